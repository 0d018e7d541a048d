"""The tracker: a Kalman filter for the ball and one for each other player, which know the noise of the senses.

What it is told: the readings (distance, direction, their changes) with the noise that `Senses` states, his own commands, and how late
news are; himself he carries on by what he has sent since. The ball rolls and slows down; whoever is near it may change its way, and a
reading that cannot be explained opens the filter.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...envs.actions import PARAMETER_SCALES
from ...envs.controller import Action, Observation
from ...envs.observations import BodyFeature, SelfFeature
from ...envs.players.senses import NOISE, Senses
from ...simulator.senses import BallLevel
from ...simulator.state import CommandKind
from ..body import DEFAULT, Body
from ..percepts import NEVER
from ..skills.constants import Constants, between
from .hands import NEAR, Hold, Spread, holding, normal_log_density
from .own_motion import carried_on

VELOCITY_STEP, TURN_STEP = 0.02, np.radians(0.1)
"""Steps in which the changes of distance, as a share of it, and of direction are told (specification/simulator.md 6.1.5)."""


@dataclass(frozen=True, kw_only=True)
class TrackerConstants(Constants):
    """Of the tracker: what is not the senses' noise, which it is told. Tuned by the least error about the ball (`benchmark.tracking`)."""

    whose: ClassVar[str] = "tracker"

    live: float = between(0.2, 0.02, 0.8)
    """m / cycle by which the velocity of a ball near another player may change in a cycle (standard deviation)."""
    surprise: float = between(18.0, 8.0, 60.0)
    """Squared distance of a reading from what was expected, in standard deviations, beyond which the way of the ball has been changed."""
    opened: float = between(0.7, 0.1, 2.0)
    """Metres, and m / cycle, by which it may then be elsewhere."""
    near: float = between(0.6, 0.0, 2.0)
    """Metres beyond a player's reach within which he may change it."""
    recent: float = between(6.0, 1.0, 15.0)
    """Cycles for which the others' places are good enough to say so, and to carry them on."""
    run: float = between(0.12, 0.02, 0.5)
    """m / cycle by which a player's velocity changes in a cycle."""
    tiring: float = between(0.95, 0.5, 1.0)
    """Share of it that he keeps."""
    turned: float = between(0.6, 0.1, 3.0)
    """Error of where he believes to look, degrees."""


