"""The macro actions of agents: a few things that soccer players do, each carried out from the agent's own memory."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...errors import CommandError
from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ...simulator.senses import See
from ...simulator.simulator import Simulator
from ...simulator.state import PLAYERS
from .kernels import macros as kernels
from .memory import Memories
from .scripted import FORMATION

FIXED = ("noop", "reorient", "go_to_ball", "intercept", "move_to", "dribble", "shoot", "hold", "defend_goal", "catch",
         "receive")  # fmt: skip
"""The macros that do not name another player."""


def macro_names(mates: int, opponents: int) -> tuple[str, ...]:
    """Names of the macros: the fixed ones, ``pass_1 ...`` to the other players of the team by number, ``mark_1 ...`` of the opponents."""
    return FIXED + tuple(f"pass_{k + 1}" for k in range(mates)) + tuple(f"mark_{k + 1}" for k in range(opponents))


class Macros:
    """Carries out the macros of the agents of W worlds.

    Parameters
    ----------
    simulator : Simulator
    players : (A,) int array
        Object numbers of the agents.
    counts : (int, int)
        Players of the left and right side.
    region : (float, float)
        Half length and half width of where `receive` gets open, m.
    full_state : bool
        The memories hold the truth (`Memories`).

    Attributes
    ----------
    names : tuple of str
        By index; the largest set of any agent.
    mask : (W, A, len(names)) bool array
        What can be done now; always at least ``noop`` and ``reorient``.
    fresh : (W, 22) bool array
        Whose eye had a look in this cycle.
    """

    def __init__(
        self, simulator: Simulator, players: np.ndarray, counts: tuple[int, int], region: tuple[float, float] = (HALF_LENGTH, HALF_WIDTH),
        full_state: bool = False,
    ) -> None:  # fmt: skip
        self.simulator = simulator
        self.players = np.asarray(players, np.int64)
        left = self.players <= 11
        self._mates = np.where(left, counts[0], counts[1]) - 1
        self._opponents = np.where(left, counts[1], counts[0])
        self.names = macro_names(int(self._mates.max()), int(self._opponents.max()))
        if len(set(self._mates.tolist())) > 1:
            # one numbering for all agents: passes of the larger side, then marks
            self._mates = np.full(len(self.players), self._mates.max())
        active = np.zeros(PLAYERS, bool)
        active[self.players - 1] = True
        self.memories = Memories(simulator, active, full_state)
        self._region = float(region[0]), float(region[1])
        self.mask: np.ndarray = np.zeros((simulator.worlds, len(self.players), len(self.names)), bool)
        self.fresh: np.ndarray = np.zeros((simulator.worlds, PLAYERS), bool)

    def reset(self, worlds: np.ndarray) -> None:
        """An episode begins in the given worlds."""
        self.memories.forget(worlds)

    def observe(self, see: See, body: np.ndarray, sent: np.ndarray, worlds: np.ndarray) -> None:
        """Take in the percepts of a cycle in the given worlds, row k being ``worlds[k]``, and say what can be done there."""
        self.memories.update(see, body, sent, worlds)
        self.fresh[worlds] = see.fresh[: len(worlds)]
        kernels.masks(self.simulator.world, worlds, self.memories.records, self.players, self._mates, self._opponents, self.mask)

    def act(self, action: Any, commands: np.ndarray) -> None:
        """Write the commands of the agents' macros.

        Parameters
        ----------
        action : (W, A) int array
        commands : (W, 22) array of COMMAND

        Raises
        ------
        CommandError
            When the action has another shape, or is no macro.
        """
        shape = self.mask.shape[:2]
        array = np.asarray(action)
        if array.shape != shape or array.dtype.kind not in "iu":
            raise CommandError(f"action 'macro': expected whole numbers of shape {shape}, got {array.dtype} of shape {array.shape}")
        if array.size and (array.min() < 0 or array.max() >= len(self.names)):
            bad = int(array[(array < 0) | (array >= len(self.names))][0])
            raise CommandError(f"action 'macro': {bad} is none; allowed are 0 to {len(self.names) - 1}: {', '.join(self.names)}")
        kernels.act(
            self.simulator.world, self.memories.records, self.players, array.astype(np.int64), self._mates, FORMATION, *self._region,
            self.fresh, commands,
        )  # fmt: skip
