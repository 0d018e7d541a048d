"""What a model of the ball infers from the percepts, as further inputs of a policy: the posterior of its distance and direction."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..agents.body import Body
from ..agents.models import DIRECTION, DISTANCE, ball_model
from ..architecture.prm.grounding.grounding import Grounding
from ..architecture.prm.inference.filter import Filter
from ..envs.observations import BodyFeature, ObjectFeature, SelfFeature
from ..envs.tasks.base import Task

NEEDS = ("normalised", "memory")
"""Parts of the observation that it reads."""
VARIABLES = {"ball.dist": len(DISTANCE.edges) - 1, "ball.dir_deg": len(DIRECTION.edges) - 1}
"""What is inferred, and in how many bins."""
COLUMNS = tuple(f"belief_{variable}_{k}" for variable, count in VARIABLES.items() for k in range(count))
"""Names of the inputs: probabilities of the bins."""
_WORDS = np.array(["no", "yes", None], object)


class BallBelief:
    """The model of the ball, filtered for N agents side by side.

    Parameters
    ----------
    task : Task
    agents : int
        N.

    Attributes
    ----------
    posterior : (N, bins) float32 array
        After the last observation; even before one.
    """

    def __init__(self, task: Task, agents: int) -> None:
        body = Body.of(task)
        self._filter = Filter(Grounding(ball_model(body), {"ball": "Ball"}), agents, on_impossible="restart")
        self._decay = body.kind.player_decay
        self._facing = np.full(agents, np.nan)
        even = np.concatenate([np.full(count, 1.0 / count) for count in VARIABLES.values()])
        self.posterior = np.tile(even, (agents, 1)).astype(np.float32)

    def reset(self, agents: np.ndarray | None = None) -> None:
        """Episodes of all, or of some, (N,) bool, begin: they know nothing."""
        if agents is None or agents.any():
            self._filter.reset(agents)
            self._facing[slice(None) if agents is None else agents] = np.nan

    def update(self, observation: Mapping[str, np.ndarray]) -> np.ndarray:
        """Take in the observations of a cycle, each (N, ...); the posterior."""
        body, ball = np.asarray(observation["body"], np.float64), np.asarray(observation["ball"], np.float64)
        neck = body[:, BodyFeature.NECK]
        looked, seen = body[:, BodyFeature.FRESH] > 0, np.asarray(observation["level"])[:, 0] > 0
        direction = np.degrees(_wrapped(ball[:, ObjectFeature.DIRECTION] + neck))
        facing = np.asarray(observation["self"], np.float64)[:, SelfFeature.BODY]
        turned = np.degrees(_wrapped(facing - self._facing))
        self._facing = facing
        along = np.cos(body[:, BodyFeature.SPEED_DIRECTION] + neck) * body[:, BodyFeature.SPEED] / self._decay
        told = looked & seen
        result = self._filter.step(
            {
                "ball.turned_deg": np.nan_to_num(turned),
                "ball.advanced": along,
                "ball.seen": _WORDS[np.where(looked, seen.astype(np.int64), 2)],
                "ball.seen_dist": np.where(told, ball[:, ObjectFeature.DISTANCE], np.nan),
                "ball.seen_dir_deg": np.where(told, direction, np.nan),
            }
        )
        self.posterior = np.concatenate([np.asarray(result[name]) for name in VARIABLES], axis=1).astype(np.float32)
        return self.posterior


def _wrapped(angle: np.ndarray) -> np.ndarray:
    return np.asarray((angle + math.pi) % (2 * math.pi) - math.pi)
