"""One ``(show ...)`` line of a text log, written and read whole (specification/protocol.md 11.1).

Both answer -1 or False for a line out of the ordinary, which is left to `writer` and `text`: they are slower, and say what is wrong.
"""

from __future__ import annotations

import numpy as np

from ...kernels.digits import BLANK, MINUS, ZERO, put_real, put_whole, read_real, read_whole
from ...state import LEFT
from . import kernel

LONGEST_LINE = 1 << 15
"""Bytes of a line with 22 players and the longest numbers, generously."""
POSITION_STEP, ANGLE_STEP = 1e-4, 1e-3
"""Grids on which the server rounds metres and degrees."""
OPEN, CLOSE, X, A_DIGIT = ord("("), ord(")"), ord("x"), ord("a")
L, R, H, B, V, S, C, F, P = (ord(c) for c in "lrhbvscfp")
_SHOW, _BALL, _VIEW, _FOCUS, _ENERGY, _ATTENTION, _COUNTS, _HEX = (
    np.frombuffer(text.encode(), np.uint8).copy() for text in ("(show ", " ((b)", " (v h", " (fp", " (s", " (f l", " (c", " 0x")
)
LOWEST, HIGHEST = -(2**15), 2**15 - 1
MOST = 2**31 - 1


@kernel
def put(out, at, text):
    """Write `text` from `at` on; where the next byte goes."""
    for i in range(text.shape[0]):
        out[at + i] = text[i]
    return at + text.shape[0]


@kernel
def put_on_grid(out, at, value, step):
    """Write `value` on the grid of `step` (ties to even); where the next byte goes, or -1."""
    if np.isinf(value):
        return -1
    if value == value:
        steps = np.rint(value / step)
        value = steps * step if steps != 0.0 else np.copysign(0.0, value)
    return put_real(out, at, value)


@kernel
def put_rounded(out, at, value, step):
    """The same with a blank before it."""
    if at < 0:
        return -1
    out[at] = BLANK
    return put_on_grid(out, at + 1, value, step)


@kernel
def put_pair(out, at, pair, step):
    """Two numbers, each with a blank before it."""
    return put_rounded(out, put_rounded(out, at, pair[0], step), pair[1], step)


@kernel
def put_number(out, at, value):
    """A blank and a number that is not rounded."""
    if at < 0 or np.isinf(value):
        return -1
    out[at] = BLANK
    return put_real(out, at + 1, value)


@kernel
def put_count(out, at, value):
    """A blank and a whole number, not below zero."""
    out[at] = BLANK
    return put_whole(out, at + 1, max(value, 0))


@kernel
def put_state(out, at, state):
    """A blank and the bits of a state in hexadecimal, 0 alone for none."""
    if state == 0:
        return put_count(out, at, 0)
    at = put(out, at, _HEX)
    size, rest = 0, state
    while rest > 0:
        rest //= 16
        size += 1
    for i in range(at + size - 1, at - 1, -1):
        digit = state % 16
        out[i] = ZERO + digit if digit < 10 else A_DIGIT + digit - 10
        state //= 16
    return at + size


@kernel
def put_player(out, at, row, focus):
    """`` ((l 1) TYPE STATE ...)``; where the next byte goes, or -1."""
    out[at], out[at + 1], out[at + 2], out[at + 3] = BLANK, OPEN, OPEN, L if row.side == LEFT else R
    at = put_count(out, at + 4, row.unum)
    out[at] = CLOSE
    at = put_state(out, put_count(out, at + 1, row.type), np.int64(row.state))
    at = put_pair(out, put_pair(out, at, row.pos, POSITION_STEP), row.vel, POSITION_STEP)
    at = put_rounded(out, put_rounded(out, at, row.body, ANGLE_STEP), row.neck, ANGLE_STEP)
    if not np.isnan(row.point[0]):
        at = put_pair(out, at, row.point, POSITION_STEP)
    if at < 0:
        return -1
    at = put(out, at, _VIEW)
    if row.view_quality == 2:
        out[at - 1] = L
    at = put_rounded(out, at, row.view_width, ANGLE_STEP)
    if at < 0:
        return -1
    out[at] = CLOSE
    at += 1
    if focus:
        at = put_pair(out, put(out, at, _FOCUS), row.focus, POSITION_STEP)
        if at < 0:
            return -1
        out[at] = CLOSE
        at += 1
    at = put_number(out, put_number(out, put(out, at, _ENERGY), row.stamina), row.effort)
    at = put_number(out, put_number(out, at, row.recovery), row.capacity)
    if at < 0:
        return -1
    out[at] = CLOSE
    at += 1
    if row.attention:
        at = put(out, at, _ATTENTION)
        if row.attention > 11:
            out[at - 1] = R
        at = put_count(out, at, (row.attention - 1) % 11 + 1)
        out[at] = CLOSE
        at += 1
    at = put(out, at, _COUNTS)
    for i in range(row.counts.shape[0] if focus else row.counts.shape[0] - 1):
        at = put_count(out, at, row.counts[i])
    out[at], out[at + 1] = CLOSE, CLOSE
    return at + 2


@kernel
def write_show(time, ball, players, focus, out):
    """Write the line into `out` (LONGEST_LINE bytes); its length, or -1.

    ball : (4,) float64; players : (22,) PLAYER_FRAME; focus : whether the version has focus points and their counter
    """
    at = put_whole(out, put(out, 0, _SHOW), time)
    at = put(out, at, _BALL)
    for i in range(4):
        at = put_rounded(out, at, ball[i], POSITION_STEP)
    if at < 0:
        return -1
    out[at] = CLOSE
    at += 1
    for i in range(players.shape[0]):
        at = put_player(out, at, players[i], focus)
        if at < 0:
            return -1
    out[at], out[at + 1] = CLOSE, ord("\n")
    return at + 2


