"""Episodes of the simulator as runs: behaviours on a stage, to be sampled, looked at with properties, and told again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...architecture.analysis.sampling.runs import UNFINISHED, Run
from ...architecture.petri import CompiledNet, Place, compile_net
from .learned import behaviour
from .stage import Change, Stage

PLAYERS = 3
"""Ball and the two players of a stage."""


@dataclass(frozen=True)
class StageRuns:
    """Episodes of a behaviour in the simulator, in batch.

    Run k is the same whoever is played beside it. Signals are what the net observes, 1 for each command of the body that goes out, and the
    truth: ``true.ball_x``, ``true.ball_y``, ``true.distance`` (of the ball from the first player, m).

    Parameters
    ----------
    name : str
        Of `learned.BEHAVIOURS`.
    change : callable, optional
        Makes another net of the skill's; with several workers an importable one.
    """

    name: str
    change: Change | None = None

    @property
    def outcomes(self) -> tuple[str, ...]:
        """Those of the behaviour, and `UNFINISHED`."""
        return (*behaviour(self.name).cast(self.change).outcomes, UNFINISHED)

    def play(self, numbers: Sequence[int], seed: int, signals: bool) -> list[Run]:
        """The episodes with the given numbers."""
        count = len(numbers)
        cast = behaviour(self.name).cast(self.change)
        stage = Stage(cast, count, seed)
        what, ended = [UNFINISHED] * count, np.full(count, -1)
        rows: list[dict[str, NDArray[np.float64]]] = []
        for cycle, played in enumerate(stage.play([_seed(seed, k) for k in numbers])):
            if signals:
                row = {name: values.copy() for name, values in played.seen.items()}
                row |= {c: np.array([float(c in sent) for sent in played.commands]) for c in cast.acts}
                ball, me = (stage.core.sim.world["pos"][:, k].copy() for k in (0, 1))
                rows.append({**row, "true.ball_x": ball[:, 0], "true.ball_y": ball[:, 1], "true.distance": np.hypot(*(ball - me).T)})
            for outcome, marked in played.marks.items():
                for w in np.flatnonzero(marked & (ended < 0)).tolist():
                    what[w], ended[w] = outcome, cycle
            if (ended >= 0).all():
                break
        runs = []
        for w in range(count):
            last = int(ended[w]) if ended[w] >= 0 else cast.limit
            columns = {name: np.array([row[name][w] for row in rows[: last + 1]]) for name in (rows[0] if rows else ())}
            runs.append(Run(what[w], last, columns))
        return runs


class FilmedRun(NamedTuple):
    """One episode, to be drawn."""

    name: str
    outcome: str
    number: int
    places: NDArray[np.float64]
    """(T, 3, 2) Ball and players, m."""
    bodies: NDArray[np.float64]
    """(T, 3) Where they face, rad; of the ball 0."""
    marked: list[dict[str, float]]
    """Marked places of the net in each cycle."""
    commands: list[tuple[str, ...]]
    """Of the bodies in each cycle."""


def film(name: str, number: int, seed: int, change: Change | None = None) -> FilmedRun:
    """Play one run of `StageRuns` again and keep what can be drawn of it.

    Parameters
    ----------
    name : str
        Of `learned.BEHAVIOURS`.
    number, seed : int
        Which run.
    change : callable, optional
    """
    cast = behaviour(name).cast(change)
    stage = Stage(cast, 1, seed)
    names = _discrete(compile_net(cast.net))
    places, bodies, marked, commands = [], [], [], []
    outcome = UNFINISHED
    for played in stage.play([_seed(seed, number)]):
        world = stage.core.sim.world[0]
        places.append(world["pos"][:PLAYERS].copy())
        bodies.append([0.0, *world["body"][: PLAYERS - 1]])
        marked.append({place: n for place in names if (n := float(played.read(place)[0]))})
        commands.append(played.commands[0])
        came = [o for o, mark in played.marks.items() if mark[0]]
        if came:
            outcome = came[0]
            break
    return FilmedRun(name, outcome, number, np.array(places), np.array(bodies), marked, commands)


def _discrete(net: CompiledNet) -> tuple[str, ...]:
    return tuple(p.name for p in net.net.places if isinstance(p, Place))


def _seed(seed: int, number: int) -> np.random.SeedSequence:
    return np.random.SeedSequence(seed, spawn_key=(number,))
