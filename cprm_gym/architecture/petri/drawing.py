"""Drawings of nets, as Graphviz DOT text or as SVG, at any level of the hierarchy, in the dissertation's signs.

=====================================  ==================================================================================
circle                                 place; dots are tokens, ``≤ 5`` its capacity
hashed circle                          input place
double circle                          belief place
circle with *f*                        math place, its expression beside it
circle with a rhombus                  object place
filled bar / open bar                  immediate / timed transition, its delay beside it
hashed bar                             output transition, its command beside it
arrow                                  input and output arcs
dashed arrow                           test arc
dashed line with a circle              inhibitor arc
arrow with two heads                   set arc, its value beside it
dotted line                            command parameters and the operands of math
box                                    module instance: ports on its border when folded, its net inside when unfolded
=====================================  ==================================================================================
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ...errors import NetError
from ..expressions import Expression
from .net import PetriNet, resolve_name
from .places import AnyPlace, Belief, Continuous, Input, Math, ObjectPlace, Place, Transition

ALL = -1
"""`unfold` for a drawing with every module unfolded."""


@dataclass(frozen=True)
class Item:
    """A place or transition to draw.

    Parameters
    ----------
    key : str
        Unique in the drawing: the flat name.
    kind : str
        ``place continuous input belief math object port`` or ``immediate timed output``.
    label, detail : str
        What stands beside it; the detail is smaller.
    tokens : int
        Initial tokens, for a discrete place.
    timed : bool
        Of an output transition.
    """

    key: str
    kind: str
    label: str
    detail: str = ""
    tokens: int = 0
    timed: bool = False

    @property
    def is_transition(self) -> bool:
        """Whether it is a bar."""
        return self.kind in ("immediate", "timed", "output")


@dataclass(frozen=True)
class Link:
    """An arc to draw; `style` is ``arc test inhibitor set parameter operand fuse``."""

    source: str
    target: str
    style: str
    label: str = ""


@dataclass
class Box:
    """One net in a drawing: what it holds, and which of it are ports."""

    key: str
    title: str
    items: list[Item] = field(default_factory=list)
    links: list[Link] = field(default_factory=list)
    boxes: list[Box] = field(default_factory=list)
    entries: set[str] = field(default_factory=set)
    exits: set[str] = field(default_factory=set)

    def walk(self) -> Iterator[Box]:
        """This box and all inside it."""
        yield self
        for box in self.boxes:
            yield from box.walk()


def picture(net: PetriNet, unfold: int = 0) -> Box:
    """What a drawing of `net` shows.

    Parameters
    ----------
    net : PetriNet
    unfold : int
        Levels of modules drawn with their inside; `ALL` for every level.
    """
    return _box(net, "", net.name, unfold)


def _box(net: PetriNet, path: str, title: str, unfold: int) -> Box:
    prefix = f"{path}." if path else ""
    box = Box(path, title)
    box.entries = {prefix + port for port in net.ports.entries}
    box.exits = {prefix + port for port in net.ports.exits}
    scope = {p.name: p for p in net.places} | net.port_places()
    box.items += [_place_item(place, prefix) for place in net.places]
    for t in net.transitions:
        box.items.append(_transition_item(t, prefix))
        box.links += _transition_links(t, prefix)
    for place in net.places:
        box.links += _operand_links(place, prefix, scope)
    for instance, module in net.modules.items():
        inner = f"{prefix}{instance}"
        heading = f"{instance} : {module.name}" if instance != module.name else instance
        if unfold == 0:
            box.boxes.append(_folded(module, inner, heading))
        else:
            box.boxes.append(_box(module, inner, heading, unfold - 1 if unfold > 0 else ALL))
    box.links += [Link(prefix + target, prefix + port, "fuse") for port, target in net.fuse.items()]
    if unfold == 0:
        _drop_unused_ports(box)
    return box


def _folded(module: PetriNet, path: str, heading: str) -> Box:
    own = {p.name: p for p in module.places}
    ports = module.ports
    box = Box(path, heading, entries={f"{path}.{p}" for p in (*ports.entries, *ports.parameters)})
    box.exits = {f"{path}.{p}" for p in ports.exits}
    for port in ports.all:
        kind = "object" if isinstance(own[port], ObjectPlace) else "port"
        box.items.append(Item(f"{path}.{port}", kind, port))
    return box


def _drop_unused_ports(box: Box) -> None:
    """Folded modules show the ports of the behaviour interface that are used, if any are used at all."""
    used = {end for link in box.links for end in (link.source, link.target)}
    for inner in box.boxes:
        keep = [item for item in inner.items if item.key in used]
        inner.items = keep or inner.items


def _place_item(place: AnyPlace, prefix: str) -> Item:
    kind, detail, tokens = "place", "", 0
    if isinstance(place, Place):
        tokens = place.tokens
        detail = f"≤ {place.capacity}" if place.capacity is not None and place.capacity > 1 else ""
    elif isinstance(place, Input):
        kind, detail = "input", place.observes if place.observes != place.name else ""
    elif isinstance(place, Belief):
        state = f" = {place.state}" if place.state else ""
        kind, detail = "belief", f"{place.view} of {place.variable}{state}"
    elif isinstance(place, Math):
        kind, detail = "math", f"= {place.expression}"
    elif isinstance(place, Continuous):
        kind, detail = "continuous", f"{place.value:g}"
    elif isinstance(place, ObjectPlace):
        kind, detail = "object", place.class_name
        if place.select is not None:
            rank = "" if place.select.k == 1 else f"no. {place.select.k} by "
            order = "least" if place.select.minimize else "most"
            detail = f"{rank}{order} {place.select.best}" + (f" where {place.select.where}" if place.select.where else "")
    return Item(prefix + place.name, kind, place.name, detail, tokens)


def _transition_item(t: Transition, prefix: str) -> Item:
    details = []
    if t.is_timed:
        details.append(f"{t.delay}")
    if t.emits is not None:
        details.append(f"{t.emits.name}({', '.join(f'{value}' for value in t.emits.params.values())})")
    if t.priority:
        details.append(f"priority {t.priority}")
    kind = "output" if t.emits is not None else "timed" if t.is_timed else "immediate"
    return Item(prefix + t.name, kind, t.name, ", ".join(details), timed=t.is_timed)


def _transition_links(t: Transition, prefix: str) -> list[Link]:
    name = prefix + t.name
    links = [Link(prefix + p, name, "arc", f"{w}" if w != 1 else "") for p, w in t.inputs.items()]
    links += [Link(name, prefix + p, "arc", f"{w}" if w != 1 else "") for p, w in t.outputs.items()]
    links += [Link(prefix + p, name, "test", f"≥ {w:g}" if w != 1 else "") for p, w in t.tests.items()]
    links += [Link(prefix + p, name, "inhibitor", f"≥ {w:g}" if w != 1 else "") for p, w in t.inhibitors.items()]
    links += [Link(name, prefix + p, "set", f"= {w}") for p, w in t.sets.items()]
    if t.emits is not None:
        sources = {value for value in t.emits.params.values() if isinstance(value, str)}
        links += [Link(prefix + p, name, "parameter") for p in sorted(sources)]
    return links


def _operand_links(place: AnyPlace, prefix: str, scope: Mapping[str, AnyPlace]) -> list[Link]:
    texts: list[str] = []
    skip = ""
    if isinstance(place, Math):
        texts = [place.expression]
    elif isinstance(place, ObjectPlace) and place.select is not None:
        texts, skip = [text for text in (place.select.best, place.select.where) if text], f"{place.select.candidate}."
    elif isinstance(place, Belief) and resolve_name(place.variable, scope)[1]:
        texts = [place.variable]
    found: dict[str, None] = {}
    for text in texts:
        for name in Expression(text).names:
            if not skip or not name.startswith(skip):
                found[resolve_name(name, scope)[0]] = None
    return [Link(prefix + name, prefix + place.name, "operand") for name in found if name]


# -- DOT ----------------------------------------------------------------------------------------------------------------------------

_NODE_STYLES: Mapping[str, str] = {
    "place": "shape=circle",
    "port": "shape=circle",
    "continuous": 'shape=circle, style=filled, fillcolor="#eef2ff"',
    "input": 'shape=circle, style=wedged, fillcolor="gray80:white:gray80:white:gray80:white:gray80:white"',
    "belief": "shape=doublecircle",
    "math": "shape=circle",
    "object": "shape=circle",
    "immediate": "shape=box, style=filled, fillcolor=black, height=0.1, width=0.5",
    "timed": "shape=box, style=filled, fillcolor=white, height=0.14, width=0.5",
    "output": 'shape=box, style=striped, fillcolor="gray60:white:gray60:white:gray60:white", height=0.14, width=0.5',
}
_EDGE_STYLES: Mapping[str, str] = {
    "arc": "",
    "test": "style=dashed",
    "inhibitor": "style=dashed, arrowhead=odot",
    "set": "arrowhead=normalnormal",
    "parameter": "style=dotted, color=gray40, arrowhead=none, constraint=false",
    "operand": "style=dotted, color=gray40, arrowhead=vee",
    "fuse": "dir=none, style=bold, color=gray60",
}


def to_dot(net: PetriNet, unfold: int = 0) -> str:
    """The drawing as Graphviz DOT text.

    Parameters
    ----------
    net : PetriNet
    unfold : int
        Levels of modules drawn with their inside; `ALL` for every level.
    """
    top = picture(net, unfold)
    lines = [
        f"digraph {_quoted(net.name)} {{",
        '  node [fontname="Helvetica", fontsize=10, label="", fixedsize=true, width=0.3, height=0.3];',
    ]
    lines.append('  edge [fontname="Helvetica", fontsize=9];')
    _dot_box(top, lines, "  ")
    for box in top.walk():
        for link in box.links:
            options = ", ".join(part for part in (_EDGE_STYLES[link.style], f"label={_quoted(link.label)}" if link.label else "") if part)
            lines.append(f"  {_quoted(link.source)} -> {_quoted(link.target)}{f' [{options}]' if options else ''};")
    return "\n".join([*lines, "}"]) + "\n"


def _dot_box(box: Box, lines: list[str], indent: str) -> None:
    for item in box.items:
        inside = {"math": "f", "object": "◆"}.get(item.kind, ("●" * item.tokens if item.tokens <= 3 else str(item.tokens)))
        outside = f"{item.label}\n{item.detail}" if item.detail else item.label
        options = f"{_NODE_STYLES[item.kind]}, label={_quoted(inside)}, xlabel={_quoted(outside)}"
        lines.append(f"{indent}{_quoted(item.key)} [{options}];")
    for inner in box.boxes:
        lines.append(f"{indent}subgraph {_quoted('cluster_' + inner.key)} {{")
        lines.append(f'{indent}  label={_quoted(inner.title)}; style=rounded; color=gray60; fontname="Helvetica"; fontsize=10;')
        _dot_box(inner, lines, indent + "  ")
        lines.append(f"{indent}}}")


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


# -- files --------------------------------------------------------------------------------------------------------------------------


def to_svg(net: PetriNet, unfold: int = 0) -> str:
    """The drawing as an SVG document; no other program is needed.

    Parameters
    ----------
    net : PetriNet
    unfold : int
        Levels of modules drawn with their inside; `ALL` for every level.
    """
    from .svg import render  # the writer needs what stands above

    return render(picture(net, unfold))


def save_drawing(net: PetriNet, path: str | os.PathLike[str], unfold: int = 0) -> None:
    """Write the drawing to a ``.svg`` or ``.dot`` file, all of it or nothing."""
    target = Path(path)
    writers = {".svg": to_svg, ".dot": to_dot, ".gv": to_dot}
    if target.suffix not in writers:
        raise NetError(f"a drawing is written as {', '.join(writers)}, got {target.name!r}")
    text = writers[target.suffix](net, unfold)
    handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=target.name, suffix=".part")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        os.replace(temporary, target)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
