"""What tasks, rewards and observations use of the worlds: who acts, where everything is, what the cycle brought."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..errors import ParameterError, UnknownName
from ..simulator.pitch import HALF_LENGTH, HALF_WIDTH, PITCH_MARGIN
from ..simulator.simulator import Simulator
from ..simulator.state import LEFT, RIGHT, Stream
from .kernels import pitch as kernels

FARTHEST = np.array([HALF_LENGTH, HALF_WIDTH]) + PITCH_MARGIN
"""|x| and |y| of the farthest places where somebody can be put, m."""
COUNTERS = 8
"""Columns of `Pitch.memory`."""


class Pitch:
    """A batch of worlds in which agents act.

    Parameters
    ----------
    sim : Simulator
    players : (A,) int array
        Object numbers of the agents.
    counts : (int, int)
        Players of the left and the right side.
    region : (float, float)
        Half length and half width of where the game takes place, m.
    max_cycles : int
        Cycles until an episode is out of time.

    Attributes
    ----------
    worlds : int
        How many, W.
    every : (W,) int array
        The indices of all of them.
    parameters : ServerParameters
    sides : (A,) float array
        +1 for agents of the left team, -1 for the right one.
    cycle : (W,) int array
        Cycles of the episode.
    late : (W,) bool array
        Whether the episode has no time left.
    memory : (W, 8) int array
        Counters that a task keeps between cycles; zero at the start of an episode.
    previous_ball : (W, 2) float array
        Where the ball was before the cycle just played.
    observation : dict of str to array
        Current observations, each (W, A, ...), float32.
    place_ball, place_player : callable
        The trainer's powers (`cprm_gym.simulator.trainer`): metres, m / cycle and radians in the frame of the pitch.
    """

    def __init__(self, sim: Simulator, players: np.ndarray, counts: tuple[int, int], region: tuple[float, float], max_cycles: int) -> None:
        self.sim, self.players, self.counts, self.region, self.max_cycles = sim, players, counts, region, max_cycles
        self.worlds = sim.worlds
        self.every = np.arange(self.worlds)
        self.parameters = sim.parameters
        self.packed = sim.packed[0]
        self.sides = np.where(players <= 11, 1.0, -1.0)
        self._one_side = int(self.sides[0]) if len(players) and (self.sides == self.sides[0]).all() else 0
        self.cycle = np.zeros(self.worlds, np.int64)
        self.late = np.zeros(self.worlds, bool)
        self.memory = np.zeros((self.worlds, COUNTERS), np.int64)
        self.previous_ball = np.zeros((self.worlds, 2))
        self.observation: dict[str, np.ndarray] = {}
        self.place_ball: Callable[..., None] = sim.trainer.place_ball
        self.place_player: Callable[..., None] = sim.trainer.place_player
        self._score = np.zeros((self.worlds, 2), np.int64)
        self._gained = np.zeros((self.worlds, 2), np.int64)
        self._rows = players - 1
        self._records: np.ndarray | None = None

    def seen_by(self, players: np.ndarray) -> Pitch:
        """These worlds as those of other agents, (A,) object numbers, who have observations of their own."""
        other = Pitch(self.sim, players, self.counts, self.region, self.max_cycles)
        other.cycle, other.late, other.memory, other.previous_ball = self.cycle, self.late, self.memory, self.previous_ball
        other._score, other._gained = self._score, self._gained
        return other

    # ------------------------------------------------------------------ at the start of an episode

    def draw(self, worlds: np.ndarray, count: int) -> np.ndarray:
        """`count` numbers in [0, 1) for each of the given worlds, (n, count), from their stream of resets."""
        return self.sim.uniforms(worlds, count, Stream.RESETS)

    def start_at(self, worlds: np.ndarray, start: Any) -> None:
        """Put ball and players of the given worlds where a start state says.

        Parameters
        ----------
        worlds : (n,) int array
        start : mapping
            ``"ball"``: (x, y) or (x, y, vx, vy); ``"left_2"``, ...: (x, y) or (x, y, body); metres, m / cycle, radians in the frame of
            the pitch. Who is not named stays where the task put him.

        Raises
        ------
        ParameterError
            For another form.
        UnknownName
            For somebody who does not play.
        """
        if not isinstance(start, dict):
            raise ParameterError(f"start: expected a dict of places, such as {{'ball': (0, 0)}}, got {type(start).__name__} {start!r:.60}")
        names = ("ball", *(f"left_{k + 1}" for k in range(self.counts[0])), *(f"right_{k + 1}" for k in range(self.counts[1])))
        for name, given in start.items():
            if name not in names:
                raise UnknownName(f"start: {name!r} names nobody here; allowed are {', '.join(names)}")
            sizes = (2, 4) if name == "ball" else (2, 3)
            values = np.asarray(given, np.float64) if np.ndim(given) == 1 else np.zeros(0)
            if values.size not in sizes or not np.isfinite(values).all():
                raise ParameterError(f"start: {name!r} takes {sizes[0]} or {sizes[1]} finite numbers, got {given!r:.60}")
            if np.any(np.abs(values[:2]) > FARTHEST):
                far = " and ".join(f"{v:g}" for v in FARTHEST)
                raise ParameterError(f"start: {name!r} at {given!r:.60}; |x| and |y| of a place are at most {far} m")
            if name == "ball":
                self.place_ball(*values, worlds=worlds)
            else:
                side, unum = name.split("_")
                player = int(unum) + (0 if side == "left" else 11)
                self.place_player(player, *values, velocity=(0.0, 0.0), worlds=worlds)

    # ------------------------------------------------------------------ what the cycle brought

    def crossed_goal_line(self, right: bool) -> np.ndarray:
        """(W,) bool: the ball went through the right (or left) goal in the cycle just played (specification/simulator.md 7.8)."""
        line = self.packed["out_x"]
        now, before = self.sim.world["pos"][:, 0], self.previous_ball
        x, x0 = (now[:, 0], before[:, 0]) if right else (-now[:, 0], -before[:, 0])
        over = (x > line) & (x0 <= line)
        share = np.where(over, (line - x0) / np.where(over, x - x0, 1.0), 0.0)
        y = before[:, 1] + share * (now[:, 1] - before[:, 1])
        return np.asarray(over & (np.abs(y) <= self.packed["post_y"]))

    def goals_scored(self) -> np.ndarray:
        """(W, 2) goals of left and right in the cycle just played."""
        return self._gained

    def kickable(self, player: int) -> np.ndarray:
        """(W,) bool: the ball is within the player's reach (specification/simulator.md 3.6)."""
        out: np.ndarray = np.empty(self.worlds, np.bool_)
        kernels.kickable_by(self.sim.world, self.sim.packed, player, 1, out)
        return out

    def kickable_by(self, side: int) -> np.ndarray:
        """(W,) bool: the ball is within the reach of a player of the left (+1) or right (-1) side."""
        first, count = (1, self.counts[0]) if side == LEFT else (12, self.counts[1])
        out: np.ndarray = np.empty(self.worlds, np.bool_)
        kernels.kickable_by(self.sim.world, self.sim.packed, first, count, out)
        return out

    def of_sides(self, left: np.ndarray, right: np.ndarray) -> np.ndarray:
        """(W, A): `left` for the agents of the left side, `right` for those of the right one; both (W,)."""
        if self._one_side:
            return (left if self._one_side > 0 else right)[:, None].repeat(len(self.players), axis=1)
        return np.where(self.sides > 0, left[:, None], right[:, None])

    # ------------------------------------------------------------------ where everything is

    def side(self, player: int) -> int:
        """+1 for left players, -1 for right ones."""
        return LEFT if player <= 11 else RIGHT

    def distance(self, first: int, second: int) -> np.ndarray:
        """(W,) distance between two objects, metres."""
        d = self.sim.world["pos"][:, first] - self.sim.world["pos"][:, second]
        return np.hypot(d[:, 0], d[:, 1])

    def heading(self, player: int) -> np.ndarray:
        """(W,) direction of the player's face, radians in [-pi, pi)."""
        w = self.sim.world
        return wrapped(w["body"][:, player - 1] + w["neck"][:, player - 1])

    @property
    def time_left(self) -> np.ndarray:
        """(W,) cycles until the episode is truncated."""
        return self.max_cycles - self.cycle

    def remembered(self) -> np.ndarray:
        """(W, 22) records of what the agents remember (`players.memory.MEMORY`); rows of others mean nothing.

        Raises
        ------
        UnknownName
            When nobody keeps a memory here.
        """
        if self._records is None:
            raise UnknownName("no memory is kept here; ask for include=('memory',), a preset made from memory or the macro view")
        return self._records


def wrapped(angle: np.ndarray) -> np.ndarray:
    """Angles in [-pi, pi)."""
    return np.asarray((angle + math.pi) % (2 * math.pi) - math.pi)
