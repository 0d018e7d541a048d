"""Eyes that follow a pattern, whatever the controller would have them do."""

import numpy as np
import pytest

from cprm_gym.benchmark.demonstrations import ARMS, DEMONSTRATIONS
from cprm_gym.benchmark.demonstrations.looking import NARROW, PATTERNS, FixedLooks, Pattern
from cprm_gym.benchmark.demonstrations.plan import BEST_PATTERN
from cprm_gym.envs.actions import NECK_SCALE
from cprm_gym.envs.controller import no_action
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.simulator.state import ViewWidth


class Staring:
    """Turns the neck to the left as far as it goes, in a normal view."""

    needs = ()

    def reset(self, observation, seed, worlds=None):
        self.count = len(observation["level"])

    def act(self, observation):
        action = no_action(self.count)
        action["turn_neck"][:] = 1.0
        return action


def looks(pattern, cycles):
    """Neck in degrees and width after each cycle, of one world."""
    core = SoccerCore(make_task("Goalie"), 1, seed=1)
    observation = {key: value[:, 0] for key, value in core.reset(1).items()}
    eyes = FixedLooks(Staring(), pattern)
    eyes.reset(observation, 0)
    found = []
    for _ in range(cycles):
        action = eyes.act({key: value[:, 0] for key, value in core.observation.items()})
        core.step({key: np.asarray(value)[:, None] for key, value in action.items()})
        world = core.sim.world[0]
        found.append((round(float(np.degrees(world["neck"][0])), 3), int(world["view_width"][0])))
    return found


def test_the_neck_goes_where_the_pattern_says_and_stays_as_long():
    found = looks(Pattern((-80.0, 80.0), 2, ViewWidth.WIDE), 6)
    assert [neck for neck, _ in found] == pytest.approx([-80.0, -80.0, 80.0, 80.0, -80.0, -80.0], abs=2.0), "he feels his neck to a degree"
    assert {width for _, width in found} == {ViewWidth.WIDE}


def test_half_a_pattern_leaves_the_neck_alone_and_narrows_the_view_after_the_first_look():
    found = looks(NARROW, 4)
    assert found[0] == (90.0, ViewWidth.NORMAL)
    assert [width for _, width in found[1:]] == [ViewWidth.NARROW] * 3
    assert NECK_SCALE == 180.0


def test_the_rival_is_one_of_the_patterns():
    assert ARMS[BEST_PATTERN].looks == PATTERNS[BEST_PATTERN]
    assert all(BEST_PATTERN in DEMONSTRATIONS[name].floors for name in ("J alone", "J 2v1"))
