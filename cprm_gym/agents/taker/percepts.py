"""What a taker perceives: `field_percepts`, and what the scripted players' formulas make of what he knows."""

from __future__ import annotations

import numpy as np

from ...envs.controller import Observation
from ...envs.observations import BodyFeature
from ..body import Body
from ..keeper.recall import recall
from ..percepts import Percepts, field_percepts
from .constants import TakerConstants
from .kernels import judge

NAMES = ("takers.first", "meet.x", "meet.y", "cover.x", "cover.y", "out.x", "out.y", "keepers.gap", "tackle.chance")
"""Columns of what `judge` answers."""


def taker_percepts(
    observation: Observation, records: np.ndarray, count: int, half: float, body: Body, constants: TakerConstants
) -> Percepts:
    """What a taker perceives.

    Parameters
    ----------
    observation : dict of (N, ...) arrays
        With the part ``memory``.
    records : (N,) array of MEMORY
        His own, told what his body is; overwritten.
    count : int
        How many takers there are.
    half : float
        Half the length of the square, m.
    body : Body
    constants : TakerConstants

    Returns
    -------
    dict of (N,) float64
        `field_percepts` and `NAMES`: how many takers are before him at the ball, where he meets it, where he stands in the way of a pass,
        where to kick the ball out of the square, metres from the ball to the nearest keeper, the chance that a tackle hits it; and as the
        net takes them ``meet.distance``, ``meet.direction_deg``, ``out.distance``, ``out.direction_deg``.
    """
    percepts = field_percepts(observation)
    recall(records, observation)
    out = np.zeros((len(records), len(NAMES)))
    me = np.asarray(observation["body"])[:, BodyFeature.UNUM].astype(np.int64) - 1
    judge(records, me, count, half, body.server.ball_speed_max, constants.share, out)
    percepts.update(zip(NAMES, out.T))
    x, y, facing = percepts["me.x"], percepts["me.y"], percepts["me.facing_deg"]
    for name in ("meet", "out"):
        to_x, to_y = percepts[f"{name}.x"] - x, percepts[f"{name}.y"] - y
        percepts[f"{name}.distance"] = np.hypot(to_x, to_y)
        percepts[f"{name}.direction_deg"] = (np.degrees(np.arctan2(to_y, to_x)) - facing + 180.0) % 360.0 - 180.0
    return percepts
