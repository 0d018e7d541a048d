"""Sines, cosines and roots of fractions, enclosed in fractions."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

PI_LOW, PI_HIGH = Fraction(333, 106), Fraction(355, 113)
"""Archimedes' and Zu Chongzhi's bounds: 333/106 < pi < 355/113."""
_GRAIN = 1 << 80
_TERMS = 16


def down(x: Fraction) -> Fraction:
    """Not more, with a denominator of 2**80."""
    return Fraction(x.numerator * _GRAIN // x.denominator, _GRAIN)


def up(x: Fraction) -> Fraction:
    """Not less, with a denominator of 2**80."""
    return -down(-x)


def _series(x: Fraction, first: int) -> tuple[Fraction, Fraction]:
    """Taylor's sum of sine (first = 1) or cosine (0) for 0 <= x < 4, with Lagrange's remainder."""
    square = up(x * x) if x >= 0 else x * x
    square_low = down(x * x)
    low = high = Fraction(0)
    power_low, power_high = (down(x), up(x)) if first else (Fraction(1), Fraction(1))
    factorial, k = 1, first
    for n in range(_TERMS):
        a, b = down(power_low / factorial), up(power_high / factorial)
        low, high = (low + a, high + b) if n % 2 == 0 else (low - b, high - a)
        power_low, power_high = down(power_low * square_low), up(power_high * square)
        factorial *= (k + 1) * (k + 2)
        k += 2
    rest = up(power_high / factorial)
    return low - rest, high + rest


def sine(x: Fraction) -> tuple[Fraction, Fraction]:
    """Enclosure of sin x for -4 < x < 4."""
    low, high = _series(abs(x), 1)
    return (low, high) if x >= 0 else (-high, -low)


def cosine(x: Fraction) -> tuple[Fraction, Fraction]:
    """Enclosure of cos x for -4 < x < 4."""
    return _series(abs(x), 0)


def root(x: Fraction) -> tuple[Fraction, Fraction]:
    """Enclosure of the square root of x >= 0."""
    scaled = isqrt(x.numerator * _GRAIN * _GRAIN // x.denominator)
    return Fraction(scaled, _GRAIN), Fraction(scaled + 1, _GRAIN)
