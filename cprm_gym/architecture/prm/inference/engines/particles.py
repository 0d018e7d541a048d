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

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import prod
from typing import Any, NamedTuple

import numpy as np

from cprm_gym.errors import ModelError, ParameterError, did_you_mean

from ...grounding.slices import PREVIOUS
from ..bayes_net import one_hot
from ..compiled import kernels
from ..compiled.steps import ABSORBED, BARREN, HELD, Kind, Recent, SliceInfo, TableStore
from ..evidence import Readings
from ..factors import Factor, contract_all
from ..join_tree import connected
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
    """

    info: SliceInfo | None
    values: dict[str, np.ndarray]
    parts: tuple[tuple[str, ...], ...]
    weights: tuple[np.ndarray, ...]
    hard: np.ndarray
    held: frozenset[str] = frozenset()


@dataclass
class Estimate:
    """What one step of the particle filter gave; the same questions as `exact.Outcome`.

    Attributes
    ----------
    belief : Particles
        After resampling.
    weighted : Particles
        Before resampling: posteriors are taken from these.
    """

    belief: Particles
    weighted: Particles
    info: SliceInfo
    readings: Readings
    status: np.ndarray
    increment: np.ndarray
    report: dict[str, Any] = field(default_factory=dict)
    engine: str = "particles"
    exact_step: bool = False

    @property
    def loss(self) -> np.ndarray:
        """Nothing was projected."""
        return np.zeros(self.readings.hard.shape[1])

    @property
    def impossible(self) -> np.ndarray:
        """(W,) bool array: where no particle fits the readings."""
        return np.asarray(~np.isfinite(self.increment))

    def suspects(self, agent: int) -> list[str]:
        """Observed variables of the components without a surviving particle."""
        names = self.report["dead"].get(agent, ())
        return [n for n in names if self.readings.hard[self.info.row[n], agent] >= 0 or n in self.readings.soft]

    def marginal(self, name: str) -> np.ndarray:
        """P(variable | readings so far), (W, card)."""
        for part, weights in zip(self.weighted.parts, self.weighted.weights):
            if name in part:
                return count(self.weighted.values, (name,), weights, (int(self.info.cards[self.info.row[name]]),)).table
        return self.joint((name,))

    def joint(self, names: Sequence[str]) -> np.ndarray:
        """Joint posterior, (W, card, ...)."""
        info, batch = self.info, self.readings.hard.shape[1]
        for name in names:
            if name not in info.row:
                raise ModelError(f"no variable {name!r} in this slice.{did_you_mean(name, info.names)}")
        needed: dict[str, None] = {}
        factors = []
        queue = list(names)
        while queue:
            name = queue.pop()
            if name in needed:
                continue
            needed[name] = None
            row = info.row[name]
            if self.status[row] == HELD:
                factors.append(Factor((name,), one_hot(self.readings.hard[row], int(info.cards[row]))))
            elif self.status[row] in (ABSORBED, BARREN):
                cpd = info.slice.by_child[name]
                table = np.broadcast_to(cpd.table, (batch, *cpd.table.shape)).copy()
                seen = np.flatnonzero(self.readings.hard[row] >= 0)
                table[seen] = 0.0
                table[seen, ..., self.readings.hard[row, seen]] = 1.0
                factors.append(Factor((*(p for p, _ in cpd.parents), name), table))
                queue += [p for p, _ in cpd.parents]
        for part, weights in zip(self.weighted.parts, self.weighted.weights):
            inside = [n for n in needed if n in part]
            if inside:
                factors.append(count(self.weighted.values, inside, weights, [int(info.cards[info.row[n]]) for n in inside]))
        table = contract_all(factors, names).table
        total = table.sum(axis=tuple(range(1, table.ndim)), keepdims=True)
        found: np.ndarray = np.divide(table, total, out=np.zeros(table.shape), where=total > 0)
        return found


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


class ParticleEngine:
    """Particle filter.

    Parameters
    ----------
    particles : int
        For each component and agent.
    seed : int, SeedSequence or Generator
    threshold : float
        A component is resampled where its effective sample size falls below this share of the particles.
    """

    name = "particles"

    def __init__(self, particles: int = 1000, seed: Any = None, threshold: float = 0.5) -> None:
        if particles < 2:
            raise ParameterError(f"`particles` is at least 2, got {particles!r}")
        self.count, self.threshold = int(particles), threshold
        self.rng = self._root = np.random.default_rng(seed)
        self.store = TableStore()
        self.temporal: frozenset[tuple[str, str]] = frozenset()
        self._structures: Recent[tuple[Any, ...], Structure] = Recent(256)

    def start(self, batch: int) -> Particles:
        """The belief before the first slice."""
        return Particles(None, {}, (), (), np.zeros((0, batch), np.int64))

    def snapshot(self) -> dict[str, Any]:
        """State of the random numbers."""
        return dict(self.rng.bit_generator.state)

    def restore(self, state: dict[str, Any]) -> None:
        """Take up the random numbers where a snapshot left them."""
        self.rng.bit_generator.state = state

    def branch(self) -> None:
        """Go on with the next of the independent streams of random numbers that the seed gives."""
        (self.rng,) = self._root.spawn(1)

    def note(self, kind: Kind) -> None:
        """Draw variables of this kind: some slice has them as parents in the previous slice."""
        self.temporal |= {(kind.class_name, kind.attribute)}

    def learn(self, info: SliceInfo) -> None:
        """Note the kinds of all previous-slice parents of a slice."""
        for cpd in info.slice.cpds:
            for parent, lag in cpd.parents:
                if lag == PREVIOUS and parent in info.row:
                    self.note(info.kinds[info.row[parent]])

    def block(self, belief: Particles, info: SliceInfo, readings: Readings, status: np.ndarray, number: int) -> Block:
        """Take some particles through one step."""
        key = belief.info, belief.parts, belief.held, info, status.tobytes()
        made = self._structures.fetch(key, lambda: Structure(belief.info, belief.parts, belief.held, info, status))
        return Block(made, self.rng, belief.values, belief.weights, belief.hard, readings, number)

    def advance(
        self,
        belief: Particles,
        info: SliceInfo,
        readings: Readings,
        status: np.ndarray | None = None,
        forgive: np.ndarray | None = None,
    ) -> Estimate:
        """Go on by one slice.

        Parameters
        ----------
        belief : Particles
        info : SliceInfo
        readings : Readings
        status : int array, optional
        forgive : int array, optional
            Agents whose components keep their weights where no particle fits the readings.
        """
        if status is None:
            status = info.status(readings.hard, readings.soft, self.temporal)
        return self.finish([self.block(belief, info, readings, status, self.count)], info, readings, status, forgive)

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
        return Estimate(belief, weighted, info, readings, status, increment, report)

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

    def replace_agents(
        self,
        estimate: Estimate,
        first: SliceInfo,
        readings: Readings,
        agents: np.ndarray,
        status: np.ndarray,
        forgive: bool = False,
    ) -> Estimate:
        """The estimate with some agents begun anew; `forgive` if they may ignore readings that even the prior excludes."""
        number = estimate.weighted.weights[0].shape[1] if estimate.weighted.weights else self.count
        block = self.block(self.start(len(agents)), first, readings, status, number)
        anew = self.finish([block], first, readings, status, np.arange(len(agents)) if forgive else None)
        increment = estimate.increment.copy()
        increment[agents] = anew.increment
        mixed = [_mix(getattr(estimate, which), getattr(anew, which), agents) for which in ("belief", "weighted")]
        report = {**estimate.report, "components": mixed[0].parts}
        return Estimate(mixed[0], mixed[1], estimate.info, estimate.readings, estimate.status, increment, report)


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
