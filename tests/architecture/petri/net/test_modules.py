"""Modules: ports, nesting, fused places, instances with their own state, parameters by object places."""

import pytest
from orient_module import ORIENT, TWICE

from cprm_gym.architecture.petri import (
    Belief,
    Command,
    Continuous,
    Executor,
    Input,
    Math,
    ObjectPlace,
    PetriNet,
    Place,
    Ports,
    Selection,
    Transition,
    compile_net,
    flatten,
    instances,
)
from cprm_gym.errors import NetError


def outer(**options) -> PetriNet:
    return PetriNet("outer", modules={"orient": ORIENT}, **options)


def test_a_module_gives_its_places_the_names_of_its_instance():
    names = compile_net(TWICE).place_names
    assert names[:2] == ("go", "over")
    assert "first.begin" not in names
    assert "second.begin" in names
    assert len(names) == 2 + 2 * len(ORIENT.places) - 1


def test_flattening_a_flat_net_returns_it():
    assert flatten(ORIENT) is ORIENT
    assert flatten(flatten(TWICE)) == flatten(TWICE)


def test_two_instances_run_one_after_the_other_with_their_own_state():
    executor = Executor(TWICE)
    bearing = 40.0
    moments = []
    for _ in range(12):
        commands = executor.step({"ball.seen": 1, "body.speed": 0}, beliefs={"first.bearing": bearing, "second.bearing": 2.0})
        for values in commands.of().values():
            moments.append(values["moment"])
            bearing -= values["moment"]
    assert moments == [36.0, pytest.approx(3.6)]
    assert executor.read("first.turns")[0] == 2
    assert executor.read("second.turns")[0] == 0
    assert executor.read("over")[0] == 1


def test_interrupting_one_instance_leaves_the_other_alone():
    executor = Executor(TWICE)
    executor.step({"ball.seen": 1}, beliefs={"first.bearing": 120.0, "second.bearing": 0.0})
    for _ in range(3):
        executor.step()
    assert executor.read("first.failed")[0] == 1
    assert executor.read("second.ongoing")[0] == 0


def test_only_ports_may_be_touched():
    with pytest.raises(
        NetError, match=r"place 'turns' is inside the module of instance 'orient'. Its ports are begin, abort, ongoing, facing"
    ):
        outer(transitions=(Transition("t", ("orient.turns",)),))
    with pytest.raises(NetError, match=r"instance 'orient' has no port 'facin'. Did you mean 'facing'?"):
        outer(transitions=(Transition("t", ("orient.facin",)),))


@pytest.mark.parametrize(
    ("arcs", "message"),
    [
        ({"inputs": ("orient.begin",)}, "takes tokens from 'orient.begin', an input of its module; from outside it only receives them"),
        ({"inputs": ("orient.abort",)}, "takes tokens from 'orient.abort'"),
        ({"sets": {"orient.begin": 0}}, "takes tokens from 'orient.begin'"),
        ({"outputs": ("orient.facing",)}, "puts tokens into 'orient.facing', an output of its module; from outside it only loses them"),
        ({"outputs": ("orient.ongoing",)}, "puts tokens into 'orient.ongoing'"),
        ({"sets": {"orient.failed": 1}}, "puts tokens into 'orient.failed'"),
    ],
)
def test_inputs_only_receive_and_outputs_only_lose_tokens(arcs, message):
    with pytest.raises(NetError, match=message):
        outer(transitions=(Transition("t", **arcs),))


def test_ports_may_be_tested_emptied_and_filled_in_their_direction():
    outer(transitions=(
        Transition("t", ("orient.facing",), ("orient.begin",), tests={"orient.off_axis": 1}, inhibitors=("orient.ongoing",)),
        Transition("u", sets={"orient.failed": 0, "orient.abort": 1}),
    ))  # fmt: skip


