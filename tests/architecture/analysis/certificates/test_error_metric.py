"""Proofs by an error metric: proved, refuted with a point, undecided."""

import pytest

from cprm_gym.architecture.analysis.budget import Budget
from cprm_gym.architecture.analysis.certificates.error_metric import Action, ErrorMetricProof
from cprm_gym.errors import ModelError


def closing(**changes):
    """A point mass that brakes on its way to the origin: distance and speed, noise in both."""
    given = {
        "state": {"d": (0.5, 12.0), "s": (0.0, 1.0)},
        "noise": {"xi": (-0.1, 0.1)},
        "actions": (
            Action("dash", {"d": "d - (1 + xi) * clip(0.5 * d, 0.3, 0.6)", "s": "clip(0.5 * d, 0.3, 0.6)"}, "s <= 0.7"),
            Action("coast", {"d": "d - (1 + xi) * 0.4 * s", "s": "0.4 * s"}, "s > 0.6"),
        ),
        "goal": "d < 1",
        "initial": "d <= 10 and s == 0",
        "invariant": "d <= 12",
        "rank": "d",
        "falls": (0.2, 1.0),
    }
    return ErrorMetricProof(**{**given, **changes})


def test_all_obligations_are_proved():
    pytest.importorskip("z3")
    report = closing().check()
    assert report.proved
    assert len(report.obligations) == 7
    assert "coast lets the rank fall: proved" in str(report)


@pytest.mark.parametrize(
    ("changes", "obligation"),
    [
        ({"falls": (0.25, 1.0)}, "coast lets the rank fall"),
        ({"actions": (Action("back", {"d": "d + 0.4"}),)}, "back lets the rank fall"),
        ({"actions": (Action("dash", {"d": "d - 0.3"}, "s <= 0.5"),)}, "some action is always chosen"),
        ({"initial": "d <= 13", "state": {"d": (0.5, 13.0), "s": (0.0, 1.0)}}, "the start is within the invariant"),
        ({"invariant": "d <= 12 and s <= 0.55"}, "dash keeps the invariant"),
    ],
)
def test_a_broken_behaviour_is_refuted_with_a_point(changes, obligation):
    pytest.importorskip("z3")
    report = closing(**changes).check()
    assert report.proved is False
    refuted = {o.name: o for o in report.obligations if o.holds is False}
    assert obligation in refuted
    assert refuted[obligation].point


def test_boxes_alone_prove_what_leaves_them_room():
    proof = ErrorMetricProof(
        {"d": (1.0, 12.0)},
        {"xi": (-0.1, 0.1)},
        (Action("dash", {"d": "(1 - 0.4 * (1 + xi)) * d"}),),
        goal="d < 1.085",
        initial="d <= 12",
        invariant="d <= 12",
        rank="d",
        falls=(0.0, 0.75),
    )
    report = proof.check(budget=Budget(states=500))
    assert report.proved
    assert all(o.why == "" for o in report.obligations)


def test_what_a_budget_does_not_reach_is_undecided():
    tight = closing(falls=(0.2159999, 1.0))  # true only just: 0.36 of the least speed ...
    report = tight.check(budget=Budget(states=3))
    assert report.proved is None
    assert "boxes were not enough" in str(report)


def test_a_rank_that_need_not_fall_is_no_proof():
    with pytest.raises(ModelError, match="the rank falls by an amount"):
        closing(falls=(0.0, 1.0))
    with pytest.raises(ModelError, match="updates 'x'"):
        closing(actions=(Action("dash", {"x": "1"}),))
