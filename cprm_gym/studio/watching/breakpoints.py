"""Where a run stops by itself: at a firing, a marked place, an expression or a belief; kept in a file beside the net.

An expression is one of the language of nets over places and percepts, with additions: ``P(ball.x < -40)``, the probability of a part of a
variable's states, ``E(ball.x)``, its expectation, and ``clock(t)``, how many cycles the clock of the transition ``t`` has counted, -1 while
it does not run. ``cycle`` is the cycle.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from ...architecture.cprm import CPRMRunner
from ...architecture.prm.model.formulas import Formula
from ...errors import CprmError, FormatError, ModelError, ParameterError, unknown_name
from ...files import parse_json, read_bounded, write_atomically
from ..running.frames import marginal, moments, variables

FORMAT, VERSION, LARGEST = "cprm_gym breakpoints", 1, 1 << 20
MOST = 200
"""Breakpoints of a net."""
CALL = re.compile(r"\b([PE]|clock)\(\s*([A-Za-z_][\w.]*(?:\([\w,]*\)\.\w+)?)\s*(?:(<=|>=|==|<|>)\s*('[^']*'|-?[\w.+]+)\s*)?\)")
"""A belief or a clock in an expression: which of them, of what, and for ``P`` the relation and the bound."""
_TERM = "belief_{}"


@dataclass(frozen=True)
class Breakpoint:
    """One of them.

    Parameters
    ----------
    kind : str
        ``fires`` a transition, ``marked`` a place that comes to hold something, ``when`` an expression that becomes true, ``ends`` the
        episode.
    what : str
        Name of the transition or place, or the expression.
    on : bool
        Whether it holds.
    """

    KINDS: ClassVar[tuple[str, ...]] = ("fires", "marked", "when", "ends")
    kind: str
    what: str = ""
    on: bool = True

    def __post_init__(self) -> None:
        """Refuse what is none."""
        if self.kind not in self.KINDS:
            raise unknown_name("kind of breakpoint", str(self.kind), self.KINDS)
        if not isinstance(self.what, str) or not isinstance(self.on, bool):
            raise ParameterError(f"breakpoint {self.kind!r}: a name or expression, and on or off, got {self.what!r}, {self.on!r}")
        if self.kind == "when":
            Term.parse(self.what)

    @property
    def key(self) -> str:
        """By which it is found."""
        return f"{self.kind} {self.what}".strip()

    def check(self, runner: CPRMRunner) -> None:
        """Refuse a name that an agent's net does not have.

        Raises
        ------
        UnknownName
        """
        names = {"fires": runner.executor.net.transition_names, "marked": runner.executor.net.place_names}.get(self.kind)
        if names is not None and self.what not in names:
            raise unknown_name("transition" if self.kind == "fires" else "place", self.what, names)
        if self.kind == "when":
            Term.parse(self.what).value(runner, 0)

    def holds(self, runner: CPRMRunner, fired: Iterable[str], cycle: int, over: bool) -> bool:
        """Whether it would stop here, if it did not in the cycle before."""
        if self.kind == "ends":
            return over
        if self.kind == "fires":
            return self.what in fired
        if self.kind == "marked":
            return self.what in runner.places and float(runner.executor.read(self.what)[0]) > 0
        try:
            return Term.parse(self.what).value(runner, cycle) > 0
        except CprmError:  # a variable that does not exist just now
            return False


class Term:
    """An expression over places, percepts and beliefs.

    Raises
    ------
    ParameterError
        When it is not in the language.
    """

    _known: ClassVar[dict[str, Term]] = {}

    def __init__(self, text: str) -> None:
        self.text = text
        self.beliefs: list[tuple[str, str, str, str]] = []

        def named(found: re.Match[str]) -> str:
            kind, variable, relation, bound = found.groups()
            if (kind == "P") != (relation is not None):
                raise ParameterError(f"{found[0]!r}: written as P(ball.x < -40), E(ball.x) or clock(transition)")
            self.beliefs.append((kind, variable, relation or "", bound or ""))
            return _TERM.format(len(self.beliefs) - 1)

        plain = CALL.sub(named, text)
        try:
            self.formula = Formula(plain)
        except ModelError as error:
            raise ParameterError(str(error).replace(repr(plain), repr(text))) from None

    @classmethod
    def parse(cls, text: str) -> Term:
        """As the constructor; what was parsed before is used again."""
        if text not in cls._known:
            if len(cls._known) >= 4 * MOST:
                cls._known.clear()
            cls._known[text] = cls(text)
        return cls._known[text]

    @staticmethod
    def name_of(k: int) -> str:
        """By which the formula calls the k-th of ``beliefs``."""
        return _TERM.format(k)

    def value(self, runner: CPRMRunner, cycle: int) -> float:
        """What it is now.

        Raises
        ------
        CprmError
            For a name that is none, or where it has no finite value.
        """
        values: dict[str, np.ndarray] = {"cycle": np.full(1, float(cycle))}
        for k, belief in enumerate(self.beliefs):
            values[_TERM.format(k)] = np.full(1, believed(runner, *belief))
        for name in self.formula.names:
            if name not in values:
                values[name] = runner._value(name, runner._percepts)
        return float(self.formula(values, 1)[0])


def believed(runner: CPRMRunner, kind: str, name: str, relation: str, bound: str) -> float:
    """``P(name relation bound)``, ``E(name)``, or ``clock(name)``.

    Raises
    ------
    UnknownName, ParameterError
        When the model has no such variable, or it no such value.
    """
    if kind == "clock":
        net = runner.executor.net
        timed = [t for t, delay in zip(net.transition_names, net.delay) if delay > 0]
        if name not in timed:
            raise unknown_name("timed transition", name, timed)
        return float(runner.executor.clocks(name)[0].max(initial=-1))
    known = variables(runner)
    if name not in known:
        raise unknown_name("variable", name, known)
    variable = known[name]
    found = marginal(runner, name)
    if kind == "E":
        if variable.edges is None and variable.quantity is None:
            raise ParameterError(f"{name} has named states and no expectation: {', '.join(variable.states)}")
        return moments(found, variable)[0]
    if variable.quantity is not None:
        below = float(np.ravel(found.probability(-math.inf, _number(bound, name)))[0])
        return below if relation in ("<", "<=") else 1.0 - below
    p = np.asarray(found)
    if variable.edges is None:
        state = bound.strip("'")
        if relation != "==" or state not in variable.states:
            raise ParameterError(f"{name} has the states {', '.join(variable.states)}; written as P({name} == {variable.states[0]})")
        return float(p[variable.states.index(state)])
    limit = _number(bound, name)
    low, high = variable.edges[:-1], variable.edges[1:]
    if relation == "==":
        return float(p[(low <= limit) & (limit < high)].sum())
    below = float(p @ np.clip((limit - low) / (high - low), 0.0, 1.0))
    return below if relation in ("<", "<=") else 1.0 - below


def _number(text: str, name: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ParameterError(f"{name} has numbers, {text!r} is none") from None


# ------------------------------------------------------------------ kept beside the net


def read_breakpoints(path: Path) -> dict[str, list[Breakpoint]]:
    """Net -> its breakpoints; none where there is no file.

    Raises
    ------
    FormatError
    """
    if not path.exists():
        return {}
    data = parse_json(read_bounded(path, LARGEST).decode("utf-8", "replace"), str(path))
    if (
        not isinstance(data, dict)
        or data.get("format") != FORMAT
        or data.get("version") != VERSION
        or not isinstance(data.get("nets"), dict)
    ):
        raise FormatError(f"{path}: no breakpoints of the studio")
    found: dict[str, list[Breakpoint]] = {}
    for net, entries in data["nets"].items():
        if not isinstance(entries, list) or len(entries) > MOST:
            raise FormatError(f"{path}: net {net!r} has a list of at most {MOST} breakpoints")
        try:
            found[net] = [Breakpoint(**entry) for entry in entries]
        except (TypeError, CprmError) as error:
            raise FormatError(f"{path}: net {net!r}: {error}") from None
    return found


def write_breakpoints(path: Path, nets: Mapping[str, list[Breakpoint]]) -> None:
    """Keep them; the file is there whole or not at all."""
    content: dict[str, Any] = {"format": FORMAT, "version": VERSION, "nets": {n: [asdict(b) for b in of] for n, of in nets.items() if of}}
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, json.dumps(content, indent=1) + "\n")
