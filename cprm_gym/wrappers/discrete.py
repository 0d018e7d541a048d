"""One number instead of a hybrid action."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from ..envs.actions import PARAMETER_SCALES, scaled
from ..errors import CommandError, ParameterError, unknown_name
from ..simulator.state import CommandKind

Choice = tuple[str, float, float]
"""Command, and its two parameters in the server's units: ``("dash", 100, 0)``, ``("turn", 45, 0)``, ``("kick", 60, -30)``."""

CHOICES: tuple[Choice, ...] = (
    ("none", 0, 0),
    ("dash", 50, 0), ("dash", 100, 0), ("dash", 100, 180),
    *(("turn", float(d), 0.0) for d in (-120, -60, -30, -10, 10, 30, 60, 120)),
    *(("kick", p, float(d)) for p in (25.0, 100.0) for d in (-90, -45, -15, 0, 15, 45, 90)),
)  # fmt: skip
"""Default choices: 26 commands."""


class DiscreteActions(gymnasium.ActionWrapper[Any, Any, Any]):
    """A hybrid environment whose actions are the numbers of a fixed list of commands, for DQN and tables.

    Parameters
    ----------
    env : gymnasium.Env
        With ``action_mode="hybrid"``.
    choices : sequence of (str, float, float)
        The commands.

    Raises
    ------
    ParameterError
        For another action mode, or parameters out of range.
    UnknownName
        For a command that does not exist.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], choices: Sequence[Choice] = CHOICES) -> None:
        super().__init__(env)
        if not isinstance(env.action_space, spaces.Dict) or "type" not in env.action_space.spaces:
            raise ParameterError(f"DiscreteActions: needs an environment with action_mode='hybrid'; this one has {env.action_space}")
        self.choices = tuple(choices)
        if not self.choices:
            raise ParameterError("DiscreteActions: choices is empty; at least one command is needed")
        self._actions = []
        names = [k.name.lower() for k in CommandKind]
        for choice in self.choices:
            if len(choice) != 3:
                raise ParameterError(f"choice {choice!r}: a command and two numbers are needed, such as ('kick', 60, -30)")
            name, a, b = choice
            if name not in names:
                raise unknown_name("command", name, names)
            kind = CommandKind[name.upper()]
            if not (abs(a) <= PARAMETER_SCALES[kind, 0] and abs(b) <= PARAMETER_SCALES[kind, 1]):
                raise ParameterError(f"choice {(name, a, b)}: allowed are up to {PARAMETER_SCALES[kind, :2].tolist()}")
            self._actions.append({
                "type": np.int64(kind), "params": scaled(int(kind), a, b).astype(np.float32),
                "turn_neck": np.zeros(1, np.float32), "view": np.int64(0),
            })  # fmt: skip
        self.action_space: spaces.Space[Any] = spaces.Discrete(len(self._actions))

    def action(self, action: int) -> dict[str, Any]:
        """The hybrid action of a number."""
        number = np.asarray(action)
        if number.size != 1 or number.dtype.kind not in "iu" or not 0 <= number.item() < len(self._actions):
            raise CommandError(f"action: {action!r:.60} given; allowed are 0 to {len(self._actions) - 1}")
        return dict(self._actions[number.item()])
