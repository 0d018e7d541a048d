"""What can be sampled: runs that are decided by a seed and their number alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ....errors import ModelError
from ..kernels import paths as kernels
from ..markov.chain import MarkovChain

UNFINISHED = "unfinished"
"""The outcome of a run that was cut off."""


class Run(NamedTuple):
    """One run."""

    outcome: str
    cycles: int
    signals: Mapping[str, NDArray[np.float64]] = {}
    """Name -> (cycles + 1,) or as many values as the run has; empty where they were not asked for."""
    values: Mapping[str, float] = {}
    """Name -> a number of the whole run, such as what it was given."""


@runtime_checkable
class Runs(Protocol):
    """A source of runs: net and world, a chain, an environment."""

    @property
    def outcomes(self) -> Sequence[str]:
        """Every outcome that a run can have."""
        ...

    def play(self, numbers: Sequence[int], seed: int, signals: bool) -> list[Run]:
        """The runs with the given numbers; the same for the same seed and number, whoever else is played beside them.

        Parameters
        ----------
        numbers : sequence of int
        seed : int
        signals : bool
            Whether signals are needed.
        """
        ...


def run_key(seed: int) -> np.uint64:
    """The word that stands for a seed in kernels."""
    return np.uint64(np.random.SeedSequence(seed).generate_state(1, np.uint64)[0])


@dataclass(frozen=True, eq=False)
class ChainRuns:
    """Runs of a Markov chain.

    Parameters
    ----------
    chain : MarkovChain
    limit : int
        Cycles after which a run is cut off (outcome `UNFINISHED`).
    signals : mapping of str to (n,) array
        Name -> its value in each state.
    """

    chain: MarkovChain
    limit: int = 100_000
    signals: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, values in self.signals.items():
            if np.shape(values) != (self.chain.n,):
                raise ModelError(f"signal {name!r}: one value for each of {self.chain.n} states, got shape {np.shape(values)}")

    @property
    def outcomes(self) -> tuple[str, ...]:
        """Those of the chain, and `UNFINISHED`."""
        return (*self.chain.outcomes, UNFINISHED)

    def play(self, numbers: Sequence[int], seed: int, signals: bool) -> list[Run]:
        """The runs with the given numbers."""
        c, key = self.chain, run_key(seed)
        final = c.absorbing
        starts = np.flatnonzero(c.initial)
        where = (c.offsets, c.targets, c.chances, final, starts, np.cumsum(c.initial[starts]), key)
        name_of = self._names()
        if not (signals and self.signals):
            end, length = np.empty(len(numbers), np.int64), np.empty(len(numbers), np.int64)
            kernels.run_many(*where, np.asarray(numbers, np.int64), self.limit, end, length)
            return [Run(name_of[e], t) for e, t in zip(end.tolist(), length.tolist())]
        runs, path = [], np.empty(self.limit + 1, np.int64)
        for number in numbers:
            states = path[: int(kernels.run_one(*where, number, path))]
            runs.append(Run(name_of[int(states[-1])], len(states) - 1, {k: np.asarray(v)[states] for k, v in self.signals.items()}))
        return runs

    def _names(self) -> dict[int, str]:
        found = {int(s): name for name, states in self.chain.outcomes.items() for s in states}
        return _Else(found)


class _Else(dict[int, str]):
    def __missing__(self, key: int) -> str:
        return UNFINISHED
