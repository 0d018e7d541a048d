"""The cycle: figures of the dissertation, the micro-cases that settle a dispute, commands, errors."""

import numpy as np
import pytest
from reference_interpreter import Reference

from cprm_gym.architecture.petri import (
    INFINITE,
    Belief,
    Command,
    Continuous,
    Executor,
    Input,
    Math,
    PetriNet,
    Place,
    Semantics,
    Transition,
)
from cprm_gym.errors import CommandError, ExpressionError, LivelockError, NetError, NotEnabled, UnknownName

FIG_2_5 = PetriNet(
    "figure_2_5",
    (Place("start", tokens=1), Place("after_a"), Place("for_c"), Place("for_d"), Place("end")),
    (
        Transition("A", ("start",), ("after_a",)),
        Transition("B", ("after_a",), ("for_c", "for_d"), delay=2),
        Transition("C", ("for_c",), ("for_d",), delay=3),
        Transition("D", ("for_d",), ("end",)),
    ),
)

FIG_2_6 = PetriNet(
    "figure_2_6",
    (Place("a_in", tokens=3), Place("b_in", tokens=1), Place("tested"), Place("inhibiting")),
    (
        Transition("A", ("a_in",), ("tested",), inhibitors=("inhibiting",), delay=1),
        Transition("B", ("b_in",), ("inhibiting",), tests=("tested",)),
    ),
)


def history(net: PetriNet, cycles: int, **inputs) -> list[tuple[int, str]]:
    """(cycle, transition) of every firing, the same in both interpreters."""
    executor = Executor(net, trace=True)
    reference = Reference(net)
    slow = []
    for cycle in range(cycles):
        now = {name: values[cycle] if isinstance(values, (list, tuple)) else values for name, values in inputs.items()}
        executor.step(now)
        slow += [(cycle, name) for name in reference.step(now, {}, {})[0]]
    fast = [(f.cycle, f.transition) for f in executor.trace.firings()]
    assert fast == slow
    return fast


def times(net: PetriNet, transition: str, cycles: int = 20, **inputs) -> list[int]:
    return [cycle for cycle, name in history(net, cycles, **inputs) if name == transition]


def test_figure_2_5_a_at_0_b_and_d_at_2_c_and_d_at_5():
    assert history(FIG_2_5, 8) == [(0, "A"), (2, "B"), (2, "D"), (5, "C"), (5, "D")]


def test_figure_2_6_b_waits_for_a_and_then_a_never_fires_again():
    assert history(FIG_2_6, 8) == [(1, "A"), (1, "B")]


def test_figure_2_6_without_the_test_arc_b_fires_at_once():
    free = PetriNet("free", FIG_2_6.places, (FIG_2_6.transitions[0], Transition("B", ("b_in",), ("inhibiting",))))
    assert history(free, 8) == [(0, "B")]


# -- micro-cases ------------------------------------------------------------------------------------------------------------------


def firings(*places: Place, **arcs) -> int:
    """How often one timed transition of delay 1 fires."""
    return len(times(PetriNet("micro", places, (Transition("t", delay=1, **arcs),)), "t"))


def test_case_1_an_inhibitor_arc_blocks_from_one_token():
    assert firings(Place("p", tokens=2), Place("q"), inputs=("p",), outputs=("q",), inhibitors=("q",)) == 1


def test_case_2_an_inhibitor_arc_of_threshold_two_allows_one_token():
    assert firings(Place("p", tokens=3), Place("q"), inputs=("p",), outputs=("q",), inhibitors={"q": 2}) == 2


@pytest.mark.parametrize(("rule", "expected"), [("strong", 3), ("weak", 0)])
def test_case_3_a_self_loop_on_a_full_place_is_enabled_by_its_net_effect_only(rule, expected):
    loop = Transition("t", ("p",), ("p",), delay=1)
    net = PetriNet("loop", (Place("p", capacity=1, tokens=1),), (loop,), semantics=Semantics(capacity=rule))
    assert len(times(net, "t", cycles=4)) == expected