class Tracker:
    """Filters of one agent in N worlds.

    Parameters
    ----------
    senses : Senses
        What is known of the noise.
    body : Body
        His own.
    constants : TrackerConstants, optional
        Those tuned if not given.
    hands : bool
        Whether he is told, as the part ``hands``, how likely a catch is to take the ball (`hands.holding`).
    """

    name: ClassVar[str] = "tracker"
    oracle: ClassVar[bool] = False
    ball_age: np.ndarray = np.zeros(0)
    """(N,) cycles since the ball was seen."""

    def __init__(
        self, senses: Senses | None = None, body: Body = DEFAULT, constants: TrackerConstants | None = None, *, hands: bool = False
    ) -> None:
        self.senses, self.body, self.hands = senses or Senses(), body, hands
        self.constants = TrackerConstants.tuned("Goalie") if constants is None else constants
        self._late, self._late_others, self._everything = self.senses.delays
        # of what he believes of himself when the ball was seen, counted from what he is told now
        self._back = self._late - self._everything
        self._mean = self._cov = self._others = self._spread = np.zeros(0)
        self._cycles = np.zeros(0, np.int64)
        self._selves: list[np.ndarray] = []
        self._sent: list[Action] = []
        self._last = np.zeros(0), np.zeros(0)  # himself and the ball as they were thought to be a cycle ago
        self._pushes: list[np.ndarray] = []

    def reset(self, observation: Observation, worlds: np.ndarray | None = None) -> None:
        """Forget."""
        count = len(observation["level"])
        me = np.array(observation["self"], np.float64)
        if worlds is None or len(self._mean) != count:
            self._mean, self._cov = np.zeros((count, 4)), np.zeros((count, 4, 4))
            self._seen = np.zeros(count, bool)
            self._others, self._spread = np.zeros((count, 22, 4)), np.zeros((count, 22, 3))
            self._known = np.zeros((count, 22), bool)
            self._selves = [me.copy() for _ in range(self._back + 1)]
            self._pushes = [np.zeros((count, 2)) for _ in range(self._late + 1)]
            self._sent, self._cycles = [], np.zeros(count, np.int64)
            self._last = me, self._mean
            return
        self._seen[worlds], self._known[worlds] = False, False
        self._cycles[worlds] = -1  # the others' next cycle is their first
        for past in self._selves:
            past[worlds] = me[worlds]
        for push in self._pushes:
            push[worlds] = 0.0

    def know(self, observation: Observation, sent: Action | None) -> Mapping[str, np.ndarray]:
        """The filters' expectations, carried on to now."""
        me = np.array(observation["self"], np.float64)
        if sent is not None:
            self._pushes = [self._own_kick(sent, *self._last), *self._pushes[:-1]]
            self._sent = [sent, *self._sent][: self._everything]
            self._cycles += 1
            self._predict()
        else:
            self._cycles[:] = 0
        self._selves = [me, *self._selves[:-1]] if self._back else [me]
        self._take(observation, self._selves[self._back])
        memory, age = np.array(observation["memory"]), np.array(observation["memory_age"])
        ball = self.course()[-1]
        memory[:, 0] = np.where(self._seen[:, None], ball, memory[:, 0])
        self.ball_age = age[:, 0].astype(np.float64)
        self._follow(memory, age, me, started=sent is None)
        now = self._himself(observation, me)
        self._last = now, ball
        told = {"memory": memory.astype(np.float32)}
        if self._everything:
            told["self"] = now.astype(np.float32)
        if self.hands:
            told["hands"] = self._hold(ball, now)
        return told

    def _himself(self, observation: Observation, me: np.ndarray) -> np.ndarray:
        """Himself as he is now: what he is told of himself, carried on by what he has done since."""
        if not self._sent:
            return me
        felt = np.asarray(observation["body"], np.float64)
        locked = np.maximum(felt[:, BodyFeature.TACKLE_EXPIRES], felt[:, BodyFeature.FOUL_CHARGED])
        for k in range(len(self._sent), 0, -1):
            later, after = carried_on(me, self._sent[k - 1], self.body, felt[:, BodyFeature.EFFORT], locked)
            since = self._cycles >= k
            me, locked = np.where(since[:, None], later, me), np.where(since, after, locked)
        return me

    def log_density(self, place: np.ndarray) -> np.ndarray:
        """Log density of places (N, 2) of the ball, of the time of which the last news were: how well it knows what it says."""
        return normal_log_density(np.asarray(place, np.float64) - self._mean[:, :2], self._cov[:, :2, :2])

    @property
    def late(self) -> int:
        """Cycles by which news of the ball are late."""
        return self._late

    @property
    def seen(self) -> np.ndarray:
        """(N,) who has seen the ball."""
        return self._seen

    @property
    def velocities(self) -> np.ndarray:
        """(N, 22, 2) of the other players, as they are followed."""
        return self._others[..., 2:]

    def course(self) -> list[np.ndarray]:
        """The ball as it was at the time of the news, and as it has rolled on since, a cycle each, up to now: (N, 4) arrays."""
        course = [self._mean.copy()]
        for k in range(self._late, 0, -1):  # the first news are told until others come
            course.append(np.where((self._cycles >= k)[:, None], self._rolled(course[-1], self._pushes[k - 1]), course[-1]))
        return course

    def spread(self) -> Spread:
        """The ball as it is now, as the filter has it."""
        seen = self._seen.astype(np.float64)[:, None]
        return self._carried_on(Spread(seen, self._mean[:, None].copy(), self._cov[:, None].copy()))

    def _hold(self, ball: np.ndarray, me: np.ndarray) -> np.ndarray:
        """(N, 2) how likely a catch is to take the ball, which is expected at `ball`; where it is far in all worlds nothing is asked."""
        far = NEAR + self.body.server.ball_speed_max + self.body.top_speed
        if (np.hypot(ball[:, 0] - me[:, SelfFeature.X], ball[:, 1] - me[:, SelfFeature.Y]) > far).all():
            return np.zeros((len(me), len(Hold)))
        return holding(self.spread(), me, self.body)

    def _carried_on(self, ball: Spread) -> Spread:
        """From the time of the news to now."""
        for k in range(self._late, 0, -1):
            later, since = ball.rolled(self._pushes[k - 1], self.body), self._cycles >= k
            ball = Spread(*(np.where(since.reshape(-1, *[1] * (new.ndim - 1)), new, old) for old, new in zip(ball, later)))
        return ball

    # ------------------------------------------------------------------ the ball

    def _own_kick(self, sent: Action, me: np.ndarray, ball: np.ndarray) -> np.ndarray:
        """(N, 2) acceleration of the ball by an own kick, as far as he knows where both were."""
        kicking = np.asarray(sent["type"]) == CommandKind.KICK
        dx, dy = ball[:, 0] - me[:, SelfFeature.X], ball[:, 1] - me[:, SelfFeature.Y]
        distance = np.hypot(dx, dy)
        kind, server = self.body.kind, self.body.server
        aside = np.arctan2(dy, dx) - me[:, SelfFeature.BODY]
        aside = np.abs((aside + np.pi) % (2 * np.pi) - np.pi) / np.pi
        rate = kind.kick_power_rate * np.clip(1.0 - 0.25 * aside - 0.25 * (distance - self.body.contact) / kind.kickable_margin, 0.0, 1.0)
        power, direction = (np.asarray(sent["params"])[:, k] * PARAMETER_SCALES[CommandKind.KICK, k] for k in (0, 1))
        push = np.minimum(server.ball_accel_max, rate * np.clip(power, 0.0, server.maxpower))
        push = np.where(kicking & (distance < self.body.reach), push, 0.0)
        angle = me[:, SelfFeature.BODY] + np.radians(direction)
        return np.stack([push * np.cos(angle), push * np.sin(angle)], axis=1)

    def _rolled(self, ball: np.ndarray, push: np.ndarray) -> np.ndarray:
        """The ball a cycle later."""
        velocity = ball[:, 2:] + push
        fast = np.hypot(velocity[:, 0], velocity[:, 1])
        velocity *= np.minimum(1.0, self.body.server.ball_speed_max / np.maximum(fast, 1e-9))[:, None]
        return np.concatenate([ball[:, :2] + velocity, self.body.server.ball_decay * velocity], axis=1)

    def _predict(self) -> None:
        """One cycle of the ball; none while the first news are told again."""
        kept = self._mean.copy(), self._cov.copy()
        push, decay = self._pushes[self._late], self.body.server.ball_decay
        self._mean = self._rolled(self._mean, push)
        move = np.eye(4)
        move[0, 2] = move[1, 3] = 1.0
        move[2, 2] = move[3, 3] = decay
        self._cov = move @ self._cov @ move.T
        speed = np.hypot(self._mean[:, 2], self._mean[:, 3])
        noise = (0.6 * self.body.server.ball_rand * speed) ** 2 + 1e-4 + (0.15 * np.hypot(push[:, 0], push[:, 1])) ** 2
        gap = np.hypot(*(self._others[:, :, k] - self._mean[:, None, k] for k in (0, 1)))
        played = (self._known & (gap < self.body.reach + self.constants.near)).any(axis=1)
        noise = noise + np.where(played, self.constants.live**2, 0.0)
        for k in range(4):
            self._cov[:, k, k] += noise
        again = self._cycles <= self._late
        self._mean[again], self._cov[again] = kept[0][again], kept[1][again]

    def _reading(self, observation: Observation, me: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Place and velocity that the reading means, (N, 4), and its covariance (N, 4, 4)."""
        row = np.asarray(observation["ball"], np.float64)
        level = np.asarray(observation["level"])[:, 0]
        distance, angle = np.maximum(row[:, 0], 0.1), me[:, SelfFeature.FACE] + row[:, 1]
        cos, sin = np.cos(angle), np.sin(angle)
        along, across = row[:, 2], row[:, 3] * distance
        told = np.stack([me[:, SelfFeature.X] + distance * cos, me[:, SelfFeature.Y] + distance * sin,
                         me[:, SelfFeature.VX] + along * cos - across * sin, me[:, SelfFeature.VY] + along * sin + across * cos],
                        axis=1)  # fmt: skip
        s, n = self.senses, self.senses.noise * np.array(NOISE)
        step = 2.0 * s.gaussian if s.gaussian else s.quantise * self.body.server.quantize_step / np.sqrt(12.0)
        radial = distance * np.hypot(step, n[0]) + 0.03
        aside = distance * np.sqrt((np.radians(s.quantise) ** 2) / 12.0 + n[1] ** 2 + np.radians(self.constants.turned) ** 2) + 0.02
        moving = level >= BallLevel.MOVING
        told[:, 2:] = np.where(moving[:, None], told[:, 2:], self._mean[:, 2:])  # of a motion that is not told nothing is learned
        fast = np.where(moving, np.sqrt((VELOCITY_STEP * distance) ** 2 / 12.0 + n[2] ** 2 + 0.02**2), 1e3)
        turn = distance * np.hypot(TURN_STEP / np.sqrt(12.0), n[3]) + np.abs(across) * radial / distance + 0.02
        turn = np.where(moving, turn, 1e3)
        rotation = np.stack([np.stack([cos, -sin], -1), np.stack([sin, cos], -1)], -2)
        cov = np.zeros((len(row), 4, 4))
        for k, sizes in ((0, (radial, aside)), (2, (fast, turn))):
            spread = np.stack(sizes, axis=-1)[:, None, :] ** 2 * rotation
            cov[:, k : k + 2, k : k + 2] = spread @ rotation.transpose(0, 2, 1)
        return told, cov

    def _take(self, observation: Observation, me: np.ndarray) -> None:
        """The ball as it was seen from `me`."""
        seen = (np.asarray(observation["level"])[:, 0] > 0) & (me[:, SelfFeature.LOCATED] > 0)
        seen &= (self._cycles == 0) | (self._cycles > self._late)
        if not seen.any():
            return
        told, noise = self._reading(observation, me)
        first = seen & ~self._seen
        still = noise[:, 2, 2] > 1e3
        self._mean[first] = told[first]
        self._mean[first & still, 2:] = 0.0
        self._cov[first] = noise[first]
        for k in (2, 3):  # no ball is that fast; row and column together, so that it stays a covariance
            share = 1.0 / np.sqrt(np.maximum(self._cov[first, k, k], 1.0))
            self._cov[first, k] *= share[:, None]
            self._cov[first, :, k] *= share[:, None]
        again = seen & self._seen
        self._seen |= seen
        if not again.any():
            return
        off, cov, noise = told[again] - self._mean[again], self._cov[again], noise[again]
        odd = np.einsum("ni,ni->n", off, np.linalg.solve(cov + noise, off[..., None])[..., 0]) > self.constants.surprise
        cov[odd] += self.constants.opened**2 * np.diag([1.0, 1.0, 2.0, 2.0])
        gain = np.linalg.solve(cov + noise, cov).transpose(0, 2, 1)
        self._mean[again] += np.einsum("nij,nj->ni", gain, off)
        cov = cov - gain @ cov
        self._cov[again] = 0.5 * (cov + cov.transpose(0, 2, 1))

    # ------------------------------------------------------------------ the others

    def _follow(self, memory: np.ndarray, age: np.ndarray, me: np.ndarray, started: bool) -> None:
        """The other players' places, written into `memory` (N, 23, 4); where each was last seen stands there."""
        x, p = self._others, self._spread
        seen = (age[:, 1:] <= self._late_others) & (age[:, 1:] < NEVER)
        run, tiring = self.constants.run**2, self.constants.tiring
        if not started:
            x[..., :2] += x[..., 2:]
            x[..., 2:] *= tiring
            p[..., 0] += 2.0 * p[..., 1] + p[..., 2] + run
            p[..., 1] = tiring * (p[..., 1] + p[..., 2]) + run
            p[..., 2] = tiring**2 * p[..., 2] + run
        place = np.asarray(memory[:, 1:, :2], np.float64)
        away = np.hypot(*(place[..., k] - me[:, None, k] for k in (SelfFeature.X, SelfFeature.Y)))
        s = self.senses
        step = 2.0 * s.gaussian if s.gaussian else s.quantise * 0.03
        error = (away * np.hypot(step, s.noise * NOISE[0]) + 0.1) ** 2
        off = place - x[..., :2]
        lost = np.hypot(off[..., 0], off[..., 1]) > 4.0 + 3.0 * np.sqrt(error)
        fresh = seen & (~self._known | lost)
        x[fresh] = np.concatenate([place[fresh], np.zeros_like(place[fresh])], axis=1)
        p[fresh] = np.stack([error[fresh], np.zeros(fresh.sum()), np.full(fresh.sum(), 0.16)], axis=1)
        more = seen & ~fresh
        total = p[..., 0] + error
        gains = (p[..., 0] / total, p[..., 1] / total)
        for k in (0, 1):
            x[..., k] += np.where(more, gains[0] * off[..., k], 0.0)
            x[..., 2 + k] += np.where(more, gains[1] * off[..., k], 0.0)
        p[more] -= np.stack([gains[0] * p[..., 0], gains[0] * p[..., 1], gains[1] * p[..., 1]], axis=-1)[more]
        self._known |= seen
        self._known &= age[:, 1:] < NEVER
        recent = self._known & (age[:, 1:] <= self._late_others + self.constants.recent)
        x[~recent, 2:] = 0.0
        ahead = x[..., :2] + self._late_others * x[..., 2:]
        memory[:, 1:, :2] = np.where(recent[..., None], ahead, memory[:, 1:, :2])
