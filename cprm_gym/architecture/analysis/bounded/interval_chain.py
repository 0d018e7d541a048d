"""The value: a Markov chain whose chances are known within bounds."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....errors import FormatError, ModelError
from ....files import read_bounded
from ..markov.chain import STOCHASTIC, MarkovChain, States, start_at
from ..markov.files import MAX_BYTES


@dataclass(frozen=True, eq=False)
class IntervalChain(States):
    """A finite chain with a lower and an upper chance on each edge.

    Attributes
    ----------
    offsets, targets, outcomes, initial, names : as of `MarkovChain`
        Rows name each target once.
    lower, upper : (m,) float64
        ``0 <= lower <= upper <= 1``; in each row the lower sum to at most one, the upper to at least one. Upper chances that no row
        can have, because of the lower ones of the others, are cut when the chain is made.

    Raises
    ------
    ModelError
        Where no row fits; the message names the state.
    """

    offsets: NDArray[np.int64]
    targets: NDArray[np.int32]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    outcomes: Mapping[str, NDArray[np.int64]]
    initial: NDArray[np.float64]
    names: Sequence[str] | Callable[[int], str] = field(default=())

    def __post_init__(self) -> None:
        offsets = np.ascontiguousarray(self.offsets, np.int64)
        lower, upper = np.ascontiguousarray(self.lower, np.float64), np.ascontiguousarray(self.upper, np.float64)
        edges = len(self.targets)
        if len(lower) != edges or len(upper) != edges:
            raise ModelError(f"interval chain: {len(lower)} lower and {len(upper)} upper chances for {edges} edges")
        bad = np.flatnonzero(~((lower >= 0.0) & (lower <= upper) & (upper <= 1.0 + STOCHASTIC)))
        if bad.size:
            state = int(np.searchsorted(offsets, bad[0], "right")) - 1
            raise ModelError(f"interval chain, state {state}: [{lower[bad[0]]}, {upper[bad[0]]}] is no interval of chances")
        rows = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
        sums = _sums(rows, lower, upper, len(offsets) - 1)
        middle = _between(lower, upper, rows, *sums)
        final = np.zeros(len(offsets) - 1, bool)
        for states in self.outcomes.values():
            final[np.asarray(states, np.int64)] = True
        wrong = np.flatnonzero(((sums[0] > 1.0 + STOCHASTIC) | (sums[1] < 1.0 - STOCHASTIC)) & ~final)
        if wrong.size:
            i = int(wrong[0])
            raise ModelError(f"interval chain, state {i}: chances between {sums[0][i]} and {sums[1][i]} cannot sum to one")
        plain = MarkovChain(offsets, self.targets, middle, self.outcomes, self.initial, self.names)  # checks the rest
        upper = np.clip(upper, lower, np.maximum(lower, 1.0 - (sums[0][rows] - lower)))
        for name, value in (("offsets", plain.offsets), ("targets", plain.targets), ("lower", lower), ("upper", upper),
                            ("outcomes", plain.outcomes), ("initial", plain.initial)):  # fmt: skip
            object.__setattr__(self, name, value)

    def chain(self, chances: NDArray[np.float64], outcomes: Mapping[str, NDArray[np.int64]] | None = None) -> MarkovChain:
        """The chain with the given chances on the same edges."""
        return MarkovChain(self.offsets, self.targets, chances, self.outcomes if outcomes is None else outcomes, self.initial, self.names)

    def middle(self) -> MarkovChain:
        """A chain that lies within the bounds: in each row what the lower chances leave is shared in proportion to the room above them."""
        rows = np.repeat(np.arange(self.n), np.diff(self.offsets))
        return self.chain(_between(self.lower, self.upper, rows, *_sums(rows, self.lower, self.upper, self.n)))

    def contains(self, chain: MarkovChain, tolerance: float = 1e-12) -> bool:
        """Whether a chain with the same edges lies within the bounds."""
        if not (np.array_equal(chain.offsets, self.offsets) and np.array_equal(chain.targets, self.targets)):
            return False
        return bool(((chain.chances >= self.lower - tolerance) & (chain.chances <= self.upper + tolerance)).all())

    @classmethod
    def from_rows(
        cls,
        rows: Sequence[Mapping[int, tuple[float, float]]],
        outcomes: Mapping[str, Sequence[int]],
        initial: int | Mapping[int, float] = 0,
        names: Sequence[str] | Callable[[int], str] = (),
    ) -> IntervalChain:
        """A chain written row by row: for each state, target -> (lower, upper)."""
        offsets = np.cumsum([0, *(len(row) for row in rows)])
        targets = np.array([j for row in rows for j in row], np.int32)
        bounds = np.array([pair for row in rows for pair in row.values()], np.float64).reshape(-1, 2)
        states = {name: np.asarray(list(given), np.int64) for name, given in outcomes.items()}
        return cls(offsets, targets, bounds[:, 0].copy(), bounds[:, 1].copy(), states, start_at(len(rows), initial), names)

    @classmethod
    def around(cls, chain: MarkovChain, absolute: float = 0.0, relative: float = 0.0) -> IntervalChain:
        """All chains whose chances differ from those of `chain` by at most a margin; what is 0 or 1 stays, and so do absorbing states.

        Parameters
        ----------
        chain : MarkovChain
            Rows name each target once.
        absolute, relative : float
            The margin is their sum, the second as a share of each chance.
        """
        margin = absolute + relative * chain.chances
        certain = (chain.chances <= 0.0) | (chain.chances >= 1.0)
        lower = np.where(certain, chain.chances, np.clip(chain.chances - margin, 0.0, 1.0))
        upper = np.where(certain, chain.chances, np.clip(chain.chances + margin, 0.0, 1.0))
        return cls(chain.offsets, chain.targets, lower, upper, chain.outcomes, chain.initial, chain.names)


def _sums(
    rows: NDArray[np.int64], lower: NDArray[np.float64], upper: NDArray[np.float64], n: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sum of the lower, and of the upper chances of each row."""
    least, most = (np.asarray(np.bincount(rows, weights=side, minlength=n), np.float64) for side in (lower, upper))
    return least, most


