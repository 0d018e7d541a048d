"""Which controller to take when: what the measurements say to somebody who has to choose."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from ..comparisons import Comparison
from ..conditions import DEFAULT
from ..experiments.disturbances import by_task, own_rules, watchdogs
from ..experiments.making import reached
from ..experiments.senses import room, spoken
from ..experiments.table import believing, same_knowledge
from ..facts import CONCURRENCY, TRAINING
from ..pieces import HOLDS, IN_PART, MATTERS, UNDECIDED, Finding, Told, listed, points
from ..players import INTERNAL, LEARNED, NET, STRUCTURES
from ..results import Results

Advice = tuple[str, str, str]
"""When, what to take, why."""
KINDS = {"noise": "noise", "lost": "lost readings", "late": "late news", "view": "a narrow or a wide view"}
"""How a condition's name begins -> what is worse there."""


def guide(results: Results, told: list[Told]) -> list[Advice]:
    """Rows for what was measured; the others are left out."""
    by_name = {one.name: one for one in told}
    found: list[Advice | None] = [
        _ordinary(by_name.get("table")), _senses(results, by_name.get("senses")), _several(by_name.get("table")),
        _slow(by_name.get("slow")),
        _disturbed(by_name.get("disturbances")), _memory(results), _many(results), _sure(by_name.get("analysis")),
        _cheap(results, by_name.get("table")), _elsewhere(by_name.get("transfer")), _trained(results, by_name.get("making")),
    ]  # fmt: skip
    return [row for row in found if row is not None]


def _ordinary(told: Told | None) -> Advice | None:
    """Of who knows the same: whoever is nowhere behind the net by as much as matters."""
    alike = [] if told is None else [c for c in same_knowledge(told.comparisons) if c.metric == "success"]
    if not alike:
        return None
    tasks = {c.task for c in alike}
    lost = {name: {c.task for c in alike if c.second == name and c.better == c.first and c.difference > MATTERS} for name in STRUCTURES[1:]}
    equal = [name for name in lost if not lost[name] and any(c.second == name for c in alike)]
    behind = [f"{name} in {len(where)}" for name, where in lost.items() if where]
    if not equal:
        return ("The task is an ordinary one", "the net (cprm)", f"Behind it by more than {100 * MATTERS:.0f} points: {listed(behind)}.")
    tail = f" Decidedly behind, and by more than that as estimated: {listed(behind)}." if behind else ""
    widest = max(max(-c.low, c.high) for c in alike if c.second in equal)
    return ("The task is an ordinary one", f"what is easiest for you to write: {listed(['net', *equal])}",
            f"With the same skills and the same knowledge no difference of more than {100 * MATTERS:.0f} points from the net is decided "
            f"in any of {len(tasks)} tasks; the intervals allow up to {100 * widest:.0f}.{tail}")  # fmt: skip


def _several(table: Told | None) -> Advice | None:
    """What a belief is worth at ordinary senses, if it is ahead anywhere."""
    if table is None or not any((c.first, c.second) == ("cprm", NET) and c.better == c.first for c in table.comparisons):
        return None
    when = "Senses are ordinary, and much depends on where several others are"
    return (when, "a belief: cprm", believing(table.comparisons))


def _senses(results: Results, told: Told | None) -> Advice | None:
    if told is None or not told.comparisons:
        return None
    ahead = [c for c in told.comparisons if c.better == c.first]
    if not ahead:
        undecided = any(f.verdict == UNDECIDED for f in told.findings)
        return None if undecided else ("Senses are poor", "dead reckoning (memory)", "Neither tracker nor belief was ahead of it.")
    kinds = listed([name for kind, name in KINDS.items() if any(c.condition.startswith(kind) for c in ahead)])
    best = max(ahead, key=lambda c: c.difference)
    level = listed([name for kind, name in KINDS.items() if not any(c.condition.startswith(kind) for c in ahead)])
    tail = f" Under {level} nothing is decided: dead reckoning may do." if level else ""
    return (f"Senses are poor: {kinds}", "the same structure on a tracker or a belief instead of dead reckoning",
            f"Most in {best.task} with {spoken(best.condition)}{room(results, best)}.{tail}")  # fmt: skip


def _slow(told: Told | None) -> Advice | None:
    found = None if told is None else _decided([told], "slow")
    if told is None or found is None:
        return None
    pairs = [c for c in told.comparisons if c.condition != DEFAULT and "no reflexes" in c.second]
    most = max(pairs, key=lambda c: c.difference, default=None)
    text = found.figure if most is None else f"With reflexes the goalie saves {points(most)} more than without under {most.condition}."
    return ("Inference is slower than the world", "dead reckoning, if that will do; beside a model reflexes, from what the eye sees now",
            f"{text} {found.more}")  # fmt: skip


