"""Expressions of a run drawn over its cycles, and what would be true where a belief is about the place of something."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ...agents.demos import _object_number
from ...agents.play import agent_in
from ...architecture.cprm import CPRMRunner
from ...errors import CprmError, ParameterError, unknown_name
from ..running.frames import Message, number, object_held
from ..running.memory import runner_of
from ..running.run import Run
from .breakpoints import Term
from .session import Session

MOST = 6
"""Curves of an agent: as many as colours that can be told apart."""
LONGEST = 6000
"""Cycles of a curve: a match."""
COMPONENTS = {"x": ("pos", 0), "y": ("pos", 1), "vx": ("vel", 0), "vy": ("vel", 1)}
"""Attribute -> where the world has it."""
_OBJECT = re.compile(r"[otm]\d+")


class Curves:
    """Values of expressions in every cycle, kept in the frames.

    Parameters
    ----------
    session : Session
    """

    def __init__(self, session: Session) -> None:
        self.session = session
        self.asked: dict[str, list[str]] = {}
        session.extras.append(self._add)
        session.begun.append(lambda _: self.asked.clear())

    def calls(self) -> Mapping[str, Callable[..., Any]]:
        """What pages may call."""
        return {"curves": self.curves}

    def curves(self, agent: str, what: list[str], cycles: int = 200) -> Message:
        """Values of expressions over the last cycles, from now on also in every frame.

        Parameters
        ----------
        agent : str
        what : list of str
            Expressions as of breakpoints; those asked for before are forgotten.
        cycles : int
            How many of the last cycles.

        Returns
        -------
        dict
            ``cycles``; ``values``, expression -> a list of [value, true value], None where it has or is known to have none; ``wrong``,
            expression -> why it is none.
        """
        if not isinstance(what, list) or not all(isinstance(text, str) for text in what) or len(what) > MOST:
            raise ParameterError(f"curves: a list of at most {MOST} expressions, got {what!r}")
        if isinstance(cycles, bool) or not isinstance(cycles, int) or not 1 <= cycles <= LONGEST:
            raise ParameterError(f"cycles: 1 to {LONGEST}, got {cycles!r}")
        with self.session.lock:
            run = self.session.there()
            if agent not in run.agents:
                raise unknown_name("agent", agent, run.agents)
            runner = runner_of(run.players[run.agents.index(agent)])
            if runner is None:
                raise ParameterError(f"{agent} plays with no net of ours, and has no curves")
            wrong = {}
            for text in what:
                try:
                    Term.parse(text).value(runner, run.cycle)
                except CprmError as error:
                    wrong[text] = str(error)
            good = self.asked[agent] = [text for text in dict.fromkeys(what) if text not in wrong]
            frames = {c: f for c in list(self.session.frames)[-cycles:] if (f := self.session.frames[c])["cycle"] <= run.cycle}
            missing = [c for c, f in frames.items() if not set(good) <= set(f.get("curves", {}).get(agent, ()))]
            for c in run.visit(missing):
                self._add(run, frames[c])
                self.session.keep(frames[c])
            kept = {c: f.get("curves", {}).get(agent, {}) for c, f in sorted(frames.items())}
            return {"cycles": list(kept), "values": {t: [of.get(t, [None, None]) for of in kept.values()] for t in good}, "wrong": wrong}

    def _add(self, run: Run, made: Message) -> None:
        """Put the values of this cycle into its frame."""
        for agent, texts in self.asked.items():
            i = run.agents.index(agent)
            runner = runner_of(run.players[i])
            if runner is not None and texts:
                made.setdefault("curves", {})[agent] = {text: [_value(runner, text, run.cycle), true_value(run, i, text)] for text in texts}


def _value(runner: CPRMRunner, text: str, cycle: int) -> float | None:
    try:
        return number(Term.parse(text).value(runner, cycle), 4)
    except CprmError:  # a variable that does not exist just then
        return None


def true_value(run: Run, i: int, text: str) -> float | None:
    """What an expression would be if all beliefs in it were certain and true.

    Known of places and velocities of the ball and of players, alone and in expressions of nothing else; a probability is then 0 or 1.

    Parameters
    ----------
    run : Run
    i : int
        Whose expression it is.
    text : str

    Returns
    -------
    float or None
        In the player's own frame, metres and cycles. None where it is not known.
    """
    runner = runner_of(run.players[i])
    term = Term.parse(text)
    if runner is None:
        return None
    reads = {b.name: b.variable for b in runner.executor.belief_places if str(b.view) == "expectation"}
    if not term.beliefs and not any(name in reads for name in term.formula.names):
        return None
    values: dict[str, np.ndarray] = {}
    for k, (kind, variable, relation, bound) in enumerate(term.beliefs):
        true = None if kind == "clock" else _true_variable(run, i, runner, variable)
        if true is None or relation == "==":
            return None
        if kind == "P":
            true = float(true < float(bound) if "<" in relation else true > float(bound))
        values[term.name_of(k)] = np.full(1, true)
    for name in term.formula.names:
        if name in values:
            continue
        true = float(run.cycle) if name == "cycle" else _true_variable(run, i, runner, reads[name]) if name in reads else None
        if true is None:
            return None
        values[name] = np.full(1, true)
    try:
        return number(float(term.formula(values, 1)[0]), 4)
    except CprmError:
        return None


def _true_variable(run: Run, i: int, runner: CPRMRunner, variable: str) -> float | None:
    """The world's value of ``ball.x`` and the like; None for what the world does not have."""
    owner, _, attribute = variable.partition(".")
    if agent_in(run.players[i]) is None or attribute not in COMPONENTS:
        return None
    if owner in runner._class_at:
        owner = object_held(runner, owner) or ""
    if owner != "ball" and not _OBJECT.fullmatch(owner):
        return None
    whom = 0 if owner == "ball" else _object_number(owner, int(run.core.players[i]))
    world = run.core.sim.world[0]
    if not 0 <= whom <= 22 or (whom and not world["enabled"][whom - 1]):
        return None
    part, axis = COMPONENTS[attribute]
    return float(run.core.sides[i]) * float(world[part][whom][axis])
