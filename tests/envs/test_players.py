"""What scripted players do in single situations."""

import math

import numpy as np
import pytest

from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.players.kernels import motion, team
from cprm_gym.envs.players.memory import MEMORY, Memories
from cprm_gym.envs.tasks import make_task
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import PLAYERS


def memory(own=(0.0, 0.0), ball=(0.5, 0.0), mates=(), opponents=()):
    """The memory of player 1, who has just seen everybody named here."""
    m = Memories(Simulator(1), np.ones(PLAYERS, bool)).records[0, 0]
    m["x"], m["y"] = m["px"][0], m["py"][0] = own
    m["ball_x"], m["ball_y"] = ball
    m["ball_age"], m["located"], m["age"][0] = 0, 1, 0
    for k, (x, y) in [(1 + i, p) for i, p in enumerate(mates)] + [(11 + i, p) for i, p in enumerate(opponents)]:
        m["px"][k], m["py"][k], m["age"][k] = x, y, 0
    assert m.dtype == MEMORY
    return m


@pytest.mark.parametrize("side", [0.0, 0.5 * math.pi, math.pi, -2.0])
def test_holding_brings_the_body_between_ball_and_opponent(side):
    core = SoccerCore(make_task("Keepaway3v2", full_state=True), 1, controlled="left_1", action_mode="macro", others="hold")
    core.reset(2)
    core.place_ball(0.7 * math.cos(side), 0.7 * math.sin(side))
    core.place_player(1, 0.0, 0.0, 0.0)
    core.place_player(12, 1.6 * math.cos(side), 1.6 * math.sin(side), 0.0)
    core.place_player(13, 8.0, 8.0, 0.0)
    core.observe()
    hold = np.array([[core.macros.names.index("hold")]])
    for _ in range(12):
        core.step(hold)
    own, ball, opponent = (core.sim.world["pos"][0, k] for k in (1, 0, 12))
    assert np.linalg.norm(ball - own) < 1.085, "still in his reach"
    assert np.linalg.norm(ball - opponent) > 1.6
    assert (ball - own) @ (opponent - own) < 0.0, "on the side away from the opponent"
    assert np.linalg.norm(core.sim.world["vel"][0, 0]) < 0.3, "and it rests there"


def test_the_holder_looks_every_cycle_and_the_next_macro_gives_the_normal_view_back():
    core = SoccerCore(make_task("Keepaway3v2"), 1, controlled="left_1", action_mode="macro", others="hold")
    core.reset(2)
    core.place_ball(0.7, 0.0)
    core.place_player(1, 0.0, 0.0, 0.0)
    core.observe()
    core.step(np.array([[core.macros.names.index("hold")]]))
    assert core.sim.world["view_width"][0, 0] == motion.NARROW
    core.step(np.array([[core.macros.names.index("noop")]]))
    assert core.sim.world["view_width"][0, 0] == motion.NORMAL


WALL = [(30.0, y) for y in (-24.0, -8.0, 8.0, 24.0)] + [(51.0, 0.0)]


def test_a_through_pass_goes_behind_the_defence_into_the_way_of_a_runner():
    found, x, y, speed = team.through_pass(memory((15.0, 0.0), (15.5, 0.0), [(29.5, 0.0)], WALL), 0, 11)
    assert found
    assert x > 30.0
    assert abs(y) < 8.0
    assert 0.6 < speed <= 3.0


@pytest.mark.parametrize("mate", [(36.0, 0.0), (5.0, 0.0)], ids=["offside", "far from the line"])
def test_no_through_pass_to_who_is_offside_or_far_from_the_line(mate):
    assert not team.through_pass(memory((15.0, 0.0), (15.5, 0.0), [mate], WALL), 0, 11)[0]


def test_no_through_pass_through_an_opponent():
    wall = [*WALL, (20.0, 0.0)]
    found, _, y, _ = team.through_pass(memory((15.0, 0.0), (15.5, 0.0), [(29.5, 0.0)], wall), 0, 11)
    assert not found or abs(y) > 1.0


def test_who_is_nearest_to_the_ball_has_it():
    assert team.have_ball(memory((0.0, 0.0), (0.5, 0.0), [], [(5.0, 0.0)]), 11)
    assert team.have_ball(memory((20.0, 0.0), (0.5, 0.0), [(0.0, 0.0)], [(5.0, 0.0)]), 11)
    assert not team.have_ball(memory((3.0, 0.0), (0.5, 0.0), [], [(0.0, 0.0)]), 11)
    assert not team.have_ball(memory((20.0, 0.0), (0.5, 0.0), [], []), 11)
