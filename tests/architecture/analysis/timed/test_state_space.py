"""The exploration with clocks and environment against the micro-cases of the literature and against execution."""

import random

import numpy as np
import pytest
from reference_interpreter import Reference
from structure_nets import random_net

from cprm_gym.architecture.analysis.kernels import timed as kernels
from cprm_gym.architecture.analysis.timed.state_space import explore_timed
from cprm_gym.architecture.analysis.timed.system import timed_system
from cprm_gym.architecture.petri import INFINITE, Executor, Input, Math, ObjectPlace, PetriNet, Place, Selection, Semantics, Transition
from cprm_gym.errors import LivelockError, NetError


def firings(net, transition):
    """Cycles at which a transition fires in some run, over the first 20 cycles, following a shortest run to each of its firings."""
    space = explore_timed(net)
    label = [t.name for t in space.system.transitions].index(transition)
    found = set()
    for edge in np.flatnonzero(space.graph.labels == label):
        node = int(space.graph.sources[edge])
        found.add(space.steps([*space.edges_to(node), int(edge)])[-1].cycle)
    return found


def test_figure_2_5_fires_a_b_d_c_d():
    net = PetriNet(
        "fig_2_5",
        (Place("a", tokens=1), Place("b"), Place("c"), Place("d"), Place("end")),
        (
            Transition("A", ("a",), ("b",)),
            Transition("B", ("b",), ("c", "d"), delay=2),
            Transition("C", ("c",), ("d",), delay=3),
            Transition("D", ("d",), ("end",)),
        ),
    )
    space = explore_timed(net)
    last = int(np.flatnonzero(space.markings[:, -1] == 2)[0])
    assert [(s.cycle, s.what) for s in space.run(last)] == [(0, "A"), (2, "B"), (2, "D"), (5, "C"), (5, "D")]


@pytest.mark.parametrize(("memory", "cycle"), [("enabling", 9), ("age", 6)])
def test_a_clock_disabled_in_between_is_forgotten_or_kept(memory, cycle):
    """Delay 5, enabled at 0, disabled at 3, enabled again at 4."""
    net = PetriNet(
        "pause",
        (Place("p", tokens=1), Place("q"), Place("go", tokens=1), Place("wait"), Place("back", tokens=1)),
        (
            Transition("b", ("p",), ("q",), tests=("go",), delay=5, memory=memory),
            Transition("off", ("go", "back"), ("wait",), delay=3),
            Transition("on", ("wait",), ("go",), delay=1),
        ),
    )
    assert firings(net, "b") == {cycle}


@pytest.mark.parametrize(
    ("tokens", "persistence", "cycle"), [(1, "intermediate", 8), (1, "atomic", 5), (2, "intermediate", 5), (2, "atomic", 5)]
)
def test_taking_and_returning_a_token_restarts_the_clock_under_intermediate_persistence(tokens, persistence, cycle):

    net = PetriNet(
        "borrow",
        (Place("p", tokens=tokens), Place("q"), Place("once", tokens=1), Place("b_once", tokens=1)),
        (
            Transition("b", ("b_once",), ("q",), tests=("p",), delay=5),
            Transition("borrow", ("p", "once"), ("p",), delay=3),
        ),
        semantics=Semantics(persistence=persistence),
    )
    assert firings(net, "b") == {cycle}


def test_a_timeout_beats_slower_work_on_one_token():
    net = PetriNet(
        "timeout",
        (Place("p", tokens=1), Place("q")),
        (Transition("timeout", ("p",), ("q",), delay=4), Transition("work", ("p",), ("q",), delay=7)),
    )
    assert firings(net, "timeout") == {4}
    assert firings(net, "work") == set()


def test_two_delays_due_at_once_follow_the_declared_order_and_are_reported():
    net = PetriNet(
        "tie",
        (Place("p", tokens=1), Place("q")),
        (Transition("first", ("p",), ("q",), delay=6), Transition("second", ("p",), ("q",), delay=6)),
    )
    space = explore_timed(net)
    assert firings(net, "first") == {6}
    assert firings(net, "second") == set()
    assert space.ties[0, 1]
    assert not space.ties[1, 0]


