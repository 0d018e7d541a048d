"""A net in its world, played."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...petri import PetriNet
from ..sampling.runs import UNFINISHED, Run
from .explore import NetStates
from .worlds import World, heeded


@dataclass(frozen=True, eq=False)
class ProductRuns:
    """Runs of a net in a world: what `product` solves, drawn.

    Parameters
    ----------
    net : PetriNet
    world : World
    outcomes_ : mapping of str to str
        Outcome -> place.
    ends : tuple of str
        Outcomes of the world's own.
    limit : int
        Cycles after which a run is cut off.
    """

    net: PetriNet
    world: World
    outcomes_: Mapping[str, str]
    limit: int = 1000
    ends: tuple[str, ...] = ()

    @property
    def outcomes(self) -> tuple[str, ...]:
        """Those of the net, and `UNFINISHED`."""
        return tuple(dict.fromkeys((*self.outcomes_, *self.ends, UNFINISHED)))

    def play(self, numbers: Sequence[int], seed: int, signals: bool) -> list[Run]:
        """The runs with the given numbers; signals are the percepts, and 1 for each command that goes out."""
        count = len(numbers)
        rngs = [np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(k,))) for k in numbers]
        start = self.world.start()
        chances = np.cumsum([p for _, p in start])
        at: list[Hashable] = [start[min(int(np.searchsorted(chances, rng.random(), "right")), len(start) - 1)][0] for rng in rngs]
        nets = NetStates(self.net, self.outcomes_, max(count, 1))
        marks, heeds = [0] * count, heeded(self.world)
        silent = dict.fromkeys(nets.executor.command_names, 0.0)
        seen: list[list[dict[str, float]]] = [[] for _ in range(count)]
        runs: list[Run | None] = [None] * count
        going = list(range(count))
        for cycle in range(self.limit):
            percepts = [self.world.percepts(at[k]) for k in going]
            after, fired, ended = nets.step([marks[k] for k in going], percepts)
            for place, k in enumerate(going):
                marks[k] = after[place]
                if signals:
                    seen[k].append({**percepts[place], **silent, **dict.fromkeys(fired[place], 1.0)})
                if ended[place] is not None:
                    runs[k] = Run(str(ended[place]), cycle, _columns(seen[k]))
                    continue
                steps = self.world.next(at[k], fired[place] + nets.marks(marks[k], heeds))
                u, total = rngs[k].random(), 0.0
                for step in steps:
                    total += step.chance
                    if u < total:
                        break
                at[k] = step.state
                if own := self.world.ended(at[k]):
                    runs[k] = Run(own, cycle + 1, _columns(seen[k]))
            going = [k for k in going if runs[k] is None]
            if not going:
                break
        return [run if run is not None else Run(UNFINISHED, self.limit, _columns(seen[k])) for k, run in enumerate(runs)]


def _columns(rows: list[dict[str, float]]) -> dict[str, np.ndarray]:
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: np.array([row.get(name, 0.0) for row in rows]) for name in names}