def _disturbed(told: Told | None) -> Advice | None:
    if told is None or _decided([told], "recovery") is None:
        return None
    said = [f"ahead of the same behaviour with a watchdog instead in {by_task(watchdogs(told.comparisons))}"]
    calm = [c for c in told.comparisons if c.second == watchdogs(told.comparisons)[0].second and c.condition == DEFAULT and c.better]
    said += [f"undisturbed by {listed([f'{points(c)} in {c.task}' for c in calm])}"] * bool(calm)
    others = own_rules(told.comparisons)
    if others:
        whom = Counter(c.second for c in others if c.better == c.first)
        which = f" ({listed([f'{name} {count}' for name, count in whom.most_common()])})" if whom else ""
        said.append(f"ahead of structures that recover by their own rules in {_ahead(others)} comparisons{which}")
    return ("Things go wrong on the way", "recovery in the behaviour, as in cprm, before a watchdog",
            f"cprm, with its recovery parts, is {'; '.join(said)}.")  # fmt: skip


def _ahead(comparisons: Sequence[Comparison]) -> str:
    """``3, behind in 0 of 6``."""
    won, lost = sum(c.better == c.first for c in comparisons), sum(c.better == c.second for c in comparisons)
    return f"{won}, behind in {lost} of {len(comparisons)}"


def _memory(results: Results) -> Advice | None:
    plain, net, internal = (results.played("Hike", DEFAULT, name) for name in ("belief_region", NET, INTERNAL))
    if plain is None or net is None or plain.rate()[2] >= net.rate()[1]:
        return None
    more = ""
    if internal is not None:
        times = internal.microseconds / max(net.microseconds, 1e-9)
        more = (
            f" With its intention as a variable of the model it comes home in {100 * internal.rate()[0]:.0f} %, at {times:.1f} times the "
        )
        more += "net's decision time."
    return ("What to do depends on what was done before", "anything that remembers; not belief_region",
            f"From the hike belief_region comes home in {100 * plain.rate()[0]:.0f} %, the net in {100 * net.rate()[0]:.0f} %."
            + more)  # fmt: skip


def _many(results: Results) -> Advice | None:
    ks = sorted({int(cell.task) for cell in results.cells if cell.condition == CONCURRENCY})
    if not ks:
        return None
    machine, layers, net = (results.fact(CONCURRENCY, str(ks[-1]), form) for form in ("product machine", "subsumption", "net"))
    if machine is None or layers is None or net is None or machine["lines"] <= net["lines"]:
        return None
    return ("Several things are done at once", "machines side by side (subsumption) or a net; not one machine",
            f"{ks[-1]} skills: {machine['transitions']:,} rules as one machine, {layers['transitions']} side by side, {net['transitions']} "
            "transitions as a net.")  # fmt: skip


def _sure(told: Told | None) -> Advice | None:
    found = None if told is None else _decided([told], "code opaque")
    return None if found is None else ("You have to know beforehand what it can never do", "a Petri net (net, cprm)", found.figure)


def _cheap(results: Results, told: Told | None) -> Advice | None:
    if told is None:
        return None
    costs: dict[str, list[float]] = {}
    for cell, played in results.cells.items():
        if cell.condition == DEFAULT and cell.player in (NET, *STRUCTURES) and played.n and not played.error:
            costs.setdefault(cell.player, []).append(played.microseconds)
    if not costs:
        return None
    dearest = {name: max(costs[name]) for name in sorted(costs, key=lambda name: max(costs[name]))}
    shown = ", ".join(f"{name} {most:.0f}" for name, most in dearest.items())
    return ("Decisions have to be cheap", f"{listed(list(dearest)[:3])}",
            f"µs a decision where each is dearest: {shown}. A cycle has 100,000, so all are fast enough for one agent.")  # fmt: skip


def _elsewhere(told: Told | None) -> Advice | None:
    found = None if told is None else _decided([told], "transfer")
    return None if found is None else ("It will play in another world than it was made for", "what is best at home", found.figure)


def _trained(results: Results, told: Told | None) -> Advice | None:
    """A learner, where it came as far as the CPRM in its training."""
    if told is None:
        return None
    good, never = [], []
    for cell in results.cells:
        fact = results.fact(TRAINING, cell.task, LEARNED) if cell.condition == TRAINING else None
        found = results.played(cell.task, DEFAULT, "cprm")
        if fact is None or found is None:
            continue
        steps, rate = reached(fact["curve"], found.rate()[0]), f"{100 * found.rate()[0]:.1f} %"
        if steps is None:
            never.append(f"{cell.task} (cprm {rate}, trained for {int(fact['curve'][-1][0]):,})")
        else:
            good.append(f"{cell.task} after {steps:,} (cprm {rate})")
    if not good and not never:
        return None
    said = [f"As good as the CPRM, in agent-steps: {listed(good)}."] * bool(good)
    said += [f"Not in its training: {listed(never)}."] * bool(never)
    return ("Nobody wants to write it, and there is a simulator", "a learner, where one was seen to learn it" if good else "a written one",
            " ".join(said))  # fmt: skip


def _finding(told: Iterable[Told], claim: str) -> Finding | None:
    return next((f for one in told for f in one.findings if f.claim == claim), None)


def _decided(told: Iterable[Told], claim: str) -> Finding | None:
    """What was found of a claim that holds, in part at least."""
    found = _finding(told, claim)
    return found if found is not None and found.verdict in (HOLDS, IN_PART) else None
