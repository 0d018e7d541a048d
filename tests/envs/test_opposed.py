"""A defence in KickOffShot and PassAndAdvance: where it starts, when it has the ball, and what changes nothing without one."""

import numpy as np
import pytest

from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import Status, make_task
from cprm_gym.simulator.state import CommandKind, PlayMode


def idle(core):
    shape = (core.worlds, len(core.agents))
    return {"type": np.zeros(shape, int), "params": np.zeros((*shape, 4))}


def started(name, worlds=1, controlled="all", **options):
    core = SoccerCore(make_task(name, **options), worlds, controlled=controlled, seed=3)
    core.reset(3)
    return core


@pytest.mark.parametrize("name", ["KickOffShot2v2", "PassAndAdvance2v1", "PassAndAdvance2v2", "PassAndAdvance2v3"])
def test_defenders_start_where_the_options_say(name):
    core = started(name, 60, nearest=8.0, farthest=-4.0)
    goalies = core.task.right_goalie
    field = core.sim.world["pos"][:, 12 + goalies : 12 + core.task.right]
    assert (field[..., 0] >= -4.0).all()
    assert (field[..., 0] <= 8.0).all()
    assert (np.abs(field[..., 1]) <= 10.0).all()
    assert field[..., 0].std() > 2.0
    if goalies:
        assert (core.sim.world["pos"][:, 12, 0] > 50.0).all()


def kicked_by_a_defender(core, player=12):
    """One cycle in which a defender who has the ball kicks it a little."""
    x, y = core.sim.world["pos"][0, player]
    core.place_ball(x - 0.6, y)
    core.place_player(player, x, y, np.pi, (0.0, 0.0))
    action = idle(core)
    k = list(core.players).index(player)
    action["type"][0, k], action["params"][0, k, 0] = CommandKind.KICK, 0.2
    return core.step(action)


def test_the_defence_has_the_ball_when_the_attack_does_not_kick_it_in_time():
    core = started("PassAndAdvance2v1", capture=5)
    step = kicked_by_a_defender(core)
    waited = 0
    while not step.terminated[0]:
        step = core.step(idle(core))
        waited += 1
    assert step.status[0] == Status.CAPTURED_BY_DEFENSE
    assert waited == 5
    assert step.success[0].tolist() == [False, False, True]


def test_a_kick_of_the_attack_takes_the_ball_back():
    core = started("PassAndAdvance2v1", capture=5)
    kicked_by_a_defender(core)
    core.place_ball(-20.0, 0.0)
    core.place_player(1, -20.6, 0.0, 0.0, (0.0, 0.0))
    action = idle(core)
    action["type"][0, 0], action["params"][0, 0, 0] = CommandKind.KICK, 0.1
    steps = [core.step(action)] + [core.step(idle(core)) for _ in range(8)]
    assert not any(step.terminated[0] for step in steps)


def test_a_touch_of_the_defence_between_two_kicks_makes_no_pass():
    def passes(between):
        core = started("PassAndAdvance2v1", capture=1000)
        for player in (1, 2):
            core.place_ball(-20.0, 0.0)
            core.place_player(player, -20.6, 0.0, 0.0, (0.0, 0.0))
            action = idle(core)
            action["type"][0, player - 1], action["params"][0, player - 1, 0] = CommandKind.KICK, 0.1
            core.step(action)
            core.place_player(player, -40.0, 20.0 * player - 30.0, 0.0, (0.0, 0.0))
            if between and player == 1:
                kicked_by_a_defender(core)
        return int(core.memory[0, 1])

    assert passes(False) == 1
    assert passes(True) == 0


def test_what_the_keeper_catches_is_captured():
    core = started("KickOffShot2v2")
    core.sim.world["mode"] = PlayMode.play_on
    core.place_player(12, 50.0, 0.0, np.pi, (0.0, 0.0))
    core.place_ball(49.5, 0.0)
    action = idle(core)
    k = list(core.players).index(12)
    action["type"][0, k] = CommandKind.CATCH
    step = core.step(action)
    assert step.status[0] == Status.CAPTURED_BY_DEFENSE
    assert not step.success[0, core.sides > 0].any()
    assert step.success[0, core.sides < 0].all()


def test_without_a_defence_its_options_change_nothing():
    cores = [started("PassAndAdvance", 20), started("PassAndAdvance", 20, capture=3, nearest=-10.0)]
    for _ in range(20):
        for core in cores:
            core.step(idle(core))
    assert (cores[0].sim.world == cores[1].sim.world).all()
