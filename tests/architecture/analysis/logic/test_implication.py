"""Does it follow? Known verdicts, points that show that it does not."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from paths import SHARED

from cprm_gym.architecture.analysis.logic.boxes import Claim, prove
from cprm_gym.architecture.analysis.logic.implication import implies
from cprm_gym.architecture.analysis.logic.z3_terms import has_z3
from cprm_gym.architecture.expressions import Expression
from cprm_gym.errors import ExpressionError, ModelError

FILE = SHARED / "cases" / "markov" / "highlevel" / "predicates.json"
CASES = json.loads(FILE.read_text())["implications"] if FILE.is_file() else []


def ours(text):
    return text.replace("&", " and ").replace("|", " or ").replace("!a", "not a")


@pytest.mark.skipif(not CASES, reason="data of ../shared absent")
@pytest.mark.parametrize("case", CASES or [{"id": 0}], ids=lambda c: str(c["id"]))
def test_known_verdicts(case):
    first, second = ours(case["A"]), ours(case["B"])
    found = implies(first, second, case["vars"])
    if found.holds is None:
        assert not has_z3()
        return
    assert found.holds == case["implied"]
    if not found.holds:
        assert Expression(first).evaluate(found.counterexample)
        assert not Expression(second).evaluate(found.counterexample)
    assert found.vacuous == (case["id"] == 11)


bounds = st.integers(-3, 3)
atoms = st.tuples(st.sampled_from(["x", "y"]), st.sampled_from(["<", "<=", ">", ">=", "==", "!="]), bounds).map(
    lambda t: f"{t[0]} {t[1]} {t[2]}"
)
conditions = st.recursive(
    atoms,
    lambda c: st.one_of(
        st.tuples(c, st.sampled_from(["and", "or"]), c).map(lambda t: f"({t[0]}) {t[1]} ({t[2]})"), c.map("not ({})".format)
    ),
    max_leaves=5,
)


@given(conditions, conditions)
def test_cells_decide_what_a_fine_grid_decides(first, second):
    found = implies(first, second)
    a, b = Expression(first), Expression(second)
    points = [{"x": x / 4, "y": y / 4} for x in range(-16, 17) for y in range(-16, 17)]
    true = all(b.evaluate(p) for p in points if a.evaluate(p))
    assert found.holds == true
    assert found.method == "cells"


def test_without_z3_boxes_decide_where_ranges_are_given(monkeypatch):
    from cprm_gym.architecture.analysis.logic import implication

    monkeypatch.setattr(implication, "has_z3", lambda: False)
    ranges = {"x": (-2.0, 2.0), "y": (-2.0, 2.0)}
    assert implies("x * x + y * y <= 1", "x <= 1.1", ranges=ranges).holds
    wrong = implies("x * x + y * y <= 1", "x <= 0.9", ranges=ranges)
    assert wrong.holds is False
    assert wrong.counterexample["x"] > 0.9
    assert implies("x * x + y * y <= 1", "x <= 1.1").holds is None


def test_kinds_that_are_none_are_refused():
    with pytest.raises(ModelError, match="variable 'x': kind 'float'"):
        implies("x < 1", "x < 2", {"x": "float"})


def test_a_claim_needs_ranges():
    with pytest.raises(ExpressionError, match="no range for 'y'"):
        prove(Claim("sum", ("x > 0",), "x + y > 0"), {"x": (0.0, 1.0)})
