"""Goalies on the belief who catch by how likely their hands are to take the ball, less the same who catch by where it is expected.

python tests/benchmarks/bench_hands.py EPISODES SEED TASK SENSES,SENSES,...
"""

from __future__ import annotations

import sys

from cprm_gym.agents.knowledge.players import PLAYERS
from cprm_gym.agents.skills.constants import Constants
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.knowledge import SENSES
from cprm_gym.benchmark.statistics import paired_difference
from cprm_gym.envs.tasks import make_task

TIER = "belief"


def without(task: str, senses: str) -> Constants:
    """The numbers of the goalie of a task but for those by which he judges his hands."""
    player = PLAYERS[task]
    numbers, kind = player.numbers(TIER, SENSES[senses]), player.constants
    assert numbers is not None
    assert kind is not None
    return kind.of({name: value for name, value in numbers.to_dict().items() if name in kind.extents()})


def main(episodes: int, seed: int, task: str, senses: str) -> None:
    """Play both in the same worlds, in one sense after the other."""
    for name in senses.split(","):
        made, told = make_task(task), SENSES[name]
        by_chance, by_place = (
            play_episodes(made, PLAYERS[task].on(TIER, told, numbers), episodes, seed, senses=told, slots=250)
            for numbers in (None, without(task, name))
        )
        less = paired_difference(by_chance.success, by_place.success)
        spent = [1e6 * played.seconds / played.decisions for played in (by_chance, by_place)]
        print(
            f"{task}, {name}: {by_chance.success.mean():.1%} and {by_place.success.mean():.1%}, "
            f"{100 * less.mean:+.1f} ({100 * less.low:+.1f}, {100 * less.high:+.1f}); us a decision {spent[0]:.0f} and {spent[1]:.0f}",
            flush=True,
        )


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3], sys.argv[4])
