"""Numbers as text, as C's ``%g`` writes them, and back; bit for bit what Python's ``format`` and ``float`` do where they answer at all.

Both directions work on whole numbers below 2**53 and one exact power of ten. A product or quotient of two exact numbers is rounded once;
what the rounding hides of a product is recovered exactly (Dekker 1971), so that a tie is known from a number close to it.
"""

from __future__ import annotations

import numpy as np

from . import kernel

POWERS = np.array([10.0**k for k in range(23)])
"""All powers of ten that a double holds exactly."""
SPLIT = 134217729.0
MOST_DIGITS = 1_000_000
"""``%g`` keeps six digits."""
MINUS, POINT, ZERO, BLANK = ord("-"), ord("."), ord("0"), ord(" ")
LARGEST = 2**53


@kernel
def hidden(a, b):
    """What the rounding of the product a * b hides, exactly."""
    product = a * b
    a_high = SPLIT * a - (SPLIT * a - a)
    b_high = SPLIT * b - (SPLIT * b - b)
    a_low, b_low = a - a_high, b - b_high
    return ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low


@kernel
def put_whole(out, at, value):
    """Write a whole number from `at` on; where the next byte goes."""
    if value < 0:
        out[at] = MINUS
        at += 1
        value = -value
    size, rest = 1, value
    while rest >= 10:
        rest //= 10
        size += 1
    for i in range(at + size - 1, at - 1, -1):
        out[i] = ZERO + value % 10
        value //= 10
    return at + size


@kernel
def put_real(out, at, value):
    """Write ``%g`` of a number from `at` on (NaN as 0); where the next byte goes, or -1 for one that needs an exponent."""
    if value != value:
        out[at] = ZERO
        return at + 1
    if value < 0.0 or (value == 0.0 and np.signbit(value)):
        out[at] = MINUS
        at += 1
        value = -value
    if value == 0.0:
        out[at] = ZERO
        return at + 1
    if not 1e-4 <= value < 999999.0:
        return -1
    exponent = 5  # of the first digit
    while exponent > 0 and value < POWERS[exponent]:
        exponent -= 1
    if exponent == 0 and value < 1.0:
        exponent = -1 if value >= 0.1 else -2 if value >= 0.01 else -3 if value >= 0.001 else -4
    decimals = 5 - exponent
    scale = POWERS[decimals]
    scaled = value * scale
    digits = np.int64(scaled)
    part = scaled - digits
    error = hidden(value, scale)
    if part > 0.5 or (part == 0.5 and (error > 0.0 or (error == 0.0 and digits % 2 == 1))):
        digits += 1
    if digits == MOST_DIGITS:
        digits //= 10
        decimals -= 1
    while decimals > 0 and digits % 10 == 0:
        digits //= 10
        decimals -= 1
    whole = np.int64(POWERS[decimals])
    at = put_whole(out, at, digits // whole)
    if decimals > 0:
        out[at] = POINT
        rest = digits % whole
        for i in range(at + decimals, at, -1):
            out[i] = ZERO + rest % 10
            rest //= 10
        at += decimals + 1
    return at


@kernel
def read_whole(text, at):
    """The whole number that stands at `at`, and where it ends; (0, -1) when none stands there or it has more than ten digits."""
    negative = at < text.shape[0] and text[at] == MINUS
    first = at + 1 if negative else at
    value, end = 0, first
    while end < text.shape[0] and ZERO <= text[end] <= ZERO + 9 and end - first < 11:
        value = 10 * value + (text[end] - ZERO)
        end += 1
    if end == first or end - first > 10:
        return 0, -1
    return (-value if negative else value), end


@kernel
def read_real(text, at):
    """The number that stands at `at`, without an exponent, and where it ends; (0, -1) when `float` shall say what it is."""
    negative = at < text.shape[0] and text[at] == MINUS
    first = end = at + 1 if negative else at
    mantissa, decimals, point = 0, 0, False
    while end < text.shape[0]:
        c = text[end]
        if c == POINT and not point:
            point = True
        elif ZERO <= c <= ZERO + 9:
            if mantissa >= LARGEST // 16:
                return 0.0, -1
            mantissa = 10 * mantissa + (c - ZERO)
            decimals += point
        else:
            break
        end += 1
    if end - first - point == 0 or decimals > 22:
        return 0.0, -1
    value = mantissa / POWERS[decimals]
    return (-value if negative else value), end
