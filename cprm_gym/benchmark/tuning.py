"""The one procedure by which a player's constants are tuned for a tier of knowledge, journalled.

``cprm-gym tune --task Goalie --tier memory`` goes on where it was interrupted. In each generation candidates are drawn from a normal
distribution, all play the same worlds, which no other generation and no measurement meets, and the best of them move the distribution: as
the library cmaes does it, or, as in all studies before December 2026, by the cross-entropy method (`METHODS`). The studies whose results
are used stand in ``cprm_gym/agents/studies``.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from ..agents.knowledge.players import TEAMS, Player, player_of
from ..agents.skills.constants import Constants
from ..envs.core import SoccerCore
from ..envs.players.senses import Senses
from ..envs.tasks import Task, make_task
from ..errors import CprmError, ParameterError, unknown_name
from .episodes import play_episodes

TUNING_SEED = 800_000
"""Seeds from here on are those of tuning; measurements take small ones."""
CHECK_SEED = 700_001
"""Of the worlds in which what a study found is played beside what was set by hand."""
NORMAL = 1.96
"""Standard errors of a 95 % interval."""
KEPT = 0.3
"""Share of the old distribution that remains."""
WIDEST = 0.125
"""Of the extent: the standard deviation with which a study begins, about the constants set by hand."""
NARROWEST = 0.02
"""Of the extent: the least standard deviation."""
LATER = {"others": "", "side": "left", "method": "cross-entropy"}
"""Fields of a plan that stand in a journal only where they differ from this."""
SLOTS = 250
"""Most worlds that are played side by side."""


class Search(Protocol):
    """What a study searches, and how: a frozen dataclass whose fields stand in the journal.

    It begins with the defaults of `constants`, or with what a method ``begin()`` gives.
    """

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def population(self) -> int:
        """Candidates of a generation."""

    @property
    def elite(self) -> int:
        """How many of them move the distribution."""

    @property
    def generations(self) -> int:
        """When it ends."""

    @property
    def seed(self) -> int:
        """Decides every random number."""

    @property
    def constants(self) -> type[Constants]:
        """What is tuned."""

    def score(self, constants: Constants, generation: int) -> float:
        """How good they are in the worlds of a generation; the more the better."""


def check_search(search: Search, **least: int) -> None:
    """Refuse numbers that make no sense.

    Raises
    ------
    ParameterError
        Naming the number, what was given and what is allowed.
    """
    for name, low in {"population": 2, "elite": 1, "generations": 1, "seed": 0, **least}.items():
        if getattr(search, name) < low:
            raise ParameterError(f"tuning: {name}: {getattr(search, name)!r} given, a whole number of at least {low} is needed")
    if search.elite > search.population:
        raise ParameterError(f"tuning: elite {search.elite}: at most the population, {search.population}, is allowed")


@dataclass(frozen=True)
class Plan:
    """A study of a player on a tier.

    The score is the share of worlds in which the task is done; where a task has another end than success, for those who defend and in
    matches, it is the mean reward of an episode: cycles kept or taken, goals.

    Parameters
    ----------
    task : str
        Its player is tuned (`cprm_gym.agents.knowledge.players`).
    tier : str
    worlds : int
        Per candidate and generation.
    population, elite, generations, seed : int
        As for `Search`.
    senses : Senses
    others : str
        Policies of the scripted players, ``left,right``, if they are not those that the player is measured against.
    side : str
        ``left``, or ``right`` for those who defend.
    method : str
        Of `METHODS`.

    Raises
    ------
    UnknownName, ParameterError
        For a task without a player, a tier that he cannot be put on, a player without constants, or numbers that make no sense.
    """

    task: str = "Goalie"
    tier: str = "memory"
    worlds: int = 250
    population: int = 24
    elite: int = 6
    generations: int = 8
    seed: int = 0
    senses: Senses = Senses()  # noqa: RUF009
    others: str = ""
    side: str = "left"
    method: str = "cma-es"

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise unknown_name("method", self.method, METHODS)
        player = self.player
        if self.tier not in player.tiers:
            raise unknown_name("tier", self.tier, player.tiers)
        if player.constants is None:
            raise ParameterError(f"tuning: the player of {self.task} has no constants")
        check_search(self, worlds=1, population=4 if self.method == "cma-es" else 2)
        SoccerCore(self.played())  # refuses policies that there are not

    def played(self) -> Task:
        """The task as it is played."""
        others = {"others": tuple(self.others.split(","))} if self.others else {}
        side = {"controlled": self.side} if self.side == "right" else {}
        return make_task(self.task, **{**self.player.options, **others, **side})

    @property
    def player(self) -> Player:
        """Who is tuned."""
        return player_of(self.task, self.side)

    @property
    def constants(self) -> type[Constants]:
        """What is tuned."""
        kind = self.player.kind(self.tier)
        assert kind is not None, "refused when the plan was made"
        return kind

    def score(self, constants: Constants, generation: int) -> float:
        """Share of a generation's worlds in which the task is done with these constants, or mean reward."""
        return float(self.scores(constants, self.worlds, TUNING_SEED + 1000 * self.seed + generation).mean())

    def scores(self, constants: Constants, worlds: int, seed: int) -> np.ndarray:
        """(worlds,) float: 1 where the task is done and 0 where not, or the reward, of so many worlds of a seed."""
        make, task = self.player.on(self.tier, self.senses, constants), self.played()
        found = play_episodes(task, make, worlds, seed, senses=self.senses, slots=SLOTS)
        succeeds = self.side == "left" and self.task not in TEAMS and task.metric == "success"
        return np.asarray(found.success if succeeds else found.reward, float)


