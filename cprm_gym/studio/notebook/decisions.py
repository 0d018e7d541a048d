"""Decisions in a notebook: what an agent was told, what it believed, what fired and what it sent."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any
from xml.sax.saxutils import escape

from ...architecture.cprm.runner import Decision
from ...architecture.petri import PetriNet
from ...architecture.petri.drawing.picture import Unfold
from ...architecture.petri.drawing.plan import drawing_plan
from .nets import MOST, SCRIPTS
from .view import View, page_of

LINE, WIDTH, COLUMN = 16, 760, 250


def show_decisions(decisions: Sequence[Decision], net: PetriNet | None, unfold: Unfold, height: int) -> View:
    """One decision, or a slider through several; with the net that made them, its marking beside."""
    chosen = list(decisions)[-MOST:]
    data: dict[str, Any] = {"plans": [drawing_plan(net, unfold)] if net is not None else [], "steps": [_said(d) for d in chosen]}
    return View(_svg(chosen[-1]), page_of(f"cycle {chosen[-1].cycle}", data, "showNet(data);", SCRIPTS), height)


def _said(decision: Decision) -> dict[str, Any]:
    return {
        "cycle": int(decision.cycle),
        "marking": _numbers(decision.marking),
        "whole": True,
        "fired": list(decision.fired),
        "enabled": list(decision.enabled),
        "told": {
            "commands": {name: _numbers(params) for name, params in decision.commands.items()},
            "relations": list(decision.relations),
            "beliefs": _numbers(decision.beliefs),
            "evidence": {name: value for name, value in _numbers(decision.evidence).items() if value is not None},
        },
    }


def _numbers(values: Mapping[str, float | None]) -> dict[str, float | None]:
    return {name: None if v is None or not math.isfinite(v) else float(f"{float(v):.5g}") for name, v in values.items()}


def _svg(decision: Decision) -> str:
    """The decision as lists, column by column."""
    commands = [f"{name}({', '.join(f'{k} {v:.4g}' for k, v in params.items())})" for name, params in decision.commands.items()]
    seen = {name: value for name, value in decision.evidence.items() if value is not None}
    columns = [
        [("observed", [f"{name} = {_short(value)}" for name, value in seen.items()])],
        [("relations", list(decision.relations)), ("beliefs", [f"{name} = {_short(value)}" for name, value in decision.beliefs.items()])],
        [("fired", list(decision.fired)), ("enabled, not fired", list(decision.enabled)), ("sent", commands)],
    ]
    body, tallest = [], 0.0
    for k, groups in enumerate(columns):
        y = 44.0
        for title, lines in groups:
            body.append(f'<text x="{12 + k * COLUMN}" y="{y:.0f}" font-weight="bold">{escape(title)}</text>')
            for line in lines or ["nothing"]:
                y += LINE
                shown = line if len(line) <= 40 else line[:39] + "…"
                body.append(f'<text x="{20 + k * COLUMN}" y="{y:.0f}">{escape(shown)}</text>')
            y += 1.6 * LINE
        tallest = max(tallest, y)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{tallest:.0f}" viewBox="0 0 {WIDTH} {tallest:.0f}" '
        'font-family="Helvetica, Arial, sans-serif" font-size="11" fill="#1f2933">'
        '<rect width="100%" height="100%" fill="white"/>'
        f'<text x="12" y="20" font-size="13" font-weight="bold">cycle {decision.cycle}</text>' + "".join(body) + "</svg>\n"
    )


def _short(value: float) -> str:
    return f"{value:.4g}"
