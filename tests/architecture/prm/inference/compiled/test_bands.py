"""Tables of one constant and a band, and eight rows at a time: the same numbers as row by row with whole tables."""

import numpy as np
import pytest

from cprm_gym.architecture.prm.inference.compiled.bands import bands_of
from cprm_gym.architecture.prm.inference.compiled.kernels import BAND_ROWS, BAND_SUM, KIND
from cprm_gym.architecture.prm.inference.compiled.lanes import kernels as lanes
from cprm_gym.architecture.prm.inference.compiled.operations import Builder, MessageFactor, PlanSpec, TableFactor
from cprm_gym.architecture.prm.inference.compiled.plans import compile_plan
from cprm_gym.architecture.prm.model.integration import with_floor

PLACES, SPEEDS, TURNS = 24, 17, 3
"""States of a place, of a speed, and of something given that moves the place."""


def moving(rng: np.random.Generator, *shape: int) -> np.ndarray:
    """P(place after | ..., place before): within two of where it was or is moved to, and a floor."""
    table = np.zeros((*shape, PLACES, PLACES))
    for index in np.ndindex(*shape, PLACES):
        centre = (index[-1] + sum(index[:-1])) % PLACES
        for off in range(-2, 3):
            if 0 <= centre + off < PLACES:
                table[(*index, centre + off)] += rng.random()
    return with_floor(table / table.sum(axis=-1, keepdims=True), 5e-4)


def case(rng):
    """A belief in place and speed, carried on: the place moves by the speed and by what is given, the speed is drawn to the middle."""
    place = np.moveaxis(moving(rng, TURNS, SPEEDS), 2, 1)  # given, place, speed, place after
    speed = np.zeros((SPEEDS, SPEEDS))
    for v in range(SPEEDS):
        speed[v, max(v - 1, 0) : v + 2] += rng.random()
    speed = with_floor(speed / speed.sum(axis=-1, keepdims=True), 5e-3)
    seen = moving(rng)
    # nodes: 0 place before, 1 speed before, 2 place, 3 speed; columns: 0 given, 1 seen place
    factors = (
        MessageFactor((1, 0), 0), TableFactor(0, (-1, 0, 1, 2)), TableFactor(1, (1, 3)), TableFactor(2, (2, -2), missing=1),
    )  # fmt: skip
    spec = PlanSpec((PLACES, SPEEDS, PLACES, SPEEDS), (True, True, False, False), factors, 2)
    return spec, {0: place, 1: speed, 2: seen}


def arguments(rng, batch):
    """What `Plan.run` takes: messages, and readings of which some are missing."""
    message = rng.random((batch, SPEEDS * PLACES)) * (rng.random((batch, SPEEDS * PLACES)) < 0.6)
    evidence = np.stack([rng.integers(0, TURNS, batch), rng.integers(-1, PLACES, batch)])
    columns = np.array([[[0, 0, 0], [1, 0, PLACES]]])
    return message, columns, evidence, evidence, np.zeros((batch, 0)), np.zeros((1, 0, 3), np.int64)


def by_hand(tables, message, evidence):
    """The joint of place and speed after, one agent after the other, by whole tables."""
    out = []
    for row, (given, seen) in zip(message, evidence.T):
        before = row.reshape(SPEEDS, PLACES)
        after = np.einsum("vx,xvy,vw->wy", before, tables[0][given], tables[1])
        out.append(after * (tables[2][:, seen] if seen >= 0 else 1.0))
    return np.array(out)


def relative(a, b):
    return float((np.abs(a - b) / np.maximum(np.abs(b), 1e-300)).max())


@pytest.mark.parametrize("in_lanes", [True, False])
def test_products_with_bands_are_those_with_whole_tables(monkeypatch, in_lanes):
    monkeypatch.setattr(lanes, "LARGEST", lanes.LARGEST if in_lanes else -1)
    rng = np.random.default_rng(5)
    spec, tables = case(rng)
    plan = compile_plan(spec, tables)
    assert plan.in_lanes == in_lanes
    assert {BAND_ROWS, BAND_SUM} <= set(plan.ops[:, KIND].tolist())
    given = arguments(rng, 21)
    _, marginals, sums, _ = plan.run(*given)
    joint = by_hand(tables, given[0], given[2])
    assert relative(sums.prod(axis=1), joint.sum(axis=(1, 2))) < 1e-13
    joint /= joint.sum(axis=(1, 2), keepdims=True)
    for node, axis in ((2, 1), (3, 2)):
        column, card = plan.marginals[node]
        assert relative(marginals[:, column : column + card], joint.sum(axis=axis)) < 1e-13


@pytest.mark.parametrize("in_lanes", [True, False])
def test_bands_change_the_last_digits_only(monkeypatch, in_lanes):
    monkeypatch.setattr(lanes, "LARGEST", lanes.LARGEST if in_lanes else -1)
    rng = np.random.default_rng(6)
    spec, tables = case(rng)
    banded = compile_plan(spec, tables)
    monkeypatch.setattr(Builder, "by_bands", lambda *_: False)
    whole = compile_plan(spec, tables)
    assert len(banded.band_values) > 0
    assert len(whole.band_values) == 0
    assert banded.cost.flops == whole.cost.flops  # what is projected does not hang on it
    given = arguments(rng, 40)
    for a, b in zip(banded.run(*given), whole.run(*given)):
        assert a.size == 0 or relative(a, b) < 1e-14


def test_an_agent_gets_the_same_answer_bit_by_bit_whoever_stands_beside_him():
    rng = np.random.default_rng(7)
    plan = compile_plan(*case(rng))
    assert plan.in_lanes
    message, columns, evidence, _, soft, at = arguments(rng, 19)
    together = plan.run(message, columns, evidence, evidence, soft, at)
    for first, last in ((0, 1), (3, 8), (2, 10), (7, 19)):
        part = np.ascontiguousarray(evidence[:, first:last])
        some = plan.run(message[first:last], columns, part, part, soft[first:last], at)
        for a, b in zip(some, together):
            assert a.tobytes() == np.ascontiguousarray(b[first:last]).tobytes()


def test_bands_give_the_table_back():
    rng = np.random.default_rng(8)
    table = moving(rng)
    found = bands_of(table)
    again = np.full(table.shape, found.constant)
    for row, (low, high, at) in zip(again, found.rows.tolist()):
        row[low:high] += found.values[at : at + high - low]
    np.testing.assert_allclose(again, table, rtol=2e-15)
    assert len(found.values) < 0.25 * table.size


def test_a_table_without_a_narrow_band_is_left_whole():
    rng = np.random.default_rng(9)
    assert bands_of(rng.random((20, 20))) is None
    assert bands_of(np.eye(4)) is None
