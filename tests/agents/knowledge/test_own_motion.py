"""Himself by his own commands: as the simulator moves him, and so known where news of himself are late."""

from dataclasses import replace

import numpy as np
import pytest

from cprm_gym.agents.body import Body
from cprm_gym.agents.knowledge import make_tier
from cprm_gym.agents.knowledge.own_motion import carried_on
from cprm_gym.agents.knowledge.players import PLAYERS
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.envs.controller import no_action
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.observations import SelfFeature
from cprm_gym.envs.players.senses import Senses
from cprm_gym.envs.tasks import make_task
from cprm_gym.simulator.state import CommandKind

WORLDS, CYCLES = 30, 40
KINDS = np.array([CommandKind.NONE, CommandKind.DASH, CommandKind.DASH, CommandKind.TURN])


def of_agent(core):
    return {key: value[:, 0].copy() for key, value in core.observation.items()}


def played(task, draws, senses=None, tackles=0.0):
    """Random commands in worlds of a task: each cycle's core, and what is sent in it."""
    core = SoccerCore(task, WORLDS, seed=4, include=("memory",), senses=senses or Senses())
    core.reset(4)
    sent = None
    for _ in range(CYCLES):
        yield core, sent
        sent = no_action(WORLDS)
        kinds = np.where(draws.random(WORLDS) < tackles, CommandKind.TACKLE, draws.choice(KINDS, WORLDS))
        sent["type"][:] = kinds
        sent["params"][:, 0] = draws.uniform(-1.0, 1.0, WORLDS)
        sent["params"][:, 1] = np.where(kinds == CommandKind.DASH, np.round(draws.uniform(-180, 180, WORLDS)) / 180.0, 0.0)
        sent["turn_neck"][:, 0] = draws.uniform(-0.3, 0.3, WORLDS)
        core.step({key: value[:, None] for key, value in sent.items()})


def apart(one, other):
    """Metres, and degrees of body and face, between two beliefs about himself."""
    turned = (one[:, [SelfFeature.BODY, SelfFeature.FACE]] - other[:, [SelfFeature.BODY, SelfFeature.FACE]] + np.pi) % (2 * np.pi) - np.pi
    return np.hypot(*(one - other)[:, :2].T), np.degrees(np.abs(turned).max(axis=1))


def test_without_noise_he_is_where_the_simulator_moves_him():
    task = make_task("GoToBall")
    task = replace(task, parameters=replace(task.parameters, player_rand=0.0))
    expected, locked, before = None, np.zeros(WORLDS), 0.0
    for core, sent in played(task, np.random.default_rng(1), tackles=0.02):
        true = core.truth("left_1")["self"].astype(np.float64)
        if sent is not None:
            effort = core.sim.world["effort"][:, 0]
            expected, locked = carried_on(before, sent, Body.of(task), effort, locked)
            assert expected[:, :6] == pytest.approx(true[:, :6], abs=2e-3)
            assert (expected[:, SelfFeature.FREE] == true[:, SelfFeature.FREE]).all()
        before = true
    assert (locked > 0).any(), "somebody lies on the ground"


def test_what_is_told_of_himself_late_is_carried_on():
    senses, task = Senses(late=3), make_task("Goalie")
    tier, late, carried = make_tier("tracker", task, "left_1", senses), [], []
    for core, sent in played(task, np.random.default_rng(2), senses):
        observation = of_agent(core)
        if sent is None:
            tier.reset(observation)
        told, true = tier.know(observation, sent)["self"], core.truth("left_1")["self"]
        late.append(apart(observation["self"], true))
        carried.append(apart(told, true))
    late, carried = np.median(late, axis=(0, 2)), np.median(carried, axis=(0, 2))
    assert carried[0] < 0.5 * late[0]
    assert carried[1] < 0.1 * late[1]


def test_news_that_are_not_late_leave_himself_alone():
    for senses in (Senses(), Senses(late_ball=2, late_others=1)):
        tier = make_tier("tracker", make_task("Goalie"), "left_1", senses)
        for core, sent in played(make_task("Goalie"), np.random.default_rng(2), senses):
            if sent is None:
                tier.reset(of_agent(core))
            assert set(tier.know(of_agent(core), sent)) == {"memory"}


@pytest.mark.parametrize("tier", ["tracker", "belief"])
def test_the_goalie_saves_where_everything_is_told_late(tier):
    """Before himself was carried on: 16 % of 600."""
    senses, player = Senses(late=2), PLAYERS["Goalie"]
    found = play_episodes(make_task("Goalie"), player.on(tier, senses, player.constants.tuned("memory")), 150, 3001, senses=senses)
    assert found.success.mean() > 0.6