def _between(
    lower: NDArray[np.float64], upper: NDArray[np.float64], rows: NDArray[np.int64], least: NDArray[np.float64], most: NDArray[np.float64]
) -> NDArray[np.float64]:
    room = most - least
    share = np.where(room > 0.0, (1.0 - least) / np.where(room > 0.0, room, 1.0), 0.0)
    return np.clip(lower + np.clip(share, 0.0, 1.0)[rows] * (upper - lower), 0.0, 1.0)


def load_interval_chain(path: str | os.PathLike[str]) -> IntervalChain:
    """The interval chain in a JSON file.

    ``n``, ``init`` (a state), ``rows`` (lists of ``[target, lower, upper]``, numbers or fractions), and either ``classes`` (outcome ->
    states) or ``goal`` and ``target`` (states; those of ``target`` that are no ``goal`` are the outcome "other").

    Raises
    ------
    FormatError
        When it cannot be read or understood; the message names the file.
    ModelError
        When it is no chain.
    """
    file = Path(path)
    try:
        data = json.loads(read_bounded(file, MAX_BYTES))
        if "classes" in data:
            outcomes = {str(name): [int(s) for s in states] for name, states in data["classes"].items()}
        else:
            goal = [int(s) for s in data["goal"]]
            outcomes = {"goal": goal, "other": [int(s) for s in data["target"] if int(s) not in goal]}
        rows: list[dict[int, tuple[float, float]]] = []
        for row in data["rows"]:
            rows.append({int(j): (_number(lo), _number(hi)) for j, lo, hi in row})
            if len(rows[-1]) != len(row):
                raise FormatError(f"state {len(rows) - 1} names a target twice")
        if len(rows) != data["n"] or not all(0 <= j < len(rows) for row in rows for j in row):
            raise FormatError(f"{len(rows)} rows, n is {data['n']!r}; targets are states from 0 to n - 1")
        start = int(data["init"])
    except FormatError as error:
        raise FormatError(f"{file}: {error}") from None
    except KeyError as error:
        raise FormatError(f"{file}: interval chain without {error}") from None
    except (TypeError, ValueError, AttributeError, ArithmeticError, RecursionError) as error:
        raise FormatError(f"{file}: no interval chain: {error}") from None
    return IntervalChain.from_rows(rows, outcomes, start)


def _number(value: Any) -> float:
    return float(Fraction(value)) if isinstance(value, str) else float(value)
