"""A run under watch: paused, stepped, stopped by breakpoints, asked why."""

import json
import time

import pytest

from cprm_gym.errors import CprmError, FormatError, ParameterError, UnknownName
from cprm_gym.studio.editing.files import Files
from cprm_gym.studio.editing.logs import read_log
from cprm_gym.studio.running.memory import runner_of
from cprm_gym.studio.running.setup import Setup
from cprm_gym.studio.watching.breakpoints import Breakpoint, Term, read_breakpoints, write_breakpoints
from cprm_gym.studio.watching.comparison import Comparison
from cprm_gym.studio.watching.debugger import Debugger
from cprm_gym.studio.watching.readings import Readings
from cprm_gym.studio.watching.session import Session
from cprm_gym.studio.watching.typing import Typing


class Watched:
    """A session, what belongs to it, and what it told."""

    def __init__(self, place, setup):
        self.told = []
        self.session = Session(lambda event, content, passing=False: self.told.append((event, json.loads(json.dumps(content)))), setup)
        self.debugger = Debugger(self.session, place)
        self.comparison = Comparison(self.session)
        self.session.open()

    @property
    def run(self):
        return self.session.run


@pytest.fixture
def place(tmp_path):
    return tmp_path / "beside" / "breakpoints.json"


@pytest.fixture
def watched(place):
    made = Watched(place, Setup("Goalie", seed=2))
    yield made
    made.session.close()


# ------------------------------------------------------------------ playing


def test_it_plays_until_it_is_paused_and_every_cycle_is_told(watched):
    watched.session.set_speed(1000)
    watched.session.play()
    while watched.run.cycle < 5:
        time.sleep(0.01)
    watched.session.pause()
    there = watched.run.cycle
    time.sleep(0.1)
    assert watched.run.cycle == there
    watched.session.step()
    cycles = [line["cycle"] for event, content in watched.told if event == "log" for line in content["passed"]]
    assert cycles == list(range(there + 2))
    assert watched.session.frame(2)["cycle"] == 2


def test_stepping_beyond_the_end_is_refused_and_going_back_goes_on(watched):
    end = watched.session.step(6000)
    assert end["over"]
    with pytest.raises(CprmError, match="the episode is over"):
        watched.session.play()
    assert watched.session.go(3)["cycle"] == 3
    with pytest.raises(ParameterError, match="from 0 is needed, got -1"):
        watched.session.go(-1)
    assert watched.session.open()["frame"]["cycle"] == 3
    with pytest.raises(ParameterError, match="cycle 9"):
        watched.session.frame(9)
    assert watched.session.step(6000)["cycle"] == end["cycle"]


def test_another_run_is_watched_in_its_place(watched):
    watched.session.step(3)
    watched.session.begin(Setup("KickOffShot", seed=1))
    assert watched.session.open()["run"]["task"] == "KickOffShot"
    assert watched.session.open()["frame"]["cycle"] == 0
    assert ("run", "KickOffShot") in [(event, content.get("run", {}).get("task")) for event, content in watched.told]


# ------------------------------------------------------------------ breakpoints


def test_a_run_stops_where_a_transition_fires(watched):
    watched.debugger.set_breakpoint("goalie", "fires", "leap")
    stopped = watched.session.step(100)
    assert "leap" in stopped["agents"]["left_1"]["fired"]
    assert stopped["stopped"] == ["left_1: leap fired"]
    assert stopped["hit"][0]["what"] == "leap"
    before = watched.session.frame(stopped["cycle"] - 1)
    assert "leap" not in before["agents"]["left_1"]["fired"]


def test_a_belief_stops_it_when_it_becomes_so_and_not_while_it_stays_so(watched):
    text = "P(ball.x < -45) > 0.8"
    watched.debugger.set_breakpoint("goalie", "when", text)
    runner = runner_of(watched.run.players[0])
    stopped = watched.session.step(100)
    assert Term(text).value(runner, 0) == 1
    p = sum(stopped["agents"]["left_1"]["beliefs"]["ball.x"]["p"][:17])
    assert p > 0.8
    assert watched.session.step()["cycle"] == stopped["cycle"] + 1
    assert "stopped" not in watched.session.frame(stopped["cycle"] + 1)


