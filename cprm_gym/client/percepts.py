"""A player's messages as the arrays of the senses: text in, the numbers that the simulator would have put there.

The server prints six significant digits. What it rounds itself (distances, directions, changes, speeds) therefore comes out as it was, to
the last bit: a printed multiple of its step is multiplied out again. Stamina, effort, capacity and the distances of the Gaussian model
lose what stands behind the sixth digit.
"""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np

from ..simulator.kernels.senses import FELT, IN_VIEW, KICKING, NAME_SEEN, POINTING, TACKLING, TEAM_SEEN, TOLD, TOLD_MOVING
from ..simulator.landmarks import GOALS, LANDMARK_NAMES, LINE_NAMES
from ..simulator.senses import BodyColumn, Hear, Landmarks, See
from ..simulator.state import PlayMode

D2R = math.pi / 180.0
_SAME, _PRINTED = 1e-9, 5.1e-6
"""Relative errors: of a number whose six digits say everything, and of any with six digits."""
DISTANCE_STEP, SHARE_STEP, CHANGE_STEP, TURN_STEP, SPEED_STEP = 0.1, 0.02, 0.01, 0.1, 0.01
"""What the server rounds to: m, 1 / cycle, m / cycle, degrees / cycle, m / cycle (specification/simulator.md 6.1.4, 6.1.5, 6.2)."""
_OBJECT = re.compile(r"\(\(([^()]*)\) ([^()]*)\)")
_ITEM = re.compile(r"\(([a-z_]+) ((?:[^()]|\([^()]*\))*)\)")
_INNER = re.compile(r"\(([a-z_]+) ?([^()]*)\)")
_WIDTHS = {"narrow": 1, "normal": 2, "wide": 3}
_LANDMARKS = {name: row for row, name in enumerate(LANDMARK_NAMES)}
_LINES = {name: number for number, name in enumerate(LINE_NAMES) if name}
_COUNTS = {
    "kick": BodyColumn.COUNT_KICK, "dash": BodyColumn.COUNT_DASH, "turn": BodyColumn.COUNT_TURN, "say": BodyColumn.COUNT_SAY,
    "turn_neck": BodyColumn.COUNT_TURN_NECK, "catch": BodyColumn.COUNT_CATCH, "move": BodyColumn.COUNT_MOVE,
    "change_view": BodyColumn.COUNT_CHANGE_VIEW, "change_focus": BodyColumn.COUNT_CHANGE_FOCUS,
}  # fmt: skip
_INSIDE = {
    "arm": {"movable": BodyColumn.ARM_MOVABLE, "expires": BodyColumn.ARM_EXPIRES, "count": BodyColumn.COUNT_ARM},
    "focus": {"count": BodyColumn.COUNT_ATTENTION},
    "tackle": {"expires": BodyColumn.TACKLE_EXPIRES, "count": BodyColumn.COUNT_TACKLE},
    "foul": {"charged": BodyColumn.FOUL_CHARGED},
}
_HITS = {"ball": BodyColumn.HIT_BALL, "player": BodyColumn.HIT_PLAYER, "post": BodyColumn.HIT_POST}
CARDS = {"none": 0, "yellow": 1, "red": 2}
_HEARD = re.compile(r'\(hear (\d+) (?:(-?\d+) )?(our|opp)(?: (\d+))?(?: "([^"]*)")?\)')
MODES = PlayMode.__members__
_GOAL = re.compile(r"goal_([lr])_(\d+)")


def _number(word: str) -> float:
    """A finite number; what is none is an error of the message."""
    value = float(word)
    if not math.isfinite(value):
        raise ValueError(word)
    return value


def _rounded(value: float, step: float) -> float:
    """What the server rounded to a multiple of `step` before it printed `value`; `value` itself where it is no multiple."""
    multiple = round(value / step) * step
    return multiple if multiple and abs(multiple - value) <= _SAME * abs(value) else value


def _change(value: float, distance: float) -> float:
    """What the server told, m / cycle, of a change of `distance` (m) that it printed as `value`.

    The share of the distance is rounded; in the Gaussian model, whose distances are no multiples of `DISTANCE_STEP`, the change itself.
    """
    if distance > 0.0 and _rounded(distance, DISTANCE_STEP) == distance:
        told = distance * (round(value / distance / SHARE_STEP) * SHARE_STEP)
        if told and abs(told - value) <= _PRINTED * abs(value):
            return told
    return _rounded(value, CHANGE_STEP)


def read_see(text: str, row: int, team: str, see: See, marks: Landmarks) -> int:
    """Fill row `row` (0..21) of world 0 from a see message; its time.

    Parameters
    ----------
    text : str
    row : int
        Of the player.
    team : str
        Name of his team; every other is the opponents'.
    see, marks : See, Landmarks
        Only row `row` is written.

    Raises
    ------
    ValueError
        When it is no such message.
    """
    if not text.startswith("(see ") or not text.endswith(")"):
        raise ValueError(text[:40])
    time = int(text[5:-1].split(" ", 1)[0])
    sight = _Sight(row, team, see, marks)
    for name, rest in _OBJECT.findall(text):
        sight.add(name, rest.split(" "))
    sight.place_what_is_felt()
    return time


