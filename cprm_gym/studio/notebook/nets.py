"""Nets and executors in a notebook."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ...architecture.petri import Executor, PetriNet
from ...architecture.petri.drawing.picture import ALL, Unfold, picture
from ...architecture.petri.drawing.plan import drawing_plan
from ...architecture.petri.drawing.svg import render
from .view import View, page_of

SCRIPTS = ("netshapes.js", "viewport.js", "netcanvas.js", "notebook.js")
LARGE = 900
"""Parts up to which the page also holds the drawing with every module unfolded."""
MOST = 2000
"""Most cycles in one page; of more, the last."""


def show_net(net: PetriNet, unfold: Unfold = 0, height: int = 480) -> View:
    """A net with its initial marking."""
    return _view(net, unfold, [], height, None)


def show_executor(executor: Executor, unfold: Unfold = 0, height: int = 480) -> View:
    """The marking of the first copy; with a trace, of every cycle."""
    compiled = executor.net
    marking = dict(zip(compiled.place_names, executor.marking[0].tolist()))
    steps = []
    if executor.trace is not None:
        for before, events in executor.trace.cycles():
            mine = events[events[:, 0] == 0]
            fired = [compiled.transition_names[t] for t in mine[:, 2].tolist()]
            values = before.row[0, : compiled.n_places].tolist()
            steps.append({"cycle": int(before.cycle[0]), "marking": _plain(dict(zip(compiled.place_names, values))), "fired": fired})
    steps.append({"cycle": int(executor.cycle[0]), "marking": _plain(marking), "fired": [], "enabled": list(executor.enabled())})
    return _view(compiled.source, unfold, steps[-MOST:], height, marking)


def _view(net: PetriNet, unfold: Unfold, steps: list[dict[str, Any]], height: int, marking: Mapping[str, float] | None) -> View:
    plans = [drawing_plan(net, unfold)]
    if net.modules and net.parts <= LARGE and unfold != ALL:
        plans.append(drawing_plan(net, ALL))
    data = {"plans": plans, "steps": steps}
    return View(picture_of(net, marking, unfold=unfold), page_of(f"net {net.name}", data, "showNet(data);", SCRIPTS), height)


def picture_of(net: PetriNet, marking: Mapping[str, float] | None = None, fired: Collection[str] = (), unfold: Unfold = 0) -> str:
    """The SVG drawing of a net in a marking; what has fired has a sign beside its name."""
    box = picture(net, unfold)
    for part in box.walk():
        for k, item in enumerate(part.items):
            if item.is_transition:
                part.items[k] = replace(item, label=f"▶ {item.label}") if item.key in fired else item
            elif marking is not None:
                value = float(marking.get(item.key, 0.0))
                if item.kind in ("place", "port", "object"):
                    part.items[k] = replace(item, tokens=int(value))
                elif np.isfinite(value):
                    part.items[k] = replace(item, detail=f"{value:.4g}")
    return render(box)


def _plain(marking: Mapping[str, float]) -> dict[str, float | None]:
    """What JSON can say: none where a value is not known, small numbers of digits."""
    return {name: float(f"{value:.6g}") if np.isfinite(value) else None for name, value in marking.items()}