def test_breakpoints_lie_beside_the_net_and_hold_from_the_first_cycle_of_the_next_start(watched, place):
    watched.debugger.set_breakpoint("goalie", "fires", "leap")
    watched.debugger.set_breakpoint("goalie", "marked", "guard", on=False)
    first = watched.session.step(100)["cycle"]
    again = Watched(place, Setup("Goalie", seed=2))
    assert again.session.step(100)["cycle"] == first
    again.debugger.remove_breakpoint("goalie", "fires", "leap")
    assert [b.key for b in read_breakpoints(place)["goalie"]] == ["marked guard"]
    with pytest.raises(UnknownName, match="unknown breakpoint 'fires leap'"):
        again.debugger.remove_breakpoint("goalie", "fires", "leap")


@pytest.mark.parametrize(
    ("kind", "what", "words"),
    [
        ("fires", "lep", "unknown transition 'lep'. Did you mean 'leap'"),
        ("marked", "gard", "unknown place 'gard'"),
        ("when", "P(ball.xx < 3) > 0.5", "unknown variable 'ball.xx'"),
        ("when", "P(ball.x) > 0.5", "written as P"),
        ("when", "E(ball.x < 3)", "written as P"),
        ("when", "ball_x +", "'ball_x \\+'"),
        ("when", "nowhere > 1", "neither a percept nor a place"),
        ("when", "P(o1.facing < 1) > 0", "has the states"),
        ("sometimes", "", "unknown kind of breakpoint 'sometimes'"),
    ],
)
def test_a_breakpoint_that_can_never_be_is_refused_and_not_kept(watched, place, kind, what, words):
    with pytest.raises(CprmError, match=words):
        watched.debugger.set_breakpoint("goalie", kind, what)
    assert not place.exists()


def test_expressions_over_places_percepts_and_beliefs_are_what_they_say(watched):
    runner = runner_of(watched.run.players[0])
    inner = watched.session.step(3)["agents"]["left_1"]
    assert Term("E(ball.x)").value(runner, 0) == pytest.approx(inner["beliefs"]["ball.x"]["mean"], abs=1e-3)
    assert Term("ball_x").value(runner, 0) == pytest.approx(inner["marking"]["ball_x"], abs=1e-3)
    assert Term("body.stamina - 1").value(runner, 0) == inner["percepts"]["body.stamina"] - 1
    assert Term("P(ball.x < 60) + P(ball.x >= 60)").value(runner, 0) == pytest.approx(1)
    p = Term("P(o1.facing == 'x') > 2")
    with pytest.raises(ParameterError, match="has the states"):
        p.value(runner, 0)


@pytest.mark.parametrize(
    ("kind", "text", "error", "part"),
    [
        ("when", "P(ball.x < -45) > 0.8", "", ""),
        ("when", "P(ball.x < 3) + (", "'(' was never closed", "("),
        ("when", "E(ball.x) + P(ball.y > 1) + * 2", "invalid syntax", "* 2"),
        ("when", "ball_x + P(ball.z < 3)", "unknown variable 'ball.z'", "ball.z < 3)"),
        ("when", "P(ball.x) > 1", "written as P", "P(ball.x) > 1"),
        ("when", "1 + nowhere", "neither a percept nor a place", "nowhere"),
        ("when", "sqt(2)", "unknown function 'sqt'", "sqt(2)"),
        ("fires", "leap", "", ""),
        ("fires", "lep", "unknown transition 'lep'. Did you mean 'leap'?", "lep"),
        ("marked", "guard", "", ""),
        ("ends", "", "", ""),
    ],
)
def test_what_is_being_typed_is_checked_where_it_stands(watched, kind, text, error, part):
    told = Typing(watched.session).typed("left_1", kind, text)
    assert told["ok"] == (not error)
    assert error in told["error"]
    assert not part or text[told["at"] :].startswith(part)
    assert told["ok"] or "belief_" not in told["error"]


