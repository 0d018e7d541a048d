"""Models in a notebook: the class diagram, or the ground net of a slice."""

from __future__ import annotations

from ...architecture.prm import Grounding, GroundSlice, Model
from ...architecture.prm.interchange.drawing import class_diagram_svg, ground_net_svg
from .nets import SCRIPTS
from .view import View, page_of


def show_model(thing: Model | Grounding | GroundSlice, height: int) -> View:
    """Classes and relations of a model; the first slice of a world without relations; a slice."""
    if isinstance(thing, Model):
        svg, title = class_diagram_svg(thing), f"model {thing.name}"
    else:
        ground = thing if isinstance(thing, GroundSlice) else thing.ground((), first=True)
        svg, title = ground_net_svg(ground), "a slice"
    return View(svg, page_of(title, {"svg": svg}, "showPicture(data);", SCRIPTS), height)
