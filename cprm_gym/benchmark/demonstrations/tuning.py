"""Tuning of who plays in a demonstration, everybody by the procedure of `cprm_gym.benchmark.tuning` and in its senses.

``python -m cprm_gym.benchmark.demonstrations.tuning A model tracker rule``
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

from ...agents.skills.constants import STUDIES, Constants, GoalieConstants
from ...envs.tasks import make_task
from ..arguments import at_least
from ..episodes import play_episodes
from ..knowledge import SENSES
from ..tuning import TUNING_SEED, check_search, study
from .arms import ARMS
from .plan import DEMONSTRATIONS, SLOTS


@dataclass(frozen=True)
class ArmSearch:
    """A study of one arm of a demonstration; it begins with the numbers tuned for ``memory`` at default senses.

    Parameters
    ----------
    demonstration, arm : str
    worlds : int
        Per candidate and generation.
    population, elite, generations, seed : int
        As for `cprm_gym.benchmark.tuning.Search`.
    """

    demonstration: str
    arm: str
    worlds: int = 250
    population: int = 12
    elite: int = 4
    generations: int = 4
    seed: int = 0

    def __post_init__(self) -> None:
        check_search(self, worlds=1)

    @property
    def constants(self) -> type[Constants]:
        """What is tuned."""
        return ARMS[self.arm].constants(DEMONSTRATIONS[self.demonstration].task)

    def begin(self) -> GoalieConstants:
        """Where it begins."""
        return ARMS[self.arm].begin(DEMONSTRATIONS[self.demonstration].task)

    def score(self, constants: Constants, generation: int) -> float:
        """Share of a generation's worlds that are saved."""
        one = DEMONSTRATIONS[self.demonstration]
        assert isinstance(constants, GoalieConstants)
        senses = SENSES[one.senses]
        make = ARMS[self.arm].on(senses, constants, one.play)
        seed = TUNING_SEED + 1000 * self.seed + generation
        return float(play_episodes(make_task(one.task), make, self.worlds, seed, senses=senses, slots=SLOTS).success.mean())


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description="Tune who plays in a demonstration.")
    parser.add_argument("demonstration", choices=list(DEMONSTRATIONS))
    parser.add_argument("arms", nargs="+", choices=list(ARMS))
    parser.add_argument("--generations", type=at_least(1), default=4)
    options = parser.parse_args()
    for arm in options.arms:
        place = STUDIES / DEMONSTRATIONS[options.demonstration].study / f"{arm}.jsonl"
        place.parent.mkdir(parents=True, exist_ok=True)
        for found in study(ArmSearch(options.demonstration, arm, generations=options.generations), place):
            print(f"{options.demonstration} {arm} generation {found.number}: middle {found.centre:.4f}, mean {found.rate:.4f}", flush=True)


if __name__ == "__main__":
    main()
