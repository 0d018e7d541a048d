"""Module contracts: a good module keeps them, each planted fault breaks the clause it should, and every run shown is a real one."""

import random
from dataclasses import replace

import pytest
from contract_modules import added, broken, changed, turn_to_ball, without
from run_replay import Replay

from cprm_gym.architecture.analysis.budget import Budget
from cprm_gym.architecture.analysis.modules.contracts import check_contract
from cprm_gym.architecture.analysis.timed.environment import caller
from cprm_gym.architecture.analysis.timed.system import timed_system
from cprm_gym.architecture.analysis.verdicts import TITLES
from cprm_gym.architecture.petri import Belief, Executor, PetriNet, Place, Ports, Transition, flatten
from cprm_gym.errors import NetError


def test_a_good_module_keeps_every_clause():
    report = check_contract(turn_to_ball())
    assert report.holds is True
    assert {c.name for c in report.clauses} == set(TITLES)
    assert (report.complete, report.warnings) == (True, ())
    assert report.states > 10


@pytest.mark.parametrize("fault", list(broken()))
def test_each_planted_fault_breaks_its_clause_and_is_shown_by_a_real_run(fault):
    module, clause = broken()[fault]
    report = check_contract(module)
    assert report.holds is False
    assert clause in {c.name for c in report.broken}
    for c in report.broken:
        flat = flatten(module)
        moves, extra = caller(flat, idle_interrupts=True)
        replay = Replay(timed_system(flat, moves, extra))
        assert c.run
        end = replay.run(c.run)
        if c.loop:
            offset = c.run[-1].cycle
            assert replay.run([replace(s, cycle=offset) for s in c.loop]) == end


def test_a_module_that_answers_in_two_cycles_keeps_a_contract_of_two_cycles():
    slow = changed(turn_to_ball(), "stop", delay=2, priority=0)
    assert not check_contract(slow, k=1).clause("interruption").holds
    slow = changed(slow, "arrive", inhibitors={"off_axis": 3.0, "abort": 1})
    slow = changed(slow, "give_up", inhibitors=("abort",))
    slow = changed(slow, "lose", inhibitors=("ball_seen", "abort"))
    slow = changed(slow, "turn", inhibitors={"turns": 5, "abort": 1})
    late = check_contract(slow, k=1).clause("interruption")
    assert "not answered within 1 cycles" in late.why
    assert check_contract(slow, k=2).clause("interruption").holds is True


def test_what_the_ports_declare_is_the_default_number_of_cycles():
    module = turn_to_ball(within=4)
    assert check_contract(module).within == 4


def test_an_interrupt_kept_while_idle_is_declared_so():
    module = without(turn_to_ball(idle_interrupts="kept"), "drop")
    assert check_contract(module).clause("idle interrupt").holds is True
    eager = turn_to_ball(idle_interrupts="kept")
    assert "is consumed (declared: kept)" in check_contract(eager).clause("idle interrupt").why


def test_what_begin_overwrites_need_not_be_clean():
    forgetful = changed(turn_to_ball(), "give_up", sets={"watching": 0})
    assert check_contract(forgetful).clause("clean").holds is False
    assert check_contract(changed(forgetful, "start", sets={"turns": 0})).clause("clean").holds is True


def test_a_transition_that_never_fires_and_an_outcome_that_never_comes_are_warned_of():
    """The clock of `lose` starts anew whenever `turn` takes and returns its token: it never gets to two cycles."""
    module = changed(turn_to_ball(), "lose", inputs=("ongoing",))
    report = check_contract(module)
    assert report.holds is True
    assert report.warnings == ("transition 'lose' never fires", "outcome 'lost_ball' never comes")


def test_a_module_that_only_an_interrupt_ends_is_warned_of():
    watch = PetriNet(
        "watch",
        ports=Ports(begin="begin", ongoing="ongoing", done="done", errors=("aborted",), interrupts=("abort",)),
        places=tuple(Place(p, capacity=1) for p in ("begin", "ongoing", "done", "aborted", "abort")),
        transitions=(
            Transition("start", ("begin",), ("ongoing",)),
            Transition("stop", ("abort", "ongoing"), ("aborted",)),
            Transition("drop", ("abort",), (), inhibitors=("ongoing",)),
        ),
    )
    report = check_contract(watch)
    assert report.clause("may end").holds is True
    assert any("only an interrupt leads to an end" in w for w in report.warnings)


def test_bounds_on_what_is_observed_can_save_a_contract():
    module = changed(turn_to_ball(), "give_up", outputs=())
    assert check_contract(module).holds is False
    assert check_contract(module, bounds={"off_axis": (0.0, 2.0)}).clause("exclusive end").holds is True


