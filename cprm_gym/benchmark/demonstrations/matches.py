"""What holders of the ball are about to do in recorded matches: learned from some game logs, measured on others.

``python -m cprm_gym.benchmark.demonstrations.matches LEARNED.rcg.gz... --held-out OTHER.rcg.gz`` learns from the true places that logs
hold, of both goals, and tells how well shots of the others are foreseen: by these tables, and by those of own play.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...agents.body import DEFAULT
from ...agents.intention import MODES, learned
from ...agents.intention.situation import GOAL_X, situation, touch, view
from ...agents.intention.tier import HELD
from ...errors import CprmError
from ...simulator.gamelog.frames import LOG_COUNTS, Frame
from ...simulator.gamelog.reader import GameLogReader
from ...simulator.state import PlayMode
from .learning import FAST, UNSEEN, WIDE, Log, joined, learn, report

NEAR = 35.0
"""Metres from the goal within which it is asked what the holder of the ball is about to do."""
LEFTS = slice(0, 11)
KICK = LOG_COUNTS.index("kick")


def stretches(path: Path) -> list[list[Frame]]:
    """The frames of a log in which play goes on, cycles that follow each other together."""
    found: list[list[Frame]] = []
    last = None
    for frame in GameLogReader(path):
        if frame.mode != PlayMode.play_on:
            last = None
            continue
        if last is None or frame.time != last + 1:
            found.append([])
        found[-1].append(frame)
        last = frame.time
    return [frames for frames in found if len(frames) > 2]


def from_match(path: Path) -> Log:
    """Cycles of a match in which an attacker holds the ball within `NEAR` of either goal, as `learning.logged` gives them.

    Parameters
    ----------
    path : Path
        A game log of any version.

    Raises
    ------
    CprmError
        For what is no game log, or one in which nobody comes near a goal.
    """
    parts = [_attacked(frames, side) for frames in stretches(path) for side in (1.0, -1.0)]
    logs = [part for part in parts if len(part.world)]
    if not logs:
        raise CprmError(f"{path}: nobody holds the ball within {NEAR:g} m of a goal while play goes on")
    return joined(logs)


def _attacked(frames: Sequence[Frame], side: float) -> Log:
    """One stretch of play, at the goal of the left team (1), or, turned round, at that of the right one (-1)."""
    ball = side * np.array([frame.ball for frame in frames])
    players = side * np.array([np.hstack([frame.players["pos"], frame.players["vel"]]) for frame in frames])
    kicks = np.array([frame.players["counts"][:, KICK] for frame in frames])
    defenders, attackers = (LEFTS, slice(11, 22)) if side > 0 else (slice(11, 22), LEFTS)
    there = np.array([frame.players["state"] != 0 for frame in frames])
    goal = np.where(there[:, defenders], np.hypot(players[:, defenders, 0] - GOAL_X, players[:, defenders, 1]), np.inf)
    rows = np.arange(len(frames))
    me = players[:, defenders][rows, goal.argmin(axis=1), :2]
    gap = np.hypot(*(players[..., k] - ball[:, None, k] for k in (0, 1)))
    gap = np.where(there & np.isfinite(gap), gap, np.inf)
    holder = gap[:, attackers].argmin(axis=1)
    held = (gap[:, attackers].min(axis=1) < np.minimum(HELD, gap[:, defenders].min(axis=1))) & (goal.min(axis=1) < np.inf)
    held &= np.hypot(ball[:, 0] - GOAL_X, ball[:, 1]) < NEAR
    done = np.concatenate([[-1], touch(ball[:-1], ball[1:])])
    kicked = np.diff(kicks[:, attackers], axis=0).max(axis=1) > 0
    line, speed, at_goal = _crossing(ball[1:])
    shot = np.append(kicked & at_goal, False)
    since = np.full(len(frames), UNSEEN + 1)
    for k in range(1, len(frames)):
        since[k] = 0 if shot[k - 1] else since[k - 1] + 1
    told = np.flatnonzero(held & (since > UNSEEN) & (rows < len(frames) - 1))
    mine = players[:, attackers][told, holder[told]]
    numbers = situation(ball[told], mine, np.zeros((len(told), 2)), me[told])
    seen = np.hstack([view(ball[told], me[told]), numbers])
    return Log(np.zeros(len(told), np.int64), told, numbers, seen, holder[told], done[told], np.full(len(told), -1), shot[told],
               line[told], speed[told])  # fmt: skip


def _crossing(ball: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of balls (N, 4) just kicked: where they cross the goal line, how fast they were kicked, and whether that is a shot; (N,) each."""
    x, y, vx, vy = ball.T
    speed, towards = np.hypot(vx, vy), np.minimum(vx, -0.2)
    line = y + vy / towards * (GOAL_X - x)
    arrives = (x - GOAL_X) * speed / -towards < speed / DEFAULT.roll + 1.0
    return line, speed / DEFAULT.ball_decay, (vx < -0.2) & (np.abs(line) < DEFAULT.server.goal_width / 2 + WIDE) & arrives & (speed > FAST)


def main() -> None:
    """The command."""
    parser = argparse.ArgumentParser(description="Learn what holders of the ball are about to do from recorded matches.")
    parser.add_argument("learned", nargs="+", type=Path, metavar="LOG")
    parser.add_argument("--held-out", nargs="+", type=Path, required=True, metavar="LOG")
    options = parser.parse_args()
    log, other = (joined([from_match(path) for path in paths]) for paths in (options.learned, options.held_out))
    for what, one in (("learned from", log), ("measured on", other)):
        print(f"{what} {len(one.world)} cycles with {int(one.shot.sum())} shots")
    found = learn(log, True, f"expectation-maximisation over {len(options.learned)} matches, {len(MODES)} modes")
    for name, intention in (("these tables", found), ("tables of own play (shooter)", learned("shooter"))):
        print(f"{name}:\n{report(intention, other)}")


if __name__ == "__main__":
    main()