def test_what_might_be_typed_is_listed(watched):
    told = Typing(watched.session).typed("left_1", "when", "0")
    assert {"ball.x", "guard", "body.stamina", "cycle"} <= set(told["known"])
    assert {"E", "P", "clock", "sqrt"} <= set(told["functions"])
    assert "leap" in Typing(watched.session).typed("left_1", "fires", "")["known"]


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"format": "cprm_gym breakpoints", "version": 1, "nets": {"a": [{"kind": "no"}]}}', "\x00"]
)
def test_a_file_that_holds_no_breakpoints_is_named(tmp_path, text):
    path = tmp_path / "b.json"
    path.write_text(text)
    with pytest.raises(FormatError, match=r"b\.json"):
        read_breakpoints(path)


def test_breakpoints_are_read_as_they_were_written(tmp_path):
    nets = {"a": [Breakpoint("when", "cycle > 3"), Breakpoint("ends", on=False)]}
    write_breakpoints(tmp_path / "b.json", nets)
    assert read_breakpoints(tmp_path / "b.json") == nets


# ------------------------------------------------------------------ questions


def test_why_not_names_the_arc_that_holds_it_back_by_how_much_and_since_when(watched):
    watched.session.step(5)
    executor = runner_of(watched.run.players[0]).executor
    answer = watched.debugger.why("left_1", "hold")
    assert answer["answer"] == f"hold did not fire: {'; '.join(executor.why_not('hold'))}"
    (failing,) = [c for c in answer["conditions"] if not c["holds"]]
    assert (failing["place"], failing["low"], failing["has"], failing["by"]) == ("save.caught", 1, 0, 1)
    assert "held" not in failing
    assert answer["first"] == 0


def test_since_when_a_condition_fails_is_the_cycle_after_it_last_held(watched):
    watched.debugger.set_breakpoint("goalie", "fires", "leap")
    fired = watched.session.step(100)["cycle"]
    watched.session.step(2)
    answer = watched.debugger.why("left_1", "alarm")
    failing = [c for c in answer["conditions"] if not c["holds"]]
    held = {c["place"]: c["held"] for c in failing if "held" in c}
    assert held
    frames = [watched.session.frame(c)["agents"]["left_1"]["marking"] for c in range(fired + 3)]
    for place_name, cycle in held.items():
        (condition,) = [c for c in failing if c["place"] == place_name]
        holds = [(condition["low"] or 0) <= m.get(place_name, 0) < (condition["high"] or 99) for m in frames]
        assert holds[cycle]
        assert not any(holds[cycle + 1 :])


def test_an_earlier_cycle_is_asked_and_the_run_stays_where_it_is(watched):
    watched.session.step(2)
    early = watched.debugger.why("left_1", "leap")
    firings = watched.debugger.firings("left_1")
    watched.session.step(4)
    before = watched.session.again()
    assert watched.debugger.why("left_1", "leap", early["cycle"]) == early
    assert watched.debugger.firings("left_1", early["cycle"]) == firings
    assert watched.session.again() == before


def test_the_firings_of_a_cycle_lead_from_its_first_marking_to_its_last(watched):
    for _ in range(6):
        frame = watched.session.step()
        inner = frame["agents"]["left_1"]
        firings = watched.debugger.firings("left_1")
        assert [f["transition"] for f in firings] == inner["fired"]
        last = {}
        for firing in firings:
            for name, (was, now) in firing["tokens"].items():
                assert last.get(name, was) == was
                last[name] = now
        assert {name: inner["marking"].get(name, 0) for name in last} == last


def test_a_belief_moves_by_the_readings_that_speak_of_it(watched):
    watched.session.step(2)
    before = watched.session.again()
    answer = watched.debugger.moved("left_1", "ball.x")
    assert answer["evidence"][0]["name"] == "ball.seen_x"
    assert answer["evidence"][0]["moved"] > 0.3
    of_others = {e["name"]: e["moved"] for e in answer["evidence"]}
    assert of_others["o1.seen_y"] < 0.01
    assert answer["after"] == before["agents"]["left_1"]["beliefs"]["ball.x"]
    assert answer["before"]["spread"] > answer["after"]["spread"]
    assert watched.session.again() == before


def test_names_that_there_are_not_are_said(watched):
    for call, given in (
        (watched.debugger.why, ("left_1", "lep")),
        (watched.debugger.why, ("left_2", "leap")),
        (watched.debugger.moved, ("left_1", "x")),
    ):
        with pytest.raises(CprmError, match="unknown"):
            call(*given)


# ------------------------------------------------------------------ readings as a log


