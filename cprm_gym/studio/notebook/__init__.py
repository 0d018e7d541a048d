"""The studio's views in a notebook: `show` gives something that Jupyter and marimo draw, and that can be saved as SVG or HTML.

    from cprm_gym.studio.notebook import show
    show(net)                                  # zoom, pan and select as in the studio
    show(executor)                             # the same with its marking; with trace=True a slider goes through its cycles
    show(runner.explain(), net=cprm.net)       # one decision: what was told, believed, fired and sent
    show("match.rcg.gz")                       # a match with a slider

What is drawn needs no server, no network and no package beside ours: the HTML holds the studio's own canvas. Where HTML is not run,
and in files, stands the same picture as SVG (`View.svg`).
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ...architecture.cprm import CPRM
from ...architecture.cprm.runner import Decision
from ...architecture.petri import Executor, PetriNet
from ...architecture.petri.drawing.picture import Unfold
from ...architecture.prm import Grounding, GroundSlice, Model
from ...errors import ParameterError
from ...simulator.gamelog.frames import Frame
from .decisions import show_decisions
from .matches import show_match
from .models import show_model
from .nets import show_executor, show_net
from .view import View

__all__ = ["View", "show"]

Shown = PetriNet | CPRM | Executor | Decision | Sequence[Decision] | Model | Grounding | GroundSlice | Frame | Sequence[Frame] | str | Path
"""What can be shown."""


def show(thing: Shown, *, net: PetriNet | None = None, unfold: Unfold = 0, height: int = 480) -> View:
    """A view of a net, an executor, decisions, a model, objects, a slice, or a match.

    Parameters
    ----------
    thing : PetriNet, CPRM, Executor, Decision or several, Model, Grounding, GroundSlice, Frame or several, or the path of a game log
        Of a CPRM its net is shown.
    net : PetriNet, optional
        For decisions: the net that made them, drawn beside.
    unfold : int or collection of str
        For nets: levels of modules drawn with their inside, `ALL` for every level; or the paths of the instances that are.
    height : int
        Pixels, in the notebook.

    Returns
    -------
    View

    Raises
    ------
    ParameterError
        For anything else.
    FormatError
        When a path is no game log.
    """
    if isinstance(thing, CPRM):
        thing = thing.net
    if isinstance(thing, PetriNet):
        return show_net(thing, unfold, height)
    if isinstance(thing, Executor):
        return show_executor(thing, unfold, height)
    if isinstance(thing, Decision):
        return show_decisions([thing], net, unfold, height)
    if isinstance(thing, Model | Grounding | GroundSlice):
        return show_model(thing, height)
    if isinstance(thing, Frame):
        return show_match([thing], height)
    if isinstance(thing, str | os.PathLike):
        return show_match(thing, height)
    items: list[Any] = list(thing) if isinstance(thing, Sequence) else []
    if items and all(isinstance(item, Decision) for item in items):
        return show_decisions(items, net, unfold, height)
    if items and all(isinstance(item, Frame) for item in items):
        return show_match(items, height)
    kinds = "PetriNet, CPRM, Executor, Decision, Model, Grounding, GroundSlice, Frame, several decisions or frames, the path of a game log"
    raise ParameterError(f"show: {type(thing).__name__} given; shown are: {kinds}")