class _Sight:
    """A see message that is being read: row `row` of `see` and `marks`, and what has to wait for the rest of the message."""

    def __init__(self, row: int, team: str, see: See, marks: Landmarks) -> None:
        self._row, self._team, self._see, self._marks = row, team, see, marks
        for array in (*_seen_arrays(see), marks.landmarks, marks.level, marks.lines, marks.line):
            array[0, row] = 0
        see.fresh[0, row] = True
        self._nameless: dict[int, list[tuple[tuple[float, ...], list[float], int]]] = {0: [], 1: [], 2: []}
        self._felt: list[list[float]] = []
        self._felt_goal: list[float] = []
        self._lines = 0

    def add(self, name: str, words: list[str]) -> None:
        """One object: its name, and the words behind it."""
        kind = name[0]
        if kind in "pP":
            self._add_player(name, words)
            return
        values = [*map(_number, words)]
        if kind in "bB":
            self._see.ball_level[0, self._row] = FELT if kind == "B" else _told(values)
            _write(self._see.ball[0, self._row], values)
        elif kind in "fg":
            place = _LANDMARKS[name]
            self._marks.level[0, self._row, place] = _told(values)
            _write(self._marks.landmarks[0, self._row, place], values)
        elif kind == "F":
            self._felt.append(values)
        elif kind == "G":
            self._felt_goal = values
        elif name in _LINES and self._lines < 2:
            self._add_line(_LINES[name], values)
        else:
            raise ValueError(name)

    def _add_player(self, name: str, words: list[str]) -> None:
        """A player: at his place when his number is told, else he waits for a free one."""
        marked = {"t": TACKLING, "k": KICKING}.get(words[-1], 0)
        values = [*map(_number, words[:-1] if marked else words)]
        parts = name.split('"')
        flags = marked | (IN_VIEW if name[0] == "p" else 0)
        if len(values) in (3, 7):
            flags |= POINTING
        if len(parts) < 3:
            self._nameless[0].append(_nameless(values, flags))
            return
        own = 0 if self._row < 11 else 11
        side = own if parts[1] == self._team else 11 - own
        number = parts[2].split()
        if not number:
            self._nameless[1 if side == 0 else 2].append(_nameless(values, flags))
            return
        unum = int(number[0])
        if not 1 <= unum <= 11:
            raise ValueError(name)
        _write_player(self._see, self._row, side + unum - 1, values, NAME_SEEN, flags)

    def _add_line(self, line: int, values: list[float]) -> None:
        """A line in front: distance and direction, or the direction alone."""
        self._marks.line[0, self._row, self._lines] = line
        self._marks.lines[0, self._row, self._lines, 1] = values[-1] * D2R
        self._marks.lines[0, self._row, self._lines, 0] = _rounded(values[0], DISTANCE_STEP) if len(values) > 1 else np.nan
        self._lines += 1

    def place_what_is_felt(self) -> None:
        """At the end of the message: landmarks that are only felt, players without number."""
        if self._felt_goal:
            place = GOALS[1] if self._marks.level[0, self._row, GOALS[0]] else GOALS[0]
            self._marks.level[0, self._row, place] = FELT
            _write(self._marks.landmarks[0, self._row, place], self._felt_goal)
        if self._felt:
            _place_felt_flags(self._marks, self._row, self._felt)
        if any(self._nameless.values()):
            _place_nameless(self._see, self._row, self._nameless)


def _seen_arrays(see: See) -> tuple[np.ndarray, ...]:
    return see.ball, see.ball_level, see.players, see.players_level, see.players_flags


def _told(values: list[float]) -> int:
    """Whether of something seen also the changes are told."""
    return TOLD_MOVING if len(values) == 4 else TOLD


def _write(out: Any, values: list[float]) -> None:
    """Distance, direction and changes of one thing; a single number is the direction (low quality)."""
    if len(values) == 1:
        out[:] = np.nan
        out[1] = values[0] * D2R
        return
    distance = _rounded(values[0], DISTANCE_STEP)
    out[0], out[1] = distance, values[1] * D2R
    if len(values) >= 4:
        out[2], out[3] = _change(values[2], distance), _rounded(values[3], TURN_STEP) * D2R


def _write_player(see: See, row: int, place: int, values: list[float], level: int, flags: int) -> None:
    """One player at his place: distance, direction, changes, body, head, arm."""
    out = see.players[0, row, place]
    see.players_level[0, row, place], see.players_flags[0, row, place] = level, flags
    if flags & POINTING:
        values, arm = values[:-1], values[-1]
        out[6] = arm * D2R
    _write(out, values)
    if len(values) >= 6:
        out[4], out[5] = values[4] * D2R, values[5] * D2R


def _nameless(values: list[float], flags: int) -> tuple[tuple[float, ...], list[float], int]:
    """A player without number, with what decides his place among others."""
    distance, direction = (values[0], values[1]) if len(values) > 1 else (0.0, values[0])
    return (distance, direction, -flags), values, flags


