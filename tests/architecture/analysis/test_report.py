"""The timed view, co-activity of modules, and the report of ``cprm-gym analyze``."""

import io
import json

import pytest
from contract_modules import broken, turn_to_ball
from rich.console import Console
from structure_nets import flexible_manufacturing, philosophers, producer, random_net

from cprm_gym.architecture.analysis.budget import Budget
from cprm_gym.architecture.analysis.report import analyze
from cprm_gym.architecture.analysis.timed.properties import analyze_timed, may_reach
from cprm_gym.architecture.petri import Input, PetriNet, Place, Ports, Transition
from cprm_gym.architecture.petri.files.pnml_writer import write_pnml
from cprm_gym.errors import FormatError, UnknownName


def act(name):
    """A module that works for two cycles."""
    return PetriNet(
        name,
        ports=Ports(begin="begin", ongoing="ongoing", done="done"),
        places=tuple(Place(p, capacity=1) for p in ("begin", "ongoing", "done")),
        transitions=(Transition("start", ("begin",), ("ongoing",)), Transition("end", ("ongoing",), ("done",), delay=2)),
    )


def kick():
    """Look and aim at once, then shoot (Fig. 2.3)."""
    return PetriNet(
        "kick",
        places=(Place("go", tokens=1), Place("again")),
        modules={"look": act("look"), "aim": act("aim"), "shoot": act("shoot")},
        transitions=(
            Transition("both", ("go",), ("look.begin", "aim.begin")),
            Transition("ready", ("look.done", "aim.done"), ("shoot.begin",)),
            Transition("rest", ("shoot.done",), ("again",)),
            Transition("repeat", ("again",), ("go",), delay=1),
        ),
    )


def test_modules_that_may_be_active_together_are_found_with_a_run_and_the_others_excluded_with_an_invariant():
    modules = analyze_timed(kick()).modules
    assert modules.instances == ("look", "aim", "shoot")
    together = modules.together["look", "aim"]
    assert together.holds is True
    assert {"look.ongoing", "aim.ongoing"} <= set(together.run[-1].marking)
    for pair in (("look", "shoot"), ("aim", "shoot")):
        assert modules.together[pair].holds is False
        assert f"{pair[0]}.ongoing" in modules.invariants[pair]
        assert f"{pair[1]}.ongoing" in modules.invariants[pair]
    assert modules.sets == (("shoot",), ("look", "aim"))


def test_exclusion_that_only_inputs_decide_is_found_by_exploration():
    net = PetriNet(
        "either",
        places=(Place("go", tokens=1), Input("near")),
        modules={"a": act("a"), "b": act("b")},
        transitions=(
            Transition("one", ("go",), ("a.begin",), tests={"near": 0.5}),
            Transition("two", ("go",), ("b.begin",), inhibitors={"near": 0.5}),
            Transition("back", ("a.done",), ("go",)),
            Transition("forth", ("b.done",), ("go",)),
        ),
    )
    assert analyze_timed(net).modules.together["a", "b"].holds is False


def test_a_running_net_that_comes_to_a_standstill_is_shown_how():
    net = PetriNet(
        "stop",
        (Place("p", tokens=1), Place("q"), Place("end"), Input("x")),
        (
            Transition("a", ("p",), ("q",), delay=2, tests={"x": 1}),
            Transition("b", ("q",), ("p",), delay=1),
            Transition("c", ("q",), ("end",), tests={"x": 5}),
        ),
    )
    found = analyze_timed(net)
    assert found.never_stops.holds is False
    assert [s.what for s in found.never_stops.run if s.kind == "fires"] == ["a", "c"]
    assert found.reversible.holds is False
    assert found.dead_transitions == ()


