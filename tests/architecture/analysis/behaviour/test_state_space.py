"""State spaces: counts, properties and witnesses against known values and a slow oracle; budgets and interruptions."""

from dataclasses import replace

import numpy as np
import pytest
from structure_nets import flexible_manufacturing, kanban, landing_detector, philosophers, producer, random_net, token_ring
from structure_oracle import Oracle

from cprm_gym.architecture.analysis.behaviour import state_space
from cprm_gym.architecture.analysis.behaviour.properties import analyze_structure
from cprm_gym.architecture.analysis.behaviour.state_space import explore
from cprm_gym.architecture.analysis.budget import Budget
from cprm_gym.architecture.analysis.net_arrays import System
from cprm_gym.architecture.petri import PetriNet, Place, Transition
from cprm_gym.errors import NetError, UnknownName


@pytest.mark.parametrize(("tickets", "states"), [(1, 160), (2, 4_600), (3, 58_400)])
def test_kanban_has_the_published_number_of_markings(tickets, states):
    space = explore(System.from_net(kanban(tickets)))
    assert (space.n_states, space.complete, space.n_deadlocks) == (states, True, 0)


def test_the_landing_detector_has_the_published_number_of_markings():
    net = landing_detector(10)
    assert (len(net.places), len(net.transitions)) == (89, 88)
    assert explore(System.from_net(net)).n_states == 43_463, "AirplaneLD-PT-0010"


@pytest.mark.slow
def test_kanban_5_and_fms_5_have_the_published_numbers_of_markings_and_firings():
    space = explore(System.from_net(kanban(5)))
    assert (space.n_states, space.n_edges, space.n_deadlocks) == (2_546_432, 24_460_016, 0)
    space = explore(System.from_net(flexible_manufacturing(5)))
    assert (space.n_states, space.n_edges, space.n_deadlocks) == (2_895_018, 23_527_185, 0)


def test_many_transitions_are_found_through_the_places_that_are_marked():
    space = explore(System.from_net(token_ring(5)))
    assert space.net.indexed
    assert (space.n_states, space.n_edges) == (166, 365)
    space = explore(System.from_net(token_ring(10)))
    assert (space.n_states, space.n_edges, len(space.system.transitions)) == (58_905, 294_050, 1_111)


@pytest.mark.parametrize("extended", [False, True])
def test_random_nets_agree_with_the_oracle_in_every_property(extended):
    for seed in range(120):
        net = random_net(seed, timed=False, extended=extended)
        facts, found = Oracle(net).facts(), analyze_structure(net)
        got = {
            "states": found.states,
            "edges": found.edges,
            "deadlocks": found.deadlocks,
            "max_tokens_in_place": found.max_tokens_in_place,
            "max_tokens_in_marking": found.max_tokens_in_marking,
            "dead_transitions": set(found.dead_transitions),
            "live_transitions": {t for t, level in found.liveness.items() if level == 4},
            "reversible": found.reversible.holds,
            "home_markings": found.home_markings,
            "sccs": found.sccs,
            "bottom_sccs": found.bottom_sccs,
        }
        dead_free = facts["deadlocks"] == 0
        assert got == facts, f"net {seed}"
        assert found.deadlock_free.holds == dead_free
        assert found.live.holds == (facts["live_transitions"] == {t.name for t in net.transitions})
        assert found.one_safe.holds == (facts["max_tokens_in_place"] <= 1)


def test_every_witness_leads_where_it_says():
    seen = 0
    for seed in range(60):
        net = random_net(seed, timed=False)
        system = System.from_net(net)
        found = analyze_structure(net)
        for verdict in (found.deadlock_free, found.one_safe, found.live, found.reversible):
            if verdict.holds is False:
                end = system.run(verdict.firings)[-1]
                assert system.describe(end) == verdict.marking
                seen += 1
        if found.deadlock_free.holds is False:
            assert not system.enabled(system.run(found.deadlock_free.firings)[-1]).any()
    assert seen > 50


def test_philosophers_starve_unless_one_is_polite():
    rude = analyze_structure(philosophers(4))
    assert rude.deadlock_free.holds is False
    assert sorted(rude.deadlock_free.firings) == [f"first{i}" for i in range(4)]
    polite = analyze_structure(philosophers(4, polite=True))
    assert (polite.deadlock_free.holds, polite.live.holds, polite.reversible.holds) == (True, True, True)
    assert polite.home_markings == polite.states


