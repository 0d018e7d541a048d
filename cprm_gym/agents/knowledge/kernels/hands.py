"""What a goalie's hands make of a distribution of the ball, world by world."""

from __future__ import annotations

import math
from typing import NamedTuple

from ....envs.observations import SelfFeature
from . import kernel

_X, _Y, _VX, _VY, _BODY = (int(SelfFeature[n]) for n in ("X", "Y", "VX", "VY", "BODY"))
LEAST = 1e-6
"""m^2 that are added to every variance."""
TURN = 2.0 * math.pi


class Hands(NamedTuple):
    """Of a body: what its hands cover, and how a ball rolls."""

    lowest: float
    """Radians from the body to which they turn at least, and at most."""
    highest: float
    half: float
    """Half of the width of what they cover, m."""
    sure: float
    """Metres within which a catch is not harder than `chance`; beyond them ever harder, up to `longest`."""
    longest: float
    chance: float
    """That a catch holds a ball that is there."""
    fastest: float
    """Speed of a ball at most, m / cycle."""
    luck: float
    """Standard deviation of a cycle's way of the ball, as a share of its speed."""


@kernel
def below(z):
    """Probability of a standard normal below z."""
    return 0.5 * math.erfc(-z / math.sqrt(2.0))


@kernel
def in_hands(weight, x, y, xx, xy, yy, points, hands):
    """Probability that a ball is where the hands reach: one normal in the hands' own frame, x along them.

    Along the hands the normal is taken at `points`, each as likely; across them all is exact.
    """
    along, across = xx + LEAST, yy + LEAST
    size, lean = math.sqrt(along), xy / along
    sd = math.sqrt(max(across - xy * lean, LEAST))
    found = 0.0
    for point in points:
        far = x + size * point
        if far < 0.0 or far > hands.longest:
            continue
        middle = y + lean * (far - x)
        share = below((hands.half - middle) / sd) - below((-hands.half - middle) / sd)
        if hands.longest > hands.sure:
            share *= min(1.0, max(0.0, 1.0 - (far - hands.sure) / max(hands.longest - hands.sure, 1e-9)))
        found += share
    return weight * found / len(points)


@kernel
def held(weights, means, covs, me, ahead, near, points, hands):
    """Probability that a catch takes the ball of one world, `ahead` cycles on (0 or 1).

    Parameters
    ----------
    weights, means, covs : (K,), (K, 4), (K, 4, 4) arrays
        Place and velocity of the ball, a mixture of normals.
    me : (8,) array of `SelfFeature`
    ahead : int
    near : float
        Metres within which the ball has to be expected.
    points : (P,) array
        Quantiles of a standard normal, each as likely.
    hands : Hands
    """
    own_x, own_y = me[_X] + ahead * me[_VX], me[_Y] + ahead * me[_VY]
    off_x = off_y = 0.0
    for k in range(len(weights)):
        speed = math.hypot(means[k, 2], means[k, 3])
        step = ahead * min(1.0, hands.fastest / max(speed, 1e-9))
        off_x += weights[k] * (means[k, 0] + step * means[k, 2])
        off_y += weights[k] * (means[k, 1] + step * means[k, 3])
    off_x, off_y = off_x - own_x, off_y - own_y
    if math.hypot(off_x, off_y) >= near:
        return 0.0
    turned = (math.atan2(off_y, off_x) - me[_BODY] + math.pi) % TURN - math.pi
    axis = me[_BODY] + min(max(turned, hands.lowest), hands.highest)
    c, s = math.cos(axis), math.sin(axis)
    found = 0.0
    for k in range(len(weights)):
        if weights[k] == 0.0:
            continue
        speed = math.hypot(means[k, 2], means[k, 3])
        step = ahead * min(1.0, hands.fastest / max(speed, 1e-9))
        x, y = means[k, 0] + step * means[k, 2] - own_x, means[k, 1] + step * means[k, 3] - own_y
        noise = ahead * (hands.luck * min(speed, hands.fastest)) ** 2
        q = covs[k]
        xx = q[0, 0] + ahead * (q[0, 2] + q[2, 0] + q[2, 2]) + noise
        yy = q[1, 1] + ahead * (q[1, 3] + q[3, 1] + q[3, 3]) + noise
        xy = q[0, 1] + ahead * (q[0, 3] + q[2, 1] + q[2, 3])
        found += in_hands(
            weights[k], c * x + s * y, c * y - s * x, c * c * xx + 2.0 * c * s * xy + s * s * yy,
            c * s * (yy - xx) + (c * c - s * s) * xy, s * s * xx - 2.0 * c * s * xy + c * c * yy, points, hands,
        )  # fmt: skip
    return hands.chance * found


@kernel
def hold(weights, means, covs, me, near, points, hands, out):
    """`held` now and a cycle later, of each of N worlds, into the columns of `out`."""
    for n in range(len(me)):
        for ahead in range(2):
            out[n, ahead] = held(weights[n], means[n], covs[n], me[n], ahead, near, points, hands)
