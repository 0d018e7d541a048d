"""Importance sampling: runs that lean to the outcome, each with its likelihood ratio."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from ....errors import ModelError
from ..bounds import Bounds
from ..kernels import paths as kernels
from ..markov.absorption import absorption
from ..markov.chain import MarkovChain
from ..sampling.runs import run_key

LEAST = 10_000
"""Runs from which the normal interval may be trusted."""


class RareEstimate(NamedTuple):
    """An estimate of a small probability, and what tells whether it can be trusted."""

    value: float
    deviation: float
    """Standard deviation of `value`, estimated."""
    interval: Bounds
    runs: int
    steps: int
    """Cycles that were simulated for it."""
    hits: int
    """Runs that ended so."""
    effective: float
    """Of how many equally weighted hits there is as much in it (Kish); few means that the interval is too narrow."""
    largest: float
    """Share of the whole that the heaviest run has."""
    balance: float
    """Mean ratio over *all* runs, which is 1: what it misses in deviations of its own."""

    @property
    def relative(self) -> float:
        """Deviation as a share of the value, infinite without a hit."""
        return self.deviation / self.value if self.value > 0 else float("inf")

    @property
    def trusted(self) -> bool:
        """Whether nothing speaks against the interval: enough runs, no run that outweighs the rest, ratios that balance."""
        return self.runs >= LEAST and self.effective >= 100 and self.largest < 0.05 and abs(self.balance) < 4

    def steps_for(self, relative: float) -> float:
        """Cycles that a relative deviation would take."""
        return self.steps * (self.relative / relative) ** 2

    def __str__(self) -> str:
        return f"{self.value:.4g} {self.interval} ({self.runs} runs, {self.steps} cycles, effective {self.effective:.0f})"


def importance_sampling(
    chain: MarkovChain, outcome: str, h: NDArray[np.float64], runs: int = LEAST, *, seed: int = 0, share: float = 0.1,
    confidence: float = 0.95, limit: int = 1_000_000,
) -> RareEstimate:  # fmt: skip
    """Estimate the probability of an outcome from runs that lean to it.

    A step goes to s' with ``(1 - share) P(s, s') h(s') / sum + share P(s, s')``; the plain part keeps every ratio bounded from above by
    1 / share a step where h is wrong. Unbiased whatever h is; good where h resembles the probability of the outcome in shape.

    Parameters
    ----------
    chain : MarkovChain
        With one state at the start.
    outcome : str
    h : (n,) float64
        A guess of the probability from each state, from a coarse or learned model, on any scale; 0 counts as tiny.
    runs, seed : int
    share : float
        Between 0 and 1.
    confidence : float
    limit : int
        Cycles after which a run counts as one that did not end so.

    Raises
    ------
    ModelError, UnknownName
    """
    start = np.flatnonzero(chain.initial)
    if len(start) != 1:
        raise ModelError(f"importance sampling starts in one state, the chain in {len(start)}")
    if not 0.0 < share <= 1.0 or runs < 2:
        raise ModelError(f"share {share}, runs {runs}: needs a share from 0 (exclusive) to 1, and two runs")
    if not 0.0 < confidence < 1.0:
        raise ModelError(f"confidence {confidence}: needs a number between 0 and 1")
    if h.shape != (chain.n,) or not (np.isfinite(h) & (h >= 0)).all():
        raise ModelError(f"h: one finite number from 0 for each of {chain.n} states, got shape {h.shape}")
    rare = np.zeros(chain.n, bool)
    rare[chain.states_of(outcome)] = True
    bias = leaning(chain, h)
    weight, steps = np.empty(runs), np.zeros(1, np.int64)
    kernels.weighted_runs(chain.offsets, chain.targets, chain.chances, bias, chain.absorbing, rare, int(start[0]), share, run_key(seed), 0,
                          limit, weight, steps)  # fmt: skip
    hits = np.maximum(weight, 0.0)
    value, deviation = float(hits.mean()), float(hits.std(ddof=1)) / runs**0.5
    half = float(norm.ppf(0.5 + confidence / 2)) * deviation
    every = np.abs(weight)
    spread = float(every.std(ddof=1)) / runs**0.5
    total = float(hits.sum())
    return RareEstimate(
        value,
        deviation,
        Bounds(max(0.0, value - half), min(1.0, value + half)),
        runs,
        int(steps[0]),
        int((weight > 0).sum()),
        total**2 / float((hits**2).sum()) if total > 0 else 0.0,
        float(hits.max()) / total if total > 0 else 1.0,
        (float(every.mean()) - 1.0) / spread if spread > 0 else 0.0,
    )


def leaning(chain: MarkovChain, h: NDArray[np.float64]) -> NDArray[np.float64]:
    """(m,) Chances that lean to where h is large: ``P h / sum``; plain ones where all successors have none."""
    tiny = float(h[h > 0].min(initial=1.0)) * 1e-3
    sources = np.repeat(np.arange(chain.n), np.diff(chain.offsets))
    pulled = chain.chances * np.where(h > 0, h, tiny)[chain.targets]
    ended = np.zeros(chain.n, bool)
    for states in chain.outcomes.values():
        ended[states] = True
    pulled[ended[chain.targets] & (h[chain.targets] == 0)] = 0.0  # other outcomes are left to the plain part
    sums = np.asarray(np.bincount(sources, weights=pulled, minlength=chain.n), np.float64)
    return np.where(sums[sources] > 0, pulled / np.where(sums > 0, sums, 1.0)[sources], chain.chances)


def learned_chain(
    transitions: NDArray[np.int64], n: int, outcomes: dict[str, NDArray[np.int64]], start: int, *, added: float = 0.5
) -> MarkovChain:
    """A chain over cells from transitions that were seen.

    Parameters
    ----------
    transitions : (k, 2) int
        From cell, to cell.
    n : int
        Cells.
    outcomes : dict of str to cells
    start : int
    added : float
        Added to the count of every kind of transition that was seen at least once.

    Returns
    -------
    MarkovChain
        Cells that were never left have the outcome "unknown".
    """
    pairs, counts = np.unique(np.asarray(transitions, np.int64).reshape(-1, 2), axis=0, return_counts=True)
    weight = counts + added
    sums = np.asarray(np.bincount(pairs[:, 0], weights=weight, minlength=n), np.float64)
    offsets = np.concatenate(([0], np.cumsum(np.bincount(pairs[:, 0], minlength=n))))
    ended = np.concatenate([np.zeros(0, np.int64), *outcomes.values()])
    unknown = np.setdiff1d(np.flatnonzero(sums == 0), ended)
    initial = np.zeros(n)
    initial[start] = 1.0
    return MarkovChain(offsets, pairs[:, 1].astype(np.int32), weight / sums[pairs[:, 0]], {**outcomes, "unknown": unknown}, initial)


def learned_h(chain: MarkovChain, outcome: str, pilot: int = 30_000, *, seed: int = 0) -> NDArray[np.float64]:
    """h of a chain that is learned from `pilot` transitions, drawn from states that are reset at random.

    Parameters
    ----------
    chain : MarkovChain
        From which transitions are drawn; its chances are not looked at otherwise.
    outcome : str
    pilot, seed : int

    Returns
    -------
    (n,) float64
    """
    rng = np.random.default_rng(seed)
    inner = np.flatnonzero(~chain.absorbing)
    sources = rng.choice(inner, pilot)
    draws = rng.random(pilot)
    targets = np.array(
        [chain.targets[kernels.successor(chain.offsets, chain.targets, chain.chances, i, u)] for i, u in zip(sources, draws)]
    )
    model = learned_chain(np.stack((sources, targets), axis=1), chain.n, dict(chain.outcomes), int(np.flatnonzero(chain.initial)[0]))
    solved = absorption(model)
    return np.asarray(np.clip(solved.probabilities[solved.outcomes.index(outcome)], 0.0, None))
