"""Invariants, siphons and traps, coverability: against definitions, brute force and known nets."""

import itertools

import numpy as np
import pytest
from structure_nets import kanban, philosophers, producer, random_net
from structure_oracle import Oracle

from cprm_gym.architecture.analysis.behaviour.coverability import OMEGA, karp_miller
from cprm_gym.architecture.analysis.behaviour.state_space import explore
from cprm_gym.architecture.analysis.budget import Budget
from cprm_gym.architecture.analysis.net_arrays import System
from cprm_gym.architecture.analysis.structure.conservation import conservative
from cprm_gym.architecture.analysis.structure.invariants import flow_basis, semiflows, structural_bounds
from cprm_gym.architecture.analysis.structure.siphons import is_ordinary, minimal_siphons, minimal_traps, unprotected_siphon
from cprm_gym.architecture.petri import PetriNet, Place, Transition
from cprm_gym.errors import NetError


def random_systems(count, **options):
    for seed in range(count):
        yield seed, System.from_net(random_net(seed, timed=False, **options))


def test_p_invariants_hold_in_every_reachable_marking():
    for seed, system in random_systems(100):
        markings = explore(system).markings()
        for found in (flow_basis(system, "P"), semiflows(system, "P")):
            for v in found.vectors:
                sums = sum(markings[:, system.place(n)] * w for n, w in v.weights.items())
                assert (sums == v.value).all(), f"net {seed}: {v}"


def test_t_invariants_change_nothing():
    for seed, system in random_systems(100):
        for found in (flow_basis(system, "T"), semiflows(system, "T")):
            for v in found.vectors:
                change = sum(system.incidence[system.transition(n)] * w for n, w in v.weights.items())
                assert not np.any(change), f"net {seed}: {v}"


def test_the_basis_has_as_many_vectors_as_linear_algebra_says():
    for seed, system in random_systems(100, extended=False):
        rank = np.linalg.matrix_rank(system.incidence.astype(float)) if system.incidence.size else 0
        assert len(flow_basis(system, "P").vectors) == len(system.places) - rank, f"net {seed}"
        assert len(flow_basis(system, "T").vectors) == len(system.transitions) - rank, f"net {seed}"


def test_semiflows_are_minimal_and_all_there():
    """Brute force over small weights: every non-negative invariant has a minimal one inside."""
    for seed, system in random_systems(60, extended=False):
        found = semiflows(system, "P")
        assert found.complete
        supports = [v.support for v in found.vectors]
        assert not any(a < b for a in supports for b in supports)
        assert all(min(v.weights.values()) > 0 for v in found.vectors)
        for weights in itertools.product(range(3), repeat=len(system.places)):
            if any(weights) and not (system.incidence @ np.array(weights)).any():
                held = {n for n, w in zip(system.places, weights) if w}
                assert any(s <= held for s in supports), f"net {seed}"


def test_weights_are_whole_numbers_and_right():
    """The case on which integer division goes wrong elsewhere: p0 -2-> t -1-> p1 keeps p0 + 2 p1."""
    system = System.from_arrays([[2, 0]], [[0, 1]], [4, 1])
    (invariant,) = flow_basis(system, "P").vectors
    assert (invariant.weights, invariant.value) == ({"p0": 1, "p1": 2}, 6)
    assert str(invariant) == "p0 + 2 p1"


def test_kanban_keeps_its_tickets():
    system = System.from_net(kanban(3))
    found = semiflows(system, "P")
    supports = {v.support for v in found.vectors}
    assert {frozenset(f"{p}{i}" for p in ("m", "back", "kan", "out")) for i in (1, 2, 3, 4)} <= supports
    assert {v.value for v in found.vectors} == {3}
    assert set(structural_bounds(system, found).values()) == {3}
    assert conservative(system).holds is True


def test_places_that_set_arcs_write_are_left_out():
    net = PetriNet("set", (Place("p", tokens=1), Place("q")), (Transition("t", ("p",), ("q",)), Transition("u", sets={"p": 1})))
    assert flow_basis(System.from_net(net), "P").vectors == ()
    assert conservative(System.from_net(net)).holds is None


def test_a_net_that_makes_tokens_is_not_conservative():
    assert conservative(System.from_net(producer(None))).holds is False


def test_a_search_cut_short_says_so():
    places, transitions = [], []
    for k in range(12):
        places += [Place(f"a{k}"), Place(f"b{k}")]
        transitions += [Transition(f"x{k}", (f"a{k}", f"b{k}"), (f"a{(k + 1) % 12}", f"b{(k + 1) % 12}"))]
    found = semiflows(System.from_net(PetriNet("many", tuple(places), tuple(transitions))), "P", max_rows=100)
    assert not found.complete


def is_siphon(system, names):
    held = np.isin(system.places, list(names))
    reads = (system.need > 0) & (system.pre == 0)
    takes, gives = (system.pre > 0) | reads, (system.post > 0) | reads
    return all(takes[t, held].any() for t in range(len(system.transitions)) if gives[t, held].any())


