"""Reading and executing players' datagrams in bulk: the numeric commands, in their plainest form (specification/protocol.md 4).

Whatever is out of the ordinary (words, signs, exponents, unknown commands, moves, of which players are warned) is left where it stands, for
`commands` to read; nothing of it has been executed then.
"""

from __future__ import annotations

import numpy as np

from ...kernels.commands import execute
from ...kernels.digits import POINT, ZERO, read_real
from ...state import CommandKind
from . import kernel
from .words import coded

DASH, TURN, KICK = int(CommandKind.DASH), int(CommandKind.TURN), int(CommandKind.KICK)
TACKLE, CATCH = int(CommandKind.TACKLE), int(CommandKind.CATCH)
BLANK, OPEN, CLOSE = ord(" "), ord("("), ord(")")
_WORDS, _LENGTHS = coded(("(dash ", "(turn ", "(kick ", "(catch ", "(tackle ", "(turn_neck ", "(done)"))
A_DASH, A_TURN, A_KICK, A_CATCH, A_TACKLE, A_NECK, A_DONE = range(7)
N_WORDS = 7
_KINDS = np.array([DASH, TURN, KICK, CATCH, TACKLE])


@kernel
def word_at(text, at, end):
    """Which command begins at `at`, and where its arguments do; (-1, at) for another one."""
    for k in range(N_WORDS):
        n = _LENGTHS[k]
        if at + n > end:
            continue
        same = True
        for c in range(n):
            if text[at + c] != _WORDS[k, c]:
                same = False
                break
        if same:
            return k, at + n
    return -1, at


@kernel
def number_at(text, at, end):
    """The number at `at` and where it ends, -1 when it is not plain digits, at most one point and a digit behind that."""
    if at >= end or (text[at] != ord("-") and not ZERO <= text[at] <= ZERO + 9):
        return 0.0, -1
    value, stop = read_real(text[:end], at)
    if stop < 0 or stop >= end or text[stop - 1] == POINT or (text[stop] != BLANK and text[stop] != CLOSE):
        return 0.0, -1
    return value, stop


@kernel
def read_command(text, at, end, c):
    """Read the command at `at` into the record `c`: (which, where it ends), or (-1, at)."""
    which, here = word_at(text, at, end)
    if which < 0 or which == A_DONE:
        return which, here
    first, here = number_at(text, here, end)
    if here < 0:
        return -1, at
    second, given = 0.0, False
    if text[here] == BLANK:
        if which != A_DASH and which != A_KICK:
            return -1, at
        second, here = number_at(text, here + 1, end)
        given = True
        if here < 0:
            return -1, at
    if text[here] != CLOSE or (which == A_KICK and not given):
        return -1, at
    if which == A_NECK:
        c.turn_neck = first
    else:
        c.kind, c.a, c.b = _KINDS[which], first, second
    return which, here + 1


@kernel
def execute_datagrams(worlds, parameters, rows, text, starts, ends, blank, record, reached, done):
    """Execute datagrams one after the other, up to the first that is not read to its end.

    It also stops when the referee has said something, which is to be told before anything else; nothing may be announced when it begins.

    rows : (n,) 0..21 whose they are; text : bytes of all; starts, ends : (n,) where each stands
    blank, record : (1,) COMMAND that says nothing, scratch; reached : (n,) where reading stopped; done : (n,) whether ``(done)`` was said

    Returns
    -------
    How many datagrams were dealt with, the one that was not read to its end included.
    """
    w, p = worlds[0], parameters[0]
    for n in range(rows.shape[0]):
        at, end = starts[n], ends[n]
        done[n] = False
        reached[n] = at
        while at < end:
            record[0] = blank[0]
            which, at = read_command(text, at, end, record[0])
            if which < 0:
                return n + 1
            reached[n] = at
            if which == A_DONE:
                done[n] = True
            else:
                execute(w, p, rows[n], record[0])
                if w.announced > 0:
                    return n + 1
    return rows.shape[0]