class Check(NamedTuple):
    """What a study found beside what was set by hand, in worlds that neither it nor a measurement meets.

    Attributes
    ----------
    found, by_hand : float
        Mean scores.
    difference, low, high : float
        Paired, with its 95 % interval.
    """

    found: float
    by_hand: float
    difference: float
    low: float
    high: float


def check(plan: Plan, found: Mapping[str, float], worlds: int) -> Check:
    """Play with the numbers found and with those set by hand, in the same worlds.

    Parameters
    ----------
    plan : Plan
    found : mapping of str to float
        Name of a constant -> number.
    worlds : int
        At least 2.

    Raises
    ------
    ParameterError
        For fewer.
    """
    if worlds < 2:
        raise ParameterError(f"tuning: check: {worlds!r} given, a whole number of at least 2 is needed")
    ones, others = (plan.scores(constants, worlds, CHECK_SEED) for constants in (plan.constants.of(found), plan.constants()))
    half = NORMAL * float((ones - others).std(ddof=1)) / worlds**0.5
    mean = float((ones - others).mean())
    return Check(float(ones.mean()), float(others.mean()), mean, mean - half, mean + half)


@dataclass(frozen=True)
class Generation:
    """What a generation found.

    Attributes
    ----------
    number : int
    mean, sd : dict of str to float
        The distribution after it.
    best : float
        Score of its best candidate.
    rate : float
        Mean score of its candidates.
    centre : float
        Score of the candidate in the middle of the distribution, drawn in every generation.
    scores : list of float
        Of all candidates; none where the method goes on from `mean` and `sd` alone.
    """

    number: int
    mean: dict[str, float]
    sd: dict[str, float]
    best: float
    rate: float
    centre: float
    scores: list[float] = field(default_factory=list)


class Method(Protocol):
    """How the distribution moves; all in units of the extents, from 0 to 1."""

    def ask(self, number: int) -> np.ndarray:
        """(population, n): the candidates of a generation, the first in the middle."""

    def tell(self, candidates: np.ndarray, scores: np.ndarray) -> None:
        """How good they are."""

    def again(self, generation: Generation, mean: np.ndarray, sd: np.ndarray) -> None:
        """Go on behind a generation of a journal, which ended with this distribution."""

    @property
    def mean(self) -> np.ndarray:
        """(n,)."""

    @property
    def sd(self) -> np.ndarray:
        """(n,): standard deviations."""

    @property
    def remembers(self) -> bool:
        """Whether it needs all scores of a journal to go on."""


class CrossEntropy:
    """The best move mean and deviations towards their own; each constant by itself.

    References
    ----------
    R. Y. Rubinstein (1999), Methodology and Computing in Applied Probability 1:127-190.
    """

    remembers = False

    def __init__(self, search: Search, begin: np.ndarray) -> None:
        self.search, self.mean, self.sd = search, begin, np.full(len(begin), WIDEST)

    def ask(self, number: int) -> np.ndarray:
        """Drawn anew from the seed and the number of the generation."""
        rng = np.random.default_rng(np.random.SeedSequence([self.search.seed, number]))
        draws = rng.standard_normal((self.search.population, len(self.mean)))
        draws[0] = 0.0
        return np.clip(self.mean + self.sd * draws, 0.0, 1.0)

    def tell(self, candidates: np.ndarray, scores: np.ndarray) -> None:
        """`KEPT` of the old distribution remains."""
        best = candidates[np.argsort(-scores, kind="stable")[: self.search.elite]]
        self.mean = KEPT * self.mean + (1 - KEPT) * best.mean(axis=0)
        self.sd = np.maximum(KEPT * self.sd + (1 - KEPT) * best.std(axis=0), NARROWEST)

    def again(self, generation: Generation, mean: np.ndarray, sd: np.ndarray) -> None:
        """As the journal tells it."""
        self.mean, self.sd = mean, sd