def test_case_4_a_capacity_stops_the_transition_that_would_exceed_it():
    assert firings(Place("p", tokens=5), Place("q", capacity=2), inputs=("p",), outputs=("q",)) == 2


def test_case_5_the_set_value_wins_over_an_output_to_the_same_place():
    net = PetriNet("set", (Place("p", tokens=3), Place("q")), (Transition("t", ("p",), ("q",), sets={"q": 2}, delay=1, set_wins=True),))
    executor = Executor(net)
    seen = []
    for _ in range(6):
        executor.step()
        seen.append(int(executor.read("q")[0]))
    assert seen == [0, 2, 2, 2, 2, 2]
    assert executor.read("p")[0] == 0


def test_case_6_immediate_transitions_fire_before_timed_ones():
    net = PetriNet("vanishing", (Place("p", tokens=1), Place("q")), (
        Transition("b", ("p",), delay=1), Transition("a", ("p",), ("q",)),
    ))  # fmt: skip
    assert history(net, 5) == [(0, "a")]


def test_case_7_a_circle_of_immediates_is_a_livelock_and_is_named():
    net = PetriNet("trap", (Place("p", tokens=1), Place("q")), (Transition("t", ("p",), ("q",)), Transition("u", ("q",), ("p",))))
    with pytest.raises(LivelockError, match=r"more than 10000 immediate firings without becoming quiet: (t -> u -> t|u -> t -> u)"):
        Executor(net).step()
    with pytest.raises(LivelockError):
        Reference(net).step({}, {}, {})


@pytest.mark.parametrize(("memory", "expected"), [("enabling", 9), ("age", 6)])
def test_case_8_a_clock_is_forgotten_when_disabled_or_kept_by_age_memory(memory, expected):
    once = Transition("b", ("go",), inhibitors={"off": 1}, delay=5, memory=memory)
    net = PetriNet("pause", (Place("go", tokens=1), Input("off")), (once,))
    assert times(net, "b", off=[0, 0, 0, 1] + [0] * 16) == [expected]


@pytest.mark.parametrize(("persistence", "tokens", "expected"), [("intermediate", 1, 8), ("atomic", 1, 5), ("intermediate", 2, 5)])
def test_cases_9_and_10_taking_and_returning_the_last_token_read_restarts_the_clock(persistence, tokens, expected):
    net = PetriNet(
        "reader",
        (Place("p", tokens=tokens), Place("once", tokens=1), Place("todo", tokens=1)),
        (Transition("b", ("todo",), tests=("p",), delay=5), Transition("u", ("p", "once"), ("p",), delay=3)),
        semantics=Semantics(persistence=persistence),
    )
    assert times(net, "b") == [expected]


@pytest.mark.parametrize(("servers", "expected"), [(1, [5, 10, 15]), (INFINITE, [5, 5, 5]), (2, [5, 5, 10])])
def test_case_11_single_server_works_one_by_one_infinite_servers_at_once(servers, expected):
    net = PetriNet("queue", (Place("p", tokens=3, capacity=3),), (Transition("t", ("p",), delay=5, servers=servers),))
    assert times(net, "t") == expected


def test_case_12_a_timeout_disables_the_work_it_overtakes():
    net = PetriNet("timeout", (Place("p", tokens=1),), (Transition("work", ("p",), delay=7), Transition("timeout", ("p",), delay=4)))
    assert history(net, 12) == [(4, "timeout")]


def test_case_13_of_two_delays_due_at_once_the_first_declared_fires_and_the_tie_is_reported():
    net = PetriNet("tie", (Place("p", tokens=1),), (Transition("first", ("p",), delay=6), Transition("second", ("p",), delay=6)))
    assert history(net, 12) == [(6, "first")]
    executor = Executor(net)
    for _ in range(7):
        executor.step()
    assert [(c.fired, c.disabled, c.times) for c in executor.conflicts] == [("first", "second", 1)]


