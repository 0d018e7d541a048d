"""What a goalie sees of the holder of the ball before he shoots: numbers that his intention is read from."""

from __future__ import annotations

import numpy as np

from ...simulator.pitch import HALF_LENGTH
from ..body import DEFAULT, Body

FEATURES = ("gap", "next_gap", "reach", "far", "far_there", "speed", "approach", "age", "ball_age", "aside", "run", "blocked", "noise")
"""Of `situation`: metres from holder to ball now and a cycle on, cycles until he has it, metres from the goal now and then, speed of the
ball, its share towards the goal, cycles since holder and ball were seen, metres from the middle, speed of the holder, metres between the
goalie and the way to the middle of the goal."""
VIEW = ("open", "aside", "far", "sideways")
"""Of `view`: by how much the left corner is more open than the right one, y of the ball, its distance from the goal, its y velocity."""
SOON = 12
"""Cycles up to which it is told when the holder has the ball."""
RUNS, AT_FEET = 0.9, 0.8
"""Share of the top speed at which he runs to it; share of the kickable ring at which he has it."""
OLD = 30.0
"""Cycles from which on a look is old, however old."""
GOAL_X = -HALF_LENGTH
"""The own goal line."""
CORNER = 0.87
"""Share of half the goal's width at which a corner is."""


def situation(
    ball: np.ndarray, holder: np.ndarray, ages: np.ndarray, me: np.ndarray, body: Body = DEFAULT, noise: float = 0.0
) -> np.ndarray:
    """The `FEATURES` of holders.

    Parameters
    ----------
    ball : (N, 4) array
        Place and velocity, metres and m / cycle, in the frame of the goalie's team.
    holder : (N, 4) array
    ages : (N, 2) array
        Cycles since holder and ball were seen.
    me : (N, 2) array
        The goalie's place.
    body : Body
        Whose numbers the server's are.
    noise : float
        Of his senses (`Senses`).

    Returns
    -------
    (N, F) float64 array
    """
    near, pace = body.within(AT_FEET), body.pace(RUNS)
    gap = np.hypot(*(ball[:, :2] - holder[:, :2]).T)
    after = ball[:, :2] + ball[:, 2:] - holder[:, :2] - holder[:, 2:]
    reach, there, place, way = np.full(len(ball), float(SOON)), ball[:, :2].copy(), ball[:, :2].copy(), ball[:, 2:].copy()
    for cycles in range(SOON):
        first = (reach == SOON) & (np.hypot(*(place - holder[:, :2]).T) - near <= pace * cycles)
        reach[first], there[first] = cycles, place[first]
        place, way = place + way, way * body.ball_decay
    there[reach == SOON] = place[reach == SOON]
    to_goal = np.stack([GOAL_X - ball[:, 0], -ball[:, 1]], axis=1)
    far = np.hypot(*to_goal.T)
    unit = to_goal / np.maximum(far, 0.5)[:, None]
    mine = me - ball[:, :2]
    blocked = np.abs(mine[:, 0] * unit[:, 1] - mine[:, 1] * unit[:, 0])
    return np.stack(
        [gap, np.hypot(*after.T), reach, far, np.hypot(there[:, 0] - GOAL_X, there[:, 1]), np.hypot(*ball[:, 2:].T),
         (ball[:, 2:] * unit).sum(axis=1), np.minimum(ages[:, 0], OLD), np.minimum(ages[:, 1], OLD), np.abs(ball[:, 1]),
         np.hypot(*holder[:, 2:].T), blocked, np.full(len(ball), noise)],
        axis=1,
    )  # fmt: skip


def view(ball: np.ndarray, me: np.ndarray, body: Body = DEFAULT) -> np.ndarray:
    """What of the goal the holder sees open: `VIEW`.

    Parameters
    ----------
    ball : (N, 4) array
    me : (N, 2) array
        The goalie's place.
    body : Body

    Returns
    -------
    (N, V) float64 array
    """
    corner = CORNER * body.server.goal_width / 2.0
    mine = me - ball[:, :2]
    room = []
    for y in (corner, -corner):
        way = np.stack([np.full(len(ball), GOAL_X) - ball[:, 0], y - ball[:, 1]], axis=1)
        way /= np.maximum(np.hypot(*way.T), 0.5)[:, None]
        across = np.abs(mine[:, 0] * way[:, 1] - mine[:, 1] * way[:, 0])
        along = np.maximum((mine * way).sum(axis=1), 0.0)
        room.append(across - 0.25 * along)  # what he runs until the ball is there, at its speed
    return np.stack([room[0] - room[1], ball[:, 1], np.hypot(ball[:, 0] - GOAL_X, ball[:, 1]), ball[:, 3]], axis=1)


TOUCHES = ("none", "on", "left", "right", "back", "hard")
"""What the last cycle did to the ball: nothing, pushed towards the goal, to the left (y grows) or right, away from it, or hit hard."""
TOUCHED, HARD = 0.35, 1.8
"""m / cycle by which its velocity must differ from its roll to have been touched; its speed after a hard kick."""


def touch(before: np.ndarray, ball: np.ndarray, body: Body = DEFAULT) -> np.ndarray:
    """Index of `TOUCHES`, from two estimates of the ball a cycle apart.

    Parameters
    ----------
    before, ball : (N, 4) arrays
    body : Body

    Returns
    -------
    (N,) int64 array
    """
    change = ball[:, 2:] - body.ball_decay * before[:, 2:]
    touched, fast = np.hypot(*change.T) > TOUCHED, np.hypot(*ball[:, 2:].T) > HARD
    goal = np.arctan2(-ball[:, 1], GOAL_X - ball[:, 0])
    off = (np.arctan2(ball[:, 3], ball[:, 2]) - goal + np.pi) % (2 * np.pi) - np.pi
    side = np.select([np.abs(off) < 0.6, np.abs(off) > 2.0, off < 0], [1, 4, 2], 3)  # facing the own goal, a turn to the right is +y
    return np.where(touched, np.where(fast, 5, side), 0)
