"""The preset ``normalised``: what a player remembers of the pitch, as numbers a network can start from.

Five parts, each within [-1, 1]: ``me``, ``ball``, ``goals``, ``players`` (team-mates, then opponents, by number) and ``known``, the mask:
1 for the ball and each player whose place is known, 0 otherwise, and then all his entries are 0. Directions are sine and cosine against
the own body, distances logarithms, so that half a metre counts near the ball and ten far from it. With ``flatten`` the parts stand one
after the other in one vector; `Columns.names` says what each entry is. Everything comes from the player's own memory of what he
perceived (`cprm_gym.envs.players.memory`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from gymnasium import spaces

from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH, PITCH_LENGTH, PITCH_WIDTH
from ...simulator.state import PlayMode
from ..kernels import normalised as kernels
from ..kernels.vectors import RECENT
from ..observations import BodyFeature
from ..pitch import Pitch


class Column(NamedTuple):
    """One entry of a part."""

    name: str
    low: float
    high: float
    unit: str
    """What 1 means."""
    meaning: str


ME = (
    Column("located", 0, 1, "flag", "he has known his place since the episode began; the entries that need it are 0 before"),
    Column("x", -1, 1, f"{HALF_LENGTH:g} m", "own place, x towards the opponent's goal"),
    Column("y", -1, 1, f"{HALF_WIDTH:g} m", "own place, y to the right hand of who looks there"),
    Column("body_sin", -1, 1, "sine", "own body against the x axis"),
    Column("body_cos", -1, 1, "cosine", "own body against the x axis"),
    Column("neck", -1, 1, "90 degrees", "neck against the body"),
    Column("forward", -1, 1, "top speed", "own velocity along the body"),
    Column("sideward", -1, 1, "top speed", "own velocity across it"),
    Column("stamina", 0, 1, "stamina_max", "stamina left"),
    Column("effort", 0, 1, "1", "share of a dash's power that has effect"),
    Column("free", 0, 1, "flag", "the body obeys: no tackle, no foul holds it"),
    Column("fresh", 0, 1, "flag", "a look came in this cycle"),
    Column("kickable", 0, 1, "flag", "the ball is within reach"),
    Column("goalie", 0, 1, "flag", "he is the goalie"),
    Column("play_on", 0, 1, "flag", "the ball is in play"),
    Column("own_ball", 0, 1, "flag", "a set play of the own team"),
    Column("their_ball", 0, 1, "flag", "a set play of the opponents"),
)
"""Columns of ``me``."""
_WAY = (
    Column("sin", -1, 1, "sine", "direction against the own body"),
    Column("cos", -1, 1, "cosine", "direction against the own body"),
    Column("distance", 0, 1, "log(1 + 125 m)", "log(1 + distance in m) over that of the pitch's diagonal, which stands for all beyond"),
)
_AGE = Column("age", 0, 1, f"{RECENT} cycles", "since it was last seen; later it counts as unknown")
BALL = (
    *_WAY,
    Column("forward", -1, 1, "ball_speed_max", "its velocity along the own body"),
    Column("sideward", -1, 1, "ball_speed_max", "its velocity across it"),
    _AGE,
)
"""Columns of ``ball``."""
GOALS = tuple(c._replace(name=f"{goal}_{c.name}") for goal in ("their", "own") for c in _WAY)
"""Columns of ``goals``: the middle of the opponents' and of the own goal; 0 before the place is known."""
PLAYER = (
    *_WAY,
    _AGE,
    Column("told", 0, 1, "flag", "seen in this cycle with his body and motion; the entries that follow are 0 otherwise"),
    Column("body_sin", -1, 1, "sine", "his body against the own one"),
    Column("body_cos", -1, 1, "cosine", "his body against the own one"),
    Column("forward", -1, 1, "top speed", "his velocity along the own body"),
    Column("sideward", -1, 1, "top speed", "his velocity across it"),
)
"""Columns of a row of ``players``."""
KNOWN = Column("known", 0, 1, "flag", f"his place is known: seen in the last {RECENT} cycles; otherwise all his entries are 0")
FARTHEST = math.hypot(PITCH_LENGTH, PITCH_WIDTH)
"""Distance that is 1, m: the diagonal of the pitch."""


def mode_flags() -> np.ndarray:
    """(modes, 2, 3) what the last three entries of ``me`` are in each play mode, for the left and the right side."""
    table = np.zeros((max(PlayMode) + 1, 2, 3), np.float32)
    table[PlayMode.play_on, :, 0] = 1.0
    for mode in PlayMode:
        name, _, side = mode.name.rpartition("_")
        if side in ("l", "r") and name in ("kick_off", "kick_in", "free_kick", "corner_kick", "goal_kick", "penalty_kick",
                                           "indirect_free_kick", "penalty_setup", "penalty_ready", "penalty_taken"):  # fmt: skip
            whose = 0 if side == "l" else 1
            table[mode, whose, 1] = table[mode, 1 - whose, 2] = 1.0
    return table


