"""Which cells can be met at once: what is said does not hang on accidents."""

import itertools
import math

import numpy as np
import pytest

from cprm_gym.architecture.analysis.timed.regions import LARGEST, Question, combinations, evaluate
from cprm_gym.architecture.expressions import Expression
from cprm_gym.architecture.expressions.interpreter import interpret

ANY = (-LARGEST, LARGEST)
INF = float("inf")
NUMBERS = (0.0, 5e-324, 1e-200, 0.5, 1.0, 1.5, 2.5, math.pi, 7.25, 180.0, 1e16, 1e200, LARGEST)


def answer(a, b):
    """What is found of one question, whose names are `a` and `b`."""
    larger = Expression(f"max({a}, {b})").tree
    cells = (b, ((-INF, 2.0), (2.0, INF))), ("larger", ((-INF, -1.0), (-1.0, INF)))
    found = combinations(Question(((a, ANY), (b, ANY)), (("larger", larger),), cells))
    return [(combination, tuple(point.values())) for combination, point in found.possible.items()], found.undecided


def test_what_is_found_does_not_hang_on_how_things_are_called():
    """Thresholds on a maximum were noted for one of its two names, which of them the hash of their texts decided."""
    assert all(answer(f"x{k}", f"y{k}") == answer("a", "b") for k in range(20))


@pytest.mark.parametrize(
    "text",
    [
        "x + y", "x - y", "x * y", "x / y", "x % y", "x < y", "x == y", "min(x, y)", "clip(x, -1, 2)", "x and y", "x or y", "x if y else 3",
        "hypot(x, y)", "abs(x)", "sign(x)", "sqrt(x)", "floor(x)", "round(x)", "norm_angle(x)", "norm_deg(x)", "degrees(x)", "x ** 2",
    ],
)  # fmt: skip
def test_many_points_at_once_have_the_values_that_the_interpreter_gives_each(text):
    """To the last bit: squares that vanish or overflow in a `hypot` too."""
    tree, signed = Expression(text).tree, [sign * x for x in NUMBERS for sign in (1.0, -1.0)]
    points = np.array(list(itertools.product(signed, signed)))
    found = evaluate(tree, {"x": points[:, 0], "y": points[:, 1]}, len(points))
    np.testing.assert_array_equal(found, [interpret(tree, {"x": x, "y": y}) for x, y in points])


def test_a_cell_that_only_the_least_numbers_reach_is_found():
    """``d + hypot(d, d) < 0`` holds where the squares vanish, and there alone."""
    steps = (("n", Expression("d + hypot(d, d)").tree),)
    found = combinations(Question((("d", ANY),), steps, (("d", ((-INF, -1.0), (-1.0, INF))), ("n", ((-INF, 0.0), (0.0, INF))))))
    assert found.possible[2, 1] == {"d": -5e-324}
