"""Watching, recording and asking about matches, from the command line and from a server."""

import json
import threading

import numpy as np
import pytest
from typer.testing import CliRunner

from cprm_gym.cli import app
from cprm_gym.client.monitor import MonitorConnection, read_frame
from cprm_gym.errors import CprmError, FormatError
from cprm_gym.server import Port, Server, Settings, Transport, run_in_real_time
from cprm_gym.server.command import port_words
from cprm_gym.simulator.gamelog.reader import GameLogReader
from cprm_gym.simulator.gamelog.writer import GameLogWriter
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.viewing.command import place_of, recorded
from cprm_gym.viewing.keys import Pace
from cprm_gym.viewing.pictures import brightest, world_of


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "game.rcg"
    sim = Simulator(1, seed=1)
    sim.trainer.start()
    with GameLogWriter.for_simulator(path, sim) as writer:
        for _ in range(30):
            sim.step()
            writer.record(sim)
    return path


def run(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


def test_a_log_is_watched_converted_and_counted(log, tmp_path):
    shown = run("watch", log, "--every", 10, "--speed", 64)
    assert shown.exit_code == 0
    assert "Left - Right" in shown.stdout
    assert "30 frames" in shown.stdout
    assert "wrote" in run("convert", log, tmp_path / "game.json").stdout
    assert GameLogReader(tmp_path / "game.json").version == -1
    told = json.loads(run("stats", tmp_path / "game.json", "--json").stdout)
    assert told["teams"] == ["Left", "Right"]
    assert told["parts"]["match"]["goals"] == ["0", "0"]
    table = run("stats", log, "--heat", tmp_path / "heat.png")
    assert table.exit_code == 0, table.output
    assert (tmp_path / "heat.png").read_bytes()[:4] == b"\x89PNG"


def test_who_stops_watching_is_told_how_much_he_has_seen(log, monkeypatch):
    def stopped(frames, *_):
        for _ in range(3):
            next(frames)
        raise KeyboardInterrupt

    monkeypatch.setattr("cprm_gym.viewing.command.show", stopped)
    assert run("watch", log).stdout.split("\n")[:2] == ["interrupted", "3 frames"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("watch", "udp://:1"), "udp://host:port"),
        (("watch", "udp://h:70000"), "udp://host:port"),
        (("watch", "nothing.rcg"), "nothing.rcg"),
        (("convert", "nothing.rcg", "x.rcg"), "nothing.rcg"),
        (("join", "a team"), "1 to 15 letters"),
        (("join", "A", "--port", "9", "--wait", "0.2"), "no answer from 127.0.0.1:9"),
        (("serve", "half_time=3"), "server::"),
        (("serve", "--clock", "slow"), "real, synchronous and fast"),
        (("serve", "--port", "65534"), "allowed are 1 to 65533"),
        (("serve", "--wait", "-1"), "seconds above 0"),
        (("serve", "--results", "/no/such/folder/results.csv"), "there is no folder /no/such/folder"),
        (("serve", "--port", "0", "--left", "/no/such/team"), "cannot be started"),
        (("serve", "--port", "0", "--clock", "fast", "--wait", "0.1"), "no player of the left team came within 0.1 s"),
        (("serve", "--port", "0", "--automatic", "--clock", "fast", "server::connect_wait=2", "server::game_over_wait=1"), "without it"),
        (("join", "A", "--port", "99999"), "a port is 1 to 65535"),
        (("join", "A", "--wait", "-3"), "seconds above 0"),
        (("join", "A", "--controller", "nobody"), "unknown controller"),
    ],
)
def test_mistakes_are_one_line_and_status_2(words, said):
    result = run(*words)
    assert result.exit_code == 2
    assert said in result.stderr.replace("\n", "")


