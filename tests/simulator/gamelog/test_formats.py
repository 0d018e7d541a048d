"""The same five cycles in every log format, recorded by a real server, and what its fullstate said at the same time."""

import datetime
import gzip
import json
import random
import shutil

import numpy as np
import pytest
from paths import ROOT

from cprm_gym.errors import CprmError, FormatError, ParameterError
from cprm_gym.simulator.gamelog.commands import CommandLogReader, CommandLogWriter, LogLine
from cprm_gym.simulator.gamelog.frames import Frame, Message, Team, player_row
from cprm_gym.simulator.gamelog.reader import GameLogReader
from cprm_gym.simulator.gamelog.writer import GameLogWriter
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import PlayMode

FORMATS = ROOT / "tests" / "conformance" / "data" / "formats"
VERSIONS = [1, 2, 3, 4, 5, 6, -1]
STATES = json.loads((FORMATS / "states_fullprecision.json").read_text())
DATE = datetime.datetime(2026, 11, 22, 15, 20, 26)

# half a unit of the last digit that a version keeps: position, velocity, angle in degrees, stamina
ROUNDING = {
    1: (1 / 16, None, 1.0, None),
    2: (1 / 16, None, 1.0, None),
    3: (1 / 65536, 1 / 65536, 0.002, 1 / 65536),
    4: (5.1e-5, 5.1e-5, 5.1e-4, 0.051),
    5: (5.1e-5, 5.1e-5, 5.1e-4, 0.051),
    6: (5.1e-5, 5.1e-5, 5.1e-4, 0.051),
    -1: (5.1e-5, 5.1e-5, 5.1e-4, 0.051),
}


@pytest.mark.parametrize("version", VERSIONS)
def test_every_version_tells_the_recorded_states_within_its_rounding(version):
    reader = GameLogReader(FORMATS / f"v{version}.rcg")
    assert reader.version == version
    frames = list(reader)
    assert [frame.time for frame in frames] == [state["t"] for state in STATES]
    position, velocity, angle, stamina = ROUNDING[version]
    for frame, state in zip(frames, STATES):
        assert frame.mode.name == state["pm"]
        assert [frame.left.score, frame.right.score] == state["score"]
        assert (frame.left.name, frame.right.name) == ("L", "R")
        np.testing.assert_allclose(frame.ball[:2], state["ball"][:2], atol=position, rtol=0)
        if velocity is not None:
            np.testing.assert_allclose(frame.ball[2:], state["ball"][2:], atol=velocity, rtol=0)
        for key, values in state["pl"].items():
            row = frame.players[player_row(1 if key[0] == "l" else -1, int(key[1:]))]
            np.testing.assert_allclose(row["pos"], values[1:3], atol=position, rtol=0)
            assert abs(row["body"] - values[5]) <= angle
            if velocity is not None:
                assert row["type"] == values[0]
                np.testing.assert_allclose(row["vel"], values[3:5], atol=velocity, rtol=0)
                assert abs(row["neck"] - values[6]) <= angle
                assert abs(row["stamina"] - values[7]) <= stamina
                np.testing.assert_allclose([row["effort"], row["recovery"]], values[8:10], atol=2e-5, rtol=0)
            if version in (5, 6, -1):
                assert row["capacity"] == pytest.approx(values[10], abs=0.51)


@pytest.mark.parametrize("version", [3, 4, 5, 6, -1])
def test_parameters_and_types_of_the_header_are_the_servers(version):
    header = GameLogReader(FORMATS / f"v{version}.rcg").header
    parameters, types = header.parameters(), header.types()
    assert parameters.ball_decay == pytest.approx(0.94, abs=2e-5)
    assert parameters.say_msg_size == 10
    assert len(types) == 18
    assert types[5].player_decay == pytest.approx(0.35097881246360713, abs=2e-5)
    assert header.player_parameters().pt_max == 1


@pytest.mark.parametrize("version", [4, 5, 6, -1])
def test_pointing_focus_attention_view_and_counters_are_read(version):
    last = list(GameLogReader(FORMATS / f"v{version}.rcg"))[-1].players[1]
    np.testing.assert_allclose(last["point"], (13.4202, 0.6031))
    assert last["attention"] == 1
    assert (last["view_quality"], last["view_width"]) == (1, 60.0)
    assert last["counts"][9] == 1
    if version == 6:
        np.testing.assert_allclose(last["focus"], (9.9, 6.6))
    if version in (6, -1):
        assert last["counts"][11] == 3