def test_an_immediate_transition_pre_empts_a_timed_one():
    net = PetriNet("vanishing", (Place("p", tokens=1), Place("q")), (Transition("b", ("p",), (), delay=1), Transition("a", ("p",), ("q",))))
    assert firings(net, "a") == {0}
    assert firings(net, "b") == set()


def test_test_and_inhibitor_arc_of_one_threshold_leave_no_gap_and_no_overlap():
    net = PetriNet(
        "decide",
        (Place("p", tokens=1), Place("near"), Place("far"), Input("distance")),
        (
            Transition("kick", ("p",), ("near",), inhibitors={"distance": 0.7}),
            Transition("run", ("p",), ("far",), tests={"distance": 0.7}),
        ),
    )
    space = explore_timed(net)
    ends = {tuple(space.marking(i)) for i in range(space.n_nodes) if space.kinds[i] == kernels.OVER}
    assert ends == {("near",), ("far",)}


def test_places_that_show_the_same_observation_agree():
    net = PetriNet(
        "same",
        (Place("p", tokens=1), Place("q"), Input("a", observes="ball.seen"), Input("b", observes="ball.seen")),
        (Transition("never", ("p",), ("q",), tests={"a": 1}, inhibitors={"b": 1}),),
    )
    assert firings(net, "never") == set()
    assert len(timed_system(net).variables) == 1


def test_math_places_with_one_expression_of_the_same_things_agree():
    net = PetriNet(
        "twins",
        (
            Place("p", tokens=1), Input("a", observes="x"), Input("b", observes="x"), Input("c"),
            Math("far", "abs(a) + 1"), Math("wide", "abs(b) + 1"), Math("other", "abs(c) + 1"),
        ),
        (
            Transition("never", ("p",), tests={"far": 2}, inhibitors={"wide": 2}),
            Transition("may", ("p",), tests={"far": 2}, inhibitors={"other": 2}, delay=1),
        ),
    )  # fmt: skip
    assert firings(net, "never") == set()
    assert 1 in firings(net, "may")


def test_bounds_cut_away_what_cannot_be():
    net = PetriNet("bounds", (Place("p", tokens=1), Input("x")), (Transition("t", ("p",), tests={"x": 5}),))
    assert "t" in {s.what for i in range(explore_timed(net).n_nodes) for s in explore_timed(net).run(i)}
    space = explore_timed(timed_system(net, bounds={"x": (0, 4)}))
    assert not (space.graph.labels == 0).any()


def test_a_math_place_stays_within_what_its_expression_can_give():
    net = PetriNet(
        "clipped",
        (Place("p", tokens=1), Place("q", tokens=1), Input("x"), Math("power", "clip(x, 0, 100)"), Math("twice", "2 * power + 1")),
        (Transition("strong", ("p",), tests={"twice": 202}), Transition("weak", ("q",), tests={"twice": 200})),
    )
    assert firings(net, "strong") == set()
    assert 0 in firings(net, "weak")
    space = explore_timed(timed_system(net, bounds={"x": (0, 50)}))
    assert not (space.graph.labels == 1).any()


def test_bounds_that_contradict_each_other_are_refused():
    net = PetriNet("none", (Place("p", tokens=1), Input("x"), Math("y", "abs(x)")), (Transition("t", ("p",), tests={"y": 1}),))
    with pytest.raises(NetError, match="bounds of place 'y'"):
        timed_system(net, bounds={"y": (-5, -1)})
    with pytest.raises(NetError, match=r"unknown place 'z'"):
        timed_system(net, bounds={"z": (0, 1)})


def test_more_clocks_than_a_number_of_servers_can_be_are_refused_by_name():
    net = PetriNet("servers", (Place("p", tokens=3),), (Transition("slow", ("p",), delay=2, servers=INFINITE),))
    with pytest.raises(NetError, match=r"'slow'.*up to 64 clocks.*it may have 256; give its input places capacities"):
        explore_timed(net)


