"""What a run is made of, as a value: the same setup gives the same run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ...architecture.petri import PetriNet
from ...architecture.prm import Model
from ...envs.controller import Controller
from ...envs.others.registry import load_controller
from ...envs.tasks import TASKS, Task, make_task
from ...errors import ParameterError, unknown_name
from ...wrappers.disturbances import DISTURBANCES

WITH_MODEL = "cprm:model=bins"
"""Who plays if nobody is named: an agent with a model of his own has more to be looked at than one on a tier of knowledge."""


@dataclass(frozen=True)
class Setup:
    """What is played.

    Parameters
    ----------
    task : str
    controller : str
        As of the entry points; empty: everybody is scripted.
    seed : int
        Of the world and of the players.
    world : int
        Which of the worlds of the seed, as episodes of a benchmark are numbered.
    disturbance : str, optional
        Of `DISTURBANCES`.
    options : mapping
        Fields of the task that differ from its own.
    nets : mapping of str to PetriNet
        Name of a net of a player -> the net with which it plays instead.
    models : mapping of str to Model
        Likewise of its model.

    Raises
    ------
    UnknownName, ParameterError, ControllerError
    """

    task: str
    controller: str = WITH_MODEL
    seed: int = 0
    world: int = 0
    disturbance: str | None = None
    options: Mapping[str, Any] = field(default_factory=dict)
    nets: Mapping[str, PetriNet] = field(default_factory=dict)
    models: Mapping[str, Model] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse what there is not."""
        if self.task not in TASKS:
            raise unknown_name("task", self.task, TASKS)
        if self.controller:
            load_controller(self.controller)
        if self.disturbance is not None and self.disturbance not in DISTURBANCES:
            raise unknown_name("disturbance", self.disturbance, DISTURBANCES)
        for name in ("seed", "world"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**63:
                raise ParameterError(f"{name}: a whole number from 0 is needed, got {value!r}")

    def made(self) -> Task:
        """The task."""
        return make_task(self.task, **self.options)

    def player(self, task: Task, agent: str) -> Controller:
        """Who plays an agent of the task."""
        return load_controller(self.controller)(task, agent)

    def said(self) -> dict[str, Any]:
        """What a page shows of it."""
        return {"task": self.task, "controller": self.controller, "seed": self.seed, "world": self.world, "disturbance": self.disturbance,
                "changed": sorted(self.nets), "models": sorted(self.models)}  # fmt: skip
