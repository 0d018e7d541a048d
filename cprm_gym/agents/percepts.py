"""Named quantities from observation arrays: what nets, models, state machines and hand-written code all read.

Angles are degrees here, relative to the body, because the server's commands take degrees relative to the body.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..envs.spaces import BodyFeature, ObjectFeature

Percepts = dict[str, np.ndarray]
"""Name -> (N,) float array; NaN where there is no reading."""


def body_percepts(observation: Mapping[str, np.ndarray]) -> Percepts:
    """What the player feels of himself.

    Returns
    -------
    dict of (N,) float64
        ``body.stamina``, ``body.effort``, ``body.speed`` (m / cycle), ``body.speed_direction`` and ``body.neck`` (degrees),
        ``body.fresh`` (1 if he saw something this cycle), ``body.locked`` (cycles until the body obeys again).
    """
    body = np.asarray(observation["body"], np.float64)
    neck = np.degrees(body[:, BodyFeature.NECK])
    return {
        "body.stamina": body[:, BodyFeature.STAMINA],
        "body.effort": body[:, BodyFeature.EFFORT],
        "body.speed": body[:, BodyFeature.SPEED],
        "body.speed_direction": np.degrees(body[:, BodyFeature.SPEED_DIRECTION]) + neck,
        "body.neck": neck,
        "body.fresh": body[:, BodyFeature.FRESH],
        "body.locked": np.maximum(body[:, BodyFeature.TACKLE_EXPIRES], body[:, BodyFeature.FOUL_CHARGED]),
    }


def ball_percepts(observation: Mapping[str, np.ndarray]) -> Percepts:
    """What the player sees of the ball, with `body_percepts`.

    Returns
    -------
    dict of (N,) float64
        ``ball.seen`` (1 if a ball, or something felt to be one, is in this percept), ``ball.distance`` (m), ``ball.direction`` (degrees
        from the body), ``ball.distance_change`` (m / cycle), ``ball.direction_change`` (degrees / cycle): 0 where not seen.
    """
    percepts = body_percepts(observation)
    ball = np.asarray(observation["ball"], np.float64)
    level = np.asarray(observation["level"])[:, 0]
    seen = level > 0
    direction = np.degrees(ball[:, ObjectFeature.DIRECTION]) + percepts["body.neck"]
    percepts["ball.seen"] = seen.astype(np.float64)
    percepts["ball.distance"] = np.where(seen, ball[:, ObjectFeature.DISTANCE], 0.0)
    percepts["ball.direction"] = np.where(seen, (direction + 180.0) % 360.0 - 180.0, 0.0)
    percepts["ball.distance_change"] = np.where(seen, ball[:, ObjectFeature.DISTANCE_CHANGE], 0.0)
    percepts["ball.direction_change"] = np.where(seen, np.degrees(ball[:, ObjectFeature.DIRECTION_CHANGE]), 0.0)
    return percepts
