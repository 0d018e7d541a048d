"""A learned policy as a controller like any other: in `benchmark`, `play`, `join`, in the studio, as an opponent."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..envs.actions import (
    BOX_KINDS,
    DISCRETE_DIRECTIONS,
    DISCRETE_KINDS,
    DISCRETE_NECKS,
    DISCRETE_POWERS,
    NECK_SCALE,
    scaled,
)
from ..envs.controller import Action, Observation
from ..envs.core import player_number
from ..envs.others.luck import WorldLuck
from ..envs.tasks.base import Task
from ..envs.vectors.normalised import Columns
from ..errors import CprmError, ParameterError, UnknownName, unknown_name
from ..simulator.state import CommandKind
from .policy import SHIPPED, Description, Policy, load_policy, shipped
from .remembered import MacroPlayer

_KINDS, _POWERS = np.array([int(k) for k in DISCRETE_KINDS]), np.array(DISCRETE_POWERS)
_DIRECTIONS, _NECKS = np.array(DISCRETE_DIRECTIONS), np.array(DISCRETE_NECKS)
_BOX = np.array([int(k) for k in BOX_KINDS])
LASTS = 5
"""Cycles for which an option goes on until another one may be chosen, as in learning."""


class PolicyController:
    """Plays with a policy.

    Parameters
    ----------
    policy : Policy
    task : Task
    agent : str
    drawn : bool
        Draw the actions, from a stream of each world; otherwise the likeliest ones are taken.
    lasts : int
        Cycles between two choices of an option.

    Raises
    ------
    ParameterError
        When the policy takes in what this agent of this task does not observe, or chooses what he has not.
    """

    def __init__(self, policy: Policy, task: Task, agent: str, drawn: bool = False, lasts: int = LASTS) -> None:
        from .beliefs import COLUMNS, BallBelief
        from .options import option_names

        described = policy.description
        self.policy, self.task, self.agent, self.drawn, self.lasts = policy, task, agent, drawn, lasts
        self.player = player_number(agent)
        needs = ["normalised"]
        further = COLUMNS if described.belief else ()
        _check_columns(described, (*columns_of(task, agent), *further), agent)
        # where both sides are told vectors and one is larger, there are rows of nobody
        most = max(task.left, task.right)
        layouts = (columns_of(task, agent), Columns(most - 1, most, task.task_features).names)
        self._orders = {len(own): np.array([(*own, *further).index(n) for n in described.columns]) for own in reversed(layouts)}
        self._belief_of = BallBelief if described.belief else None
        if described.belief or described.mode in ("macro", "option"):
            needs.append("memory")
        if described.mode == "option" and described.names != option_names(task, agent):
            raise ParameterError(
                f"policy of {described.task}: chooses among {', '.join(described.names)}; {agent} of {task.name} has the options "
                f"{', '.join(option_names(task, agent))}"
            )
        if described.mode == "macro" and described.names != MacroPlayer(task, self.player, 1).names:
            raise ParameterError(f"policy of {described.task}: its macros are not those of {agent} of {task.name}")
        self.needs = tuple(needs)
        self._luck = WorldLuck(policy.parts)

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes."""
        count = len(observation["level"])
        if worlds is None:
            self._luck.begin(np.full(count, seed), np.arange(count))
        self._begin(observation, worlds)

    def begin(self, observation: Observation, seeds: np.ndarray, worlds: np.ndarray | None = None) -> None:
        """Begin episodes, each with its world's luck."""
        self._luck.begin(seeds, self.player, worlds)
        self._begin(observation, worlds)

    def _begin(self, observation: Observation, worlds: np.ndarray | None) -> None:
        from .options import OptionPlayer

        count = len(observation["level"])
        chosen = np.ones(count, bool) if worlds is None else np.asarray(worlds, bool)
        mode = self.policy.description.mode
        if worlds is None:
            self._hidden = np.zeros((count, 2, self.policy.network.hidden), np.float32)
            self._cycle = np.zeros(count, np.int64)
            self._choice = np.zeros(count, np.int64)
            self._belief = None if self._belief_of is None else self._belief_of(self.task, count)
            self._macros = MacroPlayer(self.task, self.player, count) if mode == "macro" else None
            self._options = OptionPlayer(self.task, self.agent, count) if mode == "option" else None
        self._hidden[chosen] = 0.0
        self._cycle[chosen] = 0
        if self._belief is not None:
            self._belief.reset(chosen)
        if self._macros is not None:
            self._macros.reset(chosen)
        if self._options is not None:
            self._options.begin(observation, 0, None if worlds is None else chosen)

    def act(self, observation: Observation) -> Action:
        """One action for each world."""
        x = np.asarray(observation["normalised"], np.float32)
        order = self._orders[x.shape[1]]
        if self._belief is not None:
            x = np.concatenate([x, self._belief.update(observation)], axis=1)
        x = x[:, order]
        mask = None if self._macros is None else self._macros.observe(observation)
        if self._options is not None:
            due = self._cycle % self.lasts == 0
            if due.any():
                self._choice[due] = self._choose(x, None)[due]
            self._cycle += 1
            return self._options.act(observation, self._choice)
        action = self._choose(x, mask)
        if self._macros is not None:
            return self._macros.act(action)
        return low_level(self.policy.description.mode, action)

    def _choose(self, x: np.ndarray, mask: np.ndarray | None) -> np.ndarray:
        uniform = self._luck.draw() if self.drawn else None
        recurrent = self.policy.network.hidden > 0
        action, state = self.policy.act(x, mask, uniform, self._hidden.swapaxes(0, 1) if recurrent else None)
        if recurrent and state is not None:
            self._hidden[...] = state.swapaxes(0, 1)
        return action

    def state(self) -> dict[str, np.ndarray]:
        """What decides his next commands, beside what he is told.

        Raises
        ------
        CprmError
            For a policy with a belief or over options, whose models and nets are not told.
        """
        if self._belief_of is not None or self._options is not None:
            raise CprmError(f"policy of {self.policy.description.task}: what its belief or its options go on from cannot be saved")
        macros = {} if self._macros is None else self._macros.state()
        return {**self._luck.state(), "hidden": self._hidden, **macros}


