"""PNML: what is read, in which spellings, and what is refused with its element and line."""

import json

import pytest
from paths import SHARED

from cprm_gym.architecture.petri import PetriNet, Place, Transition
from cprm_gym.architecture.petri.files.pnml_reader import parse_pnml, read_pnml
from cprm_gym.errors import FormatError, FormatWarning

CASES = SHARED / "cases" / "petri"
PTNET = "http://www.pnml.org/version-2009/grammar/ptnet"


def pnml(body, kind=PTNET, page=True):
    inner = f"<page id='page'>\n{body}\n</page>" if page else body
    head = "<?xml version='1.0'?>\n<pnml xmlns='http://www.pnml.org/version-2009/grammar/pnml'>"
    return f"{head}\n<net id='n' type='{kind}'>\n{inner}\n</net></pnml>"


P = "<place id='p'><initialMarking><text>2</text></initialMarking></place>"
Q = "<place id='q'/>"
T = "<transition id='t'/>"
IN = "<arc id='a' source='p' target='t'/>"
OUT = "<arc id='b' source='t' target='q'/>"


def net(**arcs):
    return PetriNet("n", (Place("p", tokens=2), Place("q")), (Transition("t", ("p",), ("q",), **arcs),))


def test_a_plain_net_is_read():
    assert parse_pnml(pnml(P + Q + T + IN + OUT)) == net()


def test_arcs_between_the_same_two_nodes_add_up():
    got = parse_pnml(pnml(P + Q + T + IN + "<arc id='a2' source='p' target='t'><inscription><text>3</text></inscription></arc>" + OUT))
    assert got.transition("t").inputs == {"p": 4}


@pytest.mark.parametrize(
    "arc",
    [
        "<arc id='i' source='q' target='t' type='inhibitor'><inscription><text>2</text></inscription></arc>",
        "<arc id='i' source='q' target='t'><type value='inhibitor'/><inscription><text>2</text></inscription></arc>",
        "<arc id='i' source='q' target='t'><type><text>inhibitor</text></type><inscription><value>2</value></inscription></arc>",
        "<arc id='i' source='q' target='t'><arctype><text>inhibitor</text></arctype><inscription><text>2</text></inscription></arc>",
        "<arc id='i' source='q' target='t' type='tapnInhibitor'><inscription><value>2</value></inscription></arc>",
        "<inhibitorArc id='i' source='q' target='t'><inscription><value>2</value></inscription></inhibitorArc>",
    ],
)
def test_every_spelling_of_an_inhibitor_arc_is_read(arc):
    assert parse_pnml(pnml(P + Q + T + IN + OUT + arc)) == net(inhibitors={"q": 2})


@pytest.mark.parametrize("spelling", ["test", "read"])
def test_test_and_read_arcs_are_read(spelling):
    assert parse_pnml(pnml(P + Q + T + IN + OUT + f"<arc id='i' source='q' target='t' type='{spelling}'/>")) == net(tests=("q",))


def test_a_reset_arc_sets_to_zero():
    got = parse_pnml(pnml(P + Q + T + IN + OUT + "<arc id='i' source='p' target='t' type='reset'/>"))
    assert got.transition("t").sets == {"p": 0}


def test_nets_without_pages_nested_pages_prefixes_and_reference_nodes_are_read():
    assert parse_pnml(pnml(P + Q + T + IN + OUT, page=False)) == net()
    nested = P + "<page id='inner'>" + Q + T + "<referencePlace id='r' ref='p'/><arc id='a' source='r' target='t'/></page>" + OUT
    assert parse_pnml(pnml(nested)) == net()
    prefixed = pnml(P + Q + T + IN + OUT).replace("<", "<x:").replace("<x:/", "</x:").replace("<x:?", "<?").replace("xmlns=", "xmlns:x=")
    assert parse_pnml(prefixed) == net()


