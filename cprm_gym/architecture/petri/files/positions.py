"""Where somebody put the parts of a drawing by hand: kept in the files of nets, and no part of what the net means.

In JSON it is the entry ``layout``: definition -> place, transition or instance -> ``[x, y]``. In PNML it is ``<graphics>`` for the places
and transitions of the net itself, and the ``layout`` of the net's JSON form in our block for the modules in it.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from typing import Any

from ....errors import NetError
from ..net.checks import shown
from .pnml_tree import TOOL, Node, parse_xml

Positions = Mapping[str, Mapping[str, tuple[float, float]]]
"""Definition of a module -> place, transition or instance -> where it stands, in pixels of the drawing."""
FAR = 1e6
"""Largest coordinate."""


def positions_from_layout(layout: object) -> dict[str, dict[str, tuple[float, float]]]:
    """The positions that the entry ``layout`` of a JSON form holds.

    Raises
    ------
    NetError
        When it is not of that form.
    """
    found: dict[str, dict[str, tuple[float, float]]] = {}
    if not isinstance(layout, dict):
        raise NetError(f"'layout' maps definitions to positions, got {shown(layout)}")
    for key, parts in layout.items():
        if not isinstance(parts, dict):
            raise NetError(f"'layout' of {key!r} maps names to [x, y], got {shown(parts)}")
        found[key] = {name: _point(at, f"'layout' of {key!r}: {name!r}") for name, at in parts.items()}
    return found


def _point(at: object, where: str) -> tuple[float, float]:
    if isinstance(at, (list, tuple)) and len(at) == 2:
        x, y = at
        if all(isinstance(v, (int, float)) and not isinstance(v, bool) and math.isfinite(v) and abs(v) <= FAR for v in (x, y)):
            return x, y
    raise NetError(f"{where} is [x, y], numbers within {FAR:g}, got {shown(at)}")


def with_positions(form: dict[str, Any], positions: Positions | None) -> dict[str, Any]:
    """The JSON form of a net with these positions as its ``layout``; definitions that it does not have are left out."""
    kept = {key: {name: list(at) for name, at in parts.items()} for key, parts in (positions or {}).items() if key in form["definitions"]}
    return {**form, "layout": kept} if any(kept.values()) else form


def pnml_positions(data: bytes | str, source: str, net: str) -> dict[str, dict[str, tuple[float, float]]]:
    """The positions in a PNML document of one net.

    Parameters
    ----------
    data : bytes or str
    source : str
        Named in errors.
    net : str
        Key of the definition to which ``<graphics>`` belong: the net's name.

    Raises
    ------
    FormatError
        When the document is not XML.
    """
    root = parse_xml(data, source)
    found: dict[str, dict[str, tuple[float, float]]] = {}
    own = {}
    for node in root.walk():
        if node.tag in ("place", "transition") and (at := _graphics(node)) is not None:
            name = node.first("name")
            own[(name.label() if name is not None else "") or node.attributes.get("id", "")] = at
        elif node.tag == "toolspecific" and node.attributes.get("tool") == TOOL and (block := node.first("definition")) is not None:
            found |= _of_block(block)
    if own:
        found.setdefault(net, own)
    return found


def _graphics(node: Node) -> tuple[float, float] | None:
    graphics = node.first("graphics")
    position = graphics.first("position") if graphics is not None else None
    if position is None:
        return None
    values = [position.attributes.get(axis, "") for axis in ("x", "y")]
    if not all(re.fullmatch(r"-?[0-9]{1,6}(\.[0-9]*)?", v) for v in values):
        return None
    return float(values[0]), float(values[1])


def _of_block(definition: Node) -> dict[str, dict[str, tuple[float, float]]]:
    """Positions in the definition of our block; a block of others, or one that is no net's form, has none."""
    try:
        form = json.loads(definition.text)
        return positions_from_layout(form.get("layout", {})) if isinstance(form, dict) else {}
    except (ValueError, RecursionError, NetError):
        return {}
