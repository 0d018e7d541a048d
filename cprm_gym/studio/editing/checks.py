"""Checks of a net in the background: structure, contract, use of modules; each finding names the parts it is about."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Mapping
from typing import Any

from ...architecture.analysis import Budget, Verdict, check_composition, check_contract
from ...architecture.analysis.net_arrays import System
from ...architecture.analysis.structure.conservation import conservative
from ...architecture.analysis.structure.invariants import flow_basis
from ...architecture.analysis.timed.environment import closed_system
from ...architecture.analysis.timed.properties import judge_timed
from ...architecture.analysis.timed.state_space import explore_timed
from ...architecture.petri import PetriNet, compile_net
from ...errors import CprmError

SECONDS = 5.0
"""What one check may take; what is not known by then is said to be unknown."""
SETTLE = 0.4
"""Seconds without a change after which checks begin."""
REMEMBERED = 200
QUOTED = re.compile(r"'([^']+)'")


def check_net(net: PetriNet, seconds: float = SECONDS) -> list[dict[str, Any]]:
    """What can be said about one net: by kind ``contract``, ``composition`` and ``structure``.

    Parameters
    ----------
    net : PetriNet
    seconds : float
        For each kind.

    Returns
    -------
    list of dict
        ``kind``, ``title``, ``holds`` (None: not known), ``text``, ``names`` (places, transitions and instances that it is about) and
        ``run``, the steps that show it.
    """
    found: list[dict[str, Any]] = []
    for kind, check in (("contract", _contract), ("composition", _composition), ("structure", _structure)):
        try:
            found += check(net, Budget(seconds=seconds))
        except CprmError as error:
            found.append(_finding(net, kind, kind, None, f"cannot be checked: {error}"))
    return found


def _contract(net: PetriNet, budget: Budget) -> list[dict[str, Any]]:
    ports = net.ports
    if not (ports.begin and ports.ongoing and ports.outcomes):
        return []
    report = check_contract(net, budget=budget)
    found = [_of_verdict(net, "contract", v.name, v, v.title) for v in report.clauses]
    return found + [_finding(net, "contract", "warning", None, text) for text in report.warnings]


def _composition(net: PetriNet, budget: Budget) -> list[dict[str, Any]]:
    if not any(m.ports.begin and m.ports.ongoing and m.ports.outcomes for m in net.modules.values()):
        return []
    report = check_composition(net, budget=budget)
    found = []
    for misuse, holds in [*((m, False) for m in report.misuses), *((m, None) for m in report.undecided)]:
        made = _finding(net, "composition", misuse.kind, holds, misuse.why, [str(s) for s in misuse.run])
        made["names"] = list(dict.fromkeys([misuse.instance.partition(".")[0], *made["names"]]))
        found.append(made)
    text = "modules are used as they assume" if report.holds else "not everything was explored"
    return found or [_finding(net, "composition", "modules", report.holds, text)]


def _structure(net: PetriNet, budget: Budget) -> list[dict[str, Any]]:
    budget, clock = budget.start()
    compiled = compile_net(net)
    system = System.from_net(compiled)
    found = []
    isolated = [p.name for p in compiled.net.places if p.name in system.places and not _touched(compiled.net, p.name)]
    if isolated:
        found.append(_finding(net, "structure", "unused", None, "no arc touches " + ", ".join(map(repr, isolated)), names=isolated))
    space = explore_timed(closed_system(compiled, None, enough=clock.spent), budget.part(0.8))
    timed = judge_timed(compiled, space, (), clock.spent)
    for title, verdict, promise in (
        ("becomes quiet", timed.becomes_quiet, "immediate transitions come to an end in every instant"),
        ("bounded", timed.bounded, "no place fills up without end"),
    ):
        found.append(_of_verdict(net, "structure", title, verdict, promise))
    if timed.dead_transitions:
        names = list(timed.dead_transitions)
        found.append(_finding(net, "structure", "dead", None, "never fire: " + ", ".join(map(repr, names)), names=names))
    for emission in timed.emissions:
        found.append(_finding(net, "structure", "two commands", None, str(emission)))
    for invariant in flow_basis(system, "P", clock.spent).vectors[:8]:
        found.append(_finding(net, "structure", "invariant", True, f"{invariant} = {invariant.value}", names=list(invariant.weights)))
    if (sums := conservative(system, clock.left)).holds:
        found.append(_of_verdict(net, "structure", "conservative", sums, "a weighted sum of all tokens never changes"))
    return found


def _touched(net: PetriNet, name: str) -> bool:
    return any(name in arcs for t in net.transitions for arcs in (t.inputs, t.outputs, t.tests, t.inhibitors, t.sets)) or any(
        name in (getattr(p, "expression", ""), *re.findall(r"[A-Za-z][\w.]*", getattr(p, "expression", ""))) for p in net.places
    )


def _of_verdict(net: PetriNet, kind: str, title: str, verdict: Verdict, promise: str) -> dict[str, Any]:
    text = promise if verdict.holds else verdict.why or promise
    run = [str(s) for s in verdict.run] + [f"for ever: {s}" for s in verdict.loop]
    made = _finding(net, kind, title, verdict.holds, text, run)
    if verdict.holds is False and not made["names"] and verdict.firings:
        made["names"] = _known(net, verdict.firings[-1:])
    if verdict.holds is False and not made["names"]:
        made["names"] = _known(net, [name for name in (net.ports.begin, net.ports.ongoing) if name])
    return made


def _finding(
    net: PetriNet, kind: str, title: str, holds: bool | None, text: str, run: list[str] | None = None, names: list[str] | None = None
) -> dict[str, Any]:
    about = _known(net, names if names is not None else QUOTED.findall(text))
    return {"kind": kind, "title": title, "holds": holds, "text": text, "names": about, "run": run or []}


def _known(net: PetriNet, names: Any) -> list[str]:
    """Own parts of the net that flat names mean: an inner one is its instance."""
    own = {p.name for p in net.places} | {t.name for t in net.transitions}
    found = [name if name in own else name.partition(".")[0] if name.partition(".")[0] in net.modules else "" for name in names]
    return [name for name in dict.fromkeys(found) if name]


class Checker:
    """Checks nets in a thread of its own, the newest first; answers of nets that were not changed are remembered.

    Parameters
    ----------
    tell : callable
        Called with (document, revision, definition key, findings) for each net that was checked.
    seconds : float
        For each kind of check of each net.
    """

    def __init__(self, tell: Callable[[str, int, str, list[dict[str, Any]]], None], seconds: float = SECONDS) -> None:
        self.tell, self.seconds = tell, seconds
        self._asked: dict[str, tuple[int, Mapping[str, PetriNet]]] = {}
        self._known: dict[PetriNet, list[dict[str, Any]]] = {}
        self._change = threading.Condition()
        self._thread: threading.Thread | None = None
        self._ended = False

    def ask(self, document: str, revision: int, nets: Mapping[str, PetriNet]) -> None:
        """Check these nets, instead of earlier ones of the same document."""
        with self._change:
            self._asked[document] = revision, nets
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="net checks", daemon=True)
                self._thread.start()
            self._change.notify()

    def close(self) -> None:
        """End after the check that is under way."""
        with self._change:
            self._ended = True
            self._change.notify()

    def _run(self) -> None:
        while True:
            with self._change:
                self._change.wait_for(lambda: self._asked or self._ended)
                if self._ended:
                    return
                while self._change.wait(SETTLE) and not self._ended:  # more changes are coming
                    pass
                document = next(reversed(self._asked), "")
                asked = self._asked.pop(document, None)
            for key, net in asked[1].items() if asked else ():
                if self._ended or document in self._asked:
                    break  # it was changed meanwhile
                findings = self._known.get(net)
                if findings is None:
                    findings = self._known[net] = check_net(net, self.seconds)
                    while len(self._known) > REMEMBERED:
                        del self._known[next(iter(self._known))]
                self.tell(document, asked[0] if asked else 0, key, findings)
