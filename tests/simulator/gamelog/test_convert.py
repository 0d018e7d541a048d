"""Game logs of every version, written and read back."""

import re

import numpy as np
import pytest

from cprm_gym.envs.core import SoccerCore
from cprm_gym.errors import FormatError
from cprm_gym.simulator.gamelog.convert import VERSIONS, convert
from cprm_gym.simulator.gamelog.reader import GameLogReader
from cprm_gym.simulator.gamelog.writer import GameLogWriter


@pytest.fixture(scope="module")
def game(tmp_path_factory):
    """A log of 40 cycles, version 6."""
    path = tmp_path_factory.mktemp("game") / "game.rcg"
    core = SoccerCore("Soccer11v11", 1, controlled=(), others="strong", seed=1)
    core.reset(1)
    with GameLogWriter.for_simulator(path, core.sim) as log:
        for n in range(40):
            core.step(None)
            log.record(core.sim)
            if n == 10:
                log.message("a word")
    return path


@pytest.mark.parametrize("version", VERSIONS)
def test_there_and_back(game, version, tmp_path):
    there, back = tmp_path / f"there-{version}.rcg.gz", tmp_path / "back.rcg"
    assert convert(game, there, version) == 40
    read = GameLogReader(there)
    assert read.version == {"json": -1, "record": 0, **{str(k): k for k in range(1, 7)}}[version]
    assert convert(there, back) == 40
    step = 1 / 32 if version in "12" else 1e-4
    for before, after in zip(GameLogReader(game), GameLogReader(back)):
        assert (before.time, before.mode, before.left, before.right) == (after.time, after.mode, after.left, after.right)
        np.testing.assert_allclose(after.ball[:2], before.ball[:2], atol=step + 1e-9)
        np.testing.assert_allclose(after.players["pos"], before.players["pos"], atol=step + 1e-9)
        assert np.array_equal(after.players["state"] & 0xFFFF, before.players["state"] & 0xFFFF)
        if version not in "12":
            np.testing.assert_allclose(after.players["vel"], before.players["vel"], atol=1e-4)
            np.testing.assert_allclose(after.players["stamina"], before.players["stamina"], atol=0.01)
    said = [message.text for message in GameLogReader(there).messages()]
    assert "a word" in said


@pytest.mark.parametrize("version", ["6", "record"])
def test_the_newest_text_comes_back_to_the_byte(version, game, tmp_path):
    convert(game, tmp_path / "a", version)
    convert(tmp_path / "a", tmp_path / "b", "6")
    frames = [line for line in (tmp_path / "b").read_text().splitlines() if line.startswith("(show")]
    assert frames == [line for line in game.read_text().splitlines() if line.startswith("(show")]


def test_a_game_keeps_its_date(game, tmp_path):
    """A log of version 6 converted to version 6 is the same file, whenever that is done; so it is by way of JSON."""
    old = tmp_path / "old.rcg"
    old.write_bytes(re.sub(rb"\(result \d{12} ", b"(result 201907051430 ", game.read_bytes()))
    convert(old, tmp_path / "same.rcg")
    assert (tmp_path / "same.rcg").read_bytes() == old.read_bytes()
    convert(old, tmp_path / "there.json")
    assert b'{"timestamp":"2019-07-05T14:30:00+0000"}' in (tmp_path / "there.json").read_bytes()[:200]
    convert(tmp_path / "there.json", tmp_path / "back.rcg")
    assert [message.text for message in GameLogReader(tmp_path / "back.rcg").messages()][-1].startswith("(result 201907051430 ")


def test_another_version_is_refused(game, tmp_path):
    with pytest.raises(FormatError, match=r"version '7': allowed are 1, 2, .*json"):
        convert(game, tmp_path / "x.rcg", "7")
