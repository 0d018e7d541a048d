"""see of many players at once, short names (specification/protocol.md 5.3)."""

from __future__ import annotations

import numpy as np

from ...kernels import landmark_sight, senses
from ...kernels.geometry import R2D
from ...kernels.senses import FELT, IN_VIEW, KICKING, NAME_SEEN, POINTING, TACKLING, TEAM_SEEN, TOLD_MOVING
from ...landmarks import LANDMARKS as N_LANDMARKS
from ...state import PLAYERS
from . import kernel, words
from .words import BLANK, CLOSE, NUL, OPEN, QUOTE, put_count, put_degrees, put_number, put_text, put_word

_NAMES, _NAME_LENGTHS = words.LANDMARKS
_FELT, _FELT_LENGTHS = words.CLOSE_LANDMARKS
_LINES, _LINE_LENGTHS = words.LINES
_B, _CLOSE_B, _P, _CLOSE_P = ord("b"), ord("B"), ord("p"), ord("P")


@kernel
def put_place(out, at, row):
    """``) DIST DIR`` behind a name; a distance that is not told is NaN."""
    if at < 0:
        return -1
    out[at] = CLOSE
    at += 1
    if row[0] == row[0]:
        at = put_number(out, at, row[0])
    return put_degrees(out, at, row[1])


@kernel
def put_changes(out, at, row):
    """`` DISTCHG DIRCHG`` where they are told."""
    if at < 0 or row[2] != row[2]:
        return at
    return put_number(out, put_number(out, at, row[2]), row[3] * R2D)


@kernel
def open_object(out, at):
    """Blank and the parentheses of an object and its name."""
    if at < 0:
        return -1
    out[at], out[at + 1], out[at + 2] = BLANK, OPEN, OPEN
    return at + 3


@kernel
def close_object(out, at):
    """The end of an object."""
    if at < 0:
        return -1
    out[at] = CLOSE
    return at + 1


@kernel
def put_landmarks(rows, levels, out, at):
    """All landmarks that are seen or felt."""
    for j in range(N_LANDMARKS):
        level = levels[j]
        if level == 0:
            continue
        at = open_object(out, at)
        if level == FELT:
            at = put_word(out, at, _FELT, _FELT_LENGTHS, j)
        else:
            at = put_word(out, at, _NAMES, _NAME_LENGTHS, j)
        at = put_place(out, at, rows[j])
        if level == TOLD_MOVING:
            at = put_changes(out, at, rows[j])
        at = close_object(out, at)
    return at


@kernel
def put_ball(row, level, out, at):
    """The ball, if it is seen or felt."""
    if level == 0 or at < 0:
        return at
    at = open_object(out, at)
    out[at] = _CLOSE_B if level == FELT else _B
    at = put_place(out, at + 1, row)
    if level == TOLD_MOVING:
        at = put_changes(out, at, row)
    return close_object(out, at)


@kernel
def put_name(w, i, j, level, marks, names, lengths, out, at):
    """Name of player `j` as player `i` is told it; `names` (2, 2, longest): side of the observer, team."""
    out[at] = _P if level > FELT or marks & IN_VIEW else _CLOSE_P
    at += 1
    if level == FELT:
        return at
    observer, team = (0 if i < 11 else 1), (0 if j < 11 else 1)
    out[at], out[at + 1] = BLANK, QUOTE
    at = put_word(out, at + 2, names[observer], lengths[observer], team)
    out[at] = QUOTE
    at += 1
    if level == NAME_SEEN:
        at = put_count(out, at, j % 11 + 1)
        if w.goalie[j] == 1 or (w.goalie[j] != 0 and observer == team):
            at = put_text(out, at, words.GOALIE_MARK)
    return at


@kernel
def put_player(w, i, j, v, row, level, marks, names, lengths, out, at):
    """Player `j`."""
    at = open_object(out, at)
    if at < 0:
        return -1
    at = put_place(out, put_name(w, i, j, level, marks, names, lengths, out, at), row)
    if row[0] == row[0] and level >= TEAM_SEEN:
        if level == NAME_SEEN:
            at = put_degrees(out, put_degrees(out, put_changes(out, at, row), row[4]), row[5])
        if marks & POINTING and v >= 8:
            at = put_degrees(out, at, row[6])
        if marks & TACKLING and v >= 8:
            at = put_text(out, at, words.TACKLING_MARK)
        elif marks & KICKING and v >= 13:
            at = put_text(out, at, words.KICKING_MARK)
    return close_object(out, at)


@kernel
def put_lines(rows, ids, out, at):
    """The lines in front."""
    for k in range(ids.shape[0]):
        if ids[k]:
            at = put_word(out, open_object(out, at), _LINES, _LINE_LENGTHS, ids[k])
            at = close_object(out, put_place(out, at, rows[k]))
    return at


@kernel
def put_sight(w, p, i, v, tick, names, lengths, scratch, out, at):
    """The message of player `i` for version `v`, with its NUL; where the next byte goes, -1 when a number needs an exponent."""
    ball, players, levels, marks, flags, flag_levels, lines, ids = scratch
    players[i], levels[i], marks[i], flags[i], flag_levels[i] = 0.0, 0, 0, 0.0, 0
    ball[i], lines[i], ids[i] = 0.0, 0.0, 0
    landmark_sight.look_at_landmarks(w, p, i, v, tick, flags, flag_levels)
    level = senses.look(w, p, i, v, tick, ball, players, levels, marks)[0]
    landmark_sight.look_at_lines(w, p, i, v, lines, ids)
    at = put_count(out, put_text(out, at, words.SEE), w.time)
    at = put_landmarks(flags[i], flag_levels[i], out, at)
    at = put_ball(ball[i], level, out, at)
    for j in range(PLAYERS):
        if levels[i, j]:
            at = put_player(w, i, j, v, players[i, j], levels[i, j], marks[i, j], names, lengths, out, at)
    at = put_lines(lines[i], ids[i], out, at)
    if at < 0:
        return -1
    out[at], out[at + 1] = CLOSE, NUL
    return at + 2


@kernel
def tell_sights(worlds, parameters, rows, newest, tick, names, lengths, scratch, out, ends):
    """see of the players `rows` of world 0, one after the other, each with its NUL.

    rows : (n,) 0..21; newest : version of those without one; tick : message of the cycle, for the draws
    names, lengths : (2, 2, longest), (2, 2) what the observers of each side call each team; scratch : buffers of `new_scratch`
    out : bytes; ends : (n,) where each message ends, -1 for one that `messages` has to write: old names, or a number with an exponent
    """
    w, p, at = worlds[0], parameters[0], 0
    for n in range(rows.shape[0]):
        i = rows[n]
        v = w.protocol[i] if w.protocol[i] > 0 else newest
        end = put_sight(w, p, i, v, tick, names, lengths, scratch, out, at) if v >= 6 else -1
        ends[n] = end
        if end >= 0:
            at = end


def new_scratch() -> tuple[np.ndarray, ...]:
    """Buffers for `tell_sights`."""
    return (
        np.zeros((PLAYERS, 4)),
        np.zeros((PLAYERS, PLAYERS, 7)),
        np.zeros((PLAYERS, PLAYERS), np.int8),
        np.zeros((PLAYERS, PLAYERS), np.uint8),
        np.zeros((PLAYERS, N_LANDMARKS, 4)),
        np.zeros((PLAYERS, N_LANDMARKS), np.int8),
        np.zeros((PLAYERS, 2, 2)),
        np.zeros((PLAYERS, 2), np.int8),
    )
