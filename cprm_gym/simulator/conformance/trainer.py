"""The trainer's commands of recordings, executed on world 0 of a simulator (specification/protocol.md 6)."""

from __future__ import annotations

import math
from typing import Any

from ...errors import CommandError
from ..protocol.commands import PlayerCommand
from ..simulator import Simulator

_SILENT = {"look", "check_ball", "team_names", "ear", "eye", "say", "done", "compression", "init"}


def is_whole(value: Any) -> bool:
    """Whether a word of a command is a whole number."""
    return isinstance(value, float) and value.is_integer()


def execute_trainer(simulator: Simulator, command: PlayerCommand, names: tuple[str, str]) -> None:
    """Execute one command of the trainer.

    Raises
    ------
    CommandError
        For a command that the trainer does not have, or one with other arguments than it takes.
    UnknownName
        For a play mode that there is not.
    """
    name, args = command
    if name == "start":
        simulator.trainer.start()
    elif name == "change_mode" and len(args) == 1:
        simulator.trainer.change_mode(str(args[0]))
    elif name == "recover":
        simulator.trainer.recover()
    elif name == "move" and len(args) in (3, 4, 6) and all(isinstance(value, float) for value in args[1:]):
        _move(simulator, args, names)
    elif name == "change_player_type" and len(args) == 3 and is_whole(args[2]):
        simulator.trainer.change_player_type(_player(args[0], args[1], names), int(args[2]))
    elif name not in _SILENT:
        raise CommandError(f"unknown trainer command, or one with other arguments than it takes: {name!r}")


def _player(team: Any, unum: Any, names: tuple[str, str]) -> int:
    """Object number of a player named by team and number."""
    if team not in names:
        raise CommandError(f"a trainer command names the team {team!r}; the teams are {names[0]!r} and {names[1]!r}")
    if not is_whole(unum) or not 1 <= unum <= 11:
        raise CommandError(f"a trainer command names the player {unum!r}; numbers are 1 to 11")
    return 11 * names.index(team) + int(unum)


def _move(simulator: Simulator, args: tuple[Any, ...], names: tuple[str, str]) -> None:
    """``(move (ball) x y [a [vx vy]])`` and ``(move (player TEAM U) x y [a [vx vy]])``."""
    what, x, y, *rest = args
    velocity = (rest[1], rest[2]) if len(rest) == 3 else None
    if what == ("ball",):
        simulator.trainer.place_ball(x, y, *(velocity or (0.0, 0.0)))
    elif isinstance(what, tuple) and len(what) == 3 and what[0] == "player":
        body = math.radians(rest[0]) if rest else None
        simulator.trainer.place_player(_player(what[1], what[2], names), x, y, body, velocity)
    else:
        raise CommandError(f"a trainer moves (ball) or (player TEAM U), got {str(what)[:40]!r}")
