"""Whole matches replayed from their logs: of the real server, and of the simulator itself."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from paths import SHARED

from cprm_gym.errors import CommandError, FormatError
from cprm_gym.simulator.conformance import run
from cprm_gym.simulator.conformance.match import replay_match
from cprm_gym.simulator.gamelog.reader import GameLogReader
from cprm_gym.simulator.gamelog.replay import Recorder, replay
from cprm_gym.simulator.gamelog.writer import GameLogWriter
from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.player_types import PlayerParameters
from cprm_gym.simulator.protocol.commands import PlayerCommand, command_record
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import PlayMode

MATCHES = SHARED / "matches"
REAL = {"noise": "HELIOS_L_2-vs-HELIOS_R_3.rcg.gz", "no noise": "nonoise-HELIOS_L_5-vs-HELIOS_R_5.rcg.gz"}
needs_shared = pytest.mark.skipif(not MATCHES.exists(), reason="data of ../shared absent")


def play(path: Path, cycles: int, noise: bool, version: int = 6) -> Simulator:
    """Record a game in which everybody runs to the ball and kicks it about."""
    parameters = ServerParameters() if noise else ServerParameters().without_noise()
    types = PlayerParameters() if noise else PlayerParameters(kick_rand_delta_factor=0.0)
    simulator = Simulator(1, parameters, types, seed=3)
    simulator.team_names = ("Reds", "Blues")
    draw = np.random.default_rng(5)
    world = simulator.world[0]
    for row in range(22):
        place = PlayerCommand("move", (-3.0 - 4.0 * (row % 11), -30.0 + 5.5 * (row % 11)))
        simulator.command_phase(0, row + 1, command_record(place))
    simulator.advance()
    simulator.trainer.start()
    with Recorder(path, simulator, version=version) as recorder:
        for _ in range(cycles):
            commands = simulator.commands
            simulator.clear_commands()
            for row in range(22):
                dx, dy = world["pos"][0] - world["pos"][row + 1]
                angle = np.degrees((np.arctan2(dy, dx) - world["body"][row] + np.pi) % (2 * np.pi) - np.pi)
                if np.hypot(dx, dy) < 0.9:
                    action = PlayerCommand("kick", (float(draw.uniform(5, 100)), float(draw.uniform(-180, 180))))
                elif draw.random() < 0.03:
                    action = PlayerCommand("tackle", (float(draw.uniform(-180, 180)), False))
                elif row in (0, 11) and draw.random() < 0.5:
                    action = PlayerCommand("catch", (0.0,))
                elif abs(angle) > 20:
                    action = PlayerCommand("turn", (float(angle),))
                else:
                    action = PlayerCommand("dash", (float(draw.uniform(30, 100)), float(angle)))
                record = command_record(action)
                assert record is not None
                record["turn_neck"] = draw.uniform(-90, 90)
                commands[0, row] = record[0]
            recorder.step()
    return simulator


@pytest.mark.parametrize(("noise", "version", "ending"), [(True, 6, ".rcg.gz"), (False, 6, ".rcg"), (False, -1, ".rcg")])
def test_a_recorded_game_of_the_simulator_replays_completely(noise, version, ending, tmp_path):
    path = tmp_path / f"game{ending}"
    simulator = play(path, 200, noise, version)
    result = replay_match(path)
    assert result.ok, result.text()
    assert result.cycles > 190
    assert [check.value for check in result.checks] == [1.0, 1.0], result.text()
    frames = list(GameLogReader(path))
    assert len({frame.mode for frame in frames}) >= 2
    assert frames[-1].time == simulator.world["time"][0]
    np.testing.assert_allclose(frames[-1].players["pos"], simulator.world["pos"][0, 1:], atol=5.1e-5)


def test_commands_of_a_trainer_are_replayed():
    """The server's own log of a trainer who sets the mode, places everybody and changes a type."""
    result = replay_match(Path(__file__).parent / "data" / "formats" / "v6.rcg")
    assert result.ok, result.text()
    assert result.mismatches == []
    assert result.cycles == 4


def test_who_says_goodbye_is_off_the_field_at_once(tmp_path):
    path = tmp_path / "game.rcg"
    simulator = play(path, 30, noise=False)
    world = simulator.world[0]
    clock = int(world["time"])
    lines = (tmp_path / "game.rcl").read_text() + "".join(f"{clock},0\tRecv Reds_{unum}: (bye)\n" for unum in range(1, 12))
    (tmp_path / "game.rcl").write_text(lines)
    world["enabled"][:11], world["bits"][:11] = 0, 0
    simulator.clear_commands()
    simulator.step()
    frames = list(GameLogReader(path))
    with GameLogWriter.for_simulator(path, simulator) as writer:
        for frame in frames:
            writer.write(frame)
        writer.record(simulator)
    result = replay_match(path)
    assert result.ok, result.text()
    assert result.mismatches == []
    assert result.cycles >= 30


@needs_shared
def test_a_shoot_out_that_ends_when_everybody_leaves_comes_out_as_logged():
    result = replay_match(MATCHES / "shootout" / "helios_shootout.rcg.gz")
    assert result.ok, result.text()
    assert result.mismatches == []
    assert result.cycles == 950