def test_case_14_a_test_and_an_input_arc_need_the_larger_of_the_two():
    assert firings(Place("p", tokens=2), inputs=("p",), tests={"p": 2}) == 1


# -- more of the rule -------------------------------------------------------------------------------------------------------------


def test_resampling_memory_restarts_at_any_firing():
    net = PetriNet("resample", (Place("p", tokens=1), Place("q", tokens=1)), (
        Transition("t", ("p",), delay=5, memory="resampling"), Transition("other", ("q",), delay=3),
    ))  # fmt: skip
    assert times(net, "t") == [8]


def test_a_clock_restarts_when_a_firing_in_the_same_instant_disables_and_another_enables_it_again():
    net = PetriNet("blink", (Place("p", tokens=1), Place("q"), Place("once", tokens=1), Place("todo", tokens=1)), (
        Transition("b", ("todo",), inhibitors=("q",), delay=5), Transition("on", ("once",), ("q",), delay=3), Transition("off", ("q",)),
    ))  # fmt: skip
    assert times(net, "b") == [8]


def test_higher_priority_fires_first_whatever_the_order_of_declaration():
    net = PetriNet("priority", (Place("p", tokens=1),), (Transition("low", ("p",)), Transition("high", ("p",), priority=1)))
    executor = Executor(net, trace=True)
    executor.step()
    assert [f.transition for f in executor.trace.firings()] == ["high"]
    assert executor.conflicts == []


def test_conflict_between_immediates_of_equal_priority_is_reported():
    net = PetriNet("choice", (Place("p", tokens=1),), (Transition("left", ("p",)), Transition("right", ("p",))))
    executor = Executor(net, batch=3)
    executor.step()
    assert executor.conflicts == [("left", "right", 3)]


def test_random_choice_follows_the_weights_and_the_seed():
    fork = (Transition("left", ("p",), ("l",), weight=3.0), Transition("right", ("p",), ("r",), weight=1.0))
    net = PetriNet("fork", (Place("p", tokens=1), Place("l"), Place("r")), fork, semantics=Semantics(choice="random"))
    executor = Executor(net, batch=4000, seed=5)
    executor.step()
    share = executor.read("l").mean()
    assert abs(share - 0.75) < 5 * np.sqrt(0.75 * 0.25 / 4000)
    again = Executor(net, batch=7, seed=5)
    again.step()
    assert (again.read("l") == executor.read("l")[:7]).all()
    other = Executor(net, batch=4000, seed=6)
    other.step()
    assert (other.read("l") != executor.read("l")).any()


def test_random_choice_goes_on_over_resets_and_begins_anew_with_a_seed():
    fork = (Transition("left", ("p",), ("l",)), Transition("right", ("p",), ("r",)))
    net = PetriNet("fork", (Place("p", tokens=1), Place("l"), Place("r")), fork, semantics=Semantics(choice="random"))
    executor = Executor(net, batch=64, seed=5)
    runs = []
    for seed in (None, None, 5):
        executor.reset(seed=seed)
        executor.step()
        runs.append(executor.read("l").tolist())
    assert runs[0] != runs[1]
    assert runs[0] == runs[2]


def test_inputs_of_any_memory_layout_are_read_alike():
    values = np.asfortranarray(np.arange(8.0).reshape(4, 2))
    values.flags.writeable = False
    executor = Executor(WATCH, batch=4)
    executor.step(values)
    executor.step(values[::-1])
    assert executor.read("far").tolist() == [7, 5, 3, 1]


