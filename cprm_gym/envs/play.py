"""Playing a task in process: a rehearsal, its worlds cycle by cycle, and films or game logs of them."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from importlib import import_module
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from ..errors import CprmError, ParameterError, UnknownName
from ..files import check_place, hidden_beside
from ..simulator.gamelog.writer import GameLogWriter
from .controller import ControllerFactory, Observation, check_action
from .core import SoccerCore, select_agents
from .rendering import Viewer
from .tasks.base import Status, Task

ENDINGS = (".mp4", ".gif", ".rcg", ".rcg.gz")
"""Files that `Film` writes."""
REHEARSED = 3
"""Cycles of a rehearsal."""


def rehearse(task: Task, factory: ControllerFactory, agent: str) -> None:
    """Make a controller and let it decide, so that kernels and models are there before a server is joined.

    Parameters
    ----------
    task : Task
    factory : ControllerFactory
    agent : str
        Whose controller it is: ``left_1``.
    """
    controller = factory(task, agent)
    core = SoccerCore(task, 1, controlled=agent, others="hold", include=tuple(getattr(controller, "needs", ())))
    controller.reset(_own(core.reset(0)), 0)
    for _ in range(REHEARSED):
        action = check_action(type(controller).__name__, controller.act(_own(core.observation)), 1)
        core.step({key: np.asarray(value)[:, None] for key, value in action.items()})


def _own(observation: Observation) -> dict[str, np.ndarray]:
    """The observation of the one agent."""
    return {key: value[:, 0] for key, value in observation.items()}


def play(
    task: Task, controller: ControllerFactory | None = None, others: str | Sequence[str] | None = None, seed: int = 0,
    cycles: int | None = None,
) -> Iterator[tuple[SoccerCore, Status]]:  # fmt: skip
    """One episode: the engine after the start and after every cycle, and the status.

    Parameters
    ----------
    task : Task
    controller : ControllerFactory, optional
        Plays the task's controlled agents; without one they are scripted as well.
    others : str or (str, str), optional
        Scripted policies; the task's own if not given, where a side that would only stand still plays as the medium team.
    seed : int
    cycles : int, optional
        Stop after so many.

    Raises
    ------
    ParameterError
        For less than one cycle.
    """
    if cycles is not None and cycles < 1:
        raise ParameterError(f"cycles: {cycles!r} given; allowed is 1 and more")
    if controller is None:
        sides = task.others if others is None else others
        pair = (sides, sides) if isinstance(sides, str) else tuple(sides)
        if others is None:
            pair = tuple("medium" if side == "hold" else side for side in pair)
        core = SoccerCore(task, 1, controlled=(), others=pair)
        agents = []
    else:
        agents = [controller(task, agent) for agent in select_agents(task.controlled, task.left, task.right)]
        needs = tuple(dict.fromkeys(part for agent in agents for part in getattr(agent, "needs", ())))
        core = SoccerCore(task, 1, others=others, include=needs)
    core.reset(seed)
    for i, agent in enumerate(agents):
        agent.reset({key: values[:, i] for key, values in core.observation.items()}, seed + i)
    yield core, Status.IN_GAME
    for _ in range(task.max_cycles if cycles is None else min(cycles, task.max_cycles)):
        action = None
        if agents:
            seen = [{key: values[:, i] for key, values in core.observation.items()} for i in range(len(agents))]
            chosen = [check_action(type(agent).__name__, agent.act(o), 1) for agent, o in zip(agents, seen)]
            action = {key: np.stack([c[key] for c in chosen], axis=1) for key in chosen[0]}
        step = core.step(action)
        yield core, Status(int(step.status[0]))
        if step.terminated[0] or step.truncated[0]:
            return


class Film:
    """A film (``.mp4``, ``.gif``) or game log (``.rcg``, ``.rcg.gz``) of one world; the file appears when the ``with`` block ends.

    Parameters
    ----------
    path : path
    core : SoccerCore
        Whose world 0 is shown.
    fps : int
        Pictures per second; 10 is the speed of the game.

    Raises
    ------
    UnknownName
        For another kind of file.
    CprmError
        When what writes films is not installed, or the place cannot be written to.
    """

    def __init__(self, path: str | Path, core: SoccerCore, fps: int = 10) -> None:
        self.path, self.core = Path(path), core
        ending = next((e for e in reversed(ENDINGS) if self.path.name.endswith(e)), None)
        if ending is None:
            raise UnknownName(f"record {self.path}: allowed are files that end in {', '.join(ENDINGS)}")
        check_place(self.path, "record")
        self._log: GameLogWriter | None = None
        self._film: Any = None
        if ending.startswith(".rcg"):
            self._log = GameLogWriter.for_simulator(self.path, core.sim, teams=core.sim.team_names)
            return
        try:
            imageio = import_module("imageio.v2")
        except ImportError:
            raise CprmError("films need imageio: pip install 'cprm-gym[render]'") from None
        self.viewer = Viewer("rgb_array", region=core.task.region, goal_width=core.parameters.goal_width)
        self._temporary = hidden_beside(self.path, ending)
        options: dict[str, Any] = {"fps": fps, "macro_block_size": 2} if ending == ".mp4" else {"duration": 1000 / fps, "loop": 0}
        self._film = imageio.get_writer(self._temporary, **options)

    def add(self) -> None:
        """The world as it is now."""
        if self._log is not None:
            self._log.record(self.core.sim)
            return
        picture = self.viewer.draw(self.core.sim.world[0], tuple(self.core.players.tolist())[:3])
        self._film.append_data(np.asarray(picture))

    def __enter__(self) -> Film:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self._log is not None:
            self._log.__exit__(kind, error, trace)
            return
        try:
            self._film.close()
            if kind is None:
                os.replace(self._temporary, self.path)
        finally:  # the end of a long film can be interrupted, too
            self._temporary.unlink(missing_ok=True)
