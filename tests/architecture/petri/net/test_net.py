"""Definitions: what is refused, with which words."""

import pytest

from cprm_gym.architecture.petri import (
    Belief,
    Command,
    FrozenMap,
    Input,
    Math,
    ObjectPlace,
    PetriNet,
    Place,
    PlaceKind,
    Ports,
    Selection,
    Semantics,
    Transition,
    compile_net,
)
from cprm_gym.errors import NetError

PLACES = (
    Place("idle", tokens=1), Place("busy", capacity=2), Input("seen"), Belief("bearing", "ball.direction"),
    Math("off", "abs(bearing)"), ObjectPlace("target", "Opponent"), ObjectPlace("mate", "Teammate"),
)  # fmt: skip


def refused(message: str, *transitions: Transition, places=PLACES, **options) -> None:
    with pytest.raises(NetError, match=message):
        PetriNet("m", places, transitions, **options)


def test_unknown_place_gets_a_suggestion():
    refused("net 'm', transition 't': `inputs`: unknown place 'idel'. Did you mean 'idle'?", Transition("t", ("idel",)))


def test_a_string_instead_of_a_tuple_is_refused_with_the_tuple():
    with pytest.raises(NetError, match=r"transition 't': `inputs` takes a tuple of place names, got the string 'idle'; write \('idle',\)"):
        Transition("t", "idle")
    with pytest.raises(NetError, match=r"`tests` takes a mapping from place to threshold, got the string 'idle'; write \{'idle': 1\}"):
        Transition("t", tests="idle")


@pytest.mark.parametrize("kind", ["inputs", "outputs"])
@pytest.mark.parametrize("place", ["seen", "bearing", "off"])
def test_transitions_never_move_real_values(kind, place):
    refused(
        f"`{kind}` names the .* place '{place}'; transitions move tokens of discrete and object places only",
        Transition("t", **{kind: (place,)}),
    )


def test_set_arc_to_a_real_valued_place_is_refused():
    refused("`sets` names the math place 'off'", Transition("t", sets={"off": 1}))


def test_repeated_names_add_weight():
    t = Transition("t", ("a", "a"), {"b": 3})
    assert t.inputs == {"a": 2}
    assert t.outputs == {"b": 3}
    assert t == Transition("t", {"a": 2}, ("b", "b", "b"))


@pytest.mark.parametrize("weight", [0, -1, 1.5, True, "1", float("nan"), float("inf"), 2**31, 10**400])
def test_weights_are_whole_numbers_from_one(weight):
    with pytest.raises(NetError, match="transition 't': `inputs`: weight of 'a' is"):
        Transition("t", {"a": weight})


def test_weight_beyond_the_capacity_is_refused():
    refused("`outputs`: 3 tokens for place 'busy' of capacity 2", Transition("t", outputs={"busy": 3}))
    refused("tests 3 tokens of place 'busy' of capacity 2", Transition("t", tests={"busy": 3}))
    refused("`sets`: 3 tokens for place 'busy' of capacity 2", Transition("t", sets={"busy": 3}))


def test_thresholds_of_discrete_places_are_whole_numbers_from_one():
    refused("threshold of 'busy' is a whole number from 1, got 0", Transition("t", inhibitors={"busy": 0}))
    refused("threshold of 'idle' is a whole number from 1, got 1.5", Transition("t", tests={"idle": 1.5}))
    PetriNet("m", PLACES, (Transition("t", tests={"bearing": -1.5}),))
    with pytest.raises(NetError, match="threshold of 'bearing' is a finite number, got 1000"):
        Transition("t", tests={"bearing": 10**400})


def test_set_and_output_arc_to_one_place_need_a_decision():
    refused("set and output arc to 'busy'; write set_wins=True", Transition("t", outputs=("busy",), sets={"busy": 0}))
    PetriNet("m", PLACES, (Transition("t", outputs=("busy",), sets={"busy": 0}, set_wins=True),))


