"""Exact filtering: the belief as a set of factors, carried from slice to slice by compiled plans.

The belief after a slice is a product of factors over its hidden variables. A step shifts it one slice back, multiplies the
CPDs that the active relations give, puts in the readings, and sums out the variables of the past only (`plans.py`). Which of
the present ones matter is decided by the next slice, so relations may switch on and off at any time and the answer is the one
of the unrolled, non-homogeneous net.

References
----------
Murphy, Dynamic Bayesian Networks, 2002, section 3; dissertation sections 2.3.3 and 2.3.4.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from cprm_gym.errors import CostError, ModelError, ParameterError, did_you_mean

from ...grounding.slices import STATIC
from ..compiled.steps import (
    ABSORBED,
    BARREN,
    EMPTY,
    HELD,
    PRESENT,
    Choose,
    Compiler,
    Group,
    Kind,
    Layout,
    SliceInfo,
    SliceStep,
    TableStore,
)
from ..evidence import Readings
from ..factors import Factor, contract_all
from ..join_tree import connected


class FactoredBelief(NamedTuple):
    """All that is known after a slice. Its arrays are never changed, so a belief is its own snapshot.

    Attributes
    ----------
    layout : Layout
    messages : tuple of (objects * W, columns) float arrays
    hard : (V, W) int array
        Readings of the slice.
    """

    layout: Layout
    messages: tuple[np.ndarray, ...]
    hard: np.ndarray


class ComponentCost(NamedTuple):
    """What one component of a step takes, for all agents."""

    variables: tuple[str, ...]
    """Hidden variables of the past and the present slice, those of the first object if several are alike."""
    objects: int
    """How many like components run as one batch."""
    bytes: int
    """Working memory, belief included."""
    flops: float
    largest: int
    """Entries of the largest table."""


@dataclass
class Outcome:
    """What one step gave.

    Attributes
    ----------
    belief : FactoredBelief
    info : SliceInfo
    readings : Readings
    slice_step : SliceStep
    marginals : list of (objects * W, columns) float arrays
    increment : (W,) float array
        ln P(readings of this slice | those of earlier ones); -inf where impossible.
    loss : (W,) float array
        Kullback-Leibler divergence of the projection, nats; zero if nothing was projected.
    sums : list of (objects * W, roots) float arrays
        Normalising constants of each group of components.
    replaced : list of (agents, Outcome)
        Agents whose answer comes from another step: those that began anew.
    """

    belief: FactoredBelief
    info: SliceInfo
    readings: Readings
    slice_step: SliceStep
    marginals: list[np.ndarray]
    increment: np.ndarray
    loss: np.ndarray
    sums: list[np.ndarray]
    replaced: list[tuple[np.ndarray, Outcome]] = field(default_factory=list)
    engine: str = "exact"
    report: dict[str, Any] = field(default_factory=dict)

    @property
    def exact_step(self) -> bool:
        """Whether the step approximated nothing."""
        return "clusters" not in self.report

    def __post_init__(self) -> None:
        self.batch = int(self.readings.hard.shape[1])

    def excluded(self, agent: int) -> list[tuple[Group, int]]:
        """Components in which an agent's readings are impossible: their group and number in it."""
        found = []
        for group, sums in zip(self.slice_step.groups, self.sums):
            for b in range(len(group.members)):
                if (sums[b * self.batch + agent] <= 0.0).any():
                    found.append((group, b))
        return found

    @property
    def impossible(self) -> np.ndarray:
        """(W,) bool array: where the readings have probability zero."""
        return np.asarray(~np.isfinite(self.increment))

    def marginal(self, name: str) -> np.ndarray:
        """P(variable | all readings so far), shape (W, card)."""
        at = self.slice_step.where.get(name)
        if at is not None:
            group, instance, column, card = at
            batch = self.batch
            found: np.ndarray = self.marginals[group][instance * batch : (instance + 1) * batch, column : column + card]
        else:
            found = self.joint((name,))
        if self.replaced:
            found = found.copy()
            for agents, other in self.replaced:
                found[agents] = other.marginal(name)
        return found

    def factors(self) -> list[Factor]:
        """The belief as factors; a variable is named (name, slice), slice 0 or -1 for a static one."""
        return belief_factors(self.belief, self.batch)

    def conditional(self, name: str) -> Factor:
        """P(reading | its parents, what was observed of it), for a variable that is not in the belief."""
        info, row = self.info, self.info.row[name]
        cpd = info.slice.by_child[name]
        scope = tuple((p, STATIC if p in info.row and info.static[info.row[p]] else PRESENT) for p, _ in cpd.parents) + ((name, PRESENT),)
        table = np.broadcast_to(cpd.table, (self.batch, *cpd.table.shape)).copy()
        values = self.readings.hard[row]
        seen = np.flatnonzero(values >= 0)
        table[seen] = 0.0
        table[seen, ..., values[seen]] = 1.0
        return Factor(scope, table)

    def joint(self, names: Sequence[str]) -> np.ndarray:
        """P(variables | all readings so far), shape (W, card, ...), axes in the order of `names`."""
        info = self.info
        for name in names:
            if name not in info.row:
                raise ModelError(f"no variable {name!r} in this slice.{did_you_mean(name, info.names)}")
        if len(set(names)) != len(names):
            raise ModelError(f"a variable is named twice in {tuple(names)}")
        status = self.slice_step.status
        factors = self.factors()
        queue, added = list(names), set()
        while queue:
            name = queue.pop()
            row = info.row[name]
            if name in added:
                continue
            added.add(name)
            if status[row] == HELD:
                table = np.zeros((self.batch, int(info.cards[row])))
                table[np.arange(self.batch), self.readings.hard[row]] = 1.0
                factors.append(Factor(((name, PRESENT),), table))
            elif status[row] in (ABSORBED, BARREN):
                factors.append(self.conditional(name))
                queue += [p for p, _ in info.slice.by_child[name].parents]
        wanted = [(n, STATIC if info.static[info.row[n]] else PRESENT) for n in names]
        linked = connected([wanted, *(f.scope for f in factors)])[0]
        factors = [factors[i - 1] for i in linked if i > 0]
        table = contract_all(factors, wanted).table
        table = np.broadcast_to(table, (self.batch, *table.shape[1:]))
        total = table.sum(axis=tuple(range(1, table.ndim)), keepdims=True)
        found: np.ndarray = np.divide(table, total, out=np.zeros(table.shape), where=total > 0)
        for agents, other in self.replaced:
            found[agents] = other.joint(names)
        return found