def test_a_contract_with_a_module_inside_is_checked_through_and_through():
    inner = turn_to_ball()
    names = ("begin", "ongoing", "done", "failed", "abort")
    outer = PetriNet(
        "outer",
        ports=Ports(
            begin="begin",
            ongoing="ongoing",
            done="done",
            errors=("failed",),
            interrupts=("abort",),
            answers={"abort": ("failed", "done")},
        ),
        places=tuple(Place(p, capacity=1) for p in names),
        modules={"turn": inner},
        transitions=(
            Transition("start", ("begin",), ("ongoing", "turn.begin")),
            Transition("finish", ("turn.facing", "ongoing"), ("done",)),
            Transition("fail", ("turn.failed", "ongoing"), ("failed",)),
            Transition("lost", ("turn.lost_ball", "ongoing"), ("failed",)),
            Transition("stop", ("abort",), ("turn.abort",), tests=("turn.ongoing",), priority=20),
            Transition("late", ("abort",), (), inhibitors=("ongoing",), priority=20),
        ),
    )
    report = check_contract(outer)
    assert report.holds is True, str(report)
    hasty = check_contract(replace(outer, ports=replace(outer.ports, answers={})))
    assert "ends in 'done' instead of 'failed'" in hasty.clause("interruption").why
    assert [s.what for s in hasty.clause("interruption").run[-3:]] == ["turn.arrive", "caller interrupts: abort", "finish"]
    careless = replace(outer, transitions=tuple(t for t in outer.transitions if t.name != "lost"))
    assert check_contract(careless).clause("may end").holds is False


def test_a_spent_budget_leaves_clauses_unknown_but_keeps_what_is_broken():
    report = check_contract(broken()["fills a place"][0], most_tokens=100_000, budget=Budget(states=20_000))
    assert not report.complete
    assert report.clause("clean").holds is False
    assert report.clause("bounded").holds is None
    assert "states" in report.clause("bounded").why


def test_a_net_without_the_ports_of_a_behaviour_is_refused():
    with pytest.raises(NetError, match="'plain': a behaviour module has ports begin, ongoing"):
        check_contract(PetriNet("plain", (Place("p"),)))


def test_the_report_reads_as_text_and_as_json():
    report = check_contract(broken()["vanishes"][0])
    assert "BROKEN   exclusive end: 'ongoing' is empty, but no outcome is marked" in str(report)
    plain = report.to_json()
    assert plain["holds"] is False
    clause = next(c for c in plain["clauses"] if c["clause"] == "exclusive end")
    assert clause["run"][0][2] == "caller begins"


def test_object_parameters_and_further_ports_may_be_used_by_the_caller_at_any_time():
    module = added(turn_to_ball(), Place("request", capacity=1), Transition("serve", ("request",), (), tests=("ongoing",)))
    module = replace(module, ports=replace(module.ports, inputs=("request",)))
    assert check_contract(module).holds is True


def test_places_that_show_one_belief_are_one_variable():
    module = turn_to_ball()
    twin = replace(module, places=(*module.places, Belief("again", variable="ball.direction")))
    system = timed_system(changed(twin, "turn", tests={"off_axis": 3.0, "again": 1.0}))
    assert [v.places for v in system.variables if "again" in v.places] == [("bearing", "again")]


def test_every_run_shown_for_randomly_damaged_modules_is_a_real_one():
    shown = 0
    for seed in range(60):
        draw = random.Random(seed)
        module = turn_to_ball()
        for _ in range(draw.randint(1, 3)):
            t = draw.choice(module.transitions)
            places = [p.name for p in module.places if isinstance(p, Place)]
            damage = draw.choice(["gone", "output", "input", "delay", "sets", "priority"])
            if damage == "gone" and len(module.transitions) > 3:
                module = without(module, t.name)
            elif damage == "output":
                module = changed(module, t.name, outputs=(draw.choice(places),), set_wins=True)
            elif damage == "input":
                module = changed(module, t.name, inputs=tuple(draw.sample(places, 2)))
            elif damage == "delay":
                module = changed(module, t.name, delay=draw.randint(0, 3))
            elif damage == "sets":
                module = changed(module, t.name, sets={}, set_wins=True)
            elif damage == "priority":
                module = changed(module, t.name, priority=draw.randint(0, 12))
        report = check_contract(module, budget=Budget(states=60_000))
        moves, extra = caller(module, idle_interrupts=True)
        for c in report.broken:
            Replay(timed_system(module, moves, extra)).run(c.run)
            shown += len(c.run)
    assert shown > 300


def test_what_a_caller_does_resets_no_clock_with_resampling_memory():
    """In cycle 2 the work is over whether or not an abort is put at that instant."""
    module = PetriNet(
        "work",
        tuple(Place(p, capacity=1) for p in ("begin", "ongoing", "done", "failed", "abort")),
        (
            Transition("start", ("begin",), ("ongoing",)),
            Transition("end", ("ongoing",), ("done",), delay=2, memory="resampling"),
            Transition("stop", ("abort", "ongoing"), ("failed",), delay=1),
        ),
        ports=Ports(begin="begin", ongoing="ongoing", done="done", errors=("failed",), interrupts=("abort",), idle_interrupts="kept"),
    )
    clause = check_contract(module).clause("interruption")
    assert (clause.holds, clause.why) == (False, "interrupted by 'abort', it ends in 'done' instead of 'failed'")
    executor = Executor(module)
    executor.write("begin", 1)
    executor.step()
    executor.step()
    executor.write("abort", 1)
    executor.step()
    assert executor.read("done") == executor.read("abort") == 1
