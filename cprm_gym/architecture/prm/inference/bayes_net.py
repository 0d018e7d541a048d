"""Exact inference in a net without time: junction tree, variable elimination, most probable explanation.

    net = BayesNet(ground_slice)
    answer = net.query({"grass": "wet"})
    answer["rain"], answer.joint("rain", "sprinkler"), answer.log_evidence
    net.most_probable({"grass": "wet"})

Observations may differ between agents: every table has a leading axis for them.

References
----------
Koller and Friedman 2009, chapters 9, 10 and 13; Shafer and Shenoy 1990; dissertation section 2.3.2.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cached_property
from math import prod
from typing import Any

import numpy as np

from ....errors import EvidenceError, ImpossibleEvidence, ModelError, did_you_mean
from ..grounding.slices import PREVIOUS, SAME, GroundSlice
from ..model.domains import Index
from ..model.schema import one_or_many
from .compiled.cache import TableStore
from .compiled.slice_info import SliceInfo
from .conflicts import smallest_conflict
from .evidence import Readings, jeffrey_likelihood, one_hot, read_hard, read_soft
from .factors import Factor, contract, contract_all, multiply, union
from .join_tree import best_order, connected, join_tree, neighbours


class JunctionTree:
    """Marginals of a product of factors, by passing messages over a join tree (Shafer-Shenoy: no division).

    Parameters
    ----------
    factors : sequence of Factor
    batch : int
        Number of agents.

    Attributes
    ----------
    log_total : (W,) float array
        Logarithm of the sum of the product over all variables; -inf where it is zero. Kept in logarithms on the way, so that
        long chains do not underflow.
    """

    def __init__(self, factors: Sequence[Factor], batch: int = 1) -> None:
        self.factors = list(factors)
        self.batch = batch
        self.cards: dict[Any, int] = {}
        for f in factors:
            self.cards.update(f.cards)
        scopes = [frozenset(f.scope) for f in factors if f.scope]
        self.tree = join_tree(scopes, self.cards)
        self.log_total = np.zeros(batch)
        self._pots: dict[int, list[Factor]] = {i: [] for i in range(len(self.tree.cliques))}
        for f in factors:
            if f.scope:
                self._pots[self.tree.smallest(f.scope, self.cards)].append(f)
            else:
                with np.errstate(divide="ignore"):
                    self.log_total = self.log_total + np.log(f.table)
        self._children: dict[int, list[int]] = {i: [] for i in self._pots}
        for i, parent in enumerate(self.tree.parents):
            if parent >= 0:
                self._children[parent].append(i)
        self._up: dict[int, Factor] = {}
        self._down: dict[int, Factor] = {}
        self._beliefs: dict[int, Factor] = {}
        self._towards_root()

    def _product(self, parts: Sequence[Factor]) -> Factor:
        """Product of factors, the smallest first."""
        pool = sorted(parts, key=lambda f: f.size)
        result = Factor((), np.ones(1))
        for f in pool:
            result = multiply(result, f)
        return result

    def _towards_root(self) -> None:
        for i in reversed(range(len(self.tree.cliques))):
            joined = self._product([*self._pots[i], *(self._up[j] for j in self._children[i])])
            parent = self.tree.parents[i]
            separator = self.tree.cliques[i] & self.tree.cliques[parent] if parent >= 0 else frozenset()
            sent, log_scale = joined.sum_onto(separator).scaled()
            self._up[i] = sent
            self.log_total = self.log_total + log_scale

    def _from_parent(self, i: int) -> list[Factor]:
        """What the parent of a clique sends it."""
        parent = self.tree.parents[i]
        if parent < 0:
            return []
        if i not in self._down:
            others = [self._up[j] for j in self._children[parent] if j != i]
            joined = self._product([*self._pots[parent], *others, *self._from_parent(parent)])
            self._down[i] = joined.sum_onto(self.tree.cliques[i]).scaled()[0]
        return [self._down[i]]

    def belief(self, i: int) -> Factor:
        """Marginal of clique i, each agent's sums to one (or is zero where the evidence is impossible)."""
        if i not in self._beliefs:
            for ancestor in self._path(i):
                self._from_parent(ancestor)
            joined = self._product([*self._pots[i], *(self._up[j] for j in self._children[i]), *self._from_parent(i)])
            self._beliefs[i] = normalised(joined)
        return self._beliefs[i]

    def _path(self, i: int) -> list[int]:
        """The cliques from the root to i; messages are made in that order, so that no recursion gets deep."""
        path = []
        while i >= 0:
            path.append(i)
            i = self.tree.parents[i]
        return path[::-1]

    def joint(self, nodes: Sequence[Any]) -> np.ndarray:
        """Joint marginal of some nodes, shape (W, card, ...)."""
        inside = self.tree.containing(nodes)
        if inside:
            best = min(inside, key=lambda i: prod(self.cards[v] for v in self.tree.cliques[i]))
            table = self.belief(best).sum_onto(set(nodes)).over(nodes)
        else:
            linked = connected([tuple(nodes), *(f.scope for f in self.factors)])[0]
            chosen = [self.factors[i - 1].scaled()[0] for i in linked if i > 0]
            table = normalised(contract_all(chosen, nodes)).over(nodes)
        return np.broadcast_to(table, (self.batch, *table.shape[1:]))

    def marginal(self, node: Any) -> np.ndarray:
        """Marginal of one node, (W, card)."""
        return self.joint((node,))


