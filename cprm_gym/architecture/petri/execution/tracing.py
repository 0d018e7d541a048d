"""Traces: which transition fired when and why, and what else was enabled (`Executor.replay` does the same again)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .state import Snapshot


class Firing(NamedTuple):
    """One firing."""

    copy: int
    cycle: int
    transition: str
    timed: bool  # False: immediate
    enabled: tuple[str, ...]  # all transitions that were enabled, this one included
    reason: str


class Trace:
    """The firings of an executor since its last reset, with the state at the start of every cycle.

    Parameters
    ----------
    names : tuple of str
        The transitions.
    delay, priority : sequences
    """

    def __init__(self, names: Sequence[str], delay: Sequence[int], priority: Sequence[int]) -> None:
        self._names = tuple(names)
        self._delay = delay
        self._priority = priority
        self._cycles: list[tuple[Snapshot, NDArray[np.int64], NDArray[np.uint8]]] = []

    def __len__(self) -> int:
        return len(self._cycles)

    def clear(self) -> None:
        """Forget everything."""
        self._cycles.clear()

    def add(self, before: Snapshot, events: NDArray[np.int64], enabled: NDArray[np.uint8]) -> None:
        """Add one cycle: the state after the inputs were written, and the firings as (copy, cycle, transition, timed)."""
        self._cycles.append((before, events.copy(), np.packbits(enabled, axis=1)))

    def firings(self, copy: int | None = None) -> list[Firing]:
        """Every firing in order, of one copy or of all."""
        found = []
        for _, events, bits in self._cycles:
            enabled = np.unpackbits(bits, axis=1, count=len(self._names)) if len(events) else bits
            for (w, cycle, t, timed), row in zip(events.tolist(), enabled):
                if copy is None or w == copy:
                    names = tuple(self._names[u] for u in np.flatnonzero(row))
                    found.append(Firing(w, cycle, self._names[t], bool(timed), names, self._reason(t, row)))
        return found

    def _reason(self, t: int, enabled: NDArray[np.uint8]) -> str:
        if self._delay[t] > 0:
            return f"timed: enabled for its delay of {self._delay[t]} cycles"
        rivals = [u for u in np.flatnonzero(enabled).tolist() if u != t and self._delay[u] == 0]
        if not rivals:
            return "immediate: the only one enabled"
        equal = [self._names[u] for u in rivals if self._priority[u] == self._priority[t]]
        if equal:
            return f"immediate: chosen among equal priorities before {', '.join(equal)}"
        return f"immediate: of higher priority than {', '.join(self._names[u] for u in rivals)}"

    def text(self, copy: int = 0) -> str:
        """One line per firing of one copy, to be read."""
        return "\n".join(f"cycle {f.cycle}: {f.transition} fired ({f.reason})" for f in self.firings(copy))

    def cycles(self) -> Iterator[tuple[Snapshot, NDArray[np.int64]]]:
        """Every cycle: the state at its start, and the firings as (copy, cycle, transition, timed)."""
        return ((before, events) for before, events, _ in self._cycles)

    def last(self) -> NDArray[np.int64]:
        """The firings of the last cycle."""
        return self._cycles[-1][1]

    def show(self, events: NDArray[np.int64]) -> str:
        """The names of the transitions that fired."""
        return ", ".join(self._names[t] for t in events[:, 2].tolist()) or "nothing fired"
