"""Saves and speed of the goalies on the same shots, worlds that were not used to tune them.

python tests/benchmarks/bench_goalie.py [episodes]
python tests/benchmarks/bench_goalie.py EPISODES variants     what attention and how often he infers change, rates alone
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from cprm_baselines.goalie_memory import MemoryGoalie
from cprm_baselines.goalie_raw import RawGoalie
from cprm_baselines.scripted import ScriptedController
from cpu_time import timed

from cprm_gym.agents.goalie import GoalieAgent
from cprm_gym.agents.knowledge import Informed
from cprm_gym.agents.registry import make_controller
from cprm_gym.agents.skills.constants import GoalieConstants
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.statistics import paired_difference, wilson_interval
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.pitch import Pitch
from cprm_gym.envs.tasks.base import Status
from cprm_gym.envs.tasks.goalie import Goalie

SEED, BLOCK = 2026, 250


@dataclass(frozen=True)
class CrowdedGoalie(Goalie):
    """The task with eleven opponents, nine more somewhere in the goalie's half, for six seconds."""

    right: int = 11
    max_cycles: int = 60

    def setup(self, core: Pitch, worlds: np.ndarray) -> None:
        """Shot or shooter, and the others at random places at least 12 m in front of the goal line."""
        super().setup(core, worlds)
        u = core.draw(worlds, 2 * (self.right - 2))
        for k in range(self.right - 2):
            core.place_player(14 + k, -40.0 + 40.0 * u[:, 2 * k], 56.0 * u[:, 2 * k + 1] - 28.0, np.pi, worlds=worlds)


def play(make: Any, task: Goalie, episodes: int) -> dict[str, Any]:
    """Whether each episode went without a goal, and CPU milliseconds of a decision and of its inference."""
    saved, shot, spent, inferring, decisions = [], [], 0.0, [0.0], 0
    for first in range(0, episodes, BLOCK):
        count = min(BLOCK, episodes - first)
        agent = make(task)
        core = SoccerCore(task, count, seed=SEED, first_world=first, include=agent.needs)
        observation = {key: value[:, 0] for key, value in core.reset(SEED).items()}
        shot.append(core.sim.world["vel"][:, 0].any(axis=1))
        agent.reset(observation, 0)
        if isinstance(agent, Informed):
            agent.tier.know = timed(agent.tier.know, inferring)
        elif hasattr(agent, "controller") and agent.controller.bank is not None:
            agent.controller._infer = timed(agent.controller._infer, inferring)
        running, clean = np.ones(count, bool), np.ones(count, bool)
        while running.any():
            start = time.process_time()
            action = agent.act(observation)
            spent += time.process_time() - start
            decisions += count
            step = core.step({key: np.asarray(value)[:, None] for key, value in action.items()})
            clean &= ~(running & (step.status == Status.GOAL))
            running &= ~(step.terminated | step.truncated)
        saved.append(clean)
    return {"saved": np.concatenate(saved), "shot": np.concatenate(shot), "ms": 1e3 * spent / decisions,
            "inference": 1e3 * inferring[0] / decisions}  # fmt: skip


def single(make: Any, task: Goalie, cycles: int = 300) -> tuple[float, float]:
    """Median and 99th percentile of the CPU milliseconds of one decision of one goalie."""
    agent = make(task)
    core = SoccerCore(task, 1, seed=SEED, include=agent.needs)
    observation = {key: value[:, 0] for key, value in core.reset(SEED).items()}
    agent.reset(observation, 0)
    times = []
    for _ in range(cycles):
        start = time.process_time()
        action = agent.act(observation)
        times.append(1e3 * (time.process_time() - start))
        step = core.step({key: np.asarray(value)[:, None] for key, value in action.items()})
        if step.terminated[0] or step.truncated[0]:
            core.reset()
            agent.reset(observation, 0, np.ones(1, bool))
    return float(np.median(times[20:])), float(np.percentile(times[20:], 99))


