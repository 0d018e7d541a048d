"""Whole lines: written and read by the kernels exactly as by the functions that they stand for."""

import numpy as np
import pytest
from drawn_frames import drawn_frame

from cprm_gym.errors import FormatError
from cprm_gym.simulator.gamelog import text, writer
from cprm_gym.simulator.gamelog.frames import PLAYER_FRAME, Frame, empty_players
from cprm_gym.simulator.gamelog.kernels import show
from cprm_gym.simulator.gamelog.reader import GameLogReader


def line_of(frame: Frame, version: int) -> str | None:
    out = np.empty(show.LONGEST_LINE, np.uint8)
    size = show.write_show(frame.time, frame.ball, frame.players, version > 5, out)
    return out[:size].tobytes().decode() if size > 0 else None


def read(line: str) -> tuple[int, np.ndarray, np.ndarray]:
    ball, rows = np.empty(4), empty_players()
    return show.read_show(np.frombuffer(line.encode(), np.uint8), ball, rows), ball, rows


@pytest.mark.parametrize("version", [5, 6])
def test_a_line_is_written_and_read_as_by_the_functions_it_stands_for(version):
    draw = np.random.default_rng(version)
    for _ in range(60):
        frame = drawn_frame(draw)
        line = line_of(frame, version)
        assert line == writer.text_show(frame, version)
        time, ball, rows = read(line.rstrip())
        slow = text._parse_show(line.rstrip())
        assert (time, ball.tobytes(), rows.tobytes()) == (slow.time, slow.ball.tobytes(), slow.players.tobytes())


def test_a_frame_with_nothing_known_and_one_with_numbers_out_of_the_ordinary():
    assert line_of(Frame(3), 6) == writer.text_show(Frame(3), 6)
    frame = Frame(3)
    frame.ball[0], frame.players["stamina"][4] = np.inf, 1e12
    assert line_of(frame, 6) is None


def test_damaged_lines_are_read_alike_or_left_alone():
    draw = np.random.default_rng(8)
    alphabet = np.frombuffer(b'0123456789 .-()lrvhfpscxe_"', np.uint8)
    whole = [line_of(drawn_frame(draw), version).rstrip() for version in (5, 6) for _ in range(10)]
    lines = [" ((".join(line.split(" ((")[:4]) + ")" for line in whole]  # ball and two players
    taken = 0
    for _ in range(4000):
        line = np.frombuffer(lines[int(draw.integers(len(lines)))].encode(), np.uint8).copy()
        for _ in range(int(draw.integers(1, 4))):
            line[draw.integers(6, len(line))] = draw.choice(alphabet)
        damaged = line[: draw.integers(6, len(line) + 1)] if draw.random() < 0.2 else line
        time, ball, rows = read(damaged.tobytes().decode())
        if time >= 0:
            taken += 1
            slow = text._parse_show(damaged.tobytes().decode())
            assert (time, ball.tobytes(), rows.tobytes()) == (slow.time, slow.ball.tobytes(), slow.players.tobytes())
    assert taken > 100


@pytest.mark.parametrize(("wrong", "message"), [("(q h", "unknown part 'q'"), ("(v h x", "cannot be read"), ("(fp (v h", "cannot be read")])
def test_a_line_that_is_not_taken_tells_what_is_wrong(wrong, message, tmp_path):
    path = tmp_path / "x.rcg"
    path.write_text("ULG6\n" + line_of(Frame(1, ball=np.zeros(4)), 6).replace("(v h", wrong, 1))
    with pytest.raises(FormatError, match=message):
        list(GameLogReader(path))


def test_rows_of_players_are_new_each_time():
    rows = empty_players()
    rows["type"] = 9
    assert rows.dtype == PLAYER_FRAME
    assert empty_players()["type"].max() == 0
