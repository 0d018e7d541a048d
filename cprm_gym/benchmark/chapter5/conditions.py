"""Under what a cell is played: senses, disturbances, other worlds, slow knowledge; by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from ...envs.players.senses import Senses
from ...envs.tasks import Task, make_task
from ...errors import unknown_name
from ...simulator.parameters import ServerParameters
from ...wrappers.disturbances import DISTURBANCES, Disturbance


@dataclass(frozen=True)
class Condition:
    """What differs from a task as it is.

    Parameters
    ----------
    senses : Senses
    disturbance : str
        Of `DISTURBANCES`; empty for none.
    strikes : (int, int), optional
        Cycles from which the one is drawn in which it strikes, if they are not the disturbance's own.
    period, latency : int
        Of slow knowledge (`slow.Slow`): cycles from one inference to the next, and until its result is there.
    parameters : mapping of str to number
        Of the server that differ.
    options : mapping of str to (mapping of str to object)
        Task -> its options that differ.
    """

    senses: Senses = field(default_factory=Senses)
    disturbance: str = ""
    strikes: tuple[int, int] | None = None
    period: int = 1
    latency: int = 0
    parameters: Mapping[str, Any] = field(default_factory=dict)
    options: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def happening(self) -> Disturbance | None:
        """What happens, and when; None where nothing does."""
        if not self.disturbance:
            return None
        found = DISTURBANCES[self.disturbance]
        return found if self.strikes is None else replace(found, first=self.strikes[0], last=self.strikes[1])

    def task(self, name: str) -> Task:
        """The task under it."""
        options = dict(self.options.get(name, {}))
        if self.parameters:
            options["parameters"] = ServerParameters(**self.parameters)
        return make_task(name, **options)


DEFAULT = "default"
NOISES = (0.25, 0.5, 1.0, 2.0, 4.0)
VIEWS = ("narrow", "wide")
LOST = (0.1, 0.2, 0.3, 0.5)
DELAYS = (1, 2, 4)
PERIODS = (2, 5, 10)
LATENCIES = (2, 5, 10)
EARLY, SOON = " early", (2, 10)
"""A disturbance that strikes so soon that a short episode is not over by then, and in which cycles."""

SHIFTS: dict[str, Condition] = {
    "ball rolls on": Condition(parameters={"ball_decay": 0.96}),
    "slow players": Condition(parameters={"player_speed_max": 0.9}),
    "inert players": Condition(parameters={"inertia_moment": 8.0}),
    "hard shots": Condition(options={"Goalie": {"difficulty": 0.8}, "GoToBall": {"rolling": 1.0, "speed": 2.5},
                                     "LostAndFound": {"kicked": 1.0, "fast": 2.8}}),
    "other starts": Condition(options={"Goalie": {"shots": 0.0}, "GoToBall": {"near": 40.0, "far": 60.0},
                                       "Goalie2v1": {"near": 12.0, "far": 18.0}, "LostAndFound": {"near": 8.0, "far": 14.0},
                                       "HFO1v0": {"ball_x": (0.0, 10.0), "ball_y": 33.0}}),
    "stronger opponents": Condition(options={"Goalie": {"others": "mixing"}, "Goalie2v1": {"others": ("weak", "strong")}}),
}  # fmt: skip
"""Worlds that nobody was tuned or trained for."""

MATCHES: dict[str, dict[str, Any]] = {
    name: {"controlled": "left", "others": "strong", "max_cycles": 300} for name in ("Soccer5v5", "Soccer11v11")
}
"""Matches as the suite plays them, half a minute of each from the kick-off on: a whole one takes as long as thousands of drills."""

CONDITIONS: dict[str, Condition] = {
    DEFAULT: Condition(options=MATCHES),
    **{f"noise {n:g}": Condition(senses=Senses(noise=n)) for n in NOISES},
    **{f"view {v}": Condition(senses=Senses(view=v)) for v in VIEWS},
    **{f"lost {n:g}": Condition(senses=Senses(lost=n)) for n in LOST},
    **{f"late {n}": Condition(senses=Senses(late=n)) for n in DELAYS},
    **{name: Condition(disturbance=name) for name in DISTURBANCES},
    **{name + EARLY: Condition(disturbance=name, strikes=SOON) for name in DISTURBANCES},
    **{f"inference every {n}": Condition(period=n) for n in PERIODS},
    **{f"inference {n} late": Condition(latency=n) for n in LATENCIES},
    **SHIFTS,
}
"""Name -> condition."""


def condition(name: str) -> Condition:
    """The condition of that name.

    Raises
    ------
    UnknownName
        Listing those that there are.
    """
    if name not in CONDITIONS:
        raise unknown_name("condition", name, CONDITIONS)
    return CONDITIONS[name]


def shifts_of(task: str) -> list[str]:
    """The shifts that change a task."""
    return [name for name, shift in SHIFTS.items() if shift.parameters or task in shift.options]


def metric_of(task: str) -> str:
    """What is compared: ``success``, ``cycles`` where a task's metric is the duration, ``goals`` in matches."""
    return "goals" if task in MATCHES else "cycles" if make_task(task).metric == "duration" else "success"


__all__ = ["CONDITIONS", "DEFAULT", "MATCHES", "SHIFTS", "Condition", "condition", "metric_of", "shifts_of"]
