"""The best answer within a budget of time and memory, and which engine gave it.

1. *exact*, if the plans of the step fit the budget;
2. *projection*: the belief is first divided into the largest clusters, by mutual information, that make the step fit;
3. *particles*, in blocks until the time is up, if even single variables as clusters do not fit.

What a plan costs is known before it runs (`Plan.cost`); how many operations a millisecond holds is measured while running.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from cprm_gym.errors import CostError, ParameterError

from .. import smoothing
from ..compiled.belief import FactoredBelief, Piece, PieceFactor, nothing_yet
from ..compiled.slice_info import Kind, SliceInfo
from ..compiled.steps import SliceStep
from ..evidence import Readings
from .clusters import project
from .engine import ComponentCost, Engine, StepResult
from .exact import FactoredResult
from .particle_steps import Block
from .particles import Estimate, ParticleEngine, Particles, count
from .projection import ProjectionEngine

SHARE = 0.6
"""Share of the time that the plans may be expected to take; the rest is for what surrounds them."""


class AnytimeBelief(NamedTuple):
    """A belief of factors or of particles, whichever the last step could afford.

    Attributes
    ----------
    belief : FactoredBelief or Particles
    since : SliceInfo or None
        The slice in which particles were last needed: while it stays the same, factors are not tried.
    random : dict
        State of the stream of random numbers.
    """

    belief: FactoredBelief | Particles
    since: SliceInfo | None
    random: Mapping[str, Any]


class AnytimeEngine(Engine):
    """Exact, projected or sampled, whatever the budget allows.

    Parameters
    ----------
    budget_ms : float
        Time for a step of all agents together, milliseconds. The first step of a new structure also takes the time to compile
        its plan, unless it was made before (`Filter.cost` makes it).
    memory_limit : float
        Bytes for one component.
    block : int
        Particles in a block.
    most : int
        No more particles than this, however much time is left.
    seed : int, SeedSequence or Generator
    threads : int
        As for `ExactEngine`.
    """

    name: ClassVar[str] = "anytime"
    exact: ClassVar[bool] = False

    def __init__(
        self,
        budget_ms: float = 20.0,
        memory_limit: float = 2.0**26,
        block: int = 500,
        most: int = 20_000,
        seed: Any = None,
        threads: int = 1,
    ) -> None:
        if budget_ms <= 0:
            raise ParameterError(f"`budget_ms` is positive, got {budget_ms!r}")
        self.budget_ms, self.block, self.most = budget_ms, block, most
        self.rate = 1e6
        self.factors = ProjectionEngine(memory_limit=memory_limit, threads=threads)
        self.sampled = ParticleEngine(block, seed)
        self.sampled.store = self.factors.store
        self.store = self.factors.store

    @property
    def temporal(self) -> frozenset[tuple[str, str]]:  # type: ignore[override]
        """Kinds of variables that are kept."""
        return self.factors.temporal

    def start(self, batch: int) -> AnytimeBelief:
        return AnytimeBelief(nothing_yet(batch), None, self.sampled.stream())

    def note(self, kind: Kind) -> None:
        self.factors.note(kind)
        self.sampled.note(kind)

    @property
    def compiled(self) -> int:
        return self.factors.compiled

    def cost(self, belief: AnytimeBelief, info: SliceInfo, readings: Readings) -> list[ComponentCost]:
        return self.factors.cost(self.factored(belief), info, readings)

    def prepare(self, belief: AnytimeBelief, info: SliceInfo, readings: Readings) -> AnytimeBelief:
        return belief._replace(belief=self.factors.prepare(self.factored(belief), info, readings))

    def factored(self, belief: AnytimeBelief) -> FactoredBelief:
        if isinstance(belief.belief, Particles):
            self._cannot("keeps particles now, not factors")
        return belief.belief

    def adopt(self, belief: FactoredBelief) -> AnytimeBelief:
        return AnytimeBelief(belief, None, self.sampled.stream())

    def project(self, belief: AnytimeBelief, clusters: Sequence[Sequence[str]]) -> tuple[AnytimeBelief, np.ndarray]:
        projected, loss = self.factors.project(self.factored(belief), clusters)
        return belief._replace(belief=projected), loss

    def conflict(self, before: AnytimeBelief, result: StepResult, agent: int) -> list[str]:
        if isinstance(result, FactoredResult) and not isinstance(before.belief, Particles):
            return self.factors.conflict(before.belief, result, agent)
        return result.suspects(agent)

    def replace_agents(self, result: StepResult, first: SliceInfo, readings: Readings, agents: np.ndarray, forgive: bool) -> StepResult:
        kept: AnytimeBelief = result.belief
        if isinstance(result, FactoredResult):
            mixed = self.factors.replace_agents(result, first, readings, agents, forgive)
            return replace(mixed, belief=kept._replace(belief=mixed.factored))
        assert isinstance(result, Estimate)
        inner = replace(result, belief=kept.belief)
        self.sampled.take_up(kept.random)
        return self._sampled(self.sampled.begin_some(inner, first, readings, agents, forgive), kept.since)

    def _sampled(self, estimate: Estimate, since: SliceInfo | None) -> Estimate:
        """The estimate with a belief of this engine's own."""
        return replace(estimate, belief=AnytimeBelief(estimate.belief, since, self.sampled.stream_left()))

    def advance(self, belief: AnytimeBelief, info: SliceInfo, readings: Readings, forgive: np.ndarray | None = None) -> StepResult:
        """Go on by one slice by the best engine that fits."""
        begun = perf_counter()
        inner = belief.belief
        factored: FactoredBelief | None = None
        if not isinstance(inner, Particles):
            factored = inner
        elif info is not belief.since:
            factored = to_factors(self.factors, inner)
        if factored is not None and forgive is None:
            result = self._try_factored(factored, info, readings)
            if result is not None:
                return self._timed(replace(result, belief=belief._replace(belief=result.factored)), begun)
        self.sampled.take_up(belief.random)
        particles = inner if isinstance(inner, Particles) else to_particles(inner, self.block, self.sampled.rng)
        return self._timed(self._sampled(self._sample(particles, info, readings, begun, forgive), info), begun)

    def _timed(self, result: StepResult, begun: float) -> StepResult:
        result.report = {**result.report, "ms": 1e3 * (perf_counter() - begun), "budget_ms": self.budget_ms}
        return result

    def _try_factored(self, belief: FactoredBelief, info: SliceInfo, readings: Readings) -> FactoredResult | None:
        """An exact or projected step, or None if none fits."""
        batch = readings.hard.shape[1]
        allowed = SHARE * self.budget_ms * self.rate
        slice_step = self.factors.slice_step(belief, info, readings)
        members = max(1, sum(len(g.members) for g in slice_step.groups if g.plan.cost.flops * batch > 0.2 * allowed))
        share = allowed / batch / members
        self.factors.max_flops = 2.0 ** np.floor(np.log2(share))
        tier = "exact"
        loss, clusters = np.zeros(batch), None
        if self.flops(slice_step, batch) > allowed or not self.fits(slice_step, batch):
            chosen = self.factors.choice(belief, info, slice_step)
            if not chosen:
                return None
            try:
                belief, loss = project(self.factors.compiler, self.factors.memory_limit, belief, chosen)
            except CostError:
                return None
            clusters = [tuple(name for name, _ in c) for choice in chosen.values() for c in choice.clusters]
            tier = "projection"
            slice_step = self.factors.slice_step(belief, info, readings)
            if self.flops(slice_step, batch) > 4.0 * allowed or not self.fits(slice_step, batch):
                return None
        begun = perf_counter()
        result = self.factors.run(belief, info, readings, slice_step)
        self._learn_rate(self.flops(slice_step, batch), perf_counter() - begun)
        report = {**result.report, "clusters": clusters} if clusters is not None else result.report
        return replace(result, engine=tier, exact=result.exact and clusters is None, loss=result.loss + loss, report=report)

    def flops(self, slice_step: SliceStep, batch: int) -> float:
        """Operations of a step."""
        return sum(g.plan.cost.flops * len(g.members) for g in slice_step.groups) * batch

    def fits(self, slice_step: SliceStep, batch: int) -> bool:
        """Whether every component stays within the memory."""
        try:
            self.factors.check(slice_step, batch)
        except CostError:
            return False
        return True

    def _learn_rate(self, flops: float, seconds: float) -> None:
        """Operations for each millisecond: a running mean over steps large enough to be measured."""
        if flops > 2e5 and seconds > 1e-4:
            self.rate = 0.9 * self.rate + 0.1 * min(max(flops / (1e3 * seconds), 1e5), 1e8)

    def _sample(
        self,
        belief: Particles,
        info: SliceInfo,
        readings: Readings,
        begun: float,
        forgive: np.ndarray | None,
    ) -> Estimate:
        """Particles in blocks until the time is up; at least one block."""
        status = info.status(readings.hard, readings.soft, self.sampled.temporal)
        blocks: list[Block] = []
        longest = 0.0
        while True:
            start = perf_counter()
            blocks.append(self.sampled.block(belief, info, readings, status, self.block))
            longest = max(longest, perf_counter() - start)
            spent = 1e3 * (perf_counter() - begun)
            if spent + 1.5e3 * longest > self.budget_ms or (len(blocks) + 1) * self.block > self.most:
                break
        return self.sampled.finish(blocks, info, readings, status, forgive)