def normalised(factor: Factor) -> Factor:
    """Each agent's table divided by its sum; a table of zeros stays one."""
    axes = tuple(range(1, factor.table.ndim))
    total = factor.table.sum(axis=axes, keepdims=True)
    return Factor(factor.scope, np.divide(factor.table, total, out=np.zeros(factor.table.shape), where=total > 0))


def maximise(factors: Sequence[Factor], batch: int, summed: Collection[Any] = ()) -> tuple[dict[Any, np.ndarray], np.ndarray]:
    """The assignment that makes a product of factors largest.

    Parameters
    ----------
    factors : sequence of Factor
    batch : int
    summed : collection of nodes
        Not assigned: the product is summed over them first.

    Returns
    -------
    assignment : dict of node to (W,) int array
    log_value : (W,) float array
        Logarithm of the largest product; -inf where every assignment gives zero.
    """
    pool = list(factors)
    cards: dict[Any, int] = {}
    for f in pool:
        cards.update(f.cards)
    log_value = np.zeros(batch)
    trace: list[tuple[Any, Factor]] = []
    for v in _order_after(pool, cards, summed):
        inside = sorted((f for f in pool if v in f.scope), key=lambda f: f.size)
        pool = [f for f in pool if v not in f.scope]
        joined = inside[0]
        for f in inside[1:]:
            joined = multiply(joined, f)
        joined, log_scale = joined.scaled()
        log_value = log_value + log_scale
        rest = [u for u in joined.scope if u != v]
        if v in summed:
            pool.append(joined.sum_onto(rest))
        else:
            trace.append((v, joined))
            pool.append(joined.max_onto(rest))
    for f in pool:
        with np.errstate(divide="ignore"):
            log_value = log_value + np.log(f.table)
    assignment: dict[Any, np.ndarray] = {}
    rows = np.arange(batch)
    for v, joined in reversed(trace):
        others = [u for u in joined.scope if u != v]
        table = np.broadcast_to(joined.over([*others, v]), (batch, *(cards[u] for u in others), cards[v]))
        index = (rows, *(assignment[u] for u in others))
        assignment[v] = table[index].argmax(axis=-1)
    return assignment, log_value


def _order_after(factors: Sequence[Factor], cards: Mapping[Any, int], first: Collection[Any]) -> list[Any]:
    """An order in which to eliminate all variables, some of them before all others."""
    graph = neighbours([f.scope for f in factors])
    leading = [v for v in graph if v in first]
    if not leading:
        return best_order(graph, cards)
    order = best_order({v: graph[v] & set(leading) for v in leading}, cards)
    for v in order:
        around = graph.pop(v)
        for u in around:
            graph[u] |= around
            graph[u] -= {u, v}
    return order + best_order(graph, cards)


def by_chance(info: SliceInfo, first: bool = False) -> set[str]:
    """Auxiliary variables of a slice that the declared ones do not determine: noise of an aggregate, selectors.

    With `first`, those that hang on the slice before are among them, since that slice is summed out.

    To maximise over one that is determined is to sum it out, and keeps a long chain of an aggregate cheap.
    """
    found: set[str] = set()
    for name in info.slice.order():
        cpd = info.slice.by_child.get(name)
        if cpd is not None and info.variables[name].auxiliary:
            certain = bool(((cpd.table == 0.0) | (cpd.table == 1.0)).all())
            if not certain or any((lag == SAME and parent in found) or (first and lag == PREVIOUS) for parent, lag in cpd.parents):
                found.add(name)
    return found


