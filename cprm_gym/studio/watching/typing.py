"""Whether what is being typed into the field of a breakpoint or a curve can stand there, and what might."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from ...architecture.cprm import CPRMRunner
from ...architecture.expressions import FUNCTIONS
from ...errors import CprmError, did_you_mean, unknown_name
from ..running.frames import Message, variables
from .breakpoints import CALL, Breakpoint, Term, believed
from .questions import runner_in
from .session import Session

BELIEFS = ("E", "P", "clock")
"""What an expression of a run has besides the functions of the language."""


class Typing:
    """Answers while an expression is typed.

    Parameters
    ----------
    session : Session
    """

    def __init__(self, session: Session) -> None:
        self.session = session

    def calls(self) -> Mapping[str, Callable[..., Any]]:
        """What pages may call."""
        return {"typed": self.typed}

    def typed(self, agent: str, kind: str, text: str) -> Message:
        """Whether a text can stand in a breakpoint of a kind, ``when`` also for curves.

        Returns
        -------
        dict
            ``ok``; ``error`` and ``at``, the column of the mistake; ``known`` names and ``functions`` that might stand there.

        Raises
        ------
        UnknownName
            For another kind, or agent.
        """
        if kind not in Breakpoint.KINDS:
            raise unknown_name("kind of breakpoint", kind, Breakpoint.KINDS)
        with self.session.lock:
            run = self.session.there()
            runner = runner_in(run, agent)
            net = runner.executor.net
            if kind != "when":
                known = sorted({"fires": net.transition_names, "marked": net.place_names, "ends": ()}[kind])
                return _answer(known, (), *_named(text, known, kind))
            known = sorted({*net.place_names, *runner._percepts, *variables(runner), *_timed(runner), "cycle"})
            return _answer(known, sorted((*FUNCTIONS, *BELIEFS)), *_mistake(text, runner, run.cycle))


def _answer(known: list[str], functions: Any, error: str, at: int) -> Message:
    return {"ok": not error, "error": error, "at": at, "known": known, "functions": list(functions)}


def _timed(runner: CPRMRunner) -> list[str]:
    net = runner.executor.net
    return [t for t, delay in zip(net.transition_names, net.delay) if delay > 0]


def _named(text: str, known: list[str], kind: str) -> tuple[str, int]:
    name = text.strip()
    if kind == "ends" or name in known:
        return "", 0
    what = "transition" if kind == "fires" else "place"
    return f"unknown {what} {name!r}.{did_you_mean(name, known)}".strip(), 0


def _mistake(text: str, runner: CPRMRunner, cycle: int) -> tuple[str, int]:
    """What is wrong with an expression, and where; the empty text when nothing is."""
    try:
        term = Term.parse(text)
    except CprmError as error:
        lines = str(error).split("\n")
        caret = len(lines[-1]) - 5 if len(lines) > 1 and lines[-1].endswith("^") else None
        said = re.sub(r"^formula '.*': ", "", lines[0])
        return said, _place_of(text, said) if caret is None else _original(text, caret)
    for found, belief in zip(CALL.finditer(text), term.beliefs):
        try:
            believed(runner, *belief)
        except CprmError as error:
            return str(error), found.start(2)
    for name in term.formula.names:
        if name != "cycle" and not name.startswith("belief_") and name not in runner.places and name not in runner._percepts:
            near = did_you_mean(name, (*runner.places, *runner._percepts))
            found_at = re.search(rf"(?<![\w.]){re.escape(name)}(?![\w.])", text)
            return f"{name!r} is neither a percept nor a place.{near}".strip(), found_at.start() if found_at else 0
    try:
        term.value(runner, cycle)
    except CprmError as error:
        return str(error), 0
    return "", 0


def _original(text: str, column: int) -> int:
    """A column of an expression in which beliefs are names, in the text as it was typed."""
    shift = 0
    for k, found in enumerate(CALL.finditer(text)):
        start = found.start() - shift
        short = len(Term.name_of(k))
        if column < start:
            break
        if column < start + short:
            return found.start()
        shift += len(found[0]) - short
    return min(column + shift, max(0, len(text) - 1))


def _place_of(text: str, said: str) -> int:
    """Where the part that a message quotes stands."""
    quoted = re.match(r"'([^']+)'", said)
    return max(0, text.find(quoted[1])) if quoted else 0
