"""Proof by replay: recorded runs of a real server, and whole matches, played again by the simulator and compared.

`run` takes files of every kind (scenarios, runs of random commands, statistics, match logs) or directories of them and returns a
`Report` that prints per file the cycles compared, the largest error per quantity and each mismatch. ``cprm-gym conformance``
is this function.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path

from ...errors import FormatError
from ..gamelog.reader import GameLogReader
from .frequencies import catches, fouls, hearing
from .match import REPLAYED_VERSIONS, command_log_of, replay_match
from .recording import Recording, read_recording
from .report import Check, Mismatch, Report, Result
from .scenario import ScenarioReplay
from .sight import arms, gaussian, levels
from .statistics import ball_rows, player_rows, winds

__all__ = ["Check", "Mismatch", "Report", "Result", "files_in", "replay_match", "replay_scenario", "run"]

_RECORDINGS = (".jsonl", ".jsonl.gz")
_MATCHES = (".rcg", ".rcg.gz")
_STATISTICS: dict[str, Callable[[Recording, Result], None]] = {
    "catch_stretch": catches,
    "noise_foul": fouls,
    "noise_hear": hearing,
    "sight_point": arms,
    "sight_gauss": gaussian,
    "sight_prob": levels,
    "sight_prob_v17": levels,
    "wind_rand": winds,
}


def replay_scenario(path: str | os.PathLike[str]) -> Result:
    """Replay one recording (``.jsonl``, ``.jsonl.gz``).

    Raises
    ------
    FormatError
        When the file cannot be read.
    """
    recording = read_recording(path)
    result = Result(str(path), recording.scenario)
    if recording.scenario not in _STATISTICS and any("steps" in record or record["rec"] == "row" for record in recording.records):
        ScenarioReplay(recording, result).run()
    else:
        replay_statistics(recording, result)
    return result


def replay_statistics(recording: Recording, result: Result) -> None:
    """Compare a recording of chance, distributions or frequencies, with the simulator.

    Raises
    ------
    FormatError
        When its records are of no known kind.
    """
    if recording.scenario in _STATISTICS:
        _STATISTICS[recording.scenario](recording, result)
        return
    for record in recording.records:
        if record["rec"] != "rows" or "set" not in record:
            raise FormatError(f"{recording.path}: a record of unknown kind {record['rec']!r} in scenario {recording.scenario!r}")
        if "bbody" in record["columns"]:
            player_rows(recording, result, record)
        else:
            ball_rows(recording, result, record)


def files_in(paths: Iterable[str | os.PathLike[str]]) -> list[Path]:
    """The recordings and matches among `paths`, directories searched through.

    Raises
    ------
    FormatError
        For a path that does not exist, a file of another kind, or a directory with nothing to replay.
    """
    found: list[Path] = []
    for given in paths:
        path = Path(given)
        if path.is_dir():
            inside = sorted(file for file in path.rglob("*") if file.name.endswith(_RECORDINGS + _MATCHES))
            if not inside:
                raise FormatError(f"{path}: no recordings (*{', *'.join(_RECORDINGS)}) or matches (*{', *'.join(_MATCHES)}) in it")
            found += inside
        elif not path.exists():
            raise FormatError(f"{path}: no such file or directory")
        elif path.name.endswith(_RECORDINGS + _MATCHES):
            found.append(path)
        else:
            raise FormatError(f"{path}: not a recording (*{', *'.join(_RECORDINGS)}) or a match (*{', *'.join(_MATCHES)})")
    return found


def replay_file(path: Path) -> Result:
    """Replay one file; a game log that cannot be replayed is read as far as it goes, and the result says why it was not replayed.

    Raises
    ------
    FormatError
        When it cannot be read.
    """
    if not path.name.endswith(_MATCHES):
        return replay_scenario(path)
    reader = GameLogReader(path)
    if reader.version not in REPLAYED_VERSIONS:
        why = f"version {reader.version} of a game log does not keep what a replay needs"
    elif command_log_of(path) is None:
        why = "no command log (.rcl) lies beside it"
    else:
        return replay_match(path)
    cycles, damage = 0, ""
    try:
        for cycles, _ in enumerate(reader, 1):  # noqa: B007 - the last number is what counts
            pass
    except FormatError as error:
        damage = f", then: {error}"
    return Result(str(path), "match", not_replayed=f"{why}; {cycles} cycles can be read{damage}")


def run(paths: Iterable[str | os.PathLike[str]], on_result: Callable[[Result, int, int], object] | None = None) -> Report:
    """Replay files and directories of files.

    Parameters
    ----------
    paths : iterable of path
        Recordings (``.jsonl.gz``), game logs (``.rcg.gz``; to be replayed they need a command log ``.rcl.gz`` beside them), or directories.
    on_result : callable, optional
        Called with (result, files done, files in all) after each file.

    Raises
    ------
    FormatError
        When a path does not exist or a file cannot be read.
    """
    files = files_in(paths)
    report = Report([])
    for done, path in enumerate(files, 1):
        result = replay_file(path)
        report.results.append(result)
        if on_result is not None:
            on_result(result, done, len(files))
    return report
