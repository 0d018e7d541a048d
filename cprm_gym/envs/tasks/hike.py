"""Hike: out to see a view and home again; in the middle of the way both times look the same."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ...simulator.state import PlayMode
from ..pitch import Pitch
from .base import Outcome, Status, Task, within

_SEEN, _SPUN_OUT, _SPUN_HOME = 0, 1, 2


@dataclass(frozen=True)
class Hike(Task):
    """A player goes to a place with a view, and back to where he came from, on the same way.

    Description
    -----------
    One player; the ball lies at the corner and means nothing. In the middle of the way, out and home, he is spun round: he stands still
    there and faces anywhere. So what can be known of the world in the middle is the same both times, and the way on is the opposite one:
    who does not remember whether he has been to the view cannot tell which.

    Actions
    -------
    Any action view; running and turning matter.

    Observations
    ------------
    The common schema; nothing is added. Home is at (-`way` / 2, 0), the view at (`way` / 2, 0), in the frame of the pitch.

    Rewards
    -------
    1 at the view the first time, 1 at home after that, else 0.

    Start
    -----
    He stands at home and faces anywhere.

    End
    ---
    SUCCESS: he is home, within `near` metres, after he was at the view; truncated after `max_cycles`, about one and a half times of what
    the way takes.

    References
    ----------
    Dissertation 5.3.2 ("We might hike out to see a view, and on our return retrace our steps").
    """

    name: str = "Hike"
    max_cycles: int = 200
    terms: tuple[str, ...] = ("view", "home")
    way: float = within(30.0, 8.0, 90.0)
    near: float = within(1.5, 0.5, 4.0)

    def setup(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """Stand at home."""
        u = pitch.draw(worlds, 1)
        pitch.sim.world["mode"][worlds] = PlayMode.play_on
        corner = np.full(len(worlds), HALF_LENGTH - 1.0), np.full(len(worlds), HALF_WIDTH - 1.0)
        pitch.place_ball(*corner, worlds=worlds)
        home = np.full(len(worlds), -self.way / 2)
        pitch.place_player(1, home, np.zeros(len(worlds)), math.pi * (2 * u[:, 0] - 1), worlds=worlds)

    def outcome(self, pitch: Pitch) -> Outcome:
        """Spun round in the middle; at the view; at home."""
        place, memory = pitch.sim.world["pos"][:, 1], pitch.memory
        seen = memory[:, _SEEN] > 0
        x = place[:, 0]
        outwards = ~seen & (memory[:, _SPUN_OUT] == 0) & (x >= 0.0)
        homewards = seen & (memory[:, _SPUN_HOME] == 0) & (x <= 0.0)
        memory[outwards, _SPUN_OUT] = memory[homewards, _SPUN_HOME] = 1
        spun = np.flatnonzero(outwards | homewards)
        if len(spun):
            facing = math.pi * (2 * pitch.draw(spun, 1)[:, 0] - 1)
            pitch.place_player(1, np.zeros(len(spun)), np.zeros(len(spun)), facing, worlds=spun)
        at_view = ~seen & (np.hypot(x - self.way / 2, place[:, 1]) <= self.near)
        memory[at_view, _SEEN] = 1
        home = seen & (np.hypot(x + self.way / 2, place[:, 1]) <= self.near)
        terms = {"view": at_view[:, None] * pitch.sides, "home": home[:, None] * pitch.sides}
        status = np.where(home, int(Status.SUCCESS), 0)
        return Outcome(terms["view"] + terms["home"], home, pitch.of_sides(home, np.zeros_like(home)), status, terms)
