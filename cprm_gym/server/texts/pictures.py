"""The picture of the whole pitch that trainer and coaches get, for every version of the protocol (specification/protocol.md 6, 7)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...simulator.kernels import rounding
from ...simulator.protocol.messages import real
from ...simulator.simulator import Simulator
from ...simulator.state import BALL, PlayerBit
from ..clients import Coach, Official

LONG_NAMES = 6
"""Newest version with long names and ``(see ...)``."""


def team_name(sim: Simulator, client: Official, left: bool) -> str:
    """What `client` is told the left or right team is called: coaches know opponents by their fixed name, if there is one."""
    fixed = sim.parameters.fixed_teamname_l if left else sim.parameters.fixed_teamname_r
    foreign = isinstance(client, Coach) and (client.side > 0) != left
    return fixed if fixed and foreign else sim.team_names[0 if left else 1]


def player_name(sim: Simulator, client: Official, row: int) -> str:
    """``(p "Left" 1 goalie)`` or ``(player Left 1)``, as `client` is told it."""
    name = team_name(sim, client, row < 11)
    if client.version <= LONG_NAMES:
        return f"(player {name} {row % 11 + 1})"
    goalie = int(sim.world["goalie"][0, row])
    own = not isinstance(client, Coach) or (client.side > 0) == (row < 11)
    return f'(p "{name}" {row % 11 + 1}{" goalie" if goalie == 1 or (goalie and own) else ""})'


def picture(sim: Simulator, client: Official, look: bool = False) -> str:
    """What is sent every cycle to a client with an open eye, or the answer to ``(look)``.

    Parameters
    ----------
    sim : Simulator
        Of one world.
    client : Official
        Who looks.
    look : bool
        The answer to a question, which marks nothing but tackles.
    """
    w = sim.world[0]
    long = client.version <= LONG_NAMES
    head = "ok look" if look else "see" if long else "see_global"
    goals, ball = ("((goal r) 52.5 0) ((goal l) -52.5 0)", "ball") if long else ("((g r) 52.5 0) ((g l) -52.5 0)", "b")
    numbers = " ".join(map(real, (*w["pos"][BALL], *w["vel"][BALL])))
    players = [_player(sim, w, client, int(row), look) for row in np.flatnonzero(w["enabled"])]
    return " ".join((f"({head} {w['time']} {goals} (({ball}) {numbers})", *players)) + ")"


def _player(sim: Simulator, w: Any, client: Official, row: int, look: bool) -> str:
    """One player of the picture."""
    place, speed = [*map(real, w["pos"][row + 1])], [*map(real, w["vel"][row + 1])]
    angles = [str(int(rounding.rounded_degrees(angle))) for angle in (w["body"][row], w["neck"][row])]
    name = player_name(sim, client, row)
    if client.version <= LONG_NAMES:
        return f"({' '.join((name, *place, *angles, *speed))})"
    parts = [name, *place, *speed, *angles]
    if client.version >= 8:
        parts += _marks(w, row, client.version, look, w["arm_timer"][row] < sim.packed["point_to_duration"][0])
    return f"({' '.join(parts)})"


def _marks(w: Any, row: int, version: int, look: bool, pointing: bool) -> list[str]:
    """Direction of a raised arm, what the player is doing, his card."""
    marks = []
    if pointing:
        x, y = w["arm_target"][row] - w["pos"][row + 1]
        marks.append(str(int(rounding.rounded_degrees(math.atan2(y, x)))))
    if w["tackle_cycles"][row] > 0:
        marks.append("t")
    elif not look and version >= 13 and w["kick_cycles"][row] >= 0:
        marks.append("k")
    elif not look and version >= 14 and not pointing and w["foul_cycles"][row] > 0:
        marks.append("f")
    bits = int(w["bits"][row])
    if not look and version >= 14 and bits & (PlayerBit.RED_CARD | PlayerBit.YELLOW_CARD):
        marks.append("r" if bits & PlayerBit.RED_CARD else "y")
    return marks
