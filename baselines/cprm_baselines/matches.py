"""Matches between teams, scripted ones and controllers: who wins, and what happens on the way.

python -m cprm_baselines.matches                                  strong against weak, 40 matches of eleven a side
python -m cprm_baselines.matches --left strong --right strong
python -m cprm_baselines.matches --task Soccer5v5 --left cprm --right strong --seconds 150
"""

from __future__ import annotations

import argparse
from typing import NamedTuple

import numpy as np

from cprm_gym.benchmark.arguments import at_least
from cprm_gym.benchmark.statistics import wilson_interval
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.simulator.state import PlayMode


class Matches(NamedTuple):
    """What became of a number of matches."""

    score: np.ndarray
    """(matches, 2) goals of left and right."""
    finished: np.ndarray
    """(matches,) bool: the referee ended it."""
    begun: dict[str, int]
    """How often each play mode began, over all matches."""
    longest: int
    """Most cycles in a row that any match spent in one mode other than play_on."""

    @property
    def won(self) -> np.ndarray:
        """(matches,) bool: the left team scored more."""
        return np.asarray(self.score[:, 0] > self.score[:, 1])


def play_matches(left: str, right: str, matches: int, seed: int = 0, task: str = "Soccer11v11", cycles: int = 9000) -> Matches:
    """Play matches, all at once.

    Parameters
    ----------
    left, right : str
        Scripted policies or controllers, who play the teams.
    matches : int
    seed : int
    task : str
        ``Soccer5v5``, ``Soccer11v11``.
    cycles : int
        After so many a match is over, whatever the referee says; a whole one with extra time and penalties takes fewer than the default.
    """
    core = SoccerCore(make_task(task, max_cycles=cycles), matches, controlled=(), others=(left, right))
    core.reset(seed)
    world = core.sim.world
    score, finished = np.zeros((matches, 2), np.int64), np.zeros(matches, bool)
    last, standing, longest = world["mode"].copy(), np.zeros(matches, np.int64), 0
    begun = np.zeros(len(PlayMode), np.int64)
    for _ in range(core.task.max_cycles):
        step = core.step(None)
        mode = world["mode"]
        changed = (mode != last) & ~finished
        np.add.at(begun, mode[changed], 1)
        standing = np.where(changed | (mode == PlayMode.play_on) | finished, 0, standing + 1)
        longest = max(longest, int(standing.max()))
        score[~finished] = world["score"][~finished]
        finished |= step.terminated
        last = mode.copy()
        if finished.all():
            break
    return Matches(score, finished, {PlayMode(i).name: int(n) for i, n in enumerate(begun) if n}, longest)


def main() -> None:
    """Play and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", default="Soccer11v11")
    parser.add_argument("--seconds", type=at_least(1), default=900, help="after which a match is over; whole ones if not given")
    parser.add_argument("--left", default="strong")
    parser.add_argument("--right", default="weak")
    parser.add_argument("--matches", type=at_least(1), default=40)
    parser.add_argument("--seed", type=at_least(0), default=0)
    arguments = parser.parse_args()
    m = play_matches(arguments.left, arguments.right, arguments.matches, arguments.seed, arguments.task, 10 * arguments.seconds)
    drawn = int((m.score[:, 0] == m.score[:, 1]).sum())
    won = int(m.won.sum())
    print(f"{arguments.left} against {arguments.right}: {won} won, {drawn} drawn, {len(m.score) - won - drawn} lost of {len(m.score)}")
    interval = wilson_interval(won, len(m.score))
    print(f"won {100 * won / len(m.score):.0f} % ({100 * interval.low:.0f} - {100 * interval.high:.0f})")
    print(f"goals per match {m.score[:, 0].mean():.1f} : {m.score[:, 1].mean():.1f}; ended by the referee {int(m.finished.sum())}")
    print(f"longest stoppage {m.longest} cycles")
    for name, count in sorted(m.begun.items(), key=lambda item: -item[1]):
        print(f"  {name:24s} {count / len(m.score):6.2f} per match")


if __name__ == "__main__":
    main()
