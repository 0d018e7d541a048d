"""Controllers beside the agents: what they see, their luck, every face, saved states, errors."""

import gymnasium
import numpy as np
import pytest
from cprm_baselines.random_policy import make_controller as make_random
from cprm_baselines.scripted import make_controller as make_scripted

import cprm_gym  # noqa: F401
from cprm_gym.envs import SoccerEnv, SoccerVectorEnv, soccer_v2
from cprm_gym.envs.controller import no_action
from cprm_gym.envs.core import SoccerCore
from cprm_gym.errors import ControllerError, CprmError, ParameterError, UnknownName

DASH = {"type": np.ones((3, 1), np.int64), "params": np.full((3, 1, 4), 0.4)}


class Listener:
    """Does nothing, and keeps what it was given."""

    needs = ("memory", "hear", "landmarks", "lines")

    def __init__(self):
        self.seen, self.begun = [], []

    def reset(self, observation, seed, worlds=None):
        self.begun.append((seed, worlds))
        self.seen.append({key: value.copy() for key, value in observation.items()})

    def act(self, observation):
        self.seen.append({key: value.copy() for key, value in observation.items()})
        return no_action(len(observation["level"]))


class Oracle(Listener):
    """As `cprm_gym.agents.knowledge.Informed`: somebody who wants to be connected with the worlds."""

    def connect(self, core, agent):
        self.core = core


def listeners():
    made = {}

    def make(task, agent):
        made[agent] = Listener()
        return made[agent]

    return made, make


def test_another_is_told_what_an_agent_in_his_place_is_told_and_nothing_else():
    made, make = listeners()
    played = SoccerCore("HFO2v2", 3, controlled="left", others=make)
    agents = SoccerCore("HFO2v2", 3, controlled="all", others="hold", include=Listener.needs)
    played.reset(5)
    agents.reset(5)
    for _ in range(12):
        played.step({key: np.repeat(value, 2, axis=1) for key, value in DASH.items()})
        idle = {key: np.zeros_like(value) for key, value in DASH.items()}
        agents.step({key: np.concatenate([DASH[key]] * 2 + [idle[key]] * 2, axis=1) for key in DASH})
    assert set(made) == {"right_1", "right_2"}
    for i, agent in enumerate(("right_1", "right_2")):
        played.played.controllers[i].act({key: value[:, i] for key, value in played.played.observation.items()})
        last = made[agent].seen[-1]
        assert last.keys() == agents.observation.keys()
        for key, value in last.items():
            np.testing.assert_array_equal(value, agents.observation[key][:, 2 + i], err_msg=f"{agent}: {key}")


def test_a_controller_of_the_scripted_kernels_plays_as_they_do():
    """Rounding to the float32 of observations and the actions' scales apart: after three seconds they are within centimetres."""
    cores = [SoccerCore("HFO1v1", 8, others=others) for others in ("strong", "scripted")]
    for core in cores:
        core.reset(3)
        for _ in range(30):
            core.step({"type": np.zeros((8, 1), np.int64), "params": np.zeros((8, 1, 4))})
    gap = np.abs(cores[0].sim.world["pos"][:, 12] - cores[1].sim.world["pos"][:, 12]).max(axis=1)
    assert np.median(gap) < 0.05
    assert np.abs(cores[0].sim.world["pos"][:, 12] - [51.0, 0.0]).max() > 1.0


@pytest.mark.parametrize("others", ["eased:share=60", make_random])
def test_world_k_is_the_same_alone_and_in_any_batch(others):
    batch = SoccerCore("HFO2v2", 3, controlled="left", others=others)
    batch.reset(7)
    alone = SoccerCore("HFO2v2", 1, controlled="left", others=others, first_world=2)
    alone.reset(7)
    for k in range(60):
        if k == 30:
            batch.reset(None, np.array([2]))
            alone.reset(None)
        batch.step({key: np.repeat(value, 2, axis=1) for key, value in DASH.items()})
        alone.step({key: np.repeat(value[:1], 2, axis=1) for key, value in DASH.items()})
    np.testing.assert_array_equal(batch.sim.world[2]["pos"], alone.sim.world[0]["pos"])
    assert not np.array_equal(batch.sim.world[1]["pos"], alone.sim.world[0]["pos"])