def test_test_and_inhibitor_arcs_of_one_threshold_are_exact_complements_on_real_values():
    net = PetriNet("cut", (Input("x"), Place("n"), Place("y")), (
        Transition("above", outputs=("y",), tests={"x": 0.3}, delay=1), Transition("below", outputs=("n",), inhibitors={"x": 0.3}, delay=1),
    ))  # fmt: skip
    values = np.concatenate([np.random.default_rng(0).normal(size=500), [0.3, np.nextafter(0.3, 0), np.nextafter(0.3, 1)]])
    executor = Executor(net, batch=len(values))
    for _ in range(2):
        executor.step({"x": values})
    assert (executor.read("y") == (values >= 0.3)).all()
    assert (executor.read("n") == (values < 0.3)).all()


def test_infinite_servers_beyond_the_clocks_of_an_unbounded_place_are_an_error():
    net = PetriNet("many", (Place("p", tokens=300),), (Transition("t", ("p",), delay=2, servers=INFINITE),))
    with pytest.raises(NetError, match=r"'t' has infinite servers and is enabled more often than it has clocks \(256\)"):
        Executor(net).step()


def test_copies_are_independent_and_alike():
    rng = np.random.default_rng(3)
    net = PetriNet("walk", (Input("x"), Place("n", capacity=40)), (Transition("t", outputs=("n",), tests={"x": 0.0}, delay=1),))
    values = rng.normal(size=(20, 5))
    batch = Executor(net, batch=5)
    for row in values:
        batch.step({"x": row})
    for copy in range(5):
        alone = Executor(net)
        for row in values:
            alone.step({"x": row[copy]})
        assert alone.read("n")[0] == batch.read("n")[copy]


# -- values from outside ------------------------------------------------------------------------------------------------------------

WATCH = PetriNet(
    "watch",
    (
        Input("seen", observes="ball.seen"),
        Input("far", observes="ball.distance", value=100),
        Input("far_too", observes="ball.distance", value=100),
        Belief("bearing", variable="ball.direction"),
        Continuous("gain", 0.5),
        Math("moment", "gain * bearing"),
        Place("turned", capacity=99),
    ),
    (Transition("turn", outputs=("turned",), tests=("seen",), delay=1, emits=Command("turn", moment="moment", style=2)),),
)


def test_inputs_and_beliefs_are_named_in_order():
    executor = Executor(WATCH)
    assert executor.input_names == ("ball.seen", "ball.distance")
    assert executor.belief_names == ("bearing",)
    assert executor.belief_places[0].variable == "ball.direction"
    assert executor.command_names == ("turn",)


def test_arrays_and_names_write_the_same():
    by_array, by_name = Executor(WATCH, batch=2), Executor(WATCH, batch=2)
    for _ in range(2):
        a = by_array.step(np.array([[1, 5.0], [0, 7.0]]), beliefs=np.array([[30.0], [40.0]]))
        b = by_name.step({"ball.seen": [1, 0], "ball.distance": np.array([5.0, 7.0])}, beliefs={"bearing": [30.0, 40.0]})
    assert a.of(0) == b.of(0) == {"turn": {"moment": 15.0, "style": 2.0}}
    assert a.of(1) == b.of(1) == {}
    assert (by_array.read("far_too") == [5.0, 7.0]).all()
    assert (by_name.read("far_too") == [5.0, 7.0]).all()


def test_what_is_not_given_keeps_its_value():
    executor = Executor(WATCH)
    executor.step({"ball.seen": 1, "ball.distance": 3})
    executor.step()
    assert executor.read("far")[0] == 3
    assert executor.read("turned")[0] == 1


def test_unknown_input_lists_what_is_known():
    with pytest.raises(UnknownName, match=r"unknown input 'ball\.sen'. Did you mean 'ball\.seen'\? Known: ball\.distance, ball\.seen"):
        Executor(WATCH).step({"ball.sen": 1})


