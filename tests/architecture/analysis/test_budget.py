"""One budget bounds all of an analysis, and proofs decide what exploration leaves open."""

import time
from dataclasses import replace

import numpy as np
import pytest
from structure_nets import kanban, token_ring

from cprm_gym.architecture.analysis import report as reports
from cprm_gym.architecture.analysis.behaviour.properties import Proofs, analyze_structure
from cprm_gym.architecture.analysis.budget import Budget, available_memory
from cprm_gym.architecture.analysis.net_arrays import FREE, NEVER, System
from cprm_gym.architecture.analysis.report import analyze
from cprm_gym.architecture.analysis.structure.siphons import minimal_siphons
from cprm_gym.architecture.petri import PetriNet, Place, Transition
from cprm_gym.errors import NetError


def test_siphons_proofs_and_runs_share_the_time_that_is_granted():
    """A net whose siphons alone take long: they were looked for 20 seconds after a budget of 1.5."""
    net = token_ring(10)
    analyze(kanban(1))  # kernels are compiled
    began = time.monotonic()
    report = analyze(net, budget=Budget(seconds=1.5))
    assert time.monotonic() - began < 12  # several things at a time may run on this machine
    assert any("cut short" in note for note in report.notes)
    assert report.siphons is None or not report.siphons.complete or report.untimed.complete


def test_siphons_stop_when_told():
    found = minimal_siphons(System.from_net(kanban(2)), enough=lambda: True)
    assert (found.sets, found.complete) == ((), False)


def test_a_net_whose_arrays_are_larger_than_the_memory_granted_is_refused_by_name():
    with pytest.raises(NetError, match=r"net 'kanban': 16 places and 16 transitions take 0 MiB as arrays; 0 MiB are granted"):
        analyze(kanban(2), budget=Budget(memory=1000))


def test_conservation_decides_boundedness_and_siphons_decide_deadlocks_when_exploration_stops():
    report = analyze(kanban(8), budget=Budget(states=2000))
    assert (report.untimed.complete, report.conservative.holds, report.siphon_trap.holds) == (False, True, True)
    assert report.untimed.bounded.holds is True
    assert report.untimed.bounded.why.startswith("conservation")
    assert report.untimed.deadlock_free.holds is True
    alone = analyze_structure(kanban(8), Budget(states=2000))
    assert (alone.bounded.holds, alone.deadlock_free.holds) == (None, None)


def test_invariants_decide_whether_a_net_is_one_safe():
    net = token_ring(6)
    report = analyze(net, budget=Budget(states=100))
    assert not report.untimed.complete
    assert report.untimed.one_safe.holds is True


def drain(*places, extra=()):
    """A large cyclic net beside a part that fills a sink."""
    big = kanban(8)
    return replace(big, places=(*big.places, *places), transitions=(*big.transitions, *extra))


def test_a_sink_decides_liveness():
    net = drain(Place("work", capacity=3, tokens=3), Place("sink", capacity=3), extra=(Transition("end", ("work",), ("sink",)),))
    untimed = analyze(net, budget=Budget(states=2000)).untimed
    assert not untimed.complete
    assert untimed.live.holds is False
    assert "'end' takes what is never put back into 'work'" in untimed.live.why
    assert untimed.reversible.holds is False
    assert untimed.reversible.firings[-1] == "end"


def test_a_bounded_place_that_only_fills_decides_liveness():
    net = drain(Place("sink", capacity=5), extra=(Transition("drop", (), ("sink",)),))
    proofs = Proofs()
    untimed = analyze_structure(net, Budget(states=2000), proofs=proofs)
    assert untimed.live.holds is None  # nothing says that the net is bounded
    bounded = analyze_structure(net, Budget(states=2000), proofs=Proofs(conservative=replace(untimed.live, holds=True)))
    assert "is never taken again from 'sink'" in bounded.live.why
    assert bounded.live.holds is False


def test_a_timed_view_that_stops_is_bounded_if_the_untimed_one_is():
    places = tuple(Place(f"p{k}", tokens=1) for k in range(6))
    steps = tuple(Transition(f"t{k}", (f"p{k}",), (f"p{k}",), delay=d) for k, d in enumerate((7, 11, 13, 17, 19, 23)))
    report = analyze(PetriNet("clocks", places, steps), budget=Budget(states=5000))
    assert (report.timed.complete, report.timed.bounded.holds) == (False, True)


def test_the_memory_granted_by_default_is_what_is_there():
    assert 0 < Budget().memory <= available_memory()


def test_a_part_of_a_budget_ends_with_it_and_an_interruption_stops_the_whole():
    budget, clock = Budget(seconds=100.0).start()
    _, part = budget.part(0.25).start()
    assert 0 < part.left <= 25
    part.interrupt()
    assert (part.reason, clock.reason) == ("interrupted", "interrupted")
    assert budget.start()[1] is clock


def test_the_running_net_is_not_even_prepared_when_the_time_is_over(monkeypatch):
    """2,187 timed self-loops in modules seven deep took 2.4 seconds of a budget of one: arrays were made for what was not looked at."""

    def prepared(*_args, **_options):
        raise AssertionError("the running net was prepared")

    net = PetriNet("leaf", (Place("p", 1, 1),), (Transition("t", ("p",), ("p",), delay=1),))
    for depth in range(3):
        net = PetriNet(f"deep_{depth}", modules={f"m{k}": net for k in range(3)})
    assert analyze(net).timed is not None
    monkeypatch.setattr(reports, "closed_system", prepared)
    found = analyze(net, budget=Budget(seconds=0.0))
    assert found.timed is None
    assert "not explored cycle by cycle: the time is over" in found.notes


@pytest.mark.parametrize("weak", [False, True])
def test_capacities_become_thresholds_of_what_may_exceed_them(weak):
    """Place by place and transition by transition, as the rule of enabling says it."""
    rng = np.random.default_rng(int(weak))
    for _ in range(20):
        t_count, p_count = rng.integers(1, 7, 2)
        pre, post = (rng.integers(0, 3, (t_count, p_count)) for _ in range(2))
        inhibit = rng.integers(0, 4, (t_count, p_count)) * (rng.random((t_count, p_count)) < 0.3)
        capacity = rng.integers(-1, 3, p_count)
        system = System.from_arrays(
            pre, post, np.zeros(p_count, np.int64), inhibit=inhibit, capacity=capacity, weak_capacity=weak
        )  # fmt: skip
        for t, p in np.ndindex(t_count, p_count):
            gain = post[t, p] - (0 if weak else pre[t, p])
            expected = inhibit[t, p] if inhibit[t, p] else FREE
            if capacity[p] >= 0 and post[t, p] > 0 and (gain > 0 or weak):
                room = max(capacity[p] - gain + 1, 0)
                expected = NEVER if room == 0 else room if expected == FREE else min(room, expected)
            assert system.inhibit[t, p] == expected
