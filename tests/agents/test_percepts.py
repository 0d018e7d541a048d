"""Percepts of others: the way they face is perceived as it is; the mistake 'constantly away' is made on purpose and caught."""

import numpy as np
import pytest

from cprm_gym.agents.goalie import goalie_percepts
from cprm_gym.agents.percepts import mates_percepts
from cprm_gym.envs.core import SoccerCore
from cprm_gym.simulator.pitch import HALF_LENGTH

TURNS = {0.0: 0.0, 30.0: 0.0, 75.0: 1.0, -75.0: 1.0, 150.0: 2.0, 180.0: 2.0}
"""Degrees between the way somebody faces and the way to the goal, or to the player -> what is to be perceived."""


def turned(way):
    """Each of `TURNS` from a direction, radians."""
    return (way + np.radians(list(TURNS)) + np.pi) % (2.0 * np.pi) - np.pi


def told_of_an_opponent(perceive):
    """What a goalie perceives of an opponent who faces his goal, aside of it, or away from it: degrees -> index."""
    core = SoccerCore("Goalie", len(TURNS), seed=3, include=("memory",))
    core.reset(3)
    core.place_player(1, -50.0, 0.0, 0.0)
    core.place_player(12, -38.0, 2.0, turned(np.arctan2(-2.0, -HALF_LENGTH + 38.0)))
    percepts = perceive({key: value[:, 0] for key, value in core.observe(np.arange(len(TURNS))).items()}, 2)
    assert (percepts["o1.faced"] == 1).all()
    return dict(zip(TURNS, percepts["o1.facing"].tolist()))


def told_of_a_mate(perceive):
    """The same of a team-mate, who faces the player, aside of him, or away from him."""
    core = SoccerCore("PassAndAdvance", len(TURNS), seed=3, include=("memory",))
    core.reset(3)
    core.place_player(1, 0.0, 0.0, 0.0)
    core.place_player(2, 8.0, 1.0, turned(np.arctan2(-1.0, -8.0)))
    percepts = perceive({key: value[:, 0] for key, value in core.observe(np.arange(len(TURNS))).items()}, 1)
    assert (percepts["m1.faced"] == 1).all()
    return dict(zip(TURNS, percepts["m1.facing"].tolist()))


def constantly_away(perceive):
    """The mutation: whoever is seen faces away."""
    return lambda *given: {name: 2.0 + 0.0 * value if name.endswith(".facing") else value for name, value in perceive(*given).items()}


@pytest.mark.parametrize(("told", "perceive"), [(told_of_an_opponent, goalie_percepts), (told_of_a_mate, mates_percepts)])
def test_the_way_somebody_faces_is_perceived_as_it_is_and_constantly_away_is_caught(told, perceive):
    assert told(perceive) == TURNS
    assert told(constantly_away(perceive)) != TURNS
