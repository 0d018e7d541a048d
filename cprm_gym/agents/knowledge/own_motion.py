"""A player's own motion by his commands: how he knows his place where what he is told of himself is late.

References
----------
specification/simulator.md 3.1, 4.1, 4.2, 4.4 and 4.7, without noise and with legs that do the same.
"""

from __future__ import annotations

import numpy as np

from ...envs.actions import NECK_SCALE, PARAMETER_SCALES
from ...envs.controller import Action
from ...envs.observations import SelfFeature
from ...simulator.state import CommandKind
from ..body import Body


def carried_on(me: np.ndarray, sent: Action, body: Body, effort: np.ndarray, locked: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Himself a cycle later.

    Parameters
    ----------
    me : (N, 8) array of `SelfFeature`
    sent : dict of (N, ...) arrays
        What he did in this cycle.
    body : Body
        His own.
    effort : (N,) array
    locked : (N,) array
        Cycles for which the body does not obey, as it is felt.

    Returns
    -------
    me : (N, 8) array
    locked : (N,) array
    """
    kind, server, obeys = body.kind, body.server, locked <= 0
    command = np.asarray(sent["type"])
    first, second = (np.asarray(sent["params"], np.float64)[:, k] * PARAMETER_SCALES[command, k] for k in (0, 1))
    x, y, vx, vy, facing, face = (me[:, k] for k in range(6))
    speed = np.hypot(vx, vy)
    moment = np.where(obeys & (command == CommandKind.TURN), np.clip(first, server.minmoment, server.maxmoment), 0.0)
    power = np.where(obeys & (command == CommandKind.DASH), np.clip(first, server.min_dash_power, server.max_dash_power), 0.0)
    push = power * _share(np.abs(second), body) * kind.dash_power_rate * effort
    angle = facing + np.radians(second)
    vx, vy = _within(vx + push * np.cos(angle), vy + push * np.sin(angle), kind.player_speed_max)
    neck = np.degrees(_wrapped(face - facing)) + np.asarray(sent["turn_neck"], np.float64)[:, 0] * NECK_SCALE
    facing = _wrapped(facing + np.radians(moment / (1.0 + kind.inertia_moment * speed)))
    face = _wrapped(facing + np.radians(np.clip(neck, server.minneckang, server.maxneckang)))
    falls = obeys & (command == CommandKind.TACKLE)
    locked = np.where(falls, server.tackle_cycles - 1.0, np.maximum(locked - 1.0, 0.0))
    moved = np.stack([x + vx, y + vy, kind.player_decay * vx, kind.player_decay * vy, facing, face], axis=1)
    later = np.concatenate([moved, me[:, 6:]], axis=1)
    later[:, SelfFeature.FREE] = locked <= 0
    return later, locked


def _share(aside: np.ndarray, body: Body) -> np.ndarray:
    """Share of a dash's power that counts in a direction, degrees from the body."""
    side, back = body.server.side_dash_rate, body.server.back_dash_rate
    ahead = side + (1.0 - side) * (1.0 - aside / 90.0)
    return np.asarray(np.clip(np.where(aside > 90.0, back - (back - side) * (1.0 - (aside - 90.0) / 90.0), ahead), 0.0, 1.0))


def _within(vx: np.ndarray, vy: np.ndarray, most: float) -> tuple[np.ndarray, np.ndarray]:
    """A velocity of at most so many m / cycle."""
    share = np.minimum(1.0, most / np.maximum(np.hypot(vx, vy), 1e-9))
    return vx * share, vy * share


def _wrapped(angle: np.ndarray) -> np.ndarray:
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)
