"""An agent who decides alone goes ways of his own through reading, inference and beliefs: shorter ones, with the same decisions."""

import numpy as np
import pytest

from cprm_gym.agents import goalie, passer
from cprm_gym.agents.outfielder import agent as outfielder
from cprm_gym.architecture.cprm import CPRMRunner
from cprm_gym.architecture.prm.inference.engines.exact import ExactEngine
from cprm_gym.architecture.prm.inference.filter_bank import FilterBank
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ParameterError

PLAYERS = {
    "goalie": ("Goalie", "left_1", goalie.make_controller),
    "passer": ("PassAndAdvance", "left_1", passer.make_controller),
    "outfielder": ("Soccer5v5", "left_2", outfielder.make_controller),
}
CYCLES = 60


def recorded(name, worlds):
    """Observations of a player in some worlds, (worlds, ...) arrays, with the worlds that then begin anew; his decisions as one batch."""
    task, who, make = PLAYERS[name]
    core = SoccerCore(make_task(task), worlds, seed=11, include=("memory",))
    observation = core.reset(11)
    players = [make(core.task, agent) if agent == who else None for agent in core.agents]
    me = list(core.agents).index(who)
    players[me].reset({key: value[:, me] for key, value in observation.items()}, 5)
    seen, done, over = [], [], np.zeros(worlds, bool)
    for _ in range(CYCLES):
        seen.append(({key: np.array(value[:, me]) for key, value in observation.items()}, over))
        if over.any():
            players[me].reset(seen[-1][0], 5, over)
        done.append({key: np.array(value) for key, value in players[me].act(seen[-1][0]).items()})
        still = {key: np.zeros((worlds, len(core.agents), *value.shape[1:]), value.dtype) for key, value in done[-1].items()}
        for key, value in done[-1].items():
            still[key][:, me] = value
        step = core.step(still)
        over = step.terminated | step.truncated
        if over.any():
            core.reset(worlds=over)
    return core.task, seen, done


def decisions(name, task, seen, world=0, **options):
    """What a player decides in one world, and what he believes."""
    _, who, make = PLAYERS[name]
    player = make(task, who, **options)
    found, beliefs = [], []
    for k, (everything, over) in enumerate(seen):
        observation = {key: value[world : world + 1] for key, value in everything.items()}
        if k == 0 or over[world]:
            player.reset(observation, 5)
        found.append({key: np.array(value) for key, value in player.act(observation).items()})
        executor = player.controller.executor
        beliefs.append([executor.read(place)[0] for place in executor.belief_names])
    return found, np.array(beliefs)


def apart(a, b):
    return max(float(np.abs(np.asarray(x[key], float) - y[key]).max()) for x, y in zip(a, b) for key in x)


@pytest.mark.parametrize("name", sorted(PLAYERS))
def test_short_ways_lead_to_the_decisions_of_the_long_ones(monkeypatch, name):
    task, seen, _ = recorded(name, 1)
    short, believed = decisions(name, task, seen)
    monkeypatch.setattr(ExactEngine, "_program", lambda *_: None)
    monkeypatch.setattr(FilterBank, "views", lambda *_: None)
    monkeypatch.setattr("cprm_gym.architecture.cprm.sights.Sights.read", lambda *_: None)
    monkeypatch.setattr("cprm_gym.architecture.cprm.sights.Columns.gather", lambda *_: None)
    monkeypatch.setattr(FilterBank, "_goes_alone", lambda *_: False)
    long, told = decisions(name, task, seen)
    assert any((action["type"] != 0).any() for action in short)
    assert apart(short, long) < 1e-9
    np.testing.assert_allclose(believed, told, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("name", sorted(PLAYERS))
def test_a_player_decides_alone_as_among_others(name):
    task, seen, together = recorded(name, 3)
    for world in range(3):
        alone, _ = decisions(name, task, seen, world)
        among = [{key: value[world : world + 1] for key, value in action.items()} for action in together]
        assert apart(alone, among) < 1e-9


@pytest.mark.parametrize("name", ["goalie", "passer"])
def test_a_rehearsal_changes_no_decision_and_no_belief(name):
    task, seen, _ = recorded(name, 1)
    plain, believed = decisions(name, task, seen)
    rehearsed, told = decisions(name, task, seen, rehearsal=60)
    assert apart(plain, rehearsed) == 0.0
    np.testing.assert_array_equal(believed, told)


def test_after_a_rehearsal_few_structures_are_made():
    task, seen, _ = recorded("goalie", 1)
    made = {}
    for rehearsal in (0, 400):
        player = goalie.make_controller(task, "left_1", rehearsal=rehearsal)
        player.reset({key: value[:1] for key, value in seen[0][0].items()}, 5)
        compiler = player.controller.bank.settings.engine.compiler
        before = len(compiler.slice_steps)
        for observation, _ in seen:
            player.act(observation)
        made[rehearsal] = len(compiler.slice_steps) - before
        assert player.controller.bank.impossible_count.sum() == 0
    assert made[400] <= made[0] // 2, made


@pytest.mark.parametrize("rehearsal", [-1, 2.5])
def test_a_rehearsal_of_no_whole_number_of_slices_is_refused(rehearsal):
    with pytest.raises(ParameterError, match="`rehearsal` is a whole number of slices from 0, got"):
        CPRMRunner(goalie.goalie_cprm(2), rehearsal=rehearsal)
