"""Small multiples as inline SVG: players in rows with intervals, and curves, both labelled where they are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape

from ..pieces import Curves, Dots

COLOURS = {
    "cprm": "#0072B2", "net": "#0072B2", "fsm": "#B8860B", "subsumption": "#56B4E9", "behavior_tree": "#009E73", "code": "#D55E00",
    "belief_region": "#CC79A7", "policy": "#7A3E9D", "scripted": "#555555", "random": "#999999",
    "frozen": "#999999", "memory": "#B8860B", "tracker": "#009E73", "belief": "#0072B2", "state": "#555555",
    "product machine": "#B8860B",
}  # fmt: skip
"""One colour for a player everywhere, after Okabe and Ito's palette for all kinds of colour vision; tiers have theirs in their curves."""
OTHER = "#333333"
WIDTH, LEFT, RIGHT, ROW = 380, 138, 46, 17
PLOT_HEIGHT, PLOT_LEFT, PLOT_RIGHT = 190, 40, 112


def colour(name: str) -> str:
    """Of a player: that of what it is made from; players that share one differ by dashes or hollow marks."""
    for known in sorted(COLOURS, key=len, reverse=True):
        if name.startswith(known):
            return COLOURS[known]
    return OTHER


def plain(name: str) -> bool:
    """Whether a name is that of a colour itself."""
    return name in COLOURS and name != "net"


def _number(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"


def _end(value: float) -> float:
    """A round number that is not below: where an axis ends."""
    if value <= 0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(value))
    return next(step * power for step in (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0) if step * power >= value - 1e-12)


def dots(panel: Dots) -> str:
    """Rows of values with intervals."""
    rows, top = panel.rows, 24
    most = panel.most or _end(max((high for *_, high in rows), default=1.0))
    lowest = min((low for *_, low, _ in rows), default=0.0)
    least = -_end(-lowest) if lowest < 0 and not panel.most else 0.0
    height = top + ROW * len(rows) + 26
    span = WIDTH - LEFT - RIGHT

    def x(value: float) -> float:
        return LEFT + span * (min(max(value, least), most) - least) / (most - least)

    parts = [_open(WIDTH, height, panel.title), _title(panel.title)]
    bottom = top + ROW * len(rows)
    for tick in (least, 0.0, most) if least < 0 else (0.0, most / 2, most):
        parts.append(f'<line class="grid" x1="{x(tick):.1f}" x2="{x(tick):.1f}" y1="{top}" y2="{bottom}"/>')
        parts.append(_text(x(tick), bottom + 12, _number(tick), "middle", "tick"))
    parts.append(_text(LEFT + span / 2, bottom + 24, panel.x, "middle", "tick"))
    for k, (name, value, low, high) in enumerate(rows):
        y, c = top + ROW * (k + 0.5), colour(name)
        parts.append(_text(LEFT - 6, y + 4, _short(name), "end", "name", c, name))
        parts.append(f'<line x1="{x(low):.1f}" x2="{x(high):.1f}" y1="{y}" y2="{y}" stroke="{c}" stroke-width="2.5" opacity=".55"/>')
        fill = c if plain(name) else "#fff"
        tip = f"<title>{escape(name)}: {value:.4g} ({low:.4g} to {high:.4g})</title>"
        parts.append(f'<circle cx="{x(value):.1f}" cy="{y}" r="4" fill="{fill}" stroke="{c}" stroke-width="1.8">{tip}</circle>')
        parts.append(_text(WIDTH - 4, y + 4, _number(value), "end", "value"))
    return "".join([*parts, "</svg>"])