def to_particles(belief: FactoredBelief, number: int, rng: np.random.Generator) -> Particles:
    """Particles drawn from a belief of factors."""
    batch = belief.hard.shape[1]
    drawn = smoothing.sample_belief(belief, number, rng)
    parts = tuple(tuple(dict.fromkeys(name for f in piece.factors for name, _ in f.scope)) for piece in belief.layout.pieces)
    inside = {n for part in parts for n in part}
    weights = tuple(np.full((batch, number), 1.0 / number) for _ in parts)
    held = frozenset(belief.layout.held)
    return Particles(belief.layout.info, {n: v for n, v in drawn.items() if n in inside}, parts, weights, belief.hard, held)


def to_factors(engine: ProjectionEngine, belief: Particles, floor: float = 1e-3) -> FactoredBelief:
    """A belief of factors from particles: joint counts of the variables that share most information, the rest independent.

    Clusters hold at most as many entries as a fifth of the particles. A share `floor` of the product of marginals is mixed in,
    so that no state is lost for lack of a particle.
    """
    info = belief.info
    if info is None:
        return engine.start(belief.hard.shape[1])
    batch = belief.hard.shape[1]
    pieces: list[Piece] = []
    arrays: list[np.ndarray] = []
    for part, weights in zip(belief.parts, belief.weights):
        for cluster in _clusters(belief, info, part, weights):
            cards = [int(info.cards[info.row[n]]) for n in cluster]
            joint = count(belief.values, cluster, weights, cards).table
            independent = np.ones((batch, *[1] * len(cluster)))
            for axis in range(len(cluster)):
                others = tuple(k + 1 for k in range(len(cluster)) if k != axis)
                single = (1.0 - floor) * joint.sum(axis=others, keepdims=True) + floor / cards[axis]
                independent = independent * single
            table = ((1.0 - floor) * joint + floor * independent).reshape(batch, -1)
            scope = tuple((n, -1 if info.static[info.row[n]] else 0) for n in cluster)
            pieces.append(Piece(len(arrays), 0, (PieceFactor(scope, 0, table.shape[1]),)))
            arrays.append(table / table.sum(axis=1, keepdims=True))
    held = {n: row for n, row in info.row.items() if n in belief.held}
    layout = engine.compiler.layouts.one(tuple(pieces), tuple(a.shape[1] for a in arrays), (1,) * len(arrays), held, info)
    return FactoredBelief(layout, tuple(arrays), belief.hard)


