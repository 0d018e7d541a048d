"""Formulas over arrays mean what the one expression language says."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cprm_gym.architecture.expressions import FUNCTIONS, Expression
from cprm_gym.architecture.prm.model.formulas import Formula
from cprm_gym.errors import CprmError, ModelError

NUMBERS = (-540.0, -3.5, -np.pi, -1.0, -0.5, 0.0, 0.3, 0.5, 1.5, 2.5, np.pi, 7.0, 180.0, 800.0)


def leaf():
    return st.sampled_from(["a", "b", "c", "0", "1", "2.5", "pi"])


def grown(inner):
    call = st.sampled_from([(f, abs(n)) for f, n in FUNCTIONS.items()]).flatmap(
        lambda f: st.lists(inner, min_size=f[1], max_size=f[1]).map(lambda args: f"{f[0]}({', '.join(args)})")
    )
    binary = st.tuples(inner, st.sampled_from(["+", "-", "*", "/", "%", "<", "<=", ">", ">=", "==", "!=", "and", "or"]), inner)
    choice = st.tuples(inner, inner, inner).map(lambda t: f"({t[0]} if {t[1]} else {t[2]})")
    return call | binary.map(lambda t: f"({' '.join(t)})") | choice | inner.map(lambda x: f"(not {x})") | inner.map(lambda x: f"-({x})")


@given(st.recursive(leaf(), grown, max_leaves=8), st.tuples(*[st.sampled_from(NUMBERS)] * 3))
def test_a_formula_and_its_expression_agree_wherever_either_is_defined(text, values):
    point = dict(zip("abc", values))
    try:
        wanted = float(Expression(text).evaluate(point))
    except CprmError:
        wanted = None
    formula = Formula(text)
    try:
        got = float(formula({n: np.array([point[n]]) for n in formula.names}, 1)[0])
    except CprmError:
        got = None
    assert (wanted is None) == (got is None)
    if wanted is not None:
        assert got == pytest.approx(wanted, rel=1e-9, abs=1e-9)


def test_a_guard_passes_over_what_has_no_value():
    x = np.array([-1.0, 0.0, 4.0])
    assert Formula("1 / x if x > 0 else 0")({"x": x}, 3).tolist() == [0.0, 0.0, 0.25]
    with pytest.raises(ModelError, match=r"has no finite value at x = -1.0"):
        Formula("sqrt(x) > 1")({"x": x}, 3)


@pytest.mark.parametrize(
    ("text", "affine"),
    [("2 * x + y", True), ("x * y", True), ("y - x / 3", True), ("x if y > 0 else -x", True), ("x * x", False), ("abs(x)", False),
     ("y / x", False), ("x if x > 0 else y", False), ("x ** 2", False), ("sin(y) * x", True)],
)  # fmt: skip
def test_straight_lines_are_recognised(text, affine):
    assert Formula(text).is_affine_in("x") is affine


def test_renamed_formulas_are_written_in_one_way():
    assert Formula("prev.a+ (prev.b)").renamed({"prev.a": "p0", "prev.b": "p1"}) == "p0 + p1"
