"""Stamina, effort, recovery and capacity: thresholds, limits, resets."""

from __future__ import annotations

import pytest
from simulator_worlds import act, quiet_world

from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.player_types import PlayerType
from cprm_gym.simulator.state import CommandKind, PlayMode


def levels(simulator):
    """(stamina, effort, recovery, capacity) of player 1."""
    return tuple(float(simulator.world[name][0, 0]) for name in ("stamina", "effort", "recovery", "capacity"))


def given(simulator, **values):
    for name, value in values.items():
        simulator.world[name][:, 0] = value


@pytest.mark.parametrize(
    ("stamina", "effort", "recovery"),
    [(2400.0, 0.895, 0.898), (2400.1, 0.9, 0.9), (4799.9, 0.9, 0.9), (4800.0, 0.91, 0.9), (0.0, 0.895, 0.898)],
)
def test_thresholds_are_inclusive(stamina, effort, recovery):
    simulator = quiet_world()
    given(simulator, stamina=stamina, effort=0.9, recovery=0.9)
    simulator.step()
    assert levels(simulator)[:3] == pytest.approx((stamina + 45 * recovery, effort, recovery))


def test_effort_and_recovery_stop_at_their_limits():
    simulator = quiet_world()
    given(simulator, stamina=0, effort=0.602, recovery=0.501)
    simulator.step()
    assert levels(simulator)[1:3] == (0.6, 0.5)
    given(simulator, stamina=8000, effort=0.995)
    simulator.step()
    assert levels(simulator)[1:3] == (1.0, 0.5)


def test_limits_of_effort_belong_to_the_type():
    simulator = quiet_world(player_types=[PlayerType(effort_max=0.9, effort_min=0.5, kick_rand=0.0)])
    given(simulator, stamina=0, effort=0.501)
    simulator.step()
    assert levels(simulator)[1] == 0.5
    given(simulator, stamina=8000, effort=0.895)
    simulator.step()
    assert levels(simulator)[1] == 0.9


def test_capacity_is_charged_by_what_was_regained():
    simulator = quiet_world()
    simulator.step()
    assert levels(simulator) == (8000, 1, 1, 130600)
    given(simulator, stamina=7990)
    simulator.step()
    assert levels(simulator) == (8000, 1, 1, 130590)
    given(simulator, stamina=5000, capacity=20)
    simulator.step()
    assert levels(simulator) == (5020, 1, 1, 0)
    simulator.step()
    assert levels(simulator) == (5020, 1, 1, 0)


def test_a_negative_capacity_means_no_limit():
    simulator = quiet_world(parameters=ServerParameters(stamina_capacity=-1.0).without_noise())
    given(simulator, stamina=5000)
    simulator.step()
    assert levels(simulator) == (5045, 1, 1, -1)


def test_an_empty_player_still_has_his_extra_stamina():
    simulator = quiet_world(parameters=ServerParameters(stamina_capacity=0.0, player_rand=0.0, kick_rand=0.0, ball_rand=0.0))
    given(simulator, stamina=0, effort=1.0)
    act(simulator, 1, CommandKind.DASH, 50)
    assert simulator.world["pos"][0, 1, 0] == pytest.approx(0.3)
    assert levels(simulator)[0] == 0
    given(simulator, stamina=0)
    act(simulator, 1, CommandKind.DASH, 100)
    assert 0.3 < simulator.world["pos"][0, 1, 0] - 0.3 - 0.12 < 0.6


@pytest.mark.parametrize("mode", [PlayMode.before_kick_off, PlayMode.time_over, PlayMode.goal_l, PlayMode.play_on])
def test_dashes_cost_and_rest_helps_in_every_mode(mode):
    simulator = quiet_world(mode=mode)
    act(simulator, 1, CommandKind.DASH, 100)
    assert levels(simulator)[0] == 7945


def test_negative_power_costs_twice():
    simulator = quiet_world(parameters=ServerParameters(min_dash_power=-100.0).without_noise())
    act(simulator, 1, CommandKind.DASH, -50)
    assert levels(simulator)[0] == 8000 - 100 + 45
    assert simulator.world["pos"][0, 1, 0] == pytest.approx(-0.3)


def test_a_sprint_empties_and_a_rest_fills():
    simulator = quiet_world()
    for _ in range(200):
        act(simulator, 1, CommandKind.DASH, 100)
    low = levels(simulator)
    assert low[0] < 100
    assert low[1] < 1
    assert low[2] < 1
    for _ in range(400):
        simulator.step()
    high = levels(simulator)
    assert high[0] == 8000
    assert high[1] == 1
    assert high[2] <= low[2]
    assert high[3] < 130600 - 8000
