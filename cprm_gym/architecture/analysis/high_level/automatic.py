"""Algorithm 3.1 without a hand: each module of a net analysed in place, summarised, and the summaries chained.

A module is run alone from every state in which it may begin: those in which the whole begins, and those to which the net leads from where
another module has ended, found until no new ones come up. Its outcomes' probabilities are [inf, sup] over these states, apart for each way
by which it is entered: the text's ``P(Output_i | Input_j)``. What is true before and after is the least box around the states, so that the
conditions hold along all ways by construction; what is proved is about every state that modules hand to each other.

What the net itself does between two modules (count, wait, act) is a part like any other where it is more than one sure step.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ....errors import NetError, did_you_mean
from ...petri import PetriNet, Place, Ports, compile_net
from ...petri.net.modules import Instance, instances
from ..bounded.interval_chain import IntervalChain
from ..bounded.value_iteration import interval_bounds
from ..budget import Budget
from ..markov.absorption import absorption
from ..markov.chain import Certified
from ..product.explore import STATES, UNEXPLORED, Product, product
from ..product.worlds import World
from .analysis import HighLevel, high_level_analysis
from .modules import Outcome, Summary, Wiring, summarise

BEGINNING = "the beginning"
Entry = tuple[tuple[tuple[str, float], ...], Hashable]
"""Marked places and a state of the world."""


@dataclass(frozen=True, eq=False)
class Automatic:
    """A net of modules, from what each does by itself.

    Attributes
    ----------
    answer : HighLevel
        Ways with their conditions, outcomes of the whole within bounds, expected cycles.
    summaries : mapping of str to Summary
        ``"slow after cruise.close"`` -> its summary; ``"after slow.strayed"``: what the net does then.
    entries : mapping of str to int
        From how many states each may begin.
    states : mapping of str to int
        Of each module's own chain.
    begins : Certified
        Probability that what is taken to pieces begins at all; all else is said of runs in which it does.
    complete : bool
        Whether no budget cut anything.
    """

    answer: HighLevel
    summaries: Mapping[str, Summary]
    entries: Mapping[str, int]
    states: Mapping[str, int]
    begins: Certified
    complete: bool

    def __str__(self) -> str:
        lines = []
        for name, summary in self.summaries.items():
            known = ", ".join(f"{port} {o.probability}" for port, o in summary.outcomes.items() if o.probability[1] > 0)
            lines.append(f"{name} (from {self.entries[name]} states): {known}")
        return "\n".join([*lines, *(f"{name}: {bounds}" for name, bounds in self.answer.outcomes.items()), f"cycles: {self.answer.steps}"])


def automatic_analysis(net: PetriNet, world: World, path: str = "", *, bounded: bool = False, budget: Budget | None = None) -> Automatic:
    """Summarise each module of a net in a world, and chain them.

    Modules work one after the other. Interrupts and what the net does beside a module at work are not looked at; where modules may work
    at once `high_level_concurrent_analysis` says which must be analysed as one.

    Parameters
    ----------
    net : PetriNet
    world : World
    path : str
        Which of its modules, ``"skill"``, is taken to pieces; the net itself if not given.
    bounded : bool
        Whether summaries hold for all chances within the world's intervals, instead of the likeliest.
    budget : Budget, optional
        States of each module's chain, and seconds of it all.

    Raises
    ------
    NetError
        For an unknown path, or a net without modules or outcomes.
    """
    found = instances(net)
    if path not in found:
        raise NetError(f"net {net.name!r}: unknown module {path!r}.{did_you_mean(path, found)}")
    if not found[path].net.modules or not found[path].net.ports.outcomes:
        raise NetError(f"net {found[path].net.name!r}: to be taken to pieces it needs modules, and outcomes")
    limits, clock = (budget or Budget(states=STATES)).start()
    work = _Work(compile_net(net).net, found[path], world, bounded, limits)
    begun, begins = work.begun()
    work.enter("", BEGINNING, begun)
    todo: list[_Part] = [("", BEGINNING)]
    while todo and not clock.spent():
        for key, entries in work.follow(todo.pop(0)).items():
            if work.enter(*key, entries) and key not in todo:
                todo.append(key)
    return work.chained(begins, not todo)


_Part = tuple[str, str]
"""A module and the way by which it is entered; an empty name: what the net itself does after that."""


@dataclass(eq=False)
class _Work:
    """Modules of one instance, and what is between them, solved in place."""

    flat: PetriNet
    instance: Instance
    world: World
    bounded: bool
    budget: Budget
    entries: dict[_Part, set[Entry]] = field(default_factory=dict)
    solved: dict[str, tuple[frozenset[Entry], _Solved]] = field(default_factory=dict)

    def enter(self, module: str, source: str, entries: Iterable[Entry]) -> bool:
        """Add states in which a part may begin; whether some are new."""
        known = self.entries.setdefault((module, source), set())
        fresh = set(entries) - known
        known |= fresh
        return bool(fresh)

    def begun(self) -> tuple[set[Entry], Certified]:
        """In which states the instance begins, and how likely it does."""
        own = self.instance.net.ports.begin
        if not self.instance.path:
            marking = tuple((p.name, float(p.tokens or p.name == own)) for p in self.flat.places if isinstance(p, Place))
            return {(_marked(marking), state) for state, p in self.world.start() if p > 0}, Certified(1.0, 0.0)
        prefix = f"{self.instance.path}."
        around = tuple(t for t in self.flat.transitions if not t.name.startswith(prefix))
        made = product(
            replace(self.flat, transitions=around, ports=Ports()),
            self.world,
            {"begins": self.instance.places[str(own)]},
            budget=self.budget,
        )
        return _exits(made)["begins"], absorption(made.chain).probability("begins")

    def part(self, module: str, source: str) -> _Solved:
        """A module from all states in which it may begin, by whatever way; or what the net does after one outcome."""
        key = module or f"after {source}"
        ways = [part for part in self.entries if (part[0] == module if module else part == ("", source))]
        entries = frozenset(entry for part in ways for entry in self.entries[part])
        if key not in self.solved or self.solved[key][0] != entries:
            self.solved[key] = entries, _Solved(self._run(module, entries), self)
        return self.solved[key][1]

    def _run(self, module: str, entries: frozenset[Entry]) -> Product:
        inner, places = self.instance.net, self.instance.places
        if module:
            prefix = "".join(f"{name}." for name in (self.instance.path, module) if name)
            kept = tuple(t for t in self.flat.transitions if t.name.startswith(prefix))
            ends = {port: places[f"{module}.{port}"] for port in inner.modules[module].ports.outcomes}
        else:
            own = set(self.instance.transitions.values())
            kept = tuple(t for t in self.flat.transitions if t.name in own)
            ends = {m: places[f"{m}.{net.ports.begin}"] for m, net in inner.modules.items() if net.ports.begin}
            ends |= {f"={port}": places[port] for port in inner.ports.outcomes}
        begun = [(dict(marking), state) for marking, state in sorted(entries, key=repr)]
        return product(replace(self.flat, transitions=kept, ports=Ports()), self.world, ends, budget=self.budget, begun=begun)

    def follow(self, part: _Part) -> dict[_Part, set[Entry]]:
        """The parts that may come next, and in which states they begin."""
        module, source = part
        exits = self.part(module, source).exits
        if module:
            return {("", f"{module}.{port}"): found for port, found in exits.items() if found}
        return {(target, source): found for target, found in exits.items() if found and target in self.instance.net.modules}

    def chained(self, begins: Certified, complete: bool) -> Automatic:
        """The summaries, and what follows for the whole."""
        parts = [part for part, entries in self.entries.items() if entries]
        sure = {part: self._sure(part) for part in parts if not part[0]}
        names = {p: f"{p[0]} after {p[1]}" if p[0] else f"after {p[1]}" for p in parts if not sure.get(p)}

        def leads_to(part: _Part) -> str:
            target = sure.get(part)
            return names[part] if not target else target if target.startswith("=") else names[target, part[1]]

        summaries: dict[str, Summary] = {}
        leads: dict[tuple[str, str], tuple[str, ...]] = {}
        for part, name in names.items():
            module, source = part
            solved = self.part(module, source)
            complete = complete and solved.product.complete
            summaries[name] = solved.summary(self.entries[part])
            for port, outcome in summaries[name].outcomes.items():
                if outcome.probability[1] == 0.0:
                    continue
                own = port in solved.exits  # else of the world's own, or unexplored
                if own and module:
                    leads[name, port] = (leads_to(("", f"{module}.{port}")),)
                else:
                    leads[name, port] = (port if port.startswith("=") else names[port, source] if own else f"={port}",)
        start = leads_to(("", BEGINNING))
        whole = Wiring((start,), leads)
        answer = high_level_analysis(whole, summaries, before=summaries[start].before)
        counts = {name: len(self.entries[part]) for part, name in names.items()}
        return Automatic(answer, summaries, counts, {k: s.product.chain.n for k, (_, s) in self.solved.items()}, begins, complete)

    def _sure(self, part: _Part) -> str:
        """Where the net leads at once and in any case after an outcome; empty if it is not so."""
        solved = self.part(*part)
        came = [k for k, found in solved.exits.items() if found]
        begun = len(self.entries[part])
        at_once = len(solved.product.ended) == begun == solved.product.chain.n - len(solved.product.chain.outcomes)
        return came[0] if len(came) == 1 and at_once else ""

    def box(self, states: Iterable[Hashable]) -> str:
        """The least box around states of the world, as an expression over what is perceived in them."""
        inside = [s for s in states if not self.world.ended(s)]
        hull: Any = getattr(self.world, "hull", None)
        if hull is not None:
            return str(hull(inside))
        rows = [self.world.percepts(s) for s in inside]
        terms = []
        for name in rows[0] if rows else ():
            low, high = min(r[name] for r in rows), max(r[name] for r in rows)
            terms += [f"{name} >= {low!r}", f"{name} <= {high!r}"]
        return " and ".join(terms) or "1"


class _Solved:
    """A part from all states in which it may begin."""

    def __init__(self, made: Product, work: _Work) -> None:
        self.product, self.work = made, work
        self.exits = _exits(made)
        self._exact = None if work.bounded else absorption(made.chain)
        self._at = {_entry(made, i): i for i in np.flatnonzero(made.chain.initial).tolist()}

    def summary(self, entries: set[Entry]) -> Summary:
        """[inf, sup] over these states; a cycle less, since what comes next begins in the cycle in which this ends."""
        after = {port: self.work.box(s for _, s in found) for port, found in self.exits.items() if found}
        before = self.work.box(s for _, s in entries)
        begun = [self._at[e] for e in entries if e in self._at]
        if self._exact is not None:
            known = summarise(self._exact, begun, after, before)
            outcomes, steps = known.outcomes, known.steps
        else:
            found = interval_bounds(_anywhere(self.product.bounded, begun))
            outcomes = {
                o: Outcome((p.low, p.high), after.get(o, "1")) for o, p in found.probabilities.items() if p.high > 0.0 or o in self.exits
            }
            steps = (found.time.low - 1.0, found.time.high - 1.0)
        return Summary(outcomes, before, (max(0.0, steps[0] - 1.0), max(0.0, steps[1] - 1.0)))


def _anywhere(chain: IntervalChain, begun: Sequence[int]) -> IntervalChain:
    """The chain with one state more, from which nature picks where it begins."""
    free = np.zeros(len(begun)) if len(begun) > 1 else np.ones(1)
    initial = np.zeros(chain.n + 1)
    initial[-1] = 1.0
    return IntervalChain(
        np.append(chain.offsets, chain.offsets[-1] + len(begun)), np.concatenate((chain.targets, np.asarray(begun, np.int32))),
        np.concatenate((chain.lower, free)), np.concatenate((chain.upper, np.ones(len(begun)))), chain.outcomes, initial,
    )  # fmt: skip


def _marked(pairs: Iterable[tuple[str, float]]) -> tuple[tuple[str, float], ...]:
    """Places that hold something, in order; clocks of the parts that have ended are left behind."""
    return tuple(sorted((name, n) for name, n in pairs if n and not name.startswith("clock ")))


def _entry(made: Product, state: int) -> Entry:
    m, world = made.states[state]
    return _marked(made.markings[m].items()), world


def _exits(made: Product) -> dict[str, set[Entry]]:
    """Outcome of the net -> marking and state of the world in which it comes."""
    found: dict[str, set[Entry]] = {}
    numbers = {int(k): name for name, at in made.chain.outcomes.items() if name != UNEXPLORED for k in at}
    for i, m in made.ended.items():
        name = numbers[int(made.chain.targets[made.chain.offsets[i]])]
        found.setdefault(name, set()).add((_marked(made.markings[m].items()), made.states[i][1]))
    return found
