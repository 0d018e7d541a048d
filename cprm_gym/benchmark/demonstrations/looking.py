"""Fixed patterns of neck and width: the rivals of eyes that look where something is to be seen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...envs.actions import NECK_SCALE
from ...envs.controller import Action, Controller, Observation
from ...envs.observations import BodyFeature
from ...simulator.state import ViewWidth


@dataclass(frozen=True)
class Pattern:
    """What the eyes do in turn, whatever is known.

    Attributes
    ----------
    directions : tuple of float
        To which the neck turns, degrees from the body, one after the other; none: where the controller would have it.
    held : int
        Cycles for which it stays at each.
    width : ViewWidth
        Of the view.
    begin : int
        Cycle from which the view has that width.
    """

    directions: tuple[float, ...]
    held: int
    width: ViewWidth
    begin: int = 0


PATTERNS: dict[str, Pattern] = {
    f"{name}, {width.name.lower()}": Pattern(directions, held, width)
    for name, directions, held in (
        ("ahead", (0.0,), 1), ("aside", (80.0,), 1), ("both sides", (-80.0, 80.0), 4),
        ("sweep", (-90.0, -45.0, 0.0, 45.0, 90.0, 45.0, 0.0, -45.0), 2),
    )
    for width in (ViewWidth.NARROW, ViewWidth.NORMAL, ViewWidth.WIDE)
}  # fmt: skip
"""Name -> pattern. A goalie who waits stands side-on, with the ball at about 80 degrees."""
NARROW = Pattern((), 1, ViewWidth.NARROW, 1)
"""Half a pattern: the neck follows what is known, and the view is narrow once it has looked round."""


class FixedLooks:
    """A controller whose eyes follow a pattern instead of what it would have them do.

    Parameters
    ----------
    controller : Controller
    pattern : Pattern
    """

    def __init__(self, controller: Controller, pattern: Pattern) -> None:
        self.controller, self.pattern = controller, pattern
        self.needs: tuple[str, ...] = tuple(getattr(controller, "needs", ()))
        self._cycle = np.zeros(0, np.int64)

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes."""
        count = len(observation["level"])
        self._cycle = np.zeros(count, np.int64) if worlds is None else np.where(worlds, 0, self._cycle)
        self.controller.reset(observation, seed, worlds)

    def act(self, observation: Observation) -> Action:
        """As the controller does, but for neck and view."""
        action = dict(self.controller.act(observation))
        body = np.asarray(observation["body"], np.float64)
        if self.pattern.directions:
            turn = self._cycle // self.pattern.held % len(self.pattern.directions)
            wanted = np.array(self.pattern.directions)[turn] - np.degrees(body[:, BodyFeature.NECK])
            action["turn_neck"] = np.clip(wanted / NECK_SCALE, -1.0, 1.0)[:, None]
        width = body[:, BodyFeature.VIEW_WIDTH].astype(np.int64)
        keeps = (width == self.pattern.width) | (self._cycle < self.pattern.begin)
        action["view"] = np.where(keeps, int(ViewWidth.KEEP), int(self.pattern.width))
        self._cycle = self._cycle + 1
        return action