def test_conflict_confusion_and_ties_are_told_apart():
    conflict = PetriNet(
        "conflict", (Place("p", tokens=1), Place("q"), Place("r")), (Transition("a", ("p",), ("q",)), Transition("b", ("p",), ("r",)))
    )
    found = analyze_timed(conflict)
    assert found.deterministic.holds is False
    assert {(c.first, c.second, c.kind) for c in found.conflicts} == {("a", "b", "conflict"), ("b", "a", "conflict")}
    free = PetriNet("free", (Place("p", tokens=1), Place("q", tokens=1)), (Transition("a", ("p",)), Transition("b", ("q",))))
    assert analyze_timed(free).deterministic.holds is True
    confused = PetriNet(
        "confused",
        (Place("p", tokens=1), Place("q", tokens=1), Place("r", capacity=1)),
        (Transition("a", ("p",), sets={"r": 1}), Transition("b", ("q",), sets={"r": 0})),
    )
    assert [(c.first, c.second, c.kind) for c in analyze_timed(confused).conflicts] == [("a", "b", "confusion")]
    tie = PetriNet(
        "tie", (Place("p", tokens=1), Place("q", tokens=1)), (Transition("a", ("p",), delay=2), Transition("b", ("q",), delay=2))
    )
    assert [(c.first, c.second, c.kind) for c in analyze_timed(tie).conflicts] == [("a", "b", "tie")]
    assert analyze_timed(tie).deterministic.holds is True


def test_a_loop_of_immediate_transitions_is_shown():
    net = PetriNet("trap", (Place("p", tokens=1), Place("q")), (Transition("t", ("p",), ("q",)), Transition("u", ("q",), ("p",))))
    found = analyze_timed(net).becomes_quiet
    assert (found.holds, found.why) == (False, "fires for ever in one instant: t -> u")
    assert [s.what for s in found.loop] == ["t", "u"]


def test_an_unbounded_running_net_is_stopped_at_the_limit():
    net = PetriNet("grow", (Place("p", tokens=1), Place("n")), (Transition("t", ("p",), ("p", "n"), delay=1),))
    found = analyze_timed(net)
    assert (found.bounded.holds, found.complete, found.reason) == (False, False, "unbounded")
    assert found.bounded.run[-1].marking["n"] == 255


def test_a_spent_budget_leaves_the_timed_view_unknown():
    found = analyze_timed(random_net(5), Budget(seconds=0.0))
    if not found.complete:
        assert found.never_stops.holds is None or found.never_stops.run
    big = analyze_timed(PetriNet(
        "clocks", tuple(Place(f"p{k}", tokens=1) for k in range(6)),
        tuple(Transition(f"t{k}", (f"p{k}",), (f"p{k}",), delay=d) for k, d in enumerate((7, 11, 13, 17, 19, 23))),
    ), Budget(states=5_000))  # fmt: skip
    assert (big.complete, big.reason, big.reversible.holds) == (False, "states", None)


@pytest.mark.parametrize(
    "net", [producer(None), producer(2), philosophers(3), flexible_manufacturing(1), kick(), turn_to_ball()], ids=lambda n: n.name
)
def test_the_report_is_plain_json_and_can_be_shown(net):
    report = analyze(net)
    plain = json.loads(report.text())
    assert plain["name"] == net.name
    assert plain["untimed"]["states"] == report.untimed.states > 0
    console = Console(width=120, record=True, file=io.StringIO())
    console.print(report.render())
    assert net.name in console.export_text()


def test_a_behaviour_module_is_analysed_with_a_caller_and_its_contract():
    report = analyze(turn_to_ball())
    assert report.contract.holds is True
    assert report.untimed.dead_transitions == ()
    assert report.timed.dead_transitions == ()
    faulty, _ = broken()["two outcomes"]
    assert analyze(faulty).contract.holds is False
    assert analyze(faulty, contract=False).contract is None


def test_minimal_invariants_are_found_when_asked_for():
    report = analyze(producer(2), minimal=True)
    assert all(min(v.weights.values()) > 0 for v in report.p_invariants.vectors)


def test_a_net_in_a_file_is_analysed_and_a_name_of_a_module_is_not_imported(tmp_path):
    write_pnml(turn_to_ball(), tmp_path / "net.pnml")
    assert analyze(tmp_path / "net.pnml").name == turn_to_ball().name
    with pytest.raises(FormatError, match="no file 'os:abort'"):
        analyze("os:abort")


def test_whether_a_module_may_ever_become_active_is_answered_with_a_run():
    """The question of §2.2.6."""
    found = may_reach(kick(), {"shoot.ongoing": 1})
    assert found.holds is True
    assert [s.what for s in found.run[-3:]] == ["aim.end", "ready", "shoot.start"]
    assert may_reach(kick(), {"shoot.ongoing": 1, "look.ongoing": 1}).holds is False
    with pytest.raises(UnknownName, match=r"Did you mean 'shoot.ongoing'"):
        may_reach(kick(), {"shot.ongoing": 1})