def test_unknown_belief_lists_what_is_known():
    with pytest.raises(UnknownName, match="unknown belief place 'bearin'"):
        Executor(WATCH).step(beliefs={"bearin": 1})


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_number_that_is_not_finite_is_refused_with_the_place(bad):
    with pytest.raises(NetError, match=r"'ball.distance' \(place 'far', 'far_too'\) is"):
        Executor(WATCH).step({"ball.distance": bad})
    with pytest.raises(NetError, match=r"`inputs`: 'ball\.distance' \(place 'far'\) of copy 1 is"):
        Executor(WATCH, batch=2).step(np.array([[1.0, 1.0], [1.0, bad]]))
    with pytest.raises(NetError, match=r"`beliefs`: 'bearing' \(place 'bearing'\) of copy 0 is"):
        Executor(WATCH).step(beliefs=np.array([[bad]]))


def test_wrong_shapes_say_what_is_wanted():
    with pytest.raises(NetError, match=r"`inputs` must have shape \(3, 2\): ball\.seen, ball\.distance; got \(2, 3\)"):
        Executor(WATCH, batch=3).step(np.zeros((2, 3)))
    with pytest.raises(NetError, match=r"takes a number or an array of shape \(3,\), got \(2,\)"):
        Executor(WATCH, batch=3).step({"ball.seen": [1, 2]})


def test_undefined_math_names_place_expression_and_operands():
    net = PetriNet("ratio", (Input("x", value=1), Input("y", value=1), Math("r", "x / y")))
    with pytest.raises(
        ExpressionError, match=r"net 'ratio', copy 1, cycle 0: math place 'r' = 'x / y' has no finite value at x = 3, y = 0"
    ):
        Executor(net, batch=2).step({"x": 3, "y": [1, 0]})


def test_guarded_math_is_defined():
    net = PetriNet("ratio", (Input("x"), Input("y"), Math("r", "x / y if y != 0 else -1")))
    executor = Executor(net)
    executor.step({"x": 3, "y": 0})
    assert executor.read("r")[0] == -1


def test_the_other_copies_finish_the_cycle_when_one_fails():
    net = PetriNet("ratio", (Input("y", value=1), Math("r", "1 / y"), Place("n", capacity=9)), (Transition("t", outputs=("n",), delay=1),))
    executor = Executor(net, batch=3)
    executor.step({"y": 1})
    with pytest.raises(ExpressionError, match="copy 1"):
        executor.step({"y": [1, 0, 1]})
    assert executor.read("n").tolist() == [1, 0, 1]
    assert executor.cycle.tolist() == [2, 1, 2]
    executor.reset(mask=[False, True, False])
    executor.step({"y": 1})
    assert executor.cycle.tolist() == [3, 1, 3]


def test_math_is_current_for_the_next_immediate_transition():
    net = PetriNet("current", (Place("n"), Math("twice", "2 * n")), (Transition("count", outputs=("n",), inhibitors={"twice": 6}),))
    executor = Executor(net)
    executor.step()
    assert executor.read("n")[0] == 3
    assert executor.read("twice")[0] == 6


# -- commands -----------------------------------------------------------------------------------------------------------------------


def test_parameters_are_read_before_the_transitions_own_tokens_move():
    net = PetriNet("before", (Place("n", tokens=3),), (Transition("t", ("n",), delay=1, emits=Command("say", count="n")),))
    executor = Executor(net)
    said = [executor.step().of() for _ in range(4)]
    assert said == [{}, {"say": {"count": 3.0}}, {"say": {"count": 2.0}}, {"say": {"count": 1.0}}]


BODY = PetriNet(
    "body",
    (Place("p", tokens=1), Place("q", tokens=1), Place("r", tokens=1)),
    (
        Transition("slow", ("p",), emits=Command("dash", power=10)),
        Transition("fast", ("q",), emits=Command("kick", power=90), priority=-1),
        Transition("look", ("r",), emits=Command("turn_neck", angle=5)),
    ),
)


