"""Steps of runs with noise: what has no noise must come out exactly, what has must lie inside its bounds."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ..state import BALL, PlayerBit
from .envelope import Envelope, outside
from .recording import R2D, ROW, near_post, nearest_angle, shown_mode
from .report import Result

_COLLIDE = int(PlayerBit.BALL_COLLIDE | PlayerBit.PLAYER_COLLIDE | PlayerBit.POST_COLLIDE)
_ENERGY = ("stamina", "effort", "recovery", "capacity")
SLACK = np.array([1e-9, 1e-9])


def compare_noisy(
    result: Result,
    case: str,
    cycle: int,
    world: Any,
    step: dict[str, Any],
    bounds: Envelope,
    goal_width: float,
    maybe: frozenset[int],
) -> None:
    """Compare a recorded step with noise with the step run without.

    Parameters
    ----------
    result, case, cycle
        Where it is noted.
    world : record of WORLD
        After the step, run without noise.
    step : dict
        The recorded step; its ``flags`` tell who collided.
    bounds : Envelope
    goal_width : float
        Objects near a goal post may have been reflected and are left to chance.
    maybe : frozenset of int
        Object numbers whose mark of a collision may come from before the step: a trainer's placement or a catch.
    """
    state = step["state"]
    flags = {key: int(text, 16) for key, text in step.get("flags", {}).items()}
    result.equal(case, cycle, "game", "time", state["t"], int(world["time"]))
    result.equal(case, cycle, "game", "play mode", state["pm"], shown_mode(world))
    result.equal(case, cycle, "game", "score", list(state["score"]), [int(score) for score in world["score"]])
    struck = {ROW[key] + 1 for key, bits in flags.items() if bits & _COLLIDE}
    if any(bits & int(PlayerBit.BALL_COLLIDE) for bits in flags.values()):
        struck.add(BALL)
    _place(result, case, cycle, "ball", BALL, state["ball"], bounds, _hit(BALL, struck, maybe), goal_width)
    for key, values in state["pl"].items():
        row = ROW[key]
        result.equal(case, cycle, key, "type", values[0], int(world["type"][row]))
        for name, told in zip(_ENERGY, values[7:11]):
            result.number(case, cycle, key, name, told, float(world[name][row]), 1e-12 + 2e-16 * abs(told))
        neck = nearest_angle(values[6], float(world["neck"][row]) * R2D)
        result.number(case, cycle, key, "neck", values[6], neck, 1e-12)
        turn = abs(nearest_angle(values[5], float(bounds.body[row])) - values[5])
        result.number(case, cycle, key, "body outside its bounds", 0.0, max(turn - bounds.turn[row], 0.0), 1e-9)
        _place(result, case, cycle, key, row + 1, values[1:5], bounds, _hit(row + 1, struck, maybe), goal_width)
        told_bits, own_bits = flags.get(key, 0), int(world["bits_shown"][row])
        mask = ~(_COLLIDE | int(PlayerBit.STAND | PlayerBit.GOALIE | PlayerBit.YELLOW_CARD | PlayerBit.BALL_TO_PLAYER))
        result.equal(case, cycle, key, "state bits", hex(told_bits & mask), hex(own_bits & mask))


def _hit(number: int, struck: set[int], maybe: frozenset[int]) -> bool | None:
    """Whether an object collided in the step; None if that cannot be told."""
    return None if number in struck and number in maybe else number in struck


def _place(
    result: Result,
    case: str,
    cycle: int,
    name: str,
    number: int,
    values: list[float],
    bounds: Envelope,
    hit: bool | None,
    width: float,
) -> None:
    """Position and velocity of one object: inside the envelope, and one the continuation of the other."""
    pos: npt.NDArray[np.float64] = np.array(values[:2])
    vel: npt.NDArray[np.float64] = np.array(values[2:4])
    if near_post(pos, 4.2 if number == BALL else 1.8, width):
        result.chance += 1
        return
    if hit is None:
        hit = max(outside(bounds, number, pos, vel, False, SLACK, 1.2)) > 0.0
    place, speed = outside(bounds, number, pos, vel, hit, SLACK, 1.2)
    result.number(case, cycle, name, "position outside its bounds", 0.0, max(place, 0.0), 0.0)
    result.number(case, cycle, name, "velocity outside its bounds", 0.0, max(speed, 0.0), 0.0)
    if not hit:
        # the noise that moved the object is the one that its velocity shows
        moved = (pos - bounds.start[number]) * bounds.decay[number]
        for axis, told, own in zip(("vx", "vy"), vel, moved):
            result.number(case, cycle, name, f"{axis} of the way", float(told), float(own), 1e-12)
