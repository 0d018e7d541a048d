"""The trainer's commands of recordings, executed on world 0 of a simulator (specification/protocol.md 6)."""

from __future__ import annotations

import math
from typing import Any

from ...errors import CommandError
from ..protocol.commands import PlayerCommand
from ..simulator import Simulator

_SILENT = {"look", "check_ball", "team_names", "ear", "eye", "say", "done", "compression", "init"}


def execute_trainer(simulator: Simulator, command: PlayerCommand, names: tuple[str, str]) -> None:
    """Execute one command of the trainer.

    Raises
    ------
    CommandError
        For a command that the trainer does not have.
    """
    name, args = command
    if name == "start":
        simulator.trainer.start()
    elif name == "change_mode":
        simulator.trainer.change_mode(args[0])
    elif name == "recover":
        simulator.trainer.recover()
    elif name == "move":
        _move(simulator, args, names)
    elif name == "change_player_type":
        simulator.trainer.change_player_type(_player(args[0], args[1], names), int(args[2]))
    elif name not in _SILENT:
        raise CommandError(f"a recording has an unknown trainer command {name!r}")


def _player(team: Any, unum: float, names: tuple[str, str]) -> int:
    """Object number of a player named by team and number."""
    if team not in names:
        raise CommandError(f"a trainer command names the team {team!r}; the teams are {names[0]!r} and {names[1]!r}")
    return 11 * names.index(team) + int(unum)


def _move(simulator: Simulator, args: tuple[Any, ...], names: tuple[str, str]) -> None:
    """``(move (ball) x y [a [vx vy]])`` and ``(move (player TEAM U) x y [a [vx vy]])``."""
    what, x, y, *rest = args
    velocity = (rest[1], rest[2]) if len(rest) == 3 else None
    if what == ("ball",):
        simulator.trainer.place_ball(x, y, *(velocity or (0.0, 0.0)))
    else:
        body = math.radians(rest[0]) if rest else None
        simulator.trainer.place_player(_player(what[1], what[2], names), x, y, body, velocity)
