"""The 55 landmarks and four lines of the pitch, in the server's order (specification/simulator.md 6.4)."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
import numpy.typing as npt

_TABLE = """
f c 0 0|f c t 0 -34|f c b 0 34|f r t 52.5 -34|f r b 52.5 34|f l t -52.5 -34|f l b -52.5 34|f g r b 52.5 7.01|g r 52.5 0|f g r t 52.5 -7.01
|f g l b -52.5 7.01|g l -52.5 0|f g l t -52.5 -7.01|f p r b 36 20.16|f p r c 36 0|f p r t 36 -20.16|f p l b -36 20.16|f p l c -36 0
|f p l t -36 -20.16|f t 0 0 -39|f t r 10 10 -39|f t r 20 20 -39|f t r 30 30 -39|f t r 40 40 -39|f t r 50 50 -39|f t l 10 -10 -39
|f t l 20 -20 -39|f t l 30 -30 -39|f t l 40 -40 -39|f t l 50 -50 -39|f b 0 0 39|f b r 10 10 39|f b r 20 20 39|f b r 30 30 39|f b r 40 40 39
|f b r 50 50 39|f b l 10 -10 39|f b l 20 -20 39|f b l 30 -30 39|f b l 40 -40 39|f b l 50 -50 39|f r 0 57.5 0|f r t 10 57.5 -10
|f r t 20 57.5 -20|f r t 30 57.5 -30|f r b 10 57.5 10|f r b 20 57.5 20|f r b 30 57.5 30|f l 0 -57.5 0|f l t 10 -57.5 -10|f l t 20 -57.5 -20
|f l t 30 -57.5 -30|f l b 10 -57.5 10|f l b 20 -57.5 20|f l b 30 -57.5 30
"""
_ROWS = [entry.split() for entry in _TABLE.replace("\n", "").split("|")]

LANDMARK_NAMES: tuple[str, ...] = tuple(" ".join(row[:-2]) for row in _ROWS)
"""Short names as in the messages: ``f c``, ``g r``, ``f t l 10`` ..."""

LANDMARK_POSITIONS: npt.NDArray[np.float64] = np.array([[float(row[-2]), float(row[-1])] for row in _ROWS])
"""(55, 2) m. The goal flags stand at the inner edges of the goal mouth, not at the posts."""

LANDMARK_PROTOCOLS: npt.NDArray[np.int8] = np.array([4 if abs(float(x)) > 53 or abs(float(y)) > 35 else 3 for *_, x, y in _ROWS], np.int8)
"""(55,) first protocol version that sees it: 4 for the flags outside the pitch."""

GOALS: tuple[int, int] = (LANDMARK_NAMES.index("g r"), LANDMARK_NAMES.index("g l"))
"""Indices of the right and the left goal among the landmarks."""

LANDMARKS = len(LANDMARK_NAMES)


class Line(IntEnum):
    """Identity of a line in the see arrays; 0 is none."""

    NONE = 0
    LEFT = 1
    RIGHT = 2
    TOP = 3
    BOTTOM = 4


LINE_NAMES = ("", "l l", "l r", "l t", "l b")
"""Short names by `Line`."""


def landmark_index(name: str) -> int:
    """Index of a landmark by its short name.

    Raises
    ------
    UnknownName
        When there is none of that name.
    """
    from ..errors import unknown_name

    if name not in LANDMARK_NAMES:
        raise unknown_name("landmark", name, LANDMARK_NAMES)
    return LANDMARK_NAMES.index(name)
