"""Kernels that make the agents' readings worse than the server's: lost, noisy, coarse, without velocities or numbers."""

from __future__ import annotations

import math

from ...simulator.kernels.random import READING_LOST, READING_NOISE, SENSORS, normal, uniform
from ...simulator.kernels.senses import swap_rows
from . import kernel
from .observations import wrapped

PLAYERS = 22
SEEN, MOVING = 2, 3  # levels of the ball and of players
ARM = 6  # column of where a player points


@kernel
def degrade(
    worlds, chosen, rows, cycles, lost, sizes, steps, motion, numbers, fresh, ball, ball_level, players, players_level, flags,
):  # fmt: skip
    """What the agents see of ball and players in the chosen worlds, in place; row c of the senses is world ``chosen[c]``.

    rows : (A,) players; cycles : (W,) cycle of the episode, whose first look is not lost; lost : probability
    sizes : (4,) standard deviations of log distance, direction, distance change, direction change
    steps : (2,) of log distance and of direction (rad) to which they are rounded, 0 not at all
    motion, numbers : bool, whether velocities and uniform numbers are told
    """
    for n in range(chosen.shape[0]):
        w = worlds[chosen[n]]
        first = cycles[chosen[n]] == 0
        for k in range(rows.shape[0]):
            i = rows[k]
            if not fresh[n, i]:
                continue
            if lost > 0.0 and not first and uniform(w, SENSORS, i, READING_LOST, 0) < lost:
                fresh[n, i] = False
                blind(i, ball[n], ball_level[n], players[n], players_level[n], flags[n])
                continue
            ball_level[n, i] = reread(w, i, 0, sizes, steps, motion, ball[n, i], ball_level[n, i])
            for j in range(PLAYERS):
                players_level[n, i, j] = reread(w, i, j + 1, sizes, steps, True, players[n, i, j], players_level[n, i, j])
                if not motion:
                    players[n, i, j, 2], players[n, i, j, 3] = 0.0, 0.0
            if not numbers:
                forget_numbers(i, players[n], players_level[n], flags[n])


@kernel
def blind(i, ball, ball_level, players, players_level, flags):
    """Nothing of what player `i` was told."""
    ball_level[i] = 0
    ball[i, :] = 0.0
    players_level[i, :] = 0
    players[i, :, :] = 0.0
    flags[i, :] = 0


@kernel
def reread(w, i, j, sizes, steps, motion, row, level):
    """Reading `j` of player `i` (0 the ball) with errors and coarser steps, in place; its level."""
    if level == 0:
        return level
    if level >= MOVING and not motion:
        row[2], row[3] = 0.0, 0.0
        level = SEEN
    if sizes[0] > 0.0:
        row[0] *= math.exp(normal(w, SENSORS, i, READING_NOISE, 4 * j, 0.0, sizes[0]))
        row[1] = wrapped(row[1] + normal(w, SENSORS, i, READING_NOISE, 4 * j + 1, 0.0, sizes[1]))
        if level >= MOVING:
            row[2] += normal(w, SENSORS, i, READING_NOISE, 4 * j + 2, 0.0, sizes[2])
            row[3] += normal(w, SENSORS, i, READING_NOISE, 4 * j + 3, 0.0, sizes[3])
    if steps[0] > 0.0:
        if row[0] > 0.0:
            row[0] = math.exp(steps[0] * round(math.log(row[0]) / steps[0]))
        row[1] = wrapped(steps[1] * round(row[1] / steps[1]))
    return level


@kernel
def forget_numbers(i, players, levels, flags):
    """Player `i` sees teams, but no numbers: who was seen with his number stands in a free place of his team, nearest first."""
    for j in range(PLAYERS):
        if levels[i, j] == MOVING:
            levels[i, j] = SEEN
            for f in range(2, ARM):
                players[i, j, f] = 0.0
    for team in range(2):
        for a in range(11 * team, 11 * team + 11):
            best = a
            for b in range(a + 1, 11 * team + 11):
                if a != i and b != i and comes_first(levels[i, b], players[i, b, 0], levels[i, best], players[i, best, 0]):
                    best = b
            if best != a:
                swap_rows(players, levels, flags, i, a, best)


@kernel
def comes_first(level, distance, other_level, other_distance):
    """Whether a row stands before another one: those of known team, then the unknown, then nobody; the nearer first."""
    if level != other_level:
        return level > other_level
    return level > 0 and distance < other_distance
