"""A net as it works: its places with their tokens, its transitions, its modules, drawn for films.

Shown are the net's own places and transitions and one box for each module, with the ports that are used. A module at work is lit, and so
is what has just fired. Quantities (inputs, beliefs, math) are left out: they are what the arcs' thresholds are about, not the state.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from ..architecture.petri import PetriNet
from ..architecture.petri.drawing.picture import Box, Item, picture
from ..architecture.petri.drawing.svg import Laid, lay_out

MARGIN = 14
READABLE = 0.5
"""Scale above which ports are named that hold no token."""
RADIUS = 11.0
"""Of places, in the units of the layout."""
_BACK, _BOX, _LIT, _LINE, _TEXT = (20, 34, 26), (44, 62, 51), (84, 110, 52), (120, 146, 130), (215, 228, 218)
_TOKEN, _FIRED = (246, 205, 70), (250, 150, 60)
_ARC = {"arc": (150, 176, 160), "test": (92, 128, 150), "inhibitor": (176, 92, 88), "set": (110, 110, 130)}
"""Colours of arcs by their kind."""


def skeleton(net: PetriNet) -> Box:
    """What is shown of a net: discrete places, object places, transitions, modules, and the arcs between them."""
    box = picture(net)
    quantities = {f"{name}.{port}" for name, module in net.modules.items() for port in module.ports.parameters}
    for part in box.walk():
        shown = (item for item in part.items if item.kind in ("place", "object", "port") or item.is_transition)
        part.items = [_bare(item) for item in shown if item.key not in quantities]
    there = {item.key for part in box.walk() for item in part.items}
    box.links = [link for link in box.links if link.source in there and link.target in there and link.style in _ARC]
    return box


def _bare(item: Item) -> Item:
    """Transitions carry no text until they fire, which makes the drawing small."""
    return replace(item, label="" if item.is_transition else item.label, detail="")


class NetView:
    """Draws one net again and again.

    Parameters
    ----------
    net : PetriNet
    width, height : int
        Of the picture at most, pixels; the drawing is fitted in, lying on its side if it is taller than broad.
    pygame : module
    """

    def __init__(self, net: PetriNet, width: int, height: int, pygame: Any) -> None:
        self.net = net
        self._pygame = pygame
        self._laid = lay_out(skeleton(net), outermost=True)
        across, down = self._laid.width, self._laid.height
        self._lying = down > across
        if self._lying:
            across, down = down, across
        self._scale = min((width - 2 * MARGIN) / across, (height - 2 * MARGIN) / down)
        self.size = width, min(height, int(down * self._scale) + 2 * MARGIN)
        self._offset = (width - across * self._scale) / 2
        pygame.font.init()
        self._font = pygame.font.Font(None, max(13, min(20, int(19 * self._scale))))

    def _at(self, x: float, y: float) -> tuple[float, float]:
        if self._lying:
            x, y = y, x
        return x * self._scale + self._offset, y * self._scale + MARGIN

    def draw(self, marking: Mapping[str, float], fired: Collection[str] = ()) -> np.ndarray:
        """The net with its tokens.

        Parameters
        ----------
        marking : mapping of str to float
            Place -> tokens; what is missing holds none.
        fired : collection of str
            Transitions that are lit and named.

        Returns
        -------
        (H, W, 3) uint8 array
        """
        surface = self._pygame.Surface(self.size)
        surface.fill(_BACK)
        self._boxes(surface, self._laid, (0.0, 0.0), marking)
        for link, points in self._laid.routes:
            ends = [self._laid.at[link.source], *points, self._laid.at[link.target]]
            self._arc(surface, link.style, [self._at(*p) for p in ends], link.source in fired or link.target in fired)
        for key, item in self._laid.items.items():
            self._item(surface, item, self._at(*self._laid.at[key]), marking.get(key, 0.0), key in fired)
        return np.transpose(self._pygame.surfarray.array3d(surface), (1, 0, 2)).copy()

    def _boxes(self, surface: Any, laid: Laid, corner: tuple[float, float], marking: Mapping[str, float]) -> None:
        """The modules, those at work lit."""
        for child, (x, y) in laid.inner:
            name = child.box.key
            left, top = self._at(x + corner[0], y + corner[1])
            right, bottom = self._at(x + corner[0] + child.width, y + corner[1] + child.height)
            rect = self._pygame.Rect(left, top, right - left, bottom - top)
            ongoing = self.net.modules[name].ports.ongoing
            lit = ongoing is not None and marking.get(f"{name}.{ongoing}", 0.0) > 0
            self._pygame.draw.rect(surface, _LIT if lit else _BOX, rect, border_radius=6)
            self._pygame.draw.rect(surface, _TOKEN if lit else _LINE, rect, 2 if lit else 1, border_radius=6)
            text = self._font.render(name, True, _TOKEN if lit else _TEXT)
            surface.blit(text, (rect.centerx - text.get_width() / 2, rect.top + 2))

    def _arc(self, surface: Any, style: str, points: list[tuple[float, float]], lit: bool) -> None:
        """A line with a head: an arrow, or a circle for an inhibitor."""
        colour = _FIRED if lit and style == "arc" else _ARC[style]
        self._pygame.draw.lines(surface, colour, False, points, 2 if lit and style == "arc" else 1)
        (x, y), (to_x, to_y) = list(pairwise(points))[-1]
        length = math.hypot(to_x - x, to_y - y)
        if length < 1.0:
            return
        ux, uy, gap = (to_x - x) / length, (to_y - y) / length, RADIUS * self._scale
        tip = to_x - ux * gap, to_y - uy * gap
        if style == "inhibitor":
            self._pygame.draw.circle(surface, colour, tip, 3, 1)
            return
        back = tip[0] - 6 * ux, tip[1] - 6 * uy
        self._pygame.draw.polygon(surface, colour, [tip, (back[0] - 3 * uy, back[1] + 3 * ux), (back[0] + 3 * uy, back[1] - 3 * ux)])

    def _item(self, surface: Any, item: Item, at: tuple[float, float], tokens: float, fired: bool) -> None:
        """A place with its tokens, or a transition."""
        radius = max(4.0, RADIUS * self._scale)
        if item.is_transition:
            half = (2.5, radius) if self._lying else (radius, 2.5)
            rect = self._pygame.Rect(at[0] - half[0], at[1] - half[1], 2 * half[0], 2 * half[1])
            self._pygame.draw.rect(surface, _FIRED if fired else _LINE, rect)
            if fired:
                self._label(surface, item.key.rpartition(".")[2], at, radius, _FIRED)
            return
        held = item.kind == "object" and tokens > 0
        self._pygame.draw.circle(surface, _BACK, at, radius)
        self._pygame.draw.circle(surface, _TOKEN if tokens > 0 else _TEXT, at, radius, 2 if tokens > 0 else 1)
        if tokens > 0:
            self._pygame.draw.circle(surface, _TOKEN, at, max(3.0, 0.55 * radius))
        if tokens > 1 and not held:
            count = self._font.render(f"{tokens:g}", True, _BACK)
            surface.blit(count, (at[0] - count.get_width() / 2, at[1] - count.get_height() / 2))
        if tokens > 0 or "." not in item.key or self._scale > READABLE:
            self._label(surface, item.label, at, radius, _TOKEN if tokens > 0 else _TEXT)

    def _label(self, surface: Any, text: str, at: tuple[float, float], radius: float, colour: tuple[int, int, int]) -> None:
        drawn = self._font.render(text, True, colour)
        place = (at[0] - drawn.get_width() / 2, at[1] + radius + 1) if self._lying else (at[0] + radius + 3, at[1] - drawn.get_height() / 2)
        surface.blit(drawn, place)
