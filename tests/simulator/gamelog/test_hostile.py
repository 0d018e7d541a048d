"""Logs and recordings of strangers: whatever stands in them, the error is ours, says where, and costs neither time nor memory."""

import gzip
import json
import time
import tracemalloc
import zlib
from pathlib import Path

import pytest

from cprm_gym.errors import FormatError
from cprm_gym.simulator.conformance.recording import read_recording
from cprm_gym.simulator.gamelog.commands import CommandLogReader
from cprm_gym.simulator.gamelog.reader import GameLogReader
from cprm_gym.simulator.gamelog.streams import LONGEST_ITEM

BALL = {"x": 0.0, "y": 0.0, "vx": 0.0, "vy": 0.0}
PLAYER = {
    "side": "l", "unum": 1, "type": 0, "state": 1, "x": 0.0, "y": 0.0, "vx": 0.0, "vy": 0.0, "body": 0.0, "neck": 0.0, "vq": "h", "vw": 90,
}  # fmt: skip
TEAM = {"name": "L", "score": 0}
SHOW = "(show 1 ((b) 0 0 0 0) ((l 1) 0 0x1 0 0 0 0 0 0 (v h 90) (fp 0 0) (s 8000 1 1 100) (c 0 0 0 0 0 0 0 0 0 0 0 0)))\n"


def frames(path: Path) -> list[object]:
    return list(GameLogReader(path))


def json_log(path: Path, *items: str) -> Path:
    path.write_text("[\n" + ",\n".join(('{"server_param":{}}', *items)) + "\n]\n")
    return path


def show(player: dict[str, object] | None = None, **content: object) -> str:
    return json.dumps({"show": {"time": 1, "ball": BALL, "players": [{**PLAYER, **(player or {})}], **content}})


@pytest.mark.parametrize(
    "item",
    [
        show().replace('"time": 1', '"time": 1e999'),
        show().replace('"time": 1', '"time": NaN'),
        show().replace('"time": 1', '"time": ' + "9" * 5000),
        show(time=2**40),
        show(time=None),
        show({"type": 10**6}),
        show({"type": -(10**30)}),
        show({"state": 2**40}),
        show({"state": -1}),
        show({"kick": 2**40}),
        show({"kick": "many"}),
        show({"unum": 1.5}),
        show({"unum": True}),
        show({"unum": 12}),
        show({"side": ["l"]}),
        show({"x": "0"}),
        show({"fside": "l"}),
        show(players=None),
        show(players=[[]]),
        show(ball=[]),
        json.dumps({"team": None}),
        json.dumps({"team": {"l": None, "r": TEAM}}),
        json.dumps({"team": {"l": {"name": 5, "score": 0}, "r": TEAM}}),
        json.dumps({"team": {"l": {"name": "L", "score": 1e300}, "r": TEAM}}),
        json.dumps({"msg": {"time": 1, "board": 1, "message": None}}),
        json.dumps({"msg": 5}),
        json.dumps({"playmode": {"mode": ["play_on"]}}),
        json.dumps({"server_param": []}),
        '{"show": ' + "[" * 100_000,
        '{"show": ' + '{"a":' * 100_000,
        '{"unknown": 1}',
    ],
)
def test_a_hostile_json_log_is_a_format_error_with_its_line(item, tmp_path):
    path = json_log(tmp_path / "x.rcg", item)
    with pytest.raises(FormatError, match=r"x\.rcg, line [34]: "):
        frames(path)


@pytest.mark.parametrize(
    ("was", "now", "message"),
    [
        ("(b) 0 0 0 0", "(b) 0 nan 0 0", "a number of the ball is not finite"),
        ("(b) 0 0 0 0", "(b) 1e999 0 0 0", "a number of the ball is not finite"),
        ("0x1 0 0", "0x1 0 -inf", "a number of player l 1 is not finite"),
    ],
)
def test_a_place_in_a_text_log_that_is_no_number_is_refused(was, now, message, tmp_path):
    path = tmp_path / "x.rcg"
    path.write_text("ULG6\n" + SHOW.replace(was, now))
    with pytest.raises(FormatError, match=message):
        frames(path)


def test_a_json_log_that_is_right_is_read(tmp_path):
    assert len(frames(json_log(tmp_path / "x.rcg", show(), show({"kick": 3})))) == 2


