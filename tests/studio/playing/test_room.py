"""What is played is chosen, many episodes are played, results and logs are opened, analyses are played."""

import json
from dataclasses import replace

import pytest

from cprm_gym.agents.catalogue import shipped_net
from cprm_gym.agents.goalie import goalie_cprm
from cprm_gym.architecture.prm import Noise
from cprm_gym.benchmark.plan import Plan
from cprm_gym.benchmark.runner import run as play_plan
from cprm_gym.errors import CprmError, FormatError, ParameterError
from cprm_gym.studio.playing.episodes import play_episodes
from cprm_gym.studio.playing.results import Results
from cprm_gym.studio.playing.room import RunRoom
from cprm_gym.studio.playing.witnesses import analysis
from cprm_gym.studio.running.recording import Recording
from cprm_gym.studio.running.setup import Setup
from cprm_gym.studio.watching.session import Session


@pytest.fixture
def session():
    told = []
    made = Session(lambda event, content, passing=False: told.append((event, json.loads(json.dumps(content)))))
    made.told = told
    yield made
    made.close()


def room_of(session, nets=None, results=None, models=None):
    return RunRoom(session, lambda: nets or {}, lambda: models or {}, results)


def ended(room):
    room._thread.join(120)
    return room.played()


def test_an_episode_is_watched_as_it_was_chosen(session):
    room = room_of(session)
    assert room.watch("Goalie", seed=3, world=2, disturbance="blind spell")["world"] == 2
    assert session.open()["run"]["disturbance"] == "blind spell"
    assert room.choices()["setup"]["seed"] == 3
    assert room.choices()["disturbances"]["blind spell"].startswith("Nobody sees anything for 20 cycles")


def test_the_opened_net_plays_instead_of_the_one_that_ships(session):
    net = shipped_net("goalie")
    lazy = replace(net, transitions=tuple(t for t in net.transitions if t.name not in ("leap", "alarm")))
    room = room_of(session, {"goalie": lazy})
    about = room.watch("Goalie", seed=2, nets=["goalie"])
    assert about["changed"] == ["goalie"]
    end = session.step(2000)
    assert end["over"]
    fired = {name for cycle in range(end["cycle"]) for name in session.frame(cycle)["agents"]["left_1"]["fired"]}
    assert "leap" not in fired
    with pytest.raises(CprmError, match="unknown opened net 'golie'"):
        room.watch("Goalie", nets=["golie"])


def test_the_edited_model_infers_instead_of_the_one_that_ships(session):
    model = goalie_cprm(2).model
    dim = replace(model, classes=tuple(badly_seen(c) if c.name == "Ball" else c for c in model.classes))
    about = room_of(session, models={model.name: dim}).watch("Goalie", seed=2, models=[model.name])
    assert about["models"] == [model.name]
    edited = session.step(3)["agents"]["left_1"]["beliefs"]["ball.x"]
    session.begin(Setup("Goalie", seed=2))
    shipped = session.step(3)["agents"]["left_1"]["beliefs"]["ball.x"]
    assert edited["spread"] > 2 * shipped["spread"]
    with pytest.raises(ParameterError, match="nobody in KickOffShot plays with a model called"):
        room_of(session, models={model.name: dim}).watch("KickOffShot", models=[model.name])


def badly_seen(kind):
    """The class of the ball, whose place is seen worse by far."""
    attributes = tuple(replace(a, cpd=Noise("x", sd=9.0)) if a.name == "seen_x" else a for a in kind.attributes)
    return replace(kind, attributes=attributes)


def test_a_net_that_goes_on_without_end_stops_the_run_where_it_can_be_asked(session):
    net = shipped_net("goalie")
    endless = replace(net, transitions=tuple(t for t in net.transitions if t.name != "leap"))
    room_of(session, {"goalie": endless}).watch("Goalie", seed=2, nets=["goalie"])
    there = session.step(2000)
    assert (there["status"], there["over"]) == ("TROUBLE", True)
    assert "without becoming quiet" in there["trouble"]
    assert len(there["agents"]["left_1"]["fired"]) == 300
    with pytest.raises(CprmError, match="without becoming quiet"):
        session.step()
    assert session.go(0)["trouble"] == ""