def is_trap(system, names):
    held = np.isin(system.places, list(names))
    reads = (system.need > 0) & (system.pre == 0)
    takes, gives = (system.pre > 0) | reads, (system.post > 0) | reads
    return all(gives[t, held].any() for t in range(len(system.transitions)) if takes[t, held].any())


def test_minimal_siphons_and_traps_are_those_of_brute_force():
    for seed, system in random_systems(80, extended=False):
        subsets = [frozenset(c) for n in range(1, len(system.places) + 1) for c in itertools.combinations(system.places, n)]
        for find, check in ((minimal_siphons, is_siphon), (minimal_traps, is_trap)):
            every = [s for s in subsets if check(system, s)]
            expected = {s for s in every if not any(o < s for o in every)}
            found = find(system)
            assert (set(found.sets), found.complete) == (expected, True), f"net {seed}"


def test_empty_siphons_stay_empty_and_marked_traps_stay_marked_under_set_arcs_too():
    looked = 0
    for seed, system in random_systems(120, inputs=False):
        markings = explore(system, Budget(states=2_000)).markings()
        sets = [(frozenset(s), kind) for find, kind in ((minimal_siphons, False), (minimal_traps, True)) for s in find(system).sets]
        for names, marked in sets:
            inside = np.isin(system.places, list(names))
            for m in markings[markings[:, inside].any(axis=1) == marked][:200]:
                for t in np.flatnonzero(system.enabled(m)):
                    assert system.fire(int(t), m)[inside].any() == marked, f"net {seed}: {sorted(names)}, {system.transitions[t]}"
                    looked += 1
    assert looked > 500


def test_a_siphon_that_may_run_empty_is_shown_and_one_that_cannot_proves_freedom_from_deadlock():
    rude, polite = System.from_net(philosophers(3)), System.from_net(philosophers(3, polite=True))
    assert is_ordinary(rude)
    assert unprotected_siphon(rude, minimal_siphons(rude)) is not None
    assert unprotected_siphon(polite, minimal_siphons(polite)) is None
    assert explore(polite).n_deadlocks == 0


def test_no_deadlock_is_reachable_where_the_siphons_hold_marked_traps():
    proved = 0
    for seed, system in random_systems(300, extended=False):
        bare = System.from_arrays(system.pre, system.post, system.marking)
        if is_ordinary(bare) and (bare.pre.sum(axis=1) > 0).all() and unprotected_siphon(bare, minimal_siphons(bare)) is None:
            space = explore(bare, Budget(states=5_000))
            assert space.n_deadlocks == 0, f"net {seed}"
            proved += 1
    assert proved > 5


def test_coverability_finds_the_places_that_grow():
    graph = karp_miller(System.from_net(producer(None)))
    assert (graph.complete, graph.unbounded_places, graph.dead_transitions) == (True, ("buffer",), ())
    assert graph.covers({"buffer": 1_000_000}) is True
    assert graph.covers({"hungry": 2}) is False


def test_the_coverability_graph_of_a_bounded_net_is_its_reachability_graph():
    for seed, system in random_systems(60):
        graph = karp_miller(system)
        assert graph.complete
        assert {tuple(m) for m in graph.nodes} == {tuple(m) for m in explore(system).markings()}, f"net {seed}"


def test_coverability_agrees_with_exploration_on_nets_without_capacities():
    """Whatever is found within 2000 markings is covered, and a place without omega holds no more than the graph says."""
    grows = 0
    for seed in range(80):
        base = random_net(seed, timed=False, extended=False, inputs=False)
        net = PetriNet("open", tuple(Place(p.name, tokens=p.tokens) for p in base.places), base.transitions)
        system = System.from_net(net)
        graph = karp_miller(system, Budget(seconds=20))
        assert graph.complete
        markings = explore(system, Budget(states=2_000)).markings()
        assert all((graph.nodes >= m).all(axis=1).any() for m in markings[:300]), f"net {seed}"
        if graph.unbounded_places:
            grows += 1
        else:
            assert {tuple(m) for m in graph.nodes} == set(Oracle(net).edges), f"net {seed}"
    assert grows > 5


def test_growth_under_an_inhibitor_arc_is_not_pumped():
    net = PetriNet("ten", (Place("p", tokens=1), Place("n")), (Transition("count", ("p",), ("p", "n"), inhibitors={"n": 10}),))
    graph = karp_miller(System.from_net(net))
    assert (len(graph.nodes), graph.nodes.max() < OMEGA) == (11, True)


def test_a_coverability_graph_outgrows_its_first_arrays():
    assert len(karp_miller(System.from_net(kanban(2))).nodes) == 4600


def test_coverability_refuses_priorities():
    net = PetriNet("prio", (Place("p", tokens=1),), (Transition("a", ("p",)), Transition("b", ("p",), priority=1)))
    with pytest.raises(NetError, match="not defined here for nets with priorities"):
        karp_miller(System.from_net(net, timing=True))
