"""One ``{"show": ...}`` line of a JSON log, written and read whole (specification/protocol.md 11.1).

Both answer -1 for a line out of the ordinary, which is left to `writer` and `json`: they are slower, and say what is wrong. What is read
stands in the order in which servers write it; optional parts may be missing.
"""

from __future__ import annotations

import numpy as np

from ...kernels.digits import POINT, ZERO, put_real, put_whole, read_real, read_whole
from ...state import LEFT
from ..frames import LOG_COUNTS
from . import kernel
from .show import ANGLE_STEP, HIGHEST, LOWEST, MOST, POSITION_STEP, H, L, R, put, put_on_grid, stands

QUOTE, COMMA, END, AFTER_LIST = ord('"'), ord(","), ord("}"), ord("]")
_PLAIN = ("x", "y", "vx", "vy", "body", "neck", "px", "py", "vw", "fdist", "fdir", "stamina", "effort", "recovery", "capacity")
_NAMES = (*_PLAIN, "unum", "type", "state", "fnum", *LOG_COUNTS)
_SIZES = np.array([len(name) + 4 for name in _NAMES])
_KEYS = np.zeros((len(_NAMES), _SIZES.max()), np.uint8)
for _row, _name in zip(_KEYS, _NAMES):
    _row[: len(_name) + 4] = np.frombuffer(f',"{_name}":'.encode(), np.uint8)
"""What stands before each value."""
KEY_X, KEY_BODY, KEY_PX, KEY_VW, KEY_FDIST, KEY_STAMINA, KEY_UNUM, KEY_FNUM, KEY_COUNTS = (
    _NAMES.index(name) for name in ("x", "body", "px", "vw", "fdist", "stamina", "unum", "fnum", LOG_COUNTS[0])
)
_SHOW, _STIME, _BALL, _PLAYERS, _SIDE, _QUALITY, _ATTENDED, _LAST = (
    np.frombuffer(text.encode(), np.uint8).copy()
    for text in ('{"show":{"time":', ',"stime":', ',"ball":{', '},"players":[', '{"side":"', ',"vq":"', ',"fside":"', "]}}")
)


@kernel
def put_key(out, at, key):
    """``,"name":``; where the value goes."""
    for i in range(_SIZES[key]):
        out[at + i] = _KEYS[key, i]
    return at + _SIZES[key]


@kernel
def put_rounded_value(out, at, key, value, step):
    """A name and a number on the grid of `step`; where the next byte goes, or -1."""
    return -1 if at < 0 else put_on_grid(out, put_key(out, at, key), value, step)


@kernel
def put_plain_value(out, at, key, value):
    """A name and a number that is not rounded; where the next byte goes, or -1."""
    return -1 if at < 0 or np.isinf(value) else put_real(out, put_key(out, at, key), value)


@kernel
def put_whole_value(out, at, key, value):
    """A name and a whole number."""
    return -1 if at < 0 else put_whole(out, put_key(out, at, key), value)


@kernel
def put_letter(out, at, before, letter):
    """A name and a letter in quotes; `before` ends with the first quote."""
    if at < 0:
        return -1
    at = put(out, at, before)
    out[at], out[at + 1] = letter, QUOTE
    return at + 2


