"""The tracker's own constants are tuned by one rule: the least error about the ball.

A goalie on the tier ``memory`` plays the worlds of a study under each of `SENSES`; what he is told and sends is recorded, and each
candidate tracks the ball from it, knowing the noise of those senses. The error is the distance between where the ball is told to be and
where it is, now and `AHEAD` cycles of free roll later, each at most `FAR`; the score is less the mean over the senses of the logarithm of
its mean, so that a tenth less counts as much under good senses as under bad ones.

``cprm-gym tune --tracker`` runs the study again.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..agents.body import Body
from ..agents.knowledge.players import RIVAL, player_of
from ..agents.knowledge.tracker import Tracker, TrackerConstants
from ..agents.skills.constants import Constants
from ..envs.controller import Action, Observation
from ..envs.core import SoccerCore
from ..envs.observations import SelfFeature
from ..envs.players.senses import Senses
from ..envs.tasks import make_task
from .tuning import TUNING_SEED, check_search

SENSES = (
    Senses(), Senses(view="wide"), Senses(asynchronous=True), Senses(motion=False), Senses(lost=0.3), Senses(lost=0.6), Senses(noise=0.5),
    Senses(noise=1.0), Senses(gaussian=0.1), Senses(late_ball=2),
)  # fmt: skip
"""Under which it has to know the ball."""
AHEAD = 5
"""Cycles ahead for which the ball is told as well."""
FAR = 3.0
"""The largest error that counts, m: whoever has lost the ball has lost it."""
CYCLES = 40
"""Of an episode that are tracked; what comes after its end is left out."""


class Record(NamedTuple):
    """What happened in the worlds of a generation under one of the senses."""

    told: tuple[Observation, ...]
    sent: tuple[Action, ...]
    true: np.ndarray
    """(T, W, 4) place and velocity of the ball."""
    own: np.ndarray
    """(T, W, 2) place of the player."""
    playing: np.ndarray
    """(T, W) bool: the episode goes on."""


@dataclass(frozen=True)
class TrackingPlan:
    """A study of the tracker; parameters as for `tuning.Plan`.

    Raises
    ------
    ParameterError
        For numbers that make no sense.
    """

    task: str = "Goalie"
    worlds: int = 60
    population: int = 24
    elite: int = 6
    generations: int = 8
    seed: int = 0

    def __post_init__(self) -> None:
        player_of(self.task)
        check_search(self, worlds=1)

    @property
    def constants(self) -> type[Constants]:
        """What is tuned."""
        return TrackerConstants

    def score(self, constants: Constants, generation: int) -> float:
        """Less the mean logarithm of the error, m."""
        assert isinstance(constants, TrackerConstants)
        seed = TUNING_SEED + 1000 * self.seed + generation
        errors = [error_of(self.task, self.worlds, seed, senses, constants) for senses in SENSES]
        return -float(np.log(errors).mean())


@functools.lru_cache(maxsize=2 * len(SENSES))
def record(task: str, worlds: int, seed: int, senses: Senses) -> Record:
    """What the task's player is told and sends on the tier `RIVAL`, and where the ball is."""
    made = make_task(task)
    core = SoccerCore(made, worlds, seed=seed, include=("memory", "landmarks", "lines"), senses=senses)
    observation = core.reset(seed)
    controllers = [player_of(task).on(RIVAL, senses)(made, agent) for agent in core.agents]
    told, sent, true, own, playing = [], [], [], [], [np.ones(worlds, bool)]
    for i, controller in enumerate(controllers):
        controller.reset({key: value[:, i] for key, value in observation.items()}, seed)
    for _ in range(min(CYCLES, made.max_cycles)):
        told.append({key: value[:, 0].copy() for key, value in core.observation.items()})
        truth = core.truth(core.agents[0])
        true.append(truth["memory"][:, 0])
        own.append(truth["self"][:, [SelfFeature.X, SelfFeature.Y]])
        actions = [
            controller.act({key: value[:, i] for key, value in core.observation.items()}) for i, controller in enumerate(controllers)
        ]
        sent.append({key: np.array(value) for key, value in actions[0].items()})
        step = core.step({key: np.stack([np.asarray(action[key]) for action in actions], axis=1) for key in actions[0]})
        playing.append(playing[-1] & ~(step.terminated | step.truncated))
    return Record(tuple(told), tuple(sent), np.array(true), np.array(own), np.array(playing[:-1]))


def error_of(task: str, worlds: int, seed: int, senses: Senses, constants: TrackerConstants) -> float:
    """Mean error of a tracker about the ball, m."""
    told, sent, true, _, playing = record(task, worlds, seed, senses)
    body = Body.of(make_task(task))
    tracker = Tracker(senses, body, constants)
    tracker.reset(told[0])
    known = np.array([tracker.know(now, sent[k - 1] if k else None)["memory"][:, 0] for k, now in enumerate(told)])
    decay = body.server.ball_decay
    rolled = (1.0 - decay**AHEAD) / (1.0 - decay)
    off = known - true
    gaps = np.stack([np.hypot(off[..., 0] + cycles * off[..., 2], off[..., 1] + cycles * off[..., 3]) for cycles in (0.0, rolled)])
    return float(np.minimum(gaps, FAR)[:, playing].mean())
