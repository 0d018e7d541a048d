"""Slow inference (dissertation §5.3.2): what is inferred comes every t_B cycles, and some cycles after the readings that it is from.

Two agents differ in one thing. For the one, all that he decides from is inferred, so all of it is late. The other has reflexes: what the
senses tell in this cycle reaches him in this cycle, and what is inferred is late.
"""

from __future__ import annotations

import numpy as np

from ...agents.knowledge import Informed
from ...agents.knowledge.tiers import PARTS
from ...envs.controller import Action, Observation
from ...envs.core import SoccerCore
from ...envs.observations import MAX_AGE, SelfFeature
from ...errors import ParameterError
from ...simulator.state import CommandKind


class Slow:
    """A controller on a tier of knowledge whose results come late.

    Parameters
    ----------
    player : Informed
        Its tier infers, its controller decides.
    period : int
        t_B: an inference is begun in every so many cycles; in between its last result holds.
    latency : int
        Cycles that an inference takes.
    reflexes : bool
        Whether the controller gets this cycle's readings beside the late inference. Where the ball is seen, they then are what he knows
        of it, as by a reflex arc from the eye; without them a late picture is all there is.

    Raises
    ------
    ParameterError
        For a period below 1 or a latency below 0.
    """

    def __init__(self, player: Informed, period: int = 1, latency: int = 0, reflexes: bool = False) -> None:
        if period < 1 or latency < 0:
            raise ParameterError(f"period {period} and latency {latency}: needs at least 1 and at least 0")
        self.player, self.period, self.latency, self.reflexes = player, period, latency, reflexes
        self.needs = tuple(dict.fromkeys((*player.needs, "memory"))) if reflexes else player.needs
        self._sent: Action | None = None
        self._kept: list[dict[str, np.ndarray]] = []
        self._age = np.zeros(0, np.int64)

    @property
    def oracle(self) -> bool:
        """As for `Informed`."""
        return self.player.oracle

    def connect(self, core: SoccerCore, agent: str) -> None:
        """As for `Informed`."""
        self.player.connect(core, agent)

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes: the first inference has been made when they begin."""
        if worlds is None or not len(self._age):
            self._age = np.zeros(len(observation["level"]), np.int64)
            self._sent, self._kept = None, []
        else:
            self._age[worlds] = 0
            if self._sent is not None:
                self._sent["type"][worlds] = CommandKind.NONE
        self.player.tier.reset(observation, worlds)
        self.player.controller.reset(observation, seed, worlds)

    def act(self, observation: Observation) -> Action:
        """What the controller does, given what is known by now."""
        known = {**observation, **self.player.tier.know(observation, self._sent)}
        parts = PARTS if self.reflexes else tuple(known)
        fresh = self._age == 0
        now = {key: np.array(known[key]) for key in parts}
        self._kept = [now, *self._kept[: self.period + self.latency - 1]]
        while len(self._kept) < self.period + self.latency:
            self._kept.append({key: value.copy() for key, value in now.items()})
        for old in self._kept[1:]:
            for key in parts:
                old[key][fresh] = now[key][fresh]
        # the inference whose result is there: the last one begun at least `latency` cycles ago, in a cycle that is a multiple of the period
        since = np.maximum(self._age - self.latency, 0) % self.period + np.minimum(self._age, self.latency)
        rows = np.arange(len(since))
        told = {**observation, **{key: np.stack([old[key] for old in self._kept])[since, rows] for key in parts}}
        told["memory_age"] = np.minimum(told["memory_age"] + since[:, None], MAX_AGE).astype(told["memory_age"].dtype)
        if self.reflexes:
            self._by_reflex(told, observation)
        action = self.player.controller.act(told)
        self._sent = {key: np.array(value) for key, value in action.items()}
        self._age += 1
        return action

    @staticmethod
    def _by_reflex(told: dict[str, np.ndarray], observation: Observation) -> None:
        """The own body, and the ball where it is seen now, as the senses tell them in this cycle."""
        located = np.asarray(observation["self"])[:, SelfFeature.LOCATED] > 0
        told["self"] = np.where(located[:, None], observation["self"], told["self"])
        seen = located & (np.asarray(observation["level"])[:, 0] > 0)
        told["memory"][seen, 0] = np.asarray(observation["memory"])[seen, 0]
        told["memory_age"][seen, 0] = np.asarray(observation["memory_age"])[seen, 0]