@pytest.mark.parametrize(("servers", "cycles"), [(1, [5, 10, 15]), (2, [5, 5, 10]), (INFINITE, [5, 5, 5])])
def test_servers_work_at_once(servers, cycles):
    net = PetriNet("queue", (Place("p", tokens=3, capacity=3), Place("q")), (Transition("t", ("p",), ("q",), delay=5, servers=servers),))
    space = explore_timed(net)
    last = int(np.flatnonzero(space.markings[:, 1] == 3)[0])
    assert [s.cycle for s in space.run(last)] == cycles


@pytest.mark.parametrize(("memory", "cycles"), [("enabling", {4, 7}), ("age", {4, 6}), ("resampling", {7, 11})])
def test_of_two_clocks_the_youngest_stops(memory, cycles):
    """One token is there from the start, one from cycle 1; in cycle 2 one is lent, and it is back in cycle 3."""
    net = PetriNet(
        "lend",
        (Place("p", tokens=1, capacity=2), Place("q"), Place("later", tokens=1), Place("once", tokens=1), Place("away")),
        (
            Transition("t", ("p",), ("q",), delay=4, servers=2, memory=memory),
            Transition("come", ("later",), ("p",), delay=1),
            Transition("lend", ("p", "once"), ("away",), delay=2),
            Transition("back", ("away",), ("p",), delay=1),
        ),
    )
    assert firings(net, "t") == cycles


def test_an_age_clock_stopped_by_a_due_transition_is_still_due_before_lower_priorities():
    net = PetriNet(
        "still due",
        (Place("p", tokens=1), Place("d", tokens=1), Place("race", tokens=1), Place("won")),
        (
            Transition("borrow", ("p", "d"), ("p",), delay=2, priority=2),
            Transition("a", ("race",), ("won",), tests=("p",), delay=2, priority=1, memory="age"),
            Transition("c", ("race",), delay=2),
        ),
    )
    assert firings(net, "a") == {2}
    assert firings(net, "c") == set()


def test_a_clock_restarts_when_a_firing_enables_what_the_environment_had_disabled():
    """In cycle 1 the input disables `t` when the clocks stop; then `go` enables it, so that its clock starts at that instant."""
    net = PetriNet(
        "restart",
        (Place("p", tokens=1), Place("q"), Place("go"), Place("s", tokens=1), Place("e", tokens=1), Place("k"), Input("x"),
         Math("m", "x + go")),
        (
            Transition("see", ("e",), ("k",), tests={"m": 1}),
            Transition("start", ("s",), ("go",), delay=1, priority=1),
            Transition("unsee", ("k",), (), delay=1, inhibitors={"m": 1}),
            Transition("t", ("p",), ("q",), tests={"m": 1}, delay=3),
        ),
    )  # fmt: skip
    space, executor = explore_timed(net), Executor(net)
    columns = [executor.net.place(name) for name in space.system.places]
    here = np.arange(space.n_nodes) == 0
    for cycle in range(5):
        executor.step({"x": 0.0 if cycle == 1 else 1.0})
        here = boundary_after(space, here) & (space.markings == executor.marking[0, columns]).all(axis=1)
        assert here.any(), f"cycle {cycle}"
    assert executor.read("q") == 1


def test_clocks_of_several_servers_are_those_of_the_reference_interpreter():
    """Without a choice there is one run, and it must be the interpreter's, marking for marking."""
    seen = set()
    for seed in range(200):
        net = random_net(seed, inputs=False, immediate=False)
        space = explore_timed(net)
        assert space.complete
        reference = Reference(net)
        node, ends = 0, np.flatnonzero(space.kinds == kernels.OVER)
        for _ in range(min(len(ends), 40)):
            while space.kinds[node] != kernels.OVER:
                low, high = space.graph.offsets[node], space.graph.offsets[node + 1]
                assert high == low + 1, f"net {seed}: {space.marking(node)} has {high - low} successors"
                node = int(space.graph.targets[low])
            reference.step({}, {}, {})
            wanted = [reference.marking[name] for name in space.system.places]
            assert space.markings[node].tolist() == wanted, f"net {seed}, cycle {reference.cycle}"
            node = int(space.graph.targets[space.graph.offsets[node]])
        seen |= {t.memory for t in net.transitions if t.servers != 1 and len(ends) > 5}
    assert seen == {"enabling", "age", "resampling"}


