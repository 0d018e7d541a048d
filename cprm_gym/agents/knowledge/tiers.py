"""A tier of knowledge turns what is told and what was sent into the parts ``self``, ``memory`` and ``memory_age`` of an observation.

Nets, models, state machines and scripts read their knowledge of the pitch in these parts, so each of them runs on each tier as it is:
`Informed` puts the tier in between. Nothing else of the observation is touched.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Protocol

import numpy as np

from ...architecture.cprm import CPRM
from ...envs.controller import Action, Controller, Observation
from ...envs.core import SoccerCore
from ...envs.observations import SelfFeature
from ...errors import ControllerError
from ...simulator.senses import BallLevel
from ...simulator.state import CommandKind

PARTS = ("self", "memory", "memory_age")
"""What a tier says."""


class Tier(Protocol):
    """Knowledge of one agent in each of N worlds."""

    name: ClassVar[str]
    oracle: ClassVar[bool]
    """Whether it reads the truth: `Oracle.connect` before its first use.

    A tier that reads other parts of an observation than ``memory`` names them in ``needs``.
    """

    def reset(self, observation: Observation, worlds: np.ndarray | None = None) -> None:
        """Begin episodes, as for a controller."""

    def know(self, observation: Observation, sent: Action | None) -> Mapping[str, np.ndarray]:
        """What is known in this cycle; called once in each.

        Parameters
        ----------
        observation : dict of (N, ...) arrays
            As the environment tells it, with the parts `PARTS`.
        sent : dict of (N, ...) arrays, or None
            The actions of the cycle before, ``type`` none in worlds that begin; None where all do.

        Returns
        -------
        dict of (N, ...) arrays
            Those of `PARTS` that differ.
        """


class Memory:
    """The environment's own dead reckoning: what was last seen, carried on."""

    name: ClassVar[str] = "memory"
    oracle: ClassVar[bool] = False

    def reset(self, observation: Observation, worlds: np.ndarray | None = None) -> None:
        """Nothing to begin."""

    def know(self, observation: Observation, sent: Action | None) -> Mapping[str, np.ndarray]:
        """As it is told."""
        return {}


class Frozen:
    """The ball as it was last seen, where it was seen: nothing is carried on. The others are so in every memory."""

    name: ClassVar[str] = "frozen"
    oracle: ClassVar[bool] = False

    def __init__(self) -> None:
        self._ball = np.zeros((0, 4), np.float32)

    def reset(self, observation: Observation, worlds: np.ndarray | None = None) -> None:
        """Forget."""
        if worlds is None:
            self._ball = np.zeros((len(observation["level"]), 4), np.float32)
        else:
            self._ball[worlds] = 0.0

    def know(self, observation: Observation, sent: Action | None) -> Mapping[str, np.ndarray]:
        """The last readings."""
        located = np.asarray(observation["self"])[:, SelfFeature.LOCATED] > 0
        level = np.asarray(observation["level"])[:, 0]
        placed, moving = located & (level > 0), located & (level >= BallLevel.MOVING)
        now = np.asarray(observation["memory"])[:, 0]
        self._ball[placed, :2] = now[placed, :2]
        self._ball[moving, 2:] = now[moving, 2:]
        memory = np.array(observation["memory"])
        memory[:, 0] = self._ball
        return {"memory": memory}


class Informed:
    """A controller on a tier of knowledge.

    Parameters
    ----------
    controller : Controller
        Reads ``self``, ``memory`` and ``memory_age``.
    tier : Tier
    """

    def __init__(self, controller: Controller, tier: Tier) -> None:
        self.controller, self.tier = controller, tier
        needs: tuple[str, ...] = getattr(tier, "needs", ("memory",))
        wanted = tuple(part for part in getattr(controller, "needs", ()) if part != "memory")
        self.needs: tuple[str, ...] = tuple(dict.fromkeys((*needs, *wanted)))
        """Parts of the observation: those that the tier reads, and what the controller reads besides what the tier says."""
        self.known: Mapping[str, np.ndarray] = {}
        """Parts of the observation as the tier told them last."""
        self._sent: Action | None = None

    @property
    def cprm(self) -> CPRM | None:
        """The controller's; None where it plays with none."""
        return getattr(self.controller, "cprm", None)

    @property
    def oracle(self) -> bool:
        """Whether the tier reads the truth."""
        return self.tier.oracle

    def connect(self, core: SoccerCore, agent: str) -> None:
        """Show the worlds to a tier that is an oracle, and to no other one."""
        if self.tier.oracle:
            self.tier.connect(core, agent)  # type: ignore[attr-defined]

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes."""
        if worlds is None:
            self._sent = None
        elif self._sent is not None:
            self._sent["type"][worlds] = CommandKind.NONE
        self.tier.reset(observation, worlds)
        self.controller.reset(observation, seed, worlds)

    def act(self, observation: Observation) -> Action:
        """What the controller does, given what the tier knows."""
        self.known = self.tier.know(observation, self._sent)
        action = self.controller.act({**observation, **self.known})
        self._sent = {key: np.array(value) for key, value in action.items()}
        return action


def not_connected(tier: str) -> ControllerError:
    """For an oracle that nobody has shown the worlds."""
    return ControllerError(f"tier {tier!r} reads the truth and was shown no worlds: call connect(core, agent) first")
