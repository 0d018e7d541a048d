"""Files of the editor: round trips without loss, drafts that outlive the program, changed files asked about, nothing outside the folder."""

import json

import pytest

from cprm_gym.agents.catalogue import shipped_nets
from cprm_gym.agents.goalie import GOALIE_NET, goalie_cprm
from cprm_gym.agents.models import BALL_MODEL
from cprm_gym.agents.skills.approach import APPROACH
from cprm_gym.architecture.cprm.files import load_cprm, save_cprm
from cprm_gym.architecture.petri import PetriNet, Place, Transition, load_net, save_net, write_pnml
from cprm_gym.architecture.prm import Grounding, load_model, save_model
from cprm_gym.errors import CprmError, FormatError
from cprm_gym.studio.editing.desk import Desk
from cprm_gym.studio.editing.document import Document, form_of
from cprm_gym.studio.editing.files import content
from cprm_gym.studio.editing.python_source import python_source

GOALIE = goalie_cprm()
SMALL = PetriNet("small", (Place("a", tokens=1), Place("b")), (Transition("t", ("a",), ("b",)),))


@pytest.fixture
def desk(tmp_path):
    made = Desk(lambda *_, **__: None, tmp_path / "work", tmp_path / "drafts", seconds=0.2)
    (tmp_path / "work").mkdir()
    yield made
    made.close()


def again(desk):
    """The desk of a new start in the same folder."""
    desk.close()
    return Desk(lambda *_, **__: None, desk.files.root, desk.files.drafts, seconds=0.2)


@pytest.mark.parametrize("ending", ["json", "pnml"])
def test_a_net_with_modules_and_positions_comes_back_the_same_from_its_file(desk, ending):
    save_net(APPROACH, desk.files.root / "approach.json")
    key = desk.open("approach.json")["id"]
    inner = next(iter(APPROACH.modules.values())).name
    desk.apply(key, {"op": "move", "in": "approach", "at": {APPROACH.transitions[0].name: [7, 8.5]}})
    desk.apply(key, {"op": "move", "in": inner, "at": {"begin": [-3, 4]}})
    positions = desk.document(key).positions
    desk.save(key, f"other.{ending}")
    assert load_net(desk.files.root / f"other.{ending}") == APPROACH
    opened = again(desk)
    key = opened.open(f"other.{ending}")["id"]
    assert opened.document(key).value() == APPROACH
    assert opened.document(key).positions == positions
    assert positions[inner]["begin"] == (-3, 4)
    opened.close()


def test_a_plain_net_keeps_its_positions_in_pnml_where_other_tools_find_them(desk):
    key = desk.add("small", SMALL, "new:small")
    desk.apply(key, {"op": "move", "in": "small", "at": {"a": [10, 20], "b": [10, 90], "t": [10, 55]}})
    desk.save(key, "small.pnml")
    text = (desk.files.root / "small.pnml").read_text()
    assert '<position x="10" y="90"/>' in text
    opened = again(desk)
    assert opened.document(opened.open("small.pnml")["id"]).positions["small"] == {"a": (10, 20), "b": (10, 90), "t": (10, 55)}
    opened.close()


def test_every_shipped_net_as_python_is_the_same_net():
    for net in shipped_nets().values():
        space = {}
        exec(python_source(net), space)
        assert net in [v for v in space.values() if isinstance(v, PetriNet)], net.name


def test_models_worlds_and_cprms_as_python_are_the_same():
    space = {}
    exec(python_source(BALL_MODEL), space)
    assert space["MODEL"] == BALL_MODEL
    space = {}
    exec(python_source(GOALIE.grounding()), space)
    assert (space["WORLD"].model, space["WORLD"].objects) == (GOALIE.model, dict(GOALIE.objects))
    space = {}
    exec(python_source(GOALIE), space)
    assert space["CPRM_VALUE"] == GOALIE


def test_models_and_cprms_are_opened_changed_and_saved(desk):
    save_model(BALL_MODEL, desk.files.root / "ball.json")
    save_cprm(GOALIE, desk.files.root / "goalie.json")
    ball, goalie = desk.open("ball.json")["id"], desk.open("goalie.json")["id"]
    desk.apply(ball, {"op": "set", "path": ["model", "name"], "value": "other"}, "model")
    desk.apply(goalie, {"op": "rename", "in": GOALIE.net.name, "name": "hold", "to": "keep"})
    desk.save(ball)
    desk.save(goalie)
    assert load_model(desk.files.root / "ball.json").classes == BALL_MODEL.classes
    assert load_model(desk.files.root / "ball.json").name == "other"
    assert load_cprm(desk.files.root / "goalie.json").net.transition("keep")
    assert load_cprm(desk.files.root / "goalie.json").model == GOALIE.model


def test_a_file_that_changed_meanwhile_is_asked_about_and_not_overwritten(desk):
    path = desk.files.root / "small.json"
    save_net(SMALL, path)
    key = desk.open("small.json")["id"]
    desk.apply(key, {"op": "rename", "in": "small", "name": "a", "to": "start"})
    path.write_text(path.read_text() + "\n")
    before = path.read_text()
    assert "was changed" in desk.save(key)["conflict"]
    assert path.read_text() == before
    assert "conflict" not in desk.save(key, force=True)
    assert load_net(path).place("start")


def test_a_file_that_is_there_already_is_asked_about(desk):
    path = desk.files.root / "there.json"
    path.write_text("mine")
    key = desk.add("small", SMALL, "new:small")
    assert "is there already" in desk.save(key, "there.json")["conflict"]
    assert path.read_text() == "mine"