@pytest.mark.parametrize("version", [5, 6, -1])
def test_a_log_read_and_written_again_has_the_servers_bytes(version, tmp_path):
    source, copy = FORMATS / f"v{version}.rcg", tmp_path / "copy.rcg"
    reader = GameLogReader(source)
    header = reader.header
    options = {"version": version, "date": DATE, "teams": ("L", "R")}
    with GameLogWriter(copy, header.parameters(), header.player_parameters(), header.types(), **options) as writer:
        for frame in reader:
            writer.write(frame)
    given, written = (path.read_bytes().splitlines() for path in (source, copy))
    assert len(given) == len(written)
    # the server that recorded this printed its types with 17 digits; today's server, and we, print 6
    different = [line for line, ours in zip(given, written) if line != ours and b"player_type" not in line]
    assert different == []


def test_version_6_and_json_of_one_game_hold_the_same_frames(tmp_path):
    frames = {}
    for version in (6, -1):
        path = tmp_path / f"{version}.rcg.gz"
        with GameLogWriter(path, version=version, teams=("L", "R")) as writer:
            for frame in GameLogReader(FORMATS / "v6.rcg"):
                writer.write(frame)
        assert path.read_bytes()[:2] == b"\x1f\x8b"
        frames[version] = list(GameLogReader(path))
    for text, other in zip(frames[6], frames[-1], strict=True):
        np.testing.assert_array_equal(text.ball, other.ball)
        for name in text.players.dtype.names:
            if name != "focus":
                np.testing.assert_array_equal(text.players[name], other.players[name])


def test_booleans_of_a_header_may_be_words(tmp_path):
    """As public converters write them."""
    path = tmp_path / "converted.rcg"
    data = (FORMATS / "v5.rcg").read_bytes()
    path.write_bytes(data.replace(b"(coach 1)", b"(coach true)").replace(b"(verbose 0)", b"(verbose false)"))
    assert b"true" in path.read_bytes()
    assert GameLogReader(path).header.parameters() == GameLogReader(FORMATS / "v5.rcg").header.parameters()


def test_a_writer_for_a_simulator_knows_its_teams(tmp_path):
    simulator = Simulator(1)
    simulator.team_names = ("Reds", "Blues")
    simulator.trainer.change_mode("play_on")
    with GameLogWriter.for_simulator(tmp_path / "x.rcg", simulator) as writer:
        writer.record(simulator)
    assert [(frame.left.name, frame.right.name) for frame in GameLogReader(tmp_path / "x.rcg")] == [("Reds", "Blues")]
    with GameLogWriter.for_simulator(tmp_path / "y.rcg", simulator, teams=("A", "B")) as writer:
        writer.record(simulator)
    assert next(iter(GameLogReader(tmp_path / "y.rcg"))).left.name == "A"


def test_a_json_log_may_stand_on_one_line(tmp_path):
    source, flat = FORMATS / "v-1.rcg", tmp_path / "flat.rcg"
    flat.write_bytes(source.read_bytes().replace(b"\n", b" "))
    for frame, other in zip(GameLogReader(source), GameLogReader(flat), strict=True):
        assert (frame.time, frame.mode, frame.left, frame.messages) == (other.time, other.mode, other.left, other.messages)
        for name in frame.players.dtype.names:
            np.testing.assert_array_equal(frame.players[name], other.players[name])


def test_a_log_that_cannot_be_finished_leaves_nothing(tmp_path, monkeypatch):
    def fail(*_):
        raise OSError("disk full")

    monkeypatch.setattr("os.replace", fail)
    with pytest.raises(OSError, match="disk full"), GameLogWriter(tmp_path / "game.rcg"):
        pass
    assert list(tmp_path.iterdir()) == []


def test_an_old_log_can_be_written_anew_what_it_does_not_tell_being_zero(tmp_path):
    path = tmp_path / "new.rcg"
    with GameLogWriter(path) as writer:
        for frame in GameLogReader(FORMATS / "v1.rcg"):
            writer.write(frame)
    assert b"nan" not in path.read_bytes()
    frames = list(GameLogReader(path))
    assert [frame.time for frame in frames] == [1, 2, 3, 4, 5]
    np.testing.assert_array_equal(frames[0].players["vel"], 0.0)


