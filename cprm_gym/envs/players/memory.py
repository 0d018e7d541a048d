"""What players remember of a match: one record per player, kept up to date from his percepts alone."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...simulator.landmarks import LANDMARKS
from ...simulator.packing import pack
from ...simulator.parameters import ServerParameters
from ...simulator.player_types import PlayerParameters, PlayerType
from ...simulator.senses import See, new_landmarks
from ...simulator.simulator import Simulator
from ...simulator.state import PLAYERS
from ..kernels.observations import pack_memory
from .kernels import memory as kernels

MEMORY = np.dtype(
    [
        # himself, in the frame of his team: x towards the opponent's goal
        ("x", "f8"), ("y", "f8"), ("vx", "f8"), ("vy", "f8"), ("body", "f8"), ("neck", "f8"), ("face", "f8"),
        ("stamina", "f8"), ("effort", "f8"),
        ("located", "u1"),              # he has known his place since the episode began
        ("free", "u1"),                 # his body obeys (no tackle or foul lock)
        # the ball and when it was last seen, cycles
        ("ball_x", "f8"), ("ball_y", "f8"), ("ball_vx", "f8"), ("ball_vy", "f8"), ("ball_age", "i4"),
        # own team 0..10, opponents 11..21
        ("px", "f8", (PLAYERS,)), ("py", "f8", (PLAYERS,)), ("age", "i4", (PLAYERS,)),
        ("looks", "i4"),                # how often he has seen the pitch, or forgotten all of it: the places of others change only then
        ("search", "i4"),               # looks made for the ball since it was lost
        ("taker", "i4"),                # cycles for which he leaves the ball alone: he took the set play
        ("kicker", "i4"),               # number of the player of a small team who took the set play and may not touch the ball; 0 nobody
        ("kicked", "i4"),               # his `clock` when that was last so
        ("clock", "i4"),                # cycles that he has played, by which he times his runs
        ("left", "u1"),                 # his team is the left one
        # what the server has told him of the world and of his own type (`kernels.memory.embody`)
        ("kind", "i4"),                 # his type + 1; 0 while he has been told nothing
        ("contact", "f8"), ("reach", "f8"), ("sure", "f8"), ("near", "f8"), ("margin", "f8"), ("size", "f8"),
        ("kick_rate", "f8"), ("power", "f8"), ("decay", "f8"), ("inertia", "f8"), ("dash_rate", "f8"), ("stride", "f8"),
        ("stamina_max", "f8"), ("catch_reach", "f8"), ("ball_decay", "f8"), ("ball_speed", "f8"), ("ball_accel", "f8"),
        ("goal_half", "f8"), ("moment_low", "f8"), ("moment_high", "f8"), ("neck_low", "f8"), ("neck_high", "f8"),
        ("tackle_dist", "f8"), ("tackle_width", "f8"), ("tackle_exponent", "f8"),
    ],
    align=True,
)  # fmt: skip
"""One player's picture of the pitch; metres, radians, cycles."""


def embody(records: np.ndarray, parameters: ServerParameters) -> None:
    """Tell players without a simulator, (W, 22) records, what a default player of a server with these parameters is."""
    packed = pack(parameters, PlayerParameters(), [PlayerType.default(parameters)])
    kernels.embody_all(records, packed)


class Memories:
    """The memories of the players of W worlds.

    Parameters
    ----------
    simulator : Simulator
    active : (22,) bool array
        Whose memory is kept.
    full_state : bool
        Everybody knows the truth, without noise, as in HFO's and keepaway's full state mode.

    Attributes
    ----------
    records : (W, 22) array of MEMORY
    """

    def __init__(self, simulator: Simulator, active: np.ndarray, full_state: bool = False) -> None:
        self.simulator = simulator
        self.full_state = full_state
        self.active = np.asarray(active, bool)
        self.records: np.ndarray = np.zeros((simulator.worlds, PLAYERS), MEMORY)
        self._all = np.arange(simulator.worlds)
        # where messages tell of landmarks, theirs; else room for those of one player, who looks at them himself
        self._landmarks, self._sight = new_landmarks(1), np.zeros((3, LANDMARKS))
        kernels.embody_all(self.records, simulator.packed)
        self.forget(self._all)

    def forget(self, worlds: np.ndarray) -> None:
        """Empty the memories of the given worlds; an episode begins."""
        kernels.forget(self.records, np.asarray(worlds, np.int64))

    def update(self, see: See, body: np.ndarray, sent: Any, worlds: np.ndarray) -> None:
        """Take in the percepts of a cycle.

        Parameters
        ----------
        see : See
        body : (n, 22, columns) array
        sent : (W, 22) array of COMMAND
            What was sent in the cycle before.
        worlds : (n,) int array
            Which worlds; row k of the percepts is world ``worlds[k]``.
        """
        if self.full_state:
            self.know(worlds)
            return
        told = self.simulator.told
        marks = self.simulator.landmarks(self._landmarks) if told else self._landmarks
        kernels.update(
            self.simulator.world, self.simulator.packed, worlds, self.records, sent, self.active, see.fresh, see.ball, see.ball_level,
            see.players, see.players_level, body, told, self._sight, marks.landmarks, marks.level, marks.lines, marks.line,
        )  # fmt: skip

    def know(self, worlds: np.ndarray | None = None) -> None:
        """Take in the truth, in the given worlds (n,) or all."""
        chosen = self._all if worlds is None else worlds
        kernels.know(self.simulator.world, self.simulator.packed, chosen, self.records, self.active)


def true_memory(simulator: Simulator, player: int) -> dict[str, np.ndarray]:
    """The truth as a player would remember it, for oracles alone.

    Parameters
    ----------
    simulator : Simulator
    player : int
        Object number.

    Returns
    -------
    dict of (W, ...) float32 arrays
        ``self``, ``memory``, ``memory_age`` as in the observations.
    """
    records: np.ndarray = np.zeros((simulator.worlds, PLAYERS), MEMORY)
    every = np.arange(simulator.worlds)
    kernels.know(simulator.world, simulator.packed, every, records, np.arange(1, PLAYERS + 1) == player)
    told = [np.zeros((simulator.worlds, 1, *shape), np.float32) for shape in ((8,), (PLAYERS + 1, 4), (PLAYERS + 1,))]
    pack_memory(records, every, np.array([player]), *told)
    return {key: value[:, 0] for key, value in zip(("self", "memory", "memory_age"), told)}