def test_an_unbounded_net_is_recognised_with_a_sequence_that_can_be_repeated():
    net = producer(None)
    system = System.from_net(net)
    found = analyze_structure(net, Budget(states=100_000))
    assert (found.bounded.holds, found.complete, found.reason) == (False, False, "unbounded")
    before, after = (system.run(found.bounded.firings + tuple(step.what for step in found.bounded.loop) * k)[-1] for k in (1, 2))
    assert (after >= before).all()
    assert after.sum() > before.sum()
    assert analyze_structure(producer(3)).bounded.holds is True
    assert found.quasi_live.holds is True


def test_growth_of_an_inhibited_place_is_not_taken_for_a_proof_of_unboundedness():
    net = PetriNet("ten", (Place("p", tokens=1), Place("n")), (Transition("count", ("p",), ("p", "n"), inhibitors={"n": 100}),))
    found = analyze_structure(net)
    assert (found.states, found.bounded.holds, found.max_tokens_in_place) == (101, True, 100)


def test_fields_grow_with_the_tokens_without_losing_a_marking():
    net = PetriNet("grow", (Place("p", tokens=1000), Place("q"), Place("r")), (Transition("t", ("p",), {"q": 3, "r": 1}),))
    space = explore(System.from_net(net))
    assert space.n_states == 1001
    assert {tuple(m) for m in space.markings()} == {(1000 - k, 3 * k, k) for k in range(1001)}


@pytest.mark.parametrize(
    ("budget", "reason"), [(Budget(states=5_000), "states"), (Budget(memory=400_000), "memory"), (Budget(seconds=0.0), "seconds")]
)
def test_a_spent_budget_gives_a_partial_answer_that_says_so(budget, reason):
    found = analyze_structure(kanban(4), budget)
    assert (found.complete, found.reason) == (False, reason)
    assert 0 < found.states < 454_475
    for verdict in (found.bounded, found.deadlock_free, found.live, found.reversible):
        assert verdict.holds is None
        assert reason in verdict.why


def test_a_deadlock_found_before_the_budget_is_spent_is_reported():
    net = PetriNet(
        "long",
        (Place("p", tokens=1), Place("n"), Place("end")),
        (Transition("count", ("p",), ("p", "n"), inhibitors={"n": 1_000_000}), Transition("stop", ("p",), ("end",))),
    )
    found = analyze_structure(net, Budget(states=2_000))
    assert (found.complete, found.reason) == (False, "states")
    assert (found.deadlock_free.holds, found.deadlock_free.firings) == (False, ("stop",))
    assert (found.live.holds, found.reversible.holds, found.bounded.holds) == (False, False, None)


def test_an_interruption_keeps_what_was_found():
    calls = []

    def stop(states, expanded, seconds):
        calls.append(states)
        if len(calls) == 3:
            raise KeyboardInterrupt

    space = explore(System.from_net(kanban(4)), progress=stop, chunk=1_000)
    assert (space.complete, space.reason, len(calls)) == (False, "interrupted", 3)
    assert 2_900 < space.n_expanded < space.n_states
    assert space.graph().n_nodes == space.n_states


def test_edges_kept_while_exploring_are_those_of_a_second_pass_and_given_up_where_they_do_not_fit():
    for net in (kanban(2), token_ring(4), *(random_net(seed) for seed in range(40))):
        kept, few = (explore(System.from_net(net), Budget(states=2_000), chunk=100, edge_memory=memory) for memory in (1 << 30, 60_000))
        assert kept.links is not None
        for space in (kept, few):
            found, again = space.graph(), replace(space, links=None).graph()
            for name in ("offsets", "targets", "labels"):
                assert getattr(found, name).dtype == getattr(again, name).dtype
                np.testing.assert_array_equal(getattr(found, name), getattr(again, name))
    assert explore(System.from_net(kanban(2)), edge_memory=200_000).links is None


