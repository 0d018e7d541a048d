"""What a player remembers, from his observation: for controllers that decide with the kernels of scripted players and macros."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..agents.keeper.recall import recall
from ..envs.actions import NECK_SCALE, NO_COMMAND, scaled
from ..envs.controller import Action
from ..envs.observations import BodyFeature
from ..envs.players.kernels import macros as kernels
from ..envs.players.macros import macro_names
from ..envs.players.memory import MEMORY, embody
from ..envs.players.scripted import FORMATION
from ..envs.tasks.base import Task
from ..errors import CommandError
from ..simulator.state import PLAYERS, WORLD, CommandKind


def told(sent: np.ndarray) -> Action:
    """Hybrid actions that mean the commands, (N,) of COMMAND."""
    kind = sent["kind"].astype(np.int64)
    return {
        "type": kind,
        "params": scaled(kind, *(np.nan_to_num(sent[name]) for name in "abcd")),
        "turn_neck": np.clip(np.nan_to_num(sent["turn_neck"]) / NECK_SCALE, -1.0, 1.0)[:, None],
        "view": sent["view_width"].astype(np.int64),
    }


class MacroPlayer:
    """The macros of one agent in N worlds, carried out from his observations (with the part ``memory``) instead of the simulator.

    Parameters
    ----------
    task : Task
    player : int
        Object number of the agent.
    worlds : int

    Attributes
    ----------
    names : tuple of str
        By index; those that `cprm_gym.envs.players.macros.Macros` has for agents of his side.
    """

    def __init__(self, task: Task, player: int, worlds: int) -> None:
        self.row, self._task = player - 1, task
        own, other = (task.left, task.right) if player <= 11 else (task.right, task.left)
        self.names = macro_names(own - 1, other)
        self._players, self._mates, self._opponents = np.array([player]), np.array([own - 1]), np.array([other])
        self._region = float(task.region[0]), float(task.region[1])
        self._ban = max(task.parameters.catch_ban_cycle - 1, 0)
        self._worlds: np.ndarray = np.zeros(worlds, WORLD)
        self._worlds["enabled"][:, self.row] = True
        self._worlds["goalie"][:, self.row] = self.row % 11 + 1 == (task.left_goalie if player <= 11 else task.right_goalie)
        self._records: np.ndarray = np.zeros((worlds, PLAYERS), MEMORY)
        embody(self._records, task.parameters)
        self._commands = np.repeat(NO_COMMAND, worlds * PLAYERS).reshape(worlds, PLAYERS)
        self._fresh: np.ndarray = np.zeros((worlds, PLAYERS), bool)
        self.mask: np.ndarray = np.zeros((worlds, 1, len(self.names)), bool)

    def reset(self, worlds: np.ndarray | slice) -> None:
        """Episodes begin in some worlds."""
        self._worlds["catch_ban"][worlds] = 0
        for name in ("search", "taker", "kicker", "clock"):
            self._records[name][worlds] = 0

    def observe(self, observation: Mapping[str, np.ndarray]) -> np.ndarray:
        """Take in the observations of a cycle; (N, macros) bool, what can be done now."""
        recall(self._records[:, self.row], observation)
        body = np.asarray(observation["body"])
        self._worlds["mode"] = body[:, BodyFeature.PLAY_MODE]
        self._fresh[:, self.row] = body[:, BodyFeature.FRESH] > 0
        every = np.arange(len(self._worlds))
        kernels.masks(self._worlds, every, self._records, self._players, self._mates, self._opponents, self.mask)
        self._task.restrict(self.names, self.mask)
        return self.mask[:, 0]

    def state(self) -> dict[str, np.ndarray]:
        """The live arrays that decide what he does next."""
        return {"worlds": self._worlds, "records": self._records, "commands": self._commands}

    def act(self, macros: np.ndarray) -> Action:
        """The hybrid actions of one cycle of macros, (N,) int.

        Raises
        ------
        CommandError
            For what is no macro.
        """
        chosen = np.asarray(macros, np.int64)
        if chosen.shape != self._worlds.shape or (chosen.size and not 0 <= chosen.min() <= chosen.max() < len(self.names)):
            raise CommandError(f"macros: expected {len(self._worlds)} numbers from 0 to {len(self.names) - 1}, got {macros!r:.60}")
        meant = self._task.decide(self.names, self.mask, chosen[:, None])
        kernels.act(self._worlds, self._records, self._players, meant, self._mates, FORMATION, *self._region, self._fresh,
                    self._commands)  # fmt: skip
        sent = self._commands[:, self.row]
        catching = sent["kind"] == CommandKind.CATCH
        ban = self._worlds["catch_ban"][:, self.row]
        self._worlds["catch_ban"][:, self.row] = np.where(catching & (ban == 0), self._ban, np.maximum(ban - 1, 0))
        return told(sent)
