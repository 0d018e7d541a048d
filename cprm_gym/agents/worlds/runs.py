"""Episodes of the simulator as runs: behaviours on a stage, to be sampled, looked at with properties, and told again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...architecture.analysis.sampling.runs import UNFINISHED, Run
from ...architecture.petri import CompiledNet, PetriNet, Place, compile_net
from ...architecture.petri.net.modules import instances
from ...envs.pitch import wrapped
from .learned import behaviour
from .stage import Change, Stage

PLAYERS = 3
"""Ball and the two players of a stage."""


@dataclass(frozen=True)
class StageRuns:
    """Episodes of a behaviour in the simulator, in batch.

    Run k is the same whoever is played beside it. Signals are what the net observes, 1 for each command of the body that goes out,
    ``ends.arrived`` (1 where that outcome is marked), ``works.slow`` (1 where that module is at work), and the truth (`true_signals`).

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
        parts = modules_of(cast.net)
        for cycle, played in enumerate(stage.play([_seed(seed, k) for k in numbers])):
            if signals:
                row = {name: values.copy() for name, values in played.seen.items()}
                row |= {c: np.array([float(c in sent) for sent in played.commands]) for c in cast.acts}
                row |= {f"works.{name}": (played.read(place) > 0).astype(float) for name, place in parts.items()}
                row |= {f"ends.{outcome}": marked.astype(float) for outcome, marked in played.marks.items()}
                rows.append({**row, **true_signals(stage, rows[-1] if rows else None)})
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


def modules_of(net: PetriNet) -> dict[str, str]:
    """Module of the skill -> the place that is marked while it is at work."""
    found = {}
    for path, instance in instances(net).items():
        if instance.net.ports.ongoing:
            name = ".".join(part for part in path.split(".") if part != "skill")
            found[name or "skill"] = instance.places[instance.net.ports.ongoing]
    return found


def true_signals(stage: Stage, before: Mapping[str, NDArray[np.float64]] | None) -> dict[str, NDArray[np.float64]]:
    """What is true on a stage, whatever the players perceive; lengths in m, speeds in m / cycle.

    ``true.ball_x``, ``true.ball_y``; ``true.distance`` of the ball from the first player, ``true.nearer``: by how much it is nearer than a
    cycle ago; ``true.off_axis``: degrees of the ball from where he faces, ``true.straighter``: by how many fewer than a cycle ago;
    ``true.aside``: m by which what the ball rolls along passes him; ``true.mate_off_axis``: degrees of the team-mate from where he faces;
    ``true.ball_speed``; ``true.off_mate``: degrees between where the ball rolls and where the team-mate stands; ``true.promised``: 1 where
    the world is as the behaviour promises (`Cast.promised`).
    """
    world = stage.core.sim.world
    ball, me, mate, flies = world["pos"][:, 0], world["pos"][:, 1], world["pos"][:, 2], world["vel"][:, 0]
    gap, way = ball - me, mate - ball
    distance = np.hypot(*gap.T)
    off = np.degrees(np.abs(wrapped(np.arctan2(gap[:, 1], gap[:, 0]) - world["body"][:, 0])))
    speed = np.hypot(*flies.T)
    old = before or {"true.distance": distance, "true.off_axis": off}
    return {
        "true.ball_x": ball[:, 0].copy(),
        "true.ball_y": ball[:, 1].copy(),
        "true.distance": distance,
        "true.nearer": old["true.distance"] - distance,
        "true.off_axis": off,
        "true.straighter": old["true.off_axis"] - off,
        "true.mate_off_axis": np.degrees(np.abs(wrapped(np.arctan2(*(mate - me).T[::-1]) - world["body"][:, 0]))),
        "true.ball_speed": speed,
        "true.aside": np.abs(gap[:, 0] * flies[:, 1] - gap[:, 1] * flies[:, 0]) / np.maximum(speed, 1e-9),
        "true.off_mate": np.degrees(np.abs(wrapped(np.arctan2(flies[:, 1], flies[:, 0]) - np.arctan2(way[:, 1], way[:, 0])))),
        "true.promised": np.asarray(stage.cast.promised(stage.core), float),
    }


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
