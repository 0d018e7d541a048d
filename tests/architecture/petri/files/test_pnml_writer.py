"""PNML: round trips to an equal net, what other tools see, the expanded net."""

import sys
import warnings
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from structure_nets import kanban, philosophers, producer, random_net
from structure_oracle import Oracle

from cprm_gym.architecture.petri import (
    Belief,
    Command,
    Continuous,
    Input,
    Math,
    ObjectPlace,
    PetriNet,
    Place,
    Ports,
    Selection,
    Semantics,
    Transition,
)
from cprm_gym.architecture.petri.files.pnml_reader import parse_pnml, read_pnml
from cprm_gym.architecture.petri.files.pnml_writer import expanded_net, to_pnml, write_pnml
from cprm_gym.errors import FormatError, NetError


def everything():
    """A net with every kind of place and arc, with a module in it twice."""
    module = PetriNet(
        "module <a & b>",
        ports=Ports(
            begin="begin", ongoing="ongoing", done="done", errors=("failed",), interrupts=("abort",), parameters=("who",), within=2
        ),
        places=(
            *(Place(p, capacity=1) for p in ("begin", "ongoing", "done", "failed", "abort")),
            ObjectPlace("who", "Teammate"),
            Belief("openness", "who.openness", view="probability", state="open"),
        ),
        transitions=(
            Transition("start", ("begin",), ("ongoing",), priority=3),
            Transition("end", ("ongoing",), ("done",), delay=4, tests={"openness": 0.5}, memory="age"),
            Transition("stop", ("ongoing", "abort"), ("failed",), sets={"begin": 0}),
        ),
    )
    return PetriNet(
        "every  kind",
        places=(
            Place("stock", tokens=7), Place("limited", capacity=9, tokens=2), Continuous("gain", 0.25), Input("seen", observes="ball.seen"),
            Math("double", "2 * gain + seen"), ObjectPlace("mate", "Teammate", Selection("Teammate", best="teammate.openness", k=2)),
            ObjectPlace("hand", "Ball"), ObjectPlace("box", "Ball"),
        ),
        modules={"one": module, "two": module},
        fuse={"one.who": "mate"},
        transitions=(
            Transition(
                "go", {"stock": 2}, ("one.begin", "limited"), tests={"double": 1.5, "limited": 1},
                inhibitors={"limited": 9, "seen": 0.5},
            ),
            Transition("next", ("one.done",), ("two.begin",), emits=Command("say", power="double", word=3), weight=0.5),
            Transition("move", ("hand",), ("box",), delay=2, servers=3),
            Transition("clear", (), (), sets={"limited": 3, "box": 0}, tests={"stock": 3}, priority=-1),
        ),
        semantics=Semantics(capacity="weak", persistence="atomic"),
    )  # fmt: skip


def test_a_net_with_everything_comes_back_equal():
    net = everything()
    assert parse_pnml(to_pnml(net)) == net


def test_random_nets_come_back_equal():
    for seed in range(150):
        net = random_net(seed)
        assert parse_pnml(to_pnml(net)) == net


@given(st.lists(st.text(min_size=1, max_size=12), min_size=1, max_size=6, unique=True))
def test_names_of_every_kind_come_back(names):
    try:
        net = PetriNet("names", tuple(Place(n) for n in names), tuple(Transition(n, (names[0],)) for n in names))
    except NetError:
        return
    assert parse_pnml(to_pnml(net)) == net


def test_a_plain_net_is_written_without_extensions():
    for net in (kanban(2), philosophers(3)):
        text = to_pnml(net)
        assert "toolspecific" not in text
        assert parse_pnml(text) == net


def test_inhibitor_and_set_arcs_are_never_arc_elements_of_the_page():
    net = PetriNet(
        "special", (Place("p", tokens=1), Place("q", capacity=3)), (Transition("t", ("p",), (), inhibitors=("q",), sets={"q": 2}),)
    )
    text = to_pnml(net)
    page = text[text.index("<page") : text.index("</page>")]
    assert page.count("<arc ") == 1
    assert 'type="inhibitor"' in text[text.index("</page>") :]
    assert "loses: inhibitor arcs, set arcs, capacities" in text


def test_a_reader_of_plain_nets_sees_the_skeleton():
    net = PetriNet(
        "skeleton",
        (Place("p", tokens=3), Place("q", capacity=5)),
        (Transition("t", ("p",), ("q",), tests={"p": 2, "q": 1}, inhibitors={"q": 4}, delay=3),),
    )
    plain = parse_pnml(to_pnml(net), block=False)
    assert plain.places == (Place("p", tokens=3), Place("q"))
    t = plain.transition("t")
    assert (t.inputs, t.outputs, t.tests, t.inhibitors) == ({"p": 2, "q": 1}, {"q": 2, "p": 1}, {}, {})


