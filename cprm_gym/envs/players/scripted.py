"""Scripted players: teams of three strengths and the simplest opponents, for any player who is not controlled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ...errors import UnknownName, unknown_name
from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ...simulator.senses import See
from ...simulator.simulator import Simulator
from ...simulator.state import PLAYERS, CommandKind, Stream
from .kernels import keepers as keeper_kernels
from .kernels import team as team_kernels
from .memory import Memories
from .mixing import Mix, MixingPlayers

STRENGTHS: Mapping[str, int] = {"weak": 0, "medium": 1, "strong": 2}
"""Scripted teams by name."""
SIMPLE = ("hold", "random", "chase", "knock")
"""The simplest players: do nothing, act at random, run at the ball and kick it forward, stand and kick it away when it occurs to them."""
OCCURS, HARD = 0.25, 0.55
"""Chance per cycle that it occurs to a player of the policy ``knock`` to kick, in any direction, and the least share of his full power."""
KEEPAWAY: Mapping[str, int] = {
    "keep_random": keeper_kernels.KEEP_RANDOM, "keep_hold": keeper_kernels.KEEP_HOLD, "keep_hand": keeper_kernels.KEEP_HAND,
    "take": keeper_kernels.TAKE,
}  # fmt: skip
"""Keepers that pass at random, always hold or follow hand-written rules, and takers, of keepaway (`kernels.keepers`)."""
MIXING = "mixing"
"""As the strong team, but with the ball the hidden, linked modes of `mixing`."""
POLICIES = (*SIMPLE, *STRENGTHS, *KEEPAWAY, MIXING)

FORMATION = np.array(
    [
        (-50.0, 0.0), (-36.0, -6.0), (-36.0, 6.0), (-34.0, -18.0), (-34.0, 18.0), (-22.0, 0.0),
        (-18.0, -12.0), (-18.0, 12.0), (-11.0, -22.0), (-11.0, 22.0), (-10.5, 0.0),
    ]
)  # fmt: skip
"""(11, 2) places of the players 1 to 11 at a kick-off, metres in the own team's frame."""