def low_level(mode: str, action: np.ndarray) -> Action:
    """Hybrid actions that mean the actions of the view ``discrete``, (N, 4) int, or ``box``, (N, 6) float."""
    if mode == "discrete":
        kind, power = _KINDS[action[:, 0]], _POWERS[action[:, 1]]
        direction, neck = _DIRECTIONS[action[:, 2]], _NECKS[action[:, 3]]
    else:
        kind, power = _BOX[action[:, :3].argmax(axis=1)], 50.0 * (action[:, 3] + 1.0)
        direction, neck = 180.0 * action[:, 4], 90.0 * action[:, 5]
    powered = (kind == CommandKind.DASH) | (kind == CommandKind.KICK)
    params = scaled(kind, np.where(powered, power, direction), np.where(kind == CommandKind.KICK, direction, 0.0))
    return {"type": kind, "params": params, "turn_neck": neck[:, None] / NECK_SCALE, "view": np.zeros(len(kind), np.int64)}


def columns_of(task: Task, agent: str) -> tuple[str, ...]:
    """Columns of the vector ``normalised`` that the agent observes."""
    own, other = (task.left, task.right) if player_number(agent) <= 11 else (task.right, task.left)
    return Columns(own - 1, other, task.task_features).names


def _check_columns(described: Description, names: tuple[str, ...], agent: str) -> None:
    missing = [name for name in described.columns if name not in names]
    if missing or len(described.columns) != len(names):
        what = f"it takes in {missing[0]!r}, which" if missing else f"it takes in {len(described.columns)} of the {len(names)} columns that"
        raise ParameterError(f"policy of {described.task}: {what} {agent} {'does not observe' if missing else 'observes'} in this task")


def make_controller(task: Task, agent: str, name: str = "", drawn: bool = False) -> PolicyController:
    """The controller ``policy``.

    Parameters
    ----------
    task : Task
    agent : str
    name : str
        Of a policy that comes with the project, or a path to one (``policy:name=my/folder/best``); by default the first of the project's
        policies for the task.
    drawn : bool
        Draw the actions instead of taking the likeliest.

    Raises
    ------
    UnknownName
        When no such policy is there; the message lists those that are.
    FormatError, ParameterError
        For a damaged one, and one that does not fit the task.
    """
    if not isinstance(drawn, bool):
        raise ParameterError(f"controller 'policy': drawn: {drawn!r} given; allowed are true and false")
    there = shipped()
    if not name:
        fitting = [one for one in there if one.split("-")[0] == task.name]
        if not fitting:
            raise UnknownName(
                f"controller 'policy': none of the project's policies is for {task.name}; there are {', '.join(there) or 'none'}"
            )
        name = "-".join([task.name, "ppo"]) if f"{task.name}-ppo" in fitting else fitting[0]
    if name in there:
        return PolicyController(load_policy(SHIPPED / name), task, agent, drawn)
    if not Path(name).with_suffix(".json").exists() and Path(name).suffix != ".zip":
        raise unknown_name("policy", str(name), there)
    return PolicyController(load_policy(name), task, agent, drawn)