def test_a_plain_part_changed_by_another_tool_is_not_half_believed():
    text = to_pnml(producer(3))
    tampered = text.replace("<initialMarking><text>1</text>", "<initialMarking><text>2</text>", 1)
    with pytest.raises(FormatError, match=r"the plain part was changed after this was written: place 'idle' has 2 instead of 1"):
        parse_pnml(tampered)
    assert parse_pnml(tampered, block=False).place("idle").tokens == 2


def test_entries_without_a_definition_are_read_too():
    net = PetriNet(
        "entries",
        (Place("p", tokens=1), Place("q", capacity=4)),
        (Transition("t", ("p",), ("q",), tests={"p": 1, "q": 2}, inhibitors={"q": 3}, sets={"p": 1}, set_wins=True),),
    )
    text = to_pnml(net)
    start, end = text.index("   <definition>"), text.index("</definition>") + len("</definition>\n")
    assert parse_pnml(text[:start] + text[end:]) == net


def test_files_are_written_whole_and_read_back(tmp_path):
    file = tmp_path / "net.pnml"
    write_pnml(everything(), file)
    assert read_pnml(file) == everything()
    assert [f.name for f in tmp_path.iterdir()] == ["net.pnml"]


def test_the_expanded_net_has_ordinary_arcs_only_and_the_same_markings():
    for seed in range(150):
        net = random_net(seed, timed=False)
        expanded = expanded_net(net)
        assert all(not (t.tests or t.inhibitors or t.sets) for t in expanded.transitions)
        assert all(p.capacity is None for p in expanded.places)
        fine, plain = Oracle(net), Oracle(expanded)
        known = [plain.names.index(name) for name in fine.names]
        assert {tuple(m[k] for k in known) for m in plain.edges} == set(fine.edges), f"net {seed}"
        assert sum(map(len, plain.edges.values())) == sum(map(len, fine.edges.values())), f"net {seed}"


def test_the_expanded_net_is_written_for_every_tool(tmp_path):
    file = tmp_path / "expanded.pnml"
    write_pnml(producer(2), file, expanded=True)
    net = read_pnml(file)
    assert "not buffer" in {p.name for p in net.places}
    assert "toolspecific" not in file.read_text()


def test_the_expanded_net_needs_a_bound_for_an_inhibited_place():
    net = PetriNet("open", (Place("p", tokens=1), Place("q")), (Transition("t", ("p",), ("q",), inhibitors=("q",)),))
    with pytest.raises(NetError, match="'q': has no capacity; the expanded net needs a bound"):
        expanded_net(net)
    assert Oracle(expanded_net(net, {"q": 1})).facts()["states"] == 2


def test_too_many_variants_are_refused():
    places = tuple(Place(f"p{k}", capacity=9) for k in range(5))
    net = PetriNet("wide", places, (Transition("t", (), (), sets={p.name: 0 for p in places}),))
    with pytest.raises(NetError, match="would need 100000 transitions"):
        expanded_net(net)


def test_another_version_of_our_block_is_refused():
    text = to_pnml(producer(1)).replace('tool="cprm_gym" version="1">\n   <note>', 'tool="cprm_gym" version="9">\n   <note>')
    with pytest.raises(FormatError, match="version '9' of our extensions"):
        parse_pnml(text)


def test_a_definition_that_is_no_net_is_refused_with_its_line():
    text = to_pnml(producer(1))
    start, end = text.index("<definition>") + len("<definition>"), text.index("</definition>")
    with pytest.raises(FormatError, match=r"line \d+, <definition>: not JSON"):
        parse_pnml(text[:start] + "{nonsense" + text[end:])


def test_renaming_a_place_changes_the_value_but_not_the_behaviour():
    net = replace(producer(1), name="other")
    assert parse_pnml(to_pnml(net)) != producer(1)


def test_another_tool_reads_the_skeleton_and_finds_the_same_markings_in_the_expanded_net():
    """SNAKES, an independent reader of plain place/transition nets."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if sys.version_info >= (3, 12):
            pytest.skip("SNAKES needs pkgutil.ImpImporter, which Python 3.12 took away")
        from snakes.nets import StateGraph
        from snakes.pnml import loads

        for seed in range(12):
            net = random_net(seed, timed=False)
            assert len(loads(to_pnml(net)).transition()) == len(net.transitions)
            graph = StateGraph(loads(to_pnml(expanded_net(net))))
            graph.build()
            assert len(graph) == len(Oracle(net).edges), f"net {seed}"