def _place_nameless(see: See, row: int, nameless: dict[int, list[tuple[tuple[float, ...], list[float], int]]]) -> None:
    """Players without number stand in free places, nearest first: of their team, or, unknown, of the opponents, then of the own team."""
    levels = see.players_level[0, row]
    for team, first in ((1, 0), (2, 11)):
        free = [place for place in range(first, first + 11) if levels[place] == 0 and place != row]
        for (_, values, flags), place in zip(sorted(nameless[team]), free):
            _write_player(see, row, place, values, TEAM_SEEN, flags)
    opponents = 11 if row < 11 else 0
    order = [*range(opponents, opponents + 11), *range(11 - opponents, 22 - opponents)]
    free = [place for place in order if levels[place] == 0 and place != row]
    for (_, values, flags), place in zip(sorted(nameless[0]), free):
        _write_player(see, row, place, values, FELT, flags)


def _place_felt_flags(marks: Landmarks, row: int, felt: list[list[float]]) -> None:
    """Flags that are only felt stand in the first places of flags that are not seen, nearest first."""
    free = [place for place in range(marks.level.shape[2]) if place not in GOALS and marks.level[0, row, place] == 0]
    for values, place in zip(sorted(felt), free):
        marks.level[0, row, place] = FELT
        _write(marks.landmarks[0, row, place], values)


def read_body(text: str, out: np.ndarray) -> tuple[int, int]:
    """Fill the row `out` (columns `BodyColumn`) from a sense_body message; its time, and the card (0 none, 1 yellow, 2 red).

    Raises
    ------
    ValueError
        When it is no such message.
    """
    if not text.startswith("(sense_body ") or not text.endswith(")"):
        raise ValueError(text[:40])
    head, _, rest = text[12:-1].partition(" ")
    out[:] = 0.0
    card = 0
    for name, content in _ITEM.findall(rest):
        words = content.split(" ")
        if name in _COUNTS:
            out[_COUNTS[name]] = int(words[0])
        elif name == "stamina":
            out[BodyColumn.STAMINA], out[BodyColumn.EFFORT] = _number(words[0]), _number(words[1])
            out[BodyColumn.CAPACITY] = _number(words[2]) if len(words) > 2 else 0.0
        elif name == "speed":
            out[BodyColumn.SPEED] = _rounded(_number(words[0]), SPEED_STEP)
            out[BodyColumn.SPEED_DIRECTION] = _number(words[1]) * D2R if len(words) > 1 else 0.0
        elif name == "head_angle":
            out[BodyColumn.HEAD_ANGLE] = _number(words[0]) * D2R
        elif name == "view_mode":
            out[BodyColumn.VIEW_QUALITY], out[BodyColumn.VIEW_WIDTH] = 1 if words[0] == "high" else 2, _WIDTHS[words[1]]
        elif name in _INSIDE or name == "collision":
            for inner, told in _INNER.findall(content):
                if name == "collision":
                    out[_HITS[inner]] = 1
                elif inner in _INSIDE[name]:
                    out[_INSIDE[name][inner]] = int(told)
                elif name == "arm":
                    distance, direction = told.split(" ")
                    out[BodyColumn.ARM_DISTANCE], out[BodyColumn.ARM_DIRECTION] = _number(distance), _number(direction) * D2R
                elif name == "focus" and told != "none":
                    side, unum = told.split(" ")
                    out[BodyColumn.ATTENTION] = int(unum) + (0 if side == "l" else 11)
                elif name == "foul":
                    card = CARDS[told]
                    out[BodyColumn.CARD] = card
        elif name == "focus_point":
            out[BodyColumn.FOCUS_DISTANCE], out[BodyColumn.FOCUS_DIRECTION] = _number(words[0]), _number(words[1]) * D2R
    return int(head), card


def read_hear(text: str, row: int, hear: Hear) -> bool:
    """Add a message of a player to row `row` of world 0; False for what is none (the referee, a coach, the own voice)."""
    found = _HEARD.fullmatch(text)
    if found is None:
        return False
    n = int(hear.heard[0, row])
    if n < hear.sender.shape[2]:
        _, direction, side, unum, said = found.groups()
        hear.sender[0, row, n] = 1 if side == "our" else 2
        hear.level[0, row, n] = 1 if said is None else 2
        hear.unum[0, row, n] = int(unum or 0)
        hear.direction[0, row, n] = int(direction or 0) * D2R
        data = (said or "").encode("latin-1")[: hear.text.shape[3]]
        hear.length[0, row, n] = len(data)
        hear.text[0, row, n] = 0
        hear.text[0, row, n, : len(data)] = np.frombuffer(data, np.uint8)
    hear.heard[0, row] = min(n + 1, 100)
    return True


def read_referee(name: str, world: Any) -> None:
    """Take over what the referee says: play mode and goals."""
    goal = _GOAL.fullmatch(name)
    if goal is not None:
        world["score"][0 if goal[1] == "l" else 1] = int(goal[2][:6])
        world["mode"] = PlayMode.goal_l if goal[1] == "l" else PlayMode.goal_r
    elif name in MODES:
        world["mode"] = MODES[name]
