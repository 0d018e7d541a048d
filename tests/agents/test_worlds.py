"""Worlds of the simulator that are copied with the agents in them: rare outcomes of behaviours by splitting."""

import numpy as np
import pytest

from cprm_gym.agents.worlds.learned import BEHAVIOURS
from cprm_gym.agents.worlds.runs import StageRuns
from cprm_gym.agents.worlds.splitting import SplitStage, split_behaviour
from cprm_gym.architecture.analysis.sampling.runs import UNFINISHED
from cprm_gym.errors import ModelError, UnknownName

PACE = 0.7
"""m / cycle that he makes about."""


def late(core, cycles):
    """When he would be there, at that pace."""
    return cycles + core.distance(0, 1) / PACE


def test_a_copy_has_the_agents_memory_and_luck_of_its_own():
    stage = SplitStage("go_to_ball", 4, UNFINISHED, late)
    stage.begin(3)
    everywhere = np.ones(4, bool)
    for _ in range(9):
        stage.advance(everywhere)
    kept = stage.keep(0)
    stage.put(1, kept, 11)
    stage.put(2, kept, 12)
    executor = stage._agents[0].controller.executor
    state = executor.snapshot()
    assert (state.row[1] == state.row[0]).all()
    assert (state.clock[2] == state.clock[0]).all()
    assert (stage.levels()[1:3] == stage.levels()[0]).all()
    world = stage.stage.core.sim.world
    assert (world["pos"][1, :2] == world["pos"][0, :2]).all()
    for _ in range(3):
        stage.advance(everywhere)
    assert (world["pos"][1, 1] != world["pos"][2, 1]).any()


def test_a_world_that_is_put_back_with_its_own_luck_goes_on_as_it_would_have():
    stage = SplitStage("go_to_ball", 2, UNFINISHED, late)
    stage.begin(5)
    everywhere = np.ones(2, bool)
    for _ in range(6):
        stage.advance(everywhere)
    kept = stage.keep(0)
    key = stage.stage.core.sim.world["key"][0].copy()
    for _ in range(8):
        stage.advance(everywhere)
    there = stage.stage.core.sim.world["pos"][0].copy()
    stage.put(0, kept, 1)
    stage.stage.core.sim.world["key"][0] = key
    for _ in range(8):
        stage.advance(everywhere)
    assert (stage.stage.core.sim.world["pos"][0] == there).all()


def test_splitting_comes_within_three_errors_of_plain_runs():
    """Not at the ball after 33 cycles: some two in a hundred."""
    limit = 33
    played = StageRuns("go_to_ball").play(range(3000), 8, False)
    rate = np.mean([run.cycles >= limit for run in played])
    assert 0.01 < rate < 0.04
    found = split_behaviour("go_to_ball", UNFINISHED, late, 100, 4, seed=1, limit=limit)
    assert found.zeros == 0.0
    assert abs(found.value - rate) <= 3 * (found.deviation**2 + rate / 3000) ** 0.5


def test_what_cannot_be_copied_is_refused():
    with pytest.raises(ModelError, match="with a model"):
        SplitStage("catch_ball", 2, "missed", late)
    with pytest.raises(UnknownName, match="at_ball"):
        SplitStage("go_to_ball", 2, "at_bal", late)
    assert "pass_and_receive" in BEHAVIOURS
