"""Registers every task with Gymnasium and, where it knows registration, with PettingZoo, without loading any of them."""

from __future__ import annotations

import gymnasium
import pettingzoo

NAMESPACE = "cprm"
VERSION = 2
"""Of all environments. 2: the default observation is ``normalised``, where it was ``raw``, and GoToBall pays for coming nearer. 1: success
is each agent's own and rewards of the right side have their sign, infos are numbers, ages end at 1000 cycles, ``hfo_low`` knows rest, every
face's default actions are ``discrete``."""
TASK_CYCLES = {
    "GoToBall": 200, "LostAndFound": 100, "Hike": 200,
    "KickOffShot": 600, "KickOffShot2v2": 600, "Goalie": 200, "Goalie2v1": 200, "Goalie3v2": 200,
    "PassAndAdvance": 1000, "PassAndAdvance2v1": 1000, "PassAndAdvance2v2": 1000, "PassAndAdvance2v3": 1000,
    "Keepaway3v2": 1000, "Keepaway4v3": 1000, "Keepaway5v4": 1000,
    "HFO1v0": 500, "HFO1v1": 500, "HFO2v1": 500, "HFO2v2": 500, "HFO3v2": 500, "HFO3v3": 500, "HFO4v5": 500,
    "FrontGoalEmptyGoal": 200, "FrontGoalBlockedShot": 200, "FrontGoalSupportOption": 200, "FrontGoalPassingLane": 200,
    "FrontGoalCompactDefense": 200,
    "Soccer": 9000, "Soccer5v5": 9000, "Soccer11v11": 9000,
}  # fmt: skip
"""Names of `cprm_gym.envs.tasks.TASKS`, and their ``max_cycles``."""
TASK_NAMES = tuple(TASK_CYCLES)
SMALL_CYCLES = 400
"""``max_cycles`` of SlowApproach."""


def register_all() -> tuple[str, ...]:
    """Register all tasks, and the little world of Appendix A; a second call changes nothing.

    Gymnasium answers an older version (``-v0``, ``-v1``) with an error that names the present one.

    Returns
    -------
    tuple of str
        The Gymnasium ids, ``cprm/<Task>-v2``.
    """
    soccer, small = "cprm_gym.envs", "cprm_gym.envs.tasks.slow_approach"
    one, worlds = f"{soccer}.single:SoccerEnv", f"{soccer}.vector:SoccerVectorEnv"
    entries = [(name, one, worlds, {"task": name}, cycles) for name, cycles in TASK_CYCLES.items()]
    entries.append(("SlowApproach", f"{small}:SlowApproachEnv", f"{small}:SlowApproachVectorEnv", {}, SMALL_CYCLES))
    ids = []
    for name, single, many, arguments, cycles in entries:
        env_id = f"{NAMESPACE}/{name}-v{VERSION}"
        ids.append(env_id)
        if env_id not in gymnasium.registry:
            gymnasium.register(env_id, entry_point=single, vector_entry_point=many, kwargs=arguments, max_episode_steps=cycles)
    _register_with_pettingzoo()
    return tuple(ids)


def _register_with_pettingzoo() -> None:
    """``pettingzoo.make("parallel", "cprm/soccer_v2")``, with PettingZoo 1.27 or newer; older versions say what replaced them."""
    if not hasattr(pettingzoo, "register"):
        return
    for kind, entry in (("parallel", "parallel_env"), ("aec", "env")):
        places = {f"soccer_v{VERSION}": f"soccer_v{VERSION}:{entry}", **{old: f"registration:replaced_{old}" for old in REPLACED}}
        for name, place in places.items():
            env_id = f"{NAMESPACE}/{name}"
            if env_id not in getattr(pettingzoo, f"{kind}_registry"):
                pettingzoo.register(kind, env_id, f"cprm_gym.envs.{place}")


REPLACED = {
    "soccer_v0": "success is each agent's own, infos are numbers, the default actions are discrete (action_mode='hybrid' gives those of "
    "soccer_v0), the default observation is normalised (observation='raw' gives that of soccer_v0)",
    "soccer_v1": "the default observation is normalised (observation='raw' gives that of soccer_v1), and GoToBall pays for coming nearer "
    "(reward='sparse' does not)",
}
"""Older versions, and what differs now."""


def replaced(old: str) -> None:
    """The answer to who asks for an old version.

    Raises
    ------
    ImportError
        Naming the new one.
    """
    raise ImportError(f"{old} has been replaced by soccer_v{VERSION}: {REPLACED[old]}")


def replaced_soccer_v0(**arguments: object) -> None:
    """The answer to ``pettingzoo.make("parallel", "cprm/soccer_v0")``: see `replaced`."""
    replaced("soccer_v0")


def replaced_soccer_v1(**arguments: object) -> None:
    """The answer to ``pettingzoo.make("parallel", "cprm/soccer_v1")``: see `replaced`."""
    replaced("soccer_v1")
