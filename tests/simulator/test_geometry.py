"""Geometry: angles, roundings, reflections, segments and circles, against independent computations."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from simulator_worlds import quiet_world

from cprm_gym.simulator.kernels import geometry
from cprm_gym.simulator.kernels.geometry import in_circle
from cprm_gym.simulator.kernels.referee.places import nearest_on_circle
from cprm_gym.simulator.kernels.step import advance_worlds, step_worlds
from cprm_gym.simulator.parameters import Rules
from cprm_gym.simulator.simulator import Simulator

angles = st.floats(-1e4, 1e4)
places = st.floats(-3, 3)


@settings(deadline=None)
@given(angles)
def test_a_normal_angle_is_the_same_direction_within_half_a_turn(angle):
    found = geometry.norm(angle)
    assert -math.pi <= found <= math.pi
    assert math.cos(found) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(found) == pytest.approx(math.sin(angle), abs=1e-9)


@pytest.mark.parametrize(("angle", "expected"), [(math.pi, math.pi), (-math.pi, -math.pi), (3 * math.pi, math.pi), (2 * math.pi, 0.0)])
def test_a_normal_angle_at_the_seam(angle, expected):
    assert geometry.norm(angle) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(
    ("value", "step", "expected"),
    [(0.25, 0.1, 0.2), (0.5, 1.0, 0.0), (1.5, 1.0, 2.0), (-2.5, 1.0, -2.0), (0.3, 0.0, 0.3), (7.3, 1e-11, 7.3)],
)
def test_rounding_is_half_to_even_on_the_step(value, step, expected):
    assert geometry.quantize(value, step) == pytest.approx(expected)


def test_the_zero_vector_has_direction_zero_and_stays_zero():
    assert geometry.direction(0.0, 0.0) == 0.0
    assert geometry.scale(0.0, 0.0, 5.0) == (0.0, 0.0)
    assert geometry.direction(-1.0, 0.0) == pytest.approx(math.pi)


@settings(deadline=None)
@given(places, places, st.floats(-4, 4))
def test_a_mirrored_vector_keeps_its_length_and_its_part_across_the_axis(x, y, axis):
    u, v = geometry.mirror_along(x, y, axis)
    c, s = math.cos(axis), math.sin(axis)
    assert u * c + v * s == pytest.approx(-(x * c + y * s), abs=1e-12)
    assert -u * s + v * c == pytest.approx(-x * s + y * c, abs=1e-12)


@settings(deadline=None, max_examples=300)
@given(places, places, places, places, st.floats(0.1, 1.0))
def test_a_segment_enters_a_circle_at_the_first_point_of_its_way(bx, by, ex, ey, radius):
    found, x, y = geometry.segment_enters_circle(bx, by, ex, ey, 0.0, 0.0, radius)
    share = np.linspace(0, 1, 4001)
    path = np.hypot(bx + share * (ex - bx), by + share * (ey - by)) - radius
    crosses = np.flatnonzero(np.diff(np.sign(path)))
    clear = np.abs(path).min() > 1e-3
    if clear:
        assert found == bool(len(crosses))
    if found and len(crosses) and clear:
        first = share[crosses[0]]
        assert (x, y) == pytest.approx((bx + first * (ex - bx), by + first * (ey - by)), abs=5e-3)
    if found:
        assert math.hypot(x, y) == pytest.approx(radius, abs=1e-6)


@pytest.mark.parametrize(
    ("side", "x", "y", "inside"),
    [
        (1, -36, 0, True),
        (1, -35.9, 0, False),
        (1, -52.5, -20.16, True),
        (1, 40, 0, False),
        (0, 40, 20.2, True),
        (0, 40, 20.3, False),
        (-1, 52.58, 0, True),
        (-1, 52.6, 0, False),
        (0, 0, 0, False),
    ],
)
def test_penalty_areas_include_the_balls_radius(side, x, y, inside):
    simulator = quiet_world()
    assert geometry.in_penalty_area.py_func(type("P", (), {"ball_size": simulator.packed["ball_size"][0]}), side, x, y) == inside


def test_a_point_on_the_very_edge_is_in_the_circle_by_its_distance():
    """Its square may be greater than that of the radius: 23 of 100 points that the referee puts on the edge are such."""
    square_says_no = 0
    for angle in np.linspace(0.0, 6.28, 2000):
        x, y = nearest_on_circle(20.0 * math.cos(angle), 20.0 * math.sin(angle), 0.0, 0.0, 8.85)
        assert in_circle(x, y, 0.0, 0.0, 8.85) == (math.sqrt(x * x + y * y) <= 8.85)
        square_says_no += in_circle(x, y, 0.0, 0.0, 8.85) and x * x + y * y > 8.85 * 8.85
    assert square_says_no > 200


def test_the_step_is_compiled_once_for_every_number_of_worlds():
    """Once with the referee and once without him, whatever has been played in this process before."""
    for worlds in (1, 3):
        for rules in (Rules.NONE, Rules.ALL):
            simulator = Simulator(worlds=worlds, rules=rules)
            simulator.step()
            simulator.advance()
    assert len(step_worlds.entry.signatures) == 2
    assert len(advance_worlds.entry.signatures) == 2