def test_the_stream_of_a_server_is_recorded(tmp_path):
    server = Server(Settings.from_words(["server::simulator_step=20", "server::sense_body_step=20"]))
    with Transport(server, ports=(0, 0, 0)) as transport:
        thread = threading.Thread(target=run_in_real_time, args=(transport,))
        thread.start()
        try:
            with MonitorConnection("127.0.0.1", transport.ports[0]) as monitor:
                settings = monitor.header.parameters(), monitor.header.player_parameters(), monitor.header.types()
                assert settings[0] == server.settings.server
                assert len(settings[2]) == 18
                server.stadium.sim.trainer.start()
                with GameLogWriter(tmp_path / "live.rcg", *settings, teams=("", "")) as writer:
                    for count, frame in enumerate(recorded(monitor.frames(), writer)):
                        assert frame.players["stamina"].tolist() == [8000] * 22
                        if count == 25:
                            break
        finally:
            server.over = "told to end"
            thread.join(20)
    frames = list(GameLogReader(tmp_path / "live.rcg"))
    assert len(frames) > 10
    assert frames[-1].time > frames[0].time


def test_a_port_in_use_and_a_refused_team_are_one_line_and_status_2():
    server = Server(Settings.from_words(["server::synch_mode=false"]))
    for name, place in ((b"Left", 9), (b"Right", 7)):
        server.receive(Port.PLAYER, ("127.0.0.1", place), b"(init " + name + b")")
    with Transport(server, ports=(0, 0, 0)) as transport:
        port = transport.ports[0]
        taken = run("serve", "--port", port)
        assert taken.exit_code == 2
        assert f"port {port} of 127.0.0.1 cannot be used: Address already in use; another server" in taken.stderr
        thread = threading.Thread(target=run_in_real_time, args=(transport,))
        thread.start()
        try:
            refused = run("join", "Third", "--port", port, "--controller", "random", "--players", 1)
        finally:
            server.over = "told to end"
            thread.join(20)
    assert refused.exit_code == 2
    assert "refuses (init Third (version 19) (goalie)): no_more_team" in refused.stderr


def test_the_ports_follow_that_of_the_players():
    assert port_words(7000) == ["server::port=7000", "server::coach_port=7001", "server::olcoach_port=7002"]
    given = Settings.from_words([*port_words(7000), "server::coach_port=9000"]).server
    assert (given.port, given.coach_port, given.olcoach_port) == (7000, 9000, 7002)


def test_no_server_to_watch():
    with pytest.raises(CprmError, match=r"no answer from 127.0.0.1:9 within 0.2 s"):
        MonitorConnection("127.0.0.1", 9, 0.2)


@pytest.mark.parametrize(
    "text",
    ["(show", "(show 1 (pm 99) (tm a b 0 0) ((b) 0 0 0 0))", "(show 1 (pm 1) (tm a) ((b) 0 0 0 0))", "(show 1 (pm 1) (tm a b 0 0) ((q)))"],
)
def test_damaged_frames_are_refused(text):
    with pytest.raises(FormatError, match="a frame of a monitor cannot be read"):
        read_frame(text)


def test_a_picture_stands_as_its_frame(log):
    frame = list(GameLogReader(log))[-1]
    world = world_of(frame)[0]
    assert np.array_equal(world["pos"][1:], frame.players["pos"])
    assert int(world["time"]) == frame.time


def test_where_all_wait_leaves_nothing_else_in_the_dark():
    share = np.ones((42, 28))
    share[21, 14] = 100.0
    assert brightest(share) == 1.0
    assert brightest(np.zeros((3, 3))) == 1.0


def test_keys_pause_hasten_and_end():
    pace = Pace()
    for key in " ++-q":
        pace.press(key)
    assert (pace.paused, pace.speed, pace.ended) == (True, 2.0, True)
    assert pace.seconds == 0.05


def test_places():
    assert place_of("udp://h") == ("h", 6000)
    assert place_of("udp://10.0.0.1:7000") == ("10.0.0.1", 7000)
