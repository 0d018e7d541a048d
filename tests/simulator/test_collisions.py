"""Collisions: nobody overlaps afterwards, midpoints stay, velocities bounce, the ball is fixed outside play_on."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulator_worlds import put, quiet_world

from cprm_gym.simulator.state import PlayerBit, PlayMode

MARKS = PlayerBit.BALL_TO_PLAYER | PlayerBit.BALL_COLLIDE


def test_a_ball_that_runs_into_a_player_ends_where_the_server_recorded():
    simulator = quiet_world()
    put(simulator, 0, 1, 0, -0.9, 0)
    simulator.step()
    assert simulator.world["pos"][0, 0] == pytest.approx((0.2425, 0))
    assert simulator.world["vel"][0, 0] == pytest.approx((0.0846, 0))
    assert simulator.world["pos"][0, 1] == pytest.approx((-0.1425, 0))
    assert simulator.world["bits_shown"][0, 0] & MARKS == MARKS
    assert not simulator.world["bits"][0, 0] & MARKS


@pytest.mark.parametrize("mode", [PlayMode.free_kick_l, PlayMode.kick_in_r, PlayMode.drop_ball])
def test_the_ball_stays_put_outside_play_on_but_its_velocity_bounces(mode):
    simulator = quiet_world(mode=mode)
    put(simulator, 0, 1, 0, -0.9, 0)
    simulator.step()
    assert simulator.world["pos"][0, 0] == pytest.approx((0.1, 0))
    assert simulator.world["vel"][0, 0] == pytest.approx((0.0846, 0))
    assert simulator.world["pos"][0, 1] == pytest.approx((0.1 - 0.385, 0))


def test_two_players_are_pushed_apart_around_their_midpoint_and_bounce():
    simulator = quiet_world(right=1)
    put(simulator, 1, 0, 0, 0.5, 0)
    put(simulator, 12, 0.9, 0.1, -0.3, 0)
    simulator.step()
    a, b = simulator.world["pos"][0, [1, 12]]
    assert np.hypot(*(a - b)) == pytest.approx(0.6, abs=1e-8)
    assert (a + b) / 2 == pytest.approx(((0.5 + 0.6) / 2, 0.05))
    assert simulator.world["vel"][0, [1, 12], 0] == pytest.approx((-0.02, 0.012))
    assert simulator.world["bits_shown"][0, [0, 11]].tolist() == [PlayerBit.STAND | PlayerBit.GOALIE | PlayerBit.PLAYER_COLLIDE] * 2


def test_velocities_bounce_once_however_many_rounds_are_needed():
    simulator = quiet_world(left=4)
    for number in range(1, 5):
        put(simulator, number, 0.5 * number, 0, 0.1, 0)
    simulator.step()
    assert simulator.world["vel"][0, 1:5, 0] == pytest.approx([-0.004] * 4)


def test_touching_is_not_overlapping():
    simulator = quiet_world()
    put(simulator, 0, 0.385, 0)
    simulator.step()
    assert not simulator.world["bits_shown"][0, 0] & MARKS
    assert simulator.world["pos"][0, 1].tolist() == [0, 0]


@pytest.mark.parametrize("other", [0, 12])
def test_objects_at_the_same_place_part_in_a_random_direction(other):
    simulator = quiet_world(right=1, worlds=300)
    put(simulator, 1, 5, 5)
    put(simulator, other, 5, 5)
    simulator.step()
    apart = simulator.world["pos"][:, 1] - simulator.world["pos"][:, other]
    assert np.hypot(*apart.T) == pytest.approx(np.full(300, 0.385 if other == 0 else 0.6), abs=1e-8)
    angles = np.arctan2(*apart.T)
    assert len(np.unique(angles)) == 300
    assert abs(np.exp(1j * angles).mean()) < 0.2


def test_a_fast_ball_jumps_through_a_player():
    simulator = quiet_world()
    put(simulator, 0, 1, 0, -2, 0)
    simulator.step()
    assert simulator.world["pos"][0, 0, 0] == -1
    assert simulator.world["pos"][0, 1].tolist() == [0, 0]


def test_the_caught_ball_lies_before_its_goalie_who_does_not_collide_with_it():
    simulator = quiet_world(mode=PlayMode.free_kick_l)
    simulator.world["ball_catcher"] = 1
    put(simulator, 1, -40, 3, body=90)
    put(simulator, 0, -40, 3)
    simulator.step()
    assert simulator.world["pos"][0, 0] == pytest.approx((-40, 3.385))
    assert simulator.world["pos"][0, 1].tolist() == [-40, 3]


def test_absent_players_do_not_collide():
    simulator = quiet_world(left=2)
    put(simulator, 1, 0, 0)
    put(simulator, 3, 0.1, 0)
    simulator.step()
    assert simulator.world["pos"][0, 1].tolist() == [0, 0]


@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10**6))
def test_a_few_players_never_overlap_after_a_step(seed):
    rng = np.random.default_rng(seed)
    simulator = quiet_world(left=5)
    for number in range(6):
        put(simulator, number, *rng.uniform(-1.2, 1.2, 2))
    for _ in range(12):
        simulator.step()
    places = simulator.world["pos"][0, :6]
    radius = np.array([0.085] + [0.3] * 5)
    gaps = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)) - (radius[:, None] + radius[None])
    np.fill_diagonal(gaps, 1.0)
    assert gaps.min() > -1e-6
