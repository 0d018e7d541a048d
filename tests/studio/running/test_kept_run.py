"""A run that was kept in a file goes on as it stood, in another start."""

import json

import pytest

from cprm_gym.agents.catalogue import shipped_net
from cprm_gym.errors import CprmError, FormatError
from cprm_gym.studio.playing.room import RunRoom
from cprm_gym.studio.running.changes import Change
from cprm_gym.studio.running.kept_run import read_run
from cprm_gym.studio.running.setup import Setup
from cprm_gym.studio.watching.session import Session


def started(path, nets=None):
    session = Session(lambda *told, **how: None)
    return session, RunRoom(session, lambda: nets or {}, dict, kept=path)


def test_the_run_of_the_last_time_stands_where_it_stood_with_what_was_changed(tmp_path):
    path = tmp_path / "state" / "run.json"
    session, room = started(path)
    with pytest.raises(CprmError, match="no run was kept"):
        room.go_on()
    session.begin(Setup("Goalie", seed=2, disturbance="blind spell"))
    session.step(3)
    session.run.change(Change(3, "ball", values=(-30.0, 5.0)))
    there = session.step(4)
    session.close()
    again, room = started(path)
    assert room.choices()["last"]["cycle"] == 7
    room.go_on()
    assert again.open()["frame"] == there
    assert again.state()["cycles"] == [0, 7]
    assert [line["cycle"] for line in again.open()["log"]] == list(range(8))


def test_a_run_with_an_edited_net_needs_it_open(tmp_path):
    path = tmp_path / "run.json"
    session, _ = started(path)
    session.begin(Setup("Goalie", seed=2, nets={"goalie": shipped_net("goalie")}))
    session.step(2)
    _, room = started(path)
    with pytest.raises(CprmError, match="an edited net that is not open: goalie"):
        room.go_on()
    _, room = started(path, {"goalie": shipped_net("goalie")})
    assert room.go_on()["changed"] == ["goalie"]


@pytest.mark.parametrize(
    "change",
    [{"format": "x"}, {"version": 2}, {"cycle": -1}, {"cycle": 1.5}, {"setup": {}}, {"changes": [{"kind": "ball"}]}, {"changes": 3}],
)
def test_a_damaged_file_is_named_and_never_in_the_way(tmp_path, change):
    path = tmp_path / "run.json"
    session, _ = started(path)
    session.begin(Setup("Goalie", seed=2))
    session.step()
    path.write_text(json.dumps({**json.loads(path.read_text()), **change}))
    with pytest.raises(FormatError, match=r"run\.json"):
        read_run(path)
    assert started(path)[1].last is None
