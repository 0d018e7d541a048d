"""The tier ``intention``: what a tracker knows, and beside it what the holder of the ball is about to do.

News may be late: the belief of the time of the news is rolled forward to now with the model, cycle by cycle, each with the chance that
he has shot in it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import ClassVar, NamedTuple

import numpy as np

from ...architecture.prm.grounding.grounding import Grounding
from ...architecture.prm.inference.filter_bank import FilterBank
from ...architecture.prm.inference.links import Link, Role
from ...envs.controller import Action, Observation
from ...envs.observations import SelfFeature
from ..knowledge.tracker import Tracker
from .model import DUE, LINE, MODES, PACE, POSSESSES, Intention
from .situation import GOAL_X, VIEW, situation, touch, view

HELD = 3.0
"""Metres from the ball within which an opponent holds it."""
KNOWN = 20
"""Cycles since he was seen up to which an opponent counts."""
BLIND = 6
"""Cycles without a look at the ball, before the last news, of which it is asked whether he has shot in them."""


class Told(IntEnum):
    """Columns of the part ``intention`` of an observation."""

    CHANCE = 0
    """Probability that a shot was made in a cycle of which there are no news yet, or is in the one that comes."""
    SIDE = 1
    """Probability that it goes to the side of the middle that is more probable."""
    X = 2
    """Where the ball then is, m."""
    Y = 3
    LINE = 4
    """y at which it is expected to cross the goal line, on that side, m."""
    SPEED = 5
    """Its speed, m / cycle."""
    WITHIN_3 = 6
    """Probability of a shot within 3 cycles."""
    WITHIN_5 = 7


@dataclass(frozen=True)
class Rule:
    """The hand rule "expect the shot": a rival of the model.

    Attributes
    ----------
    gap, far : float
        Metres from holder to ball, and from the ball to the goal, within which the shot is expected at once.
    """

    gap: float = 1.8
    far: float = 24.0


class Held(NamedTuple):
    """Who held the ball in S cycles of N worlds."""

    holder: np.ndarray
    """(S, N) int: of the opponents, -1 nobody."""
    at: tuple[np.ndarray, np.ndarray]
    """Where somebody did: indices of cycles and worlds, n each."""
    numbers: np.ndarray
    """(n, F) `situation`."""
    seen: np.ndarray
    """(n, V + F) `view` and `situation`."""


class IntentionTier:
    """A tracker's knowledge and the holder's intention, of one agent in N worlds.

    Parameters
    ----------
    inner : Tracker
        Knows the ball and the others.
    intention : Intention
        Learned tables.
    opponents : int
        How many there may be.
    attended, possesses, memory : bool
        Lesions: whether opponents who are not seen are carried on, whether the relation to the holder holds at all, and whether what he
        has in mind lasts from one cycle to the next.
    rule : Rule, optional
        The chance by hand instead of the model's.
    """

    name: ClassVar[str] = "intention"
    oracle: ClassVar[bool] = False

    def __init__(
        self,
        inner: Tracker,
        intention: Intention,
        opponents: int = 2,
        *,
        attended: bool = True,
        possesses: bool = True,
        memory: bool = True,
        rule: Rule | None = None,
    ) -> None:
        self.inner, self.intention, self.opponents, self.rule = inner, intention, opponents, rule
        self.attended, self.possesses = attended, possesses
        tables = dict(intention.tables)
        if not memory:
            tables["mode"] = np.tile(tables["begin"], (len(MODES), 1))
        self._tables = tables
        model = replace(intention, tables=tables).model()
        self._grounding = Grounding(model, {"ball": "Ball", **{f"o{k + 1}": "Opponent" for k in range(opponents)}})
        self._bank: FilterBank | None = None
        self._by_leaf, self._lines = tables["due"].transpose(1, 0, 2).copy(), tables["line"].transpose(1, 0, 2).copy()
        y, v = np.array(LINE.edges), np.array(PACE.edges)
        self._middles = 0.5 * (y[1:] + y[:-1])
        self._paces = tables["pace"] @ (0.5 * (v[1:] + v[:-1]))

    # ------------------------------------------------------------------ life

    def reset(self, observation: Observation, worlds: np.ndarray | None = None) -> None:
        """Forget."""
        count = len(observation["level"])
        self.inner.reset(observation, worlds)
        if worlds is None or self._bank is None or self._bank.batch != count:
            if self.rule is None:
                self._bank = FilterBank(self._grounding, count, on_impossible="restart")
            self._history: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
            self._balls: list[np.ndarray] = []
            self._before, self._cycles = np.zeros((count, 4)), np.zeros(count, np.int64)
            self._begins = np.ones(count, bool)
            return
        self._bank.reset(worlds)
        self._cycles[worlds], self._begins[worlds] = 0, True

    def know(self, observation: Observation, sent: Action | None) -> Mapping[str, np.ndarray]:
        """What the tracker knows, and the part ``intention``."""
        known = dict(self.inner.know(observation, sent))
        if sent is not None:  # in worlds that begin while others go on nothing has happened yet
            self._cycles += ~self._begins
        self._begins[:] = False
        whole = {**observation, **known}
        self._remember(whole, observation)
        known["intention"] = self._expect()
        return known

    def _remember(self, known: Observation, told: Observation) -> None:
        """Opponents (N, K, 4), their ages (N, K) and the goalie's own place (N, 2) of this cycle, for when the news of it come."""
        rows = slice(12, 12 + self.opponents)
        age = np.asarray(known["memory_age"])[:, 1:][:, rows.start - 1 : rows.stop - 1].astype(np.float64)
        source = known if self.attended else told
        place = np.asarray(source["memory"], np.float64)[:, rows, :2]
        way = self.inner.velocities[:, rows.start - 1 : rows.stop - 1] if self.attended else np.zeros_like(place)
        me = np.asarray(known["self"], np.float64)[:, [SelfFeature.X, SelfFeature.Y]]
        self._history.insert(0, (np.concatenate([place, way], axis=2), age, me))
        del self._history[self.inner.late + BLIND + 1 :]

    def holding(self, balls: np.ndarray, late: int = 0, asked: np.ndarray | None = None) -> Held:
        """Who held the ball in some cycles.

        Parameters
        ----------
        balls : (S, N, 4) array
            The ball in cycles that follow each other, the last of them `late` cycles ago.
        late : int
        asked : (S, N) bool array, optional
            Of which cycles it is asked; nobody held it in others.
        """
        steps = len(balls)
        kept = [self._history[min(late + steps - 1 - k, len(self._history) - 1)] for k in range(steps)]
        others, age, me = (np.stack(parts) for parts in zip(*kept))
        gap = np.hypot(*(others[..., k] - balls[:, :, None, k] for k in (0, 1)))
        gap = np.where(age <= KNOWN, gap, np.inf)
        nearest = gap.argmin(axis=2)
        holder = np.where((np.take_along_axis(gap, nearest[..., None], 2)[..., 0] < HELD) & self.inner.seen, nearest, -1)
        if asked is not None:
            holder = np.where(asked, holder, -1)
        cycles, worlds = np.nonzero(holder >= 0)
        at, who = (cycles, worlds), (cycles, worlds, nearest[cycles, worlds])
        body, back = self.inner.body, late + steps - 1 - at[0]
        ages = np.stack([age[who], np.maximum(self.inner.ball_age[at[1]] - back, 0)], axis=1)
        numbers = situation(balls[at], others[who], ages, me[at], body, self.inner.senses.noise)
        return Held(holder, at, numbers, np.hstack([view(balls[at], me[at], body), numbers]))

    # ------------------------------------------------------------------ what he is about to do

    def _expect(self) -> np.ndarray:
        """(N, 8) `Told`: from the last look at the ball, through the cycles without one, to the news, and rolled on to now."""
        course = self.inner.course()
        late, count = len(course) - 1, len(course[0])
        self._balls.insert(0, course[0])
        del self._balls[BLIND + 1 :]
        blind = np.minimum(np.maximum(self.inner.ball_age - late, 0.0), BLIND)
        # nobody has seen anything before the first cycle
        since = np.minimum(late + blind, self._cycles)
        way = np.stack([*self._balls[int(blind.max(initial=0.0)) : 0 : -1], *course])
        told, last = np.zeros((count, len(Told))), len(way) - 1
        held = self.holding(way, 0, since >= last - np.arange(len(way))[:, None])
        due, open_to, pace = self._sorted(held, way.shape[:2])
        p, unseen, best = self._modes(course[0], late, held, last - late), np.ones(count), np.zeros(count)
        ruled = np.zeros(way.shape[:2])
        if self.rule is not None:
            ruled[held.at] = (held.numbers[:, 0] < self.rule.gap) & (held.numbers[:, 3] < self.rule.far)
        for step, ball in enumerate(way):
            back = last - step
            there = (held.holder[step] >= 0) & self.possesses
            shoots = (p * due[step, ..., 0]).sum(axis=1) if self.rule is None else ruled[step] * (back == 0)
            chance = unseen * np.where(there, shoots, 0.0)
            better = there & (chance >= best) & (chance > 0)
            if better.any():
                weights = p[better] * due[step, better, :, 0] + 1e-9
                weights /= weights.sum(axis=1, keepdims=True)
                told[better, : Told.WITHIN_3] = self._aim(ball[better], weights, open_to[step, better], pace[step, better], back)
                best[better] = chance[better]
            unseen = unseen - chance
            if back == 0:
                for column, cycles in ((Told.WITHIN_3, 3), (Told.WITHIN_5, 5)):
                    soon = (p[..., None] * due[step, :, :, :cycles]).sum(axis=(1, 2))
                    told[:, column] = 1.0 - (unseen + chance) * (1.0 - np.where(there, soon, 0.0))
            elif back <= late:
                p = p * (1.0 - due[step, ..., 0])
                p = p / p.sum(axis=1, keepdims=True) @ self._tables["mode"]
        told[:, Told.CHANCE] = 1.0 - unseen
        return told

    def _sorted(self, held: Held, shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(S, N, M, D) when he shoots in each mode, nowhere where nobody holds the ball; (S, N) leaves of `views`, and the pace."""
        due, open_to = np.zeros((*shape, len(MODES), len(DUE))), np.zeros(shape, np.int64)
        due[held.at] = self._by_leaf[self.intention.situations.leaf(held.numbers)]
        open_to[held.at] = self.intention.views.leaf(held.seen[:, : len(VIEW)])
        pace = np.ones(shape)
        pace[held.at] = self._paces[self.intention.drives.leaf(held.seen)]
        return due, open_to, pace

    def _modes(self, ball: np.ndarray, back: int, held: Held, step: int) -> np.ndarray:
        """(N, M) what he has in mind, believed at the time of the news: one step of the model."""
        begin = np.tile(self._tables["begin"], (len(ball), 1))
        if self._bank is None:
            return begin
        holder = held.holder[step]
        done = np.where(self._cycles > back, touch(self._before, ball, self.inner.body), -1)
        self._before = ball.copy()
        evidence = {"ball.touch": np.ma.masked_less(np.where(holder >= 0, done, -1), 0)}
        whom = Role("Opponent", np.where(self.possesses, holder, -1))
        self._bank.step(evidence, (Link(POSSESSES, (whom, "ball")),))
        for agents, posterior in self._bank.answers:
            for name in (name for name in posterior.variables if name.endswith(".mode")):
                mine = agents[self._own(name, agents) == holder[agents]]
                if len(mine):
                    begin[mine] = posterior[name][np.isin(agents, mine)]
        return begin

    def _own(self, name: str, agents: np.ndarray) -> np.ndarray:
        """Whom of the opponents each agent means by a variable of its posterior."""
        assert self._bank is not None
        place = int(name.partition(".")[0][1:]) - 1
        order = self._bank.object_in.get("Opponent")
        return np.full(len(agents), place) if order is None else order[agents, place]

    def _aim(self, ball: np.ndarray, modes: np.ndarray, leaf: np.ndarray, pace: np.ndarray, cycles: int) -> np.ndarray:
        """(n, 6) chance (0), side, place, line and speed of a shot made `cycles` ago."""
        line = (modes[..., None] * self._lines[leaf]).sum(axis=1)
        left = self._middles > 0
        side = line[:, left].sum(axis=1)
        part = np.where((side > 0.5)[:, None] == left, line, 0.0)
        y = (part * self._middles).sum(axis=1) / part.sum(axis=1)
        decay = self.inner.body.ball_decay
        way = np.stack([GOAL_X - ball[:, 0], y - ball[:, 1]], axis=1)
        length = np.maximum(np.hypot(*way.T), 0.1)
        rolled = np.minimum(pace * (1.0 - decay**cycles) / (1.0 - decay), length - 0.05)
        place = ball[:, :2] + way * (rolled / length)[:, None]
        return np.stack([np.zeros(len(ball)), np.maximum(side, 1.0 - side), place[:, 0], place[:, 1], y, pace * decay**cycles], axis=1)
