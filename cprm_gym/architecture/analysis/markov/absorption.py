"""What a chain ends in and how long it takes, for every state, each number with a certificate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..kernels import chains as kernels
from ..kernels.graph import can_reach
from .chain import NEVER, Certified, MarkovChain, unknown_outcome
from .components import Components, components
from .solving import solve


@dataclass(frozen=True, eq=False)
class Absorption:
    """Where a chain ends.

    Attributes
    ----------
    chain : MarkovChain
    outcomes : tuple of str
        Those of the chain, then `NEVER`: caught for ever outside of all of them.
    probabilities : (len(outcomes), n) float64
        Of ending in each outcome, from every state.
    time : (n,) float64
        Expected cycles until an outcome is reached, or nothing but `NEVER` is left.
    ratios : (len(outcomes) + 1,) float64
        A state's probability, and last its time, is wrong by at most so many times its `time`; infinite where nothing is certain.
    caught : (n,) bool
        From which states no outcome is reached any more.
    methods : mapping of str to int
        How many states were solved in which way.
    """

    chain: MarkovChain
    outcomes: tuple[str, ...]
    probabilities: NDArray[np.float64]
    time: NDArray[np.float64]
    ratios: NDArray[np.float64]
    caught: NDArray[np.bool_]
    methods: Mapping[str, int]

    def _column(self, outcome: str) -> int:
        if outcome not in self.outcomes:
            raise unknown_outcome(outcome, self.outcomes)
        return self.outcomes.index(outcome)

    def probability(self, outcome: str, state: int | None = None) -> Certified:
        """Probability of an outcome from the start, or from a state.

        Raises
        ------
        UnknownName
            For an outcome that is not there.
        """
        k = self._column(outcome)
        if state is not None:
            value, error = float(self.probabilities[k, state]), float(self.ratios[k] * self.time[state]) if self.time[state] else 0.0
        else:
            value, error = _mean(
                self.chain.initial, self.probabilities[k], self.ratios[k] * self.time if np.isfinite(self.ratios[k]) else None
            )
        return Certified(min(max(value, 0.0), 1.0), error)  # what rounding takes beyond is no probability

    @property
    def expected_time(self) -> Certified:
        """Expected cycles until an outcome, from the start; infinite where it may never come."""
        if self.may_diverge:
            return Certified(float("inf"), 0.0)
        error = self.ratios[-1] * self.time if np.isfinite(self.ratios[-1]) else None
        return Certified(*_mean(self.chain.initial, self.time, error))

    @property
    def may_diverge(self) -> bool:
        """Whether some run from the start never ends in an outcome."""
        reached = self.chain.initial > 0
        kernels.mark_reachable(self.chain.offsets, _stopping(self.chain), reached, np.empty(self.chain.n, np.int32))
        return bool((reached & self.caught).any())

    @property
    def error(self) -> float:
        """The largest error of a probability from the start."""
        return max(self.probability(o).error for o in self.outcomes)

    def time_given(self, outcome: str) -> Certified:
        """Expected cycles of the runs from the start that end in an outcome; nan where none does.

        Solves the chain once more.

        Raises
        ------
        UnknownName
        """
        k = self._column(outcome)
        reward = self.probabilities[k].copy()
        values = np.zeros((self.chain.n, 2))
        # E[T; outcome] = sum of what is still to come of the probability: (I - Q) y = p
        target = solve_reward(self.chain, self.caught, reward, values)
        p = self.probability(outcome)
        total, error = _mean(self.chain.initial, values[:, 0], target * values[:, 1])
        if p.value <= p.error:
            return Certified(float("nan"), float("inf"))
        error += self.ratios[k] * float(self.chain.initial @ (self.time * values[:, 1])) if np.isfinite(self.ratios[k]) else float("inf")
        return Certified(total / p.value, (error + total / p.value * p.error) / (p.value - p.error))

    def __str__(self) -> str:
        lines = [f"{name}: {self.probability(name)}" for name in self.outcomes]
        return "\n".join([*lines, f"expected time: {self.expected_time}"])


def absorption(chain: MarkovChain, *, lump: bool = True) -> Absorption:
    """Solve a chain: the probability of each outcome, of `NEVER`, and the expected time, from every state.

    Graph first (what leads where), then component by component in topological order: single states from their successors, small components
    by elimination without subtractions, others by sweeps, stabilised bi-conjugate gradients or sparse factors, whichever gets there.
    The certificate of all values is computed last, whatever found them: with h the expected time and w = (I - Q) h > 0, a column with
    residual r is wrong by at most ``max(|r| / w) h``.

    Parameters
    ----------
    chain : MarkovChain
    lump : bool
        First put states together that no outcome tells apart, where that is cheap and saves much (`lumping`).
        The certificate is of the chain as it was.

    Examples
    --------
    >>> chain = MarkovChain.from_rows([{0: 0.5, 1: 0.3, 2: 0.2}, {}, {}], {"goal": [1], "lost": [2]})
    >>> found = absorption(chain)
    >>> print(f"{found.probability('goal').value:.3f} in {found.expected_time.value:.1f} cycles, error below 1e-14: {found.error < 1e-14}")
    0.600 in 2.0 cycles, error below 1e-14: True
    """
    from .lumping import worthwhile_lumping

    blocks = worthwhile_lumping(chain) if lump else None
    if blocks is not None:
        small = absorption(blocks.chain, lump=False)
        at = blocks.block
        values = np.vstack((small.probabilities, small.time))[:, at]
        methods = {**small.methods, "lumped away": chain.n - blocks.chain.n}
        return _certified(chain, values, small.caught[at], methods)
    parts = components(chain)
    caught = caught_states(chain, parts)
    values = boundary_values(chain, caught)
    methods = solve(chain, parts, chain.absorbing | caught, values)
    return _certified(chain, values, caught, methods)


def boundary_values(chain: MarkovChain, caught: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(outcomes + 2, n) What is known at once: one for its outcome in each absorbing state, and for `NEVER` in those that are caught."""
    values = np.zeros((len(chain.outcomes) + 2, chain.n))
    for k, states in enumerate(chain.outcomes.values()):
        values[k, states] = 1.0
    values[len(chain.outcomes), caught] = 1.0
    return values


