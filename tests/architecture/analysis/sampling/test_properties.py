"""Formulas of finite runs: their meaning against the definition, robustness, words that are refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cprm_gym.architecture.analysis.sampling.properties import Property
from cprm_gym.errors import ExpressionError

A, B = "a > 0", "b > 0"


def brute(f, run, t):
    """The definition, cycle by cycle; `f` is nested tuples."""
    op, n = f[0], len(run["a"])
    if op in "ab":
        return run[op][t] > 0
    if op == "!":
        return not brute(f[1], run, t)
    if op == "&":
        return brute(f[1], run, t) and brute(f[2], run, t)
    if op == "|":
        return brute(f[1], run, t) or brute(f[2], run, t)
    if op == "X":
        return t + 1 < n and brute(f[1], run, t + 1)
    if op == "N":
        return t + 1 >= n or brute(f[1], run, t + 1)
    low, high = f[-1]
    window = range(t + low, min(n - 1, t + high) + 1)
    if op == "F":
        return any(brute(f[1], run, k) for k in window)
    if op == "G":
        return all(brute(f[1], run, k) for k in window)
    if op == "U":
        return any(brute(f[2], run, k) and all(brute(f[1], run, j) for j in range(t, k)) for k in window)
    if op == "W":
        return brute(("U", f[1], f[2], (0, n)), run, t) or all(brute(f[1], run, k) for k in range(t, n))
    assert op == "R"
    return all(brute(f[2], run, k) or any(brute(f[1], run, j) for j in range(t, k)) for k in range(t, n))


def written(f):
    op = f[0]
    if op in "ab":
        return f"{op} > 0"
    if op in "!XN":
        return f"{op} ({written(f[1])})"
    if op in "&|WR":
        return f"({written(f[1])}) {op} ({written(f[2])})"
    window = f"[{f[-1][0]},{f[-1][1]}]"
    if op in "FG":
        return f"{op}{window} ({written(f[1])})"
    return f"({written(f[1])}) U{window} ({written(f[2])})"


windows = st.tuples(st.integers(0, 3), st.integers(0, 9)).map(lambda w: (w[0], w[0] + w[1]))
formulas = st.recursive(
    st.sampled_from([("a",), ("b",)]),
    lambda f: st.one_of(
        st.tuples(st.sampled_from("!XN"), f),
        st.tuples(st.sampled_from("&|"), f, f),
        st.tuples(st.sampled_from("WR"), f, f, st.just((0, 99))),
        st.tuples(st.sampled_from("FG"), f, windows),
        st.tuples(st.just("U"), f, f, windows),
    ),
    max_leaves=6,
)
runs = st.lists(st.tuples(st.integers(-3, 3), st.integers(-3, 3)), min_size=1, max_size=7)


@given(formulas, runs)
def test_a_formula_means_what_its_definition_says(f, rows):
    run = {"a": np.array([r[0] for r in rows], float), "b": np.array([r[1] for r in rows], float)}
    what = Property(written(f))
    assert what.holds(run) == brute(f, run, 0)
    margin = what.robustness(run)
    if margin != 0:
        assert (margin > 0) == what.holds(run)


@given(formulas, runs, st.integers(0, 100))
def test_less_than_the_robustness_changes_no_answer(f, rows, seed):
    run = {"a": np.array([r[0] for r in rows], float), "b": np.array([r[1] for r in rows], float)}
    what = Property(written(f))
    margin = abs(what.robustness(run))
    shift = np.random.default_rng(seed).uniform(-1, 1, (2, len(rows))) * min(margin, 1e6) * 0.99
    moved = {"a": run["a"] + shift[0], "b": run["b"] + shift[1]}
    if margin > 0:
        assert what.holds(moved) == what.holds(run)


RUN = {"ball.distance": np.array([3.0, 2.0, 0.9, 0.9]), "speed": np.array([0.2, 1.0, 0.8, 0.0]), "kicked": np.array([0.0, 0.0, 0.0, 1.0])}


@pytest.mark.parametrize(
    ("text", "holds", "margin"),
    [
        ("F ball.distance < 1", True, 0.1),
        ("F[0,1] ball.distance < 1", False, -1.0),
        ("G speed <= 1.05", True, 0.05),
        ("G (speed <= 1.05 & ball.distance > 0.5)", True, 0.05),
        ("ball.distance >= 1 U kicked", False, -0.1),
        ("(ball.distance + speed) > 1 U ball.distance < 1", True, 0.1),
        ("G (kicked -> speed < 0.1)", True, 0.1),
        ("!F kicked", False, -np.inf),
        ("X X X kicked", True, np.inf),
        ("X X X X kicked", False, -np.inf),
        ("N N N N kicked", True, np.inf),
        ("speed > 0.1 and ball.distance > 2.5 | kicked", True, 0.1),
        ("F[2,inf] (speed == 0)", True, 0.0),
        ("speed != 0.2 W kicked", False, 0.0),
    ],
)
def test_examples(text, holds, margin):
    what = Property(text)
    assert what.holds(RUN) == holds
    assert what.robustness(RUN) == pytest.approx(margin, abs=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "a property is text"),
        ("F", "column 2: an expression is missing"),
        ("F (speed < 1", "a closing parenthesis is missing"),
        ("speed < 1 & ", "an expression is missing"),
        ("speed <", "column 1"),
        ("F[3,1] speed < 1", r"window \[3, 1\] is empty"),
        ("speed < 1)", "something follows"),
        ("!" * 200 + "kicked", "nested up to"),
        ("__import__('os')", "column 1"),
    ],
)
def test_what_is_no_formula_is_refused_with_its_place(text, message):
    with pytest.raises(ExpressionError, match=message):
        Property(text)


def test_signals_must_be_there_and_of_one_length():
    with pytest.raises(ExpressionError, match=r"no signal 'sped'. Did you mean 'speed'"):
        Property("F sped > 1").holds(RUN)
    with pytest.raises(ExpressionError, match="of one length"):
        Property("a > b").holds({"a": np.zeros(2), "b": np.zeros(3)})
    with pytest.raises(ExpressionError, match="from 1"):
        Property("a > 0").holds({"a": np.zeros(0)})
    assert Property("F ball.distance < speed").names == ("ball.distance", "speed")