@pytest.mark.parametrize("damage", [lambda data: data[:40], lambda data: data[:30] + b"\xff" * 10 + data[40:], lambda data: data[:12]])
@pytest.mark.parametrize("reader", [lambda path: list(CommandLogReader(path)), frames, read_recording], ids=["rcl", "rcg", "jsonl"])
def test_broken_gzip_is_a_format_error(reader, damage, tmp_path):
    path = tmp_path / "x.gz"
    path.write_bytes(damage(gzip.compress(b"0,0\tRecv L_1: (dash 100)\n" * 200)))
    with pytest.raises(FormatError, match="cannot be decompressed"):
        reader(path)
    with pytest.raises((OSError, EOFError, zlib.error)), gzip.open(path) as stream:  # what the reader makes of it
        stream.read()


def seconds(path: Path, text: str, reader) -> float:
    path.write_text(text)
    start = time.process_time()
    with pytest.raises(FormatError):
        list(reader(path))
    return time.process_time() - start


@pytest.mark.parametrize(
    ("begin", "line", "reader"),
    [
        ('ULG6\n(msg 0 1 "', SHOW, GameLogReader),
        ('[\n{"msg": {"time": 0, "board": 1, "message": "', SHOW, GameLogReader),
        ("[\n" + '{"show":' * 3, "[1, 2, 3],\n" * 5, GameLogReader),
        ("x\n", SHOW, CommandLogReader),
    ],
    ids=["text message", "json string", "json object", "datagram"],
)
def test_what_is_not_closed_is_read_in_linear_time(begin, line, reader, tmp_path):
    times = {}
    for lines in (1000, 4000):
        times[lines] = min(seconds(tmp_path / f"{lines}", begin + line * lines, reader) for _ in range(2))
    assert times[4000] < 0.05 or times[4000] < 8 * times[1000]


@pytest.mark.parametrize(
    ("name", "content", "reader"),
    [
        ("line.rcg", b"ULG6\n" + b"x" * 40_000_000, frames),
        ("messages.rcg", b"ULG6\n" + b'(msg 0 1 "' + b"a" * 1000 + b'")\n', frames),
        ("one_message.rcg", b'ULG6\n(msg 0 1 "' + b"a\n" * 20_000_000, frames),
        ("string.rcg", b'[\n{"msg": {"message": "' + b"a" * 40_000_000, frames),
        ("types.rcg", b"ULG6\n" + b"(player_type (id 0))\n" * 1_000_000, frames),
        ("line.rcl", b"0,0\t" + b"x" * 40_000_000, lambda path: list(CommandLogReader(path))),
        ("datagram.rcl", b"0,0\tx\n" + b"x\n" * 20_000_000, lambda path: list(CommandLogReader(path))),
        ("rows.jsonl", b'{"rec": "header"}\n' + b'{"rec": "row"}\n' * 2_000_000, read_recording),
    ],
)
def test_a_few_kilobytes_of_gzip_do_not_become_gigabytes(name, content, reader, tmp_path):
    if name == "messages.rcg":
        content = content[:5] + content[5:] * 40_000
    path = tmp_path / name
    path.write_bytes(gzip.compress(content, 6))
    assert path.stat().st_size < 200_000
    del content
    tracemalloc.start()
    with pytest.raises(FormatError, match=r"more than|longer than|most|header has no"):
        reader(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 60_000_000


def test_a_message_may_be_as_long_as_the_budget_and_no_longer(tmp_path):
    path = tmp_path / "x.rcg"
    path.write_text('ULG6\n(msg 0 1 "' + "a\n" * (LONGEST_ITEM // 2 - 100) + '")\n' + SHOW)
    assert len(GameLogReader(path).__iter__().__next__().messages[0].text) == 2 * (LONGEST_ITEM // 2 - 100)
    path.write_text('ULG6\n(msg 0 1 "' + "a\n" * (LONGEST_ITEM // 2 + 100) + '")\n' + SHOW)
    with pytest.raises(FormatError, match="a message of more than 1048576 bytes"):
        frames(path)


@pytest.mark.parametrize(("what", "said"), [("show 1 ", "show 1_0 "), ("(b) 0", "(b) 1_0"), ("8000", "8_000"), ("(b) 0", "(b) \u0661")])
def test_numbers_that_only_python_knows_are_refused(tmp_path, what, said):
    (tmp_path / "a.rcg").write_text("ULG6\n" + SHOW.replace(what, said), encoding="utf-8")
    with pytest.raises(FormatError, match="line 2"):
        frames(tmp_path / "a.rcg")


def test_parameters_of_a_log_are_no_numbers_that_only_python_knows(tmp_path):
    (tmp_path / "a.rcg").write_text("ULG6\n(server_param (goal_width 1_4))\n" + SHOW)
    with pytest.raises(FormatError, match="line 2"):
        frames(tmp_path / "a.rcg")
