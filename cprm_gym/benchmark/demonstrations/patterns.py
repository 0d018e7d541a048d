"""Which fixed pattern of neck and width is best for a goalie.

``python -m cprm_gym.benchmark.demonstrations.patterns --task Goalie`` tells how well he does with each on the tier ``tracker``, in worlds
that no measurement meets.
"""

from __future__ import annotations

import argparse

from ...envs.players.senses import Senses
from ...envs.tasks import make_task
from ..arguments import at_least
from ..episodes import play_episodes
from ..tuning import TUNING_SEED
from .arms import ARMS
from .looking import PATTERNS


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description="Fixed patterns of neck and width, in worlds that no measurement meets.")
    parser.add_argument("--task", choices=("Goalie", "Goalie2v1", "Goalie3v2"), default="Goalie")
    parser.add_argument("--episodes", type=at_least(1), default=300)
    options = parser.parse_args()
    task, seed = make_task(options.task), TUNING_SEED + 500
    for name in PATTERNS:
        arm = ARMS[name]
        make = arm.on(Senses(), arm.begin(options.task))
        print(f"{name:20} {play_episodes(task, make, options.episodes, seed, slots=250).success.mean():6.1%}", flush=True)


if __name__ == "__main__":
    main()
