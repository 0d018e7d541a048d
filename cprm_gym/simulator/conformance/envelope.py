"""Where noise can take an object in one step: the noise-free step and the radius of the noise around it.

The noise is that of specification/simulator.md 3.2 and 4.1 to 4.4.

Noise of motion has a length of at most ``rand`` times the speed, noise of a kick one of at most kappa, noise of a turn is at most
``player_rand`` times the turn. The caps on acceleration and speed bring two vectors never farther apart, so the radii simply add up.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ..player_types import TypeColumn
from ..protocol.commands import PlayerCommand
from ..state import BALL, Count, PlayerBit

Array = npt.NDArray[Any]
_HIT = int(PlayerBit.BALL_COLLIDE | PlayerBit.PLAYER_COLLIDE)
_BALL_HIT = int(PlayerBit.BALL_COLLIDE | PlayerBit.BALL_TO_PLAYER)
BOUNCE = 0.1
"""Share of its speed that an object keeps, backwards, after a collision."""


class Envelope(NamedTuple):
    """What one step can lead to, for objects 0..22 and players 0..21.

    ``start`` is where the objects stood when the step began, ``move`` the way they go without noise, before any collision, ``radius`` how
    far noise can change that way, ``decay`` what is left of the speed, ``body`` the angle without noise (degrees), ``turn`` how much
    noise can change it, ``turning`` how far the player turns without noise.
    """

    start: Array
    move: Array
    radius: Array
    decay: Array
    body: Array
    turn: Array
    turning: Array


def calm(packed: Array) -> Array:
    """A copy of packed parameters without any noise of movement, turns and kicks."""
    quiet = packed.copy()
    for name in ("ball_rand", "player_rand", "kick_rand", "tackle_rand_factor", "player_rand_of", "kick_rand_factor_of"):
        quiet[name] = 0.0
    quiet["types"][..., TypeColumn.KICK_RAND] = 0.0
    return quiet


def struck(bits: Array) -> tuple[Array, bool]:
    """Which players collided in a step, and whether the ball did, from the players' state bits."""
    return (bits & _HIT) != 0, bool(((bits & _BALL_HIT) != 0).any())


def envelope(packed: Any, before: Any, middle: Any, after: Any, kick_noise: float) -> Envelope:
    """The envelope of a step.

    Parameters
    ----------
    packed : record of PARAMETERS
        With the noise.
    before, middle, after : records of WORLD
        Before the commands, after them, and after the step, run without noise.
    kick_noise : float
        Sum of the greatest lengths of the noise of all kicks and tackles of the cycle.
    """
    types = packed["types"][after["type"]]
    decay = np.concatenate([[packed["ball_decay"]], types[:, TypeColumn.PLAYER_DECAY]])
    hit = np.zeros(23, bool)
    hit[1:], hit[BALL] = struck(after["bits_shown"])
    kept = np.where(hit, -BOUNCE, 1.0) * decay
    move = after["vel"] / kept[:, None]
    speed = np.hypot(move[:, 0], move[:, 1])
    rand = np.empty(23)
    rand[BALL] = packed["ball_rand"]
    rand[1:12], rand[12:] = packed["player_rand_of"]
    extra = np.zeros(23)
    extra[BALL] = kick_noise
    radius = extra + rand * (speed + extra)
    turned = (after["body"] - before["body"] + math.pi) % (2 * math.pi) - math.pi
    turning = np.degrees(np.abs(turned))
    return Envelope(middle["pos"].copy(), move, radius, decay, np.degrees(after["body"]), turning * rand[1:], turning)


def kick_noise(packed: Any, before: Any, after: Any, row: int, command: PlayerCommand) -> float:
    """Greatest length of the noise of one kick or tackle, 0 if it had no effect.

    Parameters
    ----------
    packed : record of PARAMETERS
    before, after : records of WORLD
        Immediately before and after the command.
    row : int
        Who kicks, 0..21.
    command : PlayerCommand
    """
    if command.name == "kick" and before["counts"][row, Count.KICK] == after["counts"][row, Count.KICK]:
        return 0.0
    if command.name == "tackle" and (
        before["counts"][row, Count.TACKLE] == after["counts"][row, Count.TACKLE]
        or int(after["bits"][row]) & int(PlayerBit.TACKLE | PlayerBit.TACKLE_FAULT) != int(PlayerBit.TACKLE)
    ):
        return 0.0
    kind = packed["types"][before["type"][row]]
    rand = float(kind[TypeColumn.KICK_RAND]) * float(packed["kick_rand_factor_of"][0 if row < 11 else 1])
    dx, dy = before["pos"][BALL] - before["pos"][row + 1]
    vx, vy = before["vel"][BALL]
    of_speed = 0.5 + 0.5 * math.hypot(vx, vy) / float(packed["ball_top_speed"])
    if command.name == "kick":
        power = max(float(packed["minpower"]), min(command.args[0], float(packed["maxpower"])))
        angle = math.remainder(math.atan2(dy, dx) - float(before["body"][row]), 2 * math.pi) if dx or dy else 0.0
        margin = float(kind[TypeColumn.KICKABLE_MARGIN])
        gap = math.hypot(dx, dy) - float(kind[TypeColumn.PLAYER_SIZE]) - float(packed["ball_size"])
        of_place = 0.5 + 0.25 * (abs(angle) / math.pi + gap / margin)
        return abs(rand * power / float(packed["maxpower"]) * (of_place + of_speed))
    return rand * float(packed["tackle_rand_factor"]) * (1.0 + of_speed)


def outside(bounds: Envelope, number: int, pos: Array, vel: Array, hit: bool, slack: Array, reach: float) -> tuple[float, float]:
    """By how much an object's position and velocity lie outside the envelope; not positive when they are inside.

    Parameters
    ----------
    bounds : Envelope
    number : int
        Object number.
    pos, vel : (2,) arrays
        Where the object was found, and its velocity after decay.
    hit : bool
        Whether it collided: then its velocity is turned round and its place was pushed.
    slack : (2,) array
        Allowance for position and velocity: rounding of the log.
    reach : float
        How far a collision can push, at most.
    """
    radius, decay = bounds.radius[number], bounds.decay[number]
    target = bounds.start[number] + bounds.move[number]
    kept = -BOUNCE * decay if hit else decay
    place = float(np.hypot(*(pos - target))) - radius - slack[0] - (reach if hit else 0.0)
    speed = float(np.hypot(*(vel - kept * bounds.move[number]))) - abs(kept) * radius - slack[1]
    return place, speed
