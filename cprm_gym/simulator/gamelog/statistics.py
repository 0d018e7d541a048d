"""What team leaders want to know of a match, from its game log alone: possession, passes, shots, ways, offsides, stamina.

A log tells who kicked or tackled (state bits), not what for. What is counted follows from these and from where the ball goes:

* *touch*: a kick, or a tackle that hit the ball;
* *possession*: cycles of play_on since the team's last touch of the ball, up to the other team's;
* *pass*: a touch followed by one of a team-mate within play_on; *lost* when an opponent is next;
* *shot*: a touch after which the ball would cross the opponents' goal line within the goal and a metre beside it, fast enough to get there,
  from at most 35 m;
* *way*: the sum of a player's steps while the clock runs; steps of more than 2 m are placements, not running.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..pitch import HALF_LENGTH, HALF_WIDTH
from ..state import PLAYERS, PlayerBit, PlayMode
from .frames import Frame
from .reader import GameLogReader

LONGEST_SHOT, LONGEST_STEP, BESIDE = 35.0, 2.0, 1.0
"""Metres: from where a shot is one, that a player runs in a cycle at most, beside the goal."""
CELLS = (42, 27)
"""Columns and rows of a heat map, 2.5 m each."""
_COUNTED = ("offside", "foul_charge", "free_kick_fault", "back_pass", "catch_fault", "corner_kick", "kick_in", "goal_kick", "free_kick")


@dataclass
class Part:
    """A part of a match: a half, or all of it. Pairs are left, right."""

    name: str
    cycles: int = 0
    playing: int = 0
    """Cycles of play_on."""
    possession: list[int] = field(default_factory=lambda: [0, 0])
    """Cycles of it since each team's touches."""
    goals: list[int] = field(default_factory=lambda: [0, 0])
    touches: list[int] = field(default_factory=lambda: [0, 0])
    passes: list[int] = field(default_factory=lambda: [0, 0])
    lost: list[int] = field(default_factory=lambda: [0, 0])
    shots: list[int] = field(default_factory=lambda: [0, 0])
    modes: Counter[str] = field(default_factory=Counter)
    """How often each play mode began."""
    way: np.ndarray = field(default_factory=lambda: np.zeros(PLAYERS))
    """(22,) metres."""
    stamina: np.ndarray = field(default_factory=lambda: np.full(PLAYERS, np.nan))
    """(22,) at the end."""
    least: np.ndarray = field(default_factory=lambda: np.full(PLAYERS, np.nan))
    """(22,) the least."""
    heat: np.ndarray = field(default_factory=lambda: np.zeros((3, *CELLS)))
    """(3, columns, rows) cycles that the ball, the left and the right players spent in each cell."""

    def rows(self) -> list[tuple[str, str, str]]:
        """(what, left, right) as text."""
        shown = [_row("goals", self.goals)]
        total = sum(self.possession)
        shown.append(_row("possession", [f"{100 * n / total:.1f} %" if total else "-" for n in self.possession]))
        shown += [_row("touches", self.touches), _row("shots", self.shots)]
        tried = [kept + lost for kept, lost in zip(self.passes, self.lost)]
        shown.append(_row("passes", [f"{n} of {of}" + (f" ({100 * n / of:.0f} %)" if of else "") for n, of in zip(self.passes, tried)]))
        shown += [_row(mode, [self.modes[f"{mode}_{side}"] for side in "lr"]) for mode in _COUNTED]
        ways = self.way.reshape(2, 11)
        shown.append(_row("way, km", [f"{way.sum() / 1000:.2f}" for way in ways]))
        shown.append(_row("longest way, km", [f"{way.max() / 1000:.2f} (number {int(way.argmax()) + 1})" for way in ways]))
        for name, values in (("stamina at the end", self.stamina), ("least stamina", self.least)):
            shown.append(_row(name, ["-" if np.isnan(side).all() else f"{np.nanmean(side):.0f}" for side in values.reshape(2, 11)]))
        return shown


def _row(name: str, pair: Sequence[object]) -> tuple[str, str, str]:
    """A row of the table: what, left, right."""
    return name, str(pair[0]), str(pair[1])


@dataclass
class MatchStatistics:
    """A match and its halves.

    Attributes
    ----------
    teams : (str, str)
    whole : Part
    halves : list of Part
    """

    teams: tuple[str, str]
    whole: Part
    halves: list[Part]

    @property
    def parts(self) -> list[Part]:
        """The whole, then each half if there are several."""
        return [self.whole, *(self.halves if len(self.halves) > 1 else [])]


