"""PNML files with several nets: one is named, or all are one when they share places and transitions."""

import pytest
from typer.testing import CliRunner

from cprm_gym.architecture.petri import PetriNet, Place, Transition
from cprm_gym.architecture.petri.files.load import load_net, net_names
from cprm_gym.architecture.petri.files.pnml_reader import parse_pnml
from cprm_gym.cli import app
from cprm_gym.errors import FormatError

TWO = """<pnml>
<net id='a' type='ptnet'><name><text>first</text></name><place id='p'/></net>
<net id='b' type='ptnet'><place id='q'/></net>
</pnml>"""

SHARED = """<pnml>
<shared-place name='ball' initialMarking='1' invariant='&lt; inf'/>
<shared-transition name='pass' urgent='false'/>
<net id='left' type='P/T net' active='true'>
 <place id='ball' name='ball' initialMarking='1'/><place id='ready' name='ready' initialMarking='2'/>
 <transition id='pass' name='pass'/><transition id='get' name='get'/>
 <arc id='a1' source='ready' target='pass' type='normal' inscription='1' weight='2'/>
 <arc id='a2' source='ball' target='get' type='normal' inscription='1'/>
</net>
<net id='right' type='P/T net' active='true'>
 <place id='P0' name='ball' initialMarking='0'/><place id='ready' name='ready'/><transition id='T0' name='pass'/>
 <arc id='a1' source='P0' target='T0' type='normal' inscription='1'/>
 <arc id='a2' source='T0' target='ready' type='normal' inscription='1'/>
</net>
<net id='off' type='P/T net' active='false'><place id='x' name='x'/></net>
</pnml>"""


def test_one_of_several_nets_is_chosen_by_id_or_name(tmp_path):
    path = tmp_path / "two.pnml"
    path.write_text(TWO)
    assert net_names(path) == ("a", "b")
    assert load_net(path, net="first") == load_net(path, net="a") == PetriNet("first", (Place("p"),))
    with pytest.raises(FormatError, match=r"holds no net 'firts'\. Did you mean 'first'\? It holds 'a', 'first', 'b'"):
        load_net(path, net="firts")
    with pytest.raises(FormatError, match=r"holds 2 nets, expected one; name one of \['a', 'b'\]"):
        load_net(path)


def test_the_command_line_names_one_of_several_nets(tmp_path):
    path = tmp_path / "two.pnml"
    path.write_text(TWO)
    done = CliRunner().invoke(app, ["analyze", str(path), "--net", "b", "--json"])
    assert '"name": "b"' in done.output
    assert CliRunner().invoke(app, ["analyze", str(path)]).exit_code == 2
    done = CliRunner().invoke(app, ["analyze", "go_to_ball", "--net", "b"])
    assert (done.exit_code, "go_to_ball ships as one net; --net names one of several in a file" in done.output) == (2, True)


def test_nets_that_share_places_and_transitions_are_one_net():
    got = parse_pnml(SHARED)
    places = (Place("ball", tokens=1), Place("left.ready", tokens=2), Place("right.ready"))
    moves = (Transition("pass", {"left.ready": 2, "ball": 1}, ("right.ready",)), Transition("left.get", ("ball",)))
    assert got == PetriNet("net", places, moves)


def test_a_net_that_shares_is_not_read_without_the_others():
    with pytest.raises(FormatError, match="line 5, <place>: 'ball' is shared by several nets of this file; read them together"):
        parse_pnml(SHARED, net="left")
    assert parse_pnml(SHARED, net="off") == PetriNet("off", (Place("x"),))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("id='P0' name='ball' initialMarking='0'", "id='P0' name='ball' initialMarking='3'", "differs from the shared place"),
        ("name='pass' urgent='false'", "name='pass' urgent='true'", "urgent='true' has no meaning"),
        ("<shared-transition name='pass'", "<shared-transition name='ball'", "the name 'ball' is used twice"),
        ("invariant='&lt; inf'", "invariant='&lt;= 3'", "ages of tokens"),
        ("<transition id='get' name='get'/>", "<transition id='get' name='ball'/>", "<transition>: has the name of a <shared-place>"),
    ],
)  # fmt: skip
def test_shared_parts_that_do_not_fit_are_refused(old, new, message):
    with pytest.raises(FormatError, match=message):
        parse_pnml(SHARED.replace(old, new))


def test_the_border_places_of_a_subprocess_must_agree():
    text = """<pnml><net id='n' type='ptnet'><place id='p'><initialMarking><text>1</text></initialMarking></place>
    <page id='g'><net id='s'><place id='p'>{}</place></net></page></net></pnml>"""
    assert parse_pnml(text.format("")) == PetriNet("n", (Place("p", tokens=1),))
    with pytest.raises(FormatError, match="line 2, <place>: differs from the place of the same id in line 1"):
        parse_pnml(text.format("<initialMarking><text>2</text></initialMarking>"))
