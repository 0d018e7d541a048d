"""Operations on nets: what they change, everywhere it is named, and nothing else."""

import inspect
import random

import pytest

from cprm_gym.agents.catalogue import shipped_nets
from cprm_gym.agents.skills.approach import APPROACH
from cprm_gym.architecture.petri import (
    Belief,
    Command,
    Input,
    Math,
    ObjectPlace,
    PetriNet,
    Place,
    Ports,
    Selection,
    Transition,
    flatten,
    net_from_json,
)
from cprm_gym.errors import CprmError, NetError, UnknownName
from cprm_gym.studio.editing.document import Document, form_of
from cprm_gym.studio.editing.net_operations import OPERATIONS

TURN = PetriNet(
    "turn",
    ports=Ports(begin="begin", ongoing="ongoing", done="done", errors=("failed",), interrupts=("abort",), answers={"abort": ("failed",)}),
    places=(
        *(Place(n, capacity=1) for n in ("begin", "ongoing", "done", "failed", "abort")),
        Input("bearing", observes="ball.direction"),
        Math("off", "abs(bearing) + 0 * bearing"),
    ),
    transitions=(
        Transition("start", ("begin",), ("ongoing",)),
        Transition("turn", ("ongoing",), ("ongoing",), delay=1, tests={"off": 3.0}, emits=Command("turn", moment="bearing")),
        Transition("arrive", ("ongoing",), ("done",), inhibitors={"off": 3.0}),
        Transition("stop", ("abort", "ongoing"), ("failed",), priority=10),
    ),
)
WHOLE = PetriNet(
    "whole",
    places=(
        Place("idle", capacity=1, tokens=1),
        Place("over"),
        ObjectPlace("mate", "Mate", Selection("Mate", best="mate.near", where="mate.near > limit")),
        Input("limit"),
        Belief("far", "mate.distance"),
        Math("both", "mate.near + limit"),
        Math("turning", "turn.ongoing * 2"),
    ),
    transitions=(
        Transition("go", ("idle",), ("turn.begin",)),
        Transition("end", ("turn.done",), ("over",), sets={"idle": 1}),
        Transition("fail", ("turn.failed",), ("idle",)),
    ),
    modules={"turn": TURN},
)


def document(net=WHOLE):
    return Document(net.name, form_of(net))


def changed(*ops, net=WHOLE):
    made = document(net)
    for op in ops:
        made.apply(op)
    return made


def test_places_and_transitions_are_added_changed_and_connected():
    made = changed(
        {"op": "add_place", "in": "whole", "place": {"kind": "place", "name": "rest", "capacity": 2}},
        {"op": "add_transition", "in": "whole", "transition": {"name": "sleep", "delay": 3}},
        {"op": "connect", "in": "whole", "place": "over", "transition": "sleep", "arc": "input", "weight": 2},
        {"op": "connect", "in": "whole", "place": "rest", "transition": "sleep", "arc": "output"},
        {"op": "connect", "in": "whole", "place": "limit", "transition": "sleep", "arc": "test", "weight": 0.5},
        {"op": "connect", "in": "whole", "place": "turn.ongoing", "transition": "sleep", "arc": "inhibitor"},
        {"op": "connect", "in": "whole", "place": "idle", "transition": "sleep", "arc": "set", "weight": 0},
        {"op": "change", "in": "whole", "name": "sleep", "fields": {"priority": 4, "delay": None}},
    ).value()
    sleep = made.transition("sleep")
    assert made.place("rest") == Place("rest", 2)
    assert (sleep.inputs, sleep.outputs, sleep.tests) == ({"over": 2}, {"rest": 1}, {"limit": 0.5})
    assert (sleep.inhibitors, sleep.sets, sleep.priority, sleep.delay) == ({"turn.ongoing": 1}, {"idle": 0}, 4, 0)


