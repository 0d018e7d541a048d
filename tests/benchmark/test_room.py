"""The rows measured before this suite was built come out again: Goalie on frozen readings, memory, tracker and truth, sense by sense.

``pytest -m slow tests/benchmark/test_room.py`` plays them (two minutes of CPU time). They were measured apart, over 600 episodes each,
with other code for filters and senses, so two independent figures are compared.
"""

from dataclasses import replace

import numpy as np
import pytest

from cprm_gym.agents.knowledge.players import PLAYERS
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.knowledge import SENSES
from cprm_gym.envs.controller import no_action
from cprm_gym.envs.tasks import make_task
from cprm_gym.simulator.state import ViewWidth

EPISODES, SEED = 600, 3001
ROWS = {
    "default": (80.7, 87.7, 87.3), "wide": (65.8, 82.3, 82.7), "asynchronous": (73.2, 77.8, 78.2), "no motion": (26.3, 82.8, 83.5),
    "lost .3": (63.2, 79.8, 81.3), "lost .6": (49.5, 68.0, 69.5), "lost .8": (34.3, 51.0, 48.7), "noise .5": (60.2, 60.8, 74.7),
    "noise 1": (40.7, 39.0, 53.3), "noise 2": (25.8, 23.7, 32.7), "noise .5 lost .6": (23.8, 30.3, 37.8), "quantise 2": (81.0, 85.7, 87.5),
    "gaussian .0125": (81.0, 87.5, 86.8), "gaussian .1": (75.0, 79.3, 79.2), "ball late 1": (None, 50.0, 77.8),
    "ball late 2": (None, 37.8, 74.0), "ball late 3": (None, 31.3, 69.3), "ball late 4": (None, 28.3, 63.7), "late 2": (13.0, 12.8, None),
    "late 4": (8.8, 9.3, None),
}  # fmt: skip
"""Senses -> per cent on ``frozen``, ``memory`` and ``tracker``."""
BETTER = "asynchronous"
"""Senses whose rows were of another goalie: who did not see the ball at first has learned to look to both sides at once."""
TRUE = 89.6
"""Per cent on ``state``, over 3000 episodes."""


def far(found, expected, episodes=EPISODES):
    """How many standard deviations two independent figures, per cent, lie apart."""
    p = expected / 100.0
    return abs(found - expected) / 100.0 / (p * (1.0 - p) * (1.0 / EPISODES + 1.0 / episodes)) ** 0.5


def rate(tier, senses=None, task=None, wrapped=lambda make: make):
    """Per cent on a tier, with the constants tuned on memory as in those rows, on the truth with its own."""
    player = PLAYERS["Goalie"]
    make = player.on(tier, senses, player.numbers("state" if tier == "state" else "memory"))
    return 100.0 * play_episodes(task or make_task("Goalie"), wrapped(make), EPISODES, SEED, senses=senses).success.mean()


@pytest.mark.slow
def test_the_rows_come_out_within_their_intervals():
    apart = {
        (senses, tier): far(rate(tier, SENSES[senses]), expected)
        for senses, row in ROWS.items()
        for tier, expected in zip(("frozen", "memory", "tracker"), row)
        if expected is not None and senses != BETTER
    }
    apart["default", "state"] = far(rate("state"), TRUE, 3000)
    assert max(apart.values()) < 3.3, apart
    assert np.mean([gap > 1.96 for gap in apart.values()]) <= 0.08, "of 95 % intervals one in twenty is missed"


@pytest.mark.slow
@pytest.mark.parametrize("tier", ["frozen", "memory", "tracker"])
def test_who_looks_for_the_ball_at_once_keeps_more_than_was_measured_before(tier):
    expected = dict(zip(("frozen", "memory", "tracker"), ROWS[BETTER]))[tier]
    found = rate(tier, SENSES[BETTER])
    assert found > expected
    assert far(found, expected) > 1.96


class Narrowing:
    """Looks with the normal cone first, and with the narrow one from then on."""

    def __init__(self, controller):
        self.controller, self.needs = controller, controller.needs

    def reset(self, *given):
        self.controller.reset(*given)

    def act(self, observation):
        action = {**no_action(len(observation["level"])), **self.controller.act(observation)}
        action["view"] = np.full(len(observation["level"]), int(ViewWidth.NARROW))
        return action


@pytest.mark.slow
def test_rows_of_another_definition_come_out_when_they_are_defined_so():
    """The narrow cone after a first look with the normal one, and steps of distance alone, coarser for everybody."""
    assert far(rate("memory", wrapped=lambda make: lambda task, agent: Narrowing(make(task, agent))), 88.5) < 2.6
    task = make_task("Goalie")
    coarse = replace(task, parameters=replace(task.parameters, quantize_step=0.4))
    assert far(rate("frozen", task=coarse), 82.5) < 2.6
    assert far(rate("memory", task=coarse), 86.7) < 2.6
