"""A particle filter that is factored by independent component.

Each connected component of the belief has its own particles and one weight for each; components that a relation links are
joined, those that come apart keep what they have. One weight for all objects of a scene would leave no particle alive.
A variable is drawn from its CPD times the likelihood of the readings that depend on it alone, so a particle dies only where
several variables must fit one reading.

References
----------
Gordon, Salmond and Smith 1993; Kitagawa 1996 (systematic resampling); Doucet, Godsill and Andrieu 2000 (optimal proposal).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import prod
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple

import numpy as np

from cprm_gym.errors import ParameterError

from ..compiled import kernels
from ..compiled.cache import Recent, TableStore
from ..compiled.slice_info import SliceInfo
from ..evidence import Readings
from ..factors import Factor
from ..join_tree import connected
from .engine import Engine, StepResult, status_of_beginners
from .particle_steps import Block, Structure


class Particles(NamedTuple):
    """The belief of a particle filter. Its arrays are never changed.

    Attributes
    ----------
    info : SliceInfo or None
    values : dict of str to (W, P) int array
        Of the hidden variables.
    parts : tuple of tuple of str
        Independent components.
    weights : tuple of (W, P) float arrays
        For each component; rows sum to one.
    hard : (V, W) int array
        Readings of the slice.
    held : frozenset of str
        Variables that every agent observed.
    random : dict
        State of the stream of random numbers that the next step draws from.
    """

    info: SliceInfo | None
    values: dict[str, np.ndarray]
    parts: tuple[tuple[str, ...], ...]
    weights: tuple[np.ndarray, ...]
    hard: np.ndarray
    held: frozenset[str] = frozenset()
    random: Mapping[str, Any] = MappingProxyType({})


@dataclass
class Estimate(StepResult):
    """What one step of the particle filter gave.

    Attributes
    ----------
    belief : Particles
        After resampling.
    weighted : Particles
        Before resampling: posteriors are taken from these.
    """

    sampled: ClassVar[bool] = True

    belief: Any
    weighted: Particles
    info: SliceInfo
    readings: Readings
    status: np.ndarray
    increment: np.ndarray
    loss: np.ndarray
    engine: str = "particles"
    exact: bool = False
    report: dict[str, Any] = field(default_factory=dict)

    def suspects(self, agent: int) -> list[str]:
        names = self.report["dead"].get(agent, ())
        return [n for n in names if self.readings.hard[self.info.row[n], agent] >= 0 or n in self.readings.soft]

    def marginal(self, name: str) -> np.ndarray:
        for part, weights in zip(self.weighted.parts, self.weighted.weights):
            if name in part:
                return count(self.weighted.values, (name,), weights, (int(self.info.cards[self.info.row[name]]),)).table
        return self.joint((name,))

    def hidden_factors(self, names: Sequence[str]) -> list[Factor]:
        factors = []
        for part, weights in zip(self.weighted.parts, self.weighted.weights):
            inside = [n for n in names if n in part]
            if inside:
                factors.append(count(self.weighted.values, inside, weights, [int(self.info.cards[self.info.row[n]]) for n in inside]))
        return factors


def count(values: dict[str, np.ndarray], names: Sequence[str], weights: np.ndarray, cards: Sequence[int]) -> Factor:
    """Weighted counts of the joint values of some variables of one component."""
    index = np.zeros(weights.shape, np.int64)
    for name, card in zip(names, cards):
        index = index * card + values[name]
    out = np.zeros((len(weights), prod(cards)))
    kernels.histogram(index, weights, out)
    return Factor(tuple(names), out.reshape(len(weights), *cards))


def effective_size(weights: np.ndarray) -> np.ndarray:
    """``1 / sum w^2`` of normalised weights, (W,)."""
    squares = (weights**2).sum(axis=1)
    sizes: np.ndarray = np.divide(1.0, squares, out=np.zeros(len(squares)), where=squares > 0)
    return sizes


class ParticleEngine(Engine):
    """Particle filter.

    Parameters
    ----------
    particles : int
        For each component and agent.
    seed : int, SeedSequence or Generator
    threshold : float
        A component is resampled where its effective sample size falls below this share of the particles.
    """

    name: ClassVar[str] = "particles"
    exact: ClassVar[bool] = False

    def __init__(self, particles: int = 1000, seed: Any = None, threshold: float = 0.5) -> None:
        if particles < 2:
            raise ParameterError(f"`particles` is at least 2, got {particles!r}")
        self.count, self.threshold = int(particles), threshold
        self._root = np.random.default_rng(seed)
        self.rng = np.random.Generator(type(self._root.bit_generator)())
        """Takes up the stream of the belief that is carried on."""
        self._left: Mapping[str, Any] = {}
        self.store = TableStore()
        self.temporal = frozenset()
        self._structures: Recent[tuple[Any, ...], Structure] = Recent(256)

    def start(self, batch: int) -> Particles:
        return Particles(None, {}, (), (), np.zeros((0, batch), np.int64), random=self.stream())

    def stream(self) -> dict[str, Any]:
        """The beginning of the next of the independent streams of random numbers that the seed gives."""
        (child,) = self._root.spawn(1)
        return dict(child.bit_generator.state)

    def block(self, belief: Particles, info: SliceInfo, readings: Readings, status: np.ndarray, number: int) -> Block:
        """Take some particles through one step."""
        key = belief.info, belief.parts, belief.held, info, status.tobytes()
        made = self._structures.fetch(key, lambda: Structure(belief.info, belief.parts, belief.held, info, status))
        return Block(made, self.rng, belief.values, belief.weights, belief.hard, readings, number)

    def advance(self, belief: Particles, info: SliceInfo, readings: Readings, forgive: np.ndarray | None = None) -> Estimate:
        self.take_up(belief.random)
        status = info.status(readings.hard, readings.soft, self.temporal)
        estimate = self.finish([self.block(belief, info, readings, status, self.count)], info, readings, status, forgive)
        return self.with_stream(estimate)

    def take_up(self, random: Mapping[str, Any]) -> None:
        """Draw from where a belief's stream stands; nothing to do for the belief that was made last."""
        if random is not self._left:
            self.rng.bit_generator.state = random
        self._left = {}  # a step that fails leaves the stream in between

    def stream_left(self) -> Mapping[str, Any]:
        """Where the stream stands."""
        self._left = self.rng.bit_generator.state
        return self._left

    def with_stream(self, estimate: Estimate) -> Estimate:
        """The estimate with a belief that goes on with the random numbers left."""
        estimate.belief = estimate.belief._replace(random=self.stream_left())
        return estimate

    def finish(
        self, blocks: Sequence[Block], info: SliceInfo, readings: Readings, status: np.ndarray, forgive: np.ndarray | None
    ) -> Estimate:
        """Normalise, estimate and resample the particles of one or more blocks."""
        parts = blocks[0].parts
        values = {n: np.concatenate([b.values[n] for b in blocks], axis=1) for n in blocks[0].values}
        increment = blocks[0].constant.copy()
        weights, sizes = [], []
        dead: dict[int, list[str]] = {int(a): list(blocks[0].constant_names) for a in np.flatnonzero(~np.isfinite(increment))}
        for k in range(len(parts)):
            w = np.concatenate([b.weights[k] for b in blocks], axis=1) / len(blocks)
            prior = np.concatenate([b.prior[k] for b in blocks], axis=1) / len(blocks)
            total = w.sum(axis=1)
            lost = np.flatnonzero(total <= 0)
            for a in lost:
                if forgive is not None and a in forgive:
                    w[a], total[a] = prior[a], 1.0
                else:
                    dead.setdefault(int(a), []).extend(blocks[0].readers[k])
            with np.errstate(divide="ignore"):
                increment += np.log(total)
            w = np.divide(w, total[:, None], out=prior.copy(), where=total[:, None] > 0)
            weights.append(w)
            sizes.append(effective_size(w))
        if forgive is not None:
            increment[forgive] = np.where(np.isfinite(increment[forgive]), increment[forgive], 0.0)
        weighted = Particles(info, values, parts, tuple(weights), readings.hard, blocks[0].held)
        belief = self.resample(weighted, sizes)
        ess = np.stack(sizes, axis=1) if sizes else np.zeros((readings.hard.shape[1], 0))
        report = {"ess": ess, "components": parts, "particles": weights[0].shape[1] if weights else 0, "dead": dead}
        return Estimate(belief, weighted, info, readings, status, increment, np.zeros(len(increment)), report=report)

    def resample(self, belief: Particles, sizes: Sequence[np.ndarray]) -> Particles:
        """Systematic resampling of the components and agents whose effective sample size is too small."""
        values = dict(belief.values)
        weights = []
        for part, w, size in zip(belief.parts, belief.weights, sizes):
            agents = np.flatnonzero(size < self.threshold * w.shape[1])
            if len(agents):
                ancestors = np.empty((len(agents), w.shape[1]), np.int64)
                kernels.systematic(w[agents], self.rng.random(len(agents)), ancestors)
                w = w.copy()
                w[agents] = 1.0 / w.shape[1]
                for name in part:
                    kept = values[name].copy()
                    kept[agents] = np.take_along_axis(values[name][agents], ancestors, axis=1)
                    values[name] = kept
            weights.append(w)
        return belief._replace(values=values, weights=tuple(weights))

    def replace_agents(self, result: StepResult, first: SliceInfo, readings: Readings, agents: np.ndarray, forgive: bool) -> Estimate:
        assert isinstance(result, Estimate)
        self.take_up(result.belief.random)
        return self.with_stream(self.begin_some(result, first, readings, agents, forgive))

    def begin_some(self, estimate: Estimate, first: SliceInfo, readings: Readings, agents: np.ndarray, forgive: bool) -> Estimate:
        """As `replace_agents`, with the random numbers as they are."""
        number = estimate.weighted.weights[0].shape[1] if estimate.weighted.weights else self.count
        status = status_of_beginners(estimate, first, readings, self.temporal)
        start = Particles(None, {}, (), (), np.zeros((0, len(agents)), np.int64))
        block = self.block(start, first, readings, status, number)
        anew = self.finish([block], first, readings, status, np.arange(len(agents)) if forgive else None)
        increment = estimate.increment.copy()
        increment[agents] = anew.increment
        belief, weighted = (_mix(old, new, agents) for old, new in ((estimate.belief, anew.belief), (estimate.weighted, anew.weighted)))
        report = {**estimate.report, "components": belief.parts}
        return replace(estimate, belief=belief, weighted=weighted, increment=increment, report=report)


def _mix(old: Particles, new: Particles, agents: np.ndarray) -> Particles:
    """Particles that are `new` for some agents; components are joined where the two divide the variables differently."""
    groups = connected([*old.parts, *new.parts])
    values = {n: v.copy() for n, v in old.values.items()}
    for name, drawn in new.values.items():
        if name in values:
            values[name][agents] = drawn
    parts, weights = [], []
    for group in groups:
        mine = [k for k in group if k < len(old.parts)]
        theirs = [k - len(old.parts) for k in group if k >= len(old.parts)]
        if not mine:
            continue
        w = np.prod([old.weights[k] for k in mine], axis=0)
        if theirs:
            w[agents] = np.prod([new.weights[k] for k in theirs], axis=0)
        total = w.sum(axis=1, keepdims=True)
        weights.append(np.divide(w, total, out=np.full(w.shape, 1.0 / w.shape[1]), where=total > 0))
        parts.append(tuple(n for k in mine for n in old.parts[k]))
    return old._replace(values=values, parts=tuple(parts), weights=tuple(weights))