# --------------------------------------------------------------------------------------------------- reading


@kernel
def stands(text, at, what):
    """Behind `what` if it stands at `at`, else -1."""
    if at < 0 or at + what.shape[0] > text.shape[0]:
        return -1
    for i in range(what.shape[0]):
        if text[at + i] != what[i]:
            return -1
    return at + what.shape[0]


@kernel
def reals(text, at, values, most):
    """Read numbers, each with one blank before it, up to `most`; how many, and where they end, -1 for more or other ones."""
    count = 0
    while at >= 0 and at + 1 < text.shape[0] and text[at] == BLANK and text[at + 1] != OPEN:
        if count == most:
            return count, -1
        values[count], at = read_real(text, at + 1)
        count += 1
    return count, at


@kernel
def read_state(text, at):
    """A state behind a blank, ``0x1f`` or ``0``, and where it ends, or (0, -1)."""
    if at < 0 or at + 2 >= text.shape[0] or text[at] != BLANK or text[at + 1] != ZERO:
        return 0, -1
    at += 2
    if text[at] == BLANK:
        return 0, at
    if text[at] != X:
        return 0, -1
    value, first = 0, at + 1
    at = first
    while at < text.shape[0] and at - first < 9:
        c = text[at]
        if ZERO <= c <= ZERO + 9:
            value = 16 * value + (c - ZERO)
        elif A_DIGIT <= c <= A_DIGIT + 5:
            value = 16 * value + (c - A_DIGIT + 10)
        else:
            break
        at += 1
    return (value, at) if first < at <= first + 8 else (0, -1)


@kernel
def read_number(text, at):
    """Row 0 to 21 of the player ``l 1``, and where it ends; (0, -1) for no player."""
    if at < 0 or at + 2 >= text.shape[0] or (text[at] != L and text[at] != R) or text[at + 1] != BLANK:
        return 0, -1
    unum, end = read_whole(text, at + 2)
    if end < 0 or not 1 <= unum <= 11:
        return 0, -1
    return (unum - 1 if text[at] == L else unum + 10), end


@kernel
def read_part(text, at, row, values):
    """Read ``(v h 90)`` and its like into `row`; where it ends, or -1."""
    kind = text[at + 1]
    if kind == V:
        if at + 4 >= text.shape[0] or text[at + 2] != BLANK or (text[at + 3] != H and text[at + 3] != L):
            return -1
        count, end = reals(text, at + 4, values, 1)
        if count != 1:
            return -1
        row.view_quality, row.view_width = 1 if text[at + 3] == H else 2, values[0]
    elif kind == F and text[at + 2] == P:
        count, end = reals(text, at + 3, values, 2)
        if count != 2:
            return -1
        row.focus[0], row.focus[1] = values[0], values[1]
    elif kind == F:
        other, end = read_number(text, at + 3 if text[at + 2] == BLANK else -1)
        row.attention = other + 1
    elif kind == S:
        count, end = reals(text, at + 2, values, 4)
        if count < 3:
            return -1
        row.stamina, row.effort, row.recovery = values[0], values[1], values[2]
        if count == 4:
            row.capacity = values[3]
    elif kind == C:
        end, count = at + 2, 0
        while end >= 0 and end < text.shape[0] and text[end] == BLANK:
            value, end = read_whole(text, end + 1)
            if end < 0 or count == row.counts.shape[0] or not -1 <= value <= MOST:
                return -1
            row.counts[count] = value
            count += 1
    else:
        return -1
    return end + 1 if 0 <= end < text.shape[0] and text[end] == CLOSE else -1


@kernel
def read_player(text, at, rows, values):
    """Read `` ((l 1) ... )`` from behind its ``((`` into its row; where it ends, or -1."""
    number, at = read_number(text, at)
    if at < 0 or at + 1 >= text.shape[0] or text[at] != CLOSE or text[at + 1] != BLANK:
        return -1
    row = rows[number]
    kind, at = read_whole(text, at + 2)
    if at < 0 or not LOWEST <= kind <= HIGHEST:
        return -1
    state, at = read_state(text, at)
    if at < 0:
        return -1
    count, at = reals(text, at, values, 8)
    if at < 0 or (count != 6 and count != 8):
        return -1
    row.type, row.state = kind, state
    for i in range(2):
        row.pos[i], row.vel[i] = values[i], values[2 + i]
    row.body, row.neck = values[4], values[5]
    if count == 8:
        row.point[0], row.point[1] = values[6], values[7]
    while at >= 0 and at + 4 < text.shape[0] and text[at] == BLANK and text[at + 1] == OPEN:
        at = read_part(text, at + 1, row, values)
    return at + 1 if 0 <= at < text.shape[0] and text[at] == CLOSE else -1


@kernel
def read_show(text, ball, rows):
    """Read a line without its end into `ball` (4,) and `rows` (22,) PLAYER_FRAME; its time, or -1.

    text : (n,) uint8
    """
    values = np.empty(8)
    at = stands(text, 0, _SHOW)
    if at < 0 or at >= text.shape[0] or text[at] == MINUS:
        return -1
    time, at = read_whole(text, at)
    at = stands(text, at, _BALL)
    if at < 0 or time > MOST:
        return -1
    count, at = reals(text, at, values, 4)
    if count != 4 or at < 0 or at >= text.shape[0] or text[at] != CLOSE:
        return -1
    for i in range(4):
        ball[i] = values[i]
    at += 1
    while at >= 0 and at + 3 < text.shape[0] and text[at] == BLANK and text[at + 1] == OPEN and text[at + 2] == OPEN:
        at = read_player(text, at + 3, rows, values)
    return time if at >= 0 and at == text.shape[0] - 1 and text[at] == CLOSE else -1