class Answer(Mapping[str, np.ndarray]):
    """Posteriors of a static net: a mapping from variable to (W, card) array.

    Attributes
    ----------
    log_evidence : (W,) float array
        ln P(evidence), likelihood vectors included as given.
    """

    def __init__(self, net: BayesNet, readings: Readings, batch: int) -> None:
        self._net, self._readings, self._batch = net, readings, batch
        self._tree = JunctionTree(net.factors(readings), batch)
        self.log_evidence: np.ndarray = np.broadcast_to(self._tree.log_total, (batch,))

    def __getitem__(self, name: str) -> np.ndarray:
        return self.joint(name)

    def __contains__(self, name: object) -> bool:
        return name in self._net.info.row

    def __iter__(self) -> Iterator[str]:
        return iter(self._net.info.names)

    def __len__(self) -> int:
        return len(self._net.info.names)

    def joint(self, *names: str) -> np.ndarray:
        """Joint posterior, shape (W, card, ...)."""
        for name in names:
            self._net.check(name)
        hidden = [n for n in names if n in self._tree.cards]
        table = self._tree.joint(hidden) if hidden else np.ones(self._batch)
        for axis, name in enumerate(names):
            if name in hidden:
                continue
            row = self._net.info.row[name]
            one = np.zeros((self._batch, int(self._net.info.cards[row])))
            one[np.arange(self._batch), self._readings.hard[row]] = 1.0
            shape = [self._batch] + [1] * table.ndim
            shape[axis + 1] = one.shape[1]
            table = np.expand_dims(table, axis + 1) * one.reshape(shape)
        return table

    @cached_property
    def posterior(self) -> dict[str, np.ndarray]:
        """All posteriors."""
        return {name: self[name] for name in self}


