"""A run drawn: on the pitch as a film, and what the net did meanwhile. SVG that moves by itself, without a script."""

from __future__ import annotations

import html
from collections.abc import Sequence

import numpy as np

from ...agents.worlds.runs import FilmedRun

WIDTH = 720
SECONDS = 0.12
"""Of the film for each cycle."""
COLOURS = ("#c33", "#2563b8", "#c08a1a")
"""Of the ball and the players."""
NAMES = ("ball", "player", "team-mate")
RADII = (0.35, 0.6, 0.6)
"""As they are drawn, m; they are smaller."""
FONT = 'font-family="DejaVu Sans, sans-serif"'
ROW = 15
"""Height of a line of the net's picture."""


def pitch_film(film: FilmedRun) -> str:
    """The run on the pitch: ways as lines, players moving along them, each command where it was given."""
    moved = np.ptp(film.places, axis=0).max(axis=1) > 0.0
    near = [k for k in range(film.places.shape[1]) if k < 2 or moved[k] or _close(film, k)]
    points = film.places[:, near].reshape(-1, 2)
    low, high = points.min(axis=0) - 3.0, points.max(axis=0) + 3.0
    width, height = np.maximum(high - low, 8.0)
    scale = WIDTH / width
    parts = [
        f'<svg viewBox="0 0 {WIDTH} {height * scale + 24:.0f}" width="{WIDTH}" role="img" aria-label="the run on the pitch" {FONT}>',
        f'<rect width="{WIDTH}" height="{height * scale:.0f}" fill="#e9f2e4"/>',
    ]
    for metre in range(int(np.ceil(low[0] / 5.0)) * 5, int(high[0]) + 1, 5):
        x = (metre - low[0]) * scale
        parts.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="0" y2="{height * scale:.1f}" stroke="#cfdcc8"/>')
        parts.append(f'<text x="{x + 2:.1f}" y="{height * scale - 3:.0f}" font-size="10" fill="#789">{metre} m</text>')
    last = len(film.places) - 1
    duration = f"{max(last, 1) * SECONDS:.2f}s"
    for k in near:
        xy = (film.places[:, k] - low) * scale
        colour, radius = COLOURS[k], RADII[k] * scale
        line = " ".join(f"{x:.1f},{y:.1f}" for x, y in xy)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="1.5" opacity="0.5"/>')
        parts.append(f'<circle cx="{xy[0, 0]:.1f}" cy="{xy[0, 1]:.1f}" r="{radius:.1f}" fill="none" stroke="{colour}"/>')
        faces = ""
        if k:
            turns = np.degrees(np.unwrap(film.bodies[:, k]))
            ahead = f'<line x1="0" y1="0" x2="{1.6 * radius:.1f}" y2="0" stroke="{colour}" stroke-width="3"/>'
            faces = f'<g transform="rotate({turns[-1]:.0f})">{ahead}{_moving("rotate", [f"{a:.0f}" for a in turns], duration)}</g>'
        moves = _moving("translate", [f"{x:.1f},{y:.1f}" for x, y in xy], duration)
        body = f'<circle r="{radius:.1f}" fill="{colour}" opacity="0.85"/>'
        parts.append(f'<g transform="translate({xy[-1, 0]:.1f},{xy[-1, 1]:.1f})">{body}{faces}{moves}</g>')
    x = 4
    for k in near:
        parts.append(f'<circle cx="{x + 5}" cy="{height * scale + 13:.0f}" r="5" fill="{COLOURS[k]}"/>')
        parts.append(f'<text x="{x + 14}" y="{height * scale + 17:.0f}" font-size="12">{NAMES[k]}</text>')
        x += 90
    parts.append(
        f'<text x="{x + 10}" y="{height * scale + 17:.0f}" font-size="12" fill="#556">{last} cycles; rings: the start</text></svg>'
    )
    return "".join(parts)


def _moving(kind: str, values: Sequence[str], duration: str) -> str:
    """What lets a group move through values again and again."""
    return (
        f'<animateTransform attributeName="transform" type="{kind}" values="{";".join(values)}" dur="{duration}" repeatCount="indefinite"/>'
    )


def _close(film: FilmedRun, k: int) -> bool:
    """Whether one who stands still stands where it happens."""
    gap = film.places[:, k] - film.places[:, 0]
    return bool((np.hypot(gap[:, 0], gap[:, 1]) < 25.0).any())


def net_film(film: FilmedRun) -> str:
    """The run of the net: a line for each place whose tokens change, a cell for each cycle in which it holds some; below, the commands."""
    first = film.marked[0]
    every = dict.fromkeys(n for row in film.marked for n in row)
    names = [n for n in every if any(row.get(n) != first.get(n) for row in film.marked)]
    sent = list(dict.fromkeys(c for row in film.commands for c in row))
    left, cycles = 210, len(film.marked)
    step = (WIDTH - left) / max(cycles, 1)
    height = ROW * (len(names) + len(sent) + 2)
    parts = [f'<svg viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" role="img" aria-label="the run of the net" font-size="11" {FONT}>']
    for t in range(0, cycles, 5):
        x = left + t * step
        parts.append(f'<line x1="{x:.1f}" x2="{x:.1f}" y1="0" y2="{height - ROW}" stroke="#ddd"/>')
        parts.append(f'<text x="{x + 1:.1f}" y="{height - 4}" fill="#789">{t}</text>')
    rows: list[tuple[str, Sequence[float], str]] = [(n, [row.get(n, 0.0) for row in film.marked], "#5b7fb5") for n in names]
    rows += [(c, [float(c in row) for row in film.commands], "#c36f2b") for c in sent]
    for line, (name, values, colour) in enumerate(rows):
        y = ROW * line
        parts.append(f'<text x="{left - 6}" y="{y + ROW - 4}" text-anchor="end">{html.escape(name)}</text>')
        for t, value in enumerate(values):
            if value:
                x = left + t * step
                parts.append(f'<rect x="{x:.1f}" y="{y + 2}" width="{max(step - 0.6, 0.8):.1f}" height="{ROW - 4}" fill="{colour}"/>')
                if value > 1 and step > 8:
                    parts.append(f'<text x="{x + step / 2:.1f}" y="{y + ROW - 4}" text-anchor="middle" fill="#fff">{value:g}</text>')
    return "".join(parts) + "</svg>"
