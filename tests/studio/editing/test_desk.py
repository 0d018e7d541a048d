"""The desk: drawings that stay as they were put, checks that point at the place, the token game, expressions while they are typed."""

import json
import threading

import pytest

from cprm_gym.agents.skills.orient import ORIENT
from cprm_gym.architecture.petri import Executor, Math, ObjectPlace, PetriNet, Place, Transition
from cprm_gym.errors import CprmError, NotEnabled, ParameterError, UnknownName
from cprm_gym.studio.editing.checks import check_net
from cprm_gym.studio.editing.desk import Desk
from cprm_gym.studio.editing.document import form_of
from cprm_gym.studio.editing.expressions import check_expression
from cprm_gym.studio.editing.token_game import Games, TokenGame


class Heard:
    """Events that were published."""

    def __init__(self):
        self.events = []
        self.checked = threading.Condition()

    def __call__(self, event, content, passing=False):
        with self.checked:
            self.events.append((event, json.loads(json.dumps(content))))
            self.checked.notify_all()

    def wait(self, fits):
        with self.checked:
            assert self.checked.wait_for(lambda: any(fits(e) for e in self.events), 60)
            return next(e for e in reversed(self.events) if fits(e))


@pytest.fixture
def heard():
    return Heard()


@pytest.fixture
def desk(tmp_path, heard):
    made = Desk(heard, tmp_path, tmp_path / "drafts", seconds=5)
    yield made
    made.close()


def test_everything_a_page_gets_is_what_json_can_say(desk):
    key = desk.ship("approach")["id"]
    calls = desk.calls()
    for name, given in (
        ("list", {}),
        ("shipped", {}),
        ("browse", {}),
        ("read", {"id": key}),
        ("view", {"id": key, "definition": "approach"}),
        ("export", {"id": key, "form": "python"}),
    ):
        answer = calls[name](**given)
        assert json.loads(json.dumps(answer, allow_nan=False)) == answer, name


def test_putting_one_part_by_hand_leaves_the_others_where_they_are(desk):
    key = desk.ship("orient")["id"]
    before = {n["key"]: (n["x"], n["y"]) for n in desk.view(key, "orient")["nodes"]}
    desk.apply(key, {"op": "move", "in": "orient", "at": {"begin": [500, 600]}})
    after = {n["key"]: (n["x"], n["y"]) for n in desk.view(key, "orient")["nodes"]}
    assert after["begin"] == (500, 600)
    assert {k: v for k, v in after.items() if k != "begin"} == {k: v for k, v in before.items() if k != "begin"}
    desk.apply(key, {"op": "add_place", "in": "orient", "place": {"kind": "place", "name": "new"}, "at": [1, 2]})
    again = {n["key"]: (n["x"], n["y"]) for n in desk.view(key, "orient")["nodes"]}
    assert again == after | {"new": (1, 2)}
    desk.apply(key, {"op": "arrange", "in": "orient"})
    assert "layout" not in desk.read(key)["data"]


def test_putting_a_part_by_hand_while_quantities_are_hidden_leaves_what_is_seen(desk):
    def seen():
        return {n["key"]: (n["x"], n["y"]) for n in desk.view(key, "orient", quantities=False)["nodes"]}

    key = desk.ship("orient")["id"]
    before = seen()
    assert "off_axis" not in before
    desk.apply(key, {"op": "move", "in": "orient", "at": {"begin": [500, 600]}}, quantities=False)
    assert seen() == before | {"begin": (500, 600)}
    whole = {n["key"]: (n["x"], n["y"]) for n in desk.view(key, "orient")["nodes"]}
    others = [whole[k][0] for k in whole if k not in before]
    assert min(others) > max(x for k, (x, _) in before.items())


def test_a_refused_operation_by_hand_leaves_no_positions(desk):
    key = desk.ship("orient")["id"]
    with pytest.raises(CprmError):
        desk.apply(key, {"op": "add_place", "in": "orient", "place": {"kind": "place", "name": "begin"}, "at": [1, 2]})
    assert "layout" not in desk.read(key)["data"]


def test_a_page_that_is_behind_changes_nothing(desk):
    key = desk.ship("orient")["id"]
    desk.apply(key, {"op": "define", "name": "x"}, revision=0)
    with pytest.raises(ParameterError, match="another page"):
        desk.apply(key, {"op": "define", "name": "y"}, revision=0)
    assert "y" not in desk.read(key)["data"]["definitions"]


def test_a_broken_contract_is_reported_with_the_place(desk, heard):
    key = desk.ship("orient")["id"]
    _, first = heard.wait(lambda e: e[0] == "edit.checked")
    assert [f for f in first["findings"] if f["kind"] == "contract" and f["holds"] is False] == []
    start = next(t.name for t in ORIENT.transitions if "begin" in t.inputs)
    desk.apply(key, {"op": "disconnect", "in": "orient", "place": ORIENT.ports.ongoing, "transition": start, "arc": "output"})
    revision = desk.read(key)["revision"]
    _, second = heard.wait(lambda e: e[0] == "edit.checked" and e[1]["revision"] == revision)
    broken = [f for f in second["findings"] if f["kind"] == "contract" and f["holds"] is False]
    assert "start" in [f["title"] for f in broken]
    assert all(f["names"] for f in broken)
    assert any(ORIENT.ports.ongoing in f["names"] for f in broken)
    assert any(f["run"] for f in broken)


