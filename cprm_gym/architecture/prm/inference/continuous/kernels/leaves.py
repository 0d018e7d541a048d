"""One formula in one component: a number appended as a column, or a chance and what it says of the numbers it depends on."""

from __future__ import annotations

import math

import numpy as np

from ......compilation import kernel_group
from .....expressions.kernels import run
from .normals import backward, factor, forward, wrapped

kernel = kernel_group(_nrt=False)

NORMAL, FLAT, CHANCE, ROW = 0, 1, 2, 3
NONLINEAR, AFFINE, CONSTANT, SPREAD = 0, 1, 2, 3
"""How a normal depends on its columns: it bends; a straight line, by numbers that are given too; by constants; a straight line, but
its deviation depends on them."""
SLOPES_UNKNOWN = np.inf
"""Instead of an intercept: slopes depend on what is given."""
COLUMN, SLOT, GIVEN_NUMBER, GIVEN_STATE, SLOT_MIDDLE, GIVEN_MIDDLE = 0, 1, 2, 3, 4, 5
FINE, UNDEFINED, NEGATIVE, NO_CHANCE = 0, 1, 2, 3
"""What can be wrong: a formula without a value, a deviation below 0, a chance that is none."""

HERMITE_X, HERMITE_W, LEGENDRE_X, LEGENDRE_W = (
    np.ascontiguousarray(a) for a in (*np.polynomial.hermite_e.hermegauss(15), *np.polynomial.legendre.leggauss(8))
)
HERMITE_W = HERMITE_W / HERMITE_W.sum()
HERMITE_5_X, HERMITE_5_W = (np.ascontiguousarray(a) for a in np.polynomial.hermite_e.hermegauss(5))
HERMITE_5_W = HERMITE_5_W / HERMITE_5_W.sum()
HERMITE_9_X, HERMITE_9_W = (np.ascontiguousarray(a) for a in np.polynomial.hermite_e.hermegauss(9))
HERMITE_9_W = HERMITE_9_W / HERMITE_9_W.sum()
REACH, SCAN, BREAKS, PIECE = 8.0, 32, 14, 2.0
"""Deviations over which a chance with conditions is integrated, intervals in which its jumps are sought, most jumps, longest piece."""


@kernel
def fill(leaf, inputs, numbers, mean, states, hard, low, at, agent, row):
    """Values of the inputs of a formula at the mean of a component, into `row`."""
    for i in range(leaf[5]):
        kind, index = inputs[leaf[4] + i, 0], inputs[leaf[4] + i, 1]
        if kind == COLUMN:
            row[i] = mean[index]
        elif kind == SLOT:
            row[i] = states[index]
        elif kind == GIVEN_NUMBER:
            row[i] = low[at[index], agent]
        elif kind == GIVEN_STATE:
            row[i] = hard[at[index], agent]
        elif kind == SLOT_MIDDLE:
            row[i] = numbers[inputs[leaf[4] + i, 2] + states[index]]
        else:
            row[i] = numbers[inputs[leaf[4] + i, 2] + hard[at[index], agent]]


@kernel
def value_of(program, start, code, constants, row, stack):
    """Value of one formula."""
    return run(code, constants, start[program], start[program + 1], row, stack)


@kernel
def append_affine(mean, cov, n, begin, leaf, inputs, slopes, centre, noise, period):
    """Column n: ``centre`` plus slopes times how far the columns are from their means, plus noise of that variance.

    The columns before `begin` are needed no more.
    """
    d = leaf[3]
    for j in range(begin, n):
        total = 0.0
        for i in range(d):
            total += slopes[i] * cov[inputs[leaf[4] + i, 1], j]
        cov[n, j] = total
        cov[j, n] = total
    total = noise
    for i in range(d):
        total += slopes[i] * cov[n, inputs[leaf[4] + i, 1]]
    cov[n, n] = max(total, 0.0)
    mean[n] = wrapped(centre, period)


@kernel
def line_is_shared(leaf, inputs):
    """Whether a straight line and its noise are the same for every component of an agent: by what is given and its columns alone."""
    if leaf[6] != AFFINE or leaf[3] == 0:
        return False
    for i in range(leaf[3], leaf[5]):
        kind = inputs[leaf[4] + i, 0]
        if kind == SLOT or kind == SLOT_MIDDLE:
            return False
    return True


