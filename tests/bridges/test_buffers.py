"""Rows of flat arrays: whose they are, what ends an episode, what is written in place."""

import numpy as np
import pytest

from cprm_gym.bridges.buffers import SoccerBuffers
from cprm_gym.bridges.worlds import AgentWorlds
from cprm_gym.errors import CommandError, CprmError, UnknownName


def test_rows_are_the_agents_of_the_worlds():
    rows = SoccerBuffers(3, "HFO2v2", controlled="all", observation="raw")
    worlds = AgentWorlds(3, "HFO2v2", controlled="all", observation="raw", flatten=True)
    rows.reset(1)
    worlds.reset(1)
    rng = np.random.default_rng(0)
    for _ in range(10):
        chosen = rng.integers(0, [6, 5, 24, 5], size=(3, 4, 4))
        observed, rewards, *_ = rows.step(chosen.reshape(12, 4))
        step = worlds.step({"left": chosen[:, :2], "right": chosen[:, 2:]})
        np.testing.assert_array_equal(observed.reshape(3, 4, -1), worlds.core.output)
        np.testing.assert_array_equal(rewards.reshape(3, 4), step.reward.astype(np.float32))
    assert rows.single_observation_space.contains(observed[0])


def test_arrays_stay_the_same_ones():
    rows = SoccerBuffers(2, "HFO2v2", action_mode="macro", observation="hfo_high")
    first = rows.reset(0)[0]
    kept = (rows.observations, rows.rewards, rows.terminals, rows.truncations, rows.action_masks)
    for _ in range(5):
        seen, *_ = rows.step(np.zeros(4, np.int64))
    assert seen is first
    assert all(a is b for a, b in zip(kept, (rows.observations, rows.rewards, rows.terminals, rows.truncations, rows.action_masks)))
    np.testing.assert_array_equal(rows.action_masks.reshape(2, 2, -1), rows.core.action_mask)


def test_an_ended_episode_is_told_once_and_begins_anew():
    rows = SoccerBuffers(4, "HFO2v2", max_cycles=7, action_mode="macro", observation="hfo_high", others="hold")
    rows.reset(0)
    told = []
    for k in range(21):
        *_, terminals, truncations, infos = rows.step(np.zeros(8, np.int64))
        assert truncations.all() == ((k + 1) % 7 == 0)
        assert not terminals.any()
        told += infos
    assert len(told) == 12
    assert told[0] == {"world": 0, "status": 4, "is_success": 0.0, "cycle": 7}
    assert rows.core.cycle.tolist() == [0] * 4


def test_bad_use_is_refused():
    with pytest.raises(UnknownName, match="allowed here are discrete, box and macro"):
        SoccerBuffers(1, action_mode="hybrid")
    with pytest.raises(UnknownName, match="leave it out"):
        SoccerBuffers(1, "HFO2v2", action_mode="macro", include="action_mask")
    rows = SoccerBuffers(2, "HFO2v2")
    with pytest.raises(CprmError, match="step before reset"):
        rows.step(np.zeros((4, 4), np.int64))
    rows.reset(0)
    with pytest.raises(CommandError, match=r"expected shape \(4, 4\)"):
        rows.step(np.zeros((2, 4), np.int64))
