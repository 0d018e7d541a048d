"""The stated variants: tasks and senses in which who knows everything succeeds and who remembers only what he saw does not."""

import pytest

from cprm_gym.agents.knowledge.players import PLAYERS
from cprm_gym.benchmark.knowledge import SENSES, STATED, KnowledgePlan, play_block, summarise
from cprm_gym.benchmark.runner import run


def test_variants_are_of_tasks_and_senses_that_the_suite_knows():
    assert set(STATED) <= set(PLAYERS)
    assert set(STATED.values()) <= set(SENSES)


@pytest.mark.slow
@pytest.mark.parametrize("task", STATED)
def test_foresight_succeeds_where_frozen_fails(task):
    """1000 episodes each, a minute or two: ``pytest -m slow tests/benchmark/test_stated.py``."""
    plan = KnowledgePlan((task,), (STATED[task],), ("frozen", "foresight"), 1000, seed=77)
    rates = {row.tier: row.rate for row in summarise(plan, list(run(plan, play=play_block))).rows}
    assert rates["foresight"] >= 0.8
    assert rates["frozen"] <= 0.5