def test_fusing_is_checked():
    for fuse, places, message in (
        ({"orient.begn": "go"}, (Place("go", 1),), "has no port 'begn'. Did you mean 'begin'?"),
        ({"go": "orient.begin"}, (Place("go", 1),), "only ports of instances are fused"),
        ({"orient.begin": "gone"}, (Place("go", 1),), "unknown place 'gone'"),
        ({"orient.begin": "go"}, (Place("go"),), "their capacities differ, 1 and None"),
        ({"orient.begin": "go"}, (Input("go"),), "cannot fuse the discrete place with the input place"),
        ({"orient.off_axis": "x"}, (Continuous("x"),), "the module writes its math place itself; read it by its name"),
    ):
        with pytest.raises(NetError, match=message):
            outer(fuse=fuse, places=places)


def test_fused_places_are_one():
    both = PetriNet("both", (Place("go", 1, 1),), modules={"a": ORIENT, "b": ORIENT}, fuse={"a.begin": "go", "b.abort": "a.abort"})
    flat = flatten(both)
    assert {"a.start", "b.start"} <= {t.name for t in flat.transitions}
    assert flat.transition("a.start").inputs == {"go": 1}
    assert flat.transition("b.stop").inputs == {"a.abort": 1, "b.ongoing": 1}
    with pytest.raises(NetError, match=r"'a\.abort' is itself fused with 'stop'; name that place"):
        PetriNet("n", (Place("stop", 1),), modules={"a": ORIENT, "b": ORIENT}, fuse={"a.abort": "stop", "b.abort": "a.abort"})


def test_modules_nest_and_ports_can_be_handed_through():
    inner = PetriNet(
        "inner", (Place("begin", 1), Place("done", 1)), (Transition("t", ("begin",), ("done",)),), ports=Ports("begin", done="done")
    )
    middle = PetriNet("middle", (Place("begin", 1), Place("done", 1)), modules={"x": inner, "y": inner},
                      fuse={"x.begin": "begin", "y.done": "done"}, transitions=(Transition("on", ("x.done",), ("y.begin",)),),
                      ports=Ports("begin", done="done"))  # fmt: skip
    top = PetriNet("top", (Place("start", 1, 1), Place("end", 1)), modules={"m": middle}, fuse={"m.begin": "start", "m.done": "end"})
    assert {p.name for p in flatten(top).places} == {"start", "end", "m.x.done", "m.y.begin"}
    executor = Executor(top, trace=True)
    executor.step()
    assert [f.transition for f in executor.trace.firings()] == ["m.x.t", "m.on", "m.y.t"]
    assert executor.read("end")[0] == 1
    found = instances(top)
    assert list(found) == ["", "m", "m.x", "m.y"]
    assert found["m.x"].places == {"begin": "start", "done": "m.x.done"}
    assert found["m.y"].transitions == {"t": "m.y.t"}


def test_names_in_expressions_beliefs_and_selections_follow_the_instance():
    module = PetriNet(
        "m",
        (
            Input("x"), ObjectPlace("best", "Opponent", Selection("Opponent", best="opponent.d - x", where="opponent.d > x")),
            Belief("d", variable="best.distance"), Belief("b", variable="ball.distance"), Math("y", "best.d + x"),
            Math("z", "(y + 1) * -x ** 2 if y > 0 and not x else y % 3"),
        ),
    )  # fmt: skip
    flat = flatten(PetriNet("n", modules={"i": module}))
    assert flat.place("i.best").select == Selection("Opponent", best="opponent.d - i.x", where="opponent.d > i.x")
    assert flat.place("i.d").variable == "i.best.distance"
    assert flat.place("i.b").variable == "ball.distance"
    assert flat.place("i.y").expression == "i.best.d + i.x"
    assert flat.place("i.z").expression == "(i.y + 1) * -i.x ** 2 if i.y > 0 and not i.x else i.y % 3"
    assert flat.place("i.x").observes == "x"


def test_outer_math_reads_ports_of_instances():
    net = outer(places=(Math("double", "2 * orient.off_axis"),))
    executor = Executor(net)
    executor.step(beliefs={"orient.bearing": -20})
    assert executor.read("double")[0] == 40


def test_continuous_parameters_are_fused_with_any_real_valued_place():
    module = PetriNet("m", (Continuous("gain"), Math("twice", "2 * gain")), ports=Ports(parameters=("gain",), outputs=("twice",)))
    net = PetriNet("n", (Input("x"), Continuous("three", 3), Math("y", "x + 1")), modules={"a": module, "b": module, "c": module},
                   fuse={"a.gain": "x", "b.gain": "three", "c.gain": "y"})  # fmt: skip
    executor = Executor(net)
    executor.step({"x": 10})
    assert [executor.read(f"{i}.twice")[0] for i in "abc"] == [20, 6, 22]


