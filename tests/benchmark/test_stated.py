"""The stated variants: tasks and senses in which who knows everything succeeds and who remembers only what he saw does not."""

import pytest

from cprm_gym.agents.knowledge.players import PLAYERS, player_of
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.knowledge import SENSES, STATED
from cprm_gym.envs.tasks import make_task


def test_variants_are_of_tasks_and_senses_that_the_suite_knows():
    assert set(STATED) <= set(PLAYERS)
    assert set(STATED.values()) <= set(SENSES)


@pytest.mark.slow
@pytest.mark.parametrize("task", STATED)
def test_foresight_succeeds_where_frozen_fails(task):
    """1000 episodes each, a minute or two: ``pytest -m slow tests/benchmark/test_stated.py``."""
    senses, player = SENSES[STATED[task]], player_of(task)
    rates = {
        tier: play_episodes(make_task(task, **player.options), player.on(tier, senses), 1000, 77, senses=senses).success.mean()
        for tier in ("frozen", "foresight")
    }
    assert rates["foresight"] >= 0.8
    assert rates["frozen"] <= 0.5
