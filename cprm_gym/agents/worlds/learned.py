"""Worlds of cells learned from the simulator, a behaviour played alone in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Literal

import numpy as np

from ...architecture.analysis.budget import Clock
from ...architecture.analysis.product.learned_world import LearnedWorld, Row, thresholds_of
from ...architecture.petri import PetriNet, Place, compile_net
from ...architecture.petri.net.modules import instances
from ...errors import unknown_name
from .pair import pair_on_stage
from .stage import Cast, Change, Stage, alone_on_stage

FINER: Mapping[str, tuple[float, ...]] = {
    "distance": (0.5, 0.7, 1.0, 1.3, 1.7, 2.2, 3.0, 4.0, 6.0, 9.0, 13.0, 18.0),
    "off_axis": (5.0, 30.0, 90.0),
    "speed": (0.1, 0.3),
}
"""By the last part of a place's name, where cells are cut beside the thresholds: metres, degrees, metres a cycle."""


@dataclass(frozen=True)
class Behaviour:
    """A behaviour and the outcomes by which it is judged.

    Attributes
    ----------
    cast : callable
        Who plays what; takes a change of the skill's net, or None.
    finer : mapping of str to tuple of float
        Further cuts, beside `FINER`.
    """

    cast: Callable[[Change | None], Cast]
    finer: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    @property
    def limit(self) -> int:
        """Cycles after which it is cut off."""
        return self.cast(None).limit


BEHAVIOURS: dict[str, Behaviour] = {
    **{name: Behaviour(partial(alone_on_stage, name)) for name in ("approach", "catch_ball", "go_to_ball", "pass_ball", "receive")},
    "pass_and_receive": Behaviour(pair_on_stage),
}
"""Those that can be analysed in the simulator's world."""


def behaviour(name: str) -> Behaviour:
    """The behaviour of that name.

    Raises
    ------
    UnknownName
    """
    if name not in BEHAVIOURS:
        raise unknown_name("behaviour", name, BEHAVIOURS)
    return BEHAVIOURS[name]


def edges_of(name: str, net: PetriNet) -> dict[str, tuple[float, ...]]:
    """Where cells of a behaviour's world are cut: its net's thresholds, and finer."""
    more = {**FINER, **behaviour(name).finer}
    return {
        place: tuple(sorted({*cuts, *(more.get(place.rpartition(".")[2], ()) if len(cuts) else ())}))
        for place, cuts in thresholds_of(compile_net(net)).items()
    }


def heeds_of(net: PetriNet, parts: bool = False) -> tuple[str, ...]:
    """Places that say how far a behaviour is: what its modules (or its innermost parts alone) count, and which of them are at work."""
    found = []
    for path, instance in instances(net).items():
        if not path or (parts and instance.net.modules):
            continue
        names = [p.name for p in instance.net.places if isinstance(p, Place) and (p.capacity or 2) > 1]
        found += [instance.places[n] for n in (*names, *filter(None, (instance.net.ports.ongoing,)))]
    return tuple(dict.fromkeys(found))


def learn_world(
    name: str,
    episodes: int = 2000,
    seed: int = 0,
    *,
    net: Any = None,
    confidence: float = 0.95,
    heed: Literal["all", "parts", "nothing"] = "all",
    clock: Clock | None = None,
) -> tuple[PetriNet, dict[str, str], LearnedWorld]:
    """The world of a behaviour, from episodes in the simulator; the second half of them is told once more by itself (`LearnedWorld.later`).

    Parameters
    ----------
    name : str
        Of `BEHAVIOURS`.
    episodes, seed : int
    net : callable, optional
        A broken version, as for `Stage`.
    confidence : float
        Of the intervals, all at once.
    heed : {"all", "parts", "nothing"}
        How far the world is told where the behaviour is (`heeds_of`): all it counts and all that is at work; only that of its innermost
        modules, which can then be analysed apart; or nothing, so that cells forget all but themselves.
    clock : Clock, optional
        Ends the episodes where it says so; an interruption is told to it. What was seen until then is kept: what would have followed is
        unseen.

    Returns
    -------
    (PetriNet, outcomes, LearnedWorld)
    """
    cast = behaviour(name).cast(net)
    stage = Stage(cast, episodes, seed)
    heeds = heeds_of(cast.net, parts=heed == "parts") if heed != "nothing" else ()
    world = LearnedWorld(edges_of(name, cast.net), confidence, cast.acts, heeds)
    before: list[tuple[int, ...] | None] = [None] * episodes
    commands: list[tuple[str, ...]] = [()] * episodes
    going = np.ones(episodes, bool)
    first = episodes - episodes // 2
    runs: list[list[Row]] = [[] for _ in range(first, episodes)]
    try:
        for seen, sent, marks, read in stage.play():
            cells = world.cells({place: read(place) for place in world.edges})
            rows = [tuple(row) for row in cells.tolist()]
            tokens = {place: read(place) for place in heeds}
            for w in np.flatnonzero(going).tolist():
                last = before[w]
                if last is None:
                    world.begin(rows[w], _reading(seen, w))
                elif rows[w] in world.readings:
                    world.saw(last, commands[w], rows[w], {})
                else:
                    world.saw(last, commands[w], rows[w], _reading(seen, w))
                before[w] = rows[w]
                commands[w] = sent[w] + tuple(f"{place}={held[w]:g}" for place, held in tokens.items() if held[w])
                if w >= first:
                    runs[w - first].append((rows[w], world.told(commands[w])))
            over = going & np.logical_or.reduce(list(marks.values()))
            for w in np.flatnonzero(over[first:]).tolist():
                runs[w][-1] = (runs[w][-1][0], None)
            going &= ~over
            if not going.any() or (clock is not None and clock.spent()):
                break
    except KeyboardInterrupt:
        if clock is None:
            raise
        clock.interrupt()
    world.later = [run for run in runs if run]
    return cast.net, dict(cast.outcomes), world


def _reading(seen: Mapping[str, np.ndarray], w: int) -> dict[str, float]:
    return {name: float(values[w]) for name, values in seen.items()}


def simulate(name: str, episodes: int, seed: int, *, net: Any = None) -> tuple[dict[str, int], np.ndarray]:
    """Outcomes of fresh episodes in the simulator, and the cycle in which each ended (-1: cut off)."""
    stage = Stage(behaviour(name).cast(net), episodes, seed)
    counts = dict.fromkeys((*stage.cast.outcomes, "unfinished"), 0)
    ended = np.full(episodes, -1)
    for cycle, played in enumerate(stage.play()):
        for outcome, marked in played.marks.items():
            fresh = marked & (ended < 0)
            counts[outcome] += int(fresh.sum())
            ended[fresh] = cycle
        if (ended >= 0).all():
            break
    counts["unfinished"] = int((ended < 0).sum())
    return counts, ended
