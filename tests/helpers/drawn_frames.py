"""Frames of game logs drawn at random, for the tests of their lines."""

from __future__ import annotations

import numpy as np

from cprm_gym.simulator.gamelog.frames import Frame


def drawn_frame(draw: np.random.Generator) -> Frame:
    """Numbers of every size a match can bring, some unknown, some on ties, some without anything."""
    frame = Frame(int(draw.integers(0, 7000)), ball=draw.uniform(-57, 57, 4) * (draw.random(4) < 0.9))
    rows = frame.players
    rows["type"], rows["state"] = draw.integers(-1, 18, 22), draw.integers(0, 2, 22) * draw.integers(0, 2**21, 22)
    for name, size in (("pos", 60), ("vel", 3), ("body", 180), ("neck", 90), ("focus", 180)):
        rows[name] = draw.uniform(-size, size, rows[name].shape) * (draw.random(rows[name].shape) < 0.9)
    rows["pos"][:5] = draw.integers(-500_000, 500_000, (5, 2)) * 1e-4 + 0.5e-4
    pointing = draw.random(22) < 0.3
    rows["point"][pointing] = draw.uniform(-60, 60, (int(pointing.sum()), 2))
    rows["view_quality"], rows["view_width"] = draw.integers(1, 3, 22), draw.choice([60.0, 120.0, 180.0, 90.0, 45.0], 22)
    rows["stamina"], rows["capacity"] = draw.integers(0, 16_000, 22) * 0.5, draw.integers(-2, 261_200, 22) * 0.5
    rows["effort"], rows["recovery"] = draw.uniform(0.6, 1, 22), draw.uniform(0.5, 1, 22)
    rows["attention"], rows["counts"] = draw.integers(0, 23, 22), draw.integers(-1, 9000, (22, 12))
    return frame