class CmaEs:
    """Covariance matrix adaptation, by the library cmaes.

    References
    ----------
    N. Hansen, A. Ostermeier (2001), Evolutionary Computation 9:159-195. M. Nomura, M. Shibata (2024), arXiv:2402.01373 (cmaes).
    """

    remembers = True

    def __init__(self, search: Search, begin: np.ndarray) -> None:
        try:
            from cmaes import CMA
        except ModuleNotFoundError:
            raise CprmError("tuning: the package cmaes is not installed; install cprm-gym[tune], or take --method cross-entropy") from None
        bounds = np.tile([0.0, 1.0], (len(begin), 1))
        self._optimizer = CMA(begin, WIDEST, bounds=bounds, seed=search.seed, population_size=search.population)
        self.population, self.sd = search.population, np.full(len(begin), WIDEST)

    @property
    def mean(self) -> np.ndarray:
        """Of its distribution, within the extents."""
        return np.clip(self._optimizer.mean, 0.0, 1.0)

    def ask(self, number: int) -> np.ndarray:
        """Drawn by the library from its own generator."""
        candidates = np.array([self._optimizer.ask() for _ in range(self.population)])
        candidates[0] = self.mean
        return candidates

    def tell(self, candidates: np.ndarray, scores: np.ndarray) -> None:
        """The library makes least what it is told."""
        self._optimizer.tell([(row, -score) for row, score in zip(candidates, scores.tolist())])
        self.sd = candidates.std(axis=0)

    def again(self, generation: Generation, mean: np.ndarray, sd: np.ndarray) -> None:
        """By telling it the scores of the journal for the candidates that it draws again."""
        self.tell(self.ask(generation.number), np.array(generation.scores))


METHODS: dict[str, Callable[[Search, np.ndarray], Method]] = {"cma-es": CmaEs, "cross-entropy": CrossEntropy}
"""Name -> how a study searches."""


def study(plan: Search, journal: Path | None = None) -> Iterator[Generation]:
    """The generations of a study, those of the journal first.

    Parameters
    ----------
    plan : Search
    journal : Path, optional
        One line for the plan and one for each generation.

    Raises
    ------
    CprmError
        When the journal is of another plan or damaged.
    """
    names = list(plan.constants.extents())
    low, high = np.array(list(plan.constants.extents().values())).T
    begin = getattr(plan, "begin", plan.constants)()
    method = METHODS[getattr(plan, "method", "cross-entropy")](plan, (np.array(list(begin.to_dict().values())) - low) / (high - low))
    done = read_journal(plan, journal)
    for generation in done:
        mean, sd = (np.array([values[name] for name in names]) for values in (generation.mean, generation.sd))
        if method.remembers and len(generation.scores) != plan.population:
            raise CprmError(f"{journal}: generation {generation.number} does not tell the scores of its candidates")
        method.again(generation, (mean - low) / (high - low), sd / (high - low))
        yield generation
    for number in range(len(done), plan.generations):
        candidates = method.ask(number)
        rows = low + (high - low) * candidates
        scores = np.array([plan.score(plan.constants.of(dict(zip(names, row.tolist()))), number) for row in rows])
        method.tell(candidates, scores)
        told = [{name: round(float(v), 5) for name, v in zip(names, values)}
                for values in (low + (high - low) * method.mean, (high - low) * method.sd)]  # fmt: skip
        found = Generation(number, told[0], told[1], float(scores.max()), float(scores.mean()), float(scores[0]),
                           scores.tolist() if method.remembers else [])  # fmt: skip
        if journal is not None:
            with journal.open("a", encoding="utf-8") as file:
                file.write(json.dumps(line_of(found)) + "\n")
        if not method.remembers:
            mean, sd = (np.array(list(values.values())) for values in told)
            method.again(found, (mean - low) / (high - low), sd / (high - low))
        yield found


def line_of(generation: Generation) -> dict[str, Any]:
    """What stands in a journal of it."""
    return {name: value for name, value in asdict(generation).items() if name != "scores" or value}


def read_journal(plan: Search, journal: Path | None) -> list[Generation]:
    """The generations that a journal holds; begins it, with the plan, if there is none. A last line cut short is removed."""
    if journal is None:
        return []
    head = {**asdict(plan), "generations": None}
    for name, default in LATER.items():
        if head.get(name) == default:
            del head[name]
    if not journal.exists():
        journal.write_text(json.dumps(head) + "\n", encoding="utf-8")
        return []
    text = journal.read_text(encoding="utf-8")
    whole = text[: text.rfind("\n") + 1]
    lines = whole.splitlines()
    try:
        if not lines or json.loads(lines[0]) != head:
            raise CprmError(f"{journal}: the journal of another study; give another --journal")
        found = [Generation(**json.loads(line)) for line in lines[1:]]
    except (ValueError, TypeError) as error:
        raise CprmError(f"{journal}: not the journal of a study: {error}") from None
    if [g.number for g in found] != list(range(len(found))):
        raise CprmError(f"{journal}: generations are missing or stand there twice")
    if whole != text:
        journal.write_text(whole, encoding="utf-8")
    return found[: plan.generations]
