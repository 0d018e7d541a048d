"""One behaviour in the simulator's world, by every method that applies."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ...agents.worlds.conditions import CONDITIONS
from ...agents.worlds.learned import behaviour as named
from ...agents.worlds.learned import learn_world
from ...agents.worlds.runs import StageRuns
from ...agents.worlds.stage import Change
from ...architecture.analysis.bounded.regular import every_row_bounds
from ...architecture.analysis.bounded.unknown_state import unknown_state_bounds
from ...architecture.analysis.bounded.value_iteration import interval_bounds
from ...architecture.analysis.bounds import Bounds
from ...architecture.analysis.budget import Budget, Clock
from ...architecture.analysis.markov.absorption import absorption
from ...architecture.analysis.markov.over_time import outcomes_over_time
from ...architecture.analysis.product.explore import product
from ...architecture.analysis.product.learned_world import LearnedWorld, thresholds_of
from ...architecture.analysis.product.regular import regular_bounds
from ...architecture.analysis.product.runs import ProductRuns
from ...architecture.analysis.sampling.intervals import upper_limit
from ...architecture.analysis.sampling.properties import Property
from ...architecture.analysis.sampling.properties import properties as parsed
from ...architecture.analysis.sampling.runs import UNFINISHED, Run
from ...architecture.analysis.sampling.sample import Sample, sample
from ...architecture.petri import PetriNet, compile_net
from ...errors import ModelError, unknown_name
from . import methods as further
from .findings import FRESH, BehaviourReport
from .judged import FLOOR, judged
from .methods import Said

METHODS = ("exact", "bounded", "sampled", "simulator", "rare", "modules", "certificate", "contract")
"""exact: the learned cells' likeliest chances; bounded: within their intervals; sampled: runs of the same; simulator: fresh episodes, and
the conditions that they keep; rare: what is feared, drawn and leant to; modules: the parts chained; certificate: a proof; contract: what
the skill promises its caller."""


def analyze_behaviour(
    name: str, *, methods: Sequence[str] = METHODS, properties: Sequence[str] | Mapping[str, str] = (), episodes: int = 2000, seed: int = 0,
    confidence: float = 0.95, require: float | None = None, change: Change | None = None, budget: Budget | None = None,
    learned: LearnedWorld | None = None, progress: Callable[[str], object] | None = None,
) -> BehaviourReport:  # fmt: skip
    """Analyse a behaviour in the simulator's world.

    The world is learned from episodes: cells of what the net tests, cut at its own thresholds and finer, with intervals of all chances. Net
    and cells make one chain. The sampled answer plays that chain, the simulator's answer plays fresh episodes (other seeds) of the true
    thing: what differs between these two is what the cells forget.

    Parameters
    ----------
    name : str
        Of `BEHAVIOURS`.
    methods : sequence of str
        Of `METHODS`.
    properties : sequence or mapping of str
        Formulas over what the net observes and the commands that go out, looked at in sampled runs.
    episodes, seed : int
    confidence : float
    require : float, optional
        What the probability of the wanted outcome has to be at least.
    change : callable, optional
        Makes another net of the skill's: a version to be compared.
    budget : Budget, optional
    learned : LearnedWorld, optional
        A world at hand, instead of learning one.
    progress : callable, optional
        Told what is done now.

    Raises
    ------
    UnknownName, ModelError, ExpressionError
    """
    for method in methods:
        if method not in METHODS:
            raise unknown_name("method", method, METHODS)
    if not methods:
        raise ModelError(f"methods: none; there are {', '.join(METHODS)}")
    if not 0.0 < confidence < 1.0:
        raise ModelError(f"confidence {confidence}: needs a number between 0 and 1")
    if episodes < 2 or (require is not None and not 0 < require < 1):
        raise ModelError(f"episodes {episodes}, require {require}: needs two episodes, and a probability")
    formulas = parsed(properties)  # before anything is played
    limits, clock = (budget or Budget(states=200_000)).start()
    report = BehaviourReport(name, "", episodes, seed, confidence, require=require, change=change)
    named(name)
    work = _Work(report, tuple(methods), formulas, limits, clock, progress or (lambda _: None))
    try:
        work.learn(learned)
        for method in METHODS:
            if method in methods and clock.spent():
                report.said[method] = Said(False, "the budget ended before it")
            elif method in methods:
                getattr(work, method)()
                if clock.interrupted:
                    raise KeyboardInterrupt
        if formulas and not {"sampled", "simulator"} & set(methods):
            report.notes.append("properties are looked at in runs, which were not asked for")
        if clock.spent():
            report.notes.append(f"the budget ended it: {clock.reason}")
    except KeyboardInterrupt:
        report.interrupted = True
        report.notes.append("interrupted; what is there was finished before")
    return report


@dataclass(eq=False)
class _Work:
    """The methods one after the other, each with what was found before."""

    report: BehaviourReport
    methods: tuple[str, ...]
    formulas: Mapping[str, Property]
    limits: Budget
    clock: Clock
    say: Callable[[str], object]
    net: PetriNet = field(init=False)
    outcomes: Mapping[str, str] = field(init=False)
    world: LearnedWorld = field(init=False)
    limit: int = field(init=False)

    @property
    def shared(self) -> float:
        """With which each of two kinds of bounds holds, so that both do at once."""
        return 1.0 - (1.0 - self.report.confidence) / 2

    def learn(self, learned: LearnedWorld | None) -> None:
        """The world, and the chain of net and world where a method needs it."""
        report = self.report
        self.limit = named(report.name).limit
        self.say("learning the world")
        _, half = self.limits.part(0.5).start()
        episodes = report.episodes if learned is None else 2
        self.net, self.outcomes, world = learn_world(
            report.name, episodes, report.seed, net=report.change, confidence=self.shared, clock=half
        )  # fmt: skip
        if half.spent() and learned is None:
            report.notes.append("the episodes that teach the world were ended before their time: what would have followed is 'unseen'")
        self.world = report.world = learned or world
        report.done = next(iter(self.outcomes))
        if self.clock.interrupted:
            raise KeyboardInterrupt
        if {"exact", "bounded", "rare"} & set(self.methods) and not self.clock.spent():
            self.say("exploring net and world")
            report.product = product(self.net, self.world, self.outcomes, budget=self.limits)
            if not report.product.complete:
                report.notes.append("net and world have more states than the budget grants: the rest is the outcome 'unexplored'")

    def exact(self) -> None:
        """The chain solved."""
        assert self.report.product is not None
        chain = self.report.product.chain
        self.report.exact, self.report.over_time = absorption(chain), outcomes_over_time(chain, self.limit)

    def bounded(self) -> None:
        """The chain within its intervals, and what most runs keep to."""
        report = self.report
        assert report.product is not None
        self.say("bounding")
        chain = report.product.bounded
        report.rows = interval_bounds(chain)
        report.text = {o: unknown_state_bounds(chain, o) for o in chain.outcomes}
        rows = every_row_bounds(chain, tuple(self.outcomes)) if self.world.confidence >= self.shared else {}
        coarse = self.world.coarser(_own_thresholds(self.net, self.world))
        confidence = self.shared if rows else report.confidence
        try:
            report.regular = regular_bounds(self.net, coarse, self.outcomes, cycles=self.limit, confidence=confidence, budget=self.limits)
        except ModelError as error:
            report.bounds = rows
            report.said["bounded"] = Said(bool(rows), f"every row by itself alone: {error}")
            return
        regular = report.regular.probabilities
        report.bounds = {o: b if o not in rows else Bounds(max(b.low, rows[o].low), min(b.high, rows[o].high)) for o, b in regular.items()}
        least, division = report.regular.least[report.done]
        report.said["bounded"] = Said(
            True,
            f"{report.done} with at least {report.bounds[report.done].low:.4f}; by what most runs keep to with {least:.4f}: "
            f"{division.left} of {report.regular.runs} episodes that were held out left what is regular "
            f"({division.rows} rows begun {division.often} times or more), so that at most {division.most_left:.4f} of all do, "
            "and these may end in anything",
        )

    def sampled(self) -> None:
        """Runs of net and learned world."""
        report = self.report
        self.say("playing the learned world")
        runs = ProductRuns(self.net, self.world, self.outcomes, limit=20 * self.limit, ends=("unseen",))
        known = runs.play([0], report.seed + 1, True)[0].signals if self.formulas else {}
        told = {n: f.text for n, f in self.formulas.items() if "simulator" not in self.methods or set(f.names) <= set(known)}
        if len(told) < len(self.formulas):
            report.notes.append(f"looked at in the simulator's runs alone: {', '.join(n for n in self.formulas if n not in told)}")
        report.sampled = sample(
            runs, report.episodes, seed=report.seed + 1, confidence=report.confidence, properties_=told, budget=self.limits
        )
        self._heed(report.sampled)

    def simulator(self) -> None:
        """Fresh episodes, and the conditions that they keep."""
        report = self.report
        self.say("playing the simulator")
        conditions = CONDITIONS[report.name]
        wanted = {c.name: c.formula for c in conditions} | {n: f.text for n, f in self.formulas.items()}
        noted = _Noted(StageRuns(report.name, report.change))
        report.played = sample(
            noted,
            report.episodes,
            seed=report.seed + FRESH,
            confidence=report.confidence,
            properties_=wanted,
            budget=self.limits,
            block=500,
        )
        report.simulator, report.ended = {o: report.played.count(o) for o in noted.outcomes}, np.array(noted.ended)
        if report.played.runs:
            report.judged = judged(conditions, report.played, report.confidence, FLOOR)
        self._heed(report.played)

    def rare(self) -> None:
        """What is feared."""
        report = self.report
        assert report.product is not None
        self.say("looking for what is feared")
        exact = report.exact or absorption(report.product.chain)
        feared = [o for o in self.outcomes if o != report.done]
        worst = max(feared, key=lambda o: exact.probability(o).value, default="")
        said = further.rare(exact, worst, report.done, report.seed, report.confidence)
        if not said.applies and report.played is not None and report.played.runs:
            most = upper_limit(report.played.runs - report.played.count(report.done), report.played.runs, report.confidence)
            said = Said(False, f"{said.says}; by the simulator's episodes all else has at most {most:.4f}")
        report.said["rare"] = said

    def modules(self) -> None:
        """The parts chained."""
        self.say("taking it to pieces")
        self.report.said["modules"] = further.modules(self.net, self.world, self.report.done, self.limits)

    def certificate(self) -> None:
        """A proof."""
        self.report.said["certificate"] = further.certificate(self.report.name, self.report.seed)

    def contract(self) -> None:
        """What the skill promises."""
        self.say("checking the contract")
        self.report.said["contract"] = further.contract(self.net, self.limits)

    @staticmethod
    def _heed(found: Sample) -> None:
        if found.reason == "interrupted":
            raise KeyboardInterrupt


def _own_thresholds(net: PetriNet, world: LearnedWorld) -> dict[str, tuple[float, ...]]:
    """Where the net decides, as far as the world is cut there."""
    own = thresholds_of(compile_net(net))
    return {place: tuple(c for c in cuts if c in own.get(place, cuts)) or cuts for place, cuts in world.edges.items()}


@dataclass
class _Noted:
    """Runs whose ends are noted: the cycle, -1 where they were cut off."""

    runs: StageRuns
    ended: list[int] = field(default_factory=list)

    @property
    def outcomes(self) -> tuple[str, ...]:
        return self.runs.outcomes

    def play(self, numbers: Sequence[int], seed: int, signals: bool) -> list[Run]:
        found = self.runs.play(numbers, seed, signals)
        self.ended += [run.cycles if run.outcome != UNFINISHED else -1 for run in found]
        return found
