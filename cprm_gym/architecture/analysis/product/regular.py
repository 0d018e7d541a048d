"""Bounds of a net in a learned world from what most runs keep to (`bounded.regular`)."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ....errors import ModelError
from ...petri import CompiledNet, PetriNet
from ..bounded.interval_chain import IntervalChain
from ..bounded.regular import OFTEN, Regular, RegularBounds, counted, shared_confidence
from ..budget import Budget
from .explore import STATES, NetStates, product
from .learned_world import UNSEEN, Cell, LearnedWorld
from .worlds import Step, heeded


@dataclass(eq=False)
class RegularWorld:
    """A learned world of its regular rows alone; where they end it is `UNSEEN` (a `World`).

    Parameters
    ----------
    world : LearnedWorld
    regular : Regular
    """

    world: LearnedWorld
    regular: Regular
    _steps: dict[Any, list[Step]] = field(default_factory=dict, repr=False)

    @property
    def heeds(self) -> tuple[str, ...]:
        """As of the world."""
        return self.world.heeds

    def start(self) -> Sequence[tuple[Hashable, float]]:
        """Where runs of the first half began."""
        total = sum(self.regular.begins.values())
        return [(cell, n / total) for cell, n in self.regular.begins.items()]

    def percepts(self, state: Hashable) -> Mapping[str, float]:
        """As of the world."""
        return self.world.percepts(state)

    def ended(self, state: Hashable) -> str:
        """As of the world."""
        return self.world.ended(state)

    def name(self, state: Hashable) -> str:
        """As of the world."""
        return self.world.name(state)

    def next(self, state: Hashable, commands: tuple[str, ...]) -> Sequence[Step]:
        """Regular cells that followed, within intervals; else `UNSEEN`."""
        key: Any = (state, self.world.told(commands))
        if key not in self._steps:
            row = self.regular.row(key)
            self._steps[key] = [Step(then, p, *b) for then, (p, b) in row.items()] or [Step(UNSEEN, 1.0, 1.0, 1.0)]
        return self._steps[key]


def regular_bounds(
    net: PetriNet | CompiledNet, world: LearnedWorld, outcomes: Mapping[str, str], *, cycles: int | None = None, confidence: float = 0.95,
    budget: Budget | None = None,
) -> RegularBounds:  # fmt: skip
    """Bounds of a net's outcomes in a learned world that has runs held out.

    Parameters
    ----------
    net, outcomes
        As of `product`.
    world : LearnedWorld
        The coarser its cells the more often each is seen: `LearnedWorld.coarser` with the net's own thresholds.
    cycles : int, optional
        Also bound what has come by each cycle up to this.
    confidence : float
        Of everything together.
    budget : Budget, optional
        States of each chain, and seconds: divisions that it does not reach are left out.

    Raises
    ------
    ModelError
        When no run was held out, or all were.
    """
    if not world.later or len(world.later) >= sum(world.begins.values()):
        raise ModelError(f"learned world: bounds are had from runs of which some were held out, not all; {len(world.later)} were")
    limits, clock = (budget or Budget(states=STATES)).start()
    share, found = shared_confidence(confidence), RegularBounds(len(world.later))
    first, begins = _first_half(world)
    strays = _strays(NetStates(net, outcomes), world)
    for often in OFTEN:
        regular = Regular(first, begins, world.later, often, share, strays)
        if found.useful(regular.division):
            found.take(_chain(net, RegularWorld(world, regular), outcomes, limits), regular.division, tuple(outcomes), cycles)
        if clock.spent():
            break
    return found


def _strays(runner: NetStates, world: LearnedWorld) -> set[int]:
    """Runs that were held out in which the net did not do what it does with the readings that were kept of their cells."""
    known: dict[tuple[int, Cell], tuple[int, tuple[str, ...] | None]] = {}
    heeds, at, strays = heeded(world), [0] * len(world.later), set[int]()
    going = list(range(len(at)))
    for cycle in range(max(map(len, world.later))):
        fresh = list({(at[k], world.later[k][cycle][0]) for k in going} - known.keys())
        for first in range(0, len(fresh), runner.batch):
            part = fresh[first : first + runner.batch]
            after, fired, ended = runner.step([m for m, _ in part], [world.percepts(cell) for _, cell in part])
            for pair, then, sent, end in zip(part, after, fired, ended):
                known[pair] = then, None if end is not None else world.told(sent + runner.marks(then, heeds))
        for k in going:
            cell, told = world.later[k][cycle]
            at[k], does = known[at[k], cell]
            if does != told:
                strays.add(k)
        going = [k for k in going if k not in strays and cycle + 1 < len(world.later[k])]
    return strays


def _first_half(world: LearnedWorld) -> tuple[dict[Any, dict[Hashable, int]], dict[Hashable, int]]:
    """Counts and beginnings without the runs that were held out."""
    later = counted(world.later)
    first: dict[Any, dict[Hashable, int]] = {}
    for key, row in world.counts.items():
        kept: dict[Hashable, int] = {}
        for then, n in row.items():
            if n > (m := later.get(key, {}).get(then, 0)):
                kept[then] = n - m
        if kept:
            first[key] = kept
    begun: dict[Hashable, int] = {}
    for run in world.later:
        begun[run[0][0]] = begun.get(run[0][0], 0) + 1
    begins: dict[Hashable, int] = {}
    for cell, n in world.begins.items():
        if n > begun.get(cell, 0):
            begins[cell] = n - begun.get(cell, 0)
    return first, begins


def _chain(net: PetriNet | CompiledNet, world: RegularWorld, outcomes: Mapping[str, str], budget: Budget) -> IntervalChain:
    """Net and regular world, with one state more from which nature picks where it begins."""
    made = product(net, world, outcomes, budget=budget)
    chain, starts = made.bounded, world.regular.start()
    begun = np.flatnonzero(chain.initial)
    bounds = [starts[made.states[i][1]] for i in begun.tolist()]
    initial = np.zeros(chain.n + 1)
    initial[-1] = 1.0
    return IntervalChain(
        np.append(chain.offsets, chain.offsets[-1] + len(begun)), np.concatenate((chain.targets, begun.astype(np.int32))),
        np.concatenate((chain.lower, [b.low for b in bounds])), np.concatenate((chain.upper, [b.high for b in bounds])),
        chain.outcomes, initial,
    )  # fmt: skip