@dataclass(frozen=True)
class Columns:
    """The parts of an observation and what their entries are.

    Attributes
    ----------
    mates, opponents : int
        Rows of ``players``; where the two sides are controlled and of different sizes, those of the larger one, and rows of nobody are 0.
    task_features : tuple of (name, low, high)
        What the task adds, under ``task``, scaled from its bounds to [-1, 1].
    """

    mates: int
    opponents: int
    task_features: tuple[tuple[str, float, float], ...] = ()

    @property
    def others(self) -> tuple[str, ...]:
        """``mate_1 ... mate_n, opponent_1 ... opponent_m``."""
        return tuple(f"mate_{k + 1}" for k in range(self.mates)) + tuple(f"opponent_{k + 1}" for k in range(self.opponents))

    @property
    def parts(self) -> dict[str, tuple[tuple[int, ...], tuple[Column, ...]]]:
        """Shape and columns of each part, in their order; the columns of ``players`` row by row."""
        rows = self.others
        parts: dict[str, tuple[tuple[int, ...], tuple[Column, ...]]] = {
            "me": ((len(ME),), ME), "ball": ((len(BALL),), BALL), "goals": ((len(GOALS),), GOALS),
        }  # fmt: skip
        if rows:
            players = tuple(c._replace(name=f"{row}_{c.name}") for row in rows for c in PLAYER)
            parts["players"] = ((len(rows), len(PLAYER)), players)
        parts["known"] = ((1 + len(rows),), tuple(KNOWN._replace(name=row) for row in ("ball", *rows)))
        if self.task_features:
            added = tuple(Column(name, -1, 1, f"{low:g} to {high:g}", "of the task") for name, low, high in self.task_features)
            parts["task"] = ((len(added),), added)
        return parts

    @property
    def names(self) -> tuple[str, ...]:
        """What each entry of the flat vector is: ``ball_distance``, ``opponent_1_sin``, ``known_ball`` ..."""
        names: list[str] = []
        for part, (_, columns) in self.parts.items():
            names += [c.name if part == "players" else f"{part}_{c.name}" for c in columns]
        return tuple(names)

    @property
    def size(self) -> int:
        """Entries of the flat vector."""
        return sum(len(columns) for _, columns in self.parts.values())

    def space(self, flatten: bool) -> spaces.Space[Any]:
        """Space of one agent's observation: a Dict of the parts, or one vector."""
        boxes: dict[str, spaces.Space[Any]] = {}
        for part, (shape, columns) in self.parts.items():
            low, high = (np.array([getattr(c, bound) for c in columns], np.float32).reshape(shape) for bound in ("low", "high"))
            boxes[part] = spaces.Box(low, high, dtype=np.float32)
        if not flatten:
            return spaces.Dict(boxes)
        low, high = (np.concatenate([getattr(box, bound).ravel() for box in boxes.values()]) for bound in ("low", "high"))
        return spaces.Box(low, high, dtype=np.float32)

    def views(self, vector: np.ndarray) -> dict[str, np.ndarray]:
        """The parts as views of vectors, (..., size)."""
        views, at = {}, 0
        for part, (shape, columns) in self.parts.items():
            views[part] = vector[..., at : at + len(columns)].reshape(*vector.shape[:-1], *shape)
            at += len(columns)
        return views


class Normalised:
    """Writes the observations of a batch.

    Parameters
    ----------
    pitch : Pitch
    task_features : tuple of (name, low, high)

    Attributes
    ----------
    columns : Columns
    """

    def __init__(self, pitch: Pitch, task_features: tuple[tuple[str, float, float], ...] = ()) -> None:
        left, right = pitch.counts
        sides = {player <= 11 for player in pitch.players.tolist()} or {True}
        mates = max(left if of_left else right for of_left in sides)
        opponents = max(right if of_left else left for of_left in sides)
        self.columns = Columns(mates - 1, opponents, task_features)
        # memory index of each row; -1 where a row is nobody's
        self._others = np.full((len(pitch.players), mates - 1 + opponents), -1)
        for k, player in enumerate(pitch.players.tolist()):
            own, other = (left, right) if player <= 11 else (right, left)
            mine = [j for j in range(own) if j != (player - 1) % 11]
            self._others[k, : len(mine)] = mine
            self._others[k, mates - 1 : mates - 1 + other] = 11 + np.arange(other)
        self._flags = mode_flags()
        p = pitch.parameters
        self._scales = np.array([math.log1p(FARTHEST), p.ball_speed_max, p.stamina_max])
        self._low = np.array([f[1] for f in task_features], np.float32)
        self._half = np.array([max((f[2] - f[1]) / 2, 1e-12) for f in task_features], np.float32)

    def write(self, pitch: Pitch, worlds: np.ndarray, records: np.ndarray, vector: np.ndarray) -> None:
        """The vectors, (W, A, size), of some worlds, (n,), whose percepts and memories, (W, 22) of MEMORY, have just been made."""
        o, sim = pitch.observation, pitch.sim
        kernels.normalised(
            sim.world, sim.packed, worlds, pitch.players, records, o["body"], int(BodyFeature.FRESH), o["players"], o["level"],
            self._others, self._flags, self._scales, vector,
        )  # fmt: skip

    def add_task(self, features: np.ndarray, vector: np.ndarray) -> None:
        """What the task adds, (W, A, features), at the end of the vectors."""
        vector[..., -features.shape[-1] :] = np.clip((features - self._low) / self._half - 1.0, -1.0, 1.0)
