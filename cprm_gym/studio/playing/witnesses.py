"""The analysis of a net, with the runs that show its answers, to be played in a drawing of the net."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ...architecture.analysis.budget import Budget
from ...architecture.analysis.report import analyze
from ...architecture.analysis.verdicts import Step, Verdict
from ...architecture.petri import PetriNet, Place, compile_net

SECONDS = 20.0
"""That an analysis may take; what it has not found out by then is not known."""


def analysis(net: PetriNet, seconds: float = SECONDS) -> dict[str, Any]:
    """What ``cprm-gym analyze`` says of a net.

    Returns
    -------
    dict
        ``verdicts``: each with ``part`` (untimed, timed, contract, composition), ``name``, ``holds``, ``why`` and ``run``, a list of steps
        ``{cycle, kind, what, marking}`` in which every marking is known; ``notes``; ``start``, the marking before the run.
    """
    report = analyze(net, budget=Budget(seconds=seconds))
    verdicts = []
    for part, name, verdict in _all(report):
        steps = [*verdict.run, *verdict.loop]
        verdicts.append(
            {"part": part, "name": name, "holds": verdict.holds, "why": verdict.why, "run": _played(net, steps), "loop": len(verdict.loop)}
        )
    compiled = compile_net(net)
    start = {name: int(v) for name, v in zip(compiled.place_names, compiled.initial) if v and name in _discrete(net)}
    return {"net": net.name, "verdicts": verdicts, "notes": list(report.notes), "start": start}


def _discrete(net: PetriNet) -> set[str]:
    return {p.name for p in compile_net(net).net.places if isinstance(p, Place)}


def _all(report: Any) -> Iterator[tuple[str, str, Verdict]]:
    """Every verdict of a report."""
    for part in ("untimed", "timed"):
        found = getattr(report, part)
        for name, value in vars(found).items() if found is not None else ():
            if isinstance(value, Verdict):
                yield part, name.replace("_", " "), value
    for verdict in report.contract.clauses if report.contract is not None else ():
        yield "contract", verdict.title or verdict.name, verdict
    for misuse in report.composition.misuses if report.composition is not None else ():
        yield "composition", "modules are used as they assume", Verdict(False, str(misuse), run=misuse.run)


def _played(net: PetriNet, steps: list[Step]) -> list[dict[str, Any]]:
    """Steps with their markings; where time is left out they are those that firing gives."""
    found: list[dict[str, Any]] = []
    plain = all(step.kind == "fires" and not step.marking for step in steps)
    markings = _fired(net, [step.what for step in steps]) if plain else None
    for k, step in enumerate(steps):
        marking: Mapping[str, Any] = step.marking if markings is None else markings[k]
        found.append({"cycle": step.cycle, "kind": step.kind, "what": step.what, "marking": dict(marking)})
    return found


def _fired(net: PetriNet, names: list[str]) -> list[dict[str, int]]:
    """The discrete markings after each firing, conditions on quantities left aside."""
    compiled = compile_net(net)
    discrete = _discrete(net)
    row = compiled.initial.copy()
    found: list[dict[str, int]] = []
    for name in names:
        if name not in compiled.transition_names:  # of what was added around the net
            found.append(dict(found[-1]) if found else {})
            continue
        t = compiled.transition(name)
        for place, weight in compiled.inputs.of(t):
            row[place] -= weight
        for place, weight in compiled.outputs.of(t):
            row[place] += weight
        for place, value in compiled.sets.of(t):
            row[place] = value
        found.append({n: int(v) for n, v in zip(compiled.place_names, row) if v and n in discrete})
    return found
