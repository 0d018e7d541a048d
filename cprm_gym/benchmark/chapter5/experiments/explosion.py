"""Experiment 5: k concurrent skills as one machine, as machines side by side, as a net."""

from __future__ import annotations

from typing import Any

from ..cells import Cell, Size, Wanted
from ..facts import CONCURRENCY, CONTAINED
from ..facts.concurrency import FORMS, SECONDS
from ..pieces import FAILS, HOLDS, IN_PART, Curves, Finding, Point, Series, Table, Told
from ..results import Results

TITLE = "State explosion"
QUESTION = "What do k skills at a time cost to write down, to build and to analyse?"
MACHINE = "state machine"
SHOWN = {
    "states": "states or places",
    "transitions": "rules or transitions",
    "build": "seconds to build",
    "analyse": "seconds to analyse as a whole",
}


def _numbers(size: Size) -> tuple[int, ...]:
    return tuple(range(1, 9)) if size.full else (1, 2, 4, 6)


def wanted(size: Size) -> list[Wanted]:
    """k x form, and a state machine against its net."""
    return [Wanted(Cell(str(k), CONCURRENCY, form)) for k in _numbers(size) for form in FORMS] + [
        Wanted(Cell("GoToBall", CONTAINED, MACHINE))
    ]


def tell(results: Results, size: Size) -> Told:
    """Sizes and times over k."""
    found = {(k, form): results.fact(CONCURRENCY, str(k), form) for k in _numbers(size) for form in FORMS}
    rows = []
    for (k, form), fact in found.items():
        if fact is not None:
            apart = "-" if fact["apart"] is None else f"{fact['apart']:.3f}"
            whole = f"{fact['analyse']:.3f}" if fact["whole"] else f"not to its end in {fact['analyse']:.0f}"
            sizes = (f"{fact[key]:,}" for key in ("states", "transitions", "lines"))
            rows.append((str(k), form, *sizes, f"{fact['build']:.4f}", whole,
                         f"{fact['explored']:,}", apart, "yes" if fact["alike"] else "no"))  # fmt: skip
    panels = tuple(
        Curves(what, tuple(
            Series(form, tuple(_point(k, fact[key]) for (k, f), fact in found.items() if f == form and fact is not None)) for form in FORMS
        ), tuple((float(k), str(k)) for k in _numbers(size)), "skills at a time, k", what, log=True)
        for key, what in SHOWN.items()
    )  # fmt: skip
    head = ("k", "form", "states or places", "rules or transitions", "lines", "build, s", "analyse as a whole, s", "explored",
            "skill by skill, s",
            "sends what the net sends")  # fmt: skip
    notes = (
        "A skill rests, works while its signal is there, and recovers for a cycle; the skills share nothing. "
        "Subsumption is analysed by its "
        "product, having no method of its own. The net's analysis finds states, standstill, bounds and liveness for "
        "every environment and any "
        "order of what happens at once; a machine's finds the states that can be reached, so their times are not of the same work.",
    )
    return Told("explosion", TITLE, QUESTION, (Table("Size and time", head, tuple(rows)),), panels, (), _findings(results, found), notes)


def _point(k: int, value: float) -> Point:
    value = max(float(value), 1e-5)
    return Point(float(k), value, value, value)


def _findings(results: Results, found: dict[tuple[int, str], dict[str, Any] | None]) -> tuple[Finding, ...]:
    told = []
    same = results.fact(CONTAINED, "GoToBall", MACHINE)
    if same is not None:
        verdict = HOLDS if same["alike"] == same["cycles"] else FAILS
        told.append(
            Finding(
                "fsm contained", verdict, f"Machine and net sent the same in {same['alike']} of {same['cycles']} cycles of random readings."
            )
        )
    most = max((k for k, _ in found), default=0)
    facts = [found.get((most, form)) for form in FORMS]
    if any(fact is None for fact in facts):
        return tuple(told)
    machine, layers, net = (fact or {} for fact in facts)
    alike = all(fact["alike"] for fact in found.values() if fact is not None)
    told.append(Finding("explosion", HOLDS if alike and machine["lines"] > 10 * net["lines"] else FAILS,
        f"{most} skills take {machine['states']:,} states and {machine['transitions']:,} rules as one machine, {net['states']} places and "
        f"{net['transitions']} transitions as a net; {'all' if alike else 'not all'} send the same."))  # fmt: skip
    ended = "comes to its end" if net["whole"] else f"does not come to its end within {SECONDS:.0f} s of the clock"
    small = layers["lines"] <= net["lines"]
    apart, whole = net["apart"] < layers["analyse"], net["whole"] and net["analyse"] < layers["analyse"]
    verdict = HOLDS if small and apart and whole else IN_PART if small or apart else FAILS
    told.append(Finding("layers", verdict,
        f"{most} layers take {layers['lines']} lines, the net {net['lines']}. Whole, the layers are analysed in {layers['analyse']:.1f} s "
        f"and the net, of which more is asked, in {net['analyse']:.1f} s; skill by skill, which the net's contracts allow, it takes "
        f"{net['apart']:.2f} s.",
        f"Analysed as a whole the net explodes, too: {net['explored']:,} steps, and it {ended}. The skills share nothing."))  # fmt: skip
    return tuple(told)