def test_an_object_is_passed_to_a_module_as_its_parameter():
    """Fig. 2.24: the Pass module takes a teammate as a parameter."""
    passing = PetriNet(
        "pass",
        (
            Place("begin", 1),
            Place("ongoing", 1),
            Place("done", 1),
            ObjectPlace("target", "Teammate"),
            Math("direction", "target.direction"),
        ),
        (
            Transition("start", ("begin",), ("ongoing",)),
            Transition(
                "kick", ("ongoing", "target"), ("done",), delay=1, emits=Command("kick", power=60, direction="direction", to="target")
            ),
        ),
        ports=Ports("begin", "ongoing", "done", parameters=("target",)),
    )
    openness = Selection("Teammate", best="teammate.openness", where="teammate.openness >= 10", k=2)
    net = PetriNet(
        "play",
        (Place("ready", 1, 1), ObjectPlace("second_most_open", "Teammate", openness)),
        (Transition("choose", ("ready", "second_most_open"), ("pass.begin", "pass.target")),),
        modules={"pass": passing},
    )
    executor = Executor(net, objects={"Teammate": 4})
    team = {"openness": [12, 30, 5, 20], "direction": [10, 20, 30, 40]}
    assert executor.step(objects={"Teammate": team}).of() == {}
    assert executor.holds("pass.target")[0] == 3
    later = {"openness": [99, 30, 5, 20], "direction": [10, 20, 30, -40]}
    assert executor.step(objects={"Teammate": later}).of() == {"kick": {"power": 60, "direction": -40, "to": 3}}


def test_module_names_are_plain_words_that_nothing_else_uses():
    for modules, places, message in (
        ({"a.b": ORIENT}, (), "the name of an instance is a plain word"),
        ({"a": ORIENT}, (Place("a"),), "'a' is declared although 'a' is an instance"),
        ({"a": ORIENT}, (Place("a.b"),), "'a.b' is declared although 'a' is an instance"),
        ({"a": "orient"}, (), "`modules` maps names to nets, got 'orient'"),
    ):
        with pytest.raises(NetError, match=message):
            PetriNet("n", places, modules=modules)


@pytest.mark.parametrize(
    ("ports", "message"),
    [
        ({"begin": "p"}, "ports: 'p' must be a discrete place of capacity 1"),
        ({"begin": "x"}, "ports: 'x' must be a discrete place of capacity 1"),
        ({"done": "nowhere"}, "ports: unknown place 'nowhere'"),
        ({"inputs": ("x",)}, "ports: input 'x' must be a discrete or object place"),
        ({"parameters": ("p",)}, "ports: parameter 'p' must be an object, continuous or input place"),
    ],
)
def test_ports_are_checked(ports, message):
    with pytest.raises(NetError, match=message):
        PetriNet("n", (Place("p"), Math("x", "1")), ports=Ports(**ports))


def test_interface_is_checked_by_itself():
    for options, message in (
        ({"errors": "failed"}, r"`errors` takes a tuple of place names, got the string 'failed'; write \('failed',\)"),
        ({"begin": "a", "done": "a"}, "place 'a' is named 2 times"),
        ({"answers": {"abort": ("failed",)}}, "`answers` names 'abort', which is not an interrupt"),
        ({"interrupts": ("abort",), "answers": {"abort": ("x",)}}, "names 'x', which is neither done nor an error"),
        ({"within": 0}, "`within` is 1 to"),
        ({"idle_interrupts": "lost"}, "is 'consumed' or 'kept'"),
    ):
        with pytest.raises(NetError, match=message):
            Ports(**options)
    ports = Ports("b", "o", "d", ("e",), ("i",), ("in",), ("out",), ("par",), answers={"i": ("e",)})
    assert ports.entries == ("b", "i", "in")
    assert ports.exits == ("o", "d", "e", "out")
    assert ports.outcomes == ("d", "e")
    assert ports.all == ("b", "i", "in", "o", "d", "e", "out", "par")