@kernel
def append_known(mean, cov, n, begin, leaf, inputs, line, period):
    """Append a number by the line that `append_normal` has noted for another component."""
    centre = line[1]
    for i in range(leaf[3]):
        centre += line[3 + i] * mean[inputs[leaf[4] + i, 1]]
    append_affine(mean, cov, n, begin, leaf, inputs, line[3:], centre, line[2], period)


@kernel
def append_normal(
    mean, cov, n, begin, leaf, inputs, numbers, start, code, constants, row, stack, period, scratch, at_mean, at_cov, turns, line
):  # fmt: skip
    """Append a number with noise as column n; inputs are in `row`, taken at the normal `at_mean`, `at_cov`. Gives what is wrong.

    A line that is the same for all components is noted in `line`: 1, intercept, variance of the noise, slopes.

    Returns
    -------
    (fault, bend)
        `bend` is the variance that a straight line does not explain, as a share of the noise.
    """
    d, first = leaf[3], leaf[7]
    slopes = scratch[0]
    for i in range(d):
        slopes[i] = numbers[first + 2 + i]
    if leaf[6] == CONSTANT:
        centre = numbers[first]
        for i in range(d):
            centre += slopes[i] * row[i]
        append_affine(mean, cov, n, begin, leaf, inputs, slopes, centre, numbers[first + 1] ** 2, period)
        return FINE, 0.0
    centre = value_of(leaf[1], start, code, constants, row, stack)
    sd = numbers[first + 1] if numbers[first + 1] >= 0.0 else value_of(leaf[2], start, code, constants, row, stack)
    if centre != centre or sd != sd:
        return UNDEFINED, 0.0
    if sd < 0.0:
        return NEGATIVE, 0.0
    if leaf[6] == NONLINEAR and d > 0:
        bend = append_by_sigma_points(
            mean, cov, n, begin, leaf, inputs, start, code, constants, row, stack, period, scratch, centre, sd, at_mean, at_cov, turns
        )
        return FINE, bend
    if numbers[first] == SLOPES_UNKNOWN:
        for i in range(d):
            x = row[i]
            row[i] = x + 1.0
            slopes[i] = value_of(leaf[1], start, code, constants, row, stack) - centre
            row[i] = x
    noise = sd * sd
    if leaf[6] == SPREAD:
        noise = mean_square(leaf, inputs, start, code, constants, row, stack, scratch, sd, at_cov)
        for i in range(d):
            c = inputs[leaf[4] + i, 1]
            centre += slopes[i] * wrapped(mean[c] - at_mean[c], turns[c])
    elif line_is_shared(leaf, inputs):
        line[0], line[1], line[2] = 1.0, centre, noise
        for i in range(d):
            line[1] -= slopes[i] * row[i]
            line[3 + i] = slopes[i]
    append_affine(mean, cov, n, begin, leaf, inputs, slopes, centre, noise, period)
    return FINE, 0.0


@kernel
def mean_square(leaf, inputs, start, code, constants, row, stack, scratch, sd, at_cov):
    """Mean of the square of a deviation, `sd` in the middle, by unscented points of the columns on which it depends."""
    d = leaf[3]
    lower, base = scratch[1 : 1 + d], scratch[1 + d]
    factor(at_cov, inputs[leaf[4] : leaf[4] + d, 1], d, lower)
    kappa = max(3.0 - d, 0.0)
    reach = math.sqrt(d + kappa)
    total = kappa * sd * sd
    for k in range(d):
        base[k] = row[k]
    for i in range(d):
        for sign in range(2):
            step = reach if sign == 0 else -reach
            for k in range(d):
                row[k] = base[k] + step * lower[k, i]
            width = value_of(leaf[2], start, code, constants, row, stack)
            total += 0.5 * (sd * sd if width != width else width * width)
    for k in range(d):
        row[k] = base[k]
    return total / (d + kappa)


