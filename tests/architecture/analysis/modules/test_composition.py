"""Whether a net uses its modules as their contracts assume."""

from dataclasses import replace

from contract_modules import turn_to_ball

from cprm_gym.architecture.analysis.modules.composition import check_composition, handovers
from cprm_gym.architecture.petri import Input, PetriNet, Place, Ports, Transition


def caller_net(*more, without=()):
    """Turn to the ball again and again."""
    transitions = (
        Transition("begin", ("idle",), ("turn.begin", "waiting")),
        Transition("ahead", ("turn.facing", "waiting"), ("idle",), delay=1),
        Transition("failed", ("turn.failed", "waiting"), ("idle",), delay=1),
        Transition("lost", ("turn.lost_ball", "waiting"), ("idle",), delay=1),
        *more,
    )
    return PetriNet(
        "caller",
        places=(Place("idle", capacity=1, tokens=1), Place("waiting", capacity=1), Input("hurry")),
        modules={"turn": turn_to_ball()},
        transitions=tuple(t for t in transitions if t.name not in without),
    )


def kinds(net):
    report = check_composition(net)
    return {(m.instance, m.kind) for m in report.misuses}, report


def test_a_net_that_handles_every_outcome_in_turn_is_right():
    found, report = kinds(caller_net())
    assert found == set()
    assert (report.holds, report.complete) == (True, True)
    assert "as they assume" in str(report)


def test_an_outcome_that_nobody_takes_is_named_and_the_run_to_it_shown():
    found, report = kinds(caller_net(without=("lost",)))
    assert found == {("turn", "unhandled"), ("turn", "left lying")}
    lying = next(m for m in report.misuses if m.kind == "left lying")
    assert lying.run[-1].marking["turn.lost_ball"] == 1
    assert report.holds is False


def test_an_outcome_that_no_run_brings_needs_nobody_to_take_it():
    net = caller_net(without=("lost",))
    careful = replace(net, modules={"turn": replace(turn_to_ball(), transitions=tuple(
        t for t in turn_to_ball().transitions if "lost_ball" not in t.outputs))})  # fmt: skip
    assert kinds(careful)[0] == set()


def test_an_outcome_that_is_waited_for_in_vain_is_left_lying():
    net = caller_net(without=("failed",))
    stubborn = replace(
        net,
        places=(*net.places, Place("never", capacity=1)),
        transitions=(*net.transitions, Transition("failed", ("turn.failed", "never"), ("idle",))),
    )
    found, _ = kinds(stubborn)
    assert found == {("turn", "left lying")}


def test_a_call_while_the_module_is_busy_is_shown():
    found, report = kinds(caller_net(Transition("again", ("waiting",), ("turn.begin", "waiting"), tests={"hurry": 1}, delay=1)))
    assert ("turn", "out of turn") in found
    run = next(m for m in report.misuses if m.kind == "out of turn").run
    assert run[-1].marking["turn.begin"] == run[-1].marking["turn.ongoing"] == 1


def test_a_module_that_is_never_begun_is_named():
    found, _ = kinds(caller_net(without=("begin",)))
    assert ("turn", "never begun") in found


def test_a_net_without_modules_misuses_none():
    assert check_composition(PetriNet("plain", (Place("p"),))).holds is True


def test_what_each_outcome_leads_to_is_found():
    net = caller_net(without=("failed",))
    net = replace(
        net,
        places=(*net.places, Place("resting", capacity=1), Place("over", capacity=1)),
        modules={"turn": turn_to_ball(), "second": turn_to_ball()},
        transitions=(
            *net.transitions,
            Transition("again", ("turn.failed", "waiting"), ("second.begin", "resting")),
            Transition("end", ("second.facing", "resting"), ("over",)),
        ),
    )
    found = handovers(net)
    assert found["turn", "facing"] == found["turn", "lost_ball"] == (("turn", "begin"),)
    assert found["turn", "failed"] == (("second", "begin"),)
    assert found["second", "facing"] == found["second", "failed"] == ()


def slow_job(*more):
    """Works for three cycles."""
    return PetriNet(
        "job",
        (*(Place(p, capacity=1) for p in ("begin", "ongoing", "done", "inside")),),
        (Transition("s", ("begin",), ("ongoing", "inside")), Transition("e", ("ongoing", "inside"), ("done",), delay=3), *more),
        ports=Ports(begin="begin", ongoing="ongoing", done="done"),
    )


def user(*more, fuse=None, places=()):
    """Calls the job again and again."""
    begin = "m.begin" if not fuse or "m.begin" not in fuse else fuse["m.begin"]
    return PetriNet(
        "user",
        (Place("q", capacity=1, tokens=1), *places),
        (Transition("call", ("q",), (begin,)), Transition("fin", ("m.done",), ("q",), delay=1), *more),
        modules={"m": slow_job()},
        fuse=fuse or {},
    )


def test_a_net_that_takes_the_ongoing_of_a_module_is_shown_and_that_the_module_then_never_starts():
    found, report = kinds(user(Transition("kill", ("m.ongoing",), ("q",), delay=1)))
    assert found == {("m", "taken"), ("m", "never starts")}
    assert [s.what for s in next(m for m in report.misuses if m.kind == "taken").run] == ["call", "m.s", "kill"]
    assert [s.what for s in next(m for m in report.misuses if m.kind == "never starts").run] == ["call", "m.s", "kill", "call"]


def test_a_net_that_fuses_begin_with_a_place_of_its_own_and_takes_the_token_back_is_shown():
    fused = {"fuse": {"m.begin": "begin"}, "places": (Place("begin", capacity=1),)}
    assert kinds(user(**fused))[0] == set()
    found, _ = kinds(user(Transition("back", ("begin",), ("q",), priority=1), **fused))
    assert ("m", "taken") in found


def test_a_net_that_marks_a_fused_outcome_itself_is_shown():
    fused = {"fuse": {"m.done": "over"}, "places": (Place("over", capacity=1),)}
    net = user(Transition("cheat", (), ("over",), tests=("m.ongoing",), inhibitors=("over",), delay=1), **fused)
    net = replace(net, transitions=tuple(Transition("fin", ("over",), ("q",), delay=1) if t.name == "fin" else t for t in net.transitions))
    assert ("m", "put") in kinds(net)[0]


def test_a_transition_that_no_run_fires_misuses_nothing():
    assert kinds(user(Transition("kill", ("m.ongoing", "m.done"), ("q",))))[0] == set()


def test_an_outcome_that_only_the_module_itself_takes_is_unhandled():
    inner = PetriNet("inner", (Place("in", capacity=1),), (Transition("eat", ("in",), ()),), ports=Ports(inputs=("in",)))
    job = slow_job()
    job = replace(job, modules={"sub": inner}, fuse={"sub.in": "done"})
    net = replace(user(), modules={"m": job}, transitions=(Transition("call", ("q",), ("m.begin",)),))
    assert ("m", "unhandled") in kinds(net)[0]
