"""What a keeper perceives: `field_percepts`, and what the scripted keepers' formulas make of what he knows."""

from __future__ import annotations

import numpy as np

from ...envs.controller import Observation
from ...envs.observations import BodyFeature
from ..percepts import Percepts, field_percepts
from .kernels import judge
from .recall import recall

NAMES = (
    "keepers.first", "meet.x", "meet.y", "open.x", "open.y", "takers.gap", "pass.room", "pass.x", "pass.y", "cover.vx", "cover.vy",
    "oldest.x", "oldest.y", "oldest.age",
)  # fmt: skip
"""Columns of what `judge` answers."""
AIM = 10.0
"""Metres from the ball to the point at which a kick that shelters it is aimed."""


def keeper_percepts(observation: Observation, records: np.ndarray, count: int, half: float) -> Percepts:
    """What a keeper perceives.

    Parameters
    ----------
    observation : dict of (N, ...) arrays
        With the part ``memory``.
    records : (N,) array of MEMORY
        His own, told what his body is; overwritten.
    count : int
        How many keepers there are.
    half : float
        Half the length of the square less what is kept from its lines, m.

    Returns
    -------
    dict of (N,) float64
        `field_percepts` and `NAMES`: how many keepers are before him at the ball, where he meets it, where he is most open, metres to the
        nearest taker, how clear the way to the best receiver is and where he stands, the velocity that shelters the ball (m / cycle), and
        who was not seen for the longest; and as the net takes them ``meet.distance``, ``meet.direction_deg``, ``pass.distance``,
        ``pass.direction_deg``, ``cover.distance``, ``cover.direction_deg``, ``cover.speed``, ``oldest.direction_deg``.
    """
    percepts = field_percepts(observation)
    recall(records, observation)
    out = np.zeros((len(records), len(NAMES)))
    judge(records, np.asarray(observation["body"])[:, BodyFeature.UNUM].astype(np.int64) - 1, count, half, out)
    percepts.update(zip(NAMES, out.T))
    x, y, facing = percepts["me.x"], percepts["me.y"], percepts["me.facing_deg"]
    speed = np.hypot(percepts["cover.vx"], percepts["cover.vy"])
    away = AIM / np.maximum(speed, 1e-6)
    points = {
        "meet": (percepts["meet.x"], percepts["meet.y"]),
        "pass": (percepts["pass.x"], percepts["pass.y"]),
        "oldest": (percepts["oldest.x"], percepts["oldest.y"]),
        "cover": (percepts["ball.x"] + away * percepts["cover.vx"], percepts["ball.y"] + away * percepts["cover.vy"]),
    }
    for name, (to_x, to_y) in points.items():
        percepts[f"{name}.distance"] = np.hypot(to_x - x, to_y - y)
        percepts[f"{name}.direction_deg"] = (np.degrees(np.arctan2(to_y - y, to_x - x)) - facing + 180.0) % 360.0 - 180.0
    percepts["cover.speed"] = speed
    return percepts