@kernel
def append_by_sigma_points(
    mean, cov, n, begin, leaf, inputs, start, code, constants, row, stack, period, scratch, centre, sd, at_mean, at_cov, turns
):
    """Append a number that is no straight line of its inputs: the line through unscented points, and what is beside it."""
    d = leaf[3]
    slopes, lower, base = scratch[0], scratch[1 : 1 + d], scratch[1 + d]
    columns = inputs[leaf[4] : leaf[4] + d, 1]
    factor(at_cov, columns, d, lower)
    kappa = max(3.0 - d, 0.0)
    reach = math.sqrt(d + kappa)
    share = 0.5 / (d + kappa)
    for i in range(d):
        base[i] = row[i]
        slopes[i] = 0.0
    first, second, noise = 0.0, 0.0, (kappa / (d + kappa)) * sd * sd
    for i in range(d):
        for sign in range(2):
            step = reach if sign == 0 else -reach
            for k in range(d):
                row[k] = base[k] + step * lower[k, i]
            away = wrapped(value_of(leaf[1], start, code, constants, row, stack) - centre, period)
            width = value_of(leaf[2], start, code, constants, row, stack)
            if away != away:
                away = 0.0
            if width != width:
                width = sd
            first += share * away
            second += share * away * away
            slopes[i] += share * away * step
            noise += share * width * width
    for k in range(d):
        row[k] = base[k]
    rest = second - first * first
    for i in range(d):
        rest -= slopes[i] * slopes[i]
    backward(lower, d, slopes)
    rest = max(rest, 0.0)
    for i in range(d):
        first += slopes[i] * wrapped(mean[columns[i]] - at_mean[columns[i]], turns[columns[i]])
    append_affine(mean, cov, n, begin, leaf, inputs, slopes, centre + first, noise + rest, period)
    return rest / max(noise, 1e-300)


@kernel
def append_flat(mean, cov, n, low, high):
    """Append a number that is uniform between limits, by its first two moments."""
    for j in range(n):
        cov[n, j] = 0.0
        cov[j, n] = 0.0
    cov[n, n] = (high - low) ** 2 / 12.0
    mean[n] = 0.5 * (low + high)


@kernel
def chance_at(leaf, floor, start, code, constants, row, stack):
    """Probability of the second state; NaN where it is none."""
    p = value_of(leaf[1], start, code, constants, row, stack)
    if not (p >= 0.0 and p <= 1.0):
        return np.nan
    return p * (1.0 - floor) + 0.5 * floor


@kernel
def find_breaks(leaf, start, code, constants, row, stack, middle, sd, breaks):
    """Where conditions in a formula of one number change, in deviations, sorted into `breaks`; how many."""
    count = 0
    for c in range(leaf[9], leaf[9] + leaf[8]):
        row[0] = middle - REACH * sd
        before = value_of(c, start, code, constants, row, stack)
        for s in range(1, SCAN + 1):
            u = -REACH + 2.0 * REACH * s / SCAN
            row[0] = middle + u * sd
            now = value_of(c, start, code, constants, row, stack)
            if before == before and now == now and (before < 0.0) != (now < 0.0) and count < BREAKS:
                left, right, sign = u - 2.0 * REACH / SCAN, u, before < 0.0
                for _ in range(52):
                    half = 0.5 * (left + right)
                    row[0] = middle + half * sd
                    if (value_of(c, start, code, constants, row, stack) < 0.0) == sign:
                        left = half
                    else:
                        right = half
                at = count
                while at > 0 and breaks[at - 1] > right:
                    breaks[at] = breaks[at - 1]
                    at -= 1
                breaks[at] = right
                count += 1
            before = now
    return count