def test_players_of_one_world_have_luck_of_their_own():
    core = SoccerCore("HFO2v2", 1, controlled="left", others=make_random)
    core.reset(0)
    seeds = [c._luck.seeds for c in core.played.controllers]
    assert not np.array_equal(*seeds)


def test_equal_seeds_give_equal_games_in_every_face():
    def gym(make):
        env = make()
        env.reset(seed=4)
        env.action_space.seed(0)
        observed = [env.step(env.action_space.sample())[0] for _ in range(20)]
        return np.concatenate([np.asarray(o["players"]).ravel() for o in observed])

    for make in (
        lambda: SoccerEnv("HFO1v1", others="eased", observation="raw"),
        lambda: SoccerVectorEnv(2, "HFO1v1", others="eased", observation="raw"),
        lambda: gymnasium.make("cprm/HFO1v1-v2", others="eased", observation="raw").unwrapped,
    ):
        np.testing.assert_array_equal(gym(make), gym(make))

    def zoo():
        env = soccer_v2.parallel_env(task="HFO1v1", others="eased", observation="raw")
        env.reset(seed=4)
        return [env.step({a: np.array([1, 4, 2, 0]) for a in env.agents})[0]["left_1"]["players"] for _ in range(20)]

    def aec():
        env = soccer_v2.env(task="HFO1v1", others="eased", observation="raw")
        env.reset(seed=4)
        observed = []
        for _ in range(20):
            env.step(np.array([1, 4, 2, 0]))
            observed.append(env.last()[0]["players"])
        return observed

    np.testing.assert_array_equal(zoo(), zoo())
    np.testing.assert_array_equal(zoo(), aec())


def test_each_side_can_have_a_player_of_another_kind():
    core = SoccerCore("Goalie2v1", 2, controlled="left_1", others=("weak", "scripted"))
    assert core.scripted is None  # nobody is left to him there
    core = SoccerCore("HFO2v2", 2, controlled="left_1", others=("weak", "scripted:strength=medium"))
    assert list(core.scripted.policies) == [2]
    assert core.played.pitch.players.tolist() == [12, 13]
    core.reset(0)
    core.step({"type": np.zeros((2, 1), np.int64), "params": np.zeros((2, 1, 4))})


def test_a_saved_world_goes_on_as_it_would_have():
    core = SoccerCore("HFO2v2", 3, controlled="left", others="eased")
    core.reset(1)
    action = {key: np.repeat(value, 2, axis=1) for key, value in DASH.items()}
    for _ in range(10):
        core.step(action)
    state, branch = core.save_state(), core.branch()
    for _ in range(20):
        core.step(action)
        branch.step(action)
    end = core.sim.world["pos"].copy()
    np.testing.assert_array_equal(branch.sim.world["pos"], end)
    core.load_state(state)
    for _ in range(20):
        core.step(action)
    np.testing.assert_array_equal(core.sim.world["pos"], end)


def test_who_does_not_tell_his_state_cannot_be_saved():
    core = SoccerCore("HFO1v1", 1, others=listeners()[1])
    core.reset(0)
    with pytest.raises(CprmError, match="'make' among the others does not tell its state"):
        core.save_state()


@pytest.mark.parametrize(
    ("others", "error", "words"),
    [
        ("stronk", UnknownName, "Did you mean 'strong'"),
        ("eased:shar=3", ParameterError, "no option 'shar'"),
        ("eased:share=300", ParameterError, "whole numbers from 0 to 100"),
        (("weak", "weak", "weak"), UnknownName, "one for each side"),
        ((3, "weak"), UnknownName, "a factory of controllers"),
        (lambda task, agent: Oracle(), ParameterError, "is shown the truth"),
    ],
)
def test_bad_others_are_refused(others, error, words):
    with pytest.raises(error, match=words):
        SoccerCore("Goalie", 1, controlled="right", others=others)


def test_an_action_that_is_none_names_the_controller_and_the_player():
    class Wrong(Listener):
        def act(self, observation):
            return {**no_action(1), "type": np.array([99])}

    core = SoccerCore("HFO1v1", 1, others=lambda task, agent: Wrong())
    core.reset(0)
    with pytest.raises(ControllerError, match="right_1"):
        core.step({"type": np.zeros((1, 1), np.int64), "params": np.zeros((1, 1, 4))})


def test_make_scripted_takes_a_strength():
    with pytest.raises(UnknownName, match="medium, strong, weak"):
        make_scripted(SoccerCore("HFO1v1").task, "right_1", strength="stronger")