class BayesNet:
    """A net without time.

    Parameters
    ----------
    slice_ : GroundSlice
        Its CPDs have parents of the same slice only.
    """

    def __init__(self, slice_: GroundSlice) -> None:
        for cpd in slice_.cpds:
            if cpd.density is not None:
                raise ModelError(f"CPD of {cpd.child!r} has a real number; a static net has states only: take `Model.binned`")
            for parent, lag in cpd.parents:
                if lag != 0:
                    raise ModelError(f"CPD of {cpd.child!r} has parent {parent!r} with lag {lag}; a static net has no other slices")
        self.info = SliceInfo(slice_, {}, TableStore())

    def check(self, name: str) -> None:
        """Refuse a name that is no variable."""
        if name not in self.info.row:
            raise ModelError(f"no variable {name!r}.{did_you_mean(name, self.info.names)}")

    def read(self, evidence: Mapping[str, Any] | None, soft: Mapping[str, Any] | None, batch: int) -> Readings:
        """Evidence as arrays; see `evidence.py`."""
        info = self.info
        hard = read_hard(info.variables, info.names, info.cards, info.row, evidence, batch)
        for row in np.flatnonzero(info.given & (hard < 0).any(axis=1)):
            raise EvidenceError(f"{info.names[row]!r} must be given")
        return Readings(hard, read_soft(info.variables, soft, batch))

    def factors(self, readings: Readings) -> list[Factor]:
        """The net at the evidence; variables observed for every agent are gone."""
        info = self.info
        batch = readings.hard.shape[1]
        held = np.asarray((readings.hard >= 0).all(axis=1))
        out = []
        for cpd in info.slice.cpds:
            names = [*(p for p, _ in cpd.parents), cpd.child]
            out.append(sliced(names, cpd.table, {n: readings.hard[info.row[n]] for n in names if held[info.row[n]]}))
        for some in np.flatnonzero((readings.hard >= 0).any(axis=1) & ~held):
            out.append(Factor((info.names[some],), one_hot(readings.hard[some], int(info.cards[some]))))
        for name, likelihood in readings.soft.items():
            row = info.row[name]
            if held[row]:
                out.append(Factor((), likelihood[np.arange(batch), readings.hard[row]]))
            else:
                out.append(Factor((name,), likelihood))
        return out

    def query(self, evidence: Mapping[str, Any] | None = None, soft: Mapping[str, Any] | None = None, batch: int = 1) -> Answer:
        """Posteriors of all variables, by junction tree.

        Parameters
        ----------
        evidence, soft : dict
            As for `Filter.step`.
        batch : int
            Number of agents.

        Raises
        ------
        ImpossibleEvidence
            Naming a smallest conflicting set of observations.
        """
        readings = self.read(evidence, soft, batch)
        answer = Answer(self, readings, batch)
        bad = np.flatnonzero(~np.isfinite(answer.log_evidence))
        if len(bad):
            raise self._conflict(readings, bad)
        return answer

    def variable_elimination(
        self,
        names: Sequence[str],
        evidence: Mapping[str, Any] | None = None,
        soft: Mapping[str, Any] | None = None,
        batch: int = 1,
    ) -> np.ndarray:
        """Joint posterior of a few hidden variables, by variable elimination after leaving out what is barren.

        Returns
        -------
        (W, card, ...) array
        """
        readings = self.read(evidence, soft, batch)
        names = one_or_many(names)
        for name in names:
            self.check(name)
        needed = self._ancestors([*names, *(n for n, r in self.info.row.items() if (readings.hard[r] >= 0).any()), *readings.soft])
        factors = [f for f, cpd in zip(self.factors(readings), self.info.slice.cpds) if cpd.child in needed]
        factors += self.factors(readings)[len(self.info.slice.cpds) :]
        left = {v for f in factors for v in f.scope}
        observed = [n for n in names if n not in left]
        if observed:
            raise EvidenceError(f"variable_elimination: {observed[0]!r} is observed; its posterior is known")
        joint = contract_all(factors, names)
        total = joint.table.reshape(joint.table.shape[0], -1).sum(axis=1)
        if not (total > 0).all():
            raise self._conflict(readings, np.flatnonzero(np.broadcast_to(total <= 0, (batch,))))
        table = normalised(joint).table
        return np.broadcast_to(table, (batch, *table.shape[1:]))

    def _ancestors(self, names: Sequence[str]) -> set[str]:
        found: set[str] = set()
        queue = list(names)
        while queue:
            name = queue.pop()
            if name not in found:
                found.add(name)
                cpd = self.info.slice.by_child.get(name)
                queue += [p for p, _ in cpd.parents] if cpd else []
        return found

    def most_probable(
        self, evidence: Mapping[str, Any] | None = None, soft: Mapping[str, Any] | None = None, batch: int = 1
    ) -> tuple[dict[str, Index], np.ndarray]:
        """The most probable explanation: joint values of all declared variables that make the evidence most likely.

        Aggregates and selectors, which nobody declared, are summed out.

        Returns
        -------
        values : dict of name to Index of a (W,) int array
            Evidence as `query` takes it.
        log_probability : (W,) float array
            ln P(values and evidence).
        """
        readings = self.read(evidence, soft, batch)
        found, log_value = maximise(self.factors(readings), batch, by_chance(self.info))
        if not np.isfinite(log_value).all():
            raise self._conflict(readings, np.flatnonzero(~np.isfinite(log_value)))
        values = {
            name: Index(np.broadcast_to(found[name] if name in found else readings.hard[row], (batch,)))
            for name, row in self.info.row.items()
            if not self.info.variables[name].auxiliary
        }
        return values, log_value

    def jeffrey(self, name: str, target: Any, evidence: Mapping[str, Any] | None = None) -> np.ndarray:
        """The likelihood vector after which the posterior of `name` equals `target` (Jeffrey's rule).

        Returns
        -------
        (card,) array, to be given as `soft`
        """
        return np.asarray(jeffrey_likelihood(name, self.query(evidence)[name], target)[0])

    def _conflict(self, readings: Readings, agents: np.ndarray) -> ImpossibleEvidence:
        """The error that names a smallest set of observations of probability zero."""
        info = self.info
        agent = int(agents[0])
        part = readings.rows(np.array([agent]))
        names = [n for n, r in info.row.items() if (part.hard[r, 0] >= 0 or n in part.soft) and not info.given[r]]
        kept = smallest_conflict(names, lambda subsets: [self._impossible(part, subset) for subset in subsets])
        shown = [
            f"{n} = {info.variables[n].states[part.hard[info.row[n], 0]]}" if part.hard[info.row[n], 0] >= 0 else f"likelihood of {n}"
            for n in kept
        ]
        return ImpossibleEvidence(
            f"evidence of probability zero: {', '.join(shown)}", conflict=tuple(kept), agents=tuple(int(a) for a in agents)
        )

    def _impossible(self, readings: Readings, names: Sequence[str]) -> bool:
        """Whether the readings of one agent of these variables alone are impossible: a question to their ancestors."""
        info = self.info
        needed = self._ancestors(names)
        observed = {
            n: readings.hard[info.row[n]] for n in needed if readings.hard[info.row[n], 0] >= 0 and (n in names or info.given[info.row[n]])
        }
        factors = [
            sliced(scope, cpd.table, {n: observed[n] for n in scope if n in observed})
            for cpd in info.slice.cpds
            if cpd.child in needed
            for scope in ([*(p for p, _ in cpd.parents), cpd.child],)
        ]
        for name in names:
            if name in readings.soft:
                likelihood = readings.soft[name]
                factors.append(Factor((), likelihood[:, observed[name][0]]) if name in observed else Factor((name,), likelihood))
        return not bool(np.isfinite(JunctionTree(factors).log_total).all())


def sliced(scope: Sequence[Any], table: np.ndarray, observed: Mapping[Any, np.ndarray]) -> Factor:
    """A table at the values of its observed variables, which differ between agents.

    Parameters
    ----------
    scope : sequence of nodes
    table : array, one axis for each node
    observed : dict of node to (W,) int array
    """
    axes = [k for k, v in enumerate(scope) if v in observed]
    rest = [k for k, v in enumerate(scope) if v not in observed]
    if not axes:
        return Factor(tuple(scope), table[None])
    moved = np.transpose(table, axes + rest)
    return Factor(tuple(scope[k] for k in rest), moved[tuple(observed[scope[k]] for k in axes)])


__all__ = ["Answer", "BayesNet", "JunctionTree", "contract", "maximise", "normalised", "sliced", "union"]
