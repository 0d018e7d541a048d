"""What is demonstrated: task and senses, the model, its rivals, and by how much it is to be better."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ...agents.skills.constants import GoalieConstants
from ...envs.tasks import make_task
from ...errors import CprmError, ParameterError, unknown_name
from ...files import write_atomically
from ..episodes import play_episodes
from ..knowledge import SENSES
from ..plan import BLOCK, Block, BlockResult
from .arms import ARMS

EPISODES_TOGETHER = 16 * BLOCK
"""Episodes of a block."""
SLOTS = 250
"""Episodes played side by side."""
SEED = 4001
"""Of the worlds: no study and no learning meets them."""


@dataclass(frozen=True)
class Demonstration:
    """One of them.

    Parameters
    ----------
    title : str
    senses : str
        Of the suite ``knowledge``.
    floors : mapping of str to float
        Rival -> least difference of the model, in points; below 0 how far he may fall behind.
    model : str
        The arm that is the model.
    task : str
    play : str
        Whose learned tables the model has.
    more : tuple of str
        Other arms that play.
    episodes : int
        As many as the floor asks for: 10,000 where it is 2 points or less, else 2000.
    """

    title: str
    senses: str
    floors: Mapping[str, float]
    model: str = "model"
    task: str = "Goalie"
    play: str = "shooter"
    more: tuple[str, ...] = ("state",)
    episodes: int = 10_000

    @property
    def arms(self) -> tuple[str, ...]:
        """The model, its rivals, and the others."""
        return (self.model, *self.floors, *self.more)

    @property
    def study(self) -> str:
        """Folder of the studies in these senses."""
        return f"demonstrations/{self.task}_{self.senses}".replace(" ", "_").replace(".", "")

    def numbers(self, arm: str) -> GoalieConstants:
        """What an arm plays with: of its own study here, or, at default senses, of that of its tier; else those where tuning begins."""
        chosen = ARMS[arm]
        whose, kind = self.model if chosen.lesion else arm, chosen.constants(self.task)
        if whose in kind.studied(self.study):
            return kind.tuned(whose, self.study)
        if (
            self.task == "Goalie"
            and not chosen.expects
            and chosen.tier in GoalieConstants.studied()
            and (self.senses == "default" or chosen.tier == "state")
        ):
            return GoalieConstants.tuned(chosen.tier)
        return chosen.begin(self.task)


BEST_PATTERN = "ahead, wide"
"""The best for these goalies, in worlds that no measurement meets (``python -m cprm_gym.benchmark.demonstrations.patterns``)."""
_NOISY: dict[str, Any] = {"model": "belief, hands", "more": ("rule", "tracker, hands", "state"), "episodes": 2000}
_GAINS: dict[str, Any] = {"floors": {"memory": 2.0, "tracker": 2.0, "rule": 0.0}, "model": "model on belief, hands"}
DEMONSTRATIONS: dict[str, Demonstration] = {
    "A": Demonstration("news of the ball two cycles late", "ball late 2", {"tracker": 9.0, "rule": 2.0},
                       model="model on belief, hands", more=("rule on belief", "model on belief", "model", "memory", "state")),
    "B .5": Demonstration("noise, half", "noise .5", {"tracker": 4.0, "memory": 4.0}, **_NOISY),
    "B 1": Demonstration("noise", "noise 1", {"tracker": 4.0, "memory": 4.0}, **_NOISY),
    "C wide": Demonstration("a look in every third cycle", "wide", **_GAINS),
    "C .3": Demonstration("three looks of ten are lost", "lost .3", **_GAINS),
    "C .6": Demonstration("six looks of ten are lost", "lost .6", **_GAINS),
    "D": Demonstration("an eye with a clock of its own", "asynchronous", {"memory": 6.0, "tracker": 6.0, "rule": 0.0},
                       model="model on belief, hands", more=("model", "state"), episodes=2000),
    "E": Demonstration("the server's own senses", "default", **_GAINS),
    **{
        f"G {task[6:]}": Demonstration(
            f"{task}: what is watched, who has the ball, what he has in mind", "default",
            {"without attention": 3.0, "without possession": 3.0, "without memory": 3.0}, task=task, play="attackers",
            more=("tracker", "memory", "state"), episodes=2000,
        )
        for task in ("Goalie2v1", "Goalie3v2")
    },
    "I": Demonstration("inference every five cycles, five cycles late", "default", {"at once": -10.0, "slow, no reflexes": 25.0},
                       model="slow", more=("no model", "memory", "state"), episodes=2000),
    **{
        f"J {task[6:] or 'alone'}": Demonstration(
            f"{task}: eyes that look where something is to be seen", "default", {BEST_PATTERN: 2.0}, model="looking", task=task,
            more=("tracker", "eyes on the ball, narrow", "state"),
        )
        for task in ("Goalie", "Goalie2v1")
    },
}  # fmt: skip
"""Name -> demonstration."""


@dataclass(frozen=True)
class DemonstrationPlan:
    """What is played.

    Parameters
    ----------
    tasks : tuple of str
        Names of `DEMONSTRATIONS`.
    episodes : int
        Of each arm; 0 as many as are stated.
    seed : int

    Raises
    ------
    UnknownName, ParameterError
        For a demonstration that there is not, none, the same twice, or numbers that make no sense.
    """

    tasks: tuple[str, ...] = tuple(DEMONSTRATIONS)
    episodes: int = 0
    seed: int = SEED

    def __post_init__(self) -> None:
        if not self.tasks:
            raise ParameterError(f"demonstrations: none given; known are {', '.join(DEMONSTRATIONS)}")
        for k, name in enumerate(self.tasks):
            if name not in DEMONSTRATIONS:
                raise unknown_name("demonstration", str(name), list(DEMONSTRATIONS))
            if name in self.tasks[:k]:
                raise ParameterError(f"demonstration {name!r} is named twice")
        for number, value in (("episodes", self.episodes), ("seed", self.seed)):
            if isinstance(value, bool) or not isinstance(value, int) or value < 0:
                raise ParameterError(f"{number}: {value!r} given, a whole number of at least 0 is needed")

    @classmethod
    def quick(cls, seed: int = SEED) -> DemonstrationPlan:
        """A and E, 500 episodes of each arm: a minute."""
        return cls(("A", "E"), 500, seed)

    def blocks(self) -> list[Block]:
        """All blocks, in the order of the report; the controller of a block is ``demonstration/arm``."""
        made = []
        for name in self.tasks:
            one = DEMONSTRATIONS[name]
            count = self.episodes or one.episodes
            made += [
                Block(one.task, f"{name}/{arm}", first, min(EPISODES_TOGETHER, count - first), self.seed)
                for first in range(0, count, EPISODES_TOGETHER)
                for arm in one.arms
            ]
        return made

    @property
    def seconds(self) -> float:
        """CPU time of all of it, about."""
        return sum(b.count / 1000 * COSTS.get(b.controller.rsplit("/", 1)[1], 5.0) for b in self.blocks())

    def constants(self) -> dict[str, dict[str, dict[str, float]]]:
        """What everybody plays with: demonstration -> arm -> name -> number."""
        return {name: {arm: DEMONSTRATIONS[name].numbers(arm).to_dict() for arm in DEMONSTRATIONS[name].arms} for name in self.tasks}

    def write(self, folder: Path) -> None:
        """Note in the folder of a run what is to be played there (``plan.json``)."""
        data = {"suite": "demonstrations", **asdict(self), "constants": self.constants()}
        write_atomically(folder / "plan.json", json.dumps(data, indent=2) + "\n")

    @classmethod
    def read(cls, folder: Path) -> DemonstrationPlan:
        """The plan noted by `write`.

        Raises
        ------
        CprmError
            When there is none, it is of something else, or the constants are others by now.
        """
        path = folder / "plan.json"
        try:
            data: Any = json.loads(path.read_text(encoding="utf-8"))
            if data["suite"] != "demonstrations":
                raise ValueError("of another suite")
            plan = cls(tuple(data["tasks"]), data["episodes"], data["seed"])
        except (OSError, KeyError, ValueError, TypeError, AttributeError, RecursionError) as error:
            raise CprmError(f"{path}: not the plan of a run of the suite 'demonstrations': {error}") from None
        if data.get("constants") != plan.constants():
            raise CprmError(f"{path}: the constants are others by now; begin anew without --resume")
        return plan


COSTS = {"slow": 15.0, "slow, no reflexes": 15.0, "at once": 8.0, "memory": 2.5, "tracker": 3.0, "rule": 3.5, "state": 2.5, "belief": 4.5}
"""CPU seconds of 1000 episodes, about; of the model's arms 5."""


def play_block(block: Block, _: float = math.inf) -> BlockResult:
    """Play the episodes of one block; its players are ours, and no decision of theirs is timed."""
    name, arm = block.controller.rsplit("/", 1)
    one = DEMONSTRATIONS[name]
    senses = SENSES[one.senses]
    begin, spent = time.perf_counter(), time.process_time()
    make = ARMS[arm].on(senses, one.numbers(arm), one.play)
    found = play_episodes(make_task(one.task), make, block.count, block.seed, block.first, senses, SLOTS)
    played = int(found.cycles.max()) * block.count
    return BlockResult(
        block, found.success.tolist(), found.cycles.tolist(), found.success.astype(float).tolist(),
        wall_seconds=time.perf_counter() - begin, controller_seconds=time.process_time() - spent, decisions=played, played=played,
    )  # fmt: skip