def test_object_output_needs_an_object_input_of_its_class():
    refused("object output 'target' without an object input", Transition("t", outputs=("target",)))
    refused("moves a Teammate from 'mate' into 'target', which holds a Opponent", Transition("t", ("mate",), ("target",)))
    two = (*PLACES, ObjectPlace("second", "Opponent"))
    refused("several object inputs, target, second: which object goes on", Transition("t", ("target", "second"), ("target",)), places=two)


def test_object_places_hold_one_object():
    refused("an object place holds one object, got weight 2", Transition("t", {"target": 2}))
    refused("an object place can only be set to 0", Transition("t", sets={"target": 1}))


def test_place_set_by_a_selection_takes_no_object_from_a_transition():
    places = (ObjectPlace("a", "Opponent"), ObjectPlace("b", "Opponent", Selection("Opponent", "opponent.x")))
    refused("object place 'b' is set by its selection", Transition("t", ("a",), ("b",)), places=places)


def test_selection_is_checked():
    def net(**options):
        return PetriNet("m", (Input("x"), ObjectPlace("a", "Opponent", Selection("Opponent", **options))))

    net(best="opponent.x - x", where="opponent.y > x")
    for options, message in (
        ({"best": "x"}, "reads no attribute of the candidate; write for example 'opponent.distance'"),
        ({"best": "opponent.x + y"}, "selection, best: unknown place 'y'"),
        ({"best": "opponent.x", "where": "z > 1"}, "selection, where: unknown place 'z'"),
        ({"best": "opponent.x", "k": 0}, "selection: k is 1 to"),
        ({"best": "opponent.x +"}, "selection of a Opponent: best: not an expression"),
    ):
        with pytest.raises(NetError, match=message):
            net(**options)
    with pytest.raises(NetError, match="holds a Opponent, its selection a Ball"):
        ObjectPlace("a", "Opponent", Selection("Ball", "ball.x"))


def test_math_places_in_a_circle_are_refused_with_the_circle():
    refused(
        "math places read each other in a circle: 'a' -> 'b' -> 'c' -> 'a'", places=(Math("a", "b"), Math("b", "c + 1"), Math("c", "2 * a"))
    )


def test_math_is_ordered_by_what_it_reads():
    net = compile_net(PetriNet("m", (Math("c", "a + b"), Math("b", "a * 2"), Input("x"), Math("a", "x"))))
    order = [p.name for p in net.math]
    assert order.index("a") < order.index("b") < order.index("c")


def test_math_reads_known_places_only():
    refused("math place 'a': unknown place 'bering'. Did you mean 'bearing'?", places=(Belief("bearing", "v"), Math("a", "bering")))
    refused("'t.pos.x': an attribute has one part", places=(ObjectPlace("t", "Ball"), Math("a", "t.pos.x")))


def test_expression_errors_show_the_place_of_the_mistake():
    with pytest.raises(
        NetError, match=r"math place 'a': unknown function 'squrt'. Did you mean 'sqrt'\?.*\n    1 \+ squrt\(x\)\n        \^"
    ):
        Math("a", "1 + squrt(x)")


def test_observing_an_attribute_of_a_held_object_is_done_by_math():
    refused(r"'target.x' is an attribute of the object in a place; write Math\('d', 'target.x'\)", places=(*PLACES, Input("d", "target.x")))


@pytest.mark.parametrize("name", ["", " a", "a ", "a\nb", "x" * 201, 3, None, "pi", "sqrt"])
def test_names_that_cannot_be_written_are_refused(name):
    with pytest.raises(NetError):
        Place(name)


def test_duplicates_are_refused():
    refused("place 'a' is declared 2 times", places=(Place("a"), Input("a")))
    refused("transition 't' is declared 2 times", Transition("t", ("idle",)), Transition("t", ("idle",)))


def test_tokens_within_capacity():
    with pytest.raises(NetError, match="place 'p': 3 tokens exceed its capacity 2"):
        Place("p", capacity=2, tokens=3)


def test_command_parameters_are_places_or_numbers():
    refused("command 'kick', parameter 'power': unknown place 'powr'", Transition("t", emits=Command("kick", power="powr")))
    with pytest.raises(NetError, match="command 'kick': parameter 'power' is the name of a place, or is a finite number, got None"):
        Command("kick", power=None)
    assert Command("kick", power=1).params == {"power": 1}


