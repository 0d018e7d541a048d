"""The scripted players of the environments as a controller: the same kernels, from the observation instead of the simulator.

Everything that a scripted player decides from is in the observation with its part ``memory``; the one thing that he is told beside it,
for how long he may not catch again, follows from his own commands.
"""

from __future__ import annotations

import numpy as np

from cprm_gym.envs.actions import NECK_SCALE, NO_COMMAND, scaled
from cprm_gym.envs.controller import Action, Observation, no_action
from cprm_gym.envs.core import player_number
from cprm_gym.envs.observations import BodyFeature, SelfFeature
from cprm_gym.envs.players.kernels import team
from cprm_gym.envs.players.memory import MEMORY, embody
from cprm_gym.envs.players.scripted import FORMATION, STRENGTHS
from cprm_gym.envs.tasks import Task
from cprm_gym.simulator.state import PLAYERS, WORLD, CommandKind


class ScriptedController:
    """One scripted player of a strength.

    Parameters
    ----------
    task : Task
    agent : str
    strength : str
        ``weak``, ``medium`` or ``strong``.
    """

    needs = ("memory",)

    def __init__(self, task: Task, agent: str, strength: str = "strong") -> None:
        self.row = player_number(agent) - 1
        self.goalie = self.row % 11 + 1 == (task.left_goalie if self.row < 11 else task.right_goalie)
        self.counts = np.array([task.left, task.right])
        self.parameters = task.parameters
        self.catch_ban = task.parameters.catch_ban_cycle
        self.strength = np.array([STRENGTHS[strength]])

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes."""
        count = len(observation["level"])
        if worlds is None:
            self.worlds, self.records = np.zeros(count, WORLD), np.zeros((count, PLAYERS), MEMORY)
            embody(self.records, self.parameters)
            self.commands = np.repeat(NO_COMMAND, count * PLAYERS).reshape(count, PLAYERS)
            self.worlds["enabled"][:, self.row] = True
            self.worlds["goalie"][:, self.row] = self.goalie
        chosen = slice(None) if worlds is None else worlds
        self.worlds["catch_ban"][chosen] = 0
        for name in ("search", "taker", "kicker", "clock"):
            self.records[name][chosen] = 0

    def act(self, observation: Observation) -> Action:
        """One cycle of every world."""
        self._remember(observation)
        body = np.asarray(observation["body"])
        self.worlds["mode"] = body[:, BodyFeature.PLAY_MODE]
        fresh = np.repeat(body[:, BodyFeature.FRESH, None] > 0, PLAYERS, axis=1)
        rows = np.array([self.row])
        team.act(self.worlds, self.records, rows, self.strength, self.counts, FORMATION, fresh, self.commands)
        sent = self.commands[:, self.row]
        catching = sent["kind"] == CommandKind.CATCH
        ban = self.worlds["catch_ban"][:, self.row]
        self.worlds["catch_ban"][:, self.row] = np.where(catching & (ban == 0), max(self.catch_ban - 1, 0), np.maximum(ban - 1, 0))
        action = no_action(len(sent))
        action["type"] = sent["kind"].astype(np.int64)
        action["params"] = scaled(action["type"], *(np.nan_to_num(sent[name]) for name in "abcd"))
        action["turn_neck"][:, 0] = np.clip(np.nan_to_num(sent["turn_neck"]) / NECK_SCALE, -1.0, 1.0)
        action["view"] = sent["view_width"].astype(np.int64)
        return action

    def _remember(self, observation: Observation) -> None:
        """His memory as the kernels read it."""
        m = self.records[:, self.row]
        me, body = np.asarray(observation["self"], np.float64), np.asarray(observation["body"], np.float64)
        seen, age = np.asarray(observation["memory"], np.float64), np.asarray(observation["memory_age"])
        for name in ("x", "y", "vx", "vy", "body", "face", "located", "free"):
            m[name] = me[:, SelfFeature[name.upper()]]
        m["neck"] = body[:, BodyFeature.NECK]
        m["stamina"], m["effort"] = body[:, BodyFeature.STAMINA], body[:, BodyFeature.EFFORT]
        m["ball_x"], m["ball_y"], m["ball_vx"], m["ball_vy"] = seen[:, 0].T
        m["ball_age"] = age[:, 0]
        m["px"], m["py"], m["age"] = seen[:, 1:, 0], seen[:, 1:, 1], age[:, 1:]


def make_controller(task: Task, agent: str) -> ScriptedController:
    """The strong scripted player; plays every task."""
    return ScriptedController(task, agent)
