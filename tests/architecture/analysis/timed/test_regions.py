"""Which cells can be met at once: what is said does not hang on accidents."""

from cprm_gym.architecture.analysis.timed.regions import LARGEST, Question, combinations
from cprm_gym.architecture.expressions import Expression

ANY = (-LARGEST, LARGEST)
INF = float("inf")


def answer(a, b):
    """What is found of one question, whose names are `a` and `b`."""
    larger = Expression(f"max({a}, {b})").tree
    cells = (b, ((-INF, 2.0), (2.0, INF))), ("larger", ((-INF, -1.0), (-1.0, INF)))
    found = combinations(Question(((a, ANY), (b, ANY)), (("larger", larger),), cells))
    return [(combination, tuple(point.values())) for combination, point in found.possible.items()], found.undecided


def test_what_is_found_does_not_hang_on_how_things_are_called():
    """Thresholds on a maximum were noted for one of its two names, which of them the hash of their texts decided."""
    assert all(answer(f"x{k}", f"y{k}") == answer("a", "b") for k in range(20))
