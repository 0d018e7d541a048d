"""Random numbers within kernels: each run has a state of one word, which a seed and its number give."""

from __future__ import annotations

import numpy as np

from ....compilation import kernel_group

kernel = kernel_group()

_STEP = np.uint64(0x9E3779B97F4A7C15)
_A = np.uint64(0xBF58476D1CE4E5B9)
_B = np.uint64(0x94D049BB133111EB)
_S30 = np.uint64(30)
_S27 = np.uint64(27)
_S31 = np.uint64(31)
_S11 = np.uint64(11)


@kernel
def mixed(word):
    """A word that has nothing to do with the given one (splitmix64).

    References
    ----------
    G. L. Steele, D. Lea, C. H. Flood (2014), OOPSLA, 453-472.
    """
    z = (word ^ (word >> _S30)) * _A
    z = (z ^ (z >> _S27)) * _B
    return z ^ (z >> _S31)


@kernel
def stream(key, number):
    """The state of run `number` under a key."""
    return mixed(np.uint64(key) + mixed(np.uint64(number) * _STEP + _STEP))


@kernel
def uniform(state, k):
    """A number in [0, 1) from ``state[k]``, which moves on."""
    state[k] += _STEP
    return np.float64(mixed(state[k]) >> _S11) * 2.0**-53
