"""Wrappers of the environments, one per file.

=================== ===================================================================================================
`Flatten`           one vector instead of a dict, optionally scaled to [-1, 1] by the bounds
`DiscreteActions`   one number instead of a hybrid action (DQN)
`MacroSteps`        a macro action is carried on until it ends: summed reward, ``info["macro_steps"]`` (SMDP)
`FrameStack`        the last k observations
`BeliefObservation` a model's posteriors appended to the observation
`SingleAgent`       one agent of a parallel environment as a Gymnasium environment
`EpisodeStatistics` return, length, status, success and reward terms of every episode, in ``info["episode"]``
`Disturbed`         something goes wrong once in every episode: things displaced, eyes shut, noise (`disturbances`)
`GameLog`           every episode as a game log (``.rcg``) that rcssmonitor plays
`sb3.SoccerVecEnv`  agents x worlds as one batch for stable-baselines3 (imported from `cprm_gym.wrappers.sb3`)
=================== ===================================================================================================
"""

from .belief import BeliefObservation
from .discrete import DiscreteActions
from .disturbances import Disturbed, ParallelDisturbed
from .episode_statistics import EpisodeStatistics
from .flatten import Flatten
from .frame_stack import FrameStack
from .game_log import GameLog, ParallelGameLog
from .macro import MacroSteps
from .single_agent import SingleAgent

__all__ = [
    "BeliefObservation", "DiscreteActions", "Disturbed", "EpisodeStatistics", "Flatten", "FrameStack", "GameLog", "MacroSteps",
    "ParallelDisturbed", "ParallelGameLog", "SingleAgent",
]  # fmt: skip
