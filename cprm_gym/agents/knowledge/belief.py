"""The belief: self, ball, mates and opponents from raw senses, in relational models of real numbers.

Nothing of the environment's dead reckoning is read: the own pose comes from landmarks and lines (`scene.pose`), the others from what the
eye tells of them, with or without numbers (`scene.others`), the ball from `ball`.

A player acts on where the ball is from *him*, and errs about his own place. So the ball is told in his own picture: moved by as much as he
is expected to be elsewhere, until he sees again where he is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import numpy as np

from ...architecture.prm.grounding.grounding import Grounding
from ...architecture.prm.inference.engines.mixture import MixtureEngine
from ...architecture.prm.inference.filter import Filter
from ...architecture.prm.inference.posterior import Posterior
from ...architecture.prm.model.model import Model
from ...envs.controller import Action, Observation
from ...envs.observations import BodyFeature, SelfFeature
from ...envs.players.senses import Senses
from ...errors import ModelError
from ...simulator.state import CommandKind
from ..body import DEFAULT, Body
from ..percepts import NEVER
from .ball import SELF, BallConstants, ball_model, ball_readings, misplaced
from .hands import Spread
from .scene.constants import PlayerConstants, PoseConstants
from .scene.others import PlayersFilter, players_model
from .scene.pose import PoseFilter, pose_model
from .tracker import Tracker, TrackerConstants

COMPONENTS, MERGE = 6, 0.01
"""Modes that are kept of the ball of one agent, and the loss (nats) below which two are merged."""
RECKONED = 0.1**2, np.radians(0.44) ** 2
"""Variances of a place (m^2) and a face (rad^2) that are dead reckoning's."""
PLACED = replace(BallConstants(), placed=0.03, turned=0.1)
"""The ball's constants where the own pose is as good as the model's, not as dead reckoning's."""


def _without(action: Action, worlds: np.ndarray) -> Action:
    """An action that does nothing in some worlds."""
    neck = np.where(worlds[:, None], 0.0, action["turn_neck"])
    return {**action, "type": np.where(worlds, CommandKind.NONE, action["type"]), "turn_neck": neck}


MOTION = ("ball.x", "ball.y", "ball.vx", "ball.vy")


def spread_of(posterior: Posterior) -> Spread | None:
    """The ball's place and velocity; None before the first look, when they do not hang together."""
    try:
        return Spread(*posterior.components(*MOTION))
    except ModelError:
        return None


def expected(posterior: Posterior, ball: Spread | None) -> np.ndarray:
    """(N, 4) expected place and velocity of the ball, which may be known to be spread so."""
    return np.stack([posterior.read(name) for name in MOTION], axis=1) if ball is None else ball.middle


