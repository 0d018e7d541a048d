"""Adaptive multilevel splitting: runs that came far are copied and go on with fresh randomness."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from ....errors import CostError, ModelError
from ..bounds import Bounds
from ..budget import Budget
from ..kernels import paths as kernels
from ..markov.chain import MarkovChain
from ..sampling.runs import run_key


class SplitEstimate(NamedTuple):
    """An estimate from independent repetitions."""

    value: float
    deviation: float
    interval: Bounds
    """Student's, over the repetitions; with many of them at 0 it is not to be trusted."""
    estimates: tuple[float, ...]
    steps: int
    reason: str = "repetitions"
    """Why it ended: "repetitions", "seconds", "interrupted"."""

    @property
    def relative(self) -> float:
        """Deviation as a share of the value."""
        return self.deviation / self.value if self.value > 0 else float("inf")

    @property
    def zeros(self) -> float:
        """Share of repetitions in which no run came there: the levels do not lead to it, or are too few."""
        return sum(e == 0.0 for e in self.estimates) / max(len(self.estimates), 1)

    def steps_for(self, relative: float) -> float:
        """Cycles that a relative deviation would take."""
        return self.steps * (self.relative / relative) ** 2


def _estimate(values: Sequence[float], steps: int, confidence: float, reason: str = "repetitions") -> SplitEstimate:
    n = len(values)
    if not n:
        return SplitEstimate(0.0, float("inf"), Bounds(0.0, 1.0), (), steps, reason)
    mean = float(np.mean(values))
    deviation = float(np.std(values, ddof=1)) / n**0.5 if n > 1 else float("inf")
    half = float(student.ppf(0.5 + confidence / 2, n - 1)) * deviation if n > 1 else float("inf")
    return SplitEstimate(mean, deviation, Bounds(max(0.0, mean - half), min(1.0, mean + half)), tuple(values), steps, reason)


def _check(runs: int, repetitions: int, killed: int | None, confidence: float) -> None:
    if runs < 2 or repetitions < 1 or not (killed is None or 1 <= killed < runs):
        raise ModelError(
            f"splitting: runs {runs}, repetitions {repetitions}, killed {killed}: needs two, one, and from one to fewer than runs"
        )
    if not 0.0 < confidence < 1.0:
        raise ModelError(f"confidence {confidence}: needs a number between 0 and 1")


