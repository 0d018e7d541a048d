"""Wrappers of the environments, one per file.

==================== ===================================================================================================
`Flatten`            one vector instead of a dict, optionally scaled to [-1, 1] by the bounds
`DiscreteActions`    one number instead of a hybrid action (DQN)
`MacroSteps`         a macro action is carried on until it ends: summed reward, ``info["macro_steps"]`` (SMDP)
`VectorMacroSteps`   the same in many worlds, each of which goes just as far as its macro
`ParallelMacroSteps` the same for several agents of a parallel environment, who decide each when his macro ends
`FrameStack`         the last k observations
`BeliefObservation`  a model's posteriors appended to the observation
`SingleAgent`        one agent of a parallel environment as a Gymnasium environment
`EpisodeStatistics`  return, length, status, success and reward terms of every episode, in ``info["episode"]``
`Disturbed`          something goes wrong once in every episode: things displaced, eyes shut, noise (`disturbances`)
`GameLog`            every episode as a game log (``.rcg``) that rcssmonitor plays
`sb3.SoccerVecEnv`   agents x worlds as one batch for stable-baselines3 (imported from `cprm_gym.wrappers.sb3`)
==================== ===================================================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazy import lazy_face

if TYPE_CHECKING:
    from .belief import BeliefObservation as BeliefObservation
    from .belief import FilterBelief as FilterBelief
    from .discrete import DiscreteActions as DiscreteActions
    from .disturbances import BallDisplaced as BallDisplaced
    from .disturbances import BallStopped as BallStopped
    from .disturbances import BlindSpell as BlindSpell
    from .disturbances import Disturbed as Disturbed
    from .disturbances import NoiseBurst as NoiseBurst
    from .disturbances import ParallelDisturbed as ParallelDisturbed
    from .disturbances import PlayerDisplaced as PlayerDisplaced
    from .disturbances import Push as Push
    from .episode_statistics import EpisodeStatistics as EpisodeStatistics
    from .flatten import Flatten as Flatten
    from .frame_stack import FrameStack as FrameStack
    from .game_log import GameLog as GameLog
    from .game_log import ParallelGameLog as ParallelGameLog
    from .macro import MacroSteps as MacroSteps
    from .macro import ParallelMacroSteps as ParallelMacroSteps
    from .macro import VectorMacroSteps as VectorMacroSteps
    from .single_agent import SingleAgent as SingleAgent
else:
    __all__, __getattr__, __dir__ = lazy_face(
        __name__,
        {
            "belief": "BeliefObservation FilterBelief",
            "discrete": "DiscreteActions",
            "disturbances": "BallDisplaced BallStopped BlindSpell Disturbed NoiseBurst ParallelDisturbed PlayerDisplaced Push",
            "episode_statistics": "EpisodeStatistics",
            "flatten": "Flatten",
            "frame_stack": "FrameStack",
            "game_log": "GameLog ParallelGameLog",
            "macro": "MacroSteps ParallelMacroSteps VectorMacroSteps",
            "single_agent": "SingleAgent",
        },
    )
