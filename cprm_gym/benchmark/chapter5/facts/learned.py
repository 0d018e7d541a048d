"""What a policy that was trained took and reached, as the record that comes with it says."""

from __future__ import annotations

from typing import Any

from ....envs.tasks import make_task
from ..conditions import Condition
from ..players import make_player


def record(task: str, player: str, seed: int) -> dict[str, Any]:
    """Experience, curve and size of the policy with which a controller plays a task.

    Parameters
    ----------
    task : str
    player : str
        A controller with a ``policy``.
    seed : int
        Not used: nothing here is drawn.

    Returns
    -------
    dict
        ``algorithm``, ``mode`` (what it chooses), ``seed`` of the training that is kept, ``curve`` (agent-steps, success drawing actions
        and taking the likeliest), ``weights`` and ``inputs`` of its network, ``command`` that trains it.
    """
    made: Any = make_player(player, Condition())(make_task(task), "left_1")
    told = made.policy.description
    return {
        "algorithm": told.algorithm, "mode": told.mode, "seed": told.seed, "curve": [list(entry) for entry in told.curve],
        "weights": sum(int(values.size) for values in made.policy.arrays.values()), "inputs": len(told.columns), "command": told.command,
    }  # fmt: skip
