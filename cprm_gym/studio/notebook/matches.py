"""Matches in a notebook: frames of a game log, with a slider."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

import numpy as np

from ...errors import FormatError
from ...simulator.gamelog.frames import Frame
from ...simulator.gamelog.reader import GameLogReader
from ...simulator.parameters import ServerParameters
from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH, PENALTY_AREA_LENGTH, PENALTY_AREA_WIDTH
from .nets import SCRIPTS
from .view import View, page_of

MOST = 1500
"""Most frames in one page; of more, every so-manieth."""
TRAIL = 60
"""Frames of the ball's trail in the picture."""
MARGIN = 3.0
GREY = "#777777"
COLOURS = {1: "#c08a00", -1: "#0072b2"}


def show_match(source: str | os.PathLike[str] | Iterable[Frame], height: int) -> View:
    """A match: a path of a game log of any version, or frames."""
    frames = list(GameLogReader(source) if isinstance(source, str | os.PathLike) else source)
    if not frames:
        raise FormatError(f"{source}: no frames in it")
    kept = frames[:: -(-len(frames) // MOST)]
    told = [_said(frame) for frame in kept]
    title = f"cycle {frames[-1].time}"
    svg = field_svg(told[-1], [step["ball"] for step in told[-TRAIL:]])
    marks = {"x": HALF_LENGTH, "y": HALF_WIDTH, "area": [PENALTY_AREA_LENGTH, PENALTY_AREA_WIDTH], "goal": ServerParameters().goal_width}
    return View(svg, page_of(title, {"steps": told, "pitch": marks}, "showMatch(data);", SCRIPTS), height)


def _said(frame: Frame) -> dict[str, Any]:
    players = []
    for row in frame.players:
        if row["state"] and np.isfinite(row["pos"]).all():
            body = float(row["body"]) if np.isfinite(row["body"]) else 0.0
            players.append(
                [int(row["side"]), int(row["unum"]), round(float(row["pos"][0]), 2), round(float(row["pos"][1]), 2), round(body)]
            )
    ball = [round(float(v), 2) if np.isfinite(v) else 0.0 for v in frame.ball[:2]]
    score = [int(frame.left.score), int(frame.right.score)]
    return {"cycle": int(frame.time), "mode": frame.mode.name.lower(), "ball": ball, "players": players, "score": score}


def field_svg(step: dict[str, Any], trail: list[list[float]]) -> str:
    """The field with players and ball, and where the ball came from."""
    x, y = HALF_LENGTH + MARGIN, HALF_WIDTH + MARGIN
    line = 'fill="none" stroke="#7d9a7a" stroke-width="0.3"'
    area = "".join(
        f'<rect x="{side:.2f}" y="{-PENALTY_AREA_WIDTH / 2:.2f}" width="{PENALTY_AREA_LENGTH}" height="{PENALTY_AREA_WIDTH}" {line}/>'
        for side in (-HALF_LENGTH, HALF_LENGTH - PENALTY_AREA_LENGTH)
    )
    players = "".join(
        f'<g transform="translate({px} {py})"><circle r="1.3" fill="{COLOURS.get(side, "#777")}" stroke="#222" stroke-width="0.15"'
        f"{'' if side == 1 else ' stroke-dasharray=' + chr(34) + '0.6 0.3' + chr(34)}/>"
        f'<path d="M0 0 H1.8" stroke="#222" stroke-width="0.3" transform="rotate({body})"/>'
        f'<text y="0.5" font-size="1.5" text-anchor="middle" fill="white">{unum}</text></g>'
        for side, unum, px, py, body in step["players"]
    )
    path = " ".join(f"{bx},{by}" for bx, by in trail)
    (ball_x, ball_y), (left, right) = step["ball"], step["score"]
    said = f"cycle {step['cycle']}  {step['mode']}  {left}:{right}"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="840" viewBox="{-x} {-y} {2 * x} {2 * y}"'
        ' font-family="Helvetica, Arial, sans-serif">'
        f'<rect x="{-x}" y="{-y}" width="{2 * x}" height="{2 * y}" fill="#e9f1e7"/>'
        f'<rect x="{-HALF_LENGTH}" y="{-HALF_WIDTH}" width="{2 * HALF_LENGTH}" height="{2 * HALF_WIDTH}" {line}/>'
        f'<path d="M0 {-HALF_WIDTH} V{HALF_WIDTH}" {line}/>{area}'
        f'<polyline points="{path}" fill="none" stroke="#555" stroke-width="0.25" stroke-dasharray="0.8 0.5"/>{players}'
        f'<circle cx="{ball_x}" cy="{ball_y}" r="0.7" fill="white" stroke="#111" stroke-width="0.25"/>'
        f'<text x="{-HALF_LENGTH}" y="{-HALF_WIDTH - 0.7}" font-size="2" fill="#333">{said}</text></svg>\n'
    )
