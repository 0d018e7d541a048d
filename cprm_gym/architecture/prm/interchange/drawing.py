"""Drawings of a model (its classes and relations) and of a ground slice, as Graphviz DOT text or as a plain SVG picture.

The SVG needs no other program. In a ground net solid arrows stay in the slice, dashed ones come from the previous slice (drawn
as pale copies on the left of each object), dotted ones from static variables; those that an earlier slice defined are pale too.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from html import escape

from ..grounding.grounding import PREVIOUS, SAME, STATIC, GroundSlice
from ..model.domains import Angle, Domain, Real
from ..model.model import Model
from ..model.schema import Attribute, PRMClass, Relation, parent_text

CHARACTER, LINE, PAD, GAP, BEND = 7.5, 18.0, 10.0, 60.0, 20.0
"""Width of a letter, height of a line, padding, space between boxes, and room for bent arrows, in pixels."""

_STYLE = (
    "text{font-family:'DejaVu Sans Mono',monospace;font-size:12px;fill:#222}.title{font-weight:bold}.note{fill:#666}"
    ".class{fill:#eef4fb;stroke:#35618f}.relation{fill:#fdf3e3;stroke:#b07a21;stroke-dasharray:5 3}"
    ".node{fill:#fff;stroke:#35618f}.seen{fill:#d5dbe3;stroke:#35618f}.given{fill:#e6f2df;stroke:#5b8a3c}"
    ".past{fill:#fafafa;stroke:#bbb;stroke-dasharray:3 2}.object{fill:#f7f9fc;stroke:#c3d0df}"
    ".arc{stroke:#444;fill:none}"
    ".lag{stroke:#999;fill:none;stroke-dasharray:5 3}.static{stroke:#999;fill:none;stroke-dasharray:1 3}"
)


def _size(domain: Domain) -> str:
    """How many states, or the unit of a real number."""
    if isinstance(domain, Real | Angle):
        return f"{type(domain).__name__.lower()} {domain.unit}".strip()
    return str(len(domain))


def _quote(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'


def _attribute_line(a: Attribute) -> str:
    parents = ", ".join(parent_text(p) for p in a.parents)
    return f"{a.name} [{_size(a.domain)}]" + (f" | {parents}" if parents else "") + (" static" if a.static else "")


def _class_lines(c: PRMClass) -> list[str]:
    lines = [f"given {i.name} [{_size(i.domain)}]" for i in c.given]
    lines += [_attribute_line(a) for a in c.attributes]
    return lines + [f"-> {r.name}: {r.target}{' *' if r.many else ''}" for r in c.references]


def _relation_lines(r: Relation) -> list[str]:
    lines = [_attribute_line(a) for a in r.attributes]
    for change in r.changes:
        parents = ", ".join(parent_text(p) for p in change.parents)
        sign = "+=" if type(change).__name__ == "Add" else "="
        lines.append(f"{change.target} {sign} {parents or 'prior'}")
    return lines


def class_diagram_dot(model: Model) -> str:
    """Classes with their attributes, inheritance, references and relations as DOT text.

    Parameters
    ----------
    model : Model
    """
    out = [f"digraph {_quote(model.name)} {{", '  rankdir=LR; node [shape=record, fontname="DejaVu Sans Mono", fontsize=10];']

    def record(title: str, lines: Iterable[str]) -> str:
        text = "".join(_record(line) + "\\l" for line in lines)
        return f'"{{{_record(title)}|{text}}}"'

    for c in model.classes:
        style = ", style=dashed" if c.abstract else ""
        out.append(f"  {_quote(c.name)} [label={record(c.name, _class_lines(c))}{style}];")
    for c in model.classes:
        if c.extends:
            out.append(f"  {_quote(c.name)} -> {_quote(c.extends)} [arrowhead=empty];")
        for r in c.references:
            out.append(f"  {_quote(c.name)} -> {_quote(r.target)} [label={_quote(r.name + (' *' if r.many else ''))}];")
    for relation in model.relations:
        node = _quote(f"relation {relation.name}")
        out.append(f"  {node} [label={record(relation.name, _relation_lines(relation))}, style=dashed, color=orange3];")
        for role, target in relation.roles:
            out.append(f"  {node} -> {_quote(target)} [label={_quote(role)}, style=dashed, dir=none, color=orange3];")
    return "\n".join([*out, "}"]) + "\n"


def _record(text: str) -> str:
    for mark in '\\{}|<>"':
        text = text.replace(mark, "\\" + mark)
    return text


def ground_net_dot(ground: GroundSlice, observed: Collection[str] = ()) -> str:
    """A ground slice as DOT text, one cluster per object.

    Parameters
    ----------
    ground : GroundSlice
    observed : collection of str
        Variables to shade.
    """
    out = ["digraph slice {", '  rankdir=TB; node [shape=ellipse, fontname="DejaVu Sans", fontsize=10];']
    for k, (owner, names) in enumerate(_owners(ground).items()):
        out.append(f"  subgraph cluster_{k} {{ label={_quote(owner)}; color=gray70;")
        for name in names:
            shape = ", shape=box, fillcolor=palegreen" if name in ground.given else ""
            fill = ', style=filled, fillcolor="gray85"' if name in observed else (", style=filled" if shape else "")
            fill = fill if name in ground.variables else ", style=dashed, color=gray60"
            out.append(f"    {_quote(name)} [label={_quote(_short(ground, name))}{fill}{shape}];")
        out.append("  }")
    past: dict[str, None] = {}
    for cpd in ground.cpds:
        for parent, lag in cpd.parents:
            source = parent
            if lag == PREVIOUS:
                source = f"{parent}[t-1]"
                past[source] = None
            style = "" if lag == SAME else " [style=dashed, color=gray50]" if lag == PREVIOUS else " [style=dotted]"
            out.append(f"  {_quote(source)} -> {_quote(cpd.child)}{style};")
    out += [f"  {_quote(name)} [style=dashed, color=gray60, fontcolor=gray40];" for name in past]
    return "\n".join([*out, "}"]) + "\n"


def _owners(ground: GroundSlice) -> dict[str, list[str]]:
    """Variables of each object or tuple, in topological order; before them static parents that an earlier slice defined."""
    out: dict[str, list[str]] = {}
    for name in _earlier(ground):
        out.setdefault(name.rpartition(".")[0], []).append(name)
    for name in ground.variables:
        out.setdefault(ground.variables[name].object_name, [])
    for name in ground.order():
        out[ground.variables[name].object_name].append(name)
    return out


def _earlier(ground: GroundSlice) -> list[str]:
    """Static parents that are no variables of this slice."""
    return list(dict.fromkeys(p for c in ground.cpds for p, lag in c.parents if lag == STATIC and p not in ground.variables))


def _short(ground: GroundSlice, name: str) -> str:
    if name not in ground.variables:
        return f"{name.rpartition('.')[2]} (static)"
    owner = ground.variables[name].object_name
    return name.removeprefix(f"{owner}.") if owner else name


class _Picture:
    """Shapes with the room they take."""

    def __init__(self) -> None:
        self.under: list[str] = []
        self.over: list[str] = []
        self.width = self.height = 0.0

    def room(self, x: float, y: float) -> None:
        self.width, self.height = max(self.width, x), max(self.height, y)

    def box(self, kind: str, x: float, y: float, w: float, h: float, round_: float = 4.0) -> None:
        self.under.append(f'<rect class="{kind}" x="{x:.1f}" y="{y:.1f}" width="{w:.1f}" height="{h:.1f}" rx="{round_}"/>')
        self.room(x + w + PAD, y + h + PAD)

    def text(self, text: str, x: float, y: float, kind: str = "", anchor: str = "start") -> None:
        chosen = f' class="{kind}"' if kind else ""
        self.over.append(f'<text{chosen} x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(text)}</text>')

    def arrow(self, kind: str, start: tuple[float, float], end: tuple[float, float], bend: float = 0.0) -> None:
        (x1, y1), (x2, y2) = start, end
        length = math.hypot(x2 - x1, y2 - y1) or 1.0
        cx, cy = (x1 + x2) / 2 - bend * (y2 - y1) / length, (y1 + y2) / 2 + bend * (x2 - x1) / length
        self.over.append(f'<path class="{kind}" d="M{x1:.1f},{y1:.1f} Q{cx:.1f},{cy:.1f} {x2:.1f},{y2:.1f}" marker-end="url(#tip)"/>')

    def svg(self, title: str) -> str:
        marker = (
            '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
            '<path d="M0,0 L8,4 L0,8 z" fill="#666"/></marker></defs>'
        )
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width:.0f}" height="{self.height:.0f}" '
            f'viewBox="0 0 {self.width:.0f} {self.height:.0f}">'
        )
        parts = [head, f"<title>{escape(title)}</title>", f"<style>{_STYLE}</style>", marker, *self.under, *self.over, "</svg>"]
        return "\n".join(parts) + "\n"


def _card(picture: _Picture, kind: str, title: str, lines: list[str], x: float, y: float) -> tuple[float, float, float, float]:
    """A titled box of lines; returns its place and size."""
    w = CHARACTER * max(len(title), *(len(line) for line in lines), 8) + 2 * PAD
    h = LINE * (len(lines) + 1) + PAD
    picture.box(kind, x, y, w, h)
    picture.text(title, x + PAD, y + LINE, "title")
    for k, line in enumerate(lines):
        picture.text(line, x + PAD, y + LINE * (k + 2))
    return x, y, w, h


def class_diagram_svg(model: Model) -> str:
    """Classes above, relations below, as an SVG picture.

    Parameters
    ----------
    model : Model
    """
    picture = _Picture()
    boxes: dict[str, tuple[float, float, float, float]] = {}
    x = PAD
    for c in model.classes:
        title = c.name + (" (abstract)" if c.abstract else "") + (f" : {c.extends}" if c.extends else "")
        boxes[c.name] = _card(picture, "class", title, _class_lines(c), x, PAD)
        x += boxes[c.name][2] + GAP
    below = max((y + h for _, y, _, h in boxes.values()), default=PAD) + GAP
    for c in model.classes:
        for r in c.references:
            _between(picture, "arc", boxes[c.name], boxes[r.target], r.name + (" *" if r.many else ""))
    x = PAD
    for relation in model.relations:
        roles = ", ".join(f"{role}: {target}" for role, target in relation.roles)
        card = _card(picture, "relation", f"{relation.name}({roles})", _relation_lines(relation), x, below)
        for target in dict.fromkeys(target for _, target in relation.roles):
            tx, ty, tw, th = boxes[target]
            picture.arrow("lag", (card[0] + card[2] / 2, below), (tx + tw / 2, ty + th))
        x += card[2] + GAP
    return picture.svg(f"classes of {model.name}")


def _between(picture: _Picture, kind: str, a: tuple[float, float, float, float], b: tuple[float, float, float, float], label: str) -> None:
    """An arrow along the tops of two boxes, or a loop on one."""
    ax, ay, aw, _ = a
    bx, by, bw, _ = b
    start, end = (ax + aw * 0.7, ay), (bx + bw * 0.3, by)
    picture.arrow(kind, start, end, bend=-min(40.0, 10.0 + abs(end[0] - start[0]) / 8) if a is not b else 30.0)
    picture.text(label, (start[0] + end[0]) / 2, ay - 2, "note", "middle")


def ground_net_svg(ground: GroundSlice, observed: Collection[str] = (), columns: int = 4) -> str:
    """A ground slice as an SVG picture: objects in blocks, variables from top to bottom as they depend on each other.

    Parameters
    ----------
    ground : GroundSlice
    observed : collection of str
        Variables to shade.
    columns : int
        Blocks side by side.
    """
    picture = _Picture()
    owners = _owners(ground)
    past = {p for c in ground.cpds for p, lag in c.parents if lag == PREVIOUS}
    place: dict[str, tuple[float, float, float]] = {}
    before: dict[str, tuple[float, float, float]] = {}
    x = y = PAD
    tallest = 0.0
    for k, (owner, names) in enumerate(owners.items()):
        wide = CHARACTER * max([len(_short(ground, n)) for n in names]) + 2 * PAD
        pale = max([CHARACTER * (len(_short(ground, n)) + 4) + 2 * PAD for n in names if n in past], default=0.0)
        block = max(wide + (pale + GAP if pale else 0.0) + BEND, CHARACTER * len(owner)) + 2 * PAD
        height = 2 * LINE * len(names) + LINE + PAD
        picture.box("object", x, y, block, height)
        picture.text(owner, x + PAD, y + LINE, "note")
        for row, name in enumerate(names):
            at = y + LINE + PAD + 2 * LINE * row
            left = x + block - PAD - BEND - wide
            kind = "given" if name in ground.given else "seen" if name in observed else "node" if name in ground.variables else "past"
            picture.box(kind, left, at, wide, LINE + 4, 3.0 if kind == "given" else 11.0)
            picture.text(_short(ground, name), left + wide / 2, at + LINE - 3, anchor="middle")
            place[name] = (left, at + LINE / 2 + 2, wide)
            if name in past:
                picture.box("past", x + PAD, at, pale, LINE + 4, 11.0)
                picture.text(f"{_short(ground, name)} t-1", x + PAD + pale / 2, at + LINE - 3, "note", "middle")
                before[name] = (x + PAD, at + LINE / 2 + 2, pale)
        tallest = max(tallest, height)
        x += block + GAP / 2
        if k % columns == columns - 1:
            x, y, tallest = PAD, y + tallest + GAP / 2, 0.0
    for cpd in ground.cpds:
        for parent, lag in cpd.parents:
            if lag == PREVIOUS and parent in before:
                px, py, pw = before[parent]
                cx, cy, _ = place[cpd.child]
                picture.arrow("lag", (px + pw, py), (cx, cy), bend=6.0)
            elif parent in place:
                _join(picture, "arc" if lag == SAME else "static", place[parent], place[cpd.child])
    return picture.svg(f"slice with {', '.join(ground.relations) or 'no active relation'}")


def _join(picture: _Picture, kind: str, parent: tuple[float, float, float], child: tuple[float, float, float]) -> None:
    """An arrow between two variables: down the right side within a block, else from side to side."""
    px, py, pw = parent
    cx, cy, cw = child
    if abs(px + pw - cx - cw) < 1.0:
        if cy - py <= 2 * LINE + 1 and cy > py:
            picture.arrow(kind, (px + pw / 2, py + LINE / 2 + 2), (cx + cw / 2, cy - LINE / 2 - 2))
        else:
            picture.arrow(kind, (px + pw, py), (cx + cw, cy), bend=-min(28.0, 8.0 + abs(cy - py) / 8))
    elif px < cx:
        picture.arrow(kind, (px + pw, py), (cx, cy), bend=8.0)
    else:
        picture.arrow(kind, (px, py), (cx + cw, cy), bend=8.0)