def caught_states(chain: MarkovChain, parts: Components) -> NDArray[np.bool_]:
    """(n,) From which states no outcome can be reached."""
    reaching = np.zeros(chain.n, bool)
    can_reach(chain.offsets, parts.targets, parts.component, parts.start, parts.nodes, chain.absorbing, False, reaching)
    return ~reaching


def solve_reward(chain: MarkovChain, caught: NDArray[np.bool_], reward: NDArray[np.float64], values: NDArray[np.float64]) -> float:
    """Expected sum of a reward until the end into column 0 of `values` (n, 2), expected time into column 1.

    Returns
    -------
    float
        The sum is wrong by at most so many times the expected time.

    By the chain's own sparse factors; for many states of one component this can take long.
    """
    from scipy.sparse import csr_array, diags_array, identity
    from scipy.sparse.linalg import splu

    open_ = ~(chain.absorbing | caught)
    states = np.flatnonzero(open_)
    if not states.size:
        return 0.0
    q = csr_array(chain.matrix)[states][:, states]
    system = (identity(len(states), format="csr") - q).tocsc()
    factors = splu(system, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.0)
    right = np.column_stack((reward[states], np.ones(len(states))))
    found = factors.solve(right)
    found += factors.solve(right - system @ found)
    values[states] = found
    lack = np.abs(right - system @ found)
    degree = np.diff(q.indptr)[:, None] + 4
    absolute = diags_array(np.abs(system.diagonal())) + abs(q)
    lack += 1.01 * degree * kernels.UNIT * (absolute @ np.abs(found) + right)
    w = 1.0 - lack[:, 1]
    return float((lack[:, 0] / w).max()) if (w > 0).all() and (found[:, 1] > 0).all() else float("inf")


def _certified(chain: MarkovChain, values: NDArray[np.float64], caught: NDArray[np.bool_], methods: Mapping[str, int]) -> Absorption:
    ratios = np.zeros(len(values))
    if not kernels.certify(chain.offsets, chain.targets, chain.chances, chain.absorbing | caught, values, ratios):
        ratios[:] = np.inf
    return Absorption(chain, (*chain.outcomes, NEVER), values[:-1], values[-1], ratios, caught, methods)


def _mean(start: NDArray[np.float64], values: NDArray[np.float64], errors: NDArray[np.float64] | None) -> tuple[float, float]:
    """Mean over the start, and its error with the rounding of the sum; no errors known: infinite."""
    at = np.flatnonzero(start)
    value = float(start[at] @ values[at])
    if errors is None:
        return value, float("inf")
    rounding = (len(at) + 1) * kernels.UNIT * float(start[at] @ np.abs(values[at]))
    return value, float(start[at] @ errors[at]) + (rounding if len(at) > 1 else 0.0)


def _stopping(chain: MarkovChain) -> NDArray[np.int32]:
    """The targets with those of absorbing states led back to themselves."""
    targets = chain.targets
    rows = np.repeat(chain.absorbing, np.diff(chain.offsets))
    if rows.any():
        targets = targets.copy()
        targets[rows] = np.repeat(np.arange(chain.n, dtype=np.int32), np.diff(chain.offsets))[rows]
    return targets
