"""sense_body of many players at once (specification/protocol.md 5.4)."""

from __future__ import annotations

import numpy as np

from ...kernels import body
from ...kernels.geometry import R2D
from ...state import Count, PlayerBit
from . import kernel, words
from .words import put_count, put_degrees, put_number, put_text

_YELLOW, _RED = int(PlayerBit.YELLOW_CARD), int(PlayerBit.RED_CARD)
N_KICK, N_DASH, N_TURN, N_SAY, N_NECK = int(Count.KICK), int(Count.DASH), int(Count.TURN), int(Count.SAY), int(Count.TURN_NECK)
N_CATCH, N_MOVE, N_VIEW, N_FOCUS = int(Count.CATCH), int(Count.MOVE), int(Count.CHANGE_VIEW), int(Count.CHANGE_FOCUS)
N_ARM, N_ATTENTION, N_TACKLE = int(Count.ARM), int(Count.ATTENTION), int(Count.TACKLE)


@kernel
def put_counted(out, at, text, value):
    """A piece of text and a count."""
    return put_count(out, put_text(out, at, text), value)


@kernel
def put_counts(w, i, v, out, at):
    """What the player has done so far."""
    counts = w.counts[i]
    at = put_counted(out, at, words.KICK, counts[N_KICK])
    at = put_counted(out, at, words.DASH, counts[N_DASH])
    at = put_counted(out, at, words.TURN, counts[N_TURN])
    at = put_counted(out, at, words.SAY, counts[N_SAY])
    if v >= 5:
        at = put_counted(out, at, words.TURN_NECK, counts[N_NECK])
    if v >= 7:
        at = put_counted(out, at, words.CATCH, counts[N_CATCH])
        at = put_counted(out, at, words.MOVE, counts[N_MOVE])
        at = put_counted(out, at, words.CHANGE_VIEW, counts[N_VIEW])
    if v >= 18:
        at = put_counted(out, at, words.CHANGE_FOCUS, counts[N_FOCUS])
    return at


@kernel
def put_arm(w, i, row, out, at):
    """Arm, attention and tackle, of clients from version 8 on."""
    counts = w.counts[i]
    at = put_counted(out, at, words.ARM, np.int64(row[body.ARM_MOVABLE]))
    at = put_counted(out, at, words.EXPIRES, np.int64(row[body.ARM_EXPIRES]))
    at = put_number(out, put_text(out, at, words.TARGET), row[body.ARM_DISTANCE])
    at = put_degrees(out, at, row[body.ARM_DIRECTION])
    at = put_counted(out, at, words.COUNT, counts[N_ARM])
    at = put_text(out, at, words.FOCUS)
    target = w.attention[i]
    if target == 0:
        at = put_text(out, at, words.NONE)
    else:
        at = put_count(out, put_text(out, at, words.L if target <= 11 else words.R), (target - 1) % 11 + 1)
    at = put_counted(out, at, words.COUNT, counts[N_ATTENTION])
    at = put_counted(out, at, words.TACKLE, w.tackle_cycles[i])
    return put_counted(out, at, words.COUNT, counts[N_TACKLE])


@kernel
def put_hits(row, out, at):
    """What the player ran into."""
    at = put_text(out, at, words.COLLISION)
    if row[body.HIT_BALL] == 0.0 and row[body.HIT_PLAYER] == 0.0 and row[body.HIT_POST] == 0.0:
        return put_text(out, at, words.NO_COLLISION)
    if row[body.HIT_BALL] != 0.0:
        at = put_text(out, at, words.HIT_BALL)
    if row[body.HIT_PLAYER] != 0.0:
        at = put_text(out, at, words.HIT_PLAYER)
    if row[body.HIT_POST] != 0.0:
        at = put_text(out, at, words.HIT_POST)
    return at


@kernel
def put_body(w, p, i, v, row, out, at):
    """The message of player `i` for version `v`, with its NUL; where the next byte goes, -1 when a number needs an exponent."""
    body.sense_body(w, p, i, row)
    at = put_text(out, at, words.SENSE_BODY)
    at = put_count(out, at, w.time)
    at = put_text(out, put_text(out, at, words.VIEW_MODE), words.LOW if w.view_quality[i] == 2 else words.HIGH)
    at = put_text(out, at, words.NARROW + w.view_width[i] - 1)
    at = put_number(out, put_number(out, put_text(out, at, words.STAMINA), row[body.STAMINA]), row[body.EFFORT])
    if v >= 13:
        at = put_number(out, at, row[body.CAPACITY])
    at = put_number(out, put_text(out, at, words.SPEED), row[body.SPEED])
    if v >= 6:
        at = put_degrees(out, at, row[body.SPEED_DIRECTION])
    if v >= 5:
        at = put_degrees(out, put_text(out, at, words.HEAD_ANGLE), row[body.HEAD_ANGLE])
    at = put_counts(w, i, v, out, at)
    if v >= 8:
        at = put_arm(w, i, row, out, at)
    if v >= 12:
        at = put_hits(row, out, at)
    if v >= 14:
        at = put_counted(out, at, words.FOUL, w.foul_cycles[i])
        at = put_text(out, at, words.CARD)
        bits = w.bits[i]
        at = put_text(out, at, words.RED if bits & _RED else words.YELLOW if bits & _YELLOW else words.NONE)
    if v >= 18:
        at = put_number(out, put_text(out, at, words.FOCUS_POINT), row[body.FOCUS_DISTANCE])
        at = put_number(out, at, row[body.FOCUS_DIRECTION] * R2D)
    if at < 0:
        return -1
    for _ in range(3 if 14 <= v < 18 or 8 <= v < 12 else 2):
        out[at] = words.CLOSE
        at += 1
    out[at] = words.NUL
    return at + 1


@kernel
def tell_bodies(worlds, parameters, rows, newest, row, out, ends):
    """sense_body of the players `rows` of world 0, one after the other, each with its NUL.

    rows : (n,) 0..21; newest : version of those without one; row : (COLUMNS,) scratch
    out : bytes; ends : (n,) where each message ends, -1 for one that `messages` has to write
    """
    w, p, at = worlds[0], parameters[0], 0
    for n in range(rows.shape[0]):
        i = rows[n]
        v = w.protocol[i] if w.protocol[i] > 0 else newest
        end = put_body(w, p, i, v, row, out, at)
        ends[n] = end
        if end >= 0:
            at = end