def test_messages_include_the_result_behind_the_last_frame():
    texts = [message.text for message in GameLogReader(FORMATS / "v6.rcg").messages()]
    assert texts[0] == "Recv L_1: (init L (version 19) (goalie))"
    assert texts[-1] == "(result 202611221520 L_0-vs-R_0)"


def test_penalties_missing_teams_and_repeated_times_survive(tmp_path):
    path = tmp_path / "game.rcg"
    with GameLogWriter(path) as writer:
        for step, mode in enumerate([PlayMode.goal_l, PlayMode.goal_l, PlayMode.penalty_taken_l]):
            frame = Frame(7 + (step == 2), step if step < 2 else 0, mode, Team("A", 2, 1, 0), Team("", 1, 0, 3))
            frame.ball = np.array([52.6, -0.0, 0, 0])
            frame.players["pos"] = 1.0
            for name in ("vel", "body", "neck", "view_width", "stamina", "effort", "recovery", "capacity"):
                frame.players[name] = 0.0
            writer.write(frame)
    assert "(team 7 A null 2 1 1 0 0 3)" in path.read_text()
    frames = list(GameLogReader(path))
    assert [(f.time, f.stoppage, f.mode.name) for f in frames] == [(7, 0, "goal_l"), (7, 1, "goal_l"), (8, 0, "penalty_taken_l")]
    assert frames[0].left == Team("A", 2, 1, 0)
    assert frames[0].right == Team("", 1, 0, 3)
    assert np.signbit(frames[0].ball[1])


def test_a_log_whose_game_fails_does_not_appear(tmp_path):
    with pytest.raises(RuntimeError), GameLogWriter(tmp_path / "game.rcg"):
        raise RuntimeError("the game broke down")
    with pytest.raises(RuntimeError), CommandLogWriter(tmp_path / "game.rcl"):
        raise RuntimeError("the game broke down")
    assert list(tmp_path.iterdir()) == []


