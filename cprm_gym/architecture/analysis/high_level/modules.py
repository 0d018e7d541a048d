"""Summaries of modules, and how a net leads from one to the next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ....errors import ModelError, NetError, did_you_mean
from ...petri import PetriNet, Transition
from ..bounds import Bounds
from ..markov.absorption import Absorption


@dataclass(frozen=True)
class Outcome:
    """How a module may end.

    Parameters
    ----------
    probability : (low, high)
        Over all states in which the module may begin.
    after : str
        What is true then, an expression.
    """

    probability: tuple[float, float] = (0.0, 1.0)
    after: str = "1"

    def __post_init__(self) -> None:
        low, high = self.probability
        if not 0.0 <= low <= high <= 1.0:
            raise ModelError(f"outcome: its probability lies between two chances, got {tuple(self.probability)}")
        object.__setattr__(self, "probability", Bounds(low, high))


@dataclass(frozen=True)
class Summary:
    """What is known of a module.

    Parameters
    ----------
    outcomes : mapping of str to Outcome
        Port -> how it may end there.
    before : str
        What must be true when it begins, an expression.
    steps : (low, high)
        Expected cycles, least and most.
    reads, writes : tuple of str
        Quantities that its decisions depend on, and that its commands change.
    keeps : str
        What it relies on while it works, beyond what it reads; empty: everything it reads must stay as it is.
    """

    outcomes: Mapping[str, Outcome]
    before: str = "1"
    steps: tuple[float, float] = (0.0, float("inf"))
    reads: tuple[str, ...] = ()
    writes: tuple[str, ...] = ()
    keeps: str = ""

    def __post_init__(self) -> None:
        low = sum(o.probability[0] for o in self.outcomes.values())
        high = sum(o.probability[1] for o in self.outcomes.values())
        if not self.outcomes or low > 1.0 + 1e-9 or high < 1.0 - 1e-9:
            raise ModelError(
                f"summary: the probabilities of {', '.join(self.outcomes) or 'no outcomes'} cannot sum to one: {low} to {high}"
            )


def summarise(solved: Absorption, entries: Sequence[int], after: Mapping[str, str] | None = None, before: str = "1") -> Summary:
    """The summary of a module from its exact analysis: [inf, sup] over the states in which it may begin.

    Parameters
    ----------
    solved : Absorption
    entries : sequence of int
        Those states.
    after : mapping of str to str, optional
        Outcome -> what is true then.
    before : str

    Raises
    ------
    ModelError
        Without entries.
    """
    at = np.asarray(list(entries), np.int64)
    if not at.size:
        raise ModelError("summary: needs a state in which the module may begin")
    outcomes = {}
    for k, name in enumerate(solved.outcomes):
        p, error = solved.probabilities[k][at], solved.ratios[k] * solved.time[at]
        bounds = Bounds(float(max(0.0, (p - error).min())), float(min(1.0, (p + error).max())))
        if name in solved.chain.outcomes or bounds.high > 0.0:
            outcomes[name] = Outcome(bounds, (after or {}).get(name, "1"))
    time = solved.time[at]
    return Summary(outcomes, before, (float(time.min()), float(time.max())))


@dataclass(frozen=True)
class Wiring:
    """Where outcomes lead.

    Attributes
    ----------
    first : tuple of str
        Modules that begin when the whole does.
    leads : mapping of (module, outcome) to tuple of str
        Modules that may begin next, and outcomes of the whole, ``"=done"``; empty: nowhere.
    """

    first: tuple[str, ...]
    leads: Mapping[tuple[str, str], tuple[str, ...]] = field(default_factory=dict)


def wiring(net: PetriNet) -> Wiring:
    """Read off a net of modules which outcome of each leads to which module, or to which outcome of the whole.

    Tokens are followed through the net's own transitions and places, whatever tests and priorities say: every way that there may be
    unless the whole is interrupted.

    Parameters
    ----------
    net : PetriNet

    Raises
    ------
    NetError
        When a net has no modules.
    """
    if not net.modules:
        raise NetError(f"net {net.name!r} has no modules")
    begins = {f"{name}.{module.ports.begin}": name for name, module in net.modules.items() if module.ports.begin}
    exits = set(net.ports.outcomes)
    own = {p.name for p in net.places}
    ended = {f"{name}.{outcome}" for name, module in net.modules.items() for outcome in module.ports.outcomes}
    able = _uninterrupted(net, ended)

    def follow(start: str) -> tuple[str, ...]:
        found, seen, todo = dict[str, None](), {start}, [start]
        while todo:
            place = todo.pop(0)
            for t in able:
                if place not in t.inputs or ended & set(t.inputs) - {place}:
                    continue
                for out in t.outputs:
                    if out in begins:
                        found[begins[out]] = None
                    elif out in exits:
                        found[f"={out}"] = None
                    elif out in own and out not in seen and out != net.ports.ongoing:
                        seen.add(out)
                        todo.append(out)
        return tuple(found)

    leads = {}
    for name, module in net.modules.items():
        for outcome in module.ports.outcomes:
            leads[name, outcome] = follow(f"{name}.{outcome}")
    sources = [net.ports.begin] if net.ports.begin else [p.name for p in net.places if getattr(p, "tokens", 0)]
    first = dict.fromkeys(m for source in sources for m in follow(source) if not m.startswith("="))
    return Wiring(tuple(first), leads)


def _uninterrupted(net: PetriNet, ended: set[str]) -> list[Transition]:
    """Transitions of the net itself that may fire although nobody interrupts it."""
    marked = {p.name for p in net.places if getattr(p, "tokens", 0)} | ended
    if net.ports.begin:
        marked.add(net.ports.begin)
    able: list[Transition] = []
    while True:
        more = [t for t in net.transitions if t not in able and set(t.inputs) <= marked and not set(t.inputs) & set(net.ports.interrupts)]
        if not more:
            return able
        able += more
        marked |= {out for t in more for out in t.outputs}


def check_summaries(net_modules: Sequence[str], summaries: Mapping[str, Summary]) -> None:
    """Whether there is a summary for each module.

    Raises
    ------
    ModelError
    """
    for name in net_modules:
        if name not in summaries:
            raise ModelError(f"module {name!r} has no summary.{did_you_mean(name, summaries)}")
