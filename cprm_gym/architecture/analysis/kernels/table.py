"""A hash table of the rows of an array, for rows of any whole numbers.

Slots are 32-bit: the number of the row plus one in the low `bits` bits, as many bits of its hash as fit above; 0 is empty. The table has
``2 ** bits`` slots. Comparison with the stored row is exact.
"""

from __future__ import annotations

import numpy as np

from ....compilation import kernel_group

kernel = kernel_group()

_MIX_A = np.uint64(0x9E3779B97F4A7C15)
_MIX_B = np.uint64(0xD6E8FEB86659FD93)
_ONE = np.uint64(1)
_ZERO = np.uint64(0)
_S32 = np.uint64(32)


@kernel
def hash_row(rows, i):
    """64-bit hash of row `i`."""
    if rows.shape[1] == 0:
        return _MIX_A
    h = np.uint64(rows[i, 0]) * _MIX_A
    for w in range(1, rows.shape[1]):
        h = (h ^ (h >> _S32) ^ np.uint64(rows[i, w])) * _MIX_B
    h = (h ^ (h >> _S32)) * _MIX_B
    return h ^ (h >> _S32)


@kernel
def find(rows, table, bits, out, k, h):
    """Number of the row that equals row `k` of `out`, whose hash is `h`; or -1 - slot where it belongs in the table."""
    mask = (_ONE << bits) - _ONE
    tag = h >> (_S32 + bits)  # 32 - bits bits of the upper half
    slot = h & mask
    while True:
        entry = np.uint64(table[slot])
        if entry == _ZERO:
            return -1 - np.int64(slot)
        if entry >> bits == tag:
            i = np.int64(entry & mask) - 1
            equal = True
            for w in range(out.shape[1]):
                equal &= rows[i, w] == out[k, w]
            if equal:
                return i
        slot = (slot + _ONE) & mask


@kernel
def enter(table, bits, slot, h, i):
    """Write row number `i`, whose hash is `h`, into a free slot."""
    table[slot] = np.uint32(((h >> (_S32 + bits)) << bits) | np.uint64(i + 1))


@kernel
def rehash(rows, n, table, bits):
    """Fill an empty table with the first `n` rows."""
    mask = np.int64((_ONE << bits) - _ONE)
    for i in range(n):
        h = hash_row(rows, i)
        slot = np.int64(h & np.uint64(mask))
        while table[slot] != 0:
            slot = (slot + 1) & mask
        enter(table, bits, slot, h, i)
