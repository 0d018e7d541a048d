"""Observation presets: sizes of the literature, truth and memory, flat vectors."""

import numpy as np
import pytest

from cprm_gym.envs import soccer_v2
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.observations import ObjectFeature
from cprm_gym.envs.presets import PRESETS, hfo_high_names, hfo_low_names, keepaway_names
from cprm_gym.envs.single import SoccerEnv
from cprm_gym.envs.tasks import make_task
from cprm_gym.envs.vector import SoccerVectorEnv
from cprm_gym.errors import UnknownName
from cprm_gym.simulator.state import COMMAND


@pytest.mark.parametrize(("mates", "opponents"), [(0, 0), (0, 1), (1, 2), (3, 5)])
def test_the_vectors_have_the_sizes_of_the_literature(mates, opponents):
    assert len(hfo_low_names(mates, opponents)) == 58 + 9 * mates + 9 * opponents + 1
    assert len(hfo_high_names(mates, opponents)) == 10 + 6 * mates + 3 * opponents + 2
    assert len(set(hfo_low_names(mates, opponents))) == len(hfo_low_names(mates, opponents))
    assert len(keepaway_names(2, 2)) == 13


@pytest.mark.parametrize("flatten", [False, True])
@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_stays_in_its_space_in_every_face(preset, flatten):
    options = {"observation": preset, "flatten": flatten}
    single = SoccerEnv("HFO2v2", action_mode="discrete", **options)
    many = SoccerVectorEnv(2, "HFO2v2", action_mode="discrete", **options)
    several = soccer_v2.parallel_env(task="HFO2v2", action_mode="discrete", **options)
    for env in (single, many):
        env.action_space.seed(1)
        assert env.observation_space.contains(env.reset(seed=1)[0])
        for _ in range(8):
            assert env.observation_space.contains(env.step(env.action_space.sample())[0])
    observations, _ = several.reset(seed=1)
    for _ in range(8):
        for agent in several.agents:
            assert several.observation_space(agent).contains(observations[agent])
        observations = several.step({a: several.action_space(a).sample() for a in several.agents})[0]


def test_full_is_the_truth_of_everybody():
    core = SoccerCore(make_task("HFO2v2"), 5, observation="full")
    o = core.reset(1)
    w = core.sim.world
    offset = w["pos"][:, 0] - w["pos"][:, 1]
    assert o["ball"][:, 0, ObjectFeature.DISTANCE] == pytest.approx(np.hypot(*offset.T), rel=1e-6)
    direction = np.arctan2(offset[:, 1], offset[:, 0]) - w["body"][:, 0] - w["neck"][:, 0]
    assert np.cos(o["ball"][:, 0, ObjectFeature.DIRECTION] - direction) == pytest.approx(1.0)
    assert (o["level"][:, 0, [0, 2, 12, 13]] == 3).all()
    assert (o["level"][:, 0, 1] == 0).all(), "one does not see oneself"
    assert (o["level"][:, 0, 3:12] == 0).all()
    assert (o["age"][:, 0] == 0).all()


def test_hfo_low_says_where_the_ball_is():
    core = SoccerCore(make_task("GoToBall"), 300, observation="hfo_low")
    core.reset(2)
    names = core.preset.names
    values = {n: core.output[:, 0, i] for i, n in enumerate(names)}
    seen = (core.observation["level"][:, 0, 0] > 0) & (values["ball_valid"] == 1)
    w = core.sim.world
    offset = w["pos"][seen, 0] - w["pos"][seen, 1]
    angle = np.arctan2(offset[:, 1], offset[:, 0]) - w["body"][seen, 0]
    assert np.abs(np.arctan2(values["ball_sin"][seen], values["ball_cos"][seen]) - (angle + np.pi) % (2 * np.pi) + np.pi).max() < 0.2
    lost = values["ball_valid"] == -1
    assert lost.any()
    for name in ("ball_sin", "ball_cos", "ball_proximity", "ball_speed"):
        assert (values[name][lost] == 0).all()


def test_keepaway_distances_are_those_of_the_players():
    core = SoccerCore(make_task("Keepaway3v2", others="hold"), 50, observation="keepaway", action_mode="macro", controlled="left_1")
    core.reset(1)
    for _ in range(40):
        core.step(np.full((50, 1), core.macros.names.index("reorient")))
    running = core.cycle > 0
    pos = core.sim.world["pos"]
    nearest = np.min([np.hypot(*(pos[:, k] - pos[:, 1]).T) for k in (2, 3)], axis=0) / np.hypot(20, 20)
    got = core.output[:, 0, core.preset.names.index("K1_K2")]
    assert np.median(np.abs(got - nearest)[running]) < 0.05


def test_what_is_said_is_heard_by_the_others():
    core = SoccerCore(make_task("Soccer", left=2, right=1), 1, include=("hear",), controlled="all")
    core.reset(1)
    still = {"type": np.zeros((1, 3), int), "params": np.zeros((1, 3, 4))}
    core.step(still)
    assert (core.observation["hear"] == 0).all()
    words = np.zeros((1, 22), COMMAND)
    words[...] = core.sim.commands
    core.sim.commands["say_length"][0, 0] = 2
    core.sim.commands["say"][0, 0, :2] = (104, 105)
    core.sim.step()
    heard = core.observe()["hear"][0]
    assert heard[1, 0, 0] == 1
    assert heard[1, 0, 1] == 2
    assert heard[1, 0, 5:7].tolist() == [104, 105]
    assert (heard[0] == 0).all()


def test_errors_name_the_presets_and_unequal_teams():
    with pytest.raises(UnknownName, match=r"unknown observation preset 'hfo'.* Known: full, hfo_high, hfo_low"):
        SoccerEnv(observation="hfo")
    with pytest.raises(UnknownName, match="teams of different sizes"):
        soccer_v2.parallel_env(left=3, right=2, observation="hfo_low")


@pytest.mark.parametrize("full_state", [True, False])
def test_at_rest_there_is_no_direction_of_motion_on_either_side(full_state):
    core = SoccerCore(make_task("Soccer", left=1, right=1, full_state=full_state), 1, observation="hfo_low", others="hold")
    core.reset(1)
    names = core.preset.names
    rest = core.output[0, :, [names.index(f"velocity_{k}") for k in ("valid", "sin", "cos")]].T
    assert (rest == [-1.0, 0.0, 0.0]).all()
    core.sim.world["vel"][0, 1], core.sim.world["vel"][0, 12] = (0.3, 0.0), (-0.3, 0.0)
    core.observe()
    moving = core.output[0, :, [names.index(f"velocity_{k}") for k in ("valid", "cos")]].T
    assert moving == pytest.approx(np.ones((2, 2)), abs=0.05), "both run forward"
