"""Two runs with the same seed side by side, and where they first differ."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from ...errors import CprmError
from ..running.frames import Message, frame, quantities
from ..running.memory import runner_of
from ..running.run import Run
from .differences import differences
from .session import Session


class Comparison:
    """Another run beside the one that is watched; both are in the same cycle, or the other one has ended before.

    Parameters
    ----------
    session : Session
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self.first: Message | None = None
        """Where they first differed: cycle and what."""
        self._quantities: Mapping[str, frozenset[str]] = {}
        session.extras.append(self._add)
        session.begun.append(lambda run: self._end())

    def calls(self) -> Mapping[str, Callable[..., Any]]:
        """What pages may call."""
        return {"compare": self.compare, "alone": self.alone}

    def compare(self, controller: str | None = None, changed: bool = True) -> Message:
        """Play another run beside this one, from the start on; every cycle of this one that is kept is given the other's.

        Parameters
        ----------
        controller : str, optional
            Who plays in the other one; the same if not given.
        changed : bool
            False: with nets and models as they ship, where this run plays with edited ones.
        """
        self.session.pause()
        with self.session.lock:
            run = self.session.there()
            different: dict[str, Any] = {} if controller is None else {"controller": controller}
            if not changed or controller is not None:
                different |= {"nets": {}, "models": {}}
            self._end()
            self.session.beside = other = Run(replace(run.setup, **different))
            runners = zip(run.agents, map(runner_of, run.players))
            self._quantities = {name: quantities(runner) for name, runner in runners if runner is not None}
            kept = list(self.session.frames)
            for cycle in kept if kept and kept[0] == 0 else [0, *kept]:
                if cycle > run.cycle:
                    break
                if not other.over:
                    other.go_to(cycle)
                mine = self.session.frames.get(cycle)
                if mine is not None and cycle < run.cycle:
                    self._put(other, mine)
                    self.session.keep(mine)
            return self.session.again()

    def alone(self) -> Message:
        """Without the other run again."""
        with self.session.lock:
            self._end()
            return self.session.again()

    def _end(self) -> None:
        self.session.beside, self.first = None, None

    def _add(self, run: Run, made: Message) -> None:
        """The other run's frame of the same cycle."""
        other = self.session.beside
        if other is None:
            return
        if other.cycle > run.cycle:
            other.go_to(run.cycle)
        if self.first is not None and self.first["cycle"] > run.cycle:
            self.first = None
        try:
            while other.cycle < run.cycle and not other.over:
                other.advance()
        except CprmError as error:
            made["other_error"] = str(error)
            self._end()
            return
        self._put(other, made)

    def _put(self, other: Run, made: Message) -> None:
        """Put the other's frame, and what differs, into a frame of this run."""
        theirs = frame(other, self.session.shown, self.session.asked)
        differs = differences(made, theirs, self._quantities)
        if differs and self.first is None:
            self.first = {"cycle": made["cycle"], "what": differs["what"]}
        made["other"] = {**theirs, "setup": other.setup.said(), "first": self.first, "differs": differs}
