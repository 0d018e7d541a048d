"""The chance that a catch takes the ball: what a goalie's hands make of a distribution.

An expected ball is in his hands or not. A believed one is in them with a probability, in this cycle and, if he waits, in the next. He has
one try in five cycles, so it is these two that decide when. Each is the integral of the ball's distribution over the rectangle that the
hands cover (specification/simulator.md 4.5).
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import ClassVar, NamedTuple, Protocol

import numpy as np
from scipy.special import ndtr, ndtri

from ...envs.controller import Action, Observation
from ...envs.observations import SelfFeature
from ..body import Body
from .tiers import Tier

NEAR = 4.0
"""Metres from him within which the ball has to be expected to be asked about."""
POINTS = ndtri((np.arange(32) + 0.5) / 32.0)
"""Points of a normal, each as likely, along the hands; across them all is exact."""
LEAST = 1e-6
"""m^2 that are added to every variance."""


class Hold(IntEnum):
    """Columns of the part ``hands`` of an observation."""

    NOW = 0
    """Probability that a catch in the direction of the expected ball takes it."""
    NEXT = 1
    """The same a cycle later, if he goes on as he moves."""


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

    @property
    def middle(self) -> np.ndarray:
        """(N, 4) expected place and velocity."""
        return np.einsum("nk,nki->ni", self.weights, self.means)


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
    told = np.zeros((len(me), len(Hold)))
    later = spread.rolled(np.zeros((len(me), 2)), body)
    own = np.stack([me[:, SelfFeature.X], me[:, SelfFeature.Y]], axis=1)
    way = np.stack([me[:, SelfFeature.VX], me[:, SelfFeature.VY]], axis=1)
    for column, where, ball in ((Hold.NOW, own, spread), (Hold.NEXT, own + way, later)):
        near = np.flatnonzero(np.hypot(*(ball.middle[:, :2] - where).T) < NEAR)
        if len(near):
            told[near, column] = _held(Spread(*(part[near] for part in ball)), where[near], me[near, SelfFeature.BODY], body)
    return told


def _held(ball: Spread, where: np.ndarray, facing: np.ndarray, body: Body) -> np.ndarray:
    """(n,) probability that the ball is in the rectangle that the hands cover from `where`, turned to where it is expected."""
    s = body.server
    off = ball.middle[:, :2] - where
    turned = (np.arctan2(off[:, 1], off[:, 0]) - facing + np.pi) % (2 * np.pi) - np.pi
    axis = facing + np.clip(turned, np.radians(s.min_catch_angle), np.radians(s.max_catch_angle))
    frame = np.stack([np.stack([np.cos(axis), np.sin(axis)], -1), np.stack([-np.sin(axis), np.cos(axis)], -1)], 1)
    at = np.einsum("nij,nkj->nki", frame, ball.means[..., :2] - where[:, None])
    cov = np.einsum("nij,nkjl,nml->nkim", frame, ball.covs[..., :2, :2], frame)
    along, across = cov[..., 0, 0] + LEAST, cov[..., 1, 1] + LEAST
    x = at[..., 0, None] + np.sqrt(along)[..., None] * POINTS
    y = at[..., 1, None] + (cov[..., 0, 1] / along)[..., None] * (x - at[..., 0, None])
    sd = np.sqrt(np.maximum(across - cov[..., 0, 1] ** 2 / along, LEAST))[..., None]
    half, longest = s.catchable_area_w / 2.0, body.hands
    sure = s.catchable_area_l * (2.0 - body.kind.catchable_area_l_stretch)
    certain = np.clip(1.0 - (x - sure) / max(longest - sure, 1e-9), 0.0, 1.0) if longest > sure else 1.0
    inside = np.where((x >= 0.0) & (x <= longest), certain, 0.0) * (ndtr((half - y) / sd) - ndtr((-half - y) / sd))
    return np.asarray(s.catch_probability * (ball.weights * inside.mean(axis=-1)).sum(axis=1))


class Spreading(Protocol):
    """Who has a distribution of the ball: `Tracker` and `BeliefTier`."""

    body: Body

    def spread(self) -> Spread:
        """The ball as it is now."""


class HandsTier:
    """A tier of knowledge, and beside it the part ``hands``: what `Hold` says.

    Parameters
    ----------
    inner : Tier
        What is known.
    ball : Spreading
        Which of its parts has the distribution of the ball; `inner` itself if not given.
    """

    name: ClassVar[str] = "hands"
    oracle: ClassVar[bool] = False

    def __init__(self, inner: Tier, ball: Spreading) -> None:
        self.inner, self.ball = inner, ball
        self.needs: tuple[str, ...] = getattr(inner, "needs", ("memory",))

    def reset(self, observation: Observation, worlds: np.ndarray | None = None) -> None:
        """Forget."""
        self.inner.reset(observation, worlds)

    def know(self, observation: Observation, sent: Action | None) -> Mapping[str, np.ndarray]:
        """What is known, and the part ``hands``."""
        known = dict(self.inner.know(observation, sent))
        me = np.asarray(known.get("self", observation.get("self")), np.float64)
        known["hands"] = holding(self.ball.spread(), me, self.ball.body)
        return known