def test_a_module_that_is_used_wrongly_is_reported_with_the_instance():
    net = PetriNet("out", (Place("p", tokens=1),), (Transition("go", ("p",), ("o.begin",)),), modules={"o": ORIENT})
    wrong = [f for f in check_net(net, 5) if f["kind"] == "composition" and f["holds"] is False]
    assert wrong
    assert all(f["names"][0] == "o" for f in wrong)


def test_structure_names_what_no_arc_touches_and_what_never_fires():
    net = PetriNet("s", (Place("a", tokens=1), Place("b"), Place("lonely")),
                   (Transition("t", ("a",), ("b",)), Transition("never", ("b", "a"), ("a",))))  # fmt: skip
    found = {f["title"]: f for f in check_net(net, 5)}
    assert found["unused"]["names"] == ["lonely"]
    assert found["dead"]["names"] == ["never"]


def test_a_livelock_is_found_and_shown_by_a_run():
    net = PetriNet("loop", (Place("a", tokens=1), Place("b")), (Transition("t", ("a",), ("b",)), Transition("u", ("b",), ("a",))))
    quiet = next(f for f in check_net(net, 5) if f["title"] == "becomes quiet")
    assert quiet["holds"] is False
    assert quiet["run"]


EXPRESSIONS = [
    ("mate.near + limit", "", ""),
    ("clip(limit, 0, 1) if turn.ongoing else 2", "", ""),
    ("limit +", "not an expression", 7),
    ("limit + lmit", "Did you mean 'limit'", 8),
    ("limit + mate.near.far", "one part", 8),
    ("__import__('os')", "", 0),
    ("sqrt(1, 2)", "sqrt", 0),
    ("turn.bearing", "unknown place", 0),
]


@pytest.mark.parametrize(("text", "words", "at"), EXPRESSIONS)
def test_an_expression_is_checked_while_it_is_typed(text, words, at):
    net = PetriNet("n", (Place("limit"), ObjectPlace("mate", "Mate"), Math("m", "limit")), modules={"turn": ORIENT})
    answer = check_expression(form_of(net), "n", text)
    if at == "":
        assert answer["ok"], answer
        assert "limit" in answer["names"]
    else:
        assert not answer["ok"]
        assert words in answer["error"]
        assert answer["at"] == at


def test_an_expression_in_a_definition_that_is_not_there_is_refused():
    with pytest.raises(UnknownName):
        check_expression(form_of(ORIENT), "nowhere", "1")


DELAYED = PetriNet(
    "two", (Place("a", tokens=2), Place("b", capacity=1)), (Transition("go", ("a",), ("b",), delay=2), Transition("out", ("b",), ()))
)


def test_the_token_game_fires_what_is_enabled_and_takes_moves_back():
    game = TokenGame(DELAYED)
    start = game.state()
    assert start["enabled"] == ["go"]
    state = game.fire("go")
    assert (state["marking"], state["fired"], state["enabled"]) == ({"a": 1, "b": 1}, ["go"], ["out"])
    with pytest.raises(NotEnabled, match="b"):
        game.fire("go")
    assert game.why_not("go")
    game.fire("out")
    assert game.back()["marking"] == {"a": 1, "b": 1}
    assert game.back()["marking"] == start["marking"]
    assert game.back()["marking"] == start["marking"], "there is nothing more to take back"


def test_the_token_game_runs_cycles_as_the_executor_does():
    game, executor = TokenGame(DELAYED), Executor(DELAYED)
    for _ in range(6):
        state = game.cycle()
        executor.step()
        assert list(state["marking"].values()) == executor.marking[0].tolist()
    assert game.reset()["marking"] == {"a": 2, "b": 0}
    assert game.cycle(3)["fired"] == ["go", "out"]
    assert 0 < game.cycle(1)["clocks"].get("go", 0.5) < 1


def test_tokens_are_put_by_hand_within_the_capacity():
    game = TokenGame(DELAYED)
    assert game.write("a", 5)["marking"]["a"] == 5
    with pytest.raises(CprmError, match="0 to 1 tokens"):
        game.write("b", 2)
    assert game.back()["marking"]["a"] == 2


def test_a_cycle_that_fails_leaves_the_game_as_it_was():
    loop = PetriNet("loop", (Place("a", tokens=1), Place("b")), (Transition("t", ("a",), ("b",)), Transition("u", ("b",), ("a",))))
    game = TokenGame(loop)
    with pytest.raises(CprmError):
        game.cycle()
    assert game.state()["marking"] == {"a": 1, "b": 0}


def test_the_game_does_not_touch_the_document(desk):
    key = desk.ship("orient")["id"]
    games = Games(lambda id, definition: desk.document(id).definition(definition))
    before = desk.read(key)["data"]
    calls = games.calls()
    state = calls["begin"](key, "orient")
    assert json.loads(json.dumps(state, allow_nan=False)) == state
    assert calls["write"](key, "begin", 1)["marking"]["begin"] == 1
    calls["cycle"](key)
    assert calls["why"](key, ORIENT.transitions[0].name)["why"]
    calls["end"](key)
    assert desk.read(key)["data"] == before
    with pytest.raises(ParameterError, match="no token game"):
        calls["fire"](key, "x")


def test_closing_a_document_forgets_it(desk):
    key = desk.ship("orient")["id"]
    desk.close_document(key)
    assert desk.list()["open"] == []
    with pytest.raises(UnknownName):
        desk.read(key)


def test_edited_nets_are_given_to_whoever_plays_them(desk):
    key = desk.ship("orient")["id"]
    desk.apply(key, {"op": "rename", "in": "orient", "name": ORIENT.transitions[0].name, "to": "first"})
    assert desk.nets()["orient"].transition("first")
