"""Percepts by kernels are those by formulas over whole arrays, in every cycle of recorded play."""

import numpy as np
import percepts_by_arrays as arrays
import pytest

from cprm_gym.agents import goalie, percepts
from cprm_gym.agents.eleven import Eleven
from cprm_gym.agents.outfielder import percepts as outfielder
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task

CYCLES = 120


@pytest.fixture(scope="module")
def observed():
    """What all players of two matches of five a side observe, one row each, in some cycles."""
    core = SoccerCore(make_task("Soccer5v5"), 2, seed=4, include=("memory",))
    observation = core.reset(4)
    teams = [Eleven(core.task, side) for side in ("left", "right")]
    half = len(core.agents) // 2
    views = [slice(0, half), slice(half, None)]
    for team, rows in zip(teams, views):
        team.reset({key: value[:, rows] for key, value in observation.items()}, 4)
    seen = []
    for cycle in range(CYCLES):
        if cycle % 3 == 0:
            seen.append({key: np.array(value).reshape(-1, *value.shape[2:]) for key, value in observation.items()})
        actions = [team.act({key: value[:, rows] for key, value in observation.items()}) for team, rows in zip(teams, views)]
        core.step({key: np.concatenate([action[key] for action in actions], axis=1) for key in actions[0]})
    return seen


def flat(found):
    """Attributes of objects as percepts."""
    return {f"{c}.{a}": values for c, of in found.items() for a, values in of.items()}


PAIRS = {
    "body": (percepts.body_percepts, arrays.body_percepts),
    "ball": (percepts.ball_percepts, arrays.ball_percepts),
    "field": (percepts.field_percepts, arrays.field_percepts),
    "motion": (
        lambda o: percepts.motion_percepts(o, percepts.field_percepts(o)),
        lambda o: arrays.motion_percepts(o, arrays.field_percepts(o)),
    ),
    "mates": (lambda o: percepts.mates_percepts(o, 4), lambda o: arrays.mates_percepts(o, 4)),
    "passer": (
        lambda o: percepts.passer_percepts(o, mates=2),
        lambda o: arrays.motion_percepts(o, arrays.field_percepts(o)) | arrays.mates_percepts(o, 2),
    ),
    "outfielder": (outfielder.outfield_percepts, arrays.outfield_percepts),
    "outfielder's others": (lambda o: flat(outfielder.outfield_attributes(o)), lambda o: flat(arrays.outfield_attributes(o))),
    "mates to choose among": (lambda o: percepts.mate_attributes(o, 4), lambda o: arrays.mate_attributes(o, 4)),
    "goalie's others": (lambda o: flat(goalie.opponent_attributes(o, 5)), lambda o: flat(arrays.opponent_attributes(o, 5))),
}


def same(found, wanted):
    assert set(found) == set(wanted)
    for name, values in wanted.items():
        apart = np.abs(found[name] - values)
        if name.endswith("_deg"):  # half a turn one way is half a turn the other way
            apart = np.minimum(apart, 360.0 - apart)
        assert apart.max() < 1e-9, name


@pytest.mark.parametrize("name", sorted(PAIRS))
def test_kernels_perceive_what_formulas_over_arrays_do(observed, name):
    kernel, by_arrays = PAIRS[name]
    for observation in observed:
        same(kernel(observation), by_arrays(observation))


@pytest.mark.parametrize("side", [1, -1])
def test_the_goalie_perceives_what_formulas_over_arrays_do(observed, side):
    for observation in observed:
        team = observation["body"][:, 13] == side
        part = {key: value[team] for key, value in observation.items()}
        same(goalie.goalie_percepts(part, 5), arrays.goalie_percepts(part, 5))


def test_a_percept_that_is_said_anew_stands_in_the_table(observed):
    found = percepts.ball_percepts(observed[0])
    found["ball.moving"] = np.full(len(found.table), 0.5)
    found["mine"] = np.ones(len(found.table))
    assert (found.table[:, found.columns.at["ball.moving"]] == 0.5).all()
    assert (found["ball.moving"] == 0.5).all()
    assert list(found)[-1] == "mine"
    assert len(found) == len(found.columns.names) + 1
    assert "mine" in found
    assert "nobody's" not in found