def test_of_two_exclusive_commands_the_higher_priority_goes_out_and_the_other_is_reported():
    executor = Executor(BODY, exclusive=[("dash", "kick", "turn")])
    commands = executor.step()
    assert commands.of() == {"dash": {"power": 10.0}, "turn_neck": {"angle": 5.0}}
    assert commands.overruled[0].tolist() == [False, True, False]
    assert executor.net.transition_names[commands.source["dash"][0]] == "slow"


def test_a_later_command_of_higher_priority_overrules_the_earlier():
    late = Transition("late", ("go",), emits=Command("kick", power=1), priority=3, delay=1)
    early = Transition("early", ("p",), ("go",), emits=Command("dash", power=2), delay=1, priority=5)
    net = PetriNet("late", (Place("p", tokens=1), Place("go", tokens=1)), (late, early))
    executor = Executor(net, exclusive=[("dash", "kick")])
    executor.step()
    assert executor.step().of() == {"dash": {"power": 2.0}}
    reverse = PetriNet("late", (Place("p", tokens=1), Place("go")), (
        Transition("early", ("p",), ("go",), emits=Command("dash", power=2)),
        Transition("late", ("go",), emits=Command("kick", power=1), priority=3),
    ))  # fmt: skip
    commands = Executor(reverse, exclusive=[("dash", "kick")]).step()
    assert commands.of() == {"kick": {"power": 1.0}}
    assert commands.overruled[0].tolist() == [True, False]


def test_strict_mode_refuses_two_exclusive_commands():
    with pytest.raises(CommandError, match="two commands in one cycle, 'dash' of 'slow' and 'kick' of 'fast'"):
        Executor(BODY, exclusive=[("dash", "kick")], strict=True).step()


def test_commands_without_a_group_do_not_compete():
    assert set(Executor(BODY).step().of()) == {"dash", "kick", "turn_neck"}


def test_one_command_with_two_sets_of_parameters_is_refused():
    net = PetriNet("two", (Place("p"),), (
        Transition("a", ("p",), emits=Command("kick", power=1)), Transition("b", ("p",), emits=Command("kick", angle=1)),
    ))  # fmt: skip
    with pytest.raises(NetError, match=r"command 'kick' with parameters \['angle'\]; elsewhere it has \['power'\]"):
        Executor(net)


# -- by hand ------------------------------------------------------------------------------------------------------------------------


def test_firing_a_transition_without_tokens_names_the_missing_place():
    net = PetriNet("striker", (Place("body", 1), Place("has_ball", 1), Place("full", 1, 1), Input("obstacle", value=2)), (
        Transition("shoot", ("body", "has_ball"), ("full",), inhibitors={"obstacle": 1.5}),
    ))  # fmt: skip
    reasons = "body needs 1, has 0; has_ball needs 1, has 0; obstacle must be below 1.5, has 2; full is full with 1"
    with pytest.raises(NotEnabled, match=f"transition 'shoot' is not enabled: {reasons}"):
        Executor(net).fire("shoot")


def test_transitions_can_be_fired_by_hand():
    executor = Executor(FIG_2_5)
    assert executor.enabled() == ("A",)
    executor.fire("A")
    executor.fire("B")
    assert executor.enabled() == ("C", "D")


def test_snapshot_and_restore_continue_alike():
    executor = Executor(FIG_2_5, trace=True)
    for _ in range(3):
        executor.step()
    kept = executor.snapshot()
    first = [(executor.step(), executor.marking.tolist())[1] for _ in range(4)]
    executor.restore(kept)
    assert [(executor.step(), executor.marking.tolist())[1] for _ in range(4)] == first
    with pytest.raises(NetError, match=r"snapshot: `row` must have shape"):
        Executor(FIG_2_5, batch=2).restore(kept)


@pytest.mark.parametrize("copies", [[7], 3, [True, False]])
def test_copies_that_are_not_there_are_named(copies):
    executor = Executor(FIG_2_5, batch=3)
    with pytest.raises(NetError, match=r"`copies` are of 0 to 2"):
        executor.snapshot(copies)
    with pytest.raises(NetError, match=r"`copies` are of 0 to 2"):
        executor.restore(executor.snapshot(), copies)