def test_renaming_a_place_follows_it_into_arcs_expressions_and_selections():
    made = changed(
        {"op": "rename", "in": "whole", "name": "limit", "to": "least"},
        {"op": "rename", "in": "whole", "name": "mate", "to": "friend"},
        {"op": "rename", "in": "whole", "name": "idle", "to": "calm"},
    ).value()
    assert made.place("both").expression == "friend.near + least"
    assert made.place("friend").select.where == "mate.near > least", "the candidate is called after its class"
    assert made.place("far").variable == "friend.distance"
    assert made.place("least").observes == "limit", "what it observes is not its name"
    assert made.transition("go").inputs == {"calm": 1}
    assert made.transition("end").sets == {"calm": 1}


def test_renaming_a_port_follows_it_out_of_the_module():
    made = changed(
        {"op": "rename", "in": "turn", "name": "ongoing", "to": "at_work"},
        {"op": "rename", "in": "turn", "name": "failed", "to": "lost"},
        {"op": "rename", "in": "turn", "name": "abort", "to": "halt"},
    ).value()
    turn = made.modules["turn"]
    assert (turn.ports.ongoing, turn.ports.errors, turn.ports.answers) == ("at_work", ("lost",), {"halt": ("lost",)})
    assert made.place("turning").expression == "turn.at_work * 2"
    assert made.transition("fail").inputs == {"turn.lost": 1}


def test_renaming_an_instance_follows_its_ports():
    made = changed({"op": "rename", "in": "whole", "name": "turn", "to": "spin"}).value()
    assert set(made.modules) == {"spin"}
    assert made.place("turning").expression == "spin.ongoing * 2"
    assert made.transition("go").outputs == {"spin.begin": 1}


def test_expressions_keep_their_layout_when_a_name_in_them_changes():
    made = changed({"op": "rename", "in": "turn", "name": "bearing", "to": "b"})
    assert made.definition("turn").place("off").expression == "abs(b) + 0 * b"
    assert made.definition("turn").transition("turn").emits == Command("turn", moment="b")


def test_removing_a_place_takes_its_arcs_and_ports_with_it():
    made = changed({"op": "remove", "in": "turn", "names": ["failed", "stop", "abort"]}).value()
    assert made.modules["turn"].ports.errors == made.modules["turn"].ports.interrupts == ()
    assert made.transition("fail").inputs == {}
    assert [t.name for t in made.modules["turn"].transitions] == ["start", "turn", "arrive"]


def test_a_place_that_an_expression_reads_is_not_removed():
    with pytest.raises(NetError, match="'limit'"):
        changed({"op": "remove", "in": "whole", "names": ["limit"]})


def test_removing_an_instance_needs_what_reads_it_removed_too():
    with pytest.raises(NetError, match="turning"):
        changed({"op": "remove", "in": "whole", "names": ["turn"]})
    made = changed({"op": "remove", "in": "whole", "names": ["turn", "turning"]}).value()
    assert not made.modules
    assert made.transition("go").outputs == {}


def test_modules_are_embedded_and_their_ports_fused():
    free = PetriNet("free", (Place("a", capacity=1), Place("b")), ports=Ports(inputs=("a",)))
    made = document()
    made.apply({"op": "take", "definitions": form_of(free)["definitions"]})
    made.apply({"op": "embed", "in": "whole", "instance": "f", "definition": "free"})
    assert made.value().modules["f"] == free
    made.apply({"op": "fuse", "in": "whole", "port": "f.a", "place": "idle"})
    assert made.value().fuse == {"f.a": "idle"}
    made.apply({"op": "fuse", "in": "whole", "port": "f.a", "place": ""})
    assert made.value().fuse == {}


def test_definitions_of_another_net_with_the_same_name_get_a_new_one():
    made = document()
    other = PetriNet("turn", (Place("x"),))
    made.apply({"op": "take", "definitions": form_of(other)["definitions"]})
    assert set(made.net["definitions"]) == {"turn", "whole", "turn_2"}
    made.apply({"op": "take", "definitions": form_of(TURN)["definitions"]})
    assert set(made.net["definitions"]) == {"turn", "whole", "turn_2"}, "an equal one is the same"


def test_ports_are_set_and_unset():
    made = changed(
        {"op": "port", "in": "whole", "place": "over", "role": "outputs"},
        {"op": "port", "in": "turn", "place": "failed", "role": "outputs"},
        {"op": "ports", "in": "turn", "fields": {"within": 3}},
    ).value()
    assert made.ports.outputs == ("over",)
    ports = made.modules["turn"].ports
    assert (ports.errors, ports.outputs, ports.within, ports.answers) == ((), ("failed",), 3, {})


