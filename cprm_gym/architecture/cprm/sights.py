"""What the model is told, read from percepts by one kernel, and the numbers of percepts that a net and its model read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..expressions.compiler import Assembler
from ..petri.execution.executor import Executor
from ..prm.grounding.slices import GroundVariable
from ..prm.inference.evidence import StateRows
from ..prm.model.formulas import Formula
from . import kernels
from .percepts import PerceptNames, PerceptTable


class Sight(NamedTuple):
    """An observation, its expressions parsed."""

    name: str
    value: Formula
    when: Formula


class Seen(NamedTuple):
    """What was perceived of all observations: (n, W) values, and whether they were made."""

    values: NDArray[np.float64]
    shown: NDArray[np.bool_]


class Columns:
    """Gathers the numbers that are read in a cycle.

    Parameters
    ----------
    names : sequence of str
        First the inputs of the net, which are percepts; then percepts, or where there is no such percept places of the net.
    executor : Executor
    """

    def __init__(self, names: Sequence[str], executor: Executor) -> None:
        self.names = tuple(names)
        self._executor = executor
        self._inputs = len(executor.input_names)
        self._every = list(enumerate(self.names))
        self._place_of = {name: k for k, name in enumerate(executor.net.place_names)}
        self._of: PerceptNames | None = None
        self._found = np.zeros(0, np.int64)
        self._rest = self._every
        self._places: tuple[list[int], list[int]] = [], []

    def gather(self, percepts: Mapping[str, Any]) -> NDArray[np.float64] | None:
        """(W, N) the numbers that are percepts, one column for each name; None where one is no number, or is neither percept nor place."""
        rest = self._every
        if isinstance(percepts, PerceptTable):
            if percepts.columns is not self._of:
                self._look_up(percepts.columns)
            rows, rest = percepts.table.take(self._found, axis=1), self._rest
        else:
            rows = np.empty((self._executor.batch, len(self.names)))
        columns, places = [], []
        try:
            for column, name in rest:
                if name in percepts:
                    rows[:, column] = percepts[name]
                elif column >= self._inputs:
                    columns.append(column)
                    places.append(self._place_of[name])
                else:
                    return None
        except (TypeError, ValueError, OverflowError, KeyError):
            return None
        self._places = columns, places
        return rows

    def add_places(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """`rows`, with what the places among the names of the last `gather` hold now."""
        columns, places = self._places
        if columns:
            rows[:, columns] = self._executor.marking[:, places]
        return rows

    def _look_up(self, columns: PerceptNames) -> None:
        """Find the columns of a table of percepts."""
        self._of = columns
        self._found = np.array([columns.at.get(name, 0) for name in self.names], np.int64)
        self._rest = [(k, name) for k, name in self._every if name not in columns.at]


class Sights:
    """Observations, in an order in which those of one domain stand together.

    Parameters
    ----------
    sights : sequence of Sight
    variables : mapping of str to GroundVariable
        With states; a real number is not read here.
    columns : dict of str to int
        Where the numbers that their expressions read stand.
    """

    def __init__(self, sights: Sequence[Sight], variables: Mapping[str, GroundVariable], columns: Mapping[str, int]) -> None:
        self.names = tuple(dict.fromkeys(s.name for s in sights))
        assembler = Assembler(lambda name: columns[name])
        edges: list[float] = []
        first: dict[tuple[float, ...], int] = {}
        readings = []
        for sight in sights:
            assembler.add(sight.value.node)
            assembler.add(sight.when.node)
            variable = variables[sight.name]
            at = -1
            if variable.edges is not None:
                own = tuple(variable.edges.tolist())
                at = first.setdefault(own, len(edges))
                edges += own if at == len(edges) else ()
            readings.append((at, variable.card, int(variable.circular), int(variable.clip), self.names.index(sight.name)))
        self._readings = np.array(readings, np.int64).reshape(-1, 5)
        self._edges = np.array(edges)
        self._code = assembler.finish()
        self._stack = np.zeros(self._code.depth)
        self._all = np.ones(len(readings), np.bool_)
        self._of = [sight.name for sight in sights]

    def read(self, rows: NDArray[np.float64], withheld: frozenset[str]) -> tuple[StateRows, Seen] | None:
        """What the model is told; None where something has no finite value or is no state of its variable.

        Parameters
        ----------
        rows : (W, N) float array
        withheld : set of str
            Variables of which it is told nothing.
        """
        batch, count = len(rows), len(self._readings)
        told = np.array([name not in withheld for name in self._of], np.bool_) if withheld else self._all
        seen = Seen(np.empty((count, batch)), np.empty((count, batch), np.bool_))
        states = np.full((len(self.names), batch), -1, np.int64)
        code = self._code
        if not kernels.read_states(
            code.code, code.constants, code.start, rows, self._stack, self._readings, self._edges, told, *seen, states
        ):
            return None
        return StateRows(self.names, states, checked=True), seen
