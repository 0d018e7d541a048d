"""A scripted player's memory from an observation, so that what its kernels reckon can be known to an agent, too."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...envs.observations import BodyFeature, SelfFeature


def recall(records: np.ndarray, observation: Mapping[str, np.ndarray]) -> None:
    """Fill one player's memory in N worlds from an observation with the part ``memory``, for kernels that decide by it.

    Parameters
    ----------
    records : (N,) array of MEMORY
    observation : dict of (N, ...) arrays
    """
    me, body = np.asarray(observation["self"], np.float64), np.asarray(observation["body"], np.float64)
    seen, age = np.asarray(observation["memory"], np.float64), np.asarray(observation["memory_age"])
    for name in ("x", "y", "vx", "vy", "body", "face", "located", "free"):
        records[name] = me[:, SelfFeature[name.upper()]]
    records["neck"] = body[:, BodyFeature.NECK]
    records["stamina"], records["effort"] = body[:, BodyFeature.STAMINA], body[:, BodyFeature.EFFORT]
    records["ball_x"], records["ball_y"], records["ball_vx"], records["ball_vy"] = seen[:, 0].T
    records["ball_age"] = age[:, 0]
    records["px"], records["py"], records["age"] = seen[:, 1:, 0], seen[:, 1:, 1], age[:, 1:]
