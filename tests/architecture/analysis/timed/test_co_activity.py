"""Which modules may be active together."""

from cprm_gym.architecture.analysis.behaviour.state_space import explore
from cprm_gym.architecture.analysis.report import analyze
from cprm_gym.architecture.analysis.timed.environment import closed_system
from cprm_gym.architecture.analysis.timed.properties import analyze_timed
from cprm_gym.architecture.petri import Executor, PetriNet, Place, Ports, Transition


def job(name):
    return PetriNet(
        name,
        tuple(Place(p, capacity=1) for p in ("begin", "ongoing", "done")),
        (Transition("s", ("begin",), ("ongoing",)), Transition("e", ("ongoing",), ("done",), delay=3)),
        ports=Ports(begin="begin", ongoing="ongoing", done="done"),
    )


def outer():
    """Walks; an abort makes it shout at the same time."""
    return PetriNet(
        "outer",
        ports=Ports(
            begin="begin", ongoing="ongoing", done="done", errors=("aborted",), interrupts=("abort",), within=9, idle_interrupts="kept"
        ),
        places=(*(Place(p, capacity=1) for p in ("begin", "ongoing", "done", "aborted", "abort", "two")), Place("over", capacity=2)),
        modules={"walk": job("walk"), "shout": job("shout")},
        transitions=(
            Transition("start", ("begin",), ("ongoing", "walk.begin")),
            Transition("call", ("abort",), ("shout.begin", "two"), tests=("ongoing",), priority=1),
            Transition("w", ("walk.done",), ("over",)),
            Transition("h", ("shout.done",), ("over",)),
            Transition("end", ("ongoing", "over"), ("done",), inhibitors=("two",)),
            Transition("end2", {"ongoing": 1, "over": 2, "two": 1}, ("aborted",)),
        ),
    )


def test_modules_that_run_together_once_their_caller_begins_are_together():
    """The sum of their tokens is 0 before anybody begins, and no law of the net with its caller."""
    modules = analyze_timed(outer()).modules
    assert modules.together["walk", "shout"].holds is True
    assert modules.invariants == {}
    executor = Executor(outer())
    executor.write("begin", 1)
    executor.step()
    executor.write("abort", 1)
    executor.step()
    assert executor.read("walk.ongoing") == executor.read("shout.ongoing") == 1


def test_an_invariant_that_holds_with_the_caller_still_proves_exclusion():
    net = PetriNet(
        "turns",
        (Place("idle", tokens=1),),
        (
            Transition("a", ("idle",), ("first.begin",)), Transition("b", ("first.done",), ("second.begin",)),
            Transition("c", ("second.done",), ("idle",), delay=1),
        ),
        modules={"first": job("first"), "second": job("second")},
    )  # fmt: skip
    modules = analyze_timed(net).modules
    assert modules.together["first", "second"].holds is False
    assert "= 1" in modules.invariants["first", "second"]


def test_the_invariants_of_a_module_hold_in_every_marking_that_its_caller_brings():
    """`ongoing + walk.begin + ... = 0` is what the net without a caller says, and what no run with one keeps."""
    system = closed_system(outer()).untimed
    markings = [system.describe(m) for m in explore(system).markings()]
    vectors = analyze(outer(), minimal=True).p_invariants.vectors
    assert vectors
    for vector in vectors:
        assert {sum(w * m.get(name, 0) for name, w in vector.weights.items()) for m in markings} == {vector.value}