def test_many_episodes_are_told_as_they_end_and_failures_can_be_watched(session):
    room = room_of(session)
    room.episodes("Goalie", 24, seed=2)
    played = ended(room)
    assert [e["world"] for e in played["episodes"]] == list(range(24))
    assert played["low"] < played["success"] / 24 < played["high"]
    told = [content for event, content in session.told if event == "episodes"]
    assert [len(content["episodes"]) for content in told] == [0, 20, 24, 24]
    assert not told[-1]["going"]
    failure = next(e for e in played["episodes"] if not e["success"])
    room.watch("Goalie", seed=2, world=failure["world"])
    end = session.step(2000)
    assert (end["success"], end["cycle"], end["status"]) == (False, failure["cycles"], failure["status"])


def test_episodes_are_stopped_and_a_wrong_number_is_refused(session):
    room = room_of(session)
    with pytest.raises(ParameterError, match="episodes: 1 to"):
        play_episodes(Setup("Goalie"), 0)
    with pytest.raises(ParameterError, match="episodes: 1 to"):
        room.episodes("Goalie", -3)
    assert not room.played()["going"]
    room.episodes("Goalie", 5000, seed=2)
    with pytest.raises(CprmError, match="being played"):
        room.episodes("Goalie", 5)
    room.stop()
    room.close()
    assert len(room.played()["episodes"]) < 5000
    assert not room.played()["going"]


def test_the_episode_behind_a_number_of_a_benchmark_is_played_again(session, tmp_path):
    plan = Plan(tasks=("Goalie",), controllers=("cprm", "fsm"), episodes=4, seed=5)
    plan.write(tmp_path)
    list(play_plan(plan, workers=1, journal=tmp_path / "episodes.jsonl"))
    room = room_of(session, results=Results(tmp_path))
    table = room.table()
    assert [(row["task"], row["controller"], len(row["episodes"])) for row in table["rows"]] == [
        ("Goalie", "cprm", 4),
        ("Goalie", "fsm", 4),
    ]
    for row in table["rows"]:
        for episode in row["episodes"][:2]:
            about = room.replay("Goalie", row["controller"], episode["world"])
            assert (about["controller"], about["seed"], about["world"]) == (row["controller"], 5, episode["world"])
            end = session.step(2000)
            assert (end["success"], end["cycle"]) == (episode["success"], episode["cycles"])
    with pytest.raises(CprmError, match="no episode 9"):
        room.replay("Goalie", "cprm", 9)


def test_what_is_no_folder_of_results_is_named(session, tmp_path):
    with pytest.raises(CprmError, match=r"there is no plan\.json"):
        Results(tmp_path)
    with pytest.raises(CprmError, match="no results are open"):
        room_of(session).table()


def test_a_log_is_looked_at_from_any_frame(session, tmp_path):
    from cprm_gym.envs.play import Film, play
    from cprm_gym.envs.tasks import make_task

    path = tmp_path / "match.rcg"
    course = play(make_task("Goalie"), None, None, 1, 12)
    core, _ = next(course)
    with Film(path, core) as film:
        film.add()
        for _ in course:
            film.add()
    recording = Recording(path)
    session.look_at(recording)
    opened = session.open()
    assert opened["run"]["recorded"] == str(path)
    assert opened["state"]["cycles"] == [0, len(recording) - 1]
    ball = [session.frame(k)["world"]["ball"][:2] for k in range(len(recording))]
    assert len(set(map(tuple, ball))) > 3
    assert session.go(4)["cycle"] == 4
    assert session.step()["world"]["ball"][:2] == ball[5]
    with pytest.raises(CprmError, match="can only be looked at"):
        session.show(["left_1"])
    (tmp_path / "none.rcg").write_text("nothing")
    with pytest.raises(FormatError, match=r"none\.rcg"):
        Recording(tmp_path / "none.rcg")


def test_a_run_that_shows_an_answer_leads_where_it_says():
    found = analysis(shipped_net("approach"))
    (unsafe,) = [v for v in found["verdicts"] if v["name"] == "one safe"]
    assert unsafe["holds"] is False
    assert unsafe["run"][-1]["marking"]["orient.turns"] == 2
    assert json.loads(json.dumps(found)) == found
    kept = {v["name"]: v["holds"] for v in found["verdicts"] if v["part"] == "contract"}
    assert kept
    assert all(kept.values())
