"""What the faces of the engine share: how they read their arguments, and pictures of their world."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ..errors import ParameterError, UnknownName
from .core import SoccerCore
from .tasks import make_task
from .tasks.base import Task

RENDER_MODES = ("human", "rgb_array", "ansi")
FPS = 10
"""Cycles of 100 ms."""


def chosen_task(task: str | Task, max_cycles: int | None, options: dict[str, Any]) -> Task:
    """The task that the arguments of a face mean.

    Parameters
    ----------
    task : str or Task
        Name of a task, or a task.
    max_cycles : int, optional
        Cycles per episode; the task's own if not given.
    options : dict
        Fields of the task that shall differ.

    Raises
    ------
    UnknownName
        For a task that does not exist; the message lists those that do.
    ParameterError
        For an option that the task does not have.
    """
    if max_cycles is not None:
        options = {**options, "max_cycles": max_cycles}
    if isinstance(task, str):
        return make_task(task, **options)
    if not isinstance(task, Task):
        raise UnknownName(f"task: expected a name or a Task, got {type(task).__name__} {task!r:.60}")
    try:
        return replace(task, **options)
    except TypeError as error:
        raise ParameterError(f"task {task.name!r}: {error}") from None


def chosen_render_mode(mode: str | None) -> str | None:
    """`mode`, if there is such a one.

    Raises
    ------
    UnknownName
        Listing the modes there are.
    """
    if mode is not None and mode not in RENDER_MODES:
        raise UnknownName(f"render_mode {mode!r}: allowed are {', '.join(RENDER_MODES)} or None")
    return mode


class Pictured:
    """A face of one world that draws it; the base of the Gymnasium and the PettingZoo environment."""

    core: SoccerCore
    render_mode: str | None
    _viewer: Any = None

    def render(self) -> Any:
        """The pitch: a window (``human``), an RGB array (``rgb_array``) or text (``ansi``); None without a render mode."""
        if self.render_mode is None:
            return None
        if self._viewer is None:
            from .rendering import Viewer

            self._viewer = Viewer(self.render_mode, fps=FPS, region=self.core.task.region)
        return self._viewer.draw(self.core.sim.world[0])

    def _show(self) -> None:
        """Bring the window up to date, if there is one."""
        if self.render_mode == "human":
            self.render()

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._viewer is not None:
            self._viewer.close()
            self._viewer = None
