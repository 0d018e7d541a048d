"""Record logs: everything comes back to the bit, and damaged ones raise nothing but errors of ours."""

import numpy as np
import pytest
from drawn_frames import drawn_frame

from cprm_gym.errors import FormatError
from cprm_gym.simulator.gamelog.frames import Frame, Message, Team
from cprm_gym.simulator.gamelog.reader import GameLogReader
from cprm_gym.simulator.gamelog.records import FRAME, RecordLogWriter
from cprm_gym.simulator.gamelog.writer import frame_of
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import PlayMode


def written(path, frames):
    with RecordLogWriter(path) as log:
        for frame in frames:
            log.write(frame)
    return path


def drawn_game(count=5):
    draw, frames = np.random.default_rng(3), []
    for n in range(count):
        frame = drawn_frame(draw)
        frame.stoppage, frame.mode = n, PlayMode(3 + n % 3)
        frame.left, frame.right = Team("Ä team", n, 1, 2), Team("", n // 2)
        frame.messages = (Message(n, 1, 'a "word"\n', 2),) * (n % 3)
        frames.append(frame)
    return frames


def test_everything_comes_back_to_the_bit(tmp_path):
    frames = drawn_game()
    read = list(GameLogReader(written(tmp_path / "x.rcg", frames)))
    assert GameLogReader(tmp_path / "x.rcg").version == 0
    assert len(read) == len(frames)
    for before, after in zip(frames, read):
        assert (before.time, before.stoppage, before.mode, before.left, before.right) == (
            after.time, after.stoppage, after.mode, after.left, after.right,
        )  # fmt: skip
        assert before.messages == after.messages
        assert before.ball.tobytes() == after.ball.tobytes()
        assert before.players.tobytes() == after.players.tobytes()


def test_a_log_of_a_simulator_tells_its_cycles_unrounded_its_parameters_and_its_result(tmp_path):
    simulator, frames = Simulator(seed=4), []
    with RecordLogWriter.for_simulator(tmp_path / "x.rcg.gz", simulator) as log:
        assert not log.record(simulator), "before the kick-off nothing is logged"
        simulator.trainer.start()
        for _ in range(20):
            simulator.step()
            assert log.record(simulator)
            frames.append(frame_of(simulator.world[0], simulator.parameters))
    reader = GameLogReader(tmp_path / "x.rcg.gz")
    assert [frame.players.tobytes() for frame in reader] == [frame.players.tobytes() for frame in frames]
    assert reader.header.parameters() == simulator.parameters
    assert reader.header.types() == simulator.types
    assert [message.text[:8] for message in reader.messages()][-1] == "(result "


def test_a_log_whose_game_fails_does_not_appear(tmp_path):
    with pytest.raises(ZeroDivisionError), RecordLogWriter(tmp_path / "x.rcg"):
        _ = 1 / 0
    assert not list(tmp_path.iterdir())


def test_damaged_logs_raise_nothing_but_errors_of_ours(tmp_path):
    whole = np.frombuffer(written(tmp_path / "x.rcg", drawn_game(2)).read_bytes(), np.uint8)
    draw, refused = np.random.default_rng(5), 0
    for _ in range(300):
        data = whole.copy()
        data[draw.integers(8, len(data), int(draw.integers(1, 4)))] = draw.integers(0, 256)
        if draw.random() < 0.3:
            data = data[: draw.integers(8, len(data))]
        (tmp_path / "y.rcg").write_bytes(data.tobytes())
        try:
            list(GameLogReader(tmp_path / "y.rcg").messages())
        except FormatError as error:
            refused += "y.rcg" in str(error)
    assert refused > 50


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [("attention", 23, "attention"), ("side", 0, "out of order"), ("stamina", np.inf, "infinite"), ("pos", -np.inf, "infinite")],
)
def test_what_no_log_can_hold_is_refused(name, value, message, tmp_path):
    frame = Frame(1, ball=np.zeros(4))
    frame.players[name][3] = value
    with pytest.raises(FormatError, match=f"byte .*{message}"):
        list(GameLogReader(written(tmp_path / "x.rcg", [frame])))


def test_an_item_beyond_the_budget_is_refused_before_it_is_read(tmp_path):
    path = written(tmp_path / "x.rcg", [])
    path.write_bytes(path.read_bytes() + bytes((FRAME,)) + (1 << 30).to_bytes(4, "little"))
    with pytest.raises(FormatError, match="no item begins"):
        list(GameLogReader(path))