def test_the_readings_of_a_run_are_a_log_with_states_by_name(watched, tmp_path):
    readings = Readings(watched.session, Files(tmp_path))
    watched.session.step(5)
    assert readings.readings("left_1", "log.json") == {"written": "log.json", "slices": 6}
    (episode,) = read_log(tmp_path / "log.json")
    inner = watched.session.frame(5)["agents"]["left_1"]
    assert episode.steps[5].evidence == {name: value for name, value in inner["evidence"].items() if value is not None}
    assert list(episode.steps[5].relations) == inner["relations"]
    assert any(step.evidence.get("o1.seen_facing") in ("goal", "aside", "away") for step in episode.steps)
    for path, words in (("log.json", "is there already"), ("log.csv", "is written as .json"), ("../log.json", "outside the folder")):
        with pytest.raises(FormatError, match=words):
            readings.readings("left_1", path)
    with pytest.raises(CprmError, match="left_2: no cycle is kept"):
        readings.readings("left_2", "other.json")


# ------------------------------------------------------------------ side by side


def test_two_runs_are_the_same_until_something_is_changed_and_the_first_difference_is_marked(watched):
    watched.session.step(3)
    assert watched.comparison.compare()["other"]["first"] is None
    watched.debugger.change("ball", values=[-30, 10])
    frame = watched.session.step(2)
    assert frame["other"]["first"]["cycle"] == 4
    assert "the ball" in frame["other"]["first"]["what"]
    assert frame["other"]["world"]["ball"] != frame["world"]["ball"]
    back = watched.session.go(2)
    assert back["other"]["first"] is None
    assert back["other"]["world"] == back["world"]
    assert "other" not in watched.comparison.alone()


def test_what_differs_is_told_part_by_part(watched):
    watched.session.step(3)
    watched.comparison.compare()
    watched.debugger.change("blind", "left_1", cycles=20)
    frame = watched.session.step(3)
    other = frame["other"]
    mine, theirs = frame["agents"]["left_1"], other["agents"]["left_1"]
    differs = other["differs"]["agents"]["left_1"]
    assert "ball.x" in differs["beliefs"]
    for name in mine["beliefs"]:
        assert (name in differs["beliefs"]) == (mine["beliefs"][name] != theirs["beliefs"][name])
    marked = {*differs.get("marking", ()), *differs.get("quantities", ())}
    assert marked == {n for n in {**mine["marking"], **theirs["marking"]} if mine["marking"].get(n, 0) != theirs["marking"].get(n, 0)}
    tokens = watched.run.players[0].cprm.net
    assert not {p.name for p in tokens.places if type(p).__name__ == "Place"} & set(differs["quantities"])
    assert "ball_x" in differs["quantities"]
    assert other["first"]["what"] == watched.session.frame(other["first"]["cycle"])["other"]["differs"]["what"]


def test_cycles_before_the_comparison_have_the_other_run_too(watched):
    watched.session.step(6)
    watched.comparison.compare()
    for cycle in range(6):
        kept = watched.session.frame(cycle)
        assert kept["other"]["cycle"] == cycle
        assert kept["other"]["world"] == kept["world"]
        assert kept["other"]["differs"] == {}


def test_the_run_beside_is_asked_as_this_one_is(watched):
    with pytest.raises(CprmError, match="no other run is beside"):
        watched.debugger.why("left_1", "hold", beside=True)
    watched.session.step(4)
    watched.comparison.compare()
    assert watched.debugger.inside("left_1", beside=True) == watched.debugger.inside("left_1")
    assert watched.debugger.why("left_1", "hold", 2, beside=True) == watched.debugger.why("left_1", "hold", 2)
    assert watched.debugger.firings("left_1", beside=True) == watched.debugger.firings("left_1")
    assert watched.debugger.moved("left_1", "ball.x", beside=True) == watched.debugger.moved("left_1", "ball.x")
    watched.comparison.compare("fsm")
    assert watched.debugger.inside("left_1", beside=True) == {"net": None, "kind": "fsm"}


def test_another_controller_plays_beside(watched):
    watched.session.step(4)
    frame = watched.comparison.compare("fsm")
    assert frame["other"]["setup"]["controller"] == "fsm"
    assert frame["other"]["cycle"] == 4