def test_the_dialect_of_pipe_is_read():
    body = """<place id='p'><initialMarking><value>Default,2</value></initialMarking><capacity><value>0</value></capacity></place>
    <place id='q'><initialMarking><value>Default,0</value></initialMarking><capacity><value>3</value></capacity></place>
    <transition id='t'><timed><value>false</value></timed><rate><value>1.0</value></rate><priority><value>2</value></priority>
    <infiniteServer><value>false</value></infiniteServer><orientation><value>0</value></orientation></transition>
    <arc id='a' source='p' target='t'><inscription><value>Default,1</value></inscription><arcpath id='0' x='1' y='2'/></arc>
    <arc id='b' source='t' target='q'><type value='normal'/></arc>"""
    got = parse_pnml(pnml(body, kind="P/T net", page=False))
    assert got.place("q") == Place("q", capacity=3)
    assert (got.transition("t").priority, got.transition("t").inputs) == (2, {"p": 1})


def test_the_dialects_of_tapaal_and_tina_are_read_where_they_say_nothing_about_time():
    tapaal = """<place id='p' name='p' initialMarking='2' invariant='&lt; inf'/><place id='q' name='q' initialMarking='0'/>
    <transition id='t' name='t' urgent='false'/><arc id='a' source='p' target='t' type='timed' inscription='[0,inf)' weight='2'/>
    <arc id='b' source='t' target='q' type='normal' inscription='1'/>"""
    got = parse_pnml(pnml(tapaal, kind="P/T net", page=False))
    assert (got.place("p").tokens, got.transition("t").inputs) == (2, {"p": 2})
    for change in (("[0,inf)", "[2,5]"), ("&lt; inf", "&lt;= 4"), ("urgent='false'", "urgent='true'")):
        with pytest.raises(FormatError, match=r"timed|ages of tokens|urgent"):
            parse_pnml(pnml(tapaal.replace(*change), kind="P/T net", page=False))
    delay = "<transition id='t'><delay><interval closure='closed-open'><cn>0</cn><ci>infty</ci></interval></delay></transition>"
    assert parse_pnml(pnml(P + Q + delay + IN + OUT, kind="http://www.laas.fr/tina/tpn")) == net()


def test_exponential_rates_are_refused_or_dropped_when_asked():
    body = P + Q + "<transition id='t'><timed><value>true</value></timed><rate><value>2.5</value></rate></transition>" + IN + OUT
    with pytest.raises(FormatError, match="exponential rates have no meaning here"):
        parse_pnml(pnml(body))
    assert parse_pnml(pnml(body), rates="plain") == net()


def test_names_are_labels_if_they_differ_and_ids_otherwise():
    body = "<place id='p1'><name><text>same</text></name></place><place id='p2'><name><text>same</text></name></place>"
    with pytest.warns(FormatWarning, match="ignored: names of places, since some are alike"):
        assert [p.name for p in parse_pnml(pnml(body)).places] == ["p1", "p2"]
    body = "<place id='p1'><name><text>one</text></name></place><place id='p2'><name><text>max</text></name></place>"
    assert [p.name for p in parse_pnml(pnml(body)).places] == ["one", "max_"]


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (P + T + "\n<arc id='a' source='p' target='t' type='transport'/>", r"line 6, <arc>: arcs of type 'transport'"),
        (P + T + "\n<arc id='a' source='p' target='x'/>", r"line 6, <arc>: target 'x' is neither a place nor a transition"),
        (P + Q + "\n<arc id='a' source='p' target='q'/>", r"line 6, <arc>: joins 'p' and 'q'"),
        (P + T + "\n<arc id='a' source='t' target='p' type='inhibitor'/>", r"line 6, <arc>: an arc of type inhibitor goes from a place"),
        (P + T + "\n<arc id='a' source='p' target='t'><inscription><text>x+1</text></inscription></arc>", r"line 6, <inscription>: .*x\+1"),
        (P + T + "\n<arc id='a' source='p' target='t'><inscription><text>0</text></inscription></arc>", r"line 6, <arc>: .*at least 1"),
        (P + "\n" + P, r"line 6, <place>: the id 'p' is used twice"),
        ("\n<place/>", r"line 6, <place>: has no `id`"),
        ("\n<place id='p'><initialMarking><text>-1</text></initialMarking></place>", r"line 6, <initialMarking>: .*-1"),
        ("\n<place id='p'><initialMarking><text>Red,1,Blue,2</text></initialMarking></place>", r"line 6, .*coloured"),
        ("\n<place id='p'><hlinitialMarking/></place>", r"line 6, <hlinitialMarking>: is not understood inside <place>"),
        ("\n<place id='p'><initialMarking><multiset/></initialMarking></place>", r"line 6, <multiset>: is not understood inside"),
        ("\n<gadget/>", r"line 6, <gadget>: is not understood inside <page>"),
        (T + "\n<referencePlace id='r' ref='s'/><referencePlace id='s' ref='r'/><arc id='a' source='r' target='t'/>", "refers to itself"),
        ("\n<transition id='t'><delay><text>3</text></delay></transition>", r"line 6, <delay>: delays of other tools"),
    ],
)  # fmt: skip
def test_what_is_not_understood_is_refused_with_element_and_line(body, message):
    with pytest.raises(FormatError, match=message):
        parse_pnml(pnml(body), "file.pnml")


