"""The scripted players of the environments as a controller: the same kernels, from the observation instead of the simulator.

Everything that a scripted player decides from is in the observation with its part ``memory``; the one thing that he is told beside it,
for how long he may not catch again, follows from his own commands.
"""

from __future__ import annotations

import numpy as np

from cprm_gym.agents.keeper.recall import recall
from cprm_gym.envs.actions import NECK_SCALE, NO_COMMAND, scaled
from cprm_gym.envs.controller import Action, Observation, no_action
from cprm_gym.envs.core import player_number
from cprm_gym.envs.observations import BodyFeature
from cprm_gym.envs.others.luck import WorldLuck
from cprm_gym.envs.players.kernels import team
from cprm_gym.envs.players.memory import MEMORY, embody
from cprm_gym.envs.players.scripted import FORMATION, STRENGTHS
from cprm_gym.envs.tasks import Task
from cprm_gym.errors import ParameterError, unknown_name
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
        if strength not in STRENGTHS:
            raise unknown_name("strength", str(strength), STRENGTHS)
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
        recall(self.records[:, self.row], observation)
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

    def state(self) -> dict[str, np.ndarray]:
        """What decides his next commands, beside what he is told."""
        return {"worlds": self.worlds, "records": self.records, "commands": self.commands}


class Eased:
    """A scripted player who misses some of his cycles: opponents of every grade between the strengths.

    Parameters
    ----------
    task : Task
    agent : str
    strength : str
        As for `ScriptedController`.
    share : int
        Cycles of 100 in which he acts, drawn by the world's own luck; in the others he does nothing.

    Raises
    ------
    ParameterError
        For a share that is none.
    """

    needs = ScriptedController.needs

    def __init__(self, task: Task, agent: str, strength: str = "strong", share: int = 50) -> None:
        if isinstance(share, bool) or not isinstance(share, int) or not 0 <= share <= 100:
            raise ParameterError(f"eased: share: {share!r} given; allowed are whole numbers from 0 to 100")
        self.inner, self.share = ScriptedController(task, agent, strength), share
        self._luck = WorldLuck(1)

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes."""
        self.inner.reset(observation, seed, worlds)
        if worlds is None:
            count = len(observation["level"])
            self._luck.begin(np.full(count, seed), np.arange(count))

    def begin(self, observation: Observation, seeds: np.ndarray, worlds: np.ndarray | None = None) -> None:
        """Begin episodes, each with its world's luck."""
        self.inner.reset(observation, 0, worlds)
        self._luck.begin(seeds, self.inner.row + 1, worlds)

    def act(self, observation: Observation) -> Action:
        """One cycle of every world."""
        action = self.inner.act(observation)
        idle = 100.0 * self._luck.draw()[:, 0] >= self.share
        action["type"] = np.where(idle, int(CommandKind.NONE), action["type"])
        action["params"] = np.where(idle[:, None], 0.0, action["params"])
        return action

    def state(self) -> dict[str, np.ndarray]:
        """What decides his next commands."""
        return {**self.inner.state(), **self._luck.state()}


def make_controller(task: Task, agent: str, strength: str = "strong") -> ScriptedController:
    """A scripted player; plays every task."""
    return ScriptedController(task, agent, strength)


def make_eased(task: Task, agent: str, strength: str = "strong", share: int = 50) -> Eased:
    """A scripted player who misses some of his cycles; plays every task."""
    return Eased(task, agent, strength, share)
