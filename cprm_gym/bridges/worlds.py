"""The agents of many worlds at once, in a group for each side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces

from ..envs.core import SoccerCore, Step
from ..envs.options import EnvOptions
from ..envs.soccer_v2 import state_space, states
from ..envs.tasks import Task
from ..errors import CommandError, ParameterError, UnknownName


class AgentWorlds:
    """A task in W worlds with its agents in groups, ``left`` and ``right``, as arrays with the axes (worlds, agents of the group, ...).

    Parameters
    ----------
    worlds : int
    task : str or Task
    threads : int
        Threads that share the worlds.
    **options
        As for `EnvOptions`, and fields of the task.

    Attributes
    ----------
    core : SoccerCore
    groups : dict of str to tuple of str
        Agents of each group; a side without agents has none.
    observation_space, action_space : gymnasium.spaces.Space
        Of one agent; the same for all.
    state_space : gymnasium.spaces.Box

    Raises
    ------
    ParameterError, UnknownName
        For a number of worlds that is none, options that there are not, or nobody to act.
    """

    def __init__(self, worlds: int = 1, task: str | Task = "Soccer", *, threads: int = 1, **options: Any) -> None:
        if isinstance(worlds, bool) or not isinstance(worlds, (int, np.integer)) or worlds < 1:
            raise ParameterError(f"worlds: {worlds!r} given, a whole number of at least 1 is needed")
        self.options = EnvOptions.of({"task": task, **options})
        self.core = SoccerCore(self.options, int(worlds), threads=threads)
        self.worlds, self.task = int(worlds), self.core.task
        if not self.core.agents:
            raise UnknownName("controlled: nobody chosen; somebody has to act")
        sides = {side: tuple(a for a in self.core.agents if a.startswith(side)) for side in ("left", "right")}
        self.groups: dict[str, tuple[str, ...]] = {side: names for side, names in sides.items() if names}
        left = len(sides["left"])
        self._columns = {"left": slice(0, left), "right": slice(left, len(self.core.agents))}
        self.observation_space: spaces.Space[Any] = self.core.observation_space()
        self.action_space: spaces.Space[Any] = self.core.view.space
        self.state_space = state_space(self.core.mixes)
        self._seeded = False

    def reset(self, seed: int | None = None, worlds: np.ndarray | None = None) -> None:
        """Begin episodes, in all worlds or in those of a (W,) bool array; the first reset without a seed draws one."""
        if seed is None and not self._seeded:
            seed = int(np.random.default_rng().integers(2**31))
        self._seeded = True
        self.core.reset(seed, worlds)

    def step(self, actions: Mapping[str, Any]) -> Step:
        """Play one cycle.

        Parameters
        ----------
        actions : mapping of str to array, or to dict of array
            Of each group, (W, agents, ...).

        Raises
        ------
        CommandError
            When a group is missing, or its actions do not fit the view.
        """
        if set(actions) != set(self.groups):
            raise CommandError(f"actions: given for {', '.join(map(str, actions)) or 'nobody'}; needed for {', '.join(self.groups)}")
        given = [actions[group] for group in self.groups]
        if len(given) == 1:
            return self.core.step(given[0])
        if isinstance(given[0], Mapping):
            return self.core.step({key: np.concatenate([part[key] for part in given], axis=1) for key in given[0]})
        return self.core.step(np.concatenate(given, axis=1))

    def of(self, group: str, values: np.ndarray) -> np.ndarray:
        """The part of an array with the axes (worlds, agents, ...) that is the group's; a view."""
        return values[:, self._columns[group]]

    def observation(self, group: str) -> np.ndarray | dict[str, np.ndarray]:
        """What the agents of a group are told; views of arrays that the next step overwrites."""
        output = self.core.output
        if isinstance(output, np.ndarray):
            return self.of(group, output)
        return {name: self.of(group, values) for name, values in output.items()}

    def mask(self, group: str) -> np.ndarray | None:
        """(W, agents, macros) bool: what can be done now, for the macro view; otherwise None. A view, too."""
        return None if self.core.action_mask is None else self.of(group, self.core.action_mask)

    def state(self) -> np.ndarray:
        """(W, n) float32: the true state, for centralised critics (`SoccerParallelEnv.state`)."""
        return states(self.core)
