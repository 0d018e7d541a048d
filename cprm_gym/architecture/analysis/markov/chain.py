"""The value: a Markov chain with outcomes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....errors import ModelError, UnknownName, unknown_name

NEVER = "never"
"""The outcome of a run that stays for ever in states that lead to no outcome."""
STOCHASTIC = 1e-9
"""By how much a row may miss a sum of one."""


class Certified(NamedTuple):
    """A number and how far it can be from the true one.

    The bound holds for the chain as it is stored, in double precision, with what leads from a state to itself taken as what the other
    chances leave.
    """

    value: float
    error: float

    @property
    def low(self) -> float:
        """The least that it can be."""
        return self.value - self.error

    @property
    def high(self) -> float:
        """The most that it can be."""
        return self.value + self.error

    def __str__(self) -> str:
        return f"{self.value:.10g} +- {self.error:.1g}"


class States:
    """What every chain says of its states, whatever it knows of their chances."""

    offsets: NDArray[np.int64]
    outcomes: Mapping[str, NDArray[np.int64]]
    names: Sequence[str] | Callable[[int], str]

    @property
    def n(self) -> int:
        """Number of states."""
        return len(self.offsets) - 1

    @property
    def absorbing(self) -> NDArray[np.bool_]:
        """(n,) Whether each state belongs to an outcome."""
        mask = np.zeros(self.n, bool)
        for states in self.outcomes.values():
            mask[states] = True
        return mask

    def name(self, state: int) -> str:
        """What a state is called."""
        if callable(self.names):
            return self.names(state)
        return self.names[state] if len(self.names) else str(state)


@dataclass(frozen=True, eq=False)
class MarkovChain(States):
    """A finite Markov chain whose outcomes are absorbing.

    Attributes
    ----------
    offsets : (n + 1,) int64
        Where the row of each state begins in the two next, and where the last ends.
    targets : (m,) int32
    chances : (m,) float64
        Probability of going to the target in one cycle; rows sum to one.
    outcomes : mapping of str to (k,) int array
        Name -> its states. They are disjoint, and taken as never left, whatever their rows say.
    initial : (n,) float64
        Distribution at the start.
    names : sequence of str, or callable from state to str
        Of states, for whoever reads answers; empty: their numbers.

    Raises
    ------
    ModelError
        Where this is no chain; the message names the state.
    """

    offsets: NDArray[np.int64]
    targets: NDArray[np.int32]
    chances: NDArray[np.float64]
    outcomes: Mapping[str, NDArray[np.int64]]
    initial: NDArray[np.float64]
    names: Sequence[str] | Callable[[int], str] = field(default=())

    def __post_init__(self) -> None:
        for name, kind in (("offsets", np.int64), ("targets", np.int32), ("chances", np.float64), ("initial", np.float64)):
            object.__setattr__(self, name, np.ascontiguousarray(getattr(self, name), dtype=kind))
        n, edges = self.n, len(self.targets)
        if n < 1 or self.offsets[0] != 0 or self.offsets[-1] != edges or len(self.chances) != edges or (np.diff(self.offsets) < 0).any():
            raise ModelError(f"chain: offsets of {len(self.offsets)} do not cut {edges} targets and {len(self.chances)} chances into rows")
        if edges and not (self.targets.min() >= 0 and self.targets.max() < n):
            raise ModelError(f"chain: targets are states from 0 to {n - 1}, got {self.targets.min()} to {self.targets.max()}")
        bad = np.flatnonzero(~((self.chances >= 0.0) & (self.chances <= 1.0 + STOCHASTIC)))
        if bad.size:
            i = int(np.searchsorted(self.offsets, bad[0], "right")) - 1
            raise ModelError(f"chain, state {self.name(i)}: {self.chances[bad[0]]} is no probability")
        object.__setattr__(self, "outcomes", {k: np.unique(np.asarray(v, np.int64)) for k, v in dict(self.outcomes).items()})
        self._check_outcomes()
        sums = np.add.reduceat(np.append(self.chances, 0.0), np.minimum(self.offsets[:-1], edges)) * (np.diff(self.offsets) > 0)
        wrong = np.flatnonzero((np.abs(sums - 1.0) > STOCHASTIC) & ~self.absorbing)
        if wrong.size:
            raise ModelError(f"chain, state {self.name(int(wrong[0]))}: its chances sum to {sums[wrong[0]]}, not to one")
        if self.initial.shape != (n,) or not (self.initial >= 0).all() or abs(self.initial.sum() - 1.0) > STOCHASTIC:
            raise ModelError(
                f"chain: `initial` is a distribution over {n} states, got shape {self.initial.shape}, sum {self.initial.sum()}"
            )

    def _check_outcomes(self) -> None:
        if NEVER in self.outcomes:
            raise ModelError(f"chain: {NEVER!r} is what runs come to that reach no outcome; give the outcome another name")
        taken: dict[int, str] = {}
        for name, states in self.outcomes.items():
            if states.size and not (states[0] >= 0 and states[-1] < self.n):
                raise ModelError(f"chain, outcome {name!r}: states go from 0 to {self.n - 1}, got {states[0]} to {states[-1]}")
        together = np.concatenate([np.zeros(0, np.int64), *self.outcomes.values()])
        if len(np.unique(together)) != len(together):
            for name, states in self.outcomes.items():
                for s in states.tolist():
                    if s in taken:
                        raise ModelError(f"chain: state {self.name(s)} belongs to the outcomes {taken[s]!r} and {name!r}")
                    taken[s] = name

    @property
    def matrix(self) -> Any:
        """(n, n) `scipy.sparse.csr_array`; shares memory."""
        from scipy.sparse import csr_array

        return csr_array((self.chances, self.targets, self.offsets), shape=(self.n, self.n))

    def row(self, state: int) -> dict[int, float]:
        """Successors of a state and their probabilities."""
        lo, hi = int(self.offsets[state]), int(self.offsets[state + 1])
        found: dict[int, float] = {}
        for j, p in zip(self.targets[lo:hi].tolist(), self.chances[lo:hi].tolist()):
            found[j] = found.get(j, 0.0) + p
        return found

    def states_of(self, outcome: str) -> NDArray[np.int64]:
        """The states of an outcome.

        Raises
        ------
        UnknownName
        """
        if outcome not in self.outcomes:
            raise unknown_outcome(outcome, self.outcomes)
        return self.outcomes[outcome]

    @classmethod
    def from_rows(
        cls,
        rows: Sequence[Mapping[int, float] | Sequence[tuple[int, float]]],
        outcomes: Mapping[str, Sequence[int]],
        initial: int | Mapping[int, float] = 0,
        names: Sequence[str] | Callable[[int], str] = (),
    ) -> MarkovChain:
        """A chain written row by row.

        Parameters
        ----------
        rows : sequence of mappings or of pairs
            For each state, target -> probability.
        outcomes : mapping of str to states
        initial : int or mapping
            The state at the start, or a distribution.
        names : as of `MarkovChain`

        Examples
        --------
        >>> chain = MarkovChain.from_rows([{0: 0.5, 1: 0.3, 2: 0.2}, {}, {}], {"goal": [1], "lost": [2]})
        >>> chain.n, chain.row(0)
        (3, {0: 0.5, 1: 0.3, 2: 0.2})
        """
        pairs = [list(r.items()) if isinstance(r, Mapping) else [tuple(pair) for pair in r] for r in rows]
        offsets = np.cumsum([0, *(len(r) for r in pairs)])
        targets = np.array([j for r in pairs for j, _ in r], np.int64)
        if targets.size and not (targets.min() >= 0 and targets.max() < len(rows)):
            raise ModelError(f"chain: targets are states from 0 to {len(rows) - 1}, got {targets.min()} to {targets.max()}")
        chances = np.array([float(p) for r in pairs for _, p in r], np.float64)
        states = {name: np.asarray(list(given), np.int64) for name, given in outcomes.items()}
        return cls(offsets, targets.astype(np.int32), chances, states, start_at(len(rows), initial), names)


def start_at(n: int, initial: int | Mapping[int, float]) -> NDArray[np.float64]:
    """A distribution over n states: all in one, or as given.

    Raises
    ------
    ModelError
        For a state that is not there.
    """
    start = np.zeros(n)
    for state, mass in (initial if isinstance(initial, Mapping) else {int(initial): 1.0}).items():
        if not 0 <= state < n:
            raise ModelError(f"chain: the start {state} is no state from 0 to {n - 1}")
        start[state] += mass
    return start


def unknown_outcome(outcome: str, outcomes: Mapping[str, Any] | Sequence[str]) -> UnknownName:
    """The error for an outcome that is not there."""
    return unknown_name("outcome", outcome, outcomes)