class BeliefTier(Tracker):
    """Filters of the models for one agent in each of N worlds.

    An observation without landmarks, as of recordings, has to have the part ``self``, which is then believed.

    Parameters
    ----------
    senses : Senses
        What is known of the noise.
    body : Body
        His own.
    constants : BallConstants, optional
        `PLACED` if not given.
    tracker : TrackerConstants, optional
        For who can have played the ball.
    pose : PoseConstants, optional
    others : PlayerConstants, optional
    hands : bool
        As for `Tracker`.

    Attributes
    ----------
    pose : PoseFilter
    others : PlayersFilter
    """

    name: ClassVar[str] = "belief"
    oracle: ClassVar[bool] = False
    needs: ClassVar[tuple[str, ...]] = ("landmarks", "lines")

    def __init__(
        self,
        senses: Senses | None = None,
        body: Body = DEFAULT,
        constants: BallConstants | None = None,
        tracker: TrackerConstants | None = None,
        pose: PoseConstants | None = None,
        others: PlayerConstants | None = None,
        *,
        hands: bool = False,
    ) -> None:
        super().__init__(senses, body, tracker, hands=hands)
        self.ball = constants or PLACED
        self.pose, self.others = PoseFilter(self.senses, body, pose), PlayersFilter(self.senses, body, others)
        self._grounding = Grounding(ball_model(body, self.senses, self.ball), {"ball": "Ball"})
        self._engine = MixtureEngine(COMPONENTS, merge=MERGE)
        self._filter: Filter | None = None
        self._ball_age, self._moved = np.zeros(0), np.zeros((0, 2))
        self._done: list[Action] = []
        self._kicks: list[tuple[Action, np.ndarray] | None] = []  # the newest first: what was sent, and where he was
        self._begun = np.zeros(0, bool)
        self._ball: Spread | None = None
        self._past: list[tuple[np.ndarray, np.ndarray]] = []
        self.posterior: Posterior | None = None
        """What is believed of the ball as it was when it was seen."""

    def reset(self, observation: Observation, worlds: np.ndarray | None = None) -> None:
        """Forget."""
        count = len(observation["level"])
        if worlds is not None and len(self._cycles) != count:
            worlds = None
        if worlds is None or self._filter is None or self._filter.batch != count:
            self._filter = Filter(self._grounding, count, self._engine, on_impossible="restart")
        else:
            self._filter.reset(worlds)
        if worlds is None:
            self._begun = np.ones(count, bool)
            self._ball_age, self._moved = np.full(count, NEVER), np.zeros((count, 2))
            self._done, self._past, self._kicks = [], [], []
        else:
            self._ball_age[worlds], self._moved[worlds] = NEVER, 0.0
        self._begun[slice(None) if worlds is None else worlds] = True
        self.pose.reset(count, worlds)
        self.others.reset(count, worlds)
        super().reset({"self": np.zeros((count, len(SelfFeature))), "level": observation["level"]}, worlds)

    def know(self, observation: Observation, sent: Action | None) -> Mapping[str, np.ndarray]:
        """What is expected, carried on to now."""
        begun = self._begun
        self._cycles = np.where(begun, 0, self._cycles + 1)
        if sent is not None:
            kicking = (np.asarray(sent["type"]) == CommandKind.KICK).any()
            self._pushes = [self._own_kick(sent, *self._last) if kicking else np.zeros((len(self._cycles), 2)), *self._pushes[:-1]]
            self._kicks = [(sent, self._last[0]) if kicking else None, *self._kicks[: self._late]]
        else:
            self._cycles[:] = 0
        me = self._locate(observation, sent)
        late, others = self._late - self._everything, self._late_others - self._everything
        unsure = np.stack([0.5 * (self.pose.cov[:, 1, 1] + self.pose.cov[:, 2, 2]), self.pose.cov[:, 0, 0]], axis=1)
        if "landmarks" not in observation:
            unsure[:] = RECKONED
        for was, doubt in self._past:
            was[begun], doubt[begun] = me[begun], unsure[begun]
        self._past = [(me, unsure), *self._past[: max(late, others) + 1]]
        self._meet(observation, others)
        self._kicked_again(self._late, self._mean)
        self._take(observation, self._past[min(late, len(self._past) - 1)][0])
        ball = self._mean.copy()
        for k in range(self._late, 0, -1):  # the first news are told until others come
            self._kicked_again(k - 1, ball)
            ball = np.where((self._cycles >= k)[:, None], self._rolled(ball, self._pushes[k - 1]), ball)
        now = self._himself(observation, me)
        self._last = now, ball
        self._begun = np.zeros(len(me), bool)
        own = np.asarray(observation["body"])[:, BodyFeature.UNUM].astype(np.int64)
        memory, age = np.zeros((len(me), 23, 4)), np.full((len(me), 23), NEVER)
        memory[:, 0] = np.where(self._seen[:, None], ball, 0.0)
        memory[:, 1:, :2] = self.others.places(self._late_others)[..., :2]
        news = np.minimum(self._cycles, self._late_others)[:, None]
        age[:, 0] = np.where(self._seen, self._ball_age + np.minimum(self._cycles, self._late), NEVER)
        age[:, 1:] = np.where(self.others.known, self.others.tracks.age + news, NEVER)
        self.ball_age = np.minimum(age[:, 0], NEVER)
        rows = np.arange(len(me))
        memory[rows, own, :2], age[rows, own] = now[:, :2], 0.0
        told = {
            "self": now.astype(np.float32), "memory": memory.astype(np.float32), "memory_age": np.minimum(age, NEVER).astype(np.float32),
        }  # fmt: skip
        return {**told, "hands": self._hold(ball, now)} if self.hands else told

    @property
    def models(self) -> tuple[Model, ...]:
        """Of himself, of the others and of the ball."""
        return pose_model(), players_model(self.body, self.others.constants), self._grounding.model

    @property
    def velocities(self) -> np.ndarray:
        """(N, 22, 2) of the other players, as metres that they are expected to run in the next cycle, which is what the tracker's are."""
        here, there = (self.others.places(ahead)[..., :2] for ahead in (self._late_others, self._late_others + 1))
        return there - here

    def spread(self) -> Spread:
        """The ball as it is now in his own picture, each mode by itself."""
        if self._ball is None:
            return super().spread()
        weights, means, covs = self._ball
        means = means.copy()
        means[..., :2] += self._moved[:, None]
        return self._carried_on(Spread(weights * self._seen[:, None], means, covs))

    def log_density(self, place: np.ndarray) -> np.ndarray:
        """As the tracker's, of all modes together."""
        assert self.posterior is not None
        return Spread(*self.posterior.components("ball.x", "ball.y")).log_density(place)

    # ------------------------------------------------------------------ the parts

    def _locate(self, observation: Observation, sent: Action | None) -> np.ndarray:
        """Where he was when he was told what he is told, (N, 8)."""
        if "landmarks" not in observation:
            return np.array(observation["self"], np.float64)
        # the newest first; what a world did before its episode began is not its own
        if sent is not None:
            done = [sent, *self._done][: self._everything + 1]
            if self._begun.any():
                done = [_without(action, self._begun) for action in done]
            self._done = done
            self._sent = self._done[: self._everything]
        before = self._done[self._everything] if len(self._done) > self._everything else None
        young = (self._cycles > 0) & (self._cycles <= self._everything)
        return self.pose.step(observation, before, young if self._everything else None)

    def _meet(self, observation: Observation, back: int) -> None:
        """Mates and opponents, as they were seen `back` cycles before the rest."""
        me, unsure = self._past[min(back, len(self._past) - 1)]
        before = self.pose.late > 0.5
        if before.any():
            me = np.where(before[:, None], self._past[min(back + 1, len(self._past) - 1)][0], me)
        young = (self._cycles > 0) & (self._cycles <= self._late_others)
        self.others.step(observation, me, unsure, before, young)

    def _kicked_again(self, back: int, ball: np.ndarray) -> None:
        """What the own kick of so many cycles ago did, where the ball was then as it is known now: in reach or not."""
        kick = self._kicks[back] if self._late and back < len(self._kicks) else None
        if kick is not None:
            again = self._own_kick(*kick, ball)
            self._pushes[back] = np.where((self._cycles > back)[:, None], again, self._pushes[back])

    def _take(self, observation: Observation, me: np.ndarray) -> None:
        """The ball as it was seen from `me`."""
        assert self._filter is not None
        readings, seen = ball_readings(observation, me, self.senses, self.body.server.quantize_step, self._expected(me))
        readings |= self._given(me)
        young = (self._cycles > 0) & (self._cycles <= self._late)
        if young.any():
            self._filter.reset(young)
        self.posterior = posterior = self._filter.step(readings)
        self._seen |= seen
        self._ball_age = np.where(seen, 0.0, np.where(young, self._ball_age, self._ball_age + 1.0))
        self._ball = spread_of(posterior)
        self._mean = expected(posterior, self._ball)
        if self._late == self._everything:  # late news of the ball are of another look than that from which he now knows his place
            looked = np.asarray(observation["body"])[:, BodyFeature.FRESH] > 0
            away = self._mean[:, :2] - me[:, [SelfFeature.X, SelfFeature.Y]]
            self._moved = np.where((seen | looked)[:, None], misplaced(readings, away, self.senses, self.ball), self._moved)
            self._mean[:, :2] += self._moved

    def _expected(self, me: np.ndarray) -> np.ndarray:
        """(N,) how far the ball is expected to be, before it is looked at; NaN where nothing is known."""
        rolled = self._rolled(self._mean, self._pushes[self._late])
        away = np.hypot(rolled[:, 0] - me[:, SelfFeature.X], rolled[:, 1] - me[:, SelfFeature.Y])
        return np.where(self._seen & (self._cycles > self._late), away, np.nan)

    def _given(self, me: np.ndarray) -> dict[str, np.ndarray]:
        """What he knows of himself, now and a cycle before, his kick, and whether somebody can have played the ball."""
        push = self._pushes[self._late]
        tracks = self.others.tracks
        who = self.others.known & (tracks.age <= self.constants.recent)
        places = self.others.places(max(0, self._late_others - self._late))
        gap = np.hypot(*(places[:, :, k] - self._mean[:, None, k] for k in (0, 1)))
        played = (who & (gap < self.body.reach + self.constants.near)).any(axis=1)
        told: dict[str, np.ndarray] = {"ball.push_x": push[:, 0], "ball.push_y": push[:, 1], "ball.played": np.asarray(played, np.int64)}
        told["ball.rolling"] = np.where(self._seen, np.hypot(self._mean[:, 2], self._mean[:, 3]), 0.0)
        before = self._before if self.senses.asynchronous and len(self._before) == len(me) else me
        before = np.where((self._cycles == 0)[:, None], me, before)
        for whose, values in (("me", me), ("was", before))[: 1 + self.senses.asynchronous]:
            for name, column in zip(SELF, (SelfFeature.X, SelfFeature.Y, SelfFeature.VX, SelfFeature.VY)):
                told[f"ball.{whose}_{name}"] = values[:, column].astype(np.float64)
        self._before = me.copy()
        return told

    _before: np.ndarray = np.zeros((0, len(SelfFeature)))
