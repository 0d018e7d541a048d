"""The tasks: one file each, and their names."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from ...errors import ParameterError, did_you_mean, unknown_name
from .base import Outcome, Status, Task
from .go_to_ball import GoToBall
from .goalie import Goalie, GoalieAgainstAttack, against_attack
from .half_field import LADDER, HalfField, front_goal, hfo
from .hike import Hike
from .keepaway import Keepaway, keepaway
from .kick_off_shot import KickOffShot
from .lost_and_found import LostAndFound
from .match import Soccer
from .pass_and_advance import PassAndAdvance

TASKS: dict[str, Callable[[], Task]] = {
    "GoToBall": GoToBall,
    "LostAndFound": LostAndFound,
    "Hike": Hike,
    "KickOffShot": KickOffShot,
    "KickOffShot2v2": partial(KickOffShot, name="KickOffShot2v2", right=2, right_goalie=1),
    "Goalie": Goalie,
    **{f"Goalie{a}v{d}": partial(against_attack, a, d) for a, d in ((2, 1), (3, 2))},
    "PassAndAdvance": PassAndAdvance,
    **{f"PassAndAdvance2v{d}": partial(PassAndAdvance, name=f"PassAndAdvance2v{d}", right=d) for d in (1, 2, 3)},
    **{f"Keepaway{k}v{t}": partial(keepaway, k, t, size) for k, t, size in ((3, 2, 20.0), (4, 3, 25.0), (5, 4, 30.0))},
    **{f"HFO{a}v{d}": partial(hfo, a, d) for a, d in ((1, 0), (1, 1), (2, 1), (2, 2), (3, 2), (3, 3), (4, 5))},
    **{name: partial(front_goal, name) for name in LADDER},
    "Soccer": Soccer,
    "Soccer5v5": partial(Soccer, name="Soccer5v5", left=5, right=5),
    "Soccer11v11": partial(Soccer, name="Soccer11v11"),
}
"""What makes the task of a name with its defaults; ``cprm/<name>-v2`` is the environment id."""


def make_task(name: str, **options: object) -> Task:
    """The task of that name with the given options.

    Parameters
    ----------
    name : str
    **options
        Fields of the task's class.

    Raises
    ------
    UnknownName
        Listing the tasks there are.
    ParameterError
        For an option that the task does not have; the message lists those that it has.
    """
    if name not in TASKS:
        raise unknown_name("task", name, TASKS)
    return with_options(TASKS[name](), **options)


def with_options(task: Task, **options: object) -> Task:
    """The task with other values of some of its fields.

    Raises
    ------
    ParameterError
        For an option that the task does not have; the message lists those that it has.
    """
    known = [f for f in task.__dataclass_fields__ if f not in ("name", "statuses", "terms", "shaping", "metric", "task_features")]
    for option in options:
        if option not in known:
            raise ParameterError(f"task {task.name!r} has no option {option!r}.{did_you_mean(option, known)} Options: {', '.join(known)}.")
    return replace(task, **options)  # type: ignore[arg-type]


__all__ = [
    "TASKS", "GoToBall", "Goalie", "GoalieAgainstAttack", "HalfField", "Hike", "Keepaway", "KickOffShot", "LostAndFound", "Outcome",
    "PassAndAdvance", "Soccer", "Status", "Task", "make_task", "with_options",
]  # fmt: skip
