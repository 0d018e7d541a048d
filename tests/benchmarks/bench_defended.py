"""The striker against one medium defender: his sequence, an attacker who decides anew with every kick, and what that one knows.

python tests/benchmarks/bench_defended.py [episodes]
"""

from __future__ import annotations

import sys

from cprm_gym.agents.attacker.agent import make_controller as attack
from cprm_gym.agents.body import Body
from cprm_gym.agents.knowledge.registry import informed
from cprm_gym.agents.percepts import field_percepts
from cprm_gym.agents.play import SoccerAgent
from cprm_gym.agents.striker import striker_cprm
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.statistics import paired_difference, wilson_interval
from cprm_gym.envs.tasks import Task, make_task

SEED = 4005


def sequence(task: Task, agent: str) -> SoccerAgent:
    """The striker as he plays without opponents."""
    body = Body.of(task)
    return SoccerAgent(striker_cprm(body), field_percepts, needs=("memory",), body=body)


def main(episodes: int) -> None:
    """The table: success, and in pairs the attacker on ``belief`` less each."""
    task = make_task("KickOffShot", right=1, others="medium")
    found = {}
    for name, make, tier in (("attacker", attack, "belief"), ("attacker", attack, "memory"), ("attacker", attack, "tracker"),
                             ("attacker", attack, "state"), ("sequence", sequence, "memory")):  # fmt: skip
        good = found[name, tier] = play_episodes(task, informed(make, tier), episodes, SEED, slots=100).success
        low, high = wilson_interval(int(good.sum()), episodes)
        mean, least, most, _ = paired_difference(found["attacker", "belief"], good)
        print(f"{name:10} {tier:8} {good.mean():.3f} [{low:.3f}, {high:.3f}]  {mean:+.3f} [{least:+.3f}, {most:+.3f}]", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
