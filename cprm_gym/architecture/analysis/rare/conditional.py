"""Runs given how they end: the h-transform."""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....errors import ModelError
from ..kernels import chains as kernels
from ..markov.absorption import Absorption, absorption
from ..markov.chain import MarkovChain


class Cause(NamedTuple):
    """A step on which many runs to an outcome go."""

    source: int
    target: int
    flow: float
    """How often a run that ends so takes this step, on average."""
    lift: float
    """How many times more often than a run in general."""


@dataclass(frozen=True, eq=False)
class Conditional:
    """A chain given that it ends in one outcome.

    Attributes
    ----------
    chain : MarkovChain
        Its runs are those that end in the outcome, each with its conditional probability: ``P(s, s') h(s') / h(s)``.
    outcome : str
    probability : float
        Of the outcome.
    h : (n,) float64
        Probability of the outcome from each state.
    """

    chain: MarkovChain
    outcome: str
    probability: float
    h: NDArray[np.float64]
    whole: MarkovChain

    def visits(self) -> NDArray[np.float64]:
        """(n,) How often each state is visited on average by a run that ends so."""
        return expected_visits(self.chain)

    def causes(self, most: int = 10) -> list[Cause]:
        """Steps that set these runs apart: those most often taken, times the logarithm of how much more often than in general."""
        own, general = self.visits(), expected_visits(self.whole)
        sources = np.repeat(np.arange(self.whole.n), np.diff(self.whole.offsets))
        with np.errstate(divide="ignore", invalid="ignore"):
            flow = own[sources] * self.chain.chances
            plain = general[sources] * self.whole.chances
            telling = np.where((flow > 0) & (plain > 0), flow * np.log(flow / plain), -np.inf)
        best = np.argsort(-telling, kind="stable")[:most]
        return [
            Cause(int(sources[e]), int(self.whole.targets[e]), float(flow[e]), float(flow[e] / plain[e])) for e in best if telling[e] > 0
        ]

    def likeliest_run(self) -> tuple[list[int], float]:
        """The one run to the outcome that is most probable, and the share that it has of all of them."""
        c = self.chain
        best = np.full(c.n, np.inf)
        came = np.full(c.n, -1, np.int64)
        heap: list[tuple[float, int]] = []
        for i in np.flatnonzero(c.initial).tolist():
            best[i] = -math.log(c.initial[i])
            heapq.heappush(heap, (float(best[i]), i))
        final = np.zeros(c.n, bool)
        final[c.outcomes[self.outcome]] = True
        while heap:
            cost, i = heapq.heappop(heap)
            if cost > best[i]:
                continue
            if final[i]:
                run = [i]
                while came[run[-1]] >= 0:
                    run.append(int(came[run[-1]]))
                return run[::-1], math.exp(-cost)
            for e in range(c.offsets[i], c.offsets[i + 1]):
                j, p = int(c.targets[e]), float(c.chances[e])
                if p > 0 and cost - math.log(p) < best[j]:
                    best[j] = cost - math.log(p)
                    came[j] = i
                    heapq.heappush(heap, (float(best[j]), j))
        raise ModelError(f"outcome {self.outcome!r} is not reached from the start")


def conditional(chain: MarkovChain, outcome: str, solved: Absorption | None = None) -> Conditional:
    """The chain given an outcome.

    Parameters
    ----------
    chain : MarkovChain
    outcome : str
    solved : Absorption, optional
        Of the chain, where it is at hand.

    Raises
    ------
    UnknownName
    ModelError
        When the outcome cannot come.

    Examples
    --------
    >>> from ..markov.generators import walk_chain
    >>> given = conditional(walk_chain(12, 0.3, start=1), "rich")
    >>> f"{given.probability:.2e}", given.likeliest_run()[0][:4]
    ('5.12e-05', [1, 2, 3, 4])
    """
    solved = absorption(chain) if solved is None else solved
    p = solved.probability(outcome).value
    if not p > 0.0:
        raise ModelError(f"outcome {outcome!r} has probability {p}: there are no runs that end in it")
    h = np.clip(solved.probabilities[solved.outcomes.index(outcome)], 0.0, None)
    sources = np.repeat(np.arange(chain.n), np.diff(chain.offsets))
    pulled = chain.chances * h[chain.targets]
    sums = np.asarray(np.bincount(sources, weights=pulled, minlength=chain.n), np.float64)
    chances = np.where(sums[sources] > 0.0, pulled / np.where(sums > 0.0, sums, 1.0)[sources], 0.0)
    start = chain.initial * h
    final = {outcome: chain.outcomes[outcome], "impossible": np.setdiff1d(np.flatnonzero(sums == 0.0), chain.outcomes[outcome])}
    lean = MarkovChain(chain.offsets, chain.targets, chances, final, start / start.sum(), chain.names)
    return Conditional(lean, outcome, p, h, chain)


def expected_visits(chain: MarkovChain) -> NDArray[np.float64]:
    """(n,) How often each state is visited on average from the start; of final states, whether they are reached.

    By sparse factors of the transposed equations.
    """
    from scipy.sparse import csr_array, identity
    from scipy.sparse.linalg import splu

    absorbing = chain.absorbing
    inner = np.flatnonzero(~absorbing)
    reached = chain.initial > 0
    cut = np.repeat(absorbing, np.diff(chain.offsets)) | (chain.chances <= 0.0)
    sources = np.repeat(np.arange(chain.n, dtype=np.int32), np.diff(chain.offsets))
    kernels.mark_reachable(chain.offsets, np.where(cut, sources, chain.targets), reached, np.empty(chain.n, np.int32))
    inner = inner[reached[inner]]
    matrix = csr_array(chain.matrix)
    visits = chain.initial.copy()
    if inner.size:
        system = (identity(len(inner), format="csr") - matrix[inner][:, inner]).T.tocsc()
        factors = splu(system, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.0)
        found = factors.solve(chain.initial[inner])
        found += factors.solve(chain.initial[inner] - system @ found)
        visits[inner] = found
        flow = matrix[inner].T @ found
        visits[absorbing] += np.asarray(flow)[absorbing]
    return np.asarray(np.clip(visits, 0.0, None))
