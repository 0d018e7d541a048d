"""Games played again from their logs, and games of the simulator recorded in logs that the server's tools and `conformance` read."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import numpy.typing as npt

from ..protocol.commands import command_text
from ..protocol.messages import referee_text
from ..simulator import Simulator
from ..state import BALL, PLAYERS, Count, PlayerBit
from .commands import CommandLogWriter
from .frames import Frame
from .reader import GameLogReader
from .writer import GameLogWriter

_COUNTS = (
    Count.KICK,
    Count.DASH,
    Count.TURN,
    Count.CATCH,
    Count.MOVE,
    Count.TURN_NECK,
    Count.CHANGE_VIEW,
    Count.SAY,
    Count.TACKLE,
    Count.ARM,
    Count.ATTENTION,
    Count.CHANGE_FOCUS,
)
ANGLE_UNIT = 0.5e-3
"""Half a unit (degrees) of the last digit of angles in a log."""


def load_frame(world: Any, frame: Frame) -> None:
    """Put what a game log shows into `world`, a record of `WORLD`; what it does not show stays as it is.

    Angles that agree with the logged ones up to its rounding are kept: they are more precise.

    Parameters
    ----------
    world : record of WORLD
        Changed in place.
    frame : Frame
        A cycle of a log of version 3 or later, or JSON.
    """
    rows, state = frame.players, frame.players["state"]
    world["time"], world["stoppage"], world["mode"] = frame.time, frame.stoppage, frame.mode
    world["score"] = frame.left.score, frame.right.score
    world["pen_score"] = frame.left.pen_score, frame.right.pen_score
    world["pen_miss"] = frame.left.pen_miss, frame.right.pen_miss
    world["pos"][BALL], world["vel"][BALL], world["acc"] = frame.ball[:2], np.nan_to_num(frame.ball[2:]), 0.0
    world["enabled"] = (state & int(PlayerBit.STAND)) != 0
    world["goalie"] = (state & int(PlayerBit.GOALIE)) != 0
    world["type"] = np.maximum(rows["type"], 0)
    world["pos"][1:], world["vel"][1:] = rows["pos"], np.nan_to_num(rows["vel"])
    for name in ("body", "neck"):
        logged = np.nan_to_num(rows[name])
        close = np.abs((np.degrees(world[name]) - logged + 180.0) % 360.0 - 180.0) <= ANGLE_UNIT * 1.001
        world[name] = world[f"{name}_staged"] = np.where(close, world[name], np.radians(logged))
    for name in ("stamina", "effort", "recovery", "capacity"):
        known = ~np.isnan(rows[name])
        world[name][known] = rows[name][known]
    for column, count in enumerate(_COUNTS):
        told = rows["counts"][:, column]
        world["counts"][told >= 0, count] = told[told >= 0]
    world["card_count"] = np.where(state & int(PlayerBit.RED_CARD), 2, np.where(state & int(PlayerBit.YELLOW_CARD), 1, 0))
    world["bits_shown"] = state


def replay(path: str | os.PathLike[str], simulator: Simulator | None = None, world: int = 0) -> Iterator[tuple[Frame, Simulator]]:
    """Show a game log in a simulator, cycle by cycle: nothing is computed, the world is what the log says.

    Parameters
    ----------
    path : path
        A game log.
    simulator : Simulator, optional
        Where to show it; one with the log's parameters and types if not given.
    world : int
        In which of its worlds.

    Yields
    ------
    Frame, Simulator
        The cycle, and the simulator whose world number `world` stands as in it.

    Raises
    ------
    FormatError
        When the log cannot be read.
    """
    reader = GameLogReader(path)
    if simulator is None:
        header = reader.header
        simulator = Simulator(1, header.parameters(), header.player_parameters(), header.types() or None)
    for frame in reader:
        simulator.team_names = (frame.left.name, frame.right.name)
        load_frame(simulator.world[world], frame)
        yield frame, simulator


class Recorder:
    """Plays one world of a simulator and keeps both logs of it, as a server does.

    Use it in a ``with`` block: the files appear when the block ends, and not at all if it fails.

    Parameters
    ----------
    path : path
        Of the game log, ``match.rcg`` or ``match.rcg.gz``; the command log gets the same name with ``.rcl``.
    simulator : Simulator
    world : int
        Which of its worlds.
    version : int
        Of the game log, 5, 6 or -1 (JSON).

    Examples
    --------
    >>> with Recorder("match.rcg.gz", simulator) as recorder:  # doctest: +SKIP
    ...     for _ in range(6000):
    ...         recorder.step(choose(simulator))
    """

    def __init__(self, path: str | os.PathLike[str], simulator: Simulator, world: int = 0, version: int = 6) -> None:
        self.simulator, self.world = simulator, world
        name = Path(path)
        ending = "".join(name.suffixes[-2:]) if name.suffix == ".gz" else name.suffix
        commands = name.with_name(name.name.removesuffix(ending) + (".rcl.gz" if name.suffix == ".gz" else ".rcl"))
        self.game_log = GameLogWriter.for_simulator(name, simulator, version=version)
        try:
            self.command_log = CommandLogWriter(commands)
        except Exception:
            self.game_log.abort()
            raise

    def step(self, commands: npt.NDArray[Any] | None = None) -> None:
        """One step of all worlds of the simulator; `commands` as in `Simulator.step`."""
        simulator, record = self.simulator, self.simulator.world[self.world]
        clock = int(record["time"]), int(record["stoppage"])
        given = simulator.commands if commands is None else commands
        simulator.step(commands)
        self._log_commands(clock, given[self.world], record["order"])
        for text in referee_text(simulator, self.world):
            time, name = text.removeprefix("(hear ").removesuffix(")").split(" referee ", 1)
            self.command_log.referee(int(time), int(record["stoppage"]), [name])
        self.game_log.record(simulator, self.world)

    def _log_commands(self, clock: tuple[int, int], commands: npt.NDArray[Any], order: Sequence[int]) -> None:
        """The datagrams of a cycle in the order in which they were executed."""
        for row in order:
            if self.simulator.world[self.world]["enabled"][row]:
                sender = f"{self.simulator.team_names[0 if row < PLAYERS // 2 else 1]}_{row % 11 + 1}"
                self.command_log.received(*clock, sender, command_text(commands[row]) + "(done)")

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        try:
            self.command_log.__exit__(kind, error, trace)
        finally:
            self.game_log.__exit__(kind, error, trace)
