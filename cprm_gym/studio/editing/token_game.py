"""The token game: a net played by hand, firing by firing or cycle by cycle, with the executor that runs it in earnest (room ``game``)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...architecture.petri import Executor, ObjectPlace, PetriNet, Snapshot, flatten
from ...errors import CprmError, NetError, ParameterError

MOVES = 1000
"""Moves that can be taken back."""
OBJECTS = 3
"""Objects of each class with which object places can be filled."""


class TokenGame:
    """One net being played.

    Parameters
    ----------
    net : PetriNet

    Notes
    -----
    Math places have their values from the first cycle on; a firing by hand brings those up to date that depend on it.
    """

    def __init__(self, net: PetriNet) -> None:
        self.net = net
        classes = {p.class_name for p in flatten(net).places if isinstance(p, ObjectPlace)}
        self.executor = Executor(net, objects=dict.fromkeys(sorted(classes), OBJECTS), trace=True)
        self._past: list[Snapshot] = []
        self._fired: list[str] = []
        self._said = ""

    def fire(self, transition: str) -> dict[str, Any]:
        """Fire one transition, whatever its clock says.

        Raises
        ------
        NotEnabled
            The message says what is missing.
        """
        before = self.executor.snapshot()
        self.executor.fire(transition)
        self._past.append(before)
        del self._past[:-MOVES]
        self._fired, self._said = [transition], ""
        return self.state()

    def cycle(self, count: int = 1) -> dict[str, Any]:
        """Run whole cycles: math, immediate transitions until none is enabled, clocks, timed ones that are due.

        Raises
        ------
        CprmError
            When a cycle fails, in a livelock for example; the game is then as before.
        """
        if not 1 <= count <= MOVES:
            raise NetError(f"1 to {MOVES} cycles at once, got {count}")
        before = self.executor.snapshot()
        fired: list[str] = []
        said: dict[str, dict[str, float]] = {}
        trace = self.executor.trace
        assert trace is not None
        try:
            for _ in range(count):
                trace.clear()
                said |= self.executor.step().of(0)
                fired += [firing.transition for firing in trace.firings()]
        except CprmError:
            self.executor.restore(before)
            raise
        self._past.append(before)
        del self._past[:-MOVES]
        self._fired = fired
        self._said = ", ".join(f"{name}({', '.join(f'{k} {v:g}' for k, v in given.items())})" for name, given in said.items())
        return self.state()

    def write(self, place: str, value: float) -> dict[str, Any]:
        """Put a number of tokens or a value into a place, from outside; -1 empties an object place."""
        before = self.executor.snapshot()
        self.executor.write(place, value)
        self._past.append(before)
        del self._past[:-MOVES]
        self._fired, self._said = [], ""
        return self.state()

    def back(self) -> dict[str, Any]:
        """Take the last move back."""
        if self._past:
            self.executor.restore(self._past.pop())
        self._fired, self._said = [], ""
        return self.state()

    def reset(self) -> dict[str, Any]:
        """Begin again from the initial marking."""
        self.executor.reset()
        self._past.clear()
        self._fired, self._said = [], ""
        return self.state()

    def why_not(self, transition: str) -> list[str]:
        """What keeps a transition from firing."""
        return self.executor.why_not(transition)

    def state(self) -> dict[str, Any]:
        """The marking, what is enabled, how far clocks are, what fired last."""
        compiled = self.executor.net
        clocks = {}
        for t, name in enumerate(compiled.transition_names):
            delay = int(compiled.delay[t])
            if delay and (counted := int(self.executor.clocks(name)[0].max())) > 0:
                clocks[name] = round(counted / delay, 3)
        return {
            "cycle": int(self.executor.cycle[0]),
            "marking": {n: _number(float(v)) for n, v in zip(compiled.place_names, self.executor.marking[0])},
            "enabled": list(self.executor.enabled()),
            "clocks": clocks,
            "fired": self._fired,
            "commands": self._said,
            "moves": len(self._past),
        }


def _number(value: float) -> float | None:
    """A value as JSON can say it: none where it is not known yet."""
    return value if value == value and abs(value) != float("inf") else None


class Games:
    """The token games of the documents of a desk; none of them changes its document.

    Parameters
    ----------
    definition : callable
        (document, key of a definition) -> the net that is played.
    """

    def __init__(self, definition: Callable[[str, str], PetriNet]) -> None:
        self._definition = definition
        self._games: dict[str, TokenGame] = {}

    def calls(self) -> dict[str, Callable[..., Any]]:
        """What a page can call."""
        return {name: getattr(self, name) for name in ["begin", "fire", "cycle", "write", "back", "reset", "why", "end"]}

    def _game(self, id: str) -> TokenGame:
        if id not in self._games:
            raise ParameterError("no token game is on; begin one")
        return self._games[id]

    def begin(self, id: str, definition: str) -> dict[str, Any]:
        """Begin to play a definition by hand."""
        self._games[id] = TokenGame(self._definition(id, definition))
        return self._games[id].state()

    def fire(self, id: str, transition: str) -> dict[str, Any]:
        """Fire a transition."""
        return self._game(id).fire(transition)

    def cycle(self, id: str, count: int = 1) -> dict[str, Any]:
        """Run cycles."""
        return self._game(id).cycle(count)

    def write(self, id: str, place: str, value: float) -> dict[str, Any]:
        """Put tokens or a value into a place."""
        return self._game(id).write(place, value)

    def back(self, id: str) -> dict[str, Any]:
        """Take the last move back."""
        return self._game(id).back()

    def reset(self, id: str) -> dict[str, Any]:
        """Begin again."""
        return self._game(id).reset()

    def why(self, id: str, transition: str) -> dict[str, Any]:
        """What keeps a transition from firing."""
        return {"why": self._game(id).why_not(transition)}

    def end(self, id: str) -> dict[str, Any]:
        """End the game."""
        self._games.pop(id, None)
        return {}