def test_other_kinds_of_nets_and_documents_are_refused():
    with pytest.raises(
        FormatError, match=r"net type 'http://www.pnml.org/version-2009/grammar/symmetricnet' is not a place/transition net"
    ):
        parse_pnml(pnml(P, kind="http://www.pnml.org/version-2009/grammar/symmetricnet"))
    with pytest.raises(FormatError, match="<html>: a PNML document starts with <pnml>"):
        parse_pnml("<html/>")
    with pytest.raises(FormatError, match="holds 0 nets"):
        parse_pnml("<pnml/>")
    two = "<pnml><net id='a' type='ptnet'/><net id='b' type='ptnet'><place id='p'/></net></pnml>"
    with pytest.raises(FormatError, match="holds 2 nets"):
        parse_pnml(two)
    assert [p.name for p in parse_pnml(two, net="b").places] == ["p"]
    with pytest.raises(FormatError, match="no net 'c'"):
        parse_pnml(two, net="c")


@pytest.mark.parametrize(
    "text",
    [
        "<?xml version='1.0'?><!DOCTYPE pnml [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;&a;&a;'>]><pnml>&b;</pnml>",
        "<?xml version='1.0'?><!DOCTYPE pnml [<!ENTITY x SYSTEM 'file:///etc/hostname'>]><pnml>&x;</pnml>",
        "<?xml version='1.0'?><!DOCTYPE pnml SYSTEM 'http://example.invalid/x.dtd'><pnml/>",
    ],
)
def test_entities_and_external_references_are_refused(text):
    with pytest.raises(FormatError, match="refused, since it declares entities or external references"):
        parse_pnml(text)


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\x00\x01",
        b"<pnml",
        b"<pnml><net></pnml>",
        "<a>" * 500 + "</a>" * 500,
        b"<?xml version='1.0' encoding='nonsense'?><pnml/>",
        b"\xff\xfe<",
    ],
)
def test_broken_documents_are_refused(data):
    with pytest.raises(FormatError):
        parse_pnml(data, "broken.pnml")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FormatError, match=r"nothing\.pnml: cannot be read"):
        read_pnml(tmp_path / "nothing.pnml")


def test_every_prefix_of_a_file_is_refused_or_read_but_never_crashes():
    text = pnml(P + Q + T + IN + OUT)
    for cut in range(0, len(text), 7):
        with pytest.raises(FormatError):
            parse_pnml(text[:cut])


@pytest.mark.filterwarnings("ignore::cprm_gym.errors.FormatWarning")
@pytest.mark.skipif(not (CASES / "index.json").is_file(), reason="data of ../shared absent")
def test_inhibitor_arcs_of_the_public_models_are_all_there():
    index = json.loads((CASES / "index.json").read_text())
    checked = 0
    for file, known in index.items():
        if "inhibitor_arcs" in known:
            arcs = [w for t in read_pnml(CASES / file).transitions for w in t.inhibitors.values()]
            assert (len(arcs), max(arcs)) == (known["inhibitor_arcs"], known["max_inhibitor_weight"]), file
            checked += 1
    assert checked > 50
