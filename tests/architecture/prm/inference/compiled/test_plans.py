"""Join trees, plans and the kernels that run them."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from inference_worlds import table

from cprm_gym.architecture.prm.inference.bayes_net import JunctionTree
from cprm_gym.architecture.prm.inference.compiled import kernels
from cprm_gym.architecture.prm.inference.compiled.lanes import kernels as lanes
from cprm_gym.architecture.prm.inference.compiled.operations import Builder, MessageFactor, PlanSpec, SoftFactor, TableFactor, merge_loops
from cprm_gym.architecture.prm.inference.compiled.plans import compile_plan, structure_cost
from cprm_gym.architecture.prm.inference.factors import Factor, contract_all
from cprm_gym.architecture.prm.inference.join_tree import connected, join_tree

SCOPES = st.lists(st.sets(st.integers(0, 7), min_size=1, max_size=4), min_size=1, max_size=8)


@given(SCOPES)
def test_a_join_tree_holds_every_scope_and_keeps_each_variable_connected(scopes):
    cards = dict.fromkeys(range(8), 2)
    tree = join_tree(scopes, cards)
    assert all(any(clique >= scope for clique in tree.cliques) for scope in scopes)
    assert all(parent < i for i, parent in enumerate(tree.parents))
    for v in set().union(*scopes):
        inside = [i for i, clique in enumerate(tree.cliques) if v in clique]
        tops = [i for i in inside if tree.parents[i] not in inside]
        assert len(tops) == 1


@given(SCOPES)
def test_components_share_no_variable_and_cannot_be_divided(scopes):
    groups = connected(scopes)
    assert sorted(i for group in groups for i in group) == list(range(len(scopes)))
    unions = [set().union(*(scopes[i] for i in group)) for group in groups]
    assert all(not a & b for a, b in itertools.combinations(unions, 2))


@given(st.integers(0, 10_000))
def test_a_plan_gives_marginals_message_and_sum_of_the_product(seed):
    """Any factors, any of the variables in the past: against one big sum."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 6))
    cards = tuple(int(c) for c in rng.integers(2, 4, count))
    past = tuple(bool(b) for b in rng.random(count) < 0.4)
    tables, factors, arrays, message = {}, [], [], []
    column = 0
    for k in range(int(rng.integers(count, count + 4))):
        scope = tuple(int(v) for v in rng.permutation(count)[: rng.integers(1, min(count, 3) + 1)])
        array = rng.random([cards[v] for v in scope]) * (rng.random([cards[v] for v in scope]) > 0.2) + 1e-3
        if rng.random() < 0.5:
            tables[k] = array
            factors.append(TableFactor(k, scope))
        else:
            factors.append(MessageFactor(scope, column))
            message.append(array.ravel())
            column += array.size
        arrays.append((array, scope))
    for v in range(count):
        if not any(v in scope for _, scope in arrays):
            tables[100 + v] = np.full(cards[v], 0.5)
            factors.append(TableFactor(100 + v, (v,)))
            arrays.append((tables[100 + v], (v,)))
    weight = rng.random(cards[0])
    factors.append(SoftFactor(0, 0))
    arrays.append((weight, (0,)))
    plan = compile_plan(PlanSpec(cards, past, tuple(factors), 0), tables)
    incoming = np.concatenate([*message, np.zeros(0)])[None, :]
    none = np.zeros((1, 0, 3), np.int64)
    hard = np.zeros((0, 1), np.int64)
    places = np.array([[[0, plan.soft_places[0][1], plan.soft_places[0][0]]]])
    new, found, sums, _ = plan.run(incoming, none, hard, hard, weight[None, :], places)
    operands = [x for array, scope in arrays for x in (array, list(scope))]
    total = np.einsum(*operands, [])
    assert np.prod(sums[0]) == pytest.approx(total, rel=1e-10)
    present = [v for v in range(count) if not past[v]]
    for v in present:
        at, card = plan.marginals[v]
        np.testing.assert_allclose(found[0, at : at + card], np.einsum(*operands, [v]) / total, atol=1e-12)
    if present:
        kept = [
            Factor(f.scope, new[:, f.column : f.column + f.size].reshape(1, *(cards[v] for v in f.scope))) for p in plan.pieces for f in p
        ]
        joint = contract_all(kept, present).table[0]
        np.testing.assert_allclose(joint, np.einsum(*operands, present) / total, atol=1e-12)


def test_an_observed_variable_moves_the_address_and_a_missing_reading_is_a_row_of_ones():
    rng = np.random.default_rng(0)
    prior, sense = table(rng, (4,)), table(rng, (2, 4, 3))
    spec = PlanSpec((4,), (False,), (TableFactor(0, (0,)), TableFactor(1, (-1, 0, -2), missing=2)), 2)
    plan = compile_plan(spec, {0: prior, 1: sense})
    columns = np.array([[[0, 0, 0], [1, 0, 3]]])
    evidence = np.array([[0, 1, 1], [2, 0, -1]])
    empty = np.zeros((3, 0))
    _, found, sums, _ = plan.run(empty, columns, evidence, evidence, empty, np.zeros((1, 0, 3), np.int64))
    for w, (s, o) in enumerate(evidence.T):
        product = prior * (sense[s, :, o] if o >= 0 else 1.0)
        assert sums[w, 0] == pytest.approx(product.sum())
        np.testing.assert_allclose(found[w], product / product.sum(), atol=1e-14)


