"""The agents of many worlds as arrays: groups, states, and that each world is what the PettingZoo form is."""

import numpy as np
import pytest

from cprm_gym.bridges.worlds import AgentWorlds
from cprm_gym.envs import soccer_v2
from cprm_gym.errors import CommandError, ParameterError, UnknownName


def test_a_world_is_what_the_parallel_form_is():
    worlds = AgentWorlds(3, "HFO2v2", controlled="all", observation="raw")
    worlds.reset(6)
    env = soccer_v2.parallel_env(task="HFO2v2", controlled="all", observation="raw")
    env.core.sim.first_world = 2
    env.reset(6)
    rng = np.random.default_rng(0)
    for _ in range(20):
        chosen = rng.integers(0, [6, 5, 24, 5], size=(3, 4, 4))
        step = worlds.step({"left": chosen[:, :2], "right": chosen[:, 2:]})
        observed, rewards, *_ = env.step(dict(zip(env.possible_agents, chosen[2])))
        for group, agents in worlds.groups.items():
            for i, agent in enumerate(agents):
                for name, values in worlds.observation(group).items():
                    np.testing.assert_array_equal(values[2, i], observed[agent][name])
        assert list(step.reward[2]) == list(rewards.values())
    np.testing.assert_array_equal(worlds.state()[2], env.state())
    assert worlds.state_space.contains(worlds.state()[2])


def test_groups_are_the_sides_that_act():
    assert AgentWorlds(1, "Soccer5v5", controlled="all").groups.keys() == {"left", "right"}
    assert AgentWorlds(1, "HFO2v2").groups == {"left": ("left_1", "left_2")}
    assert AgentWorlds(1, "HFO2v2", controlled="right_2").groups == {"right": ("right_2",)}


def test_some_worlds_begin_anew_and_the_others_go_on():
    worlds = AgentWorlds(3, "HFO2v2", action_mode="macro", observation="hfo_high")
    worlds.reset(0)
    for _ in range(4):
        worlds.step({"left": np.zeros((3, 2), np.int64)})
    before = worlds.observation("left").copy()
    worlds.reset(None, np.array([False, True, False]))
    np.testing.assert_array_equal(worlds.observation("left")[[0, 2]], before[[0, 2]])
    assert worlds.core.cycle.tolist() == [4, 0, 4]
    assert worlds.mask("left").shape == (3, 2, len(worlds.core.macros.names))


@pytest.mark.parametrize(
    ("worlds", "options", "error", "words"),
    [
        (0, {}, ParameterError, "worlds: 0 given"),
        (True, {}, ParameterError, "worlds: True given"),
        (1, {"controlled": ()}, UnknownName, "somebody has to act"),
        (1, {"task": "HFO2v3"}, UnknownName, "Did you mean"),
    ],
)
def test_what_cannot_be_played_is_refused(worlds, options, error, words):
    with pytest.raises(error, match=words):
        AgentWorlds(worlds, **options)


def test_actions_of_every_group_are_needed():
    worlds = AgentWorlds(2, "HFO2v2", controlled="all")
    worlds.reset(0)
    with pytest.raises(CommandError, match="given for left; needed for left, right"):
        worlds.step({"left": np.zeros((2, 2, 4), np.int64)})
