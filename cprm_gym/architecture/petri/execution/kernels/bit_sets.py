"""Sets of small numbers as bits, of which the least is found at once.

A set of numbers below n is one row of words of 32 bits: first the *tops*, whose bits say which words are not empty, then the words. The
least number is looked up in one top of every 1024 numbers and one word, so that choosing among thousands of transitions costs as much as
among ten. Words are signed and half used: so nothing overflows, compiled or not.
"""

from __future__ import annotations

import numpy as np

from .....compilation import kernel_group

inlined = kernel_group(_nrt=False, no_cpython_wrapper=True, forceinline=True)

_DE_BRUIJN = 0x077CB531  # each 5 bits of it in a row are different: multiplied by a power of two they tell which one
_PLACE = np.zeros(32, np.int64)
for _i in range(32):
    _PLACE[((1 << _i) * _DE_BRUIJN & 0xFFFFFFFF) >> 27] = _i


def tops_of(n: int) -> int:
    """Tops of a set of numbers below `n`."""
    return -(-n // 1024)


def words_of(n: int) -> int:
    """Words of a set of numbers below `n`, without its tops."""
    return -(-n // 32)


def width_of(n: int) -> int:
    """Words of a set of numbers below `n`, its tops among them."""
    return tops_of(n) + words_of(n)


@inlined
def lowest(word):
    """The place of the lowest bit of a word that is not 0."""
    return _PLACE[(((word & -word) * _DE_BRUIJN) & 0xFFFFFFFF) >> 27]


@inlined
def note(words, i):
    """Put `i` into a set without tops, which is gone through from one end to the other."""
    words[i >> 5] |= 1 << (i & 31)


@inlined
def put(bits, tops, i):
    """Put `i` into a set."""
    word = i >> 5
    bits[tops + word] |= 1 << (i & 31)
    bits[word >> 5] |= 1 << (word & 31)


@inlined
def drop(bits, tops, i):
    """Take `i` out of a set."""
    word = i >> 5
    left = bits[tops + word] & ~(1 << (i & 31))
    bits[tops + word] = left
    if left == 0:
        bits[word >> 5] &= ~(1 << (word & 31))


@inlined
def least(bits, tops):
    """The least number of a set, -1 of an empty one."""
    for k in range(tops):
        if bits[k] != 0:
            word = 32 * k + lowest(bits[k])
            return 32 * word + lowest(bits[tops + word])
    return -1


@inlined
def clear(bits):
    """Take everything out of a set."""
    for i in range(bits.shape[0]):
        bits[i] = 0