class ScriptedPlayers:
    """The players of W worlds that no agent controls.

    Parameters
    ----------
    simulator : Simulator
    policies : mapping of int to str
        Object number 1..22 -> one of `POLICIES`.
    counts : (int, int)
        Players of the left and right side.
    region : (float, float)
        Half length and half width of where keepers stay, m.
    full_state : bool
        The players know the truth (`Memories`).
    mix : Mix
        How those of the policy ``mixing`` mix.

    Attributes
    ----------
    mixing : MixingPlayers or None
        Those, if there are any.
    fresh : (W, 22) bool array
        Whose eye had a look in this cycle.

    Raises
    ------
    UnknownName
        For a policy or player that does not exist.
    """

    def __init__(
        self, simulator: Simulator, policies: Mapping[int, str], counts: tuple[int, int],
        region: tuple[float, float] = (HALF_LENGTH, HALF_WIDTH), full_state: bool = False,
        mix: Mix = Mix(),  # noqa: B008
    ) -> None:  # fmt: skip
        for player, name in policies.items():
            if name not in POLICIES:
                raise unknown_name("scripted policy", name, POLICIES)
            if not 1 <= player <= PLAYERS:
                raise UnknownName(f"scripted player {player!r}: object numbers are 1 to {PLAYERS}")
        self.simulator = simulator
        self.policies = dict(policies)
        self.counts = np.array(counts, np.int64)
        thinking = [k - 1 for k, name in policies.items() if name in STRENGTHS or name == "chase"]
        self._rows = np.array(thinking, np.int64)
        self._strengths = np.array([STRENGTHS.get(policies[k + 1], 0) for k in thinking], np.int64)
        self._chasers = np.array([k for k in thinking if policies[k + 1] == "chase"], np.int64)
        self._random = np.array([k - 1 for k, name in policies.items() if name == "random"], np.int64)
        self._knockers = np.array([k - 1 for k, name in policies.items() if name == "knock"], np.int64)
        keepers = [k - 1 for k, name in policies.items() if name in KEEPAWAY]
        self._keepers = np.array(keepers, np.int64)
        self._kinds = np.array([KEEPAWAY[policies[k + 1]] for k in keepers], np.int64)
        self._lucky = bool((self._kinds == keeper_kernels.KEEP_RANDOM).any())
        self._luck = np.zeros((simulator.worlds, len(keepers)))
        self._region = float(region[0]), float(region[1])
        active = np.zeros(PLAYERS, bool)
        mixing = [k - 1 for k, name in policies.items() if name == MIXING]
        self.mixing = MixingPlayers(simulator, np.array(mixing, np.int64), self.counts, mix) if mixing else None
        active[thinking + keepers + mixing] = True
        self.memories = Memories(simulator, active, full_state) if active.any() else None
        self.fresh = np.zeros((simulator.worlds if active.any() else 0, PLAYERS), bool)

    @property
    def needs_senses(self) -> bool:
        """Whether anybody here looks."""
        return self.memories is not None

    def reset(self, worlds: np.ndarray) -> None:
        """An episode begins in the given worlds."""
        if self.memories is not None:
            self.memories.forget(worlds)
        if self.mixing is not None:
            self.mixing.reset(worlds)

    def perceive(self, see: See, body: np.ndarray, sent: np.ndarray, worlds: np.ndarray) -> None:
        """Take in the percepts of a cycle.

        Parameters
        ----------
        see, body
            The percepts; row k is world ``worlds[k]``.
        sent : (W, 22) array of COMMAND
            The commands of the cycle before.
        worlds : (n,) int array
        """
        if self.memories is not None:
            self.fresh[worlds] = see.fresh[: len(worlds)]
            if not self.memories.full_state:
                self.memories.update(see, body, sent, worlds)

    def act(self, commands: np.ndarray) -> None:
        """Write the commands of this cycle.

        Parameters
        ----------
        commands : (W, 22) array of COMMAND
            The rows of the scripted players are overwritten.
        """
        if self.memories is not None:
            if self.memories.full_state:
                self.memories.know()
            records = self.memories.records
            if len(self._rows):
                team_kernels.act(self.simulator.world, records, self._rows, self._strengths, self.counts, FORMATION, self.fresh, commands)
            if len(self._keepers):
                if self._lucky:
                    self._luck[...] = self.simulator.uniforms(None, len(self._keepers), Stream.RESETS)
                keeper_kernels.act(
                    self.simulator.world, records, self._keepers, self._kinds, self.counts, *self._region, self._luck, self.fresh, commands
                )
            if self.mixing is not None:
                self.mixing.act(records, FORMATION, self.fresh, commands)
        if len(self._random):
            self._act_at_random(commands)
        if len(self._knockers):
            self._knock(commands)

    def _knock(self, commands: np.ndarray) -> None:
        """Who has the ball kicks it when it occurs to him; for the others the kick does nothing."""
        rows = self._knockers
        u = self.simulator.uniforms(None, 3 * len(rows), Stream.RESETS).reshape(-1, len(rows), 3)
        commands["kind"][:, rows] = np.where(u[..., 0] < OCCURS, CommandKind.KICK, CommandKind.NONE)
        commands["a"][:, rows] = self.simulator.parameters.maxpower * (HARD + (1.0 - HARD) * u[..., 1])
        commands["b"][:, rows] = 360.0 * u[..., 2] - 180.0

    def _act_at_random(self, commands: np.ndarray) -> None:
        rows = self._random
        u = self.simulator.uniforms(None, 3 * len(rows), Stream.RESETS).reshape(-1, len(rows), 3)
        kinds = np.array([CommandKind.DASH, CommandKind.TURN, CommandKind.KICK])
        kind = kinds[(u[..., 0] * 3).astype(np.int64)]
        commands["kind"][:, rows] = kind
        commands["a"][:, rows] = np.where(kind == CommandKind.TURN, 360.0 * u[..., 1] - 180.0, 100.0 * u[..., 1])
        commands["b"][:, rows] = 360.0 * u[..., 2] - 180.0


def assign(default: str | Sequence[str] | Mapping[str, str], players: Sequence[int]) -> dict[int, str]:
    """Policies of the given players from one name for all, or a mapping with the keys ``left`` and ``right``.

    Raises
    ------
    UnknownName
        For a policy or side that does not exist.
    """
    if isinstance(default, str):
        return dict.fromkeys(players, default)
    if isinstance(default, Mapping):
        for side in default:
            if side not in ("left", "right"):
                raise UnknownName(f"opponents: unknown side {side!r}; allowed are left and right")
        return {p: default.get("left" if p <= 11 else "right", "hold") for p in players}
    return dict(zip(players, default))