@kernel
def put_player(out, at, row):
    """``{"side":"l", ...}``; where the next byte goes, or -1."""
    at = put_letter(out, at, _SIDE, L if row.side == LEFT else R)
    at = put_whole_value(out, at, KEY_UNUM, row.unum)
    at = put_whole_value(out, at, KEY_UNUM + 1, max(row.type, 0))
    at = put_whole_value(out, at, KEY_UNUM + 2, np.int64(row.state))
    for k in range(2):
        at = put_rounded_value(out, at, KEY_X + k, row.pos[k], POSITION_STEP)
    for k in range(2):
        at = put_rounded_value(out, at, KEY_X + 2 + k, row.vel[k], POSITION_STEP)
    at = put_rounded_value(out, at, KEY_BODY, row.body, ANGLE_STEP)
    at = put_rounded_value(out, at, KEY_BODY + 1, row.neck, ANGLE_STEP)
    if not np.isnan(row.point[0]):
        for k in range(2):
            at = put_rounded_value(out, at, KEY_PX + k, row.point[k], POSITION_STEP)
    at = put_letter(out, at, _QUALITY, L if row.view_quality == 2 else H)
    at = put_rounded_value(out, at, KEY_VW, row.view_width, ANGLE_STEP)
    at = put_plain_value(out, at, KEY_STAMINA, row.stamina)
    at = put_plain_value(out, at, KEY_STAMINA + 1, row.effort)
    at = put_plain_value(out, at, KEY_STAMINA + 2, row.recovery)
    at = put_plain_value(out, at, KEY_STAMINA + 3, row.capacity)
    if row.attention:
        at = put_letter(out, at, _ATTENDED, R if row.attention > 11 else L)
        at = put_whole_value(out, at, KEY_FNUM, (row.attention - 1) % 11 + 1)
    for k in range(row.counts.shape[0]):
        at = put_whole_value(out, at, KEY_COUNTS + k, max(row.counts[k], 0))
    if at < 0:
        return -1
    out[at] = END
    return at + 1


@kernel
def write_show(time, stoppage, ball, players, out):
    """Write the line into `out` (`show.LONGEST_LINE` bytes), without the comma and the break that end it; its length, or -1.

    ball : (4,) float64; players : (22,) PLAYER_FRAME
    """
    at = put_whole(out, put(out, 0, _SHOW), time)
    if stoppage > 0:
        at = put_whole(out, put(out, at, _STIME), stoppage)
    at = put(out, at, _BALL) - 1  # the comma before the first name of the ball becomes its bracket
    bracket = at
    for k in range(4):
        at = put_rounded_value(out, at, KEY_X + k, ball[k], POSITION_STEP)
    if at < 0:
        return -1
    out[bracket] = ord("{")
    at = put(out, at, _PLAYERS)
    for i in range(players.shape[0]):
        if i > 0:
            out[at] = COMMA
            at += 1
        at = put_player(out, at, players[i])
        if at < 0:
            return -1
    return put(out, at, _LAST)


# --------------------------------------------------------------------------------------------------- reading


@kernel
def is_digit(text, at):
    """Whether a digit stands at `at`."""
    return at < text.shape[0] and ZERO <= text[at] <= ZERO + 9


@kernel
def ends_well(text, first, end):
    """`end`, if what stands from `first` to it is a number as JSON has them and something follows, else -1."""
    if end < 0 or end >= text.shape[0]:
        return -1
    if text[first] == ord("-"):
        first += 1
    if not is_digit(text, first) or text[end - 1] == POINT or (text[first] == ZERO and is_digit(text, first + 1)):
        return -1
    return end


@kernel
def value_at(text, at, key):
    """Where the value of a name stands, or -1 where another one does."""
    size = _SIZES[key]
    if at < 0 or at + size >= text.shape[0]:
        return -1
    for i in range(size):
        if text[at + i] != _KEYS[key, i]:
            return -1
    return at + size


@kernel
def read_value(text, at, key):
    """The number behind a name, and where it ends, or -1."""
    first = value_at(text, at, key)
    if first < 0:
        return 0.0, -1
    value, end = read_real(text, first)
    if value == 0.0 and end == first + 2:
        value = 0.0  # -0 is a whole number, which has no sign
    return value, ends_well(text, first, end)


@kernel
def read_whole_value(text, at, key, low, high):
    """The whole number behind a name, from `low` to `high`, and where it ends, or -1."""
    first = value_at(text, at, key)
    if first < 0:
        return 0, -1
    value, end = read_whole(text, first)
    return value, ends_well(text, first, end) if low <= value <= high else -1


