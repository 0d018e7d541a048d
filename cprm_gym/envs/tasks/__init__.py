"""The tasks: one file each."""

from __future__ import annotations

from ...errors import unknown_name
from .base import Outcome, Task
from .go_to_ball import GoToBall
from .match import Soccer

TASKS: dict[str, type[Task]] = {"GoToBall": GoToBall, "Soccer": Soccer}
"""Task classes by name; ``cprm/<name>-v0`` is the environment id."""


def make_task(name: str, **options: object) -> Task:
    """The task of that name with the given options.

    Raises
    ------
    UnknownName
        Listing the tasks there are.
    """
    if name not in TASKS:
        raise unknown_name("task", name, TASKS)
    return TASKS[name](**options)  # type: ignore[arg-type]


__all__ = ["TASKS", "GoToBall", "Outcome", "Soccer", "Task", "make_task"]