def belief_factors(belief: FactoredBelief, batch: int) -> list[Factor]:
    """The factors of a belief, each with a leading axis for the agents."""
    info = belief.layout.info
    factors = []
    for piece in belief.layout.pieces:
        message = belief.messages[piece.group]
        rows = message[piece.instance * batch : (piece.instance + 1) * batch]
        for f in piece.factors:
            assert info is not None
            shape = [int(info.cards[info.row[name]]) for name, _ in f.scope]
            factors.append(Factor(f.scope, rows[:, f.column : f.column + f.size].reshape(batch, *shape)))
    return factors


class ExactEngine:
    """Compiles and runs steps.

    Parameters
    ----------
    memory_limit : float
        Bytes that one component may take; a larger one is refused before it is run.
    threads : int
        How many threads share the agents of a batch. Results do not depend on it.
    """

    name = "exact"

    def __init__(self, memory_limit: float = 2.0**31, threads: int = 1) -> None:
        if threads < 1:
            raise ParameterError(f"`threads` is at least 1, got {threads!r}")
        self.threads = threads
        self.pool = ThreadPoolExecutor(threads) if threads > 1 else None
        self.store = TableStore()
        self.compiler = Compiler(self.store)
        self.memory_limit = memory_limit
        self.temporal: frozenset[tuple[str, str]] = frozenset()

    def start(self, batch: int) -> FactoredBelief:
        """The belief before the first slice."""
        return FactoredBelief(EMPTY, (), np.zeros((0, batch), np.int64))

    def note(self, kind: Kind) -> None:
        """Keep variables of this kind in the belief from now on: some slice has them as parents in the previous slice."""
        self.temporal |= {(kind.class_name, kind.attribute)}

    def learn(self, info: SliceInfo) -> None:
        """Note the kinds of all previous-slice parents of a slice."""
        for cpd in info.slice.cpds:
            for parent, lag in cpd.parents:
                if lag == 1 and parent in info.row:
                    self.note(info.kinds[info.row[parent]])

    def choose(self, belief: FactoredBelief, info: SliceInfo) -> tuple[Choose | None, Hashable]:
        """How to project each component, and a mark of that choice; an exact engine keeps all."""
        return None, None

    def slice_step(self, belief: FactoredBelief, info: SliceInfo, readings: Readings, status: np.ndarray | None = None) -> SliceStep:
        """The compiled step; made if it is new."""
        if status is None:
            status = info.status(readings.hard, readings.soft, self.temporal)
        choose, mark = self.choose(belief, info)
        return self.compiler.slice_step(belief.layout, info, status, choose, mark)

    def cost(self, slice_step: SliceStep, batch: int) -> list[ComponentCost]:
        """What the components of a step take, the largest first."""
        costs = []
        for group in slice_step.groups:
            rows = len(group.members) * batch
            one = group.plan.cost
            memory = one.bytes + 8 * rows * (group.plan.message_size + group.plan.marginal_size)
            names = tuple(f"{name}[t-1]" if lag == 1 else name for name, lag in group.members[0])
            costs.append(ComponentCost(names, len(group.members), memory, one.flops * rows, one.largest))
        return sorted(costs, key=lambda c: -c.bytes)

    def check(self, slice_step: SliceStep, batch: int) -> None:
        """Refuse a step that would take more memory than is allowed.

        Raises
        ------
        CostError
        """
        for group in slice_step.groups:
            memory = group.plan.cost.bytes + 8 * len(group.members) * batch * group.plan.message_size
            if memory > self.memory_limit:
                names = ", ".join(sorted({name for name, _ in group.members[0]})[:12])
                raise CostError(
                    f"the component of {names} needs {memory / 2**30:.2f} GiB for {batch} agents, allowed are "
                    f"{self.memory_limit / 2**30:.2f}; project it (engine='projection' or 'anytime') or raise `memory_limit`"
                )

    def advance(self, belief: FactoredBelief, info: SliceInfo, readings: Readings, status: np.ndarray | None = None) -> Outcome:
        """Go on by one slice. The given belief stays as it is.

        Raises
        ------
        NeedsVariable, CostError, ModelError
        """
        slice_step = self.slice_step(belief, info, readings, status)
        self.check(slice_step, readings.hard.shape[1])
        return self.run(belief, info, readings, slice_step)

    def run(self, belief: FactoredBelief, info: SliceInfo, readings: Readings, slice_step: SliceStep) -> Outcome:
        """Run a compiled step."""
        batch = readings.hard.shape[1]
        soft = soft_array(slice_step, info, readings)
        messages, marginals, sums = [], [], []
        increment = np.zeros(batch)
        for group in slice_step.groups:
            incoming = slice_step.assemble(group, belief.messages, batch)
            message, found, totals, _ = group.plan.run(
                incoming, group.columns, readings.hard, belief.hard, soft, group.soft_at, increment, self.pool, self.threads
            )
            messages.append(message)
            marginals.append(found)
            sums.append(totals)
        after = FactoredBelief(slice_step.layout, tuple(messages), readings.hard)
        return Outcome(after, info, readings, slice_step, marginals, increment, np.zeros(batch), sums, engine=self.name)


def soft_array(slice_step: SliceStep, info: SliceInfo, readings: Readings) -> np.ndarray:
    """Likelihood vectors of all `WEIGHTED` variables side by side, (W, columns)."""
    batch = readings.hard.shape[1]
    out = np.ones((batch, slice_step.soft_width))
    for name, columns in slice_step.soft_columns.items():
        values = readings.hard[info.row[name]]
        seen = np.flatnonzero(values >= 0)
        block = out[:, columns]
        block[seen] = 0.0
        block[seen, values[seen]] = 1.0
        if name in readings.soft:
            block *= readings.soft[name]
    return out