def test_reset_with_a_mask_resets_those_copies_only():
    executor = Executor(FIG_2_5, batch=3)
    for _ in range(3):
        executor.step()
    executor.reset(mask=np.array([True, False, True]))
    assert executor.read("start").tolist() == [1, 0, 1]
    executor.reset()
    assert executor.read("start").tolist() == [1, 1, 1]
    with pytest.raises(NetError, match="`mask` must have shape"):
        executor.reset(mask=[True])


def test_writing_a_place_is_checked():
    executor = Executor(WATCH, batch=2)
    executor.write("turned", [4, 5])
    executor.write("gain", 2.5, which=[1])
    assert executor.read("turned").tolist() == [4, 5]
    assert executor.read("gain").tolist() == [0.5, 2.5]
    for place, value, message in (
        ("turned", 100, "holds 0 to 99 tokens, got 100"),
        ("turned", -1, "holds 0 to 99 tokens"),
        ("turned", 1.5, "holds whole numbers"),
        ("gain", np.nan, "holds finite numbers"),
        ("moment", 1, "is set by its math transition"),
        ("turnd", 1, "unknown place 'turnd'. Did you mean 'turned'?"),
    ):
        with pytest.raises(NetError, match=message):
            executor.write(place, value)


def test_marking_is_a_view_that_cannot_be_written():
    executor = Executor(FIG_2_5)
    with pytest.raises(ValueError, match="read-only"):
        executor.marking[0, 0] = 3


def test_cycle_compiles_once():
    """One kernel for every net: a second net must not compile another."""
    from cprm_gym.architecture.petri.execution.kernels.cycle import cycle

    Executor(FIG_2_5).step()
    Executor(WATCH, batch=3).step()
    assert len(cycle.signatures) == 1


# -- traces -------------------------------------------------------------------------------------------------------------------------


def test_trace_says_what_fired_when_why_and_what_was_enabled():
    executor = Executor(FIG_2_5, trace=True)
    for _ in range(6):
        executor.step()
    found = executor.trace.firings()
    assert [(f.cycle, f.transition, f.timed) for f in found] == [
        (0, "A", False), (2, "B", True), (2, "D", False), (5, "C", True), (5, "D", False),
    ]  # fmt: skip
    assert found[2].enabled == ("C", "D")
    assert found[1].reason == "timed: enabled for its delay of 2 cycles"
    assert executor.trace.text().splitlines()[0] == "cycle 0: A fired (immediate: the only one enabled)"


def test_trace_can_be_replayed():
    net = PetriNet("fork", (Place("p", tokens=1), Place("l"), Input("x")), (
        Transition("left", ("p",), ("l",), tests={"x": 0}), Transition("right", ("p",), inhibitors={"x": 0}),
        Transition("back", ("l",), ("p",), delay=1),
    ), semantics=Semantics(choice="random"))  # fmt: skip
    executor = Executor(net, batch=3, seed=1, trace=True)
    rng = np.random.default_rng(0)
    for _ in range(10):
        executor.step({"x": rng.normal(size=3)})
    other = Executor(net, batch=3)
    other.replay(executor.trace)
    assert (other.marking == executor.marking).all()


def test_replay_in_another_net_names_the_cycle_that_differs():
    executor = Executor(FIG_2_5, trace=True)
    for _ in range(6):
        executor.step()
    slower = PetriNet(
        "slower",
        FIG_2_5.places,
        tuple(t if t.name != "C" else Transition("C", ("for_c",), ("for_d",), delay=4) for t in FIG_2_5.transitions),
    )
    with pytest.raises(NetError, match="replay differs in cycle 5: C, D, now nothing fired"):
        Executor(slower).replay(executor.trace)