@pytest.mark.parametrize("module", [kernels, lanes])
def test_compiled_and_python_kernels_agree(monkeypatch, module):
    monkeypatch.setattr(lanes, "LARGEST", -1 if module is kernels else lanes.LARGEST)
    rng = np.random.default_rng(1)
    cards = (3, 3, 4, 2)
    tables = {0: table(rng, (3, 4, 3)), 1: table(rng, (3, 2)), 2: table(rng, (3, 2, 4))}
    factors = (MessageFactor((0,), 0), TableFactor(0, (0, 2, 1)), TableFactor(1, (1, 3)), TableFactor(2, (0, 3, 2)))
    plan = compile_plan(PlanSpec(cards, (True, False, False, False), factors, 0, clusters=((1,), (2, 3))), tables)
    arguments = (
        rng.random((5, 3)),
        np.zeros((1, 0, 3), np.int64),
        np.zeros((0, 5), np.int64),
        np.zeros((0, 5), np.int64),
        np.ones((5, 0)),
        np.zeros((1, 0, 3), np.int64),
    )
    compiled = plan.run(*arguments)
    for name, found in list(vars(module).items()):
        monkeypatch.setattr(module, name, getattr(found, "py_func", found))
    interpreted = plan.run(*arguments)
    for mine, theirs in zip(compiled, interpreted):
        np.testing.assert_allclose(mine, theirs, atol=1e-13)


def test_the_loss_of_clusters_is_the_divergence():
    rng = np.random.default_rng(2)
    joint = rng.random((3, 2, 4))
    joint /= joint.sum()
    spec = PlanSpec((3, 2, 4), (False,) * 3, (MessageFactor((0, 1, 2), 0),), 0, clusters=((0, 2), (1,)))
    plan = compile_plan(spec, {})
    none, hard = np.zeros((1, 0, 3), np.int64), np.zeros((0, 1), np.int64)
    message, _, _, loss = plan.run(joint.reshape(1, -1), none, hard, hard, np.ones((1, 0)), none)
    pair, single = joint.sum(axis=1), joint.sum(axis=(0, 2))
    assert loss[0, 0] == pytest.approx((joint * np.log(joint / (pair[:, None, :] * single[None, :, None]))).sum())
    np.testing.assert_allclose(message[0, :12].reshape(3, 4), pair, atol=1e-14)
    np.testing.assert_allclose(message[0, 12:], single, atol=1e-14)


def test_memory_of_tables_that_are_no_longer_needed_is_used_again():
    size = 6
    factors = [MessageFactor((0,), 0)] + [TableFactor(0, (i, i + 1)) for i in range(20)]
    spec = PlanSpec((size,) * 21, (*(True,) * 20, False), tuple(factors), 0)
    plan = compile_plan(spec, {0: np.full((size, size), 1.0 / size)})
    assert plan.heap_size < 1 + size * size + size + 4 * size + size * size


def test_loops_over_consecutive_memory_become_one():
    assert merge_loops([(3, 8, 0, 8), (2, 4, 0, 4), (4, 1, 0, 1)]) == [(24, 1, 0, 1)]
    assert merge_loops([(3, 8, 1, 8), (8, 1, 0, 1)]) == [(3, 8, 1, 8), (8, 1, 0, 1)]


def test_the_cost_of_a_structure_is_of_the_order_of_its_plan():
    scopes = [("a", "b"), ("a", "b", "A"), ("b", "B"), ("A",), ("B",)]
    cards = dict.fromkeys("abAB", 10)
    flops, largest = structure_cost(scopes, "ab", cards)
    number = {v: i for i, v in enumerate("abAB")}
    tables = {k: np.ones([10] * len(s)) for k, s in enumerate(scopes)}
    factors = tuple(TableFactor(k, tuple(number[v] for v in s)) for k, s in enumerate(scopes))
    plan = compile_plan(PlanSpec((10,) * 4, (True, True, False, False), factors, 0), tables)
    assert largest == 100
    assert 0.3 < flops / plan.cost.flops < 3.0


def test_a_junction_tree_of_a_thousand_tiny_factors_does_not_underflow():
    factors = [Factor((i, i + 1), np.full((1, 2, 2), 1e-3)) for i in range(1000)]
    tree = JunctionTree(factors)
    assert tree.log_total[0] == pytest.approx(1000 * np.log(1e-3) + 1001 * np.log(2))
    np.testing.assert_allclose(tree.marginal(500), [[0.5, 0.5]])


def test_a_builder_places_a_constant_once():
    build = Builder(PlanSpec((2, 2), (False, False), (), 0), {0: np.eye(2)})
    tensor = build.source(TableFactor(0, (0, 1)))
    assert build.place(tensor, (0, 1)) == build.place(tensor, (0, 1))
    assert build.place(tensor, (0, 1)) != build.place(tensor, (1, 0))