def _clusters(belief: Particles, info: SliceInfo, part: tuple[str, ...], weights: np.ndarray) -> list[tuple[str, ...]]:
    """Variables of a component joined by mutual information, corrected for chance."""
    cards = {n: int(info.cards[info.row[n]]) for n in part}
    limit = weights.shape[1] / 5.0
    shared = []
    for i, a in enumerate(part):
        for b in part[:i]:
            table = count(belief.values, (a, b), weights, (cards[a], cards[b])).table
            product = table.sum(axis=1, keepdims=True) * table.sum(axis=2, keepdims=True)
            with np.errstate(divide="ignore", invalid="ignore"):
                information = np.where(table > 0, table * np.log(table / product), 0.0).sum(axis=(1, 2)).mean()
            shared.append((float(information) - (cards[a] - 1) * (cards[b] - 1) / (2.0 * weights.shape[1]), a, b))
    clusters: dict[str, tuple[str, ...]] = {n: (n,) for n in part}
    for information, a, b in sorted(shared, reverse=True):
        joined = tuple(n for n in part if n in clusters[a] + clusters[b])
        if information > 0 and clusters[a] != clusters[b] and np.prod([float(cards[n]) for n in joined]) <= limit:
            for n in joined:
                clusters[n] = joined
    return list(dict.fromkeys(clusters.values()))
