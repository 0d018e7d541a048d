"""Small worlds for the tests of physics: no noise, no referee, somebody at the centre."""

from __future__ import annotations

from typing import Any

import numpy as np

from cprm_gym.simulator.parameters import Rules, ServerParameters
from cprm_gym.simulator.player_types import PlayerType
from cprm_gym.simulator.simulator import Simulator, no_commands
from cprm_gym.simulator.state import WORLD, CommandKind, PlayMode

QUIET = ServerParameters().without_noise()
R2D = 180.0 / np.pi
D2R = np.pi / 180.0


def quiet_world(left: int = 1, right: int = 0, mode: PlayMode = PlayMode.play_on, **arguments: Any) -> Simulator:
    """A simulator without noise and referee: one left player at rest at the centre, the ball far away, play on."""
    arguments.setdefault("parameters", QUIET)
    arguments.setdefault("player_types", [PlayerType.default(arguments["parameters"])])
    arguments.setdefault("rules", Rules.NONE)
    simulator = Simulator(left=left, right=right, goalies=(min(left, 1), min(right, 1)), **arguments)
    world = simulator.world
    world["mode"] = mode
    world["body"] = world["body_staged"] = 0.0
    for i in range(22):
        world["pos"][:, i + 1] = 0.0, 10.0 * i - 40.0 if i else 0.0
    world["pos"][:, 0] = 30.0, 30.0
    world["kick_cycles"] = world["dash_cycles"] = -1
    return simulator


def put(simulator: Simulator, number: int, x: float, y: float, vx: float = 0.0, vy: float = 0.0, body: float | None = None) -> None:
    """Place object `number` of every world; `body` in degrees."""
    simulator.world["pos"][:, number] = x, y
    simulator.world["vel"][:, number] = vx, vy
    if body is not None:
        simulator.world["body"][:, number - 1] = simulator.world["body_staged"][:, number - 1] = body * D2R


def say_to(simulator: Simulator, number: int, kind: CommandKind, *numbers: float, **free: Any) -> None:
    """Write one player's command into the buffer of every world."""
    row = simulator.commands[:, number - 1]
    row["kind"] = kind
    row["b"] = 0.0
    for name, value in zip("abcd", numbers):
        row[name] = value
    for name, value in free.items():
        row[name] = value


def act(simulator: Simulator, number: int, kind: CommandKind, *numbers: float, **free: Any) -> None:
    """One step in which only player `number` does something."""
    simulator.clear_commands()
    say_to(simulator, number, kind, *numbers, **free)
    simulator.step()
    simulator.clear_commands()


def same(one: Any, other: Any) -> bool:
    """Whether two worlds, or arrays of them, agree in every bit of every field."""
    return all(np.ascontiguousarray(one[name]).tobytes() == np.ascontiguousarray(other[name]).tobytes() for name in WORLD.names)


def record_of(kind: CommandKind, *numbers: float, **free: Any) -> Any:
    """One `COMMAND` record."""
    command = no_commands(1)
    command["kind"], command["b"] = kind, 0.0
    for name, value in zip("abcd", numbers):
        command[name] = value
    for name, value in free.items():
        command[name] = value
    return command[0]
