"""Places that hang on one observation are not independent: what cannot be at once is not explored, what is undecided is said to be."""

import numpy as np
import pytest

from cprm_gym.architecture.analysis.modules.contracts import check_contract
from cprm_gym.architecture.analysis.timed.properties import analyze_timed, may_reach
from cprm_gym.architecture.analysis.timed.state_space import explore_timed
from cprm_gym.architecture.analysis.timed.system import timed_system
from cprm_gym.architecture.petri import Belief, Executor, Input, Math, ObjectPlace, PetriNet, Place, Ports, Selection, Transition

DISTANCE = (Input("d"), Math("near", "1 if d < 2 else 0"))


def choice(*maths, both, more=()):
    """Goes to `both` where all of these hold at once."""
    tests, inhibitors = both
    return PetriNet(
        "choice",
        (Place("w", capacity=1, tokens=1), Place("both", capacity=1), *maths),
        (Transition("impossible", ("w",), ("both",), tests=tests, inhibitors=inhibitors), *more),
    )


def test_a_math_place_and_what_it_reads_are_never_found_where_no_value_puts_them():
    net = choice(*DISTANCE, both=({"d": 2, "near": 1}, {}))
    assert may_reach(net, {"both": 1}).holds is False
    executor = Executor(net, batch=2001)
    executor.step({"d": np.linspace(-10, 10, 2001)})
    assert executor.read("both").sum() == 0


def test_two_guards_that_exclude_each_other_are_deterministic():
    net = PetriNet(
        "decide",
        (Place("w", capacity=1, tokens=1), Place("go", capacity=1), Place("stop", capacity=1), *DISTANCE),
        (Transition("far", ("w",), ("stop",), tests={"d": 2}), Transition("close", ("w",), ("go",), tests={"near": 1})),
    )
    assert analyze_timed(net).deterministic.holds is True
    assert may_reach(net, {"go": 1}).holds is may_reach(net, {"stop": 1}).holds is True


def test_a_contract_is_not_broken_by_a_transition_that_no_value_enables():
    module = PetriNet(
        "m",
        (*(Place(p, capacity=1) for p in ("begin", "ongoing", "done", "failed", "w")), *DISTANCE),
        (
            Transition("s", ("begin",), ("ongoing", "w")),
            Transition("far", ("w", "ongoing"), ("failed",), tests={"d": 2}),
            Transition("close", ("w", "ongoing"), ("done",), tests={"near": 1}),
            Transition("impossible", ("ongoing",), ("done",), tests={"d": 2, "near": 1}, priority=9),
        ),
        ports=Ports(begin="begin", ongoing="ongoing", done="done", errors=("failed",)),
    )
    assert check_contract(module).holds is True


def test_an_end_that_no_value_brings_is_no_end():
    """The other side of the same fault: `may end` held because of a way that cannot be gone."""
    module = PetriNet(
        "m",
        (*(Place(p, capacity=1) for p in ("begin", "ongoing", "done")), *DISTANCE),
        (Transition("s", ("begin",), ("ongoing",)), Transition("e", ("ongoing",), ("done",), tests={"d": 2, "near": 1})),
        ports=Ports(begin="begin", ongoing="ongoing", done="done"),
    )
    assert check_contract(module).clause("may end").holds is False


@pytest.mark.parametrize(
    ("maths", "tests", "inhibitors"),
    [
        ((Input("a", observes="d"), Input("b", observes="d", value=0), Math("m", "a + 1"), Math("n", "b")), {"m": 3}, {"n": 1}),
        ((Input("x"), Input("y"), Math("r", "hypot(x, y)"), Math("close", "1 if r < 2 else 0")), {"r": 2, "close": 1}, {}),
        ((Input("x"), Input("y"), Math("gap", "x - y"), Math("far", "1 if x - y > 3 else 0")), {"far": 1}, {"gap": 3}),
        ((Belief("x", "ball.x"), Math("m", "abs(x)"), Math("n", "-x")), {"m": 2, "n": -1}, {"n": 2}),
        ((Input("x"), Math("m", "1 / x")), {"m": 0.5}, {"x": 0}),
        ((Input("x"), Math("m", "x * x")), {"m": -1}, {"m": 0}),
        ((Input("x"), Place("w2", capacity=2, tokens=2), Math("m", "x + w2"), Math("n", "x - w2")), {"n": 1}, {"m": 5}),
        ((Input("x"), Math("whole", "floor(x)"), Math("part", "x - whole")), {"whole": 3}, {"x": 3}),
    ],
    ids=["one observation", "common part", "written twice", "belief", "undefined", "square", "tokens", "floor"],
)
def test_kinds_of_dependence_are_seen_through(maths, tests, inhibitors):
    assert may_reach(choice(*maths, both=(tests, inhibitors)), {"both": 1}).holds is False


def test_a_threshold_is_met_exactly():
    for d, holds in ((2.0, True), (np.nextafter(2.0, 0.0), False)):
        net = choice(*DISTANCE, both=({"d": d}, {"near": 1}))
        assert may_reach(net, {"both": 1}).holds is True
        net = choice(*DISTANCE, both=({"near": 1, "d": d}, {}))
        assert may_reach(net, {"both": 1}).holds is not holds


def test_attributes_of_one_object_hang_together():
    select = Selection("Ball", best="ball.x")
    maths = (Math("x", "o.x", default=-9), Math("left", "1 if o.x < 2 else 0", default=0))
    net = choice(ObjectPlace("o", "Ball", select), *maths, both=({"x": 2, "left": 1}, {}))
    assert may_reach(net, {"both": 1}).holds is False
    absent = choice(ObjectPlace("o", "Ball", select), Math("x", "o.x", default=-9), both=({"x": 2}, {"o": 1}))
    assert may_reach(absent, {"both": 1}).holds is False


def test_what_stays_undecided_is_unknown():
    """Whether x ** 3 + y ** 3 + z ** 3 can be so near to 114 is a hard question."""
    maths = (*(Input(n) for n in "xyz"), Math("m", "abs(floor(x) ** 3 + floor(y) ** 3 + floor(z) ** 3 - 114)"))
    found = may_reach(choice(*maths, both=({}, {"m": 0.5})), {"both": 1})
    assert found.holds is None
    assert "not decided" in found.why
    net = choice(*maths, both=({}, {"m": 0.5}), more=(Transition("other", ("w",), ()),))
    assert analyze_timed(net).deterministic.holds is None


def test_the_values_that_lead_to_a_run_are_given_and_do():
    net = PetriNet(
        "two cycles",
        (
            Place("a", capacity=1, tokens=1), Place("b", capacity=1), Place("c", capacity=1), *DISTANCE,
            Math("half", "d / 2 if near < 1 else 7"),
        ),
        (
            Transition("first", ("a",), ("b",), tests={"half": 3}, inhibitors={"d": 100}, delay=1),
            Transition("second", ("b",), ("c",), tests={"near": 1}, delay=1),
        ),
    )  # fmt: skip
    space = explore_timed(timed_system(net))
    node = int(np.flatnonzero(space.markings[:, 2] > 0)[0])
    executor = Executor(net)
    for values in space.values(space.edges_to(node)):
        executor.step({name: v for name, v in values.items() if name == "d"})
    assert executor.read("c") == 1
