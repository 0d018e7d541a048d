"""How well every skill does alone (`cprm_gym.agents.worlds.trials`).

``python -m cprm_gym.benchmark.skills --episodes 1000`` prints the table.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

import numpy as np

from ..agents.body import Body
from ..agents.worlds.trials import SETTLE, TRIALS, StageTask, before_kick_off
from ..envs.core import SoccerCore
from ..envs.tasks import make_task
from ..simulator.parameters import Rules, ServerParameters
from .arguments import at_least
from .statistics import wilson_interval


def measure(
    name: str, episodes: int = 1000, seed: int = 0, parameters: ServerParameters | None = None, body: Body | None = None
) -> tuple[int, float]:
    """(successes, mean cycles to the outcome) of a skill alone; success is its outcome *and* the judgement of the world.

    Parameters
    ----------
    name : str
        Of `TRIALS`.
    episodes, seed : int
    parameters : ServerParameters, optional
        Of the world; the server's defaults if not given.
    body : Body, optional
        What the player takes himself to be; what he is in that world if not given.
    """
    trial = TRIALS[name]
    rules = Rules.CATCH if trial.goalie else Rules.NONE
    stage = StageTask(name="stage", left=2, left_goalie=int(trial.goalie), start=trial.start, rules=rules)
    task = make_task("KickOffShot") if trial.start is before_kick_off else stage
    task = replace(task, max_cycles=10_000, others="hold", parameters=parameters or task.parameters)
    core = SoccerCore(task, episodes, seed=seed, include=("memory",))
    observation = core.reset(seed)
    agent = trial.agent(name, body or Body.of(task))
    agent.reset({k: v[:, 0] for k, v in observation.items()}, seed)
    ended, good = np.full(episodes, -1), np.zeros(episodes, bool)
    for cycle in range(trial.cycles + trial.wait):
        action: dict[str, Any] = agent.act({k: v[:, 0] for k, v in observation.items()})
        assert agent.controller is not None
        fresh = (agent.controller.executor.read("done") > 0) & (ended < 0)
        ended[fresh] = cycle
        due = (ended >= 0) & (cycle - ended <= trial.wait) if trial.any_time else ended + trial.wait == cycle
        good |= due & (ended >= 0) & trial.judge(core)
        core.step({k: np.asarray(v)[:, None] for k, v in action.items()})
    return int(good.sum()), float((ended[ended >= 0] - SETTLE).mean()) if (ended >= 0).any() else float("nan")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Success of every skill alone.")
    parser.add_argument("--episodes", type=at_least(1), default=1000)
    parser.add_argument("--seed", type=at_least(0), default=0)
    options = parser.parse_args()
    print(f"{'skill':12}{'success (Wilson 95 %)':28}{'cycles':>8}  criterion")
    for name, trial in TRIALS.items():
        good, cycles = measure(name, options.episodes, options.seed)
        low, high = wilson_interval(good, options.episodes)
        print(f"{name:12}{good / options.episodes:6.1%} [{low:.1%}, {high:.1%}]{'':6}{cycles:8.1f}  {trial.criterion}", flush=True)


if __name__ == "__main__":
    main()