def test_trace_grows_with_the_firings_of_one_cycle():
    net = PetriNet("burst", (Place("n", tokens=3000),), (Transition("t", ("n",)),))
    executor = Executor(net, trace=True)
    executor.step()
    assert len(executor.trace.firings()) == 3000
    assert executor.read("n")[0] == 0


def test_why_not_tells_how_far_the_clock_of_an_enabled_transition_is():
    net = PetriNet("n", (Place("a"), Place("b")), (Transition("slow", ("a",), ("b",), delay=3), Transition("now", ("b",))))
    executor = Executor(net, batch=2)
    assert executor.why_not("slow") == ["a needs 1, has 0"]
    executor.write("a", 1, which=[1])
    assert executor.why_not("slow", 1) == ["enabled, but its clock of 3 cycles starts when the next cycle has become quiet"]
    for count in range(3):
        executor.step()
        assert executor.why_not("slow", 1) == [f"enabled, but its clock is at {count} of 3"]
    assert executor.why_not("slow", 0) == ["a needs 1, has 0"]
    assert executor.enabled(1) == ("slow",)
    executor.fire("slow", 1)  # by hand, whatever the clock says
    assert executor.why_not("now", 1) == []


def test_clocks_are_read_by_name():
    net = PetriNet(
        "n",
        (Place("a", capacity=2, tokens=2), Place("b"), Place("hold")),
        (
            Transition("many", ("a",), ("b",), delay=3, servers=2),
            Transition("old", delay=5, inhibitors={"hold": 1}, memory="age", outputs=("b",)),
            Transition("at_once", ("b",)),
        ),
    )
    executor = Executor(net, batch=2)
    assert executor.clocks("many").tolist() == [[-1, -1], [-1, -1]]
    executor.step()
    executor.step()
    assert executor.clocks("many").tolist() == [[1, 1], [1, 1]]
    executor.write("hold", 1, which=[0])
    executor.step()
    executor.step()
    assert executor.clocks("old").tolist() == [[2], [3]]  # stopped, and kept
    assert executor.clocks("at_once").shape == (2, 0)
    with pytest.raises(NetError, match=r"unknown transition 'manny'\. Did you mean 'many'"):
        executor.clocks("manny")


def test_a_copy_that_is_not_there_is_refused():
    executor = Executor(PetriNet("n", (Place("a"),), (Transition("t", ("a",)),)), batch=2)
    for ask in (executor.enabled, lambda copy: executor.why_not("t", copy), lambda copy: executor.fire("t", copy)):
        for copy in (2, -1, "0"):
            with pytest.raises(NetError, match="`copy` is 0 to 1, got"):
                ask(copy)


@pytest.mark.parametrize(
    ("act", "message"),
    [
        (lambda e: e.step({"x": 10**400}), "'x' .* is 1000"),
        (lambda e: e.step({"x": [10**400, 1]}), r"'x' takes numbers, got \[1000"),
        (lambda e: e.step({"x": "much"}), "'x' takes numbers, got 'much'"),
        (lambda e: e.step({"x": object()}), "'x' takes numbers, got <object"),
        (lambda e: e.step([["a"], ["b"]]), "`inputs` takes numbers"),
        (lambda e: e.write("a", "one"), "place 'a' takes numbers, got 'one'"),
        (lambda e: e.write("a", 1, which=[2]), r"place 'a': one value or one for each of the copies \[2\] of 2"),
        (lambda e: e.write("a", [1, 2, 3]), r"one for each of the 2 copies; got values of shape \(3,\)"),
        (lambda e: e.write("a", 10**400), "place 'a' takes numbers, got 1000"),
    ],
)
def test_what_is_no_number_is_refused_in_our_own_words(act, message):
    executor = Executor(PetriNet("n", (Place("a"), Input("x")), (Transition("t", ("a",)),)), batch=2)
    with pytest.raises(NetError, match=message):
        act(executor)