def test_options_are_checked():
    for options in ({"memory": "none"}, {"servers": 0}, {"servers": 65}, {"delay": -1}, {"delay": 1.5}, {"priority": 0.5}, {"weight": 0},
                    {"emits": "kick"}, {"sets": ("a",)}):  # fmt: skip
        with pytest.raises(NetError, match="transition 't': `"):
            Transition("t", **options)
    with pytest.raises(NetError, match="semantics: `capacity` is 'strong' or 'weak', got 'soft'"):
        Semantics(capacity="soft")
    with pytest.raises(NetError, match="`state` goes with view='probability'"):
        Belief("b", "v", state="yes")


def test_nets_are_values():
    def net():
        return PetriNet("m", PLACES, (Transition("t", ("idle",), {"busy": 1}, tests={"off": 3.0}),), ports=Ports(inputs=("idle",)))

    assert net() == net()
    assert hash(net()) == hash(net())
    assert len({net(), net()}) == 1
    assert net() != PetriNet("m", PLACES)
    with pytest.raises(AttributeError):
        net().name = "other"


def test_frozen_maps_are_hashable_mappings():
    assert FrozenMap({"a": 1, "b": 2}) == {"b": 2, "a": 1}
    assert hash(FrozenMap({"a": 1, "b": 2})) == hash(FrozenMap({"b": 2, "a": 1}))
    assert repr(FrozenMap({"a": 1})) == "{'a': 1}"
    assert FrozenMap() != 3


def test_places_and_transitions_are_found_by_name():
    net = PetriNet("m", PLACES, (Transition("t", ("idle",)),))
    assert net.place("busy").capacity == 2
    assert net.transition("t").inputs == {"idle": 1}
    with pytest.raises(NetError, match="net 'm': unknown transition 'u'"):
        net.transition("u")
    with pytest.raises(NetError, match=r"net 'm': unknown place 'bussy'\. Did you mean 'busy'?"):
        net.place("bussy")


def test_arrays_have_the_textbook_form():
    net = compile_net(PetriNet("m", (Place("a", 5, 2), Place("b", 3), Input("x")), (
        Transition("t", {"a": 2}, {"b": 1, "a": 1}, tests={"x": 0.5}, delay=4, priority=7),
        Transition("u", ("b",), sets={"a": 3}, inhibitors={"a": 2}),
    )))  # fmt: skip
    assert net.pre.tolist() == [[2, 0, 0], [0, 1, 0]]
    assert net.post.tolist() == [[1, 1, 0], [0, 0, 0]]
    assert net.incidence.tolist() == [[-1, 1, 0], [0, -1, 0]]
    assert net.set_to.tolist() == [[-1, -1, -1], [3, -1, -1]]
    assert net.test[0, 2] == 0.5
    assert net.inhibit[1, 0] == 2
    assert net.initial.tolist() == [2, 0, 0]
    assert net.kind.tolist() == [PlaceKind.DISCRETE, PlaceKind.DISCRETE, PlaceKind.INPUT]
    assert (net.delay.tolist(), net.priority.tolist()) == ([4, 0], [7, 0])
    assert net.place("b") == 1
    assert net.transition("u") == 1
    with pytest.raises(NetError, match="unknown place 'c'"):
        net.place("c")


def test_initial_marking_evaluates_math_where_it_is_defined():
    maths = (Math("a", "x / 2"), Math("b", "1 / zero", default=9), Math("c", "o.x", default=-2), Math("d", "a + b"))
    net = compile_net(PetriNet("m", (Input("x", value=4), Input("zero"), ObjectPlace("o", "Ball"), *maths)))
    assert net.initial[3:].tolist() == [2, 9, -2, 11]


def test_a_family_of_nets_is_a_function():
    def mark_opponent(number: int) -> PetriNet:
        return PetriNet(
            f"mark_{number}", (Place("begin", 1), Input("near", observes=f"opponent_{number}.near")), (Transition("go", ("begin",)),)
        )

    family = [mark_opponent(i) for i in range(1, 12)]
    assert len(set(family)) == 11
    assert family[3] == mark_opponent(4)