@kernel
def chance_moments(cov, leaf, inputs, numbers, start, code, constants, row, stack, scratch):
    """Moments of the chance over the numbers it depends on, in units of their factor: ``scratch[1:]`` gets E[p u] and E[p u u'].

    Gives E[p]; NaN where a chance is none. ``scratch[0]`` is left to the caller; the factor is in rows 2 + d to 2 + 2 d.
    """
    d, floor = leaf[3], numbers[leaf[7]]
    first, second, lower, base = scratch[1], scratch[2 : 2 + d], scratch[2 + d : 2 + 2 * d], scratch[2 + 2 * d]
    factor(cov, inputs[leaf[4] : leaf[4] + d, 1], d, lower)
    for i in range(d):
        base[i] = row[i]
        first[i] = 0.0
        for j in range(d):
            second[i, j] = 0.0
    total = 0.0
    if d == 1 and leaf[8] > 0:
        breaks = scratch[3 + 2 * d]
        count = find_breaks(leaf, start, code, constants, row, stack, base[0], lower[0, 0], breaks)
        left = -REACH
        for s in range(count + 1):
            right = breaks[s] if s < count else REACH
            pieces = int(math.ceil((right - left) / PIECE))
            for piece in range(pieces):
                half = 0.5 * (right - left) / pieces
                middle = left + (2 * piece + 1) * half
                for i in range(len(LEGENDRE_X)):
                    u = middle + half * LEGENDRE_X[i]
                    row[0] = base[0] + u * lower[0, 0]
                    p = chance_at(leaf, floor, start, code, constants, row, stack)
                    w = half * LEGENDRE_W[i] * math.exp(-0.5 * u * u) / math.sqrt(2.0 * math.pi)
                    total += w * p
                    first[0] += w * p * u
                    second[0, 0] += w * p * u * u
            left = right
    elif d <= 3:
        size = 15 if d <= 1 else (9 if d == 2 else 5)
        for index in range(size**d):
            rest, w = index, 1.0
            for i in range(d):
                k = rest % size
                rest //= size
                w *= HERMITE_W[k] if size == 15 else (HERMITE_9_W[k] if size == 9 else HERMITE_5_W[k])
                base[d + i] = HERMITE_X[k] if size == 15 else (HERMITE_9_X[k] if size == 9 else HERMITE_5_X[k])
            total += add_point(leaf, floor, start, code, constants, row, stack, d, lower, base, first, second, w)
    else:
        for index in range(2 * d):
            for i in range(d):
                base[d + i] = 0.0
            base[d + index // 2] = math.sqrt(d) if index % 2 == 0 else -math.sqrt(d)
            total += add_point(leaf, floor, start, code, constants, row, stack, d, lower, base, first, second, 0.5 / d)
    for i in range(d):
        row[i] = base[i]
    return total


@kernel
def add_point(leaf, floor, start, code, constants, row, stack, d, lower, base, first, second, w):
    """Add the chance at a point ``base[d:]`` to its moments; gives weight times chance."""
    for i in range(d):
        row[i] = base[i]
        for k in range(i + 1):
            row[i] += lower[i, k] * base[d + k]
    p = w * chance_at(leaf, floor, start, code, constants, row, stack)
    for i in range(d):
        first[i] += p * base[d + i]
        for j in range(d):
            second[i, j] += p * base[d + i] * base[d + j]
    return p


@kernel
def weigh(mean, cov, begin, n, leaf, inputs, total, holds, scratch, columns):
    """Condition on a two-state variable with the moments of `chance_moments` (first two moments); gives its log probability.

    columns : (d, n) scratch
    """
    d = leaf[3]
    first, second, lower = scratch[1], scratch[2 : 2 + d], scratch[2 + d : 2 + 2 * d]
    p = total if holds else 1.0 - total
    if not p > 1e-300:
        return -np.inf
    if d == 0:
        return math.log(p)
    shift = scratch[0]
    for i in range(d):
        shift[i] = (first[i] if holds else -first[i]) / p
    for j in range(begin, n):  # what a unit of each input is to each column
        for i in range(d):
            shift[d + i] = cov[inputs[leaf[4] + i, 1], j]
        forward(lower, d, shift[d : 2 * d])
        for i in range(d):
            columns[i, j] = shift[d + i]
    for i in range(d):
        for j in range(d):
            unit = 1.0 if i == j else 0.0
            spread = second[i, j] if holds else unit - second[i, j]
            change = spread / p - shift[i] * shift[j] - unit
            for a in range(begin, n):
                for b in range(begin, n):
                    cov[a, b] += columns[i, a] * change * columns[j, b]
    for a in range(begin, n):
        for i in range(d):
            mean[a] += columns[i, a] * shift[i]
        if cov[a, a] < 0.0:
            cov[a, a] = 0.0
    return math.log(p)
