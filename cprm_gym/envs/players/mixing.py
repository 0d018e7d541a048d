"""Players who mix: a hidden mode (dribble, feint, pass, shoot), drawn by the world's own luck, held for a while, linked to the next."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np

from ...errors import ParameterError
from ...simulator.simulator import Simulator
from ...simulator.state import PLAYERS, Stream
from .kernels import mixing as kernels
from .stated import stated

INTENT = np.dtype(
    [
        ("mode", "i4"),                 # a `Mode`
        ("cycles", "i4"),               # that it still lasts
        ("side", "i4"),                 # +1 or -1: y to which the ball was moved in the last feint, own team's frame; 0 none since
        ("begun", "i4"),                # a mode has been drawn in this episode
    ],
    align=True,
)  # fmt: skip
"""What one player has in mind."""
NOBODY = -1
"""Mode of who does not mix."""


class Mode(IntEnum):
    """What a mixing player does when he has the ball."""

    DRIBBLE = kernels.DRIBBLE
    """Past the opponents, towards the goal."""
    FEINT = kernels.FEINT
    """The ball goes aside; if a shot follows, it goes to the other corner."""
    PASS = kernels.PASS
    """To the team-mate with the clearest way; a dribble where there is none."""
    SHOOT = kernels.SHOOT
    """At the clearest corner, once the goal is within `Mix.reach`; until then a dribble."""


@dataclass(frozen=True, kw_only=True)
class Mix:
    """How the players of the policy ``mixing`` mix.

    Attributes
    ----------
    dribble, feint, passing, shoot : float
        Shares in which a mode is drawn, of at least 0, not all 0; ``Mix(dribble=0, feint=0, passing=0, shoot=1)`` always shoots at once.
    shortest, longest : int
        Cycles for which a mode is held: a whole number drawn evenly between them, 1 to 1000.
    link : float
        Probability that the next mode is the one that the last leads to (dribble - feint - shot, pass - dribble, shot - dribble) instead of
        one drawn by the shares, 0 to 1.
    reach : float
        Metres from the middle of the goal within which who means to shoots.
    close : float
        Metres within which he shoots whatever he had in mind.
    pace : float
        Share of the ball's top speed at which he shoots, 0.1 to 1.

    Raises
    ------
    ParameterError
        For a number that is out of its range.
    """

    dribble: float = 0.3
    feint: float = 0.25
    passing: float = 0.25
    shoot: float = 0.2
    shortest: int = 4
    longest: int = 14
    link: float = 0.4
    reach: float = 22.0
    close: float = 8.0
    pace: float = 1.0

    def __post_init__(self) -> None:
        limits = {"link": (0.0, 1.0), "reach": (0.0, 120.0), "close": (0.0, 120.0), "pace": (0.1, 1.0)}
        for name, (low, high) in {**dict.fromkeys(("dribble", "feint", "passing", "shoot"), (0.0, 1e6)), **limits}.items():
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, float, np.number)) or not low <= value <= high:
                raise ParameterError(f"mix: {name}: {value!r} given; allowed are numbers from {low:g} to {high:g}")
        for name in ("shortest", "longest"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 1 <= value <= 1000:
                raise ParameterError(f"mix: {name}: {value!r} given; allowed are whole numbers from 1 to 1000")
        if self.shortest > self.longest:
            raise ParameterError(f"mix: shortest: {self.shortest} given; allowed are numbers up to longest, {self.longest}")
        if not self.shares.sum() > 0:
            raise ParameterError("mix: dribble, feint, passing and shoot are all 0; one of them has to be more")

    @classmethod
    def of(cls, given: Mix | Mapping[str, Any]) -> Mix:
        """A mix, or the one that a mapping of its fields means.

        Raises
        ------
        ParameterError
            For what is neither, or a field that there is not.
        """
        return stated(cls, given, "mix")

    @property
    def shares(self) -> np.ndarray:
        """(4,) of the modes, in the order of `Mode`, as they are given."""
        return np.array([self.dribble, self.feint, self.passing, self.shoot], np.float64)


class MixingPlayers:
    """The players of W worlds who mix.

    Parameters
    ----------
    simulator : Simulator
    players : (P,) int array
        Their rows, 0 to 21.
    counts : (2,) int array
        Players of the left and right side.
    mix : Mix

    Attributes
    ----------
    intents : (W, 22) array of INTENT
        What they have in mind: truth, which nobody perceives.
    """

    def __init__(self, simulator: Simulator, players: np.ndarray, counts: np.ndarray, mix: Mix) -> None:
        self.simulator, self.players, self.counts, self.mix = simulator, players, counts, mix
        self.intents: np.ndarray = np.zeros((simulator.worlds, PLAYERS), INTENT)
        bounds = np.cumsum(mix.shares) / mix.shares.sum()
        self._how = (bounds, int(mix.shortest), int(mix.longest), float(mix.link), float(mix.reach), float(mix.close), float(mix.pace))
        self.reset(np.arange(simulator.worlds))

    def reset(self, worlds: np.ndarray) -> None:
        """An episode begins in the given worlds; the first mode is drawn in its first cycle."""
        self.intents[worlds] = np.zeros((), INTENT)

    @property
    def modes(self) -> np.ndarray:
        """(W, 22) `Mode` of each player, `NOBODY` of who does not mix or has not begun."""
        modes = np.full(self.intents.shape, NOBODY, np.int64)
        rows = self.players
        modes[:, rows] = np.where(self.intents["begun"][:, rows] > 0, self.intents["mode"][:, rows], NOBODY)
        return modes

    def act(self, records: np.ndarray, formation: np.ndarray, fresh: np.ndarray, commands: np.ndarray) -> None:
        """Write their commands of this cycle; `records`: (W, 22) MEMORY, `fresh`: (W, 22) who has just seen something."""
        count = len(self.players)
        luck = self.simulator.uniforms(None, kernels.LUCK * count, Stream.RESETS).reshape(-1, count, kernels.LUCK)
        kernels.act(self.simulator.world, records, self.intents, self.players, self.counts, formation, luck, *self._how, fresh, commands)
