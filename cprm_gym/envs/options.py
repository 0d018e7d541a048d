"""The options of an environment, stated once for every face, the benchmark's makers and the wrappers'."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from ..errors import ParameterError, UnknownName, unknown_name
from .actions import VIEWS
from .observations import INCLUDES
from .others.registry import OtherPlayer
from .players.senses import Senses
from .presets import check_preset
from .rewards import RewardOption
from .tasks import make_task, with_options
from .tasks.base import Task

SYNONYMS = {"agent": "controlled", "max_episode_steps": "max_cycles"}
"""Other names of options: what Gymnasium calls so."""
RENDER_MODES = ("human", "rgb_array", "ansi")


@dataclass(frozen=True, kw_only=True)
class EnvOptions:
    """How an environment of ours is made; every face takes these as arguments, and fields of the task beside them.

    Attributes
    ----------
    task : str or Task
        Name of a task, or a task.
    controlled : str or sequence of str, optional
        Who acts: ``all``, ``left``, ``right``, agent names, or several of them; the task's own if not given. The faces of one agent
        take its first one; there ``agent`` is the same argument.
    action_mode : str
        ``discrete`` (default), ``box``, ``hybrid`` (the command itself), ``full`` (hybrid with say, attention and point) or ``macro``.
    observation : str
        Preset: ``normalised`` (default, `cprm_gym.envs.vectors.normalised`), ``raw``, ``memory``, ``full``, ``hfo_low``, ``hfo_high`` or
        ``keepaway`` (`cprm_gym.envs.presets`).
    include : str or sequence of str
        Further parts of the observation: ``memory`` (a picture of the pitch kept from the agent's own percepts), ``landmarks``, ``lines``,
        ``hear``, ``normalised`` (the vector of that preset, beside the percepts of ``raw``), ``action_mask`` (of the macro view, beside
        the info, for learners that look for it there).
    flatten : bool
        One vector instead of a dict.
    others : str, ControllerFactory or a pair of them, optional
        Who plays the other players, or one for each side: a scripted policy, a controller by its name (`cprm_gym.envs.others.registry`) or
        what makes controllers; the task's own if not given.
    reward : None, str, sequence or mapping of str, or function
        The task's own (``sparse``: without its shaping terms), with named shaping terms added, or a function instead of it
        (`cprm_gym.envs.rewards`).
    reward_gamma : float
        Discount of the shaping terms.
    max_cycles : int, optional
        Cycles per episode; the task's own if not given. ``max_episode_steps`` is the same; where both are given, `max_cycles` counts.
    debug_info : bool
        Put the true positions into ``info["truth"]``.
    senses : Senses or mapping of its fields
        What the controlled agents perceive, and when (`cprm_gym.envs.players.senses`); as the server has it by default.
    backend : str
        Where it is played: in process (empty), or on a server, ``udp://host:port`` (`cprm_gym.client.remote` says what differs there).
    task_options : mapping
        Fields of the task that shall differ.

    Raises
    ------
    UnknownName
        For an action mode, preset or part that does not exist; the message lists those that do.
    ParameterError
        For options that do not go together, and senses out of their range.
    """

    task: str | Task = "GoToBall"
    controlled: str | Sequence[str] | None = None
    action_mode: str = "discrete"
    observation: str = "normalised"
    include: str | Sequence[str] = ()
    flatten: bool = False
    others: OtherPlayer | Sequence[OtherPlayer] | None = None
    reward: RewardOption = None
    reward_gamma: float = 0.99
    max_cycles: int | None = None
    debug_info: bool = False
    senses: Senses | Mapping[str, Any] = field(default_factory=Senses)
    backend: str = ""
    task_options: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse what does not exist; ``include`` becomes a tuple."""
        if self.action_mode not in VIEWS:
            raise unknown_name("action view", str(self.action_mode), VIEWS)
        check_preset(self.observation)
        include = (self.include,) if isinstance(self.include, str) else several("include", self.include)
        for part in include:
            if part not in INCLUDES:
                raise unknown_name("part of an observation", str(part), INCLUDES)
        if "action_mask" in include and self.action_mode != "macro":
            raise ParameterError(f"include: 'action_mask' goes with action_mode='macro', which has masks; not with {self.action_mode!r}")
        if self.observation == "memory" and "memory" not in include:
            include = ("memory", *include)
        object.__setattr__(self, "include", include)
        senses = Senses.of(self.senses)
        object.__setattr__(self, "senses", senses)
        if senses != Senses() and self.observation == "full":
            raise ParameterError("senses: the preset 'full' tells the truth, whatever they are; take another observation")
        at_once = self.observation not in ("raw", "memory") or "normalised" in include
        if any(senses.delays) and (self.action_mode == "macro" or at_once):
            raise ParameterError("senses: late news go with the observations 'raw' and 'memory' and without macros, which look at once")

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> EnvOptions:
        """The options that the arguments of a face mean; what is none of them is a field of the task.

        Raises
        ------
        UnknownName, ParameterError
            As for the options, and for a field that the task does not have.
        """
        own = {f.name for f in fields(cls)}
        chosen: dict[str, Any] = {}
        of_task = dict(given.get("task_options") or {})
        for name, value in given.items():
            meant = SYNONYMS.get(name, name)
            if meant != name and given.get(meant) is not None:
                continue
            if meant in own:
                chosen[meant] = value
            else:
                of_task[name] = value
        return cls(**{**chosen, "task_options": of_task})

    def played(self) -> Task:
        """The task.

        Raises
        ------
        UnknownName
            For a task that does not exist; the message lists those that do.
        ParameterError
            For an option that the task does not have, or an episode of no cycles.
        """
        options = dict(self.task_options)
        if self.max_cycles is not None:
            options["max_cycles"] = self.max_cycles
        if isinstance(self.task, str):
            task = make_task(self.task, **options)
        elif isinstance(self.task, Task):
            task = with_options(self.task, **options)
        else:
            raise UnknownName(f"task: expected a name or a Task, got {type(self.task).__name__} {self.task!r:.60}")
        if isinstance(task.max_cycles, bool) or not isinstance(task.max_cycles, (int, np.integer)) or task.max_cycles < 1:
            raise ParameterError(f"max_cycles: {task.max_cycles!r} given, a whole number of at least 1 is needed")
        return task


def several(name: str, given: Any) -> tuple[Any, ...]:
    """The members of a sequence; an error that names the argument for what is none."""
    if not isinstance(given, Iterable):
        raise UnknownName(f"{name}: expected a string or a sequence of strings, got {type(given).__name__} {given!r:.60}")
    return tuple(given)


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
