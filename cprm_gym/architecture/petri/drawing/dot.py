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
from collections.abc import Mapping
from pathlib import Path

from ....errors import NetError
from ....files import write_atomically
from ..net.net import PetriNet
from .picture import ALL, Box, picture
from .svg import render

__all__ = ["ALL", "save_drawing", "to_dot", "to_svg"]

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
    lines.append('  edge [fontname="Helvetica", fontsize=9, arrowsize=0.7]; graph [nodesep=0.6, ranksep=0.5, forcelabels=true];')
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


def to_svg(net: PetriNet, unfold: int = 0) -> str:
    """The drawing as an SVG document; no other program is needed.

    Parameters
    ----------
    net : PetriNet
    unfold : int
        Levels of modules drawn with their inside; `ALL` for every level.
    """
    return render(picture(net, unfold))


def save_drawing(net: PetriNet, path: str | os.PathLike[str], unfold: int = 0) -> None:
    """Write the drawing to a ``.svg`` or ``.dot`` file, all of it or nothing."""
    target = Path(path)
    writers = {".svg": to_svg, ".dot": to_dot, ".gv": to_dot}
    if target.suffix not in writers:
        raise NetError(f"a drawing is written as {', '.join(writers)}, got {target.name!r}")
    write_atomically(target, writers[target.suffix](net, unfold))
