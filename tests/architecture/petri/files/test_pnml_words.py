"""PNML: nothing is read as something else; what is not understood is refused with its element and line."""

import pytest
from paths import SHARED

from cprm_gym.architecture.petri import Continuous, PetriNet, Place, Transition
from cprm_gym.architecture.petri.files.pnml_reader import parse_pnml, read_pnml
from cprm_gym.architecture.petri.files.pnml_writer import to_pnml
from cprm_gym.errors import FormatError, FormatWarning

PLACE = "<place id='p'><initialMarking><text>2</text></initialMarking></place>"
MOVE = "<transition id='t'/>"


def document(body, head="<pnml xmlns='http://www.pnml.org/version-2009/grammar/pnml' xmlns:z='http://example.org/other'>"):
    return f"{head}\n<net id='n' type='ptnet'>\n{body}\n</net></pnml>"


def arc(inner="", attributes=""):
    return PLACE + MOVE + f"\n<arc id='a' source='p' target='t' {attributes}>{inner}</arc>"


def place(inner="", attributes=""):
    return f"\n<place id='p' {attributes}>{inner}</place>"


def transition(inner="", attributes=""):
    return f"\n<transition id='t' {attributes}>{inner}</transition>"


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (arc("<inscription><inhibitor/></inscription>"), "line 4, <inhibitor>: is not understood inside <inscription>"),
        (arc("<inscription><test><value><token/></value></test></inscription>"), "line 4, <test>: is not understood inside <inscription>"),
        (arc("<inscription><number>3</number></inscription>"), "line 4, <number>: is not understood inside <inscription>"),
        (arc("<inscription><text>3</text><text>2</text></inscription>"), "line 4, <inscription>: says several things: '3', '2'"),
        (arc("<inscription>2<text>3</text></inscription>"), "line 4, <inscription>: says several things"),
        (arc("<inscription><text><b>3</b></text></inscription>"), "line 4, <b>: is not understood inside <text>"),
        (arc("<inscription><text>1_0</text></inscription>"), "line 4, <inscription>: an inscription is a whole number, got '1_0'"),
        (arc("<inscription><text>\u0663</text></inscription>"), "line 4, <inscription>: an inscription is a whole number"),
        (arc("<inscription><text>3</text></inscription><inscription/>"), "line 4, <inscription>: stands twice inside <arc>"),
        (arc("<inscription><text>3</text></inscription>", "weight='2'"), "line 4, <arc>: says several things: normal, 2, 3"),
        (arc("<inscription kind='inhibitor'><text>1</text></inscription>"), "line 4, <inscription>: the attribute kind='inhibitor'"),
        (arc("<type text='inhibitor'/>"), "line 4, <type>: the attribute text='inhibitor' is not understood"),
        (arc("<type><inhibitor/></type>"), "line 4, <inhibitor>: is not understood inside <type>"),
        (arc("<type><text>inhibitor</text></type>", "type='normal'"), "line 4, <arc>: says several things: inhibitor, normal"),
        (arc("", "kind='inhibitor'"), "line 4, <arc>: the attribute kind='inhibitor' is not understood"),
        (arc("", "inscription='[2,5]'"), "line 4, <arc>: inscription .* ages of tokens"),
        (arc("<condition/>"), "line 4, <condition>: is not understood inside <arc>"),
        (arc("<z:type><text>inhibitor</text></z:type>"), "line 4, <type>: is of the namespace 'http://example.org/other'"),
        (arc("", "z:type='inhibitor'"), "line 4, <arc>: the attribute {http://example.org/other}type='inhibitor' is not understood"),
        (arc("inhibitor"), "line 4, <arc>: the text 'inhibitor' is not understood"),
        (PLACE + MOVE + "\n<arc id='a' source='t' target='p' type='reset'/>", "line 4, <arc>: an arc of type reset goes from a place"),
        (place("<capacity><number>3</number></capacity>"), "line 4, <number>: is not understood inside <capacity>"),
        (place("<capacity><text>3.5</text></capacity>"), "line 4, <capacity>: a capacity is a whole number"),
        (place("<initialMarking><number>3</number></initialMarking>"), "line 4, <number>: is not understood inside <initialMarking>"),
        (place("<initialMarking><text>1_0</text></initialMarking>"), "line 4, <initialMarking>: a marking is a whole number"),
        (place("<initialMarking><z:text>1</z:text></initialMarking>"), "line 4, <text>: is not understood inside <initialMarking>"),
        (place("<z:initialMarking><text>1</text></z:initialMarking>"), "line 4, <initialMarking>: is of the namespace"),
        (place("<initialMarking><text>1</text></initialMarking>", "initialMarking='1'"), "line 4, <place>: its marking is given twice"),
        (place("", "kind='continuous'"), "line 4, <place>: the attribute kind='continuous'"),
        (place("", "capacity='1'"), "line 4, <place>: the attribute capacity='1'"),
        (place("<type><text>channel</text></type>"), "line 4, <type>: places of type 'channel'"),
        (place("<marking><text>3</text></marking>"), "line 4, <marking>: is not understood inside <place>"),
        (transition("<type><text>XOR</text></type>"), "line 4, <type>: transitions of type 'XOR' are not read here"),
        (transition("<delay><text>3</text></delay>"), "line 4, <delay>: delays of other tools"),
        (transition("<guard><text>x</text></guard>"), "line 4, <guard>: is not understood inside <transition>"),
        (transition("<priority><number>3</number></priority>"), "line 4, <number>: is not understood inside <priority>"),
        (transition("<timed><text>maybe</text></timed>"), "line 4, <timed>: <timed> is true or false, got 'maybe'"),
        (transition("<rate><text>nan</text></rate>"), "line 4, <rate>: a rate is a number, got 'nan'"),
        (transition("<rate><text>0</text></rate>"), "line 4, <rate>: a rate is more than 0, got '0'"),
        ("\n<page id='g'><net id='s' type='highlevelnet'/></page>", "line 4, <net>: net type 'highlevelnet' is not"),
        (transition("", "delay='3'"), "line 4, <transition>: the attribute delay='3'"),
        (transition("", "guard='x &gt; 1'"), "line 4, <transition>: the attribute guard='x > 1'"),
        (transition("", "priority='3'"), "line 4, <transition>: priority='3' has no meaning here"),
        (transition("", "kind='timed'"), "line 4, <transition>: the attribute kind='timed'"),
        ("\n<referencePlace id='r' ref='x'/>", "line 4, <referencePlace>: 'x' is neither a place nor a transition of this net"),
        (MOVE + "\n<referencePlace id='r' ref='t'/>", "line 4, <referencePlace>: refers to 't', which is of the other kind"),
        (PLACE + "\n<referencePlace id='r' ref='p'><initialMarking/></referencePlace>", "line 4, <initialMarking>: is not understood"),
    ],
)  # fmt: skip
def test_what_is_not_understood_is_refused(body, message):
    with pytest.raises(FormatError, match=message):
        parse_pnml(document(body), "file.pnml")


