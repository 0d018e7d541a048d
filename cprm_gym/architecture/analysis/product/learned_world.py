"""A world of cells, learned from what was seen in a simulator."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....errors import FormatError, ModelError
from ....files import read_bounded
from ...petri import CompiledNet, PlaceKind
from ..sampling.intervals import clopper_pearson
from .worlds import Step

UNSEEN: Hashable = "unseen"
"""Where the world goes when it does what was never seen: what the agent perceives there is not known."""
MAX_BYTES = 64 * 2**20
Cell = tuple[int, ...]
"""Between which cuts each place is."""
Row = tuple[Cell, tuple[str, ...] | None]
"""A cell and what went out in it; None at the end of a run."""


def thresholds_of(net: CompiledNet) -> dict[str, tuple[float, ...]]:
    """Real-valued places that transitions test or that inhibit them, with the thresholds: where decisions depend on the world."""
    found: dict[str, set[float]] = {}
    for arcs in (net.tests, net.inhibitors):
        for place, value in zip(arcs.place.tolist(), arcs.value.tolist()):
            if net.kind[place] not in (PlaceKind.DISCRETE, PlaceKind.OBJECT):
                found.setdefault(net.place_names[place], set()).add(float(value))
    return {name: tuple(sorted(values)) for name, values in found.items()}


@dataclass(eq=False)
class LearnedWorld:
    """Cells of what a net tests, cut at its own thresholds and some more, with counts of how they follow each other.

    Of each cell one real reading of all percepts is kept; within a cell the net decides alike whatever the reading. That the next cell
    depends on this cell and the command alone is an assumption, which holds the better the finer the cells: compare with the simulator.

    Parameters
    ----------
    edges : mapping of str to tuple of float
        Place -> where it is cut.
    confidence : float
        With which all intervals hold at once (Clopper-Pearson, Bonferroni).
    acts : tuple of str
        Commands that are told apart, others are not looked at; empty: all.
    heeds : tuple of str
        Places of the net whose tokens are told apart too: how far the behaviour is stands for what else the past has left.
    later : list of runs
        Runs that are counted like all, and told once more by themselves, cell by cell: those from which bounds are had that have no part in
        what they bound (`regular_bounds`). One that did not end has commands in its last cell.

    Raises
    ------
    ModelError
        For a confidence that is none.
    """

    edges: Mapping[str, tuple[float, ...]]
    confidence: float = 0.95
    acts: tuple[str, ...] = ()
    heeds: tuple[str, ...] = ()
    counts: dict[tuple[Cell, tuple[str, ...]], dict[Cell, int]] = field(default_factory=dict)
    begins: dict[Cell, int] = field(default_factory=dict)
    readings: dict[Cell, dict[str, float]] = field(default_factory=dict)
    later: list[list[Row]] = field(default_factory=list)
    _steps: dict[Any, list[Step]] = field(default_factory=dict, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not 0.0 < self.confidence < 1.0:
            raise ModelError(f"learned world: confidence {self.confidence}: needs a number between 0 and 1")

    def told(self, commands: tuple[str, ...]) -> tuple[str, ...]:
        """Those of the commands and heeded places that are told apart."""
        return tuple(c for c in commands if c in self.acts or c.partition("=")[0] in self.heeds) if self.acts else commands

    def coarser(self, edges: Mapping[str, Sequence[float]], heeds: Sequence[str] | None = None) -> LearnedWorld:
        """The same runs in cells that are cut in fewer places, and heeding fewer places of the net if so wished.

        Raises
        ------
        ModelError
            When one of them is none of the cuts.
        """
        maps = []
        for place, cuts in self.edges.items():
            kept = tuple(edges.get(place, ()))
            if not set(kept) <= set(cuts):
                raise ModelError(f"learned world: {place!r} is cut at {cuts}, not at {kept}")
            maps.append([sum(cut in kept for cut in cuts[:k]) for k in range(len(cuts) + 1)])

        def at(cell: Cell) -> Cell:
            return tuple(to[k] for to, k in zip(maps, cell))

        kept_heeds = self.heeds if heeds is None else tuple(h for h in self.heeds if h in heeds)
        made = LearnedWorld({p: tuple(edges.get(p, ())) for p in self.edges}, self.confidence, self.acts, kept_heeds)
        for cell, n in self.begins.items():
            made.begins[at(cell)] = made.begins.get(at(cell), 0) + n
        for (cell, commands), row in self.counts.items():
            whole = made.counts.setdefault((at(cell), made.told(commands)), {})
            for then, n in row.items():
                whole[at(then)] = whole.get(at(then), 0) + n
        for cell, reading in self.readings.items():
            made.readings.setdefault(at(cell), reading)
        made.later = [[(at(cell), told if told is None else made.told(told)) for cell, told in run] for run in self.later]
        return made

    def cell(self, values: Mapping[str, float]) -> tuple[int, ...]:
        """The cell of values of the tested places."""
        return tuple(int(np.searchsorted(cut, values[name], "right")) for name, cut in self.edges.items())

    def cells(self, values: Mapping[str, NDArray[np.float64]]) -> NDArray[np.int64]:
        """(W, places) The same for many."""
        return np.stack([np.searchsorted(cut, values[name], "right") for name, cut in self.edges.items()], axis=1)

    def begin(self, cell: tuple[int, ...], reading: Mapping[str, float]) -> None:
        """A run began in a cell."""
        self.begins[cell] = self.begins.get(cell, 0) + 1
        self.readings.setdefault(cell, dict(reading))
        self._steps.clear()

    def saw(self, cell: tuple[int, ...], commands: tuple[str, ...], then: tuple[int, ...], reading: Mapping[str, float]) -> None:
        """A cell was followed by another, where `reading` was perceived."""
        row = self.counts.setdefault((cell, commands), {})
        row[then] = row.get(then, 0) + 1
        self.readings.setdefault(then, dict(reading))
        self._steps.clear()

    @property
    def entries(self) -> int:
        """How many chances were learned: each row has one more, of what was never seen."""
        return sum(len(row) + 1 for row in self.counts.values())

    def start(self) -> Sequence[tuple[Hashable, float]]:
        """Cells in which runs began.

        Raises
        ------
        ModelError
            When there are none.
        """
        total = sum(self.begins.values())
        if not total:
            raise ModelError("learned world: no run was seen")
        return [(cell, n / total) for cell, n in self.begins.items()]

    def percepts(self, state: Hashable) -> Mapping[str, float]:
        """The reading that was kept of the cell."""
        return self.readings[state]  # type: ignore[index]

    def next(self, state: Hashable, commands: tuple[str, ...]) -> Sequence[Step]:
        """Cells that followed, with intervals; a command that was never seen here leads to `UNSEEN`."""
        key: Any = (state, self.told(commands))
        if key not in self._steps:
            row = self.counts.get(key)
            if not row:
                self._steps[key] = [Step(UNSEEN, 1.0, 1.0, 1.0)]
            else:
                total = sum(row.values())
                level = 1.0 - (1.0 - self.confidence) / self.entries
                steps = [Step(cell, n / total, *clopper_pearson(n, total, level)) for cell, n in row.items()]
                self._steps[key] = [*steps, Step(UNSEEN, 0.0, *clopper_pearson(0, total, level))]
        return self._steps[key]

    def ended(self, state: Hashable) -> str:
        """``"unseen"`` where nothing is known."""
        return "unseen" if state == UNSEEN else ""

    def name(self, state: Hashable) -> str:
        """Within which thresholds each place is."""
        if state == UNSEEN:
            return "unseen"
        parts = []
        for (place, cut), k in zip(self.edges.items(), state):  # type: ignore[call-overload]
            if k == 0:
                parts.append(f"{place} < {cut[0]:g}")
            elif k == len(cut):
                parts.append(f"{place} >= {cut[-1]:g}")
            else:
                parts.append(f"{cut[k - 1]:g} <= {place} < {cut[k]:g}")
        return ", ".join(parts)

    def hull(self, cells: Collection[Hashable]) -> str:
        """The least box of cells around the given ones, as an expression over the places that are cut."""
        terms = []
        for k, (place, cut) in enumerate(self.edges.items()):
            own = [cell[k] for cell in cells if cell != UNSEEN]  # type: ignore[index]
            if own and min(own) > 0:
                terms.append(f"{place} >= {cut[min(own) - 1]!r}")
            if own and max(own) < len(cut):
                terms.append(f"{place} < {cut[max(own)]!r}")
        return " and ".join(terms) or "1"

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "edges": {k: list(v) for k, v in self.edges.items()},
            "confidence": self.confidence,
            "acts": list(self.acts),
            "heeds": list(self.heeds),
            "begins": [[list(c), n] for c, n in self.begins.items()],
            "counts": [[list(c), list(a), [[list(t), n] for t, n in row.items()]] for (c, a), row in self.counts.items()],
            "readings": [[list(c), r] for c, r in self.readings.items()],
            **self._told_later(),
        }

    def _told_later(self) -> dict[str, Any]:
        """Runs that were held out: rows are numbered, and a run is a list of numbers."""
        rows: dict[Row, int] = {}
        runs = [[rows.setdefault(row, len(rows)) for row in run] for run in self.later]
        return {"rows": [[list(c), None if told is None else list(told)] for c, told in rows], "later": runs}

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write it as JSON."""
        Path(path).write_text(json.dumps(self.to_json()), encoding="utf-8")


