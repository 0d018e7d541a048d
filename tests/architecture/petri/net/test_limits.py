"""Short texts that mean enormous nets, and values that are no parts of a net: refused at once, in our own words."""

import time

import pytest

from cprm_gym.architecture.petri import (
    Belief,
    Command,
    Input,
    ObjectPlace,
    PetriNet,
    Place,
    Ports,
    Selection,
    Semantics,
    Transition,
    compile_net,
    eliminate_set_arcs,
    expanded_net,
    flatten,
    instances,
    net_from_json,
    net_to_json,
    to_dot,
    to_pnml,
    to_svg,
)
from cprm_gym.architecture.petri.drawing.dot import ALL
from cprm_gym.errors import NetError


def doubled(levels):
    """A net of two modules of two modules ..."""
    net = PetriNet("n0", (Place("a"),))
    for level in range(1, levels + 1):
        net = PetriNet(f"n{level}", (Place("a"),), modules={"x": net, "y": net})
    return net


def test_a_hierarchy_knows_its_size_without_being_flattened():
    net = doubled(3)
    assert (net.depth, net.parts) == (3, 30)
    assert len(flatten(net).places) == 15


@pytest.mark.parametrize("use", [flatten, compile_net, instances, to_pnml, expanded_net, eliminate_set_arcs])
def test_what_would_be_enormous_is_refused_at_once(use):
    start = time.process_time()
    with pytest.raises(NetError, match=r"net 'n24': .* 67,108,862 places, transitions and modules, more than 200,000 \(`max_parts`\)"):
        use(doubled(24))
    assert time.process_time() - start < 1.0


def test_the_size_that_is_allowed_can_be_given():
    with pytest.raises(NetError, match="30 places, transitions and modules, more than 29"):
        flatten(doubled(3), max_parts=29)
    assert compile_net(doubled(3), max_parts=30).n_places == 15


@pytest.mark.parametrize("draw", [to_svg, to_dot])
def test_drawings_of_enormous_nets_are_refused_at_once(draw):
    with pytest.raises(NetError, match=r"33,554,431 places, transitions, ports and arcs, more than 20,000; unfold fewer levels"):
        draw(doubled(24), unfold=ALL)
    assert draw(doubled(24), unfold=2)


def test_enormous_nets_are_compared_hashed_written_and_shown_at_once():
    a, b = doubled(40), doubled(40)
    assert (a, hash(a)) == (b, hash(b))
    assert a != doubled(39)
    assert net_from_json(net_to_json(a)) == b
    assert len(repr(a)) < 200


def test_nets_with_equal_own_parts_differ_by_their_modules():
    inner = PetriNet("m", (Place("a"),))
    other = PetriNet("m", (Place("a", tokens=1),))
    assert PetriNet("n", modules={"x": inner}) != PetriNet("n", modules={"x": other})


def test_modules_too_deep_are_refused():
    with pytest.raises(NetError, match="its modules are nested 65 deep, more than 64"):
        doubled(65)


def test_large_drawings_take_time_in_proportion():
    places = tuple(Place(f"p{i}") for i in range(1501))
    moves = tuple(Transition(f"t{i}", (f"p{i}",), (f"p{i + 1}",), inhibitors={"p0": 2}) for i in range(1500))
    start = time.process_time()
    to_svg(PetriNet("chain", places, moves))
    assert time.process_time() - start < 20.0  # ran for minutes


P = Place("p")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: PetriNet("n", places=P), r"net 'n': `places` takes a tuple, got Place\(.*; write \(part,\) for one"),
        (lambda: PetriNet("n", places="p"), "net 'n': `places` takes a tuple, got 'p'"),
        (lambda: PetriNet("n", places=None), "net 'n': `places` takes a tuple, got None"),
        (lambda: PetriNet("n", (P,), Transition("t")), "net 'n': `transitions` takes a tuple"),
        (lambda: PetriNet("n", places=(3,)), "`places` takes Place, .*, got 3"),
        (lambda: PetriNet("n", modules=[P]), "net 'n': `modules` takes a mapping from instance name to net"),
        (lambda: PetriNet("n", modules={3: P}), "net 'n': `modules` takes a mapping from instance name to net"),
        (lambda: PetriNet("n", fuse="p"), "net 'n': `fuse` takes a mapping from port to place, got 'p'"),
        (lambda: PetriNet("n", ports={"begin": "p"}), "net 'n': `ports` takes a Ports"),
        (lambda: PetriNet("n", semantics="weak"), "net 'n': `semantics` takes a Semantics, got 'weak'"),
        (lambda: Ports(begin=["p"]), r"ports: `begin` is the name of a place, got \['p'\]"),
        (lambda: Ports(errors=5), "ports: `errors` takes a tuple of place names, got 5"),
        (lambda: Ports(errors=(5,)), r"ports: `errors` takes a tuple of place names, got \(5,\)"),
        (lambda: Ports(answers=("a",)), "ports: `answers` takes a mapping"),
        (lambda: Ports(interrupts=("i",), answers={"i": 3}), "ports: `answers` of 'i' takes a tuple of place names, got 3"),
        (lambda: Semantics(capacity=["weak"]), r"semantics: `capacity` is 'strong' or 'weak', got \['weak'\]"),
        (lambda: Transition("t", {3: 1}), "transition 't': `inputs` names places by text, got 3"),
        (lambda: Transition("t", 3), "transition 't': `inputs` takes a tuple of place names"),
        (lambda: Transition("t", sets={None: 1}), "transition 't': `sets` names places by text, got None"),
        (lambda: Transition("t", memory=["age"]), r"`memory` is 'enabling', 'age' or 'resampling', got \['age'\]"),
        (lambda: Transition("t", servers="1"), "`servers` is 1 to 64 or INFINITE, got '1'"),
        (lambda: Transition("t", set_wins="no"), "`set_wins` is True or False, got 'no'"),
        (lambda: ObjectPlace("o", "Ball", "ball.x"), "object place 'o': `select` takes a Selection, got 'ball.x'"),
        (lambda: Selection("Ball", "ball.x", where=3), "selection of a Ball: where is an expression written as text"),
        (lambda: Selection("Ball", "ball.x", minimize="yes"), "`minimize` is True or False"),
        (lambda: Belief("b", "x", state=3), "`state` is text, got 3"),
        (lambda: Input("i", observes=3), "the name of a observation is text, got int: 3"),
        (lambda: Command("kick", power=[1]), "command 'kick': parameter 'power'"),
        (lambda: Place("p", tokens=10**5000), r"tokens is 0 to 2147483647, got a whole number of 16610 bits"),
        (lambda: Place("p", tokens=-(10**5000)), "got a whole number of 16610 bits"),
        (lambda: Transition("t", delay=10**5000), "got a whole number of 16610 bits"),
        (lambda: Transition("t", priority=10**5000), "got a whole number of 16610 bits"),
        (lambda: Transition("t", tests={"p": 10**5000}), "got a whole number of 16610 bits"),
        (lambda: PetriNet("n", places=([10**5000],)), r"got \[a whole number of 16610 bits\]"),
        (lambda: Place("x" * 10**6), "1 to 200 printable characters"),
        (lambda: compile_net("net.json"), "a net is a PetriNet, got 'net.json'"),
    ],
)  # fmt: skip
def test_what_is_no_part_of_a_net_is_refused_in_our_own_words(make, message):
    with pytest.raises(NetError, match=message):
        make()
