"""HIGH-LEVEL-ANALYSIS and its concurrent version."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ....errors import ModelError
from ...petri import PetriNet
from ..bounded.interval_chain import IntervalChain
from ..bounded.value_iteration import interval_bounds
from ..bounds import Bounds
from ..logic.implication import Implication, implies
from .interference import Interference, groups, interferes
from .modules import Summary, Wiring, check_summaries, wiring

NOWHERE = "nowhere"
"""Outcome of the whole where an outcome of a module leads to nothing."""


@dataclass(frozen=True)
class Link:
    """A way from an outcome to a module, and whether its condition is met there."""

    source: str
    outcome: str
    target: str
    verdict: Implication

    def __str__(self) -> str:
        where = f"{self.source}.{self.outcome}" if self.outcome else self.source
        return f"{where} -> {self.target}: {self.verdict}"


@dataclass(frozen=True)
class HighLevel:
    """What follows for the whole.

    Attributes
    ----------
    links : tuple of Link
        Every way, with its check: the condition after implies the condition before.
    outcomes : mapping of str to Bounds
        Outcome of the whole -> least and most probability; empty where a condition is not met, since then nothing follows.
    steps : Bounds
        Expected cycles, least and most.
    together : tuple of tuples of str
        Modules that must be analysed as one: co-active, and interfering.
    interference : tuple of Interference
        Why.
    """

    links: tuple[Link, ...]
    outcomes: Mapping[str, Bounds]
    steps: Bounds
    together: tuple[tuple[str, ...], ...] = ()
    interference: tuple[Interference, ...] = ()

    @property
    def sound(self) -> bool | None:
        """Whether all conditions are met and nothing interferes; None where some check is undecided."""
        answers = {link.verdict.holds for link in self.links} | ({False} if self.together else set())
        return False if False in answers else None if None in answers else True

    def __str__(self) -> str:
        lines = [str(link) for link in self.links]
        lines += [f"{name}: {bounds}" for name, bounds in self.outcomes.items()]
        return "\n".join([*lines, *(f"must be analysed as one: {', '.join(g)}" for g in self.together)])


def high_level_analysis(
    net: PetriNet | Wiring, summaries: Mapping[str, Summary], *, before: str = "1", after: Mapping[str, str] | None = None,
    kinds: Mapping[str, str] | None = None,
) -> HighLevel:  # fmt: skip
    """Algorithm 3.1: check the conditions along every way, and chain what the modules do.

    Outcome probabilities are chained as intervals (nature picks within them anew whenever a module begins), which is sound however the
    states differ in which it begins. Where an outcome leads to several modules nature picks among them too.

    Parameters
    ----------
    net : PetriNet or Wiring
    summaries : mapping of str to Summary
        Of every module.
    before : str
        What is true when the whole begins.
    after : mapping of str to str, optional
        Outcome of the whole -> what it promises.
    kinds : mapping of str to str, optional
        Of quantities, as for `implies`.

    Raises
    ------
    ModelError, NetError
    """
    ways = net if isinstance(net, Wiring) else wiring(net)
    names = tuple(dict.fromkeys([*ways.first, *(m for m, _ in ways.leads), *(t for ts in ways.leads.values() for t in ts if t[0] != "=")]))
    check_summaries(names, summaries)
    if not ways.first:
        raise ModelError("high-level analysis: no module begins when the whole does")
    links = [Link("the beginning", "", m, implies(before, summaries[m].before, kinds)) for m in ways.first]
    for (module, outcome), targets in ways.leads.items():
        known = summaries[module].outcomes.get(outcome)
        if known is None or known.probability[1] == 0.0:
            continue
        for target in targets:
            needed = (after or {}).get(target[1:], "1") if target[0] == "=" else summaries[target].before
            links.append(Link(module, outcome, target.lstrip("="), implies(known.after, needed, kinds)))
    if any(link.verdict.holds is False for link in links):
        return HighLevel(tuple(links), {}, Bounds(0.0, float("inf")))
    outcomes, steps = _chained(ways, summaries, names)
    return HighLevel(tuple(links), outcomes, steps)


def _chained(ways: Wiring, summaries: Mapping[str, Summary], names: Sequence[str]) -> tuple[dict[str, Bounds], Bounds]:
    """The interval chain of modules."""
    ends = tuple(dict.fromkeys([*(t[1:] for ts in ways.leads.values() for t in ts if t[0] == "="), NOWHERE]))
    number = {name: k for k, name in enumerate((*names, *(f"={e}" for e in ends)))}
    rows: list[dict[int, tuple[float, float]]] = [{} for _ in range(len(number) + 1)]
    for name in names:
        row = rows[number[name]]
        for outcome, known in summaries[name].outcomes.items():
            targets = ways.leads.get((name, outcome)) or (f"={NOWHERE}",)
            low, high = known.probability
            for target in targets:
                a, b = row.get(number[target], (0.0, 0.0))
                row[number[target]] = (a + (low if len(targets) == 1 else 0.0), min(1.0, b + high))
    start = len(number)
    rows[start] = {number[m]: (1.0, 1.0) if len(ways.first) == 1 else (0.0, 1.0) for m in ways.first}
    chain = IntervalChain.from_rows(rows, {e: [number[f"={e}"]] for e in ends}, start, (*number, "the beginning"))
    found = interval_bounds(chain)
    used = {e: b for e, b in found.probabilities.items() if e != NOWHERE or b.high > 0.0}
    shortest, longest = (f(summaries[n].steps[k] for n in names) for k, f in ((0, min), (1, max)))
    begun = Bounds(max(0.0, found.time.low - 1.0), found.time.high - 1.0)  # the first step is the beginning
    most = 0.0 if begun.high == 0.0 else begun.high * longest
    return used, Bounds(begun.low * shortest, most)


def high_level_concurrent_analysis(
    net: PetriNet | Wiring, summaries: Mapping[str, Summary], co_active: Sequence[tuple[str, str]] | None = None, *,
    edges: Sequence[tuple[str, str]] = (), joint: Mapping[tuple[str, ...], Summary] | None = None, before: str = "1",
    after: Mapping[str, str] | None = None, kinds: Mapping[str, str] | None = None,
) -> HighLevel:  # fmt: skip
    """Algorithm 3.2: the same where modules may work at once.

    Pairs that do not interfere are taken as if alone. Others are grouped (all that are connected by interfering pairs, since sets of
    co-active modules may overlap), and a group needs a joint summary, under the names of its modules; without one the answer demands it.

    Parameters
    ----------
    net, summaries, before, after, kinds : as of `high_level_analysis`
    co_active : sequence of pairs, optional
        Modules that may work at once; by default what the timed state space says of the net (unknown counts as may).
    edges : sequence of (str, str)
        Which quantity the world lets depend on which.
    joint : mapping of tuples of str to Summary, optional
        Group, in alphabetical order -> its joint summary, whose outcomes are those of its modules, ``"turn.done"``.
    """
    if co_active is None:
        if isinstance(net, Wiring):
            raise ModelError("co_active: a wiring does not say which modules may work at once")
        from ..timed.properties import analyze_timed

        timed = analyze_timed(net)
        pairs = timed.modules.together if timed.modules else {}
        co_active = [(a, b) for (a, b), verdict in pairs.items() if verdict.holds is not False]
    found = [i for a, b in co_active if (i := interferes(a, summaries[a], b, summaries[b], edges, kinds)).holds is not False]
    demanded = tuple(g for g in groups([(i.first, i.second) for i in found]) if g not in (joint or {}))
    if demanded:
        return HighLevel((), {}, Bounds(0.0, float("inf")), demanded, tuple(found))
    merged, ways = _merged(net if isinstance(net, Wiring) else wiring(net), dict(summaries), joint or {})
    answer = high_level_analysis(ways, merged, before=before, after=after, kinds=kinds)
    return HighLevel(answer.links, answer.outcomes, answer.steps, (), tuple(found))


def _merged(ways: Wiring, summaries: dict[str, Summary], joint: Mapping[tuple[str, ...], Summary]) -> tuple[dict[str, Summary], Wiring]:
    """The net m' of the text: one module for each group."""
    name_of = {m: "+".join(group) for group in joint for m in group}
    for group, summary in joint.items():
        for m in group:
            summaries.pop(m, None)
        summaries["+".join(group)] = summary
    leads: dict[tuple[str, str], tuple[str, ...]] = {}
    for (module, outcome), targets in ways.leads.items():
        own = name_of.get(module)
        key = (own, f"{module}.{outcome}") if own else (module, outcome)
        leads[key] = tuple(dict.fromkeys(name_of.get(t, t) for t in targets))
    return summaries, Wiring(tuple(dict.fromkeys(name_of.get(m, m) for m in ways.first)), leads)
