"""Which controller to take when: what the measurements say to somebody who has to choose."""

from __future__ import annotations

from ..conditions import DEFAULT
from ..facts import CONCURRENCY
from ..pieces import HOLDS, IN_PART, UNDECIDED, Finding, Told, listed, percent
from ..players import INTERNAL, NET, ON, STRUCTURES
from ..results import Results

Advice = tuple[str, str, str]
"""When, what to take, why."""


def guide(results: Results, told: list[Told]) -> list[Advice]:
    """Rows for what was measured; the others are left out."""
    by_name = {one.name: one for one in told}
    found: list[Advice | None] = [
        _ordinary(results, by_name.get("table")), _memory(results), _senses(results, by_name.get("senses")),
        _disturbed(by_name.get("disturbances")),
        _slow(by_name.get("slow")), _many(results), _sure(by_name.get("analysis")), _cheap(results, by_name.get("table")),
    ]  # fmt: skip
    return [row for row in found if row is not None]


def _ordinary(results: Results, told: Told | None) -> Advice | None:
    if told is None or not told.comparisons:
        return None
    lost: dict[str, int] = {}
    against: dict[str, int] = {}
    for c in told.comparisons:
        fair = c.first == NET or not any(d.first == NET and d.task == c.task for d in told.comparisons)
        if fair and c.second in STRUCTURES:
            against[c.second] = against.get(c.second, 0) + 1
            lost[c.second] = lost.get(c.second, 0) + (c.better == c.first)
    equal = [name for name in against if not lost[name]]
    behind = [f"{name} (in {lost[name]} of {against[name]} tasks)" for name in against if lost[name]]
    if not equal:
        return None
    tail = f" Behind: {listed(behind)}." if behind else ""
    return ("A task at ordinary senses", f"any of {listed(['net', *equal])}: what is easiest to write for you",
            f"with the same skills and knowledge none of them is decidedly worse than the net in any of the tasks "
            f"played.{tail}")  # fmt: skip


def _memory(results: Results) -> Advice | None:
    plain, net, internal = (results.played("Hike", DEFAULT, name) for name in ("belief_region", NET, INTERNAL))
    if plain is None or net is None or plain.rate()[2] >= net.rate()[1]:
        return None
    more = ""
    if internal is not None:
        times = internal.microseconds / max(net.microseconds, 1e-9)
        more = f" With internal variables it comes home in {100 * internal.rate()[0]:.0f} %, at {times:.1f} times the net's decision time."
    return ("What to do depends on what was done before", "anything that remembers; not belief_region",
            f"the hike: belief_region {percent(plain.rate())} %, the net {percent(net.rate())} %.{more}")  # fmt: skip


def _senses(results: Results, told: Told | None) -> Advice | None:
    if told is None or not told.comparisons:
        return None
    ahead = [c for c in told.comparisons if c.better == c.first]
    if not ahead:
        undecided = any(f.verdict == UNDECIDED for f in told.findings)
        return None if undecided else ("Senses are poor", "dead reckoning (memory)", "neither tracker nor belief was ahead of it.")
    best = max(ahead, key=lambda c: c.difference)
    where: dict[str, list[str]] = {}
    for c in ahead:
        where.setdefault(c.task, [])
        where[c.task] += [c.condition] if c.condition not in where[c.task] else []
    shown = listed([f"{task} ({', '.join(names)})" for task, names in where.items()])
    return ("Senses are poor", "a better tier of knowledge under the same structure: tracker or belief",
            f"decidedly ahead of dead reckoning in {shown}; most {100 * best.difference:+.0f} points "
            f"({best.first.split(ON)[1]}, {best.task}, {best.condition}).")  # fmt: skip


def _decided(told: Told | None, claim: str) -> list[Finding]:
    """What was found of a claim that holds, in part at least."""
    return [f for f in told.findings if f.claim == claim and f.verdict in (HOLDS, IN_PART)] if told is not None else []


def _disturbed(told: Told | None) -> Advice | None:
    found = _decided(told, "recovery")
    return ("Things go wrong on the way", "recovery written into the behaviour", found[0].figure) if found else None


def _slow(told: Told | None) -> Advice | None:
    found = _decided(told, "slow")
    return ("Inference is slower than the world", "reflexes: raw readings beside what is inferred", found[0].figure) if found else None


def _many(results: Results) -> Advice | None:
    ks = sorted({int(cell.task) for cell in results.cells if cell.condition == CONCURRENCY})
    if not ks:
        return None
    machine, net = (results.fact(CONCURRENCY, str(ks[-1]), form) for form in ("product machine", "net"))
    if machine is None or net is None or machine["lines"] <= net["lines"]:
        return None
    return ("Several things are done at once", "a net, or machines side by side; not one machine",
            f"{ks[-1]} skills: {machine['transitions']:,} rules as one machine, {net['transitions']} transitions as a net.")  # fmt: skip


def _sure(told: Told | None) -> Advice | None:
    found = _decided(told, "code opaque")
    return ("You have to know beforehand what it can never do", "a net (cprm)", found[0].figure) if found else None


def _cheap(results: Results, told: Told | None) -> Advice | None:
    if told is None:
        return None
    costs: dict[str, list[float]] = {}
    for cell, played in results.cells.items():
        if cell.condition == DEFAULT and cell.player in STRUCTURES and played.n and not played.error:
            costs.setdefault(cell.player, []).append(played.microseconds)
    if not costs:
        return None
    shown = ", ".join(f"{name} {min(v):.0f} to {max(v):.0f}" for name, v in costs.items())
    cheapest = sorted(costs, key=lambda name: max(costs[name]))[:3]
    return ("Decisions have to be cheap", f"{listed(cheapest)}: the cheapest at their dearest",
            f"us a decision over the tasks: {shown}. A cycle has 100,000.")  # fmt: skip
