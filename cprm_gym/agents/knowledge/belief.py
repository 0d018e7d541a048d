"""The belief: the ball from raw senses in a relational model of real numbers, in the place of the reckoned ball.

A player acts on where the ball is from *him*, and errs about his own place. So the ball is told in his own picture: moved by as much as he
is expected to be elsewhere, until he sees again where he is.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from ...architecture.prm.grounding.grounding import Grounding
from ...architecture.prm.inference.engines.mixture import MixtureEngine
from ...architecture.prm.inference.filter import Filter
from ...architecture.prm.inference.posterior import Posterior
from ...envs.controller import Observation
from ...envs.observations import BodyFeature, SelfFeature
from ...envs.players.senses import Senses
from ..body import DEFAULT, Body
from .ball import SELF, BallConstants, ball_model, ball_readings, misplaced
from .tracker import Tracker, TrackerConstants, normal_log_density

COMPONENTS = 6
"""Modes that are kept of the ball of one agent."""


class BeliefTier(Tracker):
    """A filter of the model `ball_model` for one agent in each of N worlds; the others are followed as by the tracker.

    Parameters
    ----------
    senses : Senses
        What is known of the noise.
    body : Body
        His own.
    constants : BallConstants, optional
        Those tuned if not given.
    tracker : TrackerConstants, optional
        For the others.
    """

    name: ClassVar[str] = "belief"
    oracle: ClassVar[bool] = False

    def __init__(
        self,
        senses: Senses | None = None,
        body: Body = DEFAULT,
        constants: BallConstants | None = None,
        tracker: TrackerConstants | None = None,
    ) -> None:
        super().__init__(senses, body, tracker)
        self.ball = constants or BallConstants()
        self._grounding = Grounding(ball_model(body, self.senses, self.ball), {"ball": "Ball"})
        self._engine = MixtureEngine(COMPONENTS, merge=1e-3)
        self._filter: Filter | None = None
        self._moved = np.zeros((0, 2))
        self.posterior: Posterior | None = None
        """What is believed of the ball as it was when it was seen."""

    def reset(self, observation: Observation, worlds: np.ndarray | None = None) -> None:
        """Forget."""
        count = len(observation["level"])
        if worlds is None or self._filter is None or self._filter.batch != count:
            self._filter = Filter(self._grounding, count, self._engine, on_impossible="restart")
        else:
            self._filter.reset(worlds)
            self._moved[worlds] = 0.0
        if worlds is None or len(self._moved) != count:
            self._moved = np.zeros((count, 2))
        super().reset(observation, worlds)

    def _predict(self) -> None:
        """Nothing: the filter goes on when it is told."""

    def log_density(self, place: np.ndarray) -> np.ndarray:
        """As the tracker's, of all modes together."""
        assert self.posterior is not None
        weights, means, covs = self.posterior.components("ball.x", "ball.y")
        parts = normal_log_density(np.asarray(place, np.float64)[:, None] - means, covs)
        with np.errstate(divide="ignore"):
            return np.asarray(np.logaddexp.reduce(np.log(weights) + parts, axis=1))

    def _take(self, observation: Observation, me: np.ndarray) -> None:
        """The ball as it was seen from `me`."""
        assert self._filter is not None
        readings, seen = ball_readings(observation, me, self.senses, self.body.server.quantize_step)
        readings |= self._given(me)
        young = (self._cycles > 0) & (self._cycles <= self._late)
        if young.any():
            self._filter.reset(young)
        self.posterior = posterior = self._filter.step(readings)
        self._seen |= seen
        self._mean = np.stack([posterior.read(f"ball.{name}") for name in ("x", "y", "vx", "vy")], axis=1)
        if not self._back:  # late news of the ball are of another look than that from which he now knows his place
            looked = np.asarray(observation["body"])[:, BodyFeature.FRESH] > 0
            away = self._mean[:, :2] - me[:, [SelfFeature.X, SelfFeature.Y]]
            self._moved = np.where((seen | looked)[:, None], misplaced(readings, away, self.senses, self.ball), self._moved)
            self._mean[:, :2] += self._moved

    def _given(self, me: np.ndarray) -> dict[str, np.ndarray]:
        """What he knows of himself, now and a cycle before, his kick, and whether somebody can have played the ball."""
        columns = (SelfFeature.X, SelfFeature.Y, SelfFeature.VX, SelfFeature.VY)
        push = self._pushes[self._late]
        gap = np.hypot(*(self._others[:, :, k] - self._mean[:, None, k] for k in (0, 1)))
        played = (self._known & (gap < self.body.reach + self.constants.near)).any(axis=1)
        told: dict[str, np.ndarray] = {"ball.push_x": push[:, 0], "ball.push_y": push[:, 1], "ball.played": np.asarray(played, np.int64)}
        before = self._before if self.senses.asynchronous and len(self._before) == len(me) else me
        for who, values in (("me", me), ("was", before))[: 1 + self.senses.asynchronous]:
            for name, column in zip(SELF, columns):
                told[f"ball.{who}_{name}"] = values[:, column].astype(np.float64)
        self._before = me.copy()
        return told

    _before: np.ndarray = np.zeros((0, len(SelfFeature)))
