"""Set arcs (§4.1): run directly, and compiled away into the equivalent net of Fig. 4.2."""

from dataclasses import replace

import numpy as np
import pytest
from petri_random_nets import random_net, random_world

from cprm_gym.architecture.analysis.behaviour.bisimulation import weakly_bisimilar
from cprm_gym.architecture.petri import Executor, ObjectPlace, PetriNet, Place, Transition, flatten
from cprm_gym.architecture.petri.net.set_arcs import LOCK, eliminate_set_arcs
from cprm_gym.errors import NetError

# Fig. 4.1: two concurrent activities; on an error, recovery puts the whole module into the desired state
RECOVERY = PetriNet(
    "recovery",
    (Place("turning", 3, 2), Place("turned", 3), Place("looking", 3, 1), Place("looked", 3), Place("error", 1), Place("safe", 2)),
    (
        Transition("turn", ("turning",), ("turned",), delay=2),
        Transition("look", ("looking",), ("looked",), delay=1),
        Transition("stumble", inhibitors=("error", "safe"), outputs=("error",), delay=3),
        Transition("begin_recovery", ("error",), sets={"turning": 0, "turned": 0, "looking": 0, "looked": 0, "safe": 2}),
        Transition("resume", ("safe",), ("turning", "looking"), delay=1),
    ),
)


def hidden(name: str) -> bool:
    """Whether a name was added by the elimination."""
    return name.startswith("set.")


def test_set_arcs_reset_the_whole_module_at_once():
    executor = Executor(RECOVERY)
    for _ in range(4):
        executor.step()
    assert {p: int(executor.read(p)[0]) for p in ("turning", "turned", "looking", "looked", "error", "safe")} == {
        "turning": 0, "turned": 0, "looking": 0, "looked": 0, "error": 0, "safe": 2,
    }  # fmt: skip


def test_net_without_set_arcs_is_returned_as_it_is():
    net = PetriNet("plain", (Place("a"),), (Transition("t", ("a",)),))
    assert eliminate_set_arcs(net) == net


def test_eliminated_net_has_no_set_arcs_and_keeps_every_name():
    plain = eliminate_set_arcs(RECOVERY)
    assert not any(t.sets for t in plain.transitions)
    assert {t.name for t in plain.transitions if not hidden(t.name)} == {t.name for t in RECOVERY.transitions}
    assert {p.name for p in plain.places if not hidden(p.name)} == {p.name for p in RECOVERY.places}
    assert all(LOCK in t.inhibitors for t in plain.transitions if not hidden(t.name) and not t.is_timed)


def test_recovery_of_figure_4_1_and_its_net_of_figure_4_2_are_weakly_bisimilar():
    verdict = weakly_bisimilar(RECOVERY, eliminate_set_arcs(RECOVERY), hidden=hidden)
    assert verdict.alike, verdict.reason
    assert verdict.states[1] > verdict.states[0] > 10


def test_object_place_is_emptied_by_the_eliminated_net():
    net = PetriNet("drop", (Place("go", tokens=1), ObjectPlace("target", "Opponent")), (Transition("t", ("go",), sets={"target": 0}),))
    executor = Executor(eliminate_set_arcs(net), objects={"Opponent": 3})
    executor.write("target", 2)
    executor.step()
    assert executor.holds("target")[0] == -1


def test_bisimulation_finds_a_wrong_set_value():
    wrong = eliminate_set_arcs(RECOVERY)
    wrong = PetriNet(wrong.name, wrong.places, tuple(t for t in wrong.transitions if not t.name.endswith("turned.drain")))
    verdict = weakly_bisimilar(RECOVERY, wrong, hidden=hidden)
    assert not verdict.alike
    assert "begin_recovery" in verdict.reason


def test_bisimulation_tells_apart_nets_that_differ_only_in_a_choice():
    """Coffee or tea after one coin, against a coin that decides: same sequences, not bisimilar."""
    places = tuple(Place(p, 1, int(p == "coin")) for p in ("coin", "paid", "paid2", "cup"))
    late = PetriNet("late", places, (
        Transition("pay", ("coin",), ("paid",), delay=1),
        Transition("coffee", ("paid",), ("cup",), delay=1), Transition("tea", ("paid",), ("cup",), delay=1),
    ))  # fmt: skip
    early = PetriNet("early", places, (
        Transition("set.x", ("coin",), ("paid",), delay=1), Transition("set.y", ("coin",), ("paid2",), delay=1),
        Transition("pay", inhibitors=("coin",), delay=1),
        Transition("coffee", ("paid",), ("cup",), delay=1), Transition("tea", ("paid2",), ("cup",), delay=1),
    ))  # fmt: skip
    assert not weakly_bisimilar(late, early, hidden=hidden).alike


def test_state_space_beyond_the_limit_is_refused():
    net = PetriNet("endless", (Place("a"),), (Transition("t", outputs=("a",), delay=1),))
    with pytest.raises(NetError, match="more than 50 markings"):
        weakly_bisimilar(net, net, hidden=hidden, limit=50)


def test_reserved_names_are_refused():
    net = PetriNet("n", (Place("set.lock"), Place("a")), (Transition("t", sets={"a": 1}),))
    with pytest.raises(NetError, match=r"'set\.lock' has a name"):
        eliminate_set_arcs(net)


@pytest.mark.parametrize("block", range(4))
def test_random_nets_and_their_eliminations_are_weakly_bisimilar(block):
    compared = 0
    for seed in range(block * 20, block * 20 + 20):
        net = random_net(np.random.default_rng(seed), objects=False, small=True)
        if not any(t.sets for t in net.transitions):
            continue
        verdict = weakly_bisimilar(net, eliminate_set_arcs(net), hidden=hidden, limit=4000)
        assert verdict.alike, f"seed {seed}: {verdict.reason}"
        compared += verdict.states[0] > 3
    assert compared >= 3


def test_random_nets_and_their_eliminations_run_alike_with_clocks():
    """Cycle by cycle: the same transitions fire, and the same places hold the same."""
    firings = 0
    for seed in range(120):
        rng = np.random.default_rng(1000 + seed)
        net = random_net(rng, objects=False, random_choice=False)
        if not any(t.sets for t in net.transitions) or any("p" in str(p) for p in _set_maths(net)):
            continue
        roomy = replace(net.semantics, max_firings=10_000)  # the helpers count
        both = [Executor(n, trace=True) for n in (net, replace(eliminate_set_arcs(net), semantics=roomy))]
        for _ in range(12):
            inputs, beliefs, _ = random_world(rng)
            try:
                both[0].step(inputs, beliefs=beliefs)
            except RuntimeError:
                break
            both[1].step(inputs, beliefs=beliefs)
            fired = [[f.transition for f in executor.trace.firings(0) if not hidden(f.transition)] for executor in both]
            assert fired[0] == fired[1], f"seed {seed}"
            for place in flatten(net).places:
                assert both[0].read(place.name) == both[1].read(place.name), f"seed {seed}"
        firings += len(both[0].trace.firings())
    assert firings > 300


def _set_maths(net: PetriNet) -> list[str]:
    """Expressions that read a set place: a condition on them may see the values in between."""
    written = {p for t in net.transitions for p in t.sets}
    return [p.expression for p in net.places if hasattr(p, "expression") and any(name in p.expression for name in written)]
