"""A hash table of the rows of an array: slot 0 is empty, i + 1 is row i; its size is a power of two."""

from __future__ import annotations

import numpy as np

from ....compilation import kernel_group

kernel = kernel_group()

_MIX = np.uint64(0xD6E8FEB86659FD93)
_S32 = np.uint64(32)


@kernel
def hash_row(row):
    """64-bit hash of one row of whole numbers."""
    h = np.uint64(0x9E3779B97F4A7C15)
    for i in range(row.shape[0]):
        h = (h ^ np.uint64(row[i])) * _MIX
        h ^= h >> _S32
    return h


@kernel
def find(rows, table, row):
    """Number of a row, or -1 - slot where it belongs in the table."""
    mask = table.shape[0] - 1
    slot = np.int64(hash_row(row) & np.uint64(mask))
    while table[slot] != 0:
        i = table[slot] - 1
        equal = True
        for k in range(row.shape[0]):
            if rows[i, k] != row[k]:
                equal = False
                break
        if equal:
            return np.int64(i)
        slot = (slot + 1) & mask
    return -1 - slot


@kernel
def rehash(rows, n, table):
    """Fill an empty table with the first `n` rows."""
    for i in range(n):
        table[-1 - find(rows, table, rows[i])] = i + 1
