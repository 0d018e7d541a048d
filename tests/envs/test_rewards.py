"""Rewards as arguments."""

import numpy as np
import pytest

from cprm_gym.envs import soccer_v2
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.rewards import POTENTIALS, HausknechtStone, named_terms
from cprm_gym.envs.single import SoccerEnv
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ParameterError, UnknownName


def play(core, cycles, seed=0):
    core.reset(seed)
    draws = np.random.default_rng(seed)
    for _ in range(cycles):
        kinds = draws.integers(1, 4, (core.worlds, len(core.agents)))
        params = draws.uniform(-1, 1, (core.worlds, len(core.agents), 4))
        params[..., 2:] = 0.0
        yield core.step({"type": kinds, "params": params})


def test_shaping_terms_telescope_to_potentials():
    gamma = 0.9
    core = SoccerCore(make_task("HFO2v1", max_cycles=1000), 6, reward=tuple(POTENTIALS), reward_gamma=gamma)
    core.reset(3)
    start = {name: potential(core).copy() for name, potential in POTENTIALS.items()}
    sums = dict.fromkeys(POTENTIALS, 0.0)
    alive = np.ones(6, bool)
    factor, cycles = 1.0, 25
    for step in play(core, cycles, seed=3):
        alive &= ~step.terminated
        for name in POTENTIALS:
            sums[name] = sums[name] + factor * step.terms[name]
        factor *= gamma
        assert step.reward == pytest.approx(sum(step.terms.values()))
    assert alive.any()
    for name, potential in POTENTIALS.items():
        expected = factor * potential(core) - start[name]
        assert sums[name][alive] == pytest.approx(expected[alive], abs=1e-9)


def test_after_the_end_the_potential_is_zero():
    env = SoccerEnv(action_mode="hybrid", near=5.0, far=5.1, rolling=0.0, reward="to_ball", reward_gamma=1.0)
    env.reset(seed=0)
    w = env.core.sim.world
    w["pos"][0, 1] = w["pos"][0, 0] - [1.3, 0.0]
    w["body"][0, 0] = w["body_staged"][0, 0] = 0.0
    env.core.reward.begin(env.core, np.array([0]))
    _, reward, terminated, _, info = env.step({"type": 1, "params": np.array([1, 0, 0, 0], np.float32)})
    assert terminated
    assert info["reward_to_ball"] == pytest.approx(0.13)
    assert reward == pytest.approx(1.13)


def test_weights_and_functions():
    plain, heavy = (SoccerCore(make_task("GoToBall"), 3, reward=r) for r in ({"to_ball": 1.0}, {"to_ball": 3.0}))
    for a, b in zip(play(plain, 10), play(heavy, 10)):
        assert 3.0 * a.terms["to_ball"] == pytest.approx(b.terms["to_ball"])
    named = named_terms("time", "end")(lambda pitch, outcome: {"time": -np.ones((3, 1)), "end": 10 * outcome.reward})
    counted = SoccerCore(make_task("GoToBall"), 3, reward=named)
    for step in play(counted, 5):
        assert (step.terms["time"] == -1).all()
        assert step.reward == pytest.approx(step.terms["time"] + step.terms["end"])
    env = soccer_v2.parallel_env(task="HFO2v1", reward=HausknechtStone(), action_mode="discrete")
    env.reset(seed=1)
    infos = env.step({a: np.array([1, 4, 11, 0]) for a in env.agents})[4]
    assert {key for key in infos["left_1"] if key.startswith("reward_")} == {
        "reward_move_to_ball", "reward_kickable", "reward_ball_to_goal", "reward_goal",
    }  # fmt: skip


