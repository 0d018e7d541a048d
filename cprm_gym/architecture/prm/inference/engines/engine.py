"""What an engine is: a way to carry a belief from slice to slice.

A belief is a value of the engine's own kind, and all that an engine remembers besides (plans, structures) changes how long a step
takes, never its answer. An engine *declares* what it can do: whether its answers are exact, whether beliefs of agents can be taken
apart and joined. What it cannot do it refuses by name.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Sequence
from typing import Any, ClassVar, NamedTuple, NoReturn

import numpy as np

from cprm_gym.errors import ModelError, ParameterError, did_you_mean

from ...grounding.slices import PREVIOUS
from ...model.domains import Index
from .. import smoothing
from ..compiled.belief import FactoredBelief
from ..compiled.cache import TableStore
from ..compiled.slice_info import ABSORBED, BARREN, HELD, Kind, SliceInfo
from ..evidence import Readings, one_hot
from ..factors import Factor, contract_all
from ..join_tree import connected


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


class StepResult(ABC):
    """What one step of an engine gave.

    Attributes
    ----------
    belief : engine's own kind
        After the step.
    info : SliceInfo
    readings : Readings
    status : (V,) int array
        How each variable entered the step (`slice_info`).
    increment : (W,) float array
        ln P(readings of this slice | those of earlier ones); -inf where impossible.
    loss : (W,) float array
        Kullback-Leibler divergence, in nats, of what was thrown away.
    exact : bool
        The step approximated nothing.
    engine : str
        Which way gave the answer.
    report : dict
        What else there is to say.
    """

    sampled: ClassVar[bool] = False
    """The answer is taken from samples."""

    belief: Any
    info: SliceInfo
    readings: Readings
    status: np.ndarray
    increment: np.ndarray
    loss: np.ndarray
    exact: bool
    engine: str
    report: dict[str, Any]

    @property
    def batch(self) -> int:
        """Number of agents."""
        return int(self.readings.hard.shape[1])

    @property
    def impossible(self) -> np.ndarray:
        """(W,) bool array: where the readings have probability zero."""
        return np.asarray(~np.isfinite(self.increment))

    @abstractmethod
    def marginal(self, name: str) -> np.ndarray:
        """P(variable | all readings so far), shape (W, card)."""

    @abstractmethod
    def hidden_factors(self, names: Sequence[str]) -> list[Factor]:
        """Factors over hidden variables, by name, whose product has the joint of `names` as its marginal."""

    @abstractmethod
    def suspects(self, agent: int) -> list[str]:
        """Observed variables of the components in which an agent's readings are impossible, except what is given."""

    def joint(self, names: Sequence[str]) -> np.ndarray:
        """P(variables | all readings so far), shape (W, card, ...), axes in the order of `names`."""
        for name in names:
            if name not in self.info.row:
                raise ModelError(f"no variable {name!r} in this slice.{did_you_mean(name, self.info.names)}")
        if len(set(names)) != len(names):
            raise ModelError(f"a variable is named twice in {tuple(names)}")
        factors, needed = self._around(names)
        factors += self.hidden_factors(needed)
        linked = connected([tuple(names), *(f.scope for f in factors)])[0]
        table = contract_all([factors[i - 1] for i in linked if i > 0], names).table
        table = np.broadcast_to(table, (self.batch, *table.shape[1:]))
        total = table.sum(axis=tuple(range(1, table.ndim)), keepdims=True)
        found: np.ndarray = np.divide(table, total, out=np.zeros(table.shape), where=total > 0)
        return found

    def moments(self, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
        """Mean (W, n) and covariance (W, n, n) of real numbers; an engine for states has none.

        Raises
        ------
        ModelError
        """
        raise ModelError(f"engine {self.engine!r} keeps states; moments are of real numbers, with the engine 'mixture'")

    def components(self, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Weights (W, K), means (W, K, n) and covariances (W, K, n, n) of the normals over real numbers.

        Raises
        ------
        ModelError
        """
        raise ModelError(f"engine {self.engine!r} keeps states; normals are of real numbers, with the engine 'mixture'")

    def _around(self, names: Sequence[str]) -> tuple[list[Factor], list[str]]:
        """Factors of the variables that are not in the belief, observed or left out, and the hidden ones that they depend on."""
        info, factors = self.info, []
        hidden: dict[str, None] = {}
        queue, seen = list(names), set()
        while queue:
            name = queue.pop()
            if name in seen:
                continue
            seen.add(name)
            row = info.row[name]
            if self.status[row] == HELD:
                factors.append(Factor((name,), one_hot(self.readings.hard[row], int(info.cards[row]))))
            elif self.status[row] in (ABSORBED, BARREN):
                factors.append(self._conditional(name))
                queue += [p for p, _ in info.slice.by_child[name].parents]
            else:
                hidden[name] = None
        return factors, list(hidden)

    def _conditional(self, name: str) -> Factor:
        """P(reading | its parents, what was observed of it), for a variable that is not in the belief."""
        cpd = self.info.slice.by_child[name]
        table = np.broadcast_to(cpd.table, (self.batch, *cpd.table.shape)).copy()
        values = self.readings.hard[self.info.row[name]]
        seen = np.flatnonzero(values >= 0)
        table[seen] = 0.0
        table[seen, ..., values[seen]] = 1.0
        return Factor((*(p for p, _ in cpd.parents), name), table)


class Engine(ABC):
    """Base of all engines.

    Attributes
    ----------
    name : str
    exact : bool
        Every answer is that of the unrolled net.
    divisible : bool
        Beliefs of agents can be taken apart and joined (`form`, `select`, `join`, `renamed`).
    continuous : bool
        Real numbers stay such; for other engines a filter cuts them into their bins.
    store : TableStore
        Tables and indexed slices.
    temporal : frozenset of (class, attribute)
        Kinds of variables that some slice has as parents in the previous slice: these are kept in the belief.
    """

    name: ClassVar[str]
    exact: ClassVar[bool]
    divisible: ClassVar[bool] = False
    continuous: ClassVar[bool] = False

    store: TableStore
    temporal: frozenset[tuple[str, str]]

    # ------------------------------------------------------------------------------------------------- steps

    @abstractmethod
    def start(self, batch: int) -> Any:
        """The belief before the first slice. Engines that sample give each belief a stream of random numbers of its own."""

    @abstractmethod
    def advance(self, belief: Any, info: SliceInfo, readings: Readings, forgive: np.ndarray | None = None) -> StepResult:
        """Go on by one slice. The given belief stays as it is.

        Parameters
        ----------
        belief : engine's own kind
        info : SliceInfo
        readings : Readings
        forgive : int array, optional
            For engines that sample: agents who ignore readings that no sample fits.

        Raises
        ------
        NeedsVariable
            The belief lacks a variable of the previous slice; the last step has to be made again after `note`.
        CostError, ModelError
        """

    @abstractmethod
    def replace_agents(self, result: StepResult, first: SliceInfo, readings: Readings, agents: np.ndarray, forgive: bool) -> StepResult:
        """The result with some agents begun anew.

        Parameters
        ----------
        result : StepResult
            Of all agents, as if all went on.
        first : SliceInfo
            The first slice.
        readings : Readings
            Of the agents concerned, rows in the order of `first`.
        agents : int array
            Which agents.
        forgive : bool
            Samples may ignore readings that even the prior excludes.
        """

    def note(self, kind: Kind) -> None:
        """Keep variables of this kind in the belief from now on: some slice has them as parents in the previous slice."""
        self.temporal |= {(kind.class_name, kind.attribute)}

    def learn(self, info: SliceInfo) -> None:
        """Note the kinds of all previous-slice parents of a slice."""
        for cpd in info.slice.cpds:
            for parent, lag in cpd.parents:
                if lag == PREVIOUS and parent in info.row:
                    self.note(info.kinds[info.row[parent]])

    # ------------------------------------------------------------------------------------------------- plans

    def cost(self, belief: Any, info: SliceInfo, readings: Readings) -> list[ComponentCost]:
        """What the components of a step take, the largest first."""
        self._cannot("has no plans whose cost could be told")

    def prepare(self, belief: Any, info: SliceInfo, readings: Readings) -> Any:
        """Make the plan of a step without running it; the form of the belief after it."""
        self._cannot("has no plans to prepare")

    @property
    def compiled(self) -> int:
        """How many plans were made so far."""
        return 0

    # ------------------------------------------------------------------------------------------------- agents

    def form(self, belief: Any) -> Hashable:
        """What two beliefs must share to be joined."""
        self._cannot("keeps beliefs that cannot be joined")

    def select(self, belief: Any, agents: np.ndarray) -> Any:
        """The belief of some agents."""
        self._cannot("keeps beliefs that cannot be taken apart")

    def join(self, beliefs: Sequence[Any]) -> Any:
        """The belief of the agents of several beliefs of one form."""
        self._cannot("keeps beliefs that cannot be joined")

    def renamed(self, belief: Any, info: SliceInfo, pairs: tuple[tuple[str, str], ...]) -> Any:
        """The belief with other names for its variables, old and new of each; `info` is a slice with the new ones."""
        self._cannot("keeps beliefs that cannot be renamed")

    # ------------------------------------------------------------------------------------------------- beliefs as factors

    def factored(self, belief: Any) -> FactoredBelief:
        """The belief as a product of factors."""
        self._cannot("keeps no belief of factors")

    def handed_over(self, belief: Any) -> Any:
        """The belief in the form from which other engines go on with `adopt`: its factors, where numbers are bins."""
        return self.factored(belief)

    def adopt(self, belief: Any) -> Any:
        """A belief that was handed over as one of this engine's own."""
        self._cannot("cannot go on from a belief of factors")

    def project(self, belief: Any, clusters: Sequence[Sequence[str]]) -> tuple[Any, np.ndarray]:
        """The belief as the product of its clusters' marginals, and the loss, (W,) nats."""
        self._cannot("keeps no belief of factors to project")

    def smooth(self, window: Sequence[smoothing.Slice]) -> list[smoothing.Smoothed]:
        """Posteriors of the slices of a window given all its readings."""
        return smoothing.smooth([s._replace(before=self.factored(s.before)) for s in window])

    def most_probable_path(self, window: Sequence[smoothing.Slice]) -> list[dict[str, Index]]:
        """The most probable joint values of all variables of a window."""
        return smoothing.most_probable_path([s._replace(before=self.factored(s.before)) for s in window])

    def expected_counts(self, window: Sequence[smoothing.Slice]) -> dict[Hashable, np.ndarray]:
        """Expected counts of every row and state of each class-level CPD in a window."""
        return smoothing.expected_counts([s._replace(before=self.factored(s.before)) for s in window])

    def sample(self, belief: Any, count: int, rng: np.random.Generator) -> dict[str, np.ndarray]:
        """Joint samples of the variables of a belief, dict of name to (W, count) int array."""
        return smoothing.sample_belief(self.factored(belief), count, rng)

    # ------------------------------------------------------------------------------------------------- impossible readings

    def conflict(self, before: Any, result: StepResult, agent: int) -> list[str]:
        """Readings of an agent that are impossible together; as few as the engine can tell."""
        return result.suspects(agent)

    def _cannot(self, what: str) -> NoReturn:
        raise ParameterError(f"engine {self.name!r} {what}")


def status_of_beginners(result: StepResult, first: SliceInfo, readings: Readings, temporal: frozenset[tuple[str, str]]) -> np.ndarray:
    """Status of the variables of a first slice: as in the step of the others where both have them."""
    order = [result.info.row.get(name, -1) for name in first.names]
    status = np.where(np.array(order) >= 0, result.status[order], 0).astype(result.status.dtype)
    if min(order, default=0) < 0:
        own = first.status(readings.hard, readings.soft, temporal)
        status = np.where(np.array(order) >= 0, status, own).astype(result.status.dtype)
    return status
