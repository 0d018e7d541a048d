"""Independent groups are found, analysed apart and recombined to what the whole is; what the agent couples is noticed."""

import numpy as np
import pytest

from cprm_gym.architecture.analysis.markov.absorption import absorption
from cprm_gym.architecture.analysis.markov.chain import NEVER
from cprm_gym.architecture.analysis.product.explore import product
from cprm_gym.architecture.analysis.product.prm_world import PRMWorld
from cprm_gym.architecture.analysis.product.subdivision import analyze_apart, coupled, groups, subdivide
from cprm_gym.architecture.petri import Command, Continuous, Input, Math, PetriNet, Place, Transition
from cprm_gym.architecture.prm import BOOL, Attribute, Model, Prior, PRMClass, Relation, Replace, Table, prev
from cprm_gym.architecture.prm.grounding.grounding import Grounding
from cprm_gym.errors import UnknownName


def balls(names=("one", "two"), seen=("one", "two"), turned=(), **options):
    """Balls that come ahead and go, each by itself; a command ``turn_one`` helps the first."""
    table = Table({"no": (0.9, 0.1), "yes": (0.3, 0.7)})
    ball = PRMClass("Ball", attributes=(Attribute("ahead", BOOL, table, parents=(prev("ahead"),), initial=Prior((0.8, 0.2))),))
    helped = Table({"no": (0.5, 0.5), "yes": (0.2, 0.8)})
    turning = Relation("turning", roles=(("b", "Ball"),), changes=(Replace("b.ahead", parents=(prev("b.ahead"),), cpd=helped),))
    model = Model("balls", (ball,), (turning,))
    options.setdefault("relations", {f"turning({name})": f"turn_{name}" for name in turned})
    return PRMWorld(Grounding(model, dict.fromkeys(names, "Ball")), {n: f"{n}.ahead" for n in seen}, **options)


def watcher(name, delay, turn=None, most=9):
    """Places and transitions that wait until a ball is ahead for some cycles; gives up now and then."""
    places = [Place(f"{name}_on", capacity=1, tokens=1), Place(f"{name}_got", capacity=1), Place(f"{name}_gone", capacity=1),
              Place(f"{name}_waits", capacity=most), Input(f"{name}_seen", observes=name),
              Math(f"{name}_clear", f"{name}_seen * share")]  # fmt: skip
    transitions = [
        Transition(f"{name}_get", (f"{name}_on",), (f"{name}_got",), tests={f"{name}_clear": 1.0}, delay=delay),
        Transition(f"{name}_wait", (), (f"{name}_waits",), tests=(f"{name}_on",), inhibitors={f"{name}_waits": most}, delay=1,
                   emits=Command(turn) if turn else None),
        Transition(f"{name}_leave", (f"{name}_on",), (f"{name}_gone",), tests={f"{name}_waits": most}),
    ]  # fmt: skip
    return places, transitions


def together(*parts, extra=()):
    places = [p for part in parts for p in part[0]]
    return PetriNet("both", (*places, Continuous("share", 1.0)), (*(t for part in parts for t in part[1]), *extra))


OUTCOMES = {"got one": "one_got", "got two": "two_got", "gave up one": "one_gone", "gave up two": "two_gone"}


def test_what_is_analysed_apart_is_what_the_whole_does():
    net, world = together(watcher("one", 2, "turn_one"), watcher("two", 1, most=7)), balls(turned=("one",))
    parts = subdivide(net, world, OUTCOMES)
    assert [p.world.names for p in parts] == [("one.ahead",), ("two.ahead",)]
    assert [set(p.outcomes) for p in parts] == [{"got one", "gave up one"}, {"got two", "gave up two"}]
    assert all("share" in [q.name for q in p.net.places] for p in parts)  # a constant couples nothing
    apart = analyze_apart(net, world, OUTCOMES)
    whole = product(net, world, OUTCOMES)
    exact = absorption(whole.chain)
    for outcome in OUTCOMES:
        found, true = apart.probability(outcome), exact.probability(outcome)
        assert abs(found.value - true.value) <= found.error + true.error + 1e-15
        assert found.error < 1e-11
    assert sum(exact.probability(o).value > 0.1 for o in OUTCOMES) == 3  # the patient one never gives up first
    assert abs(apart.expected_time.value - exact.expected_time.value) <= apart.expected_time.error + 1e-11
    assert apart.expected_time.error < 1e-8
    assert apart.states < whole.chain.n


def test_each_group_goes_on_to_its_own_end():
    net, world = together(watcher("one", 2), watcher("two", 1)), balls()
    apart = analyze_apart(net, world, OUTCOMES)
    alone = absorption(product(together(watcher("two", 1)), balls(seen=("two",)), {"got two": "two_got", "gave up two": "two_gone"}).chain)
    both = apart.jointly(("got one", "got two")).value + apart.jointly(("gave up one", "got two")).value
    assert both == pytest.approx(alone.probability("got two").value, abs=1e-12)


