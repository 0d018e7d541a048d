"""A round robin: who meets whom, played in blocks that a journal keeps, and the table that comes of it."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from ...envs.core import SoccerCore
from ...envs.others.registry import other_player
from ...errors import ControllerError, CprmError, ParameterError
from ...files import write_atomically
from ..plan import Block, BlockResult, read_plan, write_plan
from .families import Family, family
from .rating import Ratings, rate

AGAINST = " against "
BLOCK = 50
"""Games played as one batch."""


@dataclass(frozen=True)
class LadderPlan:
    """A round robin of one family.

    Attributes
    ----------
    family : str
    games : int
        Of each pair on each side.
    seed : int
        All pairs meet in the same worlds.
    more : tuple of str
        Further players, on the side that learners meet: controllers by name, policies.
    rivals : tuple of str
        Further players on the other side, such as learned attackers; where the sides are alike, `more` are on both.
    held_out : bool
        Whether the opponents for testing play, too.

    Raises
    ------
    UnknownName
        For a family or player that does not exist.
    ParameterError
        For a number that makes no sense, or a player named twice.
    """

    family: str = "soccer"
    games: int = 50
    seed: int = 0
    more: tuple[str, ...] = ()
    rivals: tuple[str, ...] = ()
    held_out: bool = True

    def __post_init__(self) -> None:
        family(self.family)
        for number, value, least in (("games", self.games, 1), ("seed", self.seed, 0)):
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise ParameterError(f"{number}: {value!r} given, a whole number of at least {least} is needed")
        if self.rivals and self.chosen.alike:
            raise ParameterError(f"rivals: the sides of {self.family!r} are alike; name them among the further players")
        for players in self.sides():
            for i, name in enumerate(players):
                other_player(name)
                if name in players[:i]:
                    raise ParameterError(f"player {name!r} is on the ladder twice")

    @property
    def chosen(self) -> Family:
        """The family."""
        return family(self.family)

    def sides(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Who plays on the left and on the right."""
        f = self.chosen
        opponents = f.right + (f.held_out if self.held_out else ()) + self.more
        return (opponents if f.alike else f.left + self.rivals), opponents

    def blocks(self) -> list[Block]:
        """All games, pair by pair."""
        left, right = self.sides()
        return [
            Block(self.family, f"{a}{AGAINST}{b}", first, min(BLOCK, self.games - first), self.seed)
            for a in left
            for b in right
            if not (self.chosen.alike and a == b)
            for first in range(0, self.games, BLOCK)
        ]

    def write(self, folder: Path) -> None:
        """Note in the folder what is to be played there (``plan.json``)."""
        write_plan(self, folder)

    @classmethod
    def read(cls, folder: Path) -> LadderPlan:
        """The plan noted by `write`.

        Raises
        ------
        CprmError
            When there is none, or it cannot be read.
        """
        return read_plan(cls, folder, "round robin")


def play_games(block: Block, timeout: float) -> BlockResult:
    """The games of a block: ``reward`` is what the left side has of each (1, 0.5 or 0), ``success`` whether it won.

    Parameters
    ----------
    block : Block
    timeout : float
        Has no meaning here: the time of a decision is not watched.
    """
    chosen, started = family(block.task), time.perf_counter()
    left, right = block.controller.split(AGAINST)
    core = SoccerCore(chosen.task(), block.count, controlled=(), others=(left, right), first_world=block.first)
    core.reset(block.seed)
    running, score, cycles = np.ones(block.count, bool), np.zeros(block.count), np.zeros(block.count, np.int64)
    played = 0
    try:
        while running.any():
            step = core.step(None)
            cycles += running
            played += block.count
            ended = running & (step.terminated | step.truncated)
            if ended.any():
                score[ended] = chosen.score(core, step.status)[ended]
                running &= ~ended
    except ControllerError as error:
        return BlockResult(block, error=str(error))
    wall = time.perf_counter() - started
    return BlockResult(block, (score == 1.0).tolist(), cycles.tolist(), score.tolist(), None, wall, 0.0, 0, played)


@dataclass(frozen=True)
class Standing:
    """One player on a ladder."""

    side: str
    """``left``, ``right``, or ``either``."""
    player: str
    elo: float
    low: float
    high: float
    score: float
    """Share of the points of his games."""
    games: int
    held_out: bool


def standings(plan: LadderPlan, results: Iterable[BlockResult]) -> tuple[list[Standing], Ratings]:
    """The ladder from the games: who is better stands higher.

    Raises
    ------
    CprmError
        When no game was played, or a player made an error; the message says which.
    """
    f = plan.chosen
    left, right = plan.sides()
    names = [("either", name) for name in right] if f.alike else [("left", n) for n in left] + [("right", n) for n in right]
    index = {entry: k for k, entry in enumerate(names)}
    won, played = np.zeros((len(names), len(names))), np.zeros((len(names), len(names)))
    for result in results:
        if result.error is not None:
            raise CprmError(f"{result.block.controller}: {result.error}")
        a, b = result.block.controller.split(AGAINST)
        i, j = (index["either", a], index["either", b]) if f.alike else (index["left", a], index["right", b])
        won[i, j] += sum(result.reward)
        played[i, j] += len(result.reward)
    if not played.sum():
        raise CprmError("ladder: no game has been played")
    ratings = rate(won, played, advantage=f.alike)
    points = won.sum(axis=1) + (played - won).sum(axis=0)
    games = played.sum(axis=1) + played.sum(axis=0)
    table = [
        Standing(side, name, float(ratings.points[k]), float(ratings.low[k]), float(ratings.high[k]),
                 float(points[k] / games[k]) if games[k] else 0.0, int(games[k]), side != "left" and name in f.held_out)
        for k, (side, name) in enumerate(names)
    ]  # fmt: skip
    return sorted(table, key=lambda s: (s.side, -s.elo)), ratings


def report(plan: LadderPlan, table: list[Standing], ratings: Ratings) -> str:
    """The ladder as a Markdown page."""
    f = plan.chosen
    pairs = f"{plan.games} games of each pair{' on each side' if f.alike else ''} of {f.game}, seed {plan.seed}."
    side = f" The left side's advantage: {ratings.advantage:+.0f}." if f.alike else ""
    lines = [f"# Ladder: {plan.family}", "", f"{pairs} Elo by maximum likelihood, 1000 the mean; 95 % intervals.{side}", ""]
    lines += ["| side | player | Elo | 95 % | score | games | |", "|---|---|---:|---|---:|---:|---|"]
    lines += [
        f"| {s.side} | `{s.player}` | {s.elo:.0f} | {s.low:.0f} to {s.high:.0f} | {100 * s.score:.1f} % | {s.games} | "
        f"{'held out' if s.held_out else ''} |"
        for s in table
    ]
    return "\n".join(lines) + "\n"


def save(folder: Path, plan: LadderPlan, table: list[Standing], ratings: Ratings) -> None:
    """``ladder.json`` and ``ladder.md`` in the folder of a round robin."""
    data = {"plan": asdict(plan), "advantage": ratings.advantage, "standings": [asdict(s) for s in table]}
    write_atomically(folder / "ladder.json", json.dumps(data, indent=2) + "\n")
    write_atomically(folder / "ladder.md", report(plan, table, ratings))