def test_definitions_are_made_renamed_and_taken_away():
    made = changed({"op": "define", "name": "spare"}, {"op": "rename_net", "name": "turn", "to": "swing"})
    assert made.value().modules["turn"].name == "swing"
    assert made.value().modules["turn"].places == TURN.places
    with pytest.raises(NetError, match="is used by 'whole'"):
        made.apply({"op": "undefine", "name": "swing"})
    made.apply({"op": "undefine", "name": "spare"})
    assert set(made.net["definitions"]) == {"swing", "whole"}


BAD = [
    ({"op": "fly"}, "fly"),
    ({"op": "add_place", "in": "nowhere", "place": {"kind": "place", "name": "x"}}, "nowhere"),
    ({"op": "add_place", "in": "whole", "place": {"kind": "place", "name": "idle"}}, "'idle'"),
    ({"op": "add_place", "in": "whole", "place": {"kind": "place", "name": "go"}}, "'go'"),
    ({"op": "add_place", "in": "whole", "place": {"kind": "plaice", "name": "x"}}, "Did you mean 'place'"),
    ({"op": "add_place", "in": "whole", "place": "x"}, "a name"),
    ({"op": "add_place", "in": "whole"}, "place"),
    ({"op": "change", "in": "whole", "name": "both", "fields": {"expression": "limit +"}}, "not an expression"),
    ({"op": "change", "in": "whole", "name": "both", "fields": {"expression": "limit + nothing"}}, "unknown place 'nothing'"),
    ({"op": "change", "in": "whole", "name": "idle", "fields": {"capacity": 0}}, "capacity"),
    ({"op": "change", "in": "whole", "name": "idle", "fields": {"name": "x"}}, "rename"),
    ({"op": "rename", "in": "whole", "name": "gone", "to": "x"}, "'gone'"),
    ({"op": "rename", "in": "whole", "name": "idle", "to": "over"}, "'over'"),
    ({"op": "rename", "in": "whole", "name": "idle", "to": "if"}, "expression language"),
    ({"op": "connect", "in": "whole", "place": "idle", "transition": "go", "arc": "rubber"}, "rubber"),
    ({"op": "connect", "in": "whole", "place": "turn.begin", "transition": "go", "arc": "input"}, "only receives"),
    ({"op": "connect", "in": "whole", "place": "limit", "transition": "go", "arc": "output"}, "discrete"),
    ({"op": "disconnect", "in": "whole", "place": "over", "transition": "go", "arc": "input"}, "no input arc"),
    ({"op": "port", "in": "turn", "place": "begin", "role": "captain"}, "captain"),
    ({"op": "port", "in": "turn", "place": "begin", "role": ""}, "begin"),
    ({"op": "move", "in": "whole", "at": {"idle": [1]}}, "idle"),
    ({"op": "move", "in": "whole", "at": {"idle": [1, float("nan")]}}, "idle"),
    ({"op": "embed", "in": "turn", "instance": "w", "definition": "whole"}, "circle"),
    ({"op": "embed", "in": "whole", "instance": "w", "definition": "torn"}, "Did you mean 'turn'"),
    ({"op": "fuse", "in": "whole", "port": "turn.begin", "place": "nowhere"}, "nowhere"),
    ({"op": "undefine", "name": "whole"}, "means it"),
    ({"op": "all", "ops": [{"op": "define", "name": "x"}, {"op": "define", "name": "x"}]}, "'x' already"),
]


@pytest.mark.parametrize(("op", "words"), BAD, ids=[f"{op['op']}-{k}" for k, (op, _) in enumerate(BAD)])
def test_what_does_not_fit_is_refused_and_changes_nothing(op, words):
    made = document()
    with pytest.raises(CprmError, match=words):
        made.apply(op)
    assert made.value() == WHOLE
    assert made.data == form_of(WHOLE)
    assert made.revision == 0
    assert not made.undo()