@kernel
def read_letter(text, at, before, first, second):
    """Which of two letters stands in quotes behind `before`, 0 or 1, and where its quote ends; (0, -1) for none of them."""
    at = stands(text, at, before)
    if at < 0 or at + 1 >= text.shape[0] or text[at + 1] != QUOTE or (text[at] != first and text[at] != second):
        return 0, -1
    return (0 if text[at] == first else 1), at + 2


@kernel
def read_numbers(text, at, key, count, values):
    """Read the numbers of `count` names from `key` on; where they end, or -1."""
    for k in range(count):
        values[k], at = read_value(text, at, key + k)
    return at


@kernel
def read_player(text, at, rows, values):
    """Read ``{"side":"l", ...}`` into its row; where it ends, or -1."""
    side, at = read_letter(text, at, _SIDE, L, R)
    unum, at = read_whole_value(text, at, KEY_UNUM, 1, 11)
    kind, at = read_whole_value(text, at, KEY_UNUM + 1, LOWEST, HIGHEST)
    state, at = read_whole_value(text, at, KEY_UNUM + 2, 0, MOST)
    at = read_numbers(text, at, KEY_X, 6, values)
    if at < 0:
        return -1
    row = rows[11 * side + unum - 1]
    row.type, row.state = kind, state
    for k in range(2):
        row.pos[k], row.vel[k] = values[k], values[2 + k]
    row.body, row.neck = values[4], values[5]
    if value_at(text, at, KEY_PX) >= 0:
        at = read_numbers(text, at, KEY_PX, 2, values)
        row.point[0], row.point[1] = values[0], values[1]
    quality, at = read_letter(text, at, _QUALITY, H, L)
    row.view_quality = quality + 1
    at = read_numbers(text, at, KEY_VW, 1, values)
    row.view_width = values[0]
    if value_at(text, at, KEY_FDIST) >= 0:
        at = read_numbers(text, at, KEY_FDIST, 2, values)
        row.focus[0], row.focus[1] = values[0], values[1]
    if value_at(text, at, KEY_STAMINA) >= 0:
        at = read_numbers(text, at, KEY_STAMINA, 4, values)
        row.stamina, row.effort, row.recovery, row.capacity = values[0], values[1], values[2], values[3]
    if at >= 0 and stands(text, at, _ATTENDED) >= 0:
        other, at = read_letter(text, at, _ATTENDED, L, R)
        number, at = read_whole_value(text, at, KEY_FNUM, 1, 11)
        row.attention = 11 * other + number
    for k in range(row.counts.shape[0]):
        if value_at(text, at, KEY_COUNTS + k) >= 0:
            count, at = read_whole_value(text, at, KEY_COUNTS + k, -MOST, MOST)
            row.counts[k] = count
    return at + 1 if 0 <= at < text.shape[0] and text[at] == END else -1


@kernel
def read_show(text, ball, rows, values):
    """Read a line into `ball` (4,) and `rows` (22,) PLAYER_FRAME; its time, its stoppage or -1, where it ends or -1 for another line.

    text : (n,) uint8, copied, since a bracket is overwritten; values : (8,) to be overwritten
    """
    first = stands(text, 0, _SHOW)
    time, at = read_whole(text, first) if first >= 0 else (0, -1)
    at = ends_well(text, first, at) if 0 <= time <= MOST else -1
    stoppage = -1
    begin = stands(text, at, _STIME)
    if begin >= 0:
        stoppage, at = read_whole(text, begin)
        at = ends_well(text, begin, at) if 0 <= stoppage <= MOST else -1
    at = stands(text, at, _BALL)
    if at < 0:
        return 0, -1, -1
    text[at - 1] = COMMA  # what stands before the first name of the ball, as before the others
    at = stands(text, read_numbers(text, at - 1, KEY_X, 4, ball), _PLAYERS)
    while at >= 0 and at < text.shape[0]:
        at = read_player(text, at, rows, values)
        if at < 0 or at >= text.shape[0] or text[at] != COMMA:
            break
        at += 1
    return time, stoppage, stands(text, at, _LAST)
