"""Whole lines of JSON logs: written and read by the kernels exactly as by the functions that they stand for."""

import json

import numpy as np
import pytest
from drawn_frames import drawn_frame

from cprm_gym.errors import FormatError
from cprm_gym.simulator.gamelog import json as json_log
from cprm_gym.simulator.gamelog import writer
from cprm_gym.simulator.gamelog.frames import Frame
from cprm_gym.simulator.gamelog.kernels import show, show_json
from cprm_gym.simulator.gamelog.reader import GameLogReader


def line_of(frame: Frame) -> str | None:
    out = np.empty(show.LONGEST_LINE, np.uint8)
    size = show_json.write_show(frame.time, frame.stoppage, frame.ball, frame.players, out)
    return out[:size].tobytes().decode() if size > 0 else None


def numbers(frame: Frame) -> tuple:
    return frame.time, frame.stoppage, frame.ball.tobytes(), frame.players.tobytes()


def slowly(line: str) -> Frame:
    """What the decoder of the standard library makes of a line."""
    item, _ = json_log._DECODER.raw_decode(line)
    assert list(item) == ["show"]
    return json_log._frame(item["show"])


def test_a_line_is_written_and_read_as_by_the_functions_it_stands_for():
    draw = np.random.default_rng(1)
    for _ in range(60):
        frame = drawn_frame(draw)
        frame.stoppage = int(draw.integers(0, 3))
        line = line_of(frame)
        assert line == writer.json_show(frame)
        for ending in ("", ",\n", "\n]"):
            read = json_log.parse_show(line + ending)
            assert (read is None) if ending == "\n]" else numbers(read) == numbers(slowly(line))


def test_a_frame_with_nothing_known_and_one_with_numbers_out_of_the_ordinary():
    assert line_of(Frame(3)) == writer.json_show(Frame(3))
    frame = Frame(3)
    frame.ball[0], frame.players["stamina"][4] = np.inf, 1e12
    assert line_of(frame) is None


def test_lines_of_servers_and_monitors_with_other_parts_are_read():
    draw = np.random.default_rng(2)
    line = line_of(drawn_frame(draw))
    shown = json.loads(line)["show"]
    for player in shown["players"][:9]:
        player |= {"fdist": 3.25, "fdir": -20}
        for name in ("kick", "change_focus"):
            player.pop(name)
    in_order = ("side", "unum", "type", "state", "x", "y", "vx", "vy", "body", "neck", "px", "py", "vq", "vw", "fdist", "fdir")
    ordered = [{name: p[name] for name in (*in_order, *p) if name in p} for p in shown["players"]]
    told = json.dumps({"show": {**shown, "players": ordered}}, separators=(",", ":"))
    assert numbers(json_log.parse_show(told)) == numbers(slowly(told))
    assert json_log.parse_show(json.dumps({"show": shown})) is None, "blanks between parts are left to the decoder"


def test_damaged_lines_are_read_alike_or_left_alone():
    draw = np.random.default_rng(8)
    alphabet = np.frombuffer(b'0123456789.-,:{}[]"lrhxe ', np.uint8)
    lines = []
    for _ in range(20):
        shown = json.loads(line_of(drawn_frame(draw)))["show"]
        shown["players"] = shown["players"][:2]
        lines.append(json.dumps({"show": shown}, separators=(",", ":")))
    taken = 0
    for _ in range(4000):
        line = np.frombuffer(lines[int(draw.integers(len(lines)))].encode(), np.uint8).copy()
        for _ in range(int(draw.integers(1, 3))):
            line[draw.integers(6, len(line))] = draw.choice(alphabet)
        damaged = line[: draw.integers(6, len(line) + 1)] if draw.random() < 0.2 else line
        frame = json_log.parse_show(damaged.tobytes().decode())
        if frame is not None:
            taken += 1
            assert numbers(frame) == numbers(slowly(damaged.tobytes().decode()))
    assert taken > 100


@pytest.mark.parametrize(("right", "wrong"), [('"unum":3', '"unum":03'), ('"state":', '"state":1.5,"x":'), ('"vq":"h"', '"vq":h')])
def test_a_line_that_is_not_taken_tells_what_is_wrong(right, wrong, tmp_path):
    frame = Frame(1, ball=np.zeros(4))
    frame.players["view_quality"] = 1
    path = tmp_path / "x.rcg"
    path.write_text("[\n" + line_of(frame).replace(right, wrong, 1) + "\n]\n")
    with pytest.raises(FormatError, match="line 2"):
        list(GameLogReader(path))


def test_a_time_that_stands_still_is_counted_where_the_line_does_not_tell_it(tmp_path):
    path = tmp_path / "x.rcg"
    path.write_text("[\n" + ",\n".join(line_of(Frame(5, ball=np.zeros(4))) for _ in range(3)) + "\n]\n")
    assert [frame.stoppage for frame in GameLogReader(path)] == [0, 1, 2]
