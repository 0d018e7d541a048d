"""LostAndFound: the ball leaves the view, rolling on behind the player or kicked away unseen, and has to be reached in time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...errors import ParameterError
from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ...simulator.player_types import PlayerType
from ...simulator.state import LEFT, Count, PlayMode, ViewWidth
from ..pitch import Pitch
from .base import Outcome, Status, Task, within

_DEADLINE, _KICKS = 0, 1
PACE, GETTING_READY = 0.95, 2.0
"""Share of the top speed that a player makes, and the cycles that he loses by turning and getting up speed."""
MOVES = 0.3
"""m / cycle from which a ball rolls."""
LONGEST = 400
"""Cycles after which a ball lies still, whatever its speed was."""


@dataclass(frozen=True)
class LostAndFound(Task):
    """A player sees the ball once, then it is out of his narrow view; he must remember, predict, look and reach it in time.

    Description
    -----------
    One player, one ball, no referee. His view is narrow (60 degrees, a look in every cycle) when the episode begins. In `kicked` of the
    episodes the ball lies at the feet of an opponent who kicks it away when it occurs to him (policy ``knock``); in the others it rolls
    past the player and on behind him.

    Actions
    -------
    Any action view; when and where to turn the neck is what is to be decided.

    Observations
    ------------
    The common schema; nothing is added.

    Rewards
    -------
    1 in the cycle in which the ball becomes kickable for the player, else 0; -1 for the opponent.

    Start
    -----
    The player stands within 20 m of the middle of the pitch along it and 12 m across, looking anywhere; the ball is `near` to `far` metres
    away, at most 20 degrees off the way that he looks, so that he sees it once. A rolling ball passes him 1.5 to 4 m aside, at `slow` to
    `fast` m / cycle, and would come to rest on the pitch (the best of 8 starts that are drawn). The opponent with the ball stands behind
    it; where it rolls, he stands 40 m away.

    End
    ---
    SUCCESS: the ball is kickable for the player. TAKEN: somebody who always knows where it is, starting from where the player was when it
    was last set rolling and `grace` cycles later, would have it by now (`time_needed`). OUT_OF_TIME after `max_cycles`. Whatever is not the
    player's success is the opponent's.
    """

    name: str = "LostAndFound"
    right: int = 1
    others: str | tuple[str, str] = "knock"
    max_cycles: int = 100
    statuses: tuple[Status, ...] = (Status.SUCCESS, Status.TAKEN, Status.OUT_OF_TIME)
    terms: tuple[str, ...] = ("reached",)
    near: float = within(5.0, 1.0, 20.0)
    far: float = within(8.0, 1.0, 20.0)
    slow: float = within(1.6, 0.0, 3.0)
    fast: float = within(2.4, 0.0, 3.0)
    grace: float = within(4.0, 0.0, 1000.0)
    kicked: float = within(0.5, 0.0, 1.0)
    tries: int = within(8, 1, 1000)

    def __post_init__(self) -> None:
        """Refuse distances and speeds in the wrong order."""
        super().__post_init__()
        for low, high in (("near", "far"), ("slow", "fast")):
            if getattr(self, low) > getattr(self, high):
                allowed = f"numbers up to {high}, {getattr(self, high):g}"
                raise ParameterError(f"task {self.name!r}: {low}: {getattr(self, low):g} given; allowed are {allowed}")

    def setup(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """Draw player, ball and opponent."""
        n, row = len(worlds), np.arange(len(worlds))
        kicked = pitch.draw(worlds, 1)[:, 0] < self.kicked
        u = pitch.draw(worlds, 8 * self.tries).reshape(n, self.tries, 8)
        player = np.stack([20.0 * (2 * u[..., 0] - 1), 12.0 * (2 * u[..., 1] - 1)], axis=-1)
        face = math.pi * (2 * u[..., 2] - 1)
        way = face + math.radians(20.0) * (2 * u[..., 3] - 1)
        distance = self.near + (self.far - self.near) * u[..., 4]
        ball = player + distance[..., None] * np.stack([np.cos(way), np.sin(way)], axis=-1)
        # the point beside him that a rolling ball passes
        aside = np.where(u[..., 5] < 0.5, -1.0, 1.0) * (1.5 + 2.5 * u[..., 6])
        passed = player + aside[..., None] * np.stack([-np.sin(way), np.cos(way)], axis=-1)
        heading = (passed - ball) / np.linalg.norm(passed - ball, axis=-1, keepdims=True)
        speed = self.slow + (self.fast - self.slow) * u[..., 7]
        rest = ball + (speed / (1.0 - self.parameters.ball_decay))[..., None] * heading
        outside = np.maximum(np.abs(rest) - (HALF_LENGTH - 1.0, HALF_WIDTH - 1.0), 0.0).max(axis=-1)
        pick = outside.argmin(axis=1)
        player, face, ball, heading, speed = (values[row, pick] for values in (player, face, ball, heading, speed))
        way = way[row, pick]
        velocity = np.where(kicked[:, None], 0.0, speed[:, None] * heading)
        pitch.sim.world["mode"][worlds] = PlayMode.play_on
        pitch.place_ball(*ball.T, *velocity.T, worlds=worlds)
        pitch.place_player(1, *player.T, face, worlds=worlds)
        pitch.sim.world["view_width"][worlds, 0] = ViewWidth.NARROW
        behind = ball + 0.7 * np.stack([np.cos(way), np.sin(way)], axis=1)
        far_off = np.stack([player[:, 0] - 40.0 * np.sign(player[:, 0]), 0.0 * way], axis=1)
        for number in range(12, 12 + self.right):
            stands = np.where(kicked[:, None], behind, far_off) if number == 12 else far_off + [0.0, 3.0 * (number - 12)]
            pitch.place_player(number, *stands.T, np.arctan2(-np.sin(way), -np.cos(way)), worlds=worlds)

    def outcome(self, pitch: Pitch) -> Outcome:
        """Done when the player can kick the ball, or would have had to."""
        kicks = pitch.sim.world["counts"][:, 11 : 11 + self.right, Count.KICK].sum(axis=1)
        touched = (kicks > pitch.memory[:, _KICKS]) | (pitch.cycle == 1)
        set_rolling = np.flatnonzero(touched & (np.hypot(*pitch.sim.world["vel"][:, 0].T) > MOVES))
        pitch.memory[:, _KICKS] = kicks
        if len(set_rolling):
            pitch.memory[set_rolling, _DEADLINE] = pitch.cycle[set_rolling] + self.grace + time_needed(pitch, set_rolling)
        found = pitch.kickable_by(LEFT)
        deadline = pitch.memory[:, _DEADLINE]  # 0 while the ball lies
        taken = (deadline > 0) & (pitch.cycle >= deadline) & ~found
        reward = found[:, None] * pitch.sides
        status = np.select([found, taken], [int(Status.SUCCESS), int(Status.TAKEN)], 0)
        return Outcome(reward, status > 0, pitch.of_sides(found, taken | (pitch.late & ~found)), status, {"reached": reward})


def time_needed(pitch: Pitch, worlds: np.ndarray) -> np.ndarray:
    """(n,) cycles in which the first player of the left side could be at the rolling ball of the given worlds, if he knew where it goes.

    The smallest t at which he has run as far as the ball, free and without noise, is then away from where he is now; a default player.
    """
    p, world = pitch.parameters, pitch.sim.world
    kind = PlayerType.default(p)
    pace = PACE * min(kind.real_speed_max(p.max_dash_power), kind.player_speed_max)
    reach = kind.player_size + p.ball_size + kind.kickable_margin
    t = np.arange(LONGEST)
    rolled = (1.0 - p.ball_decay**t) / (1.0 - p.ball_decay) if p.ball_decay < 1.0 else t.astype(np.float64)
    ball = world["pos"][worlds, 0, None] + rolled[:, None] * world["vel"][worlds, 0, None]
    way = np.linalg.norm(ball - world["pos"][worlds, 1, None], axis=-1) - reach
    there = way <= pace * np.maximum(t - GETTING_READY, 0.0)
    return np.where(there.any(axis=1), there.argmax(axis=1), LONGEST)