@pytest.mark.parametrize("child", ["shared-thing", "system", "z:net"])
def test_what_is_not_understood_beside_the_nets_is_refused(child):
    with pytest.raises(FormatError, match=f"<{child.rpartition(':')[2]}>: is (not understood|of the namespace)"):
        parse_pnml(document(PLACE).replace("</pnml>", f"<{child}/></pnml>"))


@pytest.mark.parametrize(
    "kind", ["notaptnetatall", "http://example.org/stochasticptnet", "http://www.pnml.org/version-2009/grammar/highlevelnet"]
)
def test_a_net_type_is_known_or_refused(kind):
    with pytest.raises(FormatError, match="is not a place/transition net"):
        parse_pnml(document(PLACE).replace("type='ptnet'", f"type='{kind}'"))


def test_what_the_standard_lets_a_reader_ignore_is_ignored_and_named():
    extra = "<graphics><position x='1' y='2'/></graphics><toolspecific tool='Other' version='1'><z:secret/></toolspecific>"
    with pytest.warns(FormatWarning, match=r"file\.pnml: ignored: <toolspecific> of 'Other' \(2 times\)"):
        got = parse_pnml(document(place(extra) + transition(extra)), "file.pnml")
    assert got == PetriNet("n", (Place("p"),), (Transition("t"),))


def test_drawings_languages_and_schemas_say_nothing_about_a_net():
    head = "<pnml xmlns:xsi='http://www.w3.org/2001/XMLSchema-instance' xsi:schemaLocation='a b' xml:lang='en'>"
    body = place("<name><graphics><offset x='1' y='2'/></graphics><text>p</text></name><graphics/>", "positionX='3'")
    assert parse_pnml(document(body, head)) == PetriNet("n", (Place("p"),))


def test_our_own_hints_without_our_block_are_refused_where_they_need_it():
    hint = place("<toolspecific tool='cprm_gym' version='1'><kind>continuous</kind></toolspecific>")
    with pytest.raises(FormatError, match=r"<kind>: .*says what our block at the net defines"):
        parse_pnml(document(hint))
    assert parse_pnml(document(hint), block=False) == PetriNet("n", (Place("p"),))
    late = transition("<toolspecific tool='cprm_gym' version='1'><delay>1_0</delay></toolspecific>")
    with pytest.raises(FormatError, match="<delay>: a delay is a whole number, got '1_0'"):
        parse_pnml(document(late))
    assert not parse_pnml(document(late), block=False).transition("t").is_timed


def test_names_that_are_words_of_our_language_or_alike_when_cut_become_legal():
    names = ["and", "x" * 300, "x" * 301]
    body = "".join(f"<place id='p{k}'><name><text>{name}</text></name></place>" for k, name in enumerate(names))
    assert [p.name for p in parse_pnml(document(body)).places] == ["and_", "x" * 180, "x" * 180 + "_1"]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('threshold="2"', 'threshold="3"'),
        ('type="inhibitor"', 'type="test"'),
        ('   <arc type="inhibitor" place="p" transition="t" threshold="2"/>\n', ""),
        ("<definition>", "<arc/><definition>"),
        ("<definition>", "<definition>{}</definition><definition>"),
    ],
)
def test_our_block_must_agree_with_itself(old, new):
    text = to_pnml(PetriNet("n", (Place("p"), Continuous("x", 0.5)), (Transition("t", inhibitors={"p": 2}, tests={"x": 0.25}),)))
    assert parse_pnml(text).transition("t").inhibitors == {"p": 2}
    assert old in text
    with pytest.raises(FormatError, match=r"is gone|differs from the definition|not a net"):
        parse_pnml(text.replace(old, new))


FAULTS = sorted((SHARED / "cases" / "faults" / "pnml").glob("*.pnml"))


@pytest.mark.skipif(not FAULTS, reason="data of ../shared absent")
@pytest.mark.parametrize("file", FAULTS, ids=lambda path: path.stem)
def test_files_that_were_read_as_something_else_are_refused_with_file_element_and_line(file):
    with pytest.raises(FormatError, match=rf"{file.name}, line \d+, <\w+>: "):
        read_pnml(file)
