"""Registers every task with Gymnasium and, where it knows registration, with PettingZoo, without loading any of them."""

from __future__ import annotations

import gymnasium
import pettingzoo

NAMESPACE = "cprm"
TASK_NAMES = (
    "GoToBall", "KickOffShot", "Goalie", "PassAndAdvance",
    "Keepaway3v2", "Keepaway4v3", "Keepaway5v4",
    "HFO1v0", "HFO1v1", "HFO2v1", "HFO2v2", "HFO3v2", "HFO3v3", "HFO4v5",
    "FrontGoalEmptyGoal", "FrontGoalBlockedShot", "FrontGoalSupportOption", "FrontGoalPassingLane", "FrontGoalCompactDefense",
    "Soccer", "Soccer5v5", "Soccer11v11",
)  # fmt: skip
"""Names of `cprm_gym.envs.tasks.TASKS`."""


def register_all() -> tuple[str, ...]:
    """Register all tasks, and the little world of Appendix A; a second call changes nothing.

    Returns
    -------
    tuple of str
        The Gymnasium ids, ``cprm/<Task>-v0``.
    """
    ids = []
    for name in TASK_NAMES:
        env_id = f"{NAMESPACE}/{name}-v0"
        ids.append(env_id)
        if env_id not in gymnasium.registry:
            gymnasium.register(
                env_id,
                entry_point="cprm_gym.envs.single:SoccerEnv",
                vector_entry_point="cprm_gym.envs.vector:SoccerVectorEnv",
                kwargs={"task": name},
            )
    small = f"{NAMESPACE}/SlowApproach-v0"
    ids.append(small)
    if small not in gymnasium.registry:
        world = "cprm_gym.envs.tasks.slow_approach"
        gymnasium.register(small, entry_point=f"{world}:SlowApproachEnv", vector_entry_point=f"{world}:SlowApproachVectorEnv")
    _register_with_pettingzoo()
    return tuple(ids)


def _register_with_pettingzoo() -> None:
    """``pettingzoo.make("parallel", "cprm/soccer_v0")``, with PettingZoo 1.27 or newer."""
    if not hasattr(pettingzoo, "register"):
        return
    env_id = f"{NAMESPACE}/soccer_v0"
    for kind, entry in (("parallel", "parallel_env"), ("aec", "env")):
        if env_id not in getattr(pettingzoo, f"{kind}_registry"):
            pettingzoo.register(kind, env_id, f"cprm_gym.envs.soccer:{entry}")
