"""Kernels of directions that were told: their sines and cosines from a table, since the server tells whole degrees."""

from __future__ import annotations

import math

import numpy as np

from . import kernel

R2D = 180.0 / math.pi
STRAIGHT = 180
COSINES = np.array([math.cos(math.radians(d)) for d in range(-STRAIGHT, STRAIGHT + 1)])
SINES = np.array([math.sin(math.radians(d)) for d in range(-STRAIGHT, STRAIGHT + 1)])
WHOLE, SINGLE = 1e-9, 3e-5
"""Degrees by which an angle may be off a whole number of them: a few roundings of its sums, by which sines move by 2e-11 at most; and the
roundings of single precision."""


@kernel
def bearing(angle):
    """(cosine, sine) of an angle, rad; of whole degrees, from -180 to 180, from the table."""
    return bearing_within(angle, WHOLE)


@kernel
def bearing_within(angle, slack):
    """The same for an angle that stands for whole degrees if it is off them by less than `slack` degrees."""
    degrees = angle * R2D
    whole = np.rint(degrees)
    if abs(degrees - whole) < slack and abs(whole) <= STRAIGHT:
        row = int(whole) + STRAIGHT
        return COSINES[row], SINES[row]
    return math.cos(angle), math.sin(angle)


@kernel
def turned(cosine, sine, angle):
    """(cosine, sine) of a direction turned by an angle, rad."""
    return turned_within(cosine, sine, angle, WHOLE)


@kernel
def turned_within(cosine, sine, angle, slack):
    """The same for an angle that stands for whole degrees if it is off them by less than `slack` degrees."""
    c, s = bearing_within(angle, slack)
    return cosine * c - sine * s, sine * c + cosine * s