def test_gzip_is_recognised_by_content_not_by_name(tmp_path):
    odd = tmp_path / "odd.rcg"
    odd.write_bytes(gzip.compress((FORMATS / "v5.rcg").read_bytes()))
    assert len(list(GameLogReader(odd))) == 5


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda text: text.replace(b"(show 3 ((b)", b"(show 3 ((q)"), "line 58: .*no ball"),
        (lambda text: text.replace(b"(playmode 1 play_on)", b"(playmode 1 play_off)"), "line 41: unknown play mode 'play_off'"),
        (lambda text: text.replace(b"((r 11) 0 0 33", b"((r 12) 0 0 33"), "no player 12"),
        (lambda text: text.replace(b"(team 1 L R 0 0)", b"(team 1 L R zero 0)"), "zero"),
        (lambda text: b"ULG7" + text[4:], "version b'7' is unknown"),
        (lambda text: b"hello", "not a game log"),
        (lambda text: b"", "not a game log"),
        (lambda text: text[: text.index(b"Recv R_1: (done)73") + 4], "without its closing quote"),
        (lambda text: gzip.compress(text)[:2000], "cannot be decompressed"),
    ],
)
def test_a_damaged_text_log_is_refused_with_file_and_line(damage, message, tmp_path):
    path = tmp_path / "broken.rcg"
    path.write_bytes(damage((FORMATS / "v6.rcg").read_bytes()))
    with pytest.raises(FormatError, match=message) as caught:
        list(GameLogReader(path))
    assert "broken.rcg" in str(caught.value)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_log_cut_short_is_refused(version, tmp_path):
    path = tmp_path / "cut.rcg"
    data = (FORMATS / f"v{version}.rcg").read_bytes()
    path.write_bytes(data[: len(data) // 2 + 7])
    with pytest.raises(FormatError, match="ends inside"):
        list(GameLogReader(path))


@pytest.mark.parametrize("version", [4, 5, 6])
def test_a_text_log_cut_behind_a_player_is_refused_and_what_stands_before_is_read(version, tmp_path):
    data = (FORMATS / f"v{version}.rcg").read_bytes()
    last = data.rindex(b"(show ")
    end = data.index(b"))", data.index(b"((r 3) ", last)) + 2  # what is left of the line has whole players alone
    (tmp_path / "cut.rcg").write_bytes(data[:end])
    (tmp_path / "before.rcg").write_bytes(data[:last])
    (tmp_path / "unbroken.rcg").write_bytes(data[: data.index(b"\n", last)])
    read = []
    with pytest.raises(FormatError, match="ends inside this item"):
        read.extend(GameLogReader(tmp_path / "cut.rcg"))
    assert len(read) == len(list(GameLogReader(tmp_path / "before.rcg")))
    assert len(list(GameLogReader(tmp_path / "unbroken.rcg"))) == len(list(GameLogReader(tmp_path / "before.rcg"))) + 1


@pytest.mark.parametrize("version", VERSIONS)
def test_damaged_logs_raise_nothing_but_errors_of_ours(version, tmp_path):
    draw, whole = random.Random(version), (FORMATS / f"v{version}.rcg").read_bytes()
    refused = 0
    for _ in range(60):
        data = bytearray(whole)
        for _ in range(draw.randint(1, 4)):
            at = draw.randrange(min(len(data), 4000) if draw.random() < 0.5 else len(data))
            data[at : at + draw.randint(0, 3)] = draw.choice([b"", bytes([draw.randrange(256)]), b'"', b"(", b"}", b"-", b"e9"])
        (tmp_path / "damaged.rcg").write_bytes(data)
        try:
            reader = GameLogReader(tmp_path / "damaged.rcg")
            assert all(isinstance(frame, Frame) for frame in reader)
            for read in (reader.header.parameters, reader.header.player_parameters, reader.header.types):
                read()
        except (FormatError, ParameterError):
            refused += 1
    assert refused > 10


def test_writers_refuse_what_a_log_cannot_hold(tmp_path):
    with pytest.raises(FormatError, match=r"version 4, 5, 6 \(text\) or -1"):
        GameLogWriter(tmp_path / "x.rcg", version=3)
    with pytest.raises(FormatError, match="without blanks"):
        GameLogWriter(tmp_path / "x.rcg", teams=("two words", "R"))
    with pytest.raises(CprmError, match="cannot be written"):
        GameLogWriter(tmp_path / "nowhere" / "x.rcg")
    with pytest.raises(FormatError, match="cannot be read"):
        GameLogReader(tmp_path / "missing.rcg")


def test_the_recorded_command_log_is_read_line_by_line_and_written_again(tmp_path):
    lines = list(CommandLogReader(FORMATS / "v6.rcl"))
    first = lines[0]
    assert (first.sender, first.player, first.command) == ("L_1", ("L", 1), "(init L (version 19) (goalie))")
    assert [line.referee for line in lines if line.referee] == ["play_on"]
    assert {line.sender for line in lines if line.sender and not line.player} == {"Coach"}
    copy = tmp_path / "copy.rcl"
    with CommandLogWriter(copy) as writer:
        for line in lines:
            writer.line(line)
    assert copy.read_bytes() == (FORMATS / "v6.rcl").read_bytes()


def test_a_datagram_with_line_breaks_is_one_line_of_the_command_log(tmp_path):
    path = tmp_path / "odd.rcl"
    with CommandLogWriter(path) as writer:
        writer.received(3, 0, "Left_2", "(dash\n100)")
        writer.referee(3, 1, ["goal_l_1", "goal_l"])
    cycles = dict(CommandLogReader(path).cycles())
    assert cycles[3, 0] == [LogLine(3, 0, "Recv Left_2: (dash\n100)")]
    assert [line.referee for line in cycles[3, 1]] == ["goal_l_1", "goal_l"]


def test_a_text_that_is_no_command_log_is_refused(tmp_path):
    shutil.copy(FORMATS / "v6.rcg", tmp_path / "x.rcl")
    with pytest.raises(FormatError, match="not a command log"):
        CommandLogReader(tmp_path / "x.rcl")
    (tmp_path / "y.rcl").write_text("0 hello\n")
    with pytest.raises(FormatError, match="line 1: expected TIME,STOPPAGE"):
        list(CommandLogReader(tmp_path / "y.rcl"))


def test_messages_written_by_hand_carry_the_time_of_the_last_frame(tmp_path):
    for version in (6, -1):
        path = tmp_path / f"m{version}.rcg"
        with GameLogWriter(path, version=version) as writer:
            writer.write(next(iter(GameLogReader(FORMATS / "v6.rcg"))))
            writer.message('say "hi"', board=2)
        messages = list(GameLogReader(path).messages())
        assert messages[-2] == Message(1, 2, 'say "hi"')
    with pytest.raises(FormatError, match="line break"), GameLogWriter(tmp_path / "z.rcg") as writer:
        writer.message("two\nlines")
