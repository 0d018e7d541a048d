"""Tables that are one constant nearly everywhere, and something else in a narrow band.

The CPD of something that moves has in every row a few states that are likely, and in all others its floor: nine entries in ten and more
are one number f. A product with such a table is f times a sum, which costs as much as the vector is long, and a product with the band.
Nothing is approximated beyond the last digits: an entry counts as the constant if it is that up to `SAME`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

SAME = 1e-15
"""Relative difference up to which an entry is the constant: rows are scaled to sum to one, which moves the last digit."""
WIDEST = 0.4
"""Share of a table that its bands may take to be worth it."""
SMALLEST = 256
"""Entries from which on it is worth it."""


class Bands(NamedTuple):
    """A table by its rows.

    Attributes
    ----------
    constant : float
        What stands outside of the bands.
    rows : (R, 3) int64 array
        First column of the band, first column after it, and where its values stand.
    values : (V,) float array
        What the bands have beyond the constant.
    """

    constant: float
    rows: np.ndarray
    values: np.ndarray


def bands_of(table: np.ndarray) -> Bands | None:
    """The bands of a table; None where they are not narrow.

    Parameters
    ----------
    table : (R, n) float array
        Not negative.
    """
    if table.size < SMALLEST:
        return None
    constant = float(table.min())
    other = table > constant * (1.0 + SAME)
    some = other.any(axis=1)
    low = np.where(some, other.argmax(axis=1), 0)
    high = np.where(some, table.shape[1] - other[:, ::-1].argmax(axis=1), 0)
    if (high - low).sum() > WIDEST * table.size:
        return None
    column = np.arange(table.shape[1])
    inside = (column >= low[:, None]) & (column < high[:, None])
    start = np.concatenate([[0], np.cumsum(high - low)[:-1]])
    return Bands(constant, np.stack([low, high, start], axis=1).astype(np.int64), table[inside] - constant)