def test_an_unknown_operation_names_those_there_are():
    with pytest.raises(UnknownName, match="add_place"):
        changed({"op": "ad_place"})


def random_op(rng, made):
    form = made.net
    key = rng.choice(list(form["definitions"]))
    here = form["definitions"][key]
    places = [p["name"] for p in here["places"]]
    transitions = [t["name"] for t in here["transitions"]]
    names = places + transitions + list(here.get("modules", {}))
    new = f"n{rng.randrange(10**6)}"
    place = rng.choice(places or ["x"])
    transition = rng.choice(transitions or ["x"])
    return rng.choice([
        {"op": "add_place", "in": key, "place": {"kind": "place", "name": new}, "at": [rng.randrange(500), 5]},
        {"op": "add_transition", "in": key, "transition": {"name": new, "delay": rng.randrange(3)}},
        {"op": "rename", "in": key, "name": rng.choice(names or ["x"]), "to": new},
        {"op": "remove", "in": key, "names": [rng.choice(names or ["x"])]},
        {"op": "connect", "in": key, "place": place, "transition": transition,
         "arc": rng.choice(["input", "output", "test", "inhibitor", "set"]), "weight": 1},
        {"op": "port", "in": key, "place": place, "role": rng.choice(["inputs", "outputs", ""])},
        {"op": "move", "in": key, "at": {rng.choice(names or ["x"]): [rng.randrange(900), rng.randrange(900)]}},
        {"op": "define", "name": new},
        {"op": "embed", "in": key, "instance": new, "definition": rng.choice(list(form["definitions"]))},
        {"op": "change", "in": key, "name": place, "fields": {"tokens": rng.randrange(2)}},
    ])  # fmt: skip


@pytest.mark.parametrize("seed", range(4))
def test_after_many_random_operations_the_net_is_valid_and_all_can_be_undone_and_done_again(seed):
    rng = random.Random(seed)
    made = document(APPROACH)
    done = 0
    for _ in range(150):
        try:
            made.apply(random_op(rng, made))
            done += 1
        except CprmError:
            continue
    assert done > 40
    end = made.data
    flatten(made.value())
    assert net_from_json(made.text()) == made.value()
    for _ in range(done):
        assert made.undo()
    assert made.value() == APPROACH
    assert not made.undo()
    while made.redo():
        pass
    assert made.data == end


def test_renaming_every_part_of_every_shipped_net_and_back_gives_the_net_again():
    for net in shipped_nets().values():
        made = document(net)
        parts = [p.name for p in net.places] + [t.name for t in net.transitions] + list(net.modules)
        new = {name: "zz_" + name.replace(".", "_") for name in parts}
        made.apply({"op": "all", "ops": [{"op": "rename", "in": net.name, "name": a, "to": b} for a, b in new.items()]})
        assert made.value() != net
        made.apply({"op": "all", "ops": [{"op": "rename", "in": net.name, "name": b, "to": a} for a, b in new.items()]})
        assert made.value() == net, net.name


VALUES = [
    None, 0, -1, 1.5, "", "x", "idle", "limit", "go", "turn", "whole", "input", "inputs", [], ["idle"], {}, {"idle": 1}, {"name": "n"},
    {"idle": [1, 2]}, {"tokens": 0}, {"kind": "place", "name": "new"}, True, [1, 2], {"idle": [1, "a"]}, [{"op": "define", "name": "d"}],
]  # fmt: skip


@pytest.mark.parametrize("seed", range(3))
def test_whatever_a_page_sends_is_done_or_refused_with_words(seed):
    rng = random.Random(seed)
    done = 0
    for _ in range(600):
        made = document()
        name = rng.choice(sorted(OPERATIONS))
        fields = ["in" if f == "where" else f for f in list(inspect.signature(OPERATIONS[name]).parameters)[1:]]
        op = {"op": name} | {f: rng.choice(["whole", "turn"]) if f == "in" and rng.random() < 0.9 else rng.choice(VALUES) for f in fields}
        try:
            made.apply(op)
            done += 1
            made.value()
        except CprmError:
            assert made.data == form_of(WHOLE)
    assert done > 10