def load_world(path: str | os.PathLike[str]) -> LearnedWorld:
    """The world in a JSON file that `LearnedWorld.save` wrote.

    Raises
    ------
    FormatError
        When it cannot be read or understood; the message names the file.
    """
    file = Path(path)
    try:
        data = json.loads(read_bounded(file, MAX_BYTES))
        edges = {str(k): tuple(map(float, v)) for k, v in data["edges"].items()}
        world = LearnedWorld(edges, float(data["confidence"]), tuple(map(str, data["acts"])), tuple(map(str, data.get("heeds", ()))))
        for cell, n in data["begins"]:
            world.begins[tuple(map(int, cell))] = int(n)
        for cell, commands, row in data["counts"]:
            world.counts[tuple(map(int, cell)), tuple(map(str, commands))] = {tuple(map(int, t)): int(n) for t, n in row}
        for cell, reading in data["readings"]:
            world.readings[tuple(map(int, cell))] = {str(k): float(v) for k, v in reading.items()}
        rows: list[Row] = [(tuple(map(int, c)), None if t is None else tuple(map(str, t))) for c, t in data.get("rows", ())]
        if any(not 0 <= k < len(rows) for run in data.get("later", ()) for k in run):
            raise FormatError(f"{file}: a run names a row that there is not")
        world.later = [[rows[k] for k in run] for run in data.get("later", ())]
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(f"{file}: no learned world: {error!r}") from None
    if wrong := _wrong(world):
        raise FormatError(f"{file}: {wrong}")
    known = set(world.readings)
    if not {*world.begins, *(c for c, _ in world.counts), *(t for row in world.counts.values() for t in row)} <= known:
        raise FormatError(f"{file}: a cell without a reading")
    return world