def test_running_out_of_memory_in_the_middle_of_growing_leaves_a_whole_partial_answer(monkeypatch):
    grow = state_space._grow

    def fail(space, budget):
        if space.n_states < 20_000:
            return grow(space, budget)
        space.table = np.zeros(0, np.uint32)
        raise MemoryError

    monkeypatch.setattr(state_space, "_grow", fail)
    space = explore(System.from_net(kanban(4)))
    assert (space.complete, space.reason) == (False, "memory")
    assert space.number_of(space.marking(space.n_states - 1)) == space.n_states - 1
    assert (space.graph().targets >= 0).all()


def test_edges_beyond_the_memory_granted_leave_liveness_unknown():
    found = analyze_structure(kanban(2), graph_memory=1_000)
    assert (found.complete, found.live.holds, found.deadlock_free.holds, found.sccs) == (True, None, True, -1)
    assert "too large for the memory or the time granted" in found.live.why


def test_progress_grows():
    seen = []
    explore(System.from_net(kanban(3)), progress=lambda states, expanded, seconds: seen.append((states, expanded)), chunk=5_000)
    assert len(seen) > 5
    assert seen == sorted(seen)


def test_memory_per_marking_stays_near_the_packed_marking():
    space = explore(System.from_net(kanban(4)))
    assert space.layout.words == 1
    assert space.bytes_per_state < 32


def test_markings_are_found_again_by_value():
    space = explore(System.from_net(kanban(2)))
    for i in (0, 7, 4599):
        assert space.number_of(space.marking(i)) == i
    assert space.number_of(np.full(16, 9)) == -1


def test_priorities_pre_empt_in_the_timed_view_only():
    net = PetriNet(
        "two",
        (Place("p", tokens=1), Place("q"), Place("r")),
        (Transition("low", ("p",), ("q",)), Transition("high", ("p",), ("r",), priority=1)),
    )
    assert analyze_structure(System.from_net(net)).states == 3
    assert analyze_structure(System.from_net(net, timing=True)).dead_transitions == ("low",)


@pytest.mark.parametrize(("threshold", "states", "edges"), [(1, 2, 1), (2, 3, 2)])
def test_an_inhibitor_arc_stops_at_its_threshold(threshold, states, edges):
    net = PetriNet(
        "inhibit", (Place("p", tokens=threshold + 1), Place("q")), (Transition("t", ("p",), ("q",), inhibitors={"q": threshold}),)
    )
    space = explore(System.from_net(net))
    assert (space.n_states, space.n_edges) == (states, edges)


def test_a_full_place_blocks_and_a_self_loop_does_not_need_room_under_the_strong_rule():
    from cprm_gym.architecture.petri import Semantics

    full = PetriNet("full", (Place("p", tokens=5), Place("q", capacity=2)), (Transition("t", ("p",), ("q",)),))
    assert (explore(System.from_net(full)).n_states, explore(System.from_net(full)).n_deadlocks) == (3, 1)
    loop = (Place("p", capacity=1, tokens=1),), (Transition("t", ("p",), ("p",)),)
    assert explore(System.from_net(PetriNet("loop", *loop))).n_deadlocks == 0
    assert explore(System.from_net(PetriNet("loop", *loop, semantics=Semantics(capacity="weak")))).n_deadlocks == 1


def test_a_test_arc_and_an_input_arc_need_the_larger_of_both():
    net = PetriNet("both", (Place("p", tokens=2),), (Transition("t", ("p",), (), tests={"p": 2}),))
    space = explore(System.from_net(net))
    assert [int(m[0]) for m in space.markings()] == [2, 1]


def test_systems_from_arrays_are_checked():
    with pytest.raises(NetError, match="must have shape"):
        System.from_arrays([[1, 0]], [[0, 1, 0]], [1, 0])
    with pytest.raises(NetError, match="must not be negative"):
        System.from_arrays([[1, -1]], [[0, 1]], [1, 0])
    with pytest.raises(NetError, match="above the capacity"):
        System.from_arrays([[1, 0]], [[0, 1]], [2, 0], capacity=[1, -1])
    system = System.from_arrays([[1, 0]], [[0, 1]], [1, 0])
    with pytest.raises(UnknownName, match="Did you mean 'p1'"):
        system.place("p1_")
    with pytest.raises(NetError, match="firing 1 of the sequence, 't0', is not enabled"):
        system.run(("t0", "t0"))


def test_the_exploration_compiles_once():
    explore(System.from_net(kanban(1)))
    explore(System.from_net(random_net(1)))
    assert len(state_space.packed.expand.signatures) == 1