def curves(panel: Curves) -> str:
    """Lines with intervals, each with its name at its end."""
    top, bottom = 24, 24 + PLOT_HEIGHT
    crowded = max((len(label) for _, label in panel.ticks), default=0) > 5
    height = bottom + (76 if crowded else 34)
    values = [v for s in panel.series for p in s.points for v in (p.low, p.high) if v > 0 or not panel.log]
    if panel.log:
        low, high = float(math.floor(math.log10(min(values, default=1)))), float(math.ceil(math.log10(max(values, default=10))))
    else:
        low, high = 0.0, 100.0 if panel.y.endswith("%") else _end(max(values, default=1.0))
    high = high if high > low else low + 1
    places = [x for x, _ in panel.ticks]
    first, last = min(places), max(places)
    span, across = PLOT_HEIGHT, WIDTH - PLOT_LEFT - PLOT_RIGHT

    def x(value: float) -> float:
        return PLOT_LEFT + 8 + (across - 16) * ((value - first) / (last - first) if last > first else 0.5)

    def y(value: float) -> float:
        at = math.log10(max(value, 10.0**low)) if panel.log else value
        return bottom - span * (min(max(at, low), high) - low) / (high - low)

    parts = [_open(WIDTH, height, panel.title), _title(panel.title)]
    steps = range(int(low), int(high) + 1, max(1, math.ceil((high - low) / 5))) if panel.log else (low, (low + high) / 2, high)
    for tick in steps:
        value = 10.0**tick if panel.log else float(tick)
        parts.append(f'<line class="grid" x1="{PLOT_LEFT}" x2="{PLOT_LEFT + across}" y1="{y(value):.1f}" y2="{y(value):.1f}"/>')
        parts.append(_text(PLOT_LEFT - 4, y(value) + 4, _power(tick) if panel.log else _number(value), "end", "tick"))
    told = -math.inf
    for place, label in panel.ticks:
        if not crowded and x(place) - told < 5.0 + 6.0 * len(label):
            continue  # there is no room for its label
        told = x(place)
        if crowded:
            parts.append(f'<text class="tick" text-anchor="end" transform="translate({x(place) + 4:.1f} {bottom + 12}) rotate(-32)">'
                         f"{escape(label)}</text>")  # fmt: skip
        else:
            parts.append(_text(x(place), bottom + 13, label, "middle", "tick"))
    parts.append(_text(PLOT_LEFT + across / 2, height - 4, panel.x, "middle", "tick"))
    ends: list[tuple[float, str, str]] = []
    for number, series in enumerate(panel.series):
        c = colour(series.name)
        dash = "" if plain(series.name) or series.name == "net" else f' stroke-dasharray="{4 + 2 * (number % 3)} 3"'
        path = " ".join(f"{x(p.x):.1f},{y(p.y):.1f}" for p in series.points)
        parts.append(f'<polyline points="{path}" fill="none" stroke="{c}" stroke-width="2"{dash}/>')
        for p in series.points:
            parts.append(f'<line x1="{x(p.x):.1f}" x2="{x(p.x):.1f}" y1="{y(p.low):.1f}" y2="{y(p.high):.1f}" stroke="{c}" opacity=".5"/>')
            tip = f"<title>{escape(series.name)}, {p.x:g}: {p.y:.4g} ({p.low:.4g} to {p.high:.4g})</title>"
            parts.append(f'<circle cx="{x(p.x):.1f}" cy="{y(p.y):.1f}" r="3" fill="{c}">{tip}</circle>')
        if series.points:
            ends.append((y(series.points[-1].y), series.name, c))
    for place, name, c in _apart(ends, 13.0, top, bottom):
        parts.append(_text(PLOT_LEFT + across + 3, place + 4, _short(name), "start", "name", c, name))
    return "".join([*parts, "</svg>"])


def _apart(ends: Sequence[tuple[float, str, str]], gap: float, top: float, bottom: float) -> list[tuple[float, str, str]]:
    """Labels moved so far apart that they can be read, within the panel where they fit."""
    placed: list[tuple[float, str, str]] = []
    for place, name, c in sorted(ends):
        placed.append((max(place, placed[-1][0] + gap if placed else top), name, c))
    over = placed[-1][0] - bottom if placed else 0.0
    if over <= 0:
        return placed
    limit, moved = bottom, []
    for place, name, c in reversed(placed):
        limit = min(place, limit)
        moved.append((limit, name, c))
        limit -= gap
    return moved[::-1]


_SHORT = {
    "cprm, reflexes": "reflexes", "cprm, no reflexes": "no reflexes", "belief_region on belief, all late": "regions, all late",
    "belief_region on belief, reflexes": "regions, reflexes",
    "belief_region + internal variables": "… + internal variables", "cprm without recovery": "without recovery",
    "cprm without recovery watched": "… + watchdog",
}  # fmt: skip


def _short(name: str) -> str:
    return _SHORT.get(name, name)


def _power(tick: float) -> str:
    return {0: "1", 1: "10", 2: "100", 3: "1000"}.get(int(tick), f"1e{int(tick)}")


def _open(width: int, height: float, title: str) -> str:
    size = f'viewBox="0 0 {width} {height:.0f}" width="{width}" height="{height:.0f}"'
    return f'<svg {size} role="img" aria-label="{escape(title, quote=True)}">'


def _title(text: str) -> str:
    return _text(0, 13, text, "start", "title")


def _text(x: float, y: float, text: str, anchor: str, kind: str, fill: str = "", tip: str = "") -> str:
    style = f' fill="{fill}"' if fill else ""
    more = f"<title>{escape(tip)}</title>" if tip and tip != text else ""
    return f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{style}>{escape(text)}{more}</text>'


STYLE = (
    "svg{font:12px sans-serif}.title{font-weight:600;font-size:13px}.tick{fill:#555;font-size:11px}.grid{stroke:#e4e4e4}"
    ".value{font-size:11px;fill:#333}"
)
GAP = 20


def sheet(panels: Sequence[Curves | Dots], columns: int = 3) -> str:
    """Panels side by side in one picture of its own."""
    drawn = [dots(p) if isinstance(p, Dots) else curves(p) for p in panels]
    heights = [float(text.split('height="', 1)[1].split('"', 1)[0]) for text in drawn]
    parts, y = [], float(GAP)
    for first in range(0, len(drawn), columns):
        for k, text in enumerate(drawn[first : first + columns]):
            parts.append(text.replace("<svg ", f'<svg x="{GAP + k * (WIDTH + GAP)}" y="{y:.0f}" ', 1))
        y += max(heights[first : first + columns]) + GAP
    width = GAP + min(columns, len(drawn)) * (WIDTH + GAP)
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {y:.0f}" width="{width}" height="{y:.0f}">'
    return f'{head}<style>{STYLE}</style><rect width="100%" height="100%" fill="#fff"/>{"".join(parts)}</svg>\n'