def _wrong(world: LearnedWorld) -> str:
    """What makes no sense in a world from a file; empty where nothing does not."""
    for place, cuts in world.edges.items():
        if not cuts or not all(map(math.isfinite, cuts)) or any(a >= b for a, b in pairwise(cuts)):
            return f"the edges of {place!r} do not rise"
    sizes = [len(cuts) for cuts in world.edges.values()]
    for cell, reading in world.readings.items():
        if len(cell) != len(sizes) or not all(0 <= k <= size for k, size in zip(cell, sizes)):
            return f"the cell {list(cell)} does not lie within the edges"
        if not all(map(math.isfinite, reading.values())):
            return f"the reading of the cell {list(cell)} is no finite number"
    numbers = [*world.begins.values(), *(n for row in world.counts.values() for n in row.values())]
    if not all(1 <= n <= 2**53 for n in numbers):
        return "a count is no whole number from 1 to 2**53"
    return _wrong_runs(world)


def _wrong_runs(world: LearnedWorld) -> str:
    """What does not fit in the runs that were held out: they are among those that were counted."""
    counted: dict[Any, int] = {}
    for run in world.later:
        if not run or any(told is None for _, told in run[:-1]):
            return "a run ends before its last cell, or has none"
        counted[run[0][0]] = counted.get(run[0][0], 0) + 1
        for (cell, told), (then, _) in pairwise(run):
            key = (cell, told, then)
            counted[key] = counted.get(key, 0) + 1
    for key, n in counted.items():
        whole = world.counts.get((key[0], key[1]), {}).get(key[2], 0) if key and isinstance(key[0], tuple) else world.begins.get(key, 0)
        if n > whole:
            return "a run that was held out was not counted"
    return ""