def show(name: str, result: dict[str, Any]) -> None:
    """A line of the table."""
    saved, shot = result["saved"], result["shot"]
    low, high = wilson_interval(int(saved.sum()), len(saved))
    parts = f"shots {saved[shot].mean():.3f}  shooters {saved[~shot].mean():.3f}"
    speed = f"{result['ms']:.3f} ms, inference {result['inference']:.3f} ms"
    print(f"{name:34s}{saved.mean():.3f} [{low:.3f}, {high:.3f}]  {parts}  {speed}", flush=True)


def compare(name: str, a: dict[str, Any], b: dict[str, Any]) -> None:
    """Difference of the rates of two goalies on the same worlds, with the normal interval of the paired differences."""
    d = a["saved"].astype(float) - b["saved"]
    half = 1.96 * d.std(ddof=1) / len(d) ** 0.5
    print(f"  {name:32s}{d.mean():+.3f} [{d.mean() - half:+.3f}, {d.mean() + half:+.3f}]", flush=True)


def main(episodes: int) -> None:
    """Print the tables."""
    task = Goalie()
    print(
        f"{episodes} episodes, default noise, same worlds: rate without a goal, 95 % Wilson interval, CPU per decision (batches of {BLOCK})"
    )
    belief = play(lambda t: make_controller(t, "left_1"), task, episodes)
    show("CPRM goalie, on the belief", belief)
    cprm = play(lambda t: GoalieAgent(t.right), task, episodes)
    show("CPRM goalie, model on bins", cprm)
    tuned = play(lambda t: MemoryGoalie(t.right, constants=GoalieConstants.tuned("memory")), task, episodes)
    show("same net on the memory, tuned", tuned)
    memory = play(lambda t: MemoryGoalie(t.right), task, episodes)
    show("same net on the memory", memory)
    raw = play(lambda t: RawGoalie(t.right), task, episodes)
    show("same net on raw readings", raw)
    scripted = play(lambda t: ScriptedController(t, "left_1"), task, episodes)
    show("scripted keeper (strong)", scripted)
    compare("belief - bins", belief, cprm)
    compare("belief - memory, tuned", belief, tuned)
    compare("belief - memory", belief, memory)
    compare("bins - memory", cprm, memory)
    compare("bins - raw", cprm, raw)
    compare("bins - scripted", cprm, scripted)
    for name, make in (("belief", lambda t: make_controller(t, "left_1")), ("bins", lambda t: GoalieAgent(t.right))):
        median, worst = single(make, task)
        print(f"one decision alone, {name}: median {median:.2f} ms, 99 % {worst:.2f} ms CPU")
    crowd = CrowdedGoalie()
    print("eleven opponents")
    two = play(lambda t: GoalieAgent(t.right, 2), crowd, episodes)
    show("two watched", two)
    everyone = play(lambda t: GoalieAgent(t.right, t.right), crowd, episodes)
    show("all watched", everyone)
    compare("two - all", two, everyone)
    print(f"  inference with two watched takes {two['inference'] / everyone['inference']:.2f} of that with all")


def variants(episodes: int) -> None:
    """Rates of the goalie with his model as it is, with nobody attended to, and with inference in every 2nd, 5th and 10th cycle alone."""

    def make(attended: int, period: int) -> Any:
        return GoalieAgent(2, attended, t_b=period)

    found = {}
    for name, attended, period in (("as it is", 2, 1), ("nobody attended", 0, 1), *((f"t_B = {k}", 2, k) for k in (2, 5, 10))):
        found[name] = play_episodes(Goalie(), lambda task, agent: make(attended, period), episodes, SEED).success  # noqa: B023
        low, high = wilson_interval(int(found[name].sum()), episodes)
        mean, least, most, _ = paired_difference(found[name], found["as it is"])
        print(f"{name:18s}{found[name].mean():.3f} [{low:.3f}, {high:.3f}]  {mean:+.3f} [{least:+.3f}, {most:+.3f}]", flush=True)


if __name__ == "__main__":
    if sys.argv[2:] == ["variants"]:
        variants(int(sys.argv[1]))
        sys.exit()
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
