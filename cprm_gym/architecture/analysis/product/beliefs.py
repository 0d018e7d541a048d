"""A belief as part of the state (§3.2.3): exact, for runs; or in cells of its probability, sound by [inf, sup] over each cell.

The first way of the text, that what the belief is about is known, needs nothing of this: the world's percepts name the belief place.
Here the agent filters a variable of two states from noisy readings. Its belief is one number, and both prediction and Bayes' rule are
monotone in it; so what becomes of a cell lies between what becomes of its ends. Where that touches several cells nature picks among
them: bounds hold for the agent's true belief, and narrow with the cells.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ....errors import ImpossibleEvidence, ModelError
from .worlds import Step, World


@dataclass(frozen=True)
class TwoStateFilter:
    """What the agent believes of a variable that is true or not.

    Parameters
    ----------
    reading : str
        Percept that tells of it.
    likelihood : mapping of float to (float, float)
        Reading -> its probability where the variable is true, and where it is not.
    moves : (float, float)
        Probability that it is true in the next cycle, where it is true and where it is not.
    moved_by : mapping of str to (float, float), optional
        The same after a command; the first that went out counts.
    prior : float
        At the beginning.

    Raises
    ------
    ModelError
    """

    reading: str
    likelihood: Mapping[float, tuple[float, float]]
    moves: tuple[float, float] = (1.0, 0.0)
    moved_by: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    prior: float = 0.5

    def __post_init__(self) -> None:
        chances = [*self.moves, self.prior, *(p for pair in (*self.likelihood.values(), *self.moved_by.values()) for p in pair)]
        if not self.likelihood or not all(0.0 <= p <= 1.0 for p in chances):
            raise ModelError(f"filter of {self.reading!r}: needs likelihoods, and probabilities between 0 and 1")

    def corrected(self, belief: float, reading: float) -> float:
        """Bayes' rule.

        Raises
        ------
        ModelError
            For a reading without a likelihood.
        ImpossibleEvidence
            When it could not have come.
        """
        if reading not in self.likelihood:
            known = ", ".join(f"{k:g}" for k in self.likelihood)
            raise ModelError(f"filter of {self.reading!r}: no likelihood of the reading {reading:g}; there are {known}")
        yes, no = self.likelihood[reading]
        total = belief * yes + (1.0 - belief) * no
        if total <= 0.0:
            raise ImpossibleEvidence(f"filter of {self.reading!r}: the reading {reading:g} has probability zero with belief {belief:g}")
        return min(max(belief * yes / total, 0.0), 1.0)

    def updated(self, belief: float, commands: Sequence[str], reading: float) -> float:
        """One cycle on: predicted, then corrected."""
        yes, no = next((self.moved_by[c] for c in commands if c in self.moved_by), self.moves)
        return self.corrected(belief * yes + (1.0 - belief) * no, reading)


@dataclass(frozen=True, eq=False)
class BeliefWorld:
    """A world, and an agent's belief about it as a belief place of the net reads it.

    Parameters
    ----------
    world : World
    place : str
        The belief place.
    filter : TwoStateFilter
    cuts : tuple of float
        Where the belief is cut into cells: the net's thresholds, and finer. Empty: the exact belief, infinitely many states, for runs.
    """

    world: World
    place: str
    filter: TwoStateFilter
    cuts: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if list(self.cuts) != sorted(set(self.cuts)) or not all(0.0 < c < 1.0 for c in self.cuts):
            raise ModelError(f"belief {self.place!r}: cuts increase between 0 and 1, got {self.cuts}")

    def start(self) -> Sequence[tuple[Hashable, float]]:
        """States of the world with the belief after the first reading."""
        return [((w, self._cell(self.filter.corrected(self.filter.prior, self._reading(w)))), p) for w, p in self.world.start()]

    def percepts(self, state: Hashable) -> Mapping[str, float]:
        """Those of the world, and the belief: within a cell one number stands for all, since the net decides alike."""
        w, belief = _parts(state)
        return {**self.world.percepts(w), self.place: float(np.mean(self._ends(belief))) if self.cuts else belief}

    def next(self, state: Hashable, commands: tuple[str, ...]) -> Sequence[Step]:
        """Where the world goes, and what the agent then believes."""
        w, belief = _parts(state)
        found: list[Step] = []
        for step in self.world.next(w, commands):
            if self.world.ended(step.state):
                found.append(step._replace(state=(step.state, belief)))
                continue
            reading = self._reading(step.state)
            if not self.cuts:
                found.append(step._replace(state=(step.state, self.filter.updated(belief, commands, reading))))
                continue
            low, high = self._ends(belief)
            cells = sorted(self._cell(b) for b in self._images(low, high, commands, reading))
            likely = self._cell(self.filter.updated((low + high) / 2, commands, reading))
            for cell in range(int(cells[0]), int(cells[-1]) + 1):
                sure = cells[0] == cells[-1]
                found.append(Step((step.state, cell), step.chance if cell == likely else 0.0, step.low if sure else 0.0, step.high))
        return found

    def ended(self, state: Hashable) -> str:
        """The world's own outcome."""
        return self.world.ended(_parts(state)[0])

    def name(self, state: Hashable) -> str:
        """The world's state, and within which cuts the belief lies."""
        w, belief = _parts(state)
        low, high = self._ends(belief) if self.cuts else (belief, belief)
        return f"{self.world.name(w)}, {self.place} {low:.3g}" + (f" to {high:.3g}" if self.cuts else "")

    def _reading(self, w: Hashable) -> float:
        return float(self.world.percepts(w)[self.filter.reading])

    def _cell(self, belief: float) -> float:
        return int(np.searchsorted(self.cuts, belief, "right")) if self.cuts else belief

    def _ends(self, cell: float) -> tuple[float, float]:
        edges = (0.0, *self.cuts, 1.0)
        return edges[int(cell)], edges[int(cell) + 1]

    def _images(self, low: float, high: float, commands: Sequence[str], reading: float) -> list[float]:
        """What becomes of both ends; an end at which the reading is impossible stands for its limit from within."""
        images = []
        for end, inner in ((low, high), (high, low)):
            try:
                images.append(self.filter.updated(end, commands, reading))
            except ImpossibleEvidence:
                images.append(self.filter.updated(end + 1e-12 * (inner - end), commands, reading))
        return images


def _parts(state: Hashable) -> tuple[Hashable, float]:
    """The world's state and the belief, or the number of its cell."""
    assert isinstance(state, tuple)
    return state[0], state[1]
