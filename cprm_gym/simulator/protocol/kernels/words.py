"""Words and names as bytes, and writing them."""

from __future__ import annotations

import numpy as np

from ...kernels.digits import put_real, put_whole
from ...kernels.geometry import R2D
from ...landmarks import GOALS, LANDMARK_NAMES, LINE_NAMES
from . import kernel

BLANK, OPEN, CLOSE, QUOTE, NUL, MINUS = ord(" "), ord("("), ord(")"), ord('"'), 0, ord("-")


def coded(words: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """(n, longest) bytes and (n,) lengths of words."""
    table = np.zeros((len(words), max(map(len, words))), np.uint8)
    for row, word in zip(table, words):
        row[: len(word)] = np.frombuffer(word.encode("latin-1"), np.uint8)
    return table, np.array([len(word) for word in words])


LANDMARKS = coded(LANDMARK_NAMES)
"""Short names."""
CLOSE_LANDMARKS = coded(tuple("G" if number in GOALS else "F" for number in range(len(LANDMARK_NAMES))))
LINES = coded(LINE_NAMES)
TEXTS = coded(
    (
        "(sense_body", " (view_mode", " high", " low", " narrow", " normal", " wide", ") (stamina", ") (speed", ") (head_angle", ") (kick",
        ") (dash", ") (turn", ") (say", ") (turn_neck", ") (catch", ") (move", ") (change_view", ") (change_focus", ") (arm (movable",
        ") (expires", ") (target", ") (count", ")) (focus (target", " none", " l", " r", ")) (tackle (expires", ")) (collision", " none",
        " (ball)", " (player)", " (post)", ") (foul (charged", ") (card", " yellow", " red", ")) (focus_point", "(see", " t", " k",
        " goalie",
    )
)  # fmt: skip
"""Pieces of messages, by the numbers below."""
(
    SENSE_BODY, VIEW_MODE, HIGH, LOW, NARROW, NORMAL, WIDE, STAMINA, SPEED, HEAD_ANGLE, KICK, DASH, TURN, SAY, TURN_NECK, CATCH, MOVE,
    CHANGE_VIEW, CHANGE_FOCUS, ARM, EXPIRES, TARGET, COUNT, FOCUS, NONE, L, R, TACKLE, COLLISION, NO_COLLISION, HIT_BALL, HIT_PLAYER,
    HIT_POST, FOUL, CARD, YELLOW, RED, FOCUS_POINT, SEE, TACKLING_MARK, KICKING_MARK, GOALIE_MARK,
) = range(len(TEXTS[1]))  # fmt: skip
_TEXT, _LENGTH = TEXTS


@kernel
def put_word(out, at, table, lengths, row):
    """Write a word of a table; where the next byte goes, -1 stays -1."""
    if at < 0:
        return -1
    for k in range(lengths[row]):
        out[at + k] = table[row, k]
    return at + lengths[row]


@kernel
def put_text(out, at, number):
    """Write a piece of a message."""
    if at < 0:
        return -1
    for k in range(_LENGTH[number]):
        out[at + k] = _TEXT[number, k]
    return at + _LENGTH[number]


@kernel
def put_number(out, at, value):
    """A blank and a real; -1 for one that needs an exponent."""
    if at < 0 or not np.isfinite(value):
        return -1
    out[at] = BLANK
    return put_real(out, at + 1, value)


@kernel
def put_count(out, at, value):
    """A blank and a whole number."""
    if at < 0:
        return -1
    out[at] = BLANK
    return put_whole(out, at + 1, value)


@kernel
def put_degrees(out, at, radians):
    """A blank and an angle that is a whole number of degrees."""
    return put_count(out, at, np.int64(np.rint(radians * R2D)))
