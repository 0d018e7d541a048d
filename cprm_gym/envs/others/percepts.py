"""What some of the players are told in a cycle: the agents, and the others whom controllers play."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...simulator.senses import BodyColumn, Landmarks, See
from ..kernels import observations as kernels
from ..observations import MAX_AGE
from ..pitch import Pitch

_COLUMNS = np.array(
    [
        BodyColumn.STAMINA, BodyColumn.EFFORT, BodyColumn.CAPACITY, BodyColumn.SPEED, BodyColumn.SPEED_DIRECTION, BodyColumn.HEAD_ANGLE,
        BodyColumn.VIEW_WIDTH, BodyColumn.TACKLE_EXPIRES, BodyColumn.FOUL_CHARGED, BodyColumn.HIT_BALL, BodyColumn.HIT_PLAYER,
        BodyColumn.HIT_POST,
    ]
)  # fmt: skip
"""What the server tells of the body, in the order of the first entries of `BodyFeature`."""


class Sensed(NamedTuple):
    """What all players sense in some worlds, row k being world ``worlds[k]``."""

    worlds: np.ndarray
    """(n,) int."""
    see: See
    body: np.ndarray
    """(n, 22, columns)."""
    marks: Landmarks | None
    heard: tuple[np.ndarray, ...] | None
    begins: bool
    """Their episodes begin: nothing ages."""


def tell(pitch: Pitch, sensed: Sensed, records: np.ndarray | None, told: dict[str, np.ndarray]) -> None:
    """Write the observations of the players of `pitch` in the worlds of `sensed`.

    Parameters
    ----------
    pitch : Pitch
        Its `players` are told.
    sensed : Sensed
    records : (W, 22) array of MEMORY, optional
        What they remember, these percepts among it; needed for the part ``memory``.
    told : dict of (W, A, ...) arrays
        Overwritten where `sensed` is about.
    """
    chosen, see = sensed.worlds, sensed.see
    kernels.pack(
        pitch.sim.world, chosen, pitch.players, _COLUMNS, see.fresh, see.ball, see.ball_level, see.players, see.players_level, sensed.body,
        not sensed.begins, MAX_AGE, told["body"], told["ball"], told["players"], told["level"], told["age"],
    )  # fmt: skip
    if "memory" in told and records is not None:
        kernels.pack_memory(records, chosen, pitch.players, told["self"], told["memory"], told["memory_age"])
    if sensed.marks is not None:
        _tell_pitch(sensed, pitch.players - 1, told)
    if sensed.heard is not None and "hear" in told:
        kernels.pack_hear(*sensed.heard[:6], chosen, pitch.players, told["hear"])


def _tell_pitch(sensed: Sensed, rows: np.ndarray, told: dict[str, np.ndarray]) -> None:
    """Landmarks and lines of those who look."""
    marks, chosen, n = sensed.marks, sensed.worlds, len(sensed.worlds)
    if marks is None:
        return
    looks = sensed.see.fresh[:n, rows, None]
    if "landmarks" in told:
        told["landmarks"][chosen] = np.where(looks[..., None], marks.landmarks[:n, rows], 0.0)
        told["landmark_level"][chosen] = np.where(looks, marks.level[:n, rows], 0)
    if "lines" in told:
        told["lines"][chosen, ..., :2] = np.where(looks[..., None], marks.lines[:n, rows], 0.0)
        told["lines"][chosen, ..., 2] = np.where(looks, marks.line[:n, rows], 0)
