"""Kernels of what tasks ask the worlds."""

from __future__ import annotations

from ...simulator.player_types import T_KICKABLE_MARGIN, T_PLAYER_SIZE
from ...simulator.state import PlayMode
from . import kernel

PLAYERS = 22
TIME_OVER = int(PlayMode.time_over)


@kernel
def open_eyes(worlds, chosen):
    """Give every player of the chosen worlds a look at once; the next one comes after a full interval of his view."""
    for k in range(chosen.shape[0]):
        w = worlds[chosen[k]]
        for i in range(PLAYERS):
            w.saw[i] = w.enabled[i]
            w.see_counter[i] = 0


@kernel
def tally(worlds, max_cycles, cycle, score, gained, late):
    """Count the cycle just played and the goals scored in it; True if time has run out in any world.

    cycle : (W,); score, gained : (W, 2); late : (W,) bool, which worlds have no time left
    """
    any_late = False
    for n in range(cycle.shape[0]):
        w = worlds[n]
        cycle[n] += 1
        late[n] = cycle[n] >= max_cycles
        any_late |= late[n]
        for side in range(2):
            gained[n, side] = w.score[side] - score[n, side]
            score[n, side] = w.score[side]
    return any_late


@kernel
def match_outcome(worlds, gained, sides, reward, over, won):
    """A match: goals of the agents' own side less those of the other, whether it is over and whether the agent's side has won.

    gained : (W, 2); sides : (A,) +1 or -1; reward : (W, A); over : (W,) bool; won : (W, A) bool
    """
    for n in range(worlds.shape[0]):
        w = worlds[n]
        difference = gained[n, 0] - gained[n, 1]
        over[n] = w.mode == TIME_OVER
        for k in range(sides.shape[0]):
            reward[n, k] = difference * sides[k]
            won[n, k] = over[n] and (w.score[0] - w.score[1]) * sides[k] > 0


@kernel
def in_reach(w, p, first, count):
    """Whether one of `count` players from object number `first` on can kick the ball of one world (specification/simulator.md 3.6)."""
    for player in range(first, first + count):
        i = player - 1
        kind = w.type[i]
        reach = p.types[kind, T_PLAYER_SIZE] + p.ball_size + p.types[kind, T_KICKABLE_MARGIN]
        dx, dy = w.pos[player, 0] - w.pos[0, 0], w.pos[player, 1] - w.pos[0, 1]
        if w.enabled[i] > 0 and dx * dx + dy * dy <= reach * reach:
            return True
    return False


@kernel
def kickable_by(worlds, packed, first, count, out):
    """Whether one of `count` players from object number `first` on can kick the ball, for every world."""
    for n in range(worlds.shape[0]):
        out[n] = in_reach(worlds[n], packed[0], first, count)


@kernel
def race_outcome(worlds, packed, left, right, sides, status, reward, over, won, statuses):
    """A race to the ball: 1 for the agents of the side that alone can kick it, -1 for the others; over when anybody can.

    left, right : number of players of each side; sides : (A,) +1 or -1; status : of a race that is over; reward : (W, A); over : (W,) bool;
    won : (W, A) bool, the agent's side can kick the ball; statuses : (W,) int
    """
    for n in range(worlds.shape[0]):
        ours = in_reach(worlds[n], packed[0], 1, left)
        theirs = in_reach(worlds[n], packed[0], PLAYERS // 2 + 1, right)
        over[n] = ours or theirs
        statuses[n] = status if over[n] else 0
        worth = (1.0 if ours else 0.0) - (1.0 if theirs else 0.0)
        for k in range(sides.shape[0]):
            reward[n, k] = worth * sides[k]
            won[n, k] = ours if sides[k] > 0.0 else theirs