def test_every_run_of_random_nets_is_among_those_explored():
    """Execution follows one order, analysis every order: each marking at the end of a cycle must be one that analysis foresees."""
    followed = 0
    for seed in range(150):
        net = random_net(seed)
        space = explore_timed(net)
        assert space.complete
        executor = Executor(net)
        draw = random.Random(seed)
        columns = [executor.net.place(name) for name in space.system.places]
        here = np.zeros(space.n_nodes, bool)
        here[0] = True
        for _ in range(25):
            inputs = {"seen": draw.choice([-2.0, 0.0, 1.0, 3.0])}
            beliefs = {"bearing": draw.choice([-4.0, -1.0, 0.0, 1.0, 2.0])}
            try:
                executor.step(inputs, beliefs=beliefs)
            except LivelockError:
                break
            marking = executor.marking[0, columns].astype(np.int16)
            here = boundary_after(space, here) & (space.markings == marking).all(axis=1)
            assert here.any(), f"net {seed}: {dict(zip(space.system.places, marking))} was not foreseen"
            followed += 1
    assert followed > 1000


def boundary_after(space, here):
    """The ends of cycles that can be reached from the nodes `here` without crossing another."""
    graph, over = space.graph, space.kinds == kernels.OVER
    front = np.array([graph.targets[graph.offsets[i]] if over[i] else i for i in np.flatnonzero(here)], np.int64)
    seen = np.zeros(space.n_nodes, bool)
    seen[front] = True
    while len(front):
        edges = np.concatenate([np.arange(graph.offsets[i], graph.offsets[i + 1]) for i in front])
        targets = np.unique(graph.targets[edges])
        fresh = targets[~seen[targets]]
        seen[fresh] = True
        front = fresh[~over[fresh]]
    return seen & over


def test_runs_with_selected_and_carried_objects_are_among_those_explored():
    select = Selection("Teammate", best="teammate.openness", where="teammate.openness >= 10")
    net = PetriNet(
        "objects",
        (
            ObjectPlace("mate", "Teammate", select),
            ObjectPlace("target", "Teammate"),
            Place("ready", capacity=1, tokens=1),
            Place("passes", capacity=3),
            Math("open", "target.openness"),
        ),
        (
            Transition("choose", ("mate", "ready"), ("target",), delay=1),
            Transition("pass", ("target",), ("ready", "passes"), tests={"open": 12}, delay=2),
            Transition("drop", ("target",), ("ready",), inhibitors={"open": 12}, delay=1),
            Transition("wait", (), (), inhibitors=("mate",), sets={"passes": 0}, tests=("passes",), delay=2),
        ),
    )
    space = explore_timed(net)
    assert space.complete
    assert [v.is_object for v in space.system.variables] == [True, False]
    executor = Executor(net, objects={"Teammate": 2})
    columns = [executor.net.place(name) for name in space.system.places]
    draw = random.Random(5)
    here = np.zeros(space.n_nodes, bool)
    here[0] = True
    seen = set()
    for k in range(300):
        if k % 6 == 0:
            openness = np.array([draw.uniform(4, 20), draw.uniform(4, 20)])
        executor.step(objects={"Teammate": {"openness": openness}})
        held = {name: int(executor.holds(name)[0] >= 0) for name in ("mate", "target")}
        marking = np.array([held[n] if n in held else executor.marking[0, c] for n, c in zip(space.system.places, columns)], np.int16)
        here = boundary_after(space, here) & (space.markings == marking).all(axis=1)
        assert here.any()
        seen.add(tuple(marking))
    assert len(seen) > 4