def test_ten_balls_apart_are_no_more_than_ten_times_one():
    names = [f"b{k}" for k in range(10)]
    net = together(*(watcher(n, 2) for n in names))
    outcomes = {f"got {n}": f"{n}_got" for n in names} | {f"left {n}": f"{n}_gone" for n in names}
    apart = analyze_apart(net, balls(names, names), outcomes)
    assert len(apart.parts) == 10
    one = analyze_apart(together(watcher("b0", 2)), balls(names, names), {"got b0": "b0_got", "left b0": "b0_gone"})
    assert apart.states == 10 * one.states
    assert sum(apart.probability(o).value for o in outcomes) == pytest.approx(1.0, abs=1e-10)
    # alike, but those named first win where several come at once
    shares = np.array([apart.probability(f"got {n}").value for n in names])
    assert (np.diff(shares) < 0).all()


def test_coupling_through_the_agent_is_noticed():
    """The world keeps two balls apart; a net that sees one and turns to the other does not."""
    world = balls(seen=("one",), turned=("two",))
    assert groups(world) == [("one.ahead",), ("two.ahead",)]
    assert coupled(world) == [("one.ahead", "two.ahead")]
    assert groups(world, coupled(world)) == [("one.ahead", "two.ahead")]
    net = together(watcher("one", 2, "turn_two"))
    (part,) = subdivide(net, world, {"got one": "one_got"})
    assert part.world.names == ("one.ahead", "two.ahead")
    # the same net that does not turn leaves the other ball out altogether
    (part,) = subdivide(together(watcher("one", 2)), world, {"got one": "one_got"})
    assert part.world.names == ("one.ahead",)


@pytest.mark.parametrize("how", ["an arc", "an expression", "a condition", "the world's own end"])
def test_everything_that_couples_two_groups_makes_them_one(how):
    extra, options = (), {}
    first, second = watcher("one", 2), watcher("two", 1, "turn_two")
    if how == "an arc":
        extra = (Transition("stop", ("two_on",), (), tests=("one_got",)),)
    elif how == "an expression":
        second[0].append(Math("both", "one_seen + two_seen"))
    elif how == "a condition":
        options = {"relations": {"turning(two)": "turn_two and one.ahead"}}
    else:
        options = {"ends": {"both ahead": "one.ahead and two.ahead"}}
    net, world = together(first, second, extra=extra), balls(**options)
    assert len(subdivide(together(watcher("one", 2), watcher("two", 1)), balls(), OUTCOMES)) == 2
    assert len(subdivide(net, world, OUTCOMES)) == 1
    apart, exact = analyze_apart(net, world, OUTCOMES), absorption(product(net, world, OUTCOMES).chain)
    for outcome in (*OUTCOMES, *world.ends):
        assert apart.probability(outcome).value == pytest.approx(exact.probability(outcome).value, abs=1e-11)


def test_a_world_that_ends_a_group_ends_the_whole():
    net, world = together(watcher("one", 2), watcher("two", 1)), balls(ends={"rolled": "two.ahead == 1"})
    apart, exact = analyze_apart(net, world, OUTCOMES), absorption(product(net, world, OUTCOMES).chain)
    assert len(apart.parts) == 2
    for outcome in (*OUTCOMES, "rolled"):
        assert apart.probability(outcome).value == pytest.approx(exact.probability(outcome).value, abs=1e-11)


def test_groups_that_may_never_end_leave_that_to_the_others():
    """The second waits for ever with some chance, for a ball that must be ahead at once."""
    stuck = (
        [Place("two_on", capacity=1, tokens=1), Place("two_got", capacity=1), Place("two_off", capacity=1),
         Input("two_seen", observes="two")],
        [Transition("two_get", ("two_on",), ("two_got",), tests={"two_seen": 1}),
         Transition("two_stop", ("two_on",), ("two_off",), delay=1)],
    )  # fmt: skip
    outcomes = {"got one": "one_got", "gave up one": "one_gone", "got two": "two_got"}
    net, world = together(watcher("one", 2), stuck), balls()
    apart, exact = analyze_apart(net, world, outcomes), absorption(product(net, world, outcomes).chain)
    assert len(apart.parts) == 2
    assert apart.probability(NEVER).value == pytest.approx(0.0, abs=1e-12)
    for outcome in outcomes:
        assert apart.probability(outcome).value == pytest.approx(exact.probability(outcome).value, abs=1e-11)
    assert apart.expected_time.value == pytest.approx(exact.expected_time.value, abs=1e-9)
    only = analyze_apart(together(stuck), world, {"got two": "two_got"})
    assert only.probability(NEVER).value > 0.5
    assert only.expected_time.value == np.inf


def test_unknown_outcomes_are_named():
    apart = analyze_apart(together(watcher("one", 2)), balls(), {"got one": "one_got"})
    with pytest.raises(UnknownName, match="got one"):
        apart.probability("got won")
