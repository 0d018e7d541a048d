"""The SVG writer of drawings."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from xml.sax.saxutils import escape

from .labels import place_labels
from .layout import Edge, Node, Point, arrange
from .picture import Box, Item, Link, folded

RADIUS, BAR, THICK = 12.0, 40.0, 7.0  # of places; length and thickness of transitions
INK, GREY, MODULE = "#1f2933", "#6b7785", "#f4f6f8"
FONT, SMALL = 11.0, 9.0
MARGIN, HEADING = 16.0, 24.0
LONGEST = 44  # characters of a detail


@dataclass
class Laid:
    """A box whose inside has been laid out: positions relative to its top left corner."""

    box: Box
    width: float
    height: float
    at: dict[str, Point] = field(default_factory=dict)  # items, of inner boxes too
    items: dict[str, Item] = field(default_factory=dict)
    inner: list[tuple[Laid, Point]] = field(default_factory=list)
    routes: list[tuple[Link, list[Point]]] = field(default_factory=list)


def render(box: Box) -> str:
    """The SVG document of a picture."""
    laid = lay_out(box, outermost=True)
    width, height = laid.width + 2 * MARGIN, laid.height + 2 * MARGIN
    body: list[str] = []
    _draw_boxes(laid, (MARGIN, MARGIN), body)
    drawn: list[tuple[Link, list[Point]]] = []
    _draw_links(laid, (MARGIN, MARGIN), body, drawn)
    _draw_labels(laid, (MARGIN, MARGIN), body, drawn)
    _draw_items(laid, (MARGIN, MARGIN), body)
    return (
        "\n".join(
            [
                f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" viewBox="0 0 {width:.1f} {height:.1f}"'
                f' font-family="Helvetica, Arial, sans-serif" font-size="{FONT:g}">',
                f"<title>{escape(box.title)}</title>",
                "<defs>",
                '<pattern id="hash" width="5" height="5" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">'
                f'<rect width="5" height="5" fill="white"/><rect width="1.4" height="5" fill="{GREY}"/></pattern>',
                "</defs>",
                '<rect width="100%" height="100%" fill="white"/>',
                *body,
                "</svg>",
            ]
        )
        + "\n"
    )


# -- layout -------------------------------------------------------------------------------------------------------------------------


def _text_width(text: str, size: float) -> float:
    return 0.56 * size * len(text)


def _shown(detail: str) -> str:
    return detail if len(detail) <= LONGEST else detail[: LONGEST - 1] + "…"


def _extent(item: Item) -> tuple[float, float, float]:
    """Left and right of the axis, and height."""
    half = BAR / 2 if item.is_transition else RADIUS
    text = max(_text_width(item.label, FONT), _text_width(_shown(item.detail), SMALL))
    return half + 2, half + 8 + text, 2 * RADIUS + 6


def lay_out(box: Box, outermost: bool = False, by_hand: Mapping[str, Mapping[str, Point]] | None = None) -> Laid:
    """Where everything in a box goes, inner boxes first: they are nodes of the layout around them.

    Parameters
    ----------
    box : Box
    outermost : bool
        Without the room for a heading and a margin that a box in another one has.
    by_hand : mapping from key of a box to mapping from name to point, optional
        Positions that somebody chose: of places and transitions their middle, of an inner box its top left corner. Arcs of a box with
        such positions run straight; the outermost box keeps these positions as they are.

    Returns
    -------
    Laid
        Width, height and positions in pixels, from the box's top left corner.
    """
    children = [lay_out(inner, by_hand=by_hand) for inner in box.boxes]
    laid = Laid(box, 0.0, 0.0, items={item.key: item for item in box.items})
    nodes = []
    for item in box.items:
        left, right, height = _extent(item)
        nodes.append(Node(item.key, left, right, height, top=item.key in box.entries, bottom=item.key in box.exits))
    for child in children:
        nodes.append(Node("box " + child.box.key, child.width / 2, child.width / 2, child.height))
        laid.items |= child.items
    owner = {key: "box " + child.box.key for child in children for key in child.items}
    links = [link for link in box.links if link.source in laid.items and link.target in laid.items]
    edges = []
    tops = _tops(children)
    for link in links:
        source, target = (owner.get(end, end) for end in (link.source, link.target))
        if link.style == "fuse" and link.target in tops:
            source, target = owner.get(link.source, link.source), owner[link.target]
        elif link.style == "fuse":
            source, target = target, source
        pull = 1.0 if link.style in ("arc", "set", "fuse") else 0.4
        edges.append(Edge(source, target, pull))
    chosen = (by_hand or {}).get(box.key) or {}
    whole = len(chosen) >= len(nodes) and all(_name(box, node) in chosen for node in nodes)
    width, height = (0.0, 0.0) if whole else arrange(nodes, edges)
    if chosen:
        width, height = _put(box, nodes, chosen, outermost)
        for edge in edges:
            edge.points = []
    top = 0.0 if outermost else HEADING
    pad = 0.0 if outermost else MARGIN
    title = _text_width(box.title, FONT) + 12
    laid.width = max(width + 2 * pad, 0.0 if outermost else title)
    laid.height = height + top + pad
    indent = pad + (0.0 if outermost else max(0.0, laid.width - 2 * pad - width) / 2)
    for node in nodes:
        if node.key in laid.items:
            laid.at[node.key] = (node.x + indent, node.y + top)
    for child, node in zip(children, nodes[len(box.items) :]):
        corner = (node.x - node.left + indent, node.y - node.height / 2 + top)
        laid.inner.append((child, corner))
        laid.at |= {key: (x + corner[0], y + corner[1]) for key, (x, y) in child.at.items()}
    for link, edge in zip(links, edges):
        points = edge.points
        if link.style == "fuse" and edge.source != owner.get(link.source, link.source):
            points = points[::-1]
        laid.routes.append((link, [(x + indent, y + top) for x, y in points]))
    return laid


def _put(box: Box, nodes: Sequence[Node], chosen: Mapping[str, Point], outermost: bool) -> tuple[float, float]:
    """Move nodes to positions chosen by hand; returns width and height from the origin on."""
    for node in nodes:
        inner = node.key.startswith("box ")
        at = chosen.get(_name(box, node))
        if at is not None:
            node.x, node.y = at[0] + (node.left if inner else 0.0), at[1] + (node.height / 2 if inner else 0.0)
    _make_room(box, nodes)
    if not outermost and nodes:
        left, top = min(node.x - node.left for node in nodes), min(node.y - node.height / 2 for node in nodes)
        for node in nodes:
            node.x, node.y = node.x - left, node.y - top
    return max((node.x + node.right for node in nodes), default=0.0), max((node.y + node.height / 2 for node in nodes), default=0.0)


def _make_room(box: Box, nodes: Sequence[Node]) -> None:
    """Where an unfolded module is larger than the folded one that positions were chosen beside, move what stands right and below."""
    by_key = {node.key: node for node in nodes}
    for inner in box.boxes:
        if inner.folded or inner.net is None:
            continue
        node, small = by_key["box " + inner.key], lay_out(folded(inner.net, inner.key, inner.title))
        left, top = node.x - node.left, node.y - node.height / 2
        wider, taller = max(0.0, 2 * node.left - small.width), max(0.0, node.height - small.height)
        for other in nodes:
            if other is node:
                continue
            if other.y > top + small.height:
                other.y += taller
            elif other.y > top and other.x > left + small.width:
                other.x += wider


def _name(box: Box, node: Node) -> str:
    """What a node is called in the net of its box."""
    return node.key.removeprefix("box ").removeprefix(f"{box.key}." if box.key else "")


def _tops(children: Sequence[Laid]) -> set[str]:
    return {key for child in children for key in child.box.entries}


# -- drawing ------------------------------------------------------------------------------------------------------------------------


def _draw_boxes(laid: Laid, corner: Point, body: list[str]) -> None:
    for child, (x, y) in laid.inner:
        x, y = x + corner[0], y + corner[1]
        body.append(
            f'<rect x="{x:.1f}" y="{y:.1f}" width="{child.width:.1f}" height="{child.height:.1f}" rx="8" fill="{MODULE}" '
            f'stroke="{GREY}" stroke-width="1"/>'
        )
        _draw_boxes(child, (x, y), body)


def _draw_items(laid: Laid, corner: Point, body: list[str]) -> None:
    for child, (x, y) in laid.inner:
        _draw_titles(child, (x + corner[0], y + corner[1]), body)
    for key, (x, y) in laid.at.items():
        _draw_item(laid.items[key], x + corner[0], y + corner[1], body)


def _draw_titles(laid: Laid, corner: Point, body: list[str]) -> None:
    body += _text(laid.box.title, corner[0] + 8, corner[1] + 15, FONT, INK, ' font-weight="bold"')
    for child, (x, y) in laid.inner:
        _draw_titles(child, (x + corner[0], y + corner[1]), body)


def _text(text: str, x: float, y: float, size: float, colour: str, style: str = "") -> list[str]:
    """A text with a white rim, so that it can be read across lines."""
    place = f'x="{x:.1f}" y="{y:.1f}" font-size="{size:g}"{style}'
    rim = 'fill="none" stroke="white" stroke-width="3" stroke-opacity="0.85" stroke-linejoin="round"'
    return [f"<text {place} {rim}>{escape(text)}</text>", f'<text {place} fill="{colour}">{escape(text)}</text>']


def _draw_item(item: Item, x: float, y: float, body: list[str]) -> None:
    if item.is_transition:
        fill = {"immediate": INK, "timed": "white", "output": "url(#hash)"}[item.kind]
        body.append(
            f'<rect x="{x - BAR / 2:.1f}" y="{y - THICK / 2:.1f}" width="{BAR:g}" height="{THICK:g}" fill="{fill}" '
            f'stroke="{INK}" stroke-width="{1.4 if item.timed else 1.0}"/>'
        )
        half = BAR / 2
    else:
        fill = {"input": "url(#hash)", "continuous": "#eef2ff", "math": "#eef2ff"}.get(item.kind, "white")
        body.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{RADIUS:g}" fill="{fill}" stroke="{INK}" stroke-width="1.2"/>')
        half = RADIUS
        _draw_inside(item, x, y, body)
    middle = y + 4 if not item.detail else y - 1
    body += _text(item.label, x + half + 5, middle, FONT, INK)
    if item.detail:
        style = ' font-style="italic"' if item.kind == "math" else ""
        body += _text(_shown(item.detail), x + half + 5, y + 10, SMALL, GREY, style)


def _draw_inside(item: Item, x: float, y: float, body: list[str]) -> None:
    if item.kind == "belief":
        body.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{RADIUS - 3:g}" fill="none" stroke="{INK}" stroke-width="1.2"/>')
    elif item.kind == "math":
        body.append(f'<text x="{x:.1f}" y="{y + 4:.1f}" text-anchor="middle" font-style="italic" fill="{INK}">f</text>')
    elif item.kind == "object":
        body.append(f'<path d="M{x - 5:.1f} {y:.1f} l5 -6 l5 6 l-5 6 z" fill="none" stroke="{INK}" stroke-width="1.2"/>')
    elif 1 <= item.tokens <= 4:
        spots = {1: [(0, 0)], 2: [(-4, 0), (4, 0)], 3: [(-4, 3), (4, 3), (0, -4)], 4: [(-4, -4), (4, -4), (-4, 4), (4, 4)]}[item.tokens]
        body += [f'<circle cx="{x + dx:.1f}" cy="{y + dy:.1f}" r="2.6" fill="{INK}"/>' for dx, dy in spots]
    elif item.tokens:
        body.append(f'<text x="{x:.1f}" y="{y + 3.5:.1f}" text-anchor="middle" font-size="{SMALL:g}">{item.tokens}</text>')


def _draw_links(laid: Laid, corner: Point, body: list[str], drawn: list[tuple[Link, list[Point]]]) -> None:
    """Draw the arcs, inner boxes first, and add them with the points through which they go to `drawn`."""
    for child, (x, y) in laid.inner:
        _draw_links(child, (x + corner[0], y + corner[1]), body, drawn)
    ends = attachments(laid)
    for (link, points), (start, end) in zip(laid.routes, ends):
        path = [(x + corner[0], y + corner[1]) for x, y in (start, *upright(laid, link, points, start, end), end)]
        drawn.append((link, _draw_link(link, path, body)))


def _draw_labels(laid: Laid, corner: Point, body: list[str], drawn: list[tuple[Link, list[Point]]]) -> None:
    texts = []
    for key, (x, y) in laid.at.items():
        left, right, height = _extent(laid.items[key])
        x, y = x + corner[0], y + corner[1]
        texts.append((x - left, y - height / 2, x + right, y + height / 2))
    labels = [(link.label, number) for number, (link, _) in enumerate(drawn) if link.label]
    found = place_labels([(_text_width(label, SMALL), number) for label, number in labels], SMALL, texts, [path for _, path in drawn])
    for (label, _), (left, _, _, bottom) in zip(labels, found):
        body += _text(label, left, bottom - 1.5, SMALL, INK)


def upright(laid: Laid, link: Link, points: list[Point], start: Point, end: Point) -> list[Point]:
    """The points between, those straight above or below an end moved to where the arc touches it."""
    moved = list(points)
    for index, key, touch in ((0, link.source, start), (-1, link.target, end)):
        if moved and abs(moved[index][0] - laid.at[key][0]) < 0.05:
            moved[index] = (touch[0], moved[index][1])
    return moved


def attachments(laid: Laid) -> list[tuple[Point, Point]]:
    """Where each arc touches its two ends: spread along the side of the node that it comes from, in order."""
    touching: dict[tuple[str, bool], list[tuple[float, int, int]]] = {}
    sides: list[list[bool]] = []
    for number, (link, points) in enumerate(laid.routes):
        path = [laid.at[link.source], *points, laid.at[link.target]]
        row = []
        for which, key in enumerate((link.source, link.target)):
            here, *others = path if which == 0 else path[::-1]
            below = others[0][1] > here[1]
            beyond = next((point for point in others if abs(point[0] - here[0]) > 1.0), others[-1])
            lean = (beyond[0] - here[0]) / max(abs(beyond[1] - here[1]), 1.0)
            touching.setdefault((key, below), []).append((lean, number, which))
            row.append(below)
        sides.append(row)
    found: dict[tuple[int, int], Point] = {}
    for (key, below), mine in touching.items():
        x, y = laid.at[key]
        bar = laid.items[key].is_transition
        for place, (_, number, which) in enumerate(sorted(mine)):
            share = (place + 1) / (len(mine) + 1) * 2 - 1  # -1 to 1
            if bar:
                dx, dy = share * BAR / 2, THICK / 2
            else:
                angle = share * math.radians(75)
                dx, dy = RADIUS * math.sin(angle), RADIUS * math.cos(angle)
            found[number, which] = (x + dx, y + (dy if below else -dy))
    return [(found[i, 0], found[i, 1]) for i in range(len(laid.routes))]


def _draw_link(link: Link, path: list[Point], body: list[str]) -> list[Point]:
    """Draw an arc; returns the points through which its line goes."""
    tip, before = path[-1], path[-2]
    up = before[1] > tip[1]
    reach = {"inhibitor": 7.0, "arc": 7.0, "test": 7.0, "set": 12.0, "operand": 5.0}.get(link.style, 0.0)
    path = [*path[:-1], (tip[0], tip[1] + (reach if up else -reach))]
    dash = {"test": "5 3", "inhibitor": "5 3", "parameter": "1.5 3", "operand": "1.5 3"}.get(link.style)
    colour = GREY if link.style in ("parameter", "operand", "fuse") else INK
    wide = 3.0 if link.style == "fuse" else 1.1
    dashed = f' stroke-dasharray="{dash}"' if dash else ""
    body.append(f'<path d="{_curve(path)}" fill="none" stroke="{colour}" stroke-width="{wide:g}"{dashed}/>')
    direction = -1.0 if up else 1.0
    x, y = tip
    if link.style == "inhibitor":
        body.append(f'<circle cx="{x:.1f}" cy="{y - direction * 3.5:.1f}" r="3.5" fill="white" stroke="{INK}" stroke-width="1.1"/>')
    elif link.style in ("arc", "test", "set"):
        body.append(_head(x, y, direction, INK))
        if link.style == "set":
            body.append(_head(x, y - direction * 6, direction, INK))
    elif link.style == "operand":
        body.append(_head(x, y, direction, GREY, 5.0))
    return path


def _head(x: float, y: float, direction: float, colour: str, size: float = 7.0) -> str:
    back = y - direction * size
    half = size * 0.45
    return f'<path d="M{x:.1f} {y:.1f} L{x - half:.1f} {back:.1f} L{x + half:.1f} {back:.1f} z" fill="{colour}"/>'


def _curve(path: list[Point]) -> str:
    """Smooth, upright at every point."""
    parts = [f"M{path[0][0]:.1f} {path[0][1]:.1f}"]
    for (x0, y0), (x1, y1) in pairwise(path):
        if abs(x0 - x1) < 0.05:
            parts.append(f"L{x1:.1f} {y1:.1f}")
        else:
            middle = (y0 + y1) / 2
            parts.append(f"C{x0:.1f} {middle:.1f} {x1:.1f} {middle:.1f} {x1:.1f} {y1:.1f}")
    return " ".join(parts)
