"""The chance that a catch takes the ball: what a goalie's hands make of a distribution.

An expected ball is in his hands or not. A believed one is in them with a probability, in this cycle and, if he waits, in the next. He has
one try in five cycles, so it is these two that decide when. Each is the integral of the ball's distribution over the rectangle that the
hands cover (specification/simulator.md 4.5). A tier of knowledge that has such a distribution tells them as the part ``hands`` of an
observation, if it is asked to.
"""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from scipy.special import ndtri

from ..body import Body, of_body
from .kernels import hands as kernels

NEAR = 4.0
"""Metres from him within which the ball has to be expected to be asked about."""
POINTS = ndtri((np.arange(32) + 0.5) / 32.0)
"""Points of a normal, each as likely, along the hands; across them all is exact."""


class Hold(IntEnum):
    """Columns of the part ``hands`` of an observation."""

    NOW = 0
    """Probability that a catch in the direction of the expected ball takes it."""
    NEXT = 1
    """The same a cycle later, if he goes on as he moves."""


LEAST = 1e-6
"""m^2 that are added to every variance where a density is asked for."""


def normal_log_density(off: np.ndarray, cov: np.ndarray) -> np.ndarray:
    """Log density of deviations (..., 2) under normals of these covariances (..., 2, 2)."""
    xx, yy, xy = cov[..., 0, 0] + LEAST, cov[..., 1, 1] + LEAST, cov[..., 0, 1]
    det = np.maximum(xx * yy - xy**2, LEAST**2)
    away = (yy * off[..., 0] ** 2 - 2.0 * xy * off[..., 0] * off[..., 1] + xx * off[..., 1] ** 2) / det
    return np.asarray(-0.5 * (away + np.log(det)) - np.log(2.0 * np.pi))


class Spread(NamedTuple):
    """The ball's place and velocity as normals: K of them in each of N worlds."""

    weights: np.ndarray
    """(N, K)"""
    means: np.ndarray
    """(N, K, 4)"""
    covs: np.ndarray
    """(N, K, 4, 4)"""

    def rolled(self, push: np.ndarray, body: Body) -> Spread:
        """A cycle later, if nobody touches it but with the own `push` (N, 2), m / cycle."""
        decay, fastest = body.server.ball_decay, body.server.ball_speed_max
        velocity = self.means[..., 2:] + push[:, None]
        velocity = velocity * np.minimum(1.0, fastest / np.maximum(np.hypot(velocity[..., 0], velocity[..., 1]), 1e-9))[..., None]
        means = np.concatenate([self.means[..., :2] + velocity, decay * velocity], axis=-1)
        move = np.eye(4)
        move[0, 2] = move[1, 3] = 1.0
        move[2, 2] = move[3, 3] = decay
        covs = move @ self.covs @ move.T
        noise = (0.6 * body.server.ball_rand * np.hypot(velocity[..., 0], velocity[..., 1])) ** 2
        for k in range(4):
            covs[..., k, k] += noise * (decay**2 if k > 1 else 1.0)
        return Spread(self.weights, means, covs)

    def log_density(self, place: np.ndarray) -> np.ndarray:
        """Log density of places (N, 2)."""
        parts = normal_log_density(np.asarray(place, np.float64)[:, None] - self.means[..., :2], self.covs[..., :2, :2])
        with np.errstate(divide="ignore"):
            return np.asarray(np.logaddexp.reduce(np.log(self.weights) + parts, axis=1))

    @property
    def middle(self) -> np.ndarray:
        """(N, 4) expected place and velocity."""
        return np.einsum("nk,nki->ni", self.weights, self.means)


@of_body
def _hands(body: Body) -> kernels.Hands:
    """What the hands of a body cover."""
    s = body.server
    return kernels.Hands(
        float(np.radians(s.min_catch_angle)), float(np.radians(s.max_catch_angle)), s.catchable_area_w / 2.0,
        s.catchable_area_l * (2.0 - body.kind.catchable_area_l_stretch), body.hands, s.catch_probability, s.ball_speed_max,
        0.6 * s.ball_rand,
    )  # fmt: skip


def holding(spread: Spread, me: np.ndarray, body: Body) -> np.ndarray:
    """How likely a catch is to take the ball.

    Parameters
    ----------
    spread : Spread
        The ball now, in the player's own picture.
    me : (N, 8) array of `SelfFeature`
        Himself now.
    body : Body

    Returns
    -------
    (N, 2) array
        `Hold`; 0 where the ball is not near.
    """
    told = np.empty((len(me), len(Hold)))
    mine = np.ascontiguousarray(me, np.float64)
    kernels.hold(*(np.ascontiguousarray(part, np.float64) for part in spread), mine, NEAR, POINTS, _hands(body), told)
    return told