def split_chain(
    chain: MarkovChain, outcome: str, level: NDArray[np.float64], runs: int = 1000, repetitions: int = 30, *, seed: int = 0,
    killed: int | None = None, longest: int = 4000, confidence: float = 0.95,
) -> SplitEstimate:  # fmt: skip
    """Adaptive multilevel splitting of a chain's runs; unbiased for every number of runs and every level function.

    Parameters
    ----------
    chain : MarkovChain
        With one state at the start.
    outcome : str
    level : (n,) float64
        How far on the way each state is.
    runs, repetitions, seed : int
    killed : int, optional
        How many runs a round takes back at least; default a tenth.
    longest : int
        Cycles that a run may have.
    confidence : float

    Raises
    ------
    CostError
        When a run is longer.
    ModelError, UnknownName
    """
    _check(runs, repetitions, killed, confidence)
    start = np.flatnonzero(chain.initial)
    if len(start) != 1 or np.shape(level) != (chain.n,) or runs < 2:
        raise ModelError(f"splitting: one state at the start, {chain.n} levels, two runs; got {len(start)}, {np.shape(level)}, {runs}")
    rare = np.zeros(chain.n, bool)
    rare[chain.states_of(outcome)] = True
    paths, lengths, highs = np.empty((runs, longest), np.int32), np.empty(runs, np.int64), np.empty(runs)
    steps = np.zeros(1, np.int64)
    values = []
    where = (chain.offsets, chain.targets, chain.chances, chain.absorbing, rare, np.asarray(level, np.float64), int(start[0]))
    for r in range(repetitions):
        value = float(kernels.split_runs(*where, killed or max(1, runs // 10), run_key(seed + 7919 * r), paths, lengths, highs, steps))
        if value < 0:
            raise CostError(f"splitting: a run is longer than {longest} cycles; raise `longest`")
        values.append(value)
    return _estimate(values, int(steps[0]), confidence)


class Splittable(Protocol):
    """Worlds that are played side by side and can be copied."""

    def begin(self, seed: int) -> None:
        """Start all of them anew, with their randomness from a seed."""

    def advance(self, active: NDArray[np.bool_]) -> None:
        """One cycle of those that are `active` (N,)."""

    def levels(self) -> NDArray[np.float64]:
        """(N,) How far each is on the way; infinite where it has come to the outcome."""

    def ended(self) -> NDArray[np.bool_]:
        """(N,) Whether each has ended, in the outcome or otherwise."""

    def keep(self, world: int) -> Any:
        """All that a world is at this moment, to be put back later."""

    def put(self, world: int, kept: Any, fresh: int) -> None:
        """Make a world what was kept, with randomness from now on that the number `fresh` gives."""


def split_worlds(
    make: Callable[[int], Splittable], runs: int = 100, repetitions: int = 10, *, seed: int = 0, killed: int | None = None,
    confidence: float = 0.95, budget: Budget | None = None,
) -> SplitEstimate:  # fmt: skip
    """The same on worlds that can be copied: a simulator with its agents.

    A copy begins where its donor first came higher than the level that was cleared, from what was kept there.

    Parameters
    ----------
    make : callable
        From the number of worlds to a `Splittable`.
    runs, repetitions, seed : int
    killed : int, optional
        How many runs a round takes back at least; default a tenth.
    confidence : float
    budget : Budget, optional
        Its seconds; what was finished by then is kept.

    Raises
    ------
    ModelError
    """
    _check(runs, repetitions, killed, confidence)
    _, clock = (budget or Budget()).start()
    worlds = make(runs)
    taken = killed or max(1, runs // 10)
    values: list[float] = []
    steps = 0
    reason = "repetitions"
    for r in range(repetitions):
        try:
            value, used = _split_once(worlds, runs, taken, np.random.SeedSequence((seed, r)), clock.spent)
        except KeyboardInterrupt:
            reason = "interrupted"
            break
        steps += used
        if value is None:
            reason = clock.reason
            break
        values.append(value)
    return _estimate(values, steps, confidence, reason)


def _numbers(rng: np.random.Generator) -> Iterator[int]:
    while True:
        yield from rng.integers(0, 2**62, 64).tolist()


def _split_once(
    worlds: Splittable, runs: int, killed: int, seeds: np.random.SeedSequence, spent: Callable[[], bool]
) -> tuple[float | None, int]:
    """One repetition; None where the time is over."""
    fresh = _numbers(np.random.default_rng(seeds))
    worlds.begin(int(next(fresh)))
    kept: list[list[tuple[float, Any]]] = [[] for _ in range(runs)]  # (new highest level, world) along each run
    highs = np.full(runs, -np.inf)
    steps = _climb(worlds, np.ones(runs, bool), highs, kept)
    factor = 1.0
    while True:
        cleared = float(np.sort(highs)[killed - 1])
        if cleared == np.inf:
            break
        if spent():
            return None, steps
        alive = np.flatnonzero(highs > cleared)
        if not alive.size:
            return 0.0, steps
        factor *= len(alive) / runs
        again = highs <= cleared
        for w in np.flatnonzero(again):
            donor = int(alive[next(fresh) % len(alive)])
            at = next(k for k, (level, _) in enumerate(kept[donor]) if level > cleared)
            kept[w] = kept[donor][: at + 1]
            worlds.put(int(w), kept[w][-1][1], int(next(fresh)))
            highs[w] = kept[w][-1][0]
        steps += _climb(worlds, again, highs, kept)
    return factor * float((highs == np.inf).mean()), steps


def _climb(worlds: Splittable, active: NDArray[np.bool_], highs: NDArray[np.float64], kept: list[list[tuple[float, Any]]]) -> int:
    """Play the active worlds to their end, keeping each at every new highest level; returns the cycles played."""
    active = active.copy()
    steps = 0
    while True:
        levels = worlds.levels()
        for w in np.flatnonzero(active & (levels > highs)):
            highs[w] = levels[w]
            kept[w].append((float(levels[w]), worlds.keep(int(w))))
        active &= ~worlds.ended()
        if not active.any():
            return steps
        worlds.advance(active)
        steps += int(active.sum())
