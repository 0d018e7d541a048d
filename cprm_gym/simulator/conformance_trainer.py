"""The trainer's commands of recordings, executed on world 0 of a simulator (PROTOCOL.md 6)."""

from __future__ import annotations

import math
from typing import Any

from cprm_gym.errors import CommandError
from cprm_gym.simulator.command_text import PlayerCommand
from cprm_gym.simulator.kernels.contacts import resolve_collisions
from cprm_gym.simulator.kernels.referee_kick_off import kick_off, substitute
from cprm_gym.simulator.kernels.referee_set_mode import set_mode
from cprm_gym.simulator.player_types import TypeColumn
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import BALL, PlayMode

_MODES = {mode.name: mode for mode in PlayMode}
_SILENT = {"look", "check_ball", "team_names", "ear", "eye", "done", "compression", "init"}


def set_play_mode(simulator: Simulator, mode: PlayMode) -> None:
    """Change the play mode as the trainer does: every module of the referee is told."""
    set_mode(simulator.world[0], simulator.packed[0], int(mode))


def recover(simulator: Simulator) -> None:
    """Everybody on the field is rested."""
    world, packed = simulator.world[0], simulator.packed[0]
    on = world["enabled"] != 0
    world["stamina"][on], world["recovery"][on], world["capacity"][on] = packed["stamina_max"], 1.0, packed["stamina_capacity"]
    world["effort"][on] = packed["types"][world["type"][on], TypeColumn.EFFORT_MAX]
    world["hear_capacity"][on] = packed["hear_max"]


def execute_trainer(simulator: Simulator, command: PlayerCommand, names: tuple[str, str]) -> None:
    """Execute one command of the trainer.

    Raises
    ------
    CommandError
        For a command that recordings do not contain.
    """
    world, packed = simulator.world[0], simulator.packed[0]
    name, args = command
    if name == "start":
        kick_off(world, packed)
    elif name == "change_mode":
        set_play_mode(simulator, _MODES[args[0]])
    elif name == "recover":
        recover(simulator)
    elif name == "move":
        _move(world, packed, args, names)
    elif name == "change_player_type":
        row = _row(args[0], int(args[1]), names)
        substitute(world, packed, row, int(args[2]))
    elif name == "say":
        return
    elif name not in _SILENT:
        raise CommandError(f"a recording has an unknown trainer command {name!r}")


def _row(team: Any, unum: int, names: tuple[str, str]) -> int:
    """Row 0..21 of a player named by team and number."""
    if team not in names:
        raise CommandError(f"a trainer command names the team {team!r}; the teams are {names[0]!r} and {names[1]!r}")
    return 11 * names.index(team) + unum - 1


def _move(world: Any, packed: Any, args: tuple[Any, ...], names: tuple[str, str]) -> None:
    """``(move (ball) x y [a [vx vy]])`` and ``(move (player TEAM U) x y [a [vx vy]])``."""
    what, *numbers = args
    if what == ("ball",):
        world["ball_catcher"] = 0
        world["pos"][BALL] = numbers[:2]
        world["vel"][BALL] = numbers[3:5] if len(numbers) == 5 else (0.0, 0.0)
        world["acc"][BALL] = 0.0
        return
    row = _row(what[1], int(what[2]), names)
    world["pos"][row + 1] = numbers[:2]
    if len(numbers) > 2:
        angle = math.radians(max(-180.0, min(numbers[2], 180.0)))
        world["body"][row] = world["body_staged"][row] = angle
    if len(numbers) == 5:
        world["vel"][row + 1] = numbers[3:5]
    resolve_collisions(world, packed)
