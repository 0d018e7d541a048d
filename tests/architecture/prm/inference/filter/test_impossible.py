"""Evidence that cannot be: named, dropped, softened, begun anew, never a NaN."""

from __future__ import annotations

import numpy as np
import pytest
from inference_filters import Fixed, rotation
from inference_worlds import RandomWorld

from cprm_gym.architecture.prm.grounding.slices import GroundCPD, GroundSlice, GroundVariable
from cprm_gym.architecture.prm.inference.filter import Filter
from cprm_gym.errors import ImpossibleEvidence


def go_round(filter_: Filter, steps: int = 4) -> None:
    for t in range(steps):
        filter_.step({"pl": 0, "tok": 0, "obs": t} if t else {"pl": 0, "tok": 0})


def test_impossible_evidence_names_a_smallest_conflict_and_leaves_the_belief():
    filter_ = Filter(rotation(), batch=2)
    go_round(filter_)
    before = filter_.state.belief
    with pytest.raises(ImpossibleEvidence, match="obs = 3") as caught:
        filter_.step({"pl": 0, "tok": 0, "obs": [0, 3]})
    assert caught.value.conflict == ("obs",)
    assert caught.value.agents == (1,)
    assert caught.value.step == 4
    assert filter_.state.belief is before
    np.testing.assert_allclose(filter_.step({"pl": 0, "tok": 0, "obs": [0, 1]})["pos"], [[1, 0, 0, 0], [1, 0, 0, 0]])


def test_a_conflict_of_two_readings_names_both():
    x = GroundVariable("x", ("0", "1"))
    names = {"x": x, "a": GroundVariable("a", ("0", "1")), "b": GroundVariable("b", ("0", "1")), "c": GroundVariable("c", ("0", "1"))}
    copy = np.eye(2)
    cpds = (
        GroundCPD("x", (), np.array([0.5, 0.5]), 0),
        *(GroundCPD(n, (("x", 0),), copy if n != "c" else copy * 0 + 0.5, n) for n in "abc"),
    )
    slice_ = GroundSlice(names, cpds)
    with pytest.raises(ImpossibleEvidence) as caught:
        Filter(Fixed(slice_, slice_)).step({"a": 0, "b": 1, "c": 1})
    assert set(caught.value.conflict) == {"a", "b"}


def test_impossible_readings_are_dropped():
    filter_ = Filter(rotation(), batch=3, on_impossible="drop")
    go_round(filter_)
    result = filter_.step({"pl": 0, "tok": 0, "obs": [0, 3, 1]})
    np.testing.assert_allclose(result["pos"], [[1, 0, 0, 0]] * 3)
    np.testing.assert_array_equal(result.impossible, [False, True, False])
    np.testing.assert_array_equal(filter_.impossible_count, [0, 1, 0])
    assert np.isfinite(result.log_likelihood).all()


def test_impossible_readings_are_softened():
    filter_ = Filter(rotation(), batch=2, on_impossible="soften", eps=1e-3)
    go_round(filter_)
    before = filter_.log_likelihood[1]
    result = filter_.step({"pl": 0, "tok": 0, "obs": [0, 3]})
    np.testing.assert_allclose(result["pos"], [[1, 0, 0, 0]] * 2)
    assert result.increment[1] == pytest.approx(np.log(1 / 6 * 1e-3 / 4))
    assert before + result.increment[1] == pytest.approx(result.log_likelihood[1])


def test_impossible_readings_restart_the_agent_from_the_prior():
    filter_ = Filter(rotation(), batch=2, on_impossible="restart")
    go_round(filter_, 2)
    result = filter_.step({"pl": 0, "tok": 0, "obs": [2, 1]})
    fresh = Filter(rotation())
    expected = fresh.step({"pl": 0, "tok": 0, "obs": 1})
    np.testing.assert_allclose(result["pos"], [[0, 0, 1, 0], expected["pos"][0]])
    np.testing.assert_allclose(expected["pos"][0], [1 / 3, 2 / 3, 0, 0])
    follow = filter_.step({"pl": 0, "tok": 0, "obs": [3, 2]})
    np.testing.assert_allclose(follow["pos"], [[0, 0, 0, 1], fresh.step({"pl": 0, "tok": 0, "obs": 2})["pos"][0]])
    assert filter_.impossible_count.tolist() == [0, 1]


def test_a_restart_with_readings_that_even_the_prior_excludes_goes_without_them():
    filter_ = Filter(rotation(), batch=2, on_impossible="restart")
    go_round(filter_)
    result = filter_.step({"pl": 0, "tok": 0, "obs": [0, 3]})
    np.testing.assert_allclose(result["pos"][1], [0.5, 0.5, 0, 0])
    assert np.isfinite(result.log_likelihood).all()


@pytest.mark.parametrize("policy", ["drop", "soften", "restart"])
@pytest.mark.parametrize("seed", range(4))
def test_no_policy_ever_gives_a_nan(policy, seed):
    world = RandomWorld(seed, zeros=0.45)
    rng = np.random.default_rng(seed)
    filter_ = Filter(world, batch=3, on_impossible=policy)
    for t in range(6):
        evidence = {
            n: rng.integers(0, v.card, 3) for n, v in world.ground(first=t == 0).variables.items() if n in world.given or rng.random() < 0.6
        }
        result = filter_.step(evidence)
        assert np.isfinite(result.log_likelihood).all()
        for name in result:
            np.testing.assert_allclose(result[name].sum(axis=1), 1.0, atol=1e-9)