def test_a_tasks_own_shaping_pays_the_way_won_and_nothing_for_standing_still():
    env = SoccerEnv(near=20.0, far=20.1, rolling=0.0)
    env.reset(seed=3)
    for _ in range(6):
        _, reward, _, _, info = env.step([0, 0, 0, 0])
        assert reward == info["reward_to_ball_progress"] == 0.0
    core = SoccerCore("GoToBall", 20, action_mode="discrete", reward=None)
    core.reset(1)
    pos = core.sim.world["pos"]
    first, paid, rng = np.hypot(*(pos[:, 0] - pos[:, 1]).T), np.zeros(20), np.random.default_rng(0)
    for _ in range(50):
        paid += core.step(rng.integers(0, [6, 5, 24, 5], (20, 1, 4))).terms["to_ball_progress"][:, 0]
    assert paid == pytest.approx(0.025 * (first - np.hypot(*(pos[:, 0] - pos[:, 1]).T)))
    assert SoccerEnv(reward="sparse").core.reward.plain
    assert SoccerEnv(reward={"to_ball_progress": 2.0}).core.reward.weights == {"to_ball_progress": 2.0}
    assert SoccerEnv(reward="to_ball").core.reward.weights == {"to_ball": 1.0}
    assert SoccerCore("GoToBall").reward.plain, "controllers learn nothing"


def test_the_reward_of_the_literature_pays_the_first_touch_once():
    core = SoccerCore(make_task("HFO1v0"), 1, reward=HausknechtStone())
    core.reset(1)
    w = core.sim.world
    total = 0.0
    for _ in range(4):
        w["pos"][0, 1], w["vel"][0, :2] = w["pos"][0, 0] - [0.6, 0.0], 0.0
        total += core.step({"type": np.zeros((1, 1), int), "params": np.zeros((1, 1, 4))}).terms["kickable"][0, 0]
    assert total == 1.0


def test_errors_name_the_terms():
    with pytest.raises(
        UnknownName, match=r"unknown reward term 'to_bal'. Did you mean 'to_ball'\? Known: ball_to_goal, ball_to_goal_progress, facing"
    ):
        SoccerEnv(reward="to_bal")
    with pytest.raises(ParameterError, match="reward_gamma: 'much' given, allowed is 0 to 1"):
        SoccerEnv(reward="to_ball", reward_gamma="much")
    with pytest.raises(ParameterError, match="weight is nan"):
        SoccerEnv(reward={"to_ball": float("nan")})
    with pytest.raises(ParameterError, match="expected None, names of terms, names with weights or a function, got int"):
        SoccerEnv(reward=3)
    env = SoccerEnv(reward=lambda pitch, outcome: {"speed": outcome.reward})
    env.reset(seed=0)
    with pytest.raises(ParameterError, match="gave the terms speed, but its attribute `terms` names none; see named_terms"):
        env.step([0, 0, 0, 0])
    env = SoccerEnv(reward=lambda pitch, outcome: np.zeros(2))
    env.reset(seed=0)
    with pytest.raises(ParameterError, match=r"'function' has shape \(2,\), expected \(1, 1\)"):
        env.step([0, 0, 0, 0])


def test_standing_still_pays_nothing_as_progress_and_something_as_discounted_potential():
    terms = ("ball_to_goal", "ball_to_goal_progress", "to_ball_progress")
    env = SoccerEnv("HFO1v0", reward=terms, reward_gamma=0.99, full_state=True)
    env.reset(seed=1, options={"start": {"ball": (0.0, 0.0), "left_1": (-4.0, 0.0, 0.0)}})
    for _ in range(5):
        _, reward, _, _, info = env.step([0, 0, 0, 0])
        assert info["reward_ball_to_goal_progress"] == info["reward_to_ball_progress"] == 0.0
        assert info["reward_ball_to_goal"] == pytest.approx(0.01 * 5.25), "doing nothing pays"
        assert reward == pytest.approx(0.0525)


def test_progress_sums_to_the_way_that_was_made():
    core = SoccerCore(make_task("HFO1v0"), 4, reward="to_ball_progress")
    core.reset(2)
    start = POTENTIALS["to_ball"](core).copy()
    total = sum(step.terms["to_ball_progress"] for step in play(core, 20, seed=2))
    assert total == pytest.approx(POTENTIALS["to_ball"](core) - start)
