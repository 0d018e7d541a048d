"""Why a transition did not fire, what fired one after the other, which reading moved a belief."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ...architecture.cprm import CPRMRunner
from ...architecture.petri.execution.compiled_net import PlaceKind
from ...architecture.petri.execution.failures import conditions_of
from ...errors import CprmError, unknown_name
from ..running.frames import MOST_FIRED, Message, distribution, marginal, moments, number, variables
from ..running.memory import runner_of
from ..running.run import Run


def runner_in(run: Run, agent: str) -> CPRMRunner:
    """What runs an agent's net.

    Raises
    ------
    UnknownName
        When there is no such agent.
    CprmError
        When he does not play with a net of ours.
    """
    if agent not in run.agents:
        raise unknown_name("agent", agent, run.agents)
    runner = runner_of(run.players[run.agents.index(agent)])
    if runner is None:
        raise CprmError(f"{agent} does not play with a net")
    return runner


# ------------------------------------------------------------------ one firing after the other


def firings(run: Run, agent: str) -> list[Message]:
    """What fired in this cycle, in order, each with why, what else was enabled, and the tokens after it.

    Raises
    ------
    UnknownName, CprmError
    """
    runner = runner_in(run, agent)
    executor = runner.executor
    if executor.trace is None or not len(executor.trace):
        return []
    net = executor.net
    (before, _), *_ = executor.trace.cycles()
    row = before.row[0].copy()
    discrete = net.kind == PlaceKind.DISCRETE
    found = []
    for firing in executor.trace.firings(0)[:MOST_FIRED]:
        t = net.transition(firing.transition)
        was = row.copy()
        for place, weight in net.inputs.of(t):
            row[place] -= weight
        for place, weight in net.outputs.of(t):
            row[place] += weight
        for place, value in net.sets.of(t):
            row[place] = value
        changed = np.flatnonzero((row != was)[: net.n_places] & discrete)
        found.append(
            {
                "transition": firing.transition,
                "timed": firing.timed,
                "reason": firing.reason,
                "enabled": [name for name in firing.enabled if name != firing.transition],
                "tokens": {net.place_names[p]: [number(was[p]), number(row[p])] for p in changed},
            }
        )
    return found


# ------------------------------------------------------------------ why not


def why_not(run: Run, agent: str, transition: str, earlier: Iterable[tuple[int, Mapping[str, Any]]]) -> Message:
    """What keeps a transition from firing.

    Parameters
    ----------
    run : Run
    agent : str
    transition : str
    earlier : iterable of (int, mapping)
        Cycles before this one, the latest first, with the markings that were shown.

    Returns
    -------
    dict
        ``answer``, a sentence; ``conditions``, each with the place, what it needs, what it has, by how much it fails, and in which cycle
        it last held (None: in none that is kept); ``fired``, whether it fired in this cycle; ``beaten``, what fired instead while it was
        enabled; ``clock``, cycles counted and needed.

    Raises
    ------
    UnknownName, CprmError
    """
    runner = runner_in(run, agent)
    executor = runner.executor
    t = executor.net.transition(transition)
    row = executor.marking[0]
    found: list[Message] = []
    for c in conditions_of(executor.net, executor._program, row, t):
        lack = max(c.low - c.has, c.has - c.high, 0.0)
        found.append(
            {
                "place": c.place,
                "low": None if math.isinf(c.low) else number(c.low),
                "high": None if math.isinf(c.high) else number(c.high),
                "has": number(c.has),
                "holds": c.holds,
                "by": number(lack),
                "text": f"{c.place} has {c.has:g}" if c.holds else c.reason(),
            }
        )
    missing = {entry["place"]: entry for entry in found if not entry["holds"]}
    first: int | None = None
    for cycle, marking in earlier:
        first = cycle
        for entry in missing.values():
            has = marking.get(entry["place"], 0.0) or 0.0
            if "held" not in entry and (entry["low"] is None or entry["low"] <= has) and (entry["high"] is None or has < entry["high"]):
                entry["held"] = cycle
        if all("held" in entry for entry in missing.values()):
            break
    happened = firings(run, agent)
    fired = [k for k, f in enumerate(happened) if f["transition"] == transition]
    beaten = [f for f in happened if transition in f["enabled"]]
    reasons = executor.why_not(transition)
    timed = int(executor.net.delay[t])
    return {
        "transition": transition,
        "cycle": run.cycle,
        "conditions": found,
        "fired": len(fired),
        "beaten": [{"transition": f["transition"], "reason": f["reason"]} for f in beaten],
        "clock": [int(executor.clocks(transition)[0].max(initial=-1)), timed] if timed else None,
        "first": first,
        "answer": _answer(transition, len(fired), reasons, beaten),
    }


def _answer(transition: str, fired: int, reasons: list[str], beaten: list[Message]) -> str:
    """One sentence."""
    if fired:
        again = f"; now {'; '.join(reasons)}" if reasons else ""
        return f"{transition} fired in this cycle{'' if fired == 1 else f' {fired} times'}{again}"
    if beaten:
        first = beaten[-1]
        return f"{transition} was enabled, but {first['transition']} fired first ({first['reason']})" + (
            f"; now {'; '.join(reasons)}" if reasons else ""
        )
    return f"{transition} did not fire: {'; '.join(reasons)}" if reasons else f"{transition} is enabled, and fires in the next cycle"


# ------------------------------------------------------------------ what moved a belief


def moved(run: Run, agent: str, variable: str) -> Message:
    """Which readings of this cycle moved a belief.

    Parameters
    ----------
    run : Run
    agent, variable : str

    Returns
    -------
    dict
        ``before``, the belief without any reading of this cycle; ``after``; ``evidence``, for each reading its value, how far the belief
        would lie from ``after`` without it alone (total variation, 0 to 1, or for a real number the distance in standard deviations), and
        its expectation then; largest first.

    Raises
    ------
    UnknownName, CprmError
    """
    runner = runner_in(run, agent)
    if variable not in (known := variables(runner)):
        raise unknown_name("variable", variable, known)
    i = run.agents.index(agent)
    told = [name for name, _, shown in runner.told if shown[0]]
    after, at = distribution(runner, variable), marginal(runner, variable)
    kind = known[variable]
    names = list(dict.fromkeys(told))

    def read() -> tuple[Message, Any]:
        return distribution(runner, variable), marginal(runner, variable)

    answers = run.without(i, [names, *([name] for name in names)], read)
    values = {name: float(value[0]) for name, value, _ in runner.told}
    evidence = []
    for name, (message, found) in zip(names, answers[1:]):
        evidence.append({"name": name, "value": number(values[name]), "moved": number(_far(at, found, kind)), "mean": message.get("mean")})
    evidence.sort(key=lambda e: -(e["moved"] or 0.0))
    return {
        "variable": variable,
        "cycle": run.cycle,
        "before": answers[0][0],
        "after": after,
        "evidence": evidence,
        "moved": number(_far(at, answers[0][1], kind)),
        "relations": list(runner._tuples(runner._in_force, 0)),
    }


def _far(a: Any, b: Any, variable: Any) -> float:
    """How far two beliefs lie apart."""
    if variable.quantity is None:
        return float(0.5 * np.abs(np.asarray(a) - np.asarray(b)).sum())
    (ma, sa), (mb, _) = moments(a, variable), moments(b, variable)
    return abs(ma - mb) / max(sa, 1e-9)