def test_what_was_not_saved_is_there_after_a_new_start(desk):
    save_net(SMALL, desk.files.root / "small.json")
    key = desk.open("small.json")["id"]
    desk.apply(key, {"op": "rename", "in": "small", "name": "a", "to": "start"})
    fresh = desk.new("net", "fresh")["id"]
    desk.apply(fresh, {"op": "add_place", "in": "fresh", "place": {"kind": "place", "name": "p"}})
    opened = again(desk)
    state = opened.open("small.json")
    assert state["data"]["definitions"]["small"]["places"][0]["name"] == "start"
    assert "not saved" in state["told"]
    assert not state["saved"]
    (other,) = [d for d in opened.list()["open"] if d["name"] == "fresh"]
    assert opened.document(other["id"]).value().place("p")
    opened.undo(state["id"])
    assert opened.document(state["id"]).value() == SMALL, "the file's content is one step back"
    opened.close()


def test_a_draft_whose_file_changed_says_so(desk):
    path = desk.files.root / "small.json"
    save_net(SMALL, path)
    key = desk.open("small.json")["id"]
    desk.apply(key, {"op": "rename", "in": "small", "name": "a", "to": "start"})
    save_net(PetriNet("small", (Place("z"),)), path)
    opened = again(desk)
    state = opened.open("small.json")
    assert "the file was changed" in state["told"]
    assert "conflict" in opened.save(state["id"])
    opened.close()


def test_a_saved_document_leaves_no_draft(desk):
    key = desk.new("net", "fresh")["id"]
    assert list(desk.files.drafts.iterdir())
    desk.apply(key, {"op": "add_place", "in": "fresh", "place": {"kind": "place", "name": "p"}})
    desk.save(key, "fresh.json")
    assert not list(desk.files.drafts.iterdir())


def test_going_back_to_the_file_can_be_undone(desk):
    save_net(SMALL, desk.files.root / "small.json")
    key = desk.open("small.json")["id"]
    desk.apply(key, {"op": "rename", "in": "small", "name": "a", "to": "start"})
    assert desk.discard(key)["data"] == form_of(SMALL)
    assert desk.undo(key)["data"]["definitions"]["small"]["places"][0]["name"] == "start"


@pytest.mark.parametrize("path", ["../out.json", "/etc/passwd", "a/../../out.json", "", "x\0.json"])
def test_nothing_outside_the_folder_is_read_or_written(desk, path):
    key = desk.add("small", SMALL, "new:small")
    for call in (lambda: desk.open(path), lambda: desk.files.inside(path)):
        with pytest.raises(FormatError):
            call()
    if path:
        with pytest.raises(FormatError):
            desk.save(key, path)


def test_a_link_out_of_the_folder_is_not_followed(desk, tmp_path):
    save_net(SMALL, tmp_path / "secret.json")
    (desk.files.root / "link.json").symlink_to(tmp_path / "secret.json")
    with pytest.raises(FormatError, match="outside"):
        desk.open("link.json")


def test_a_file_that_the_command_line_names_may_lie_elsewhere(desk, tmp_path):
    save_net(SMALL, tmp_path / "elsewhere.json")
    key = desk.open_named(str(tmp_path / "elsewhere.json"))
    desk.apply(key, {"op": "rename", "in": "small", "name": "a", "to": "start"})
    desk.save(key)
    assert load_net(tmp_path / "elsewhere.json").place("start")


def test_a_name_in_a_module_is_opened_and_must_be_saved_under_another(desk):
    key = desk.open_named("cprm_gym.agents.goalie:GOALIE_NET")
    assert desk.document(key).value() == GOALIE_NET
    with pytest.raises(FormatError, match="name"):
        desk.save(key)
    with pytest.raises(FormatError, match="neither"):
        desk.open_named("cprm_gym.agents.goalie:AT_BALL")
    with pytest.raises(FormatError, match="Did you mean"):
        desk.open_named("cprm_gym.agents.goalie:GOALY_NET")
    with pytest.raises(FormatError, match="cannot be read"):
        desk.open("cprm_gym.agents.striker:STRIKER_NET")


def test_damaged_files_are_refused_and_leave_nothing_open(desk):
    for name, text in (("a.json", "{"), ("b.json", '{"format": "cake"}'), ("c.json", "[1]"), ("d.pnml", "<pnml>"), ("e.json", "")):
        (desk.files.root / name).write_text(text)
        with pytest.raises(CprmError):
            desk.open(name)
    assert desk.list()["open"] == []


def test_an_unfinished_model_is_kept_as_a_draft_but_not_saved(desk):
    save_model(BALL_MODEL, desk.files.root / "ball.json")
    before = (desk.files.root / "ball.json").read_text()
    key = desk.open("ball.json")["id"]
    state = desk.apply(key, {"op": "set", "path": ["model", "classes", 0, "attributes", 0, "parents"], "value": ["nothing"]}, "model")
    assert "nothing" in state["problem"]
    with pytest.raises(CprmError, match="nothing"):
        desk.save(key)
    assert (desk.files.root / "ball.json").read_text() == before
    opened = again(desk)
    assert "nothing" in opened.open("ball.json")["problem"]
    opened.close()


def test_only_nets_are_written_as_pnml():
    with pytest.raises(FormatError, match="model"):
        content(Document("b", form_of(BALL_MODEL)), "pnml")
    world = Document("g", form_of(Grounding(GOALIE.model, GOALIE.objects)))
    assert json.loads(content(world, "json"))["objects"] == dict(GOALIE.objects)


def test_files_in_the_folder_are_listed(desk):
    save_net(SMALL, desk.files.root / "small.json")
    (desk.files.root / "sub" / ".hidden").mkdir(parents=True)
    write_pnml(SMALL, desk.files.root / "sub" / "small.pnml")
    save_net(SMALL, desk.files.root / "sub" / ".hidden" / "no.json")
    assert desk.browse() == ["small.json", "sub/small.pnml"]