class Counting:
    """Counts frame by frame.

    Parameters
    ----------
    half : int
        Cycles of a half; not positive for an endless match.
    goal_half : float
        Half the width of the goal, m.
    ball_decay : float
        Share of its speed that the ball keeps in a cycle.
    """

    def __init__(self, half: int = 3000, goal_half: float = 7.01, ball_decay: float = 0.94) -> None:
        self._half, self._goal, self._roll = half, goal_half + BESIDE, max(1.0 - ball_decay, 1e-6)
        self._whole, self._halves = Part("match"), [Part("half 1")]
        self._last: Frame | None = None
        self._owner = -1
        self._teams = "", ""

    def add(self, frame: Frame) -> None:
        """Count one frame."""
        last, self._last = self._last, frame
        self._teams = frame.left.name or self._teams[0], frame.right.name or self._teams[1]
        number = max(0, (frame.time - 1) // self._half) if self._half > 0 else 0
        while len(self._halves) <= min(number, 9):
            self._halves.append(Part(f"half {len(self._halves) + 1}"))
        parts = (self._whole, self._halves[min(number, 9)])
        for part in parts:
            _stay(part, frame)
        if last is None or frame.mode != last.mode:
            self._mode_begins(frame, last, parts)
        if last is not None:
            steps = np.hypot(*(frame.players["pos"] - last.players["pos"]).T)
            running = frame.time == last.time + 1
            for part in parts:
                part.way += np.where(running & (steps <= LONGEST_STEP), np.nan_to_num(steps), 0.0)
        self._touches(frame, last, parts)
        if frame.mode == PlayMode.play_on:
            for part in parts:
                part.playing += 1
                if self._owner >= 0:
                    part.possession[self._owner // 11] += 1

    def _mode_begins(self, frame: Frame, last: Frame | None, parts: tuple[Part, ...]) -> None:
        for part in parts:
            part.modes[frame.mode.name] += 1
        if frame.mode != PlayMode.play_on:
            self._owner = -1
        if last is not None:
            gained = frame.left.score - last.left.score, frame.right.score - last.right.score
            for part in parts:
                for side in (0, 1):
                    part.goals[side] += max(0, gained[side])

    def _touches(self, frame: Frame, last: Frame | None, parts: tuple[Part, ...]) -> None:
        """Who played the ball in this cycle, and what came of the touch before."""
        state = frame.players["state"].astype(np.int64)
        kicked = (state & PlayerBit.KICK != 0) & (state & PlayerBit.KICK_FAULT == 0)
        tackled = (state & PlayerBit.TACKLE != 0) & (state & PlayerBit.TACKLE_FAULT == 0)
        if last is not None:
            tackled &= last.players["state"].astype(np.int64) & PlayerBit.TACKLE == 0
        rows = np.flatnonzero(kicked | tackled)
        if len(rows) == 0:
            return
        if len(rows) > 1:  # the nearest one had it
            gaps = np.hypot(*(frame.players["pos"][rows] - (frame.ball[:2] if last is None else last.ball[:2])).T)
            rows = rows[[int(np.nanargmin(gaps)) if not np.isnan(gaps).all() else 0]]
        row = int(rows[0])
        side = row // 11
        for part in parts:
            part.touches[side] += 1
            if self._owner >= 0 and self._owner != row:
                (part.passes if self._owner // 11 == side else part.lost)[self._owner // 11] += 1
            part.shots[side] += self._is_shot(frame, side)
        self._owner = row

    def _is_shot(self, frame: Frame, side: int) -> bool:
        """Whether the ball is on its way into the opponents' goal."""
        x, y, vx, vy = frame.ball
        ahead = HALF_LENGTH - x if side == 0 else HALF_LENGTH + x
        speed = vx if side == 0 else -vx
        if not (np.isfinite((x, y, vx, vy)).all() and speed > 0.3 and 0 < ahead <= LONGEST_SHOT):
            return False
        return bool(speed / self._roll >= ahead and abs(y + vy / speed * ahead) <= self._goal)

    def result(self) -> MatchStatistics:
        """What was counted."""
        return MatchStatistics(self._teams, self._whole, self._halves)


def _stay(part: Part, frame: Frame) -> None:
    """Where everybody is, and how tired."""
    part.cycles += 1
    stamina = frame.players["stamina"]
    there = frame.players["state"] != 0
    part.stamina = np.where(there, stamina, part.stamina)
    part.least = np.fmin(part.least, np.where(there, stamina, np.nan))
    _heat(part.heat[0], frame.ball[None, :2])
    _heat(part.heat[1], frame.players["pos"][:11][there[:11]])
    _heat(part.heat[2], frame.players["pos"][11:][there[11:]])


def _heat(cells: np.ndarray, places: np.ndarray) -> None:
    for x, y in places:
        if abs(x) <= HALF_LENGTH and abs(y) <= HALF_WIDTH:
            column = min(int((x + HALF_LENGTH) / (2 * HALF_LENGTH) * CELLS[0]), CELLS[0] - 1)
            cells[column, min(int((y + HALF_WIDTH) / (2 * HALF_WIDTH) * CELLS[1]), CELLS[1] - 1)] += 1


def match_statistics(path: str | os.PathLike[str]) -> MatchStatistics:
    """The statistics of a game log of any version.

    Raises
    ------
    FormatError
        When it cannot be read.
    """
    reader = GameLogReader(path)
    parameters = reader.header.parameters()
    counting = Counting(parameters.half_cycles, parameters.goal_width / 2, parameters.ball_decay)
    for frame in reader:
        counting.add(frame)
    return counting.result()