def test_what_cannot_be_replayed_is_named(tmp_path):
    """A game log without its command log, of an old version, or cut short."""
    data = Path(__file__).parent / "data" / "formats"
    for name in ("v6.rcg", "v4.rcg", "v2.rcg"):
        (tmp_path / name).write_bytes((data / name).read_bytes())
    cut = (data / "v5.rcg").read_bytes()
    (tmp_path / "cut.rcg").write_bytes(cut[: 9 * len(cut) // 10])
    report = run([tmp_path])
    assert report.ok
    why = {Path(result.path).name: result.not_replayed for result in report.results}
    assert "no command log (.rcl) lies beside it; 5 cycles can be read" in why["v6.rcg"]
    assert "version 4 of a game log does not keep what a replay needs" in why["v4.rcg"]
    assert "version 2" in why["v2.rcg"]
    assert "cut.rcg, line" in why["cut.rcg"]
    assert "4 of the files could not be replayed" in report.text()
    assert report.text().count("not replayed, ") == 4


def test_a_game_with_other_physics_is_found_out(tmp_path):
    path = tmp_path / "game.rcg"
    play(path, 50, noise=False)
    text = path.read_text()
    path.write_text(text.replace("(ball_decay 0.94)", "(ball_decay 0.93)", 1))
    result = replay_match(path)
    assert not result.ok
    assert "ball" in {mismatch.object for mismatch in result.mismatches}


def test_a_game_with_less_noise_allowed_is_found_out(tmp_path):
    path = tmp_path / "game.rcg"
    play(path, 50, noise=True)
    text = path.read_text()
    assert "(player_rand 0.1)" in text
    path.write_text(text.replace("(player_rand 0.1)", "(player_rand 0.05)", 1))
    assert not replay_match(path).ok


def test_a_wrong_play_mode_is_found_out(tmp_path):
    path = tmp_path / "game.rcg"
    play(path, 60, noise=False)
    lines = path.read_text().splitlines(keepends=True)
    number = next(index for index, line in enumerate(lines) if line.startswith("(show 20 "))
    lines.insert(number, "(playmode 20 free_kick_l)\n")
    path.write_text("".join(lines))
    result = replay_match(path)
    assert not result.ok
    assert "play mode" in {mismatch.quantity for mismatch in result.mismatches}


def test_a_log_is_shown_in_a_simulator_cycle_by_cycle(tmp_path):
    path = tmp_path / "game.rcg"
    play(path, 40, noise=True)
    shown = []
    for frame, simulator in replay(path):
        world = simulator.world[0]
        assert (world["time"], PlayMode(world["mode"])) == (frame.time, frame.mode)
        np.testing.assert_array_equal(world["pos"][0], frame.ball[:2])
        np.testing.assert_array_equal(world["stamina"], frame.players["stamina"])
        shown.append(frame.time)
    assert shown == list(range(1, 41))
    assert simulator.team_names == ("Reds", "Blues")


def test_a_recorder_whose_game_fails_leaves_no_file(tmp_path):
    simulator = Simulator()
    with pytest.raises(CommandError), Recorder(tmp_path / "game.rcg", simulator) as recorder:
        recorder.step(np.zeros((1, 3)))
    assert list(tmp_path.iterdir()) == []


def test_a_match_needs_its_command_log(tmp_path):
    path = tmp_path / "game.rcg"
    play(path, 20, noise=False)
    path.with_suffix(".rcl").unlink()
    with pytest.raises(FormatError, match=r"\.rcl.*missing"):
        replay_match(path)
    old = Path(__file__).parent / "data" / "formats" / "v3.rcg"
    with pytest.raises(FormatError, match="version 3 of a game log does not keep"):
        replay_match(old)


@needs_shared
@pytest.mark.parametrize("name", REAL.values(), ids=REAL)
def test_the_beginning_of_a_real_match_replays_completely(name):
    result = replay_match(MATCHES / name, cycles=500)
    assert result.ok, result.text()
    assert result.cycles == 500
    assert not result.mismatches, result.text()


@needs_shared
@pytest.mark.slow
@pytest.mark.parametrize("name", REAL.values(), ids=REAL)
def test_a_whole_real_match_replays(name):
    report = run([MATCHES / name])
    assert report.ok, report.text()
    inside, modes = report.results[0].checks
    assert inside.value >= 0.999
    assert modes.value >= 0.995


@needs_shared
def test_a_real_match_with_altered_noise_is_found_out(tmp_path):
    import gzip

    source = MATCHES / REAL["noise"]
    with gzip.open(source, "rt") as lines:
        text = [line for line, _ in zip(lines, range(90))]
    path = tmp_path / "match.rcg"
    path.write_text("".join(text).replace("(player_rand 0.1)", "(player_rand 0.08)", 1))
    result = replay_match(path, source.with_name(source.name.replace(".rcg", ".rcl")))
    assert not result.ok
    assert dataclasses.asdict(result.checks[0])["value"] < 0.999
