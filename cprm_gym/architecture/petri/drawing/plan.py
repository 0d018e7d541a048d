"""A drawing as plain values with a key for each part, for programs that draw it, colour it and change it themselves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..files.json import definition_keys
from ..files.positions import Positions
from ..net.modules import instances
from ..net.net import PetriNet
from .layout import Point
from .picture import Unfold, drop_quantities, picture
from .svg import Laid, attachments, lay_out, upright


def drawing_plan(
    net: PetriNet, unfold: Unfold = 0, positions: Positions | None = None, *, all_ports: bool = False, quantities: bool = True
) -> dict[str, Any]:
    """Where everything in a drawing stands, under the flat names of places and transitions.

    Parameters
    ----------
    net : PetriNet
    unfold : int or collection of str
        Levels of modules drawn with their inside, `ALL` for every level; or the paths of the instances that are.
    positions : mapping, optional
        Those chosen by hand, by the keys that the definitions have in the net's JSON form. What has none is placed automatically.
    all_ports : bool
        Show every port of a folded module, not only those that are used.
    quantities : bool
        False: without inputs, beliefs, math and continuous places (`picture.drop_quantities`).

    Returns
    -------
    dict
        ``width``, ``height``; ``nodes`` with key, kind, label, detail, tokens, timed, ports (``"entry"``, ``"exit"`` or empty), x, y of
        the middle; ``boxes`` with key, title, definition, folded, x, y, width, height, outer ones first; ``links`` with source, target,
        style, label and the points of their path, which is empty where an end was put by hand.
    """
    box = picture(net, unfold, all_ports)
    if not quantities:
        drop_quantities(box)
    keys = definition_keys(net)
    by_hand = {}
    if positions:
        for path, instance in instances(net).items():
            if chosen := positions.get(keys[instance.net]):
                by_hand[path] = chosen
    laid = lay_out(box, outermost=True, by_hand=by_hand)
    nodes: list[dict[str, Any]] = []
    for key, (x, y) in laid.at.items():
        item = laid.items[key]
        nodes.append(
            {"key": key, "kind": item.kind, "label": item.label, "detail": item.detail, "tokens": item.tokens, "timed": item.timed,
             "x": round(x, 1), "y": round(y, 1)}
        )  # fmt: skip
    sides = {key: side for part in box.walk() for side, names in (("entry", part.entries), ("exit", part.exits)) for key in names}
    for node in nodes:
        node["port"] = sides.get(node["key"], "")
    boxes: list[dict[str, Any]] = []
    links: list[dict[str, Any]] = []
    for inner, (x, y) in _walk(laid, (0.0, 0.0)):
        if inner is not laid:
            part = inner.box
            assert part.net is not None
            boxes.append(
                {"key": part.key, "title": part.title, "definition": keys[part.net], "folded": part.folded, "x": round(x, 1),
                 "y": round(y, 1), "width": round(inner.width, 1), "height": round(inner.height, 1)}
            )  # fmt: skip
        straight = inner.box.key in by_hand
        for (link, points), (start, end) in zip(inner.routes, attachments(inner)):
            route: list[Point] = [] if straight else [start, *upright(inner, link, points, start, end), end]
            links.append(
                {"source": link.source, "target": link.target, "style": link.style, "label": link.label,
                 "path": [[round(px + x, 1), round(py + y, 1)] for px, py in route]}
            )  # fmt: skip
    return {"width": round(laid.width, 1), "height": round(laid.height, 1), "nodes": nodes, "boxes": boxes, "links": links}


def _walk(laid: Laid, corner: Point) -> Iterator[tuple[Laid, Point]]:
    yield laid, corner
    for child, (x, y) in laid.inner:
        yield from _walk(child, (x + corner[0], y + corner[1]))
