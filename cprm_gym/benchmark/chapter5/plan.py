"""What the suite is to measure, how long that takes, and the folder that it is kept in."""

from __future__ import annotations

import json
from collections.abc import Collection
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from ...agents.knowledge.players import PLAYERS
from ...errors import CprmError, ParameterError, unknown_name
from ...files import write_atomically
from ..plan import Block
from .about import revision
from .cells import FACT, FULL, QUICK, Cell, Size, Wanted, blocks_of
from .experiments import EXPERIMENTS
from .facts import ANALYSIS, CONCURRENCY

SUITE = "chapter5"
SECONDS = {
    "GoToBall": 1.0, "LostAndFound": 0.6, "Hike": 1.0, "KickOffShot": 6.5, "KickOffShot2v2": 17.0, "Goalie": 2.1, "Goalie2v1": 4.0,
    "Goalie3v2": 4.0, "PassAndAdvance": 28.0, "PassAndAdvance2v1": 20.0, "PassAndAdvance2v2": 30.0, "PassAndAdvance2v3": 50.0,
    "Keepaway3v2": 34.0, "Keepaway4v3": 43.0, "Keepaway5v4": 44.0, "HFO1v0": 2.4, "HFO1v1": 4.0, "HFO2v1": 8.0, "HFO2v2": 15.0,
    "HFO3v2": 21.0, "HFO3v3": 31.0, "HFO4v5": 50.0, "FrontGoalEmptyGoal": 1.2, "FrontGoalBlockedShot": 1.5,
    "FrontGoalSupportOption": 4.0, "FrontGoalPassingLane": 10.5, "FrontGoalCompactDefense": 18.0,
    "Soccer5v5": 75.0, "Soccer11v11": 250.0,
}  # fmt: skip
"""CPU time of 1000 episodes of a structure on dead reckoning, about, as a full run measured it; of other tasks `OTHER`."""
OTHER = 3.0
DEARER = {
    "reflexes": 6.0, " on belief": 5.0, "cprm": 1.8, "behavior_tree": 2.3, " on ": 1.3, "scripted": 0.35, "random": 0.35, "eased": 0.35,
}  # fmt: skip
"""By what a player's name holds: how much dearer than a structure on dead reckoning."""
FACT_SECONDS = {ANALYSIS: 3.0, CONCURRENCY: 1.0}


@dataclass(frozen=True)
class Chapter5Plan:
    """What is measured.

    Parameters
    ----------
    experiments : tuple of str
        Names of `EXPERIMENTS`.
    size : Size
    seed : int

    Raises
    ------
    UnknownName
        For an experiment that there is not; the message lists those that there are.
    ParameterError
        For none, one named twice, or numbers that make no sense.
    """

    experiments: tuple[str, ...] = tuple(EXPERIMENTS)
    size: Size = FULL
    seed: int = 0

    def __post_init__(self) -> None:
        if not self.experiments:
            raise ParameterError(f"experiments: none given; known are {', '.join(EXPERIMENTS)}")
        for k, name in enumerate(self.experiments):
            if name not in EXPERIMENTS:
                raise unknown_name("experiment", str(name), list(EXPERIMENTS))
            if name in self.experiments[:k]:
                raise ParameterError(f"experiment {name!r} is named twice")
        for number, value, least in (("episodes", self.size.table, 2), ("episodes", self.size.curve, 2), ("seed", self.seed, 0)):
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise ParameterError(f"{number}: {value!r} given, a whole number of at least {least} is needed")

    @classmethod
    def quick(cls) -> Chapter5Plan:
        """All nine in small: two minutes or three."""
        return cls(size=QUICK)

    def at_most(self, episodes: int) -> Chapter5Plan:
        """The same with at most so many episodes in a cell."""
        size = self.size
        return replace(self, size=replace(size, table=min(size.table, episodes), curve=min(size.curve, episodes)))

    def wanted(self) -> list[Wanted]:
        """What all experiments ask for."""
        return [one for name in self.experiments for one in EXPERIMENTS[name].wanted(self.size)]

    def blocks(self) -> list[Block]:
        """All blocks; a cell that several experiments ask for stands there once."""
        return blocks_of(self.wanted(), self.seed)

    @property
    def seconds(self) -> float:
        """CPU time of all of it, about."""
        return sum(seconds_of(block) for block in self.blocks())

    def write(self, folder: Path) -> None:
        """Note in the folder of a run what is to be played there (``plan.json``)."""
        noted = {"suite": SUITE, **asdict(self), "constants": _constants(), "version": revision()}
        write_atomically(folder / "plan.json", json.dumps(noted, indent=2) + "\n")

    @classmethod
    def read(cls, folder: Path, tasks: Collection[str] | None = None) -> Chapter5Plan:
        """The plan noted by `write`.

        Parameters
        ----------
        folder : Path
        tasks : collection of str, optional
            Those whose players have to have the numbers of then; all if not given.

        Raises
        ------
        CprmError
            When there is none, it is of something else, or the players' numbers are others by now.
        """
        path = folder / "plan.json"
        try:
            data: Any = json.loads(path.read_text(encoding="utf-8"))
            if data["suite"] != SUITE:
                raise ValueError("of another suite")
            plan = cls(tuple(data["experiments"]), Size(**data["size"]), data["seed"])
        except (OSError, KeyError, ValueError, TypeError, AttributeError, RecursionError) as error:
            raise CprmError(f"{path}: not the plan of a run of the suite {SUITE!r}: {error}") from None
        then, now = data.get("constants"), _constants()
        if tasks is None:
            same = then == now
        else:
            same = isinstance(then, dict) and all(then.get(task) == now.get(task) for task in tasks)
        if not same:
            raise CprmError(f"{path}: the constants of the players are others by now; begin anew without --resume")
        return plan


def version_of(folder: Path) -> str:
    """With which version the run in a folder was begun; empty where that is not noted."""
    try:
        return str(json.loads((folder / "plan.json").read_text(encoding="utf-8")).get("version", ""))
    except (OSError, ValueError, AttributeError, RecursionError):
        return ""


def seconds_of(block: Block) -> float:
    """CPU time of a block, about."""
    cell = Cell.of(block)
    if block.count == FACT:
        return FACT_SECONDS.get(cell.condition, 0.5)
    dearer = max((factor for word, factor in DEARER.items() if word in cell.player), default=1.0)
    return block.count / 1000 * SECONDS.get(cell.task, OTHER) * dearer


def _constants() -> dict[str, dict[str, float]]:
    """The numbers that the players of tasks have on the memory."""
    found = {task: player.numbers("memory") for task, player in PLAYERS.items()}
    return {task: {} if numbers is None else numbers.to_dict() for task, numbers in found.items()}
