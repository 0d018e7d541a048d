"""Random draws that depend on what they are for, never on what was drawn before.

A draw is a hash of (key of the stream, step of the world, object, purpose, index): two players never shift each other's luck,
the number of worlds or threads does not matter, and a restored snapshot draws what the original would have drawn. The hash is
two rounds of the finaliser of SplitMix64 (Steele, Lea, Flood 2014) over the counters, each multiplied by an odd constant; its
53 upper bits make the float.

Purposes (the ``b`` of every function) are constants of this file, one per place in the code that draws, so that no two places
share a number. Objects (``a``) are 0..22, or -1 for the world itself.
"""

from __future__ import annotations

import math

import numpy as np

from ..state import Stream
from . import kernel

PHYSICS = int(Stream.PHYSICS)
SENSORS = int(Stream.SENSORS)
REFEREE = int(Stream.REFEREE)
RESETS = int(Stream.RESETS)

# --- purposes, stream PHYSICS
COMMAND_ORDER = 1  # permutation of the players' commands
MOTION_NOISE = 2  # ball and players
WIND_NOISE = 3
TURN_NOISE = 4
DASH_TURN_NOISE = 5  # rotation by the legs
KICK_NOISE = 6
TACKLE_SUCCESS = 7
TACKLE_NOISE = 8
CATCH_SUCCESS = 9
COLLISION_ANGLE = 10  # two objects at exactly the same place
POST_ANGLE = 11  # an object exactly on a goal post
# --- purposes, stream SENSORS
SEE_DISTANCE = 32
SEE_UNUM = 33
SEE_TEAM = 34
SEE_VELOCITY = 35
SEE_POINTING = 36
SEE_FLAG = 37
HEAR_CHOICE = 38
SEE_FLAG_DISTANCE = 40
READING_LOST = 41  # senses worse than the server's (`envs.players.senses`)
READING_NOISE = 42
# --- purposes, stream REFEREE
FOUL_DETECTION = 64
CARD = 65
RELOCATION = 66
PENALTY_SIDE = 67
PENALTY_TAKER = 68
PENALTY_WINNER = 69
KEEPAWAY = 70
# --- purposes, stream RESETS
START = 96  # where an episode begins

_STEP = np.uint64(0x9E3779B97F4A7C15)
_OBJECT = np.uint64(0xD1B54A32D192ED03)
_PURPOSE = np.uint64(0xAEF17502108EF2D9)
_INDEX = np.uint64(0xF1357AEA2E62A9C5)
_M1 = np.uint64(0xBF58476D1CE4E5B9)
_M2 = np.uint64(0x94D049BB133111EB)
_S30, _S27, _S31, _S11 = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)
_TO_UNIT = 2.0**-53
_EPS = 1e-10


@kernel
def mix(z):
    """The finaliser of SplitMix64: a bijection of 64-bit words that scatters every bit."""
    z = (z ^ (z >> _S30)) * _M1
    z = (z ^ (z >> _S27)) * _M2
    return z ^ (z >> _S31)


@kernel
def bits(w, stream, a, b, draw):
    """64 random bits of `stream` in this step of the world, for object `a`, purpose `b`, draw number `draw`.

    The stream of resets counts calls (``w.draws``) instead of steps: how long an episode lasted does not change how the next begins.
    """
    z = w.key[stream] + np.uint64(w.draws if stream == RESETS else w.steps) * _STEP
    counter = np.uint64(a + 1) * _OBJECT + np.uint64(b) * _PURPOSE + np.uint64(draw) * _INDEX
    return mix(mix(z) ^ counter)


@kernel
def uniform(w, stream, a, b, draw):
    """A float in [0, 1) determined by (stream, step, object `a`, purpose `b`, `draw`)."""
    return np.float64(bits(w, stream, a, b, draw) >> _S11) * _TO_UNIT


@kernel
def uniform_between(w, stream, a, b, draw, low, high):
    """U(low, high) of specification/simulator.md 0.3: the limits in either order; the midpoint when they are closer than 1e-10."""
    if high < low:
        low, high = high, low
    if high - low < _EPS:
        return 0.5 * (low + high)
    return low + (high - low) * uniform(w, stream, a, b, draw)


@kernel
def bernoulli(w, stream, a, b, draw, probability):
    """True with the given probability (never for 0, always for 1)."""
    return uniform(w, stream, a, b, draw) < probability


@kernel
def decide(w, forced, stream, a, b, draw, probability):
    """The outcome `forced` (1 yes, -1 no), or `bernoulli` when it is 0: replays know the outcomes of some draws."""
    if forced != 0:
        return forced > 0
    return uniform(w, stream, a, b, draw) < probability


@kernel
def normal(w, stream, a, b, draw, mean, deviation):
    """A normal variate by Box and Muller; uses draws ``2 * draw`` and ``2 * draw + 1`` of the purpose."""
    u = 1.0 - uniform(w, stream, a, b, 2 * draw)
    v = uniform(w, stream, a, b, 2 * draw + 1)
    return mean + deviation * math.sqrt(-2.0 * math.log(u)) * math.cos(2.0 * math.pi * v)


@kernel
def polar_noise(w, stream, a, b, draw, radius):
    """(x, y) of a vector with length U(0, radius) and direction U(-pi, pi); uses draws ``2 * draw`` and ``2 * draw + 1``.

    The length is uniform, not the area (specification/simulator.md 3.2). A radius within 1e-10 of zero gives half of it, undrawn, as the
    server's generator does.
    """
    length = uniform_between(w, stream, a, b, 2 * draw, 0.0, radius)
    if length == 0.0:
        return 0.0, 0.0
    angle = uniform_between(w, stream, a, b, 2 * draw + 1, -math.pi, math.pi)
    return length * math.cos(angle), length * math.sin(angle)


@kernel
def shuffle(w, stream, a, b, order, n):
    """Put a random permutation of 0..n-1 into ``order[:n]`` (Fisher-Yates)."""
    for i in range(n):
        order[i] = i
    for i in range(n - 1, 0, -1):
        j = int(uniform(w, stream, a, b, i) * (i + 1))
        order[i], order[j] = order[j], order[i]


@kernel
def draw_uniforms(worlds, chosen, stream, out):
    """Fill ``out[k]`` with uniform draws of world ``chosen[k]``; the next call gives others.

    chosen : (n,) int64; out : (n, m) float64
    """
    for k in range(chosen.shape[0]):
        w = worlds[chosen[k]]
        for j in range(out.shape[1]):
            out[k, j] = uniform(w, stream, -1, START, j)
        w.draws += 1
