"""Two runs with the same seed side by side, and where they first differ."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from ...errors import CprmError
from ..running.frames import Message, frame
from ..running.run import Run
from .frame_store import Frames
from .session import Session


class Comparison:
    """Another run beside the one that is watched; both are in the same cycle.

    Parameters
    ----------
    session : Session
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self.other: Run | None = None
        self.first: Message | None = None
        """Where they first differed: cycle and what."""
        self._frames = Frames()
        session.extras.append(self._add)
        session.begun.append(lambda run: self._end())

    def calls(self) -> Mapping[str, Callable[..., Any]]:
        """What pages may call."""
        return {"compare": self.compare, "alone": self.alone}

    def compare(self, controller: str | None = None, changed: bool = True) -> Message:
        """Play another run beside this one, from the start on.

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
            other = Run(replace(run.setup, **different))
            self.other = other
            while True:
                self._look(self.session.frames.get(other.cycle))
                if other.cycle >= run.cycle or other.over:
                    break
                other.advance()
            return self.session.again()

    def alone(self) -> Message:
        """Without the other run again."""
        with self.session.lock:
            self._end()
            return self.session.again()

    def _end(self) -> None:
        self.other, self.first = None, None
        self._frames.clear()

    def _look(self, mine: Message | None) -> Message:
        """Keep the other run's frame, and see whether it is the first that differs."""
        assert self.other is not None
        made = frame(self.other, self.session.shown, {})
        self._frames.put(made)
        if self.first is None and mine is not None:
            what = differences(mine, made)
            if what:
                self.first = {"cycle": made["cycle"], "what": what}
        return made

    def _add(self, run: Run, made: Message) -> None:
        """The other run's frame of the same cycle."""
        if self.other is None:
            return
        if self.other.cycle > run.cycle:
            self.other.go_to(run.cycle)
            if self.first is not None and self.first["cycle"] > run.cycle:
                self.first = None
        try:
            while self.other.cycle < run.cycle and not self.other.over:
                self.other.advance()
                self._look(made if self.other.cycle == run.cycle else self.session.frames.get(self.other.cycle))
        except CprmError as error:
            made["other_error"] = str(error)
            self._end()
            return
        theirs = self._frames.get(run.cycle) or self._look(made)
        shown = {key: theirs[key] for key in ("cycle", "status", "over", "world", "commands")}
        shown["agents"] = {a: {k: inner.get(k) for k in ("fired", "marking", "commands")} for a, inner in theirs["agents"].items()}
        made["other"] = {**shown, "setup": self.other.setup.said(), "first": self.first}


def differences(mine: Message, theirs: Message) -> list[str]:
    """What differs between two frames of one cycle: what was decided, then what is where."""
    found = [f"{name}: {command or 'nothing'}, there {theirs['commands'].get(name) or 'nothing'}"
             for name, command in mine["commands"].items() if command != theirs["commands"].get(name)]  # fmt: skip
    for name, inner in mine["agents"].items():
        other = theirs["agents"].get(name, {})
        if inner.get("fired") is not None and other.get("fired") is not None and inner["fired"] != other["fired"]:
            found.append(f"{name}: fired {', '.join(inner['fired']) or 'nothing'}; there {', '.join(other['fired']) or 'nothing'}")
    if mine["world"]["ball"] != theirs["world"]["ball"]:
        found.append("the ball")
    there = {row[0]: row for row in theirs["world"]["players"]}
    found += [_name(row[0]) for row in mine["world"]["players"] if row[1:6] != there.get(row[0], row)[1:6]]
    if mine["status"] != theirs["status"]:
        found.append(f"{mine['status']}, there {theirs['status']}")
    return found


def _name(k: int) -> str:
    return f"left_{k}" if k <= 11 else f"right_{k - 11}"
