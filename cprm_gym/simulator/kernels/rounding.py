"""Angles, lengths and roundings of the senses, equal to the server's formulas (specification/simulator.md 0.2, 6.1) bit by bit.

Two of them are asked for some hundred times per cycle and are therefore decided by a cheap approximation: `face_degrees` by a
polynomial, `banded_distance` by tables. Both fall back to the formula itself whenever the approximation comes near a boundary
between two results, so that speed never changes a digit.
"""

from __future__ import annotations

import math

import numpy as np

from . import kernel
from .geometry import EPS, R2D, direction, norm, quantize


@kernel
def quantised_length(length, step):
    """`length` (m) rounded on the logarithmic scale."""
    return math.exp(quantize(math.log(length + EPS), step))


@kernel
def seen_distance(distance, focus_distance, step):
    """The distance (m) told of an object `distance` away and `focus_distance` from the focus point (specification/simulator.md 6.1.4)."""
    error = (focus_distance - quantised_length(focus_distance, step)) + (distance - quantised_length(distance, step))
    return quantize(max(0.0, distance - error / 2.0), 0.1)


# ---------------------------------------------------------------------------------------------- tables of distance bands
FIRST_OCTAVE, OCTAVES = -4, 12  # tables cover 2**-4 m to 2**8 m
BINS = 128  # per octave: narrower than either step, so a bin holds at most one boundary
_SHIFT = np.int64(52 - 7)
_FIRST_BIN = np.int64((1023 + FIRST_OCTAVE) * BINS)


def _bands(step: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """For each bin the boundary inside it (infinity if none), the band below, and for each band the distance told."""
    edges = 2.0**FIRST_OCTAVE * np.array([2.0**octave * (1 + b / BINS) for octave in range(OCTAVES) for b in range(BINS)])
    upper = np.append(edges[1:], 2.0 ** (FIRST_OCTAVE + OCTAVES))
    low = np.floor(np.log(edges) / step + 0.5).astype(np.int64)
    boundary = np.exp((low + 0.5) * step)
    first, last = low[0], low[-1] + 1
    told = np.rint(np.exp(np.arange(first, last + 1) * step) / 0.1) * 0.1
    return np.where(boundary < upper, boundary, np.inf), (low - first).astype(np.int16), told


_EDGE, _BAND, _TOLD = _bands(0.1)
_EDGE_L, _BAND_L, _TOLD_L = _bands(0.01)


@kernel
def banded_distance(distance, step):
    """`seen_distance` without a focus point (``focus_distance == distance``)."""
    bin = (np.float64(distance).view(np.int64) >> _SHIFT) - _FIRST_BIN
    if 0 <= bin < OCTAVES * BINS:
        if step == 0.1:
            edge = _EDGE[bin]
            if abs(distance - edge) > 1e-6:
                return _TOLD[_BAND[bin] + (1 if distance > edge else 0)]
        elif step == 0.01:
            edge = _EDGE_L[bin]
            if abs(distance - edge) > 1e-6:
                return _TOLD_L[_BAND_L[bin] + (1 if distance > edge else 0)]
    return seen_distance(distance, distance, step)


# ---------------------------------------------------------------------------------------------- directions
# atan(x) / x as a polynomial in x**2 on [0, 1]: the interpolant at 400 Chebyshev nodes, error below 5e-7 rad (3e-5 degrees)
_A0, _A1, _A2, _A3 = 0.9999993278352409, -0.3332637452188166, 0.19879872155710365, -0.13480405607550333
_A4, _A5, _A6 = 0.08374155654526008, -0.03689862924648347, 0.007825482945601944
_MARGIN = 1e-4  # degrees around a half within which the formula decides


@kernel
def face_direction(dx, dy, body, neck):
    """Direction (rad) of (dx, dy) relative to the face, by the server's formula (specification/simulator.md 6.1.3)."""
    return norm(norm(direction(dx, dy) - body) - neck)


@kernel
def rounded_degrees(angle):
    """`angle` (rad) in whole degrees, half to even."""
    return np.rint(angle * R2D)


@kernel
def truncated_degrees(angle):
    """`angle` (rad) in whole degrees, towards zero."""
    return np.float64(int(angle * R2D))


@kernel
def told_degrees(angle, rounded):
    """`angle` (rad) in whole degrees: rounded as clients are told it from protocol 7 on, or truncated."""
    return rounded_degrees(angle) if rounded else truncated_degrees(angle)


@kernel
def rough_degrees(ahead, aside):
    """Direction (degrees) of a vector with these components along the face and a right angle from it, to 3e-5; without branches."""
    long, short = abs(ahead), abs(aside)
    steep = short > long
    long, short = (short, long) if steep else (long, short)
    x = short / long
    u = x * x
    angle = x * (_A0 + u * (_A1 + u * (_A2 + u * (_A3 + u * (_A4 + u * (_A5 + u * _A6)))))) * R2D
    angle = 90.0 - angle if steep else angle
    angle = 180.0 - angle if ahead < 0.0 else angle
    return -angle if aside < 0.0 else angle


@kernel
def is_settled(rough, degrees):
    """Whether a direction known roughly is certainly rounded to `degrees`."""
    return abs(rough - degrees) < 0.5 - _MARGIN and abs(degrees) < 180.0


@kernel
def face_degrees(dx, dy, ahead, aside, body, neck):
    """``rounded_degrees(face_direction(dx, dy, body, neck))``, decided by `rough_degrees` wherever it can be.

    `ahead` and `aside` are the components of (dx, dy) along the face and a right angle from it, exact to about 1e-12 of the length.
    """
    if max(abs(ahead), abs(aside)) > 1e-6:
        rough = rough_degrees(ahead, aside)
        degrees = np.rint(rough)
        if is_settled(rough, degrees):
            return degrees
    return rounded_degrees(face_direction(dx, dy, body, neck))
