"""A player's body in the server's world: every number of a behaviour that is the server's comes from here.

Nets, models and percepts are functions of a `Body`, made once for each (`of_body`). A distance that depends on the reach of the leg is
given as a share of the kickable ring (`Body.within`), a speed as a share of the top speed (`Body.pace`), stamina as a share of the full
one; what remains as a plain number is a threshold of the behaviour itself.
"""

from __future__ import annotations

import functools
import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

from ..envs.tasks.base import Task
from ..simulator.parameters import ServerParameters
from ..simulator.player_types import PlayerType

Made = TypeVar("Made")
_STILL, _FOREVER = 1e-3, 1.0 - 1e-3
"""Bounds of the ball's decay, beyond which its way and time have no useful formula."""


def number(value: float) -> str:
    """A number as it stands in an expression."""
    return f"{value:.10g}"


@dataclass(frozen=True)
class Body:
    """What a player's decisions depend on: the server's parameters, and his type.

    Attributes
    ----------
    server : ServerParameters
    kind : PlayerType, optional
        His type; type 0 of a server with these parameters if not given.
    """

    server: ServerParameters = field(default_factory=ServerParameters)
    kind: PlayerType = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        if self.kind is None:
            object.__setattr__(self, "kind", PlayerType.default(self.server))

    @classmethod
    def of(cls, task: Task) -> Body:
        """A default player's in a task."""
        return cls(task.parameters)

    # ------------------------------------------------------------------ leg and ball

    @property
    def contact(self) -> float:
        """Metres between the centres of player and ball that touch."""
        return self.kind.player_size + self.server.ball_size

    @property
    def reach(self) -> float:
        """Metres between the centres up to which the ball can be kicked."""
        return self.contact + self.kind.kickable_margin

    def within(self, share: float) -> float:
        """Metres between the centres, at a share of the kickable ring: 0 touches the body, 1 is as far as the leg reaches."""
        return round(self.contact + share * self.kind.kickable_margin, 3)

    @property
    def ball_decay(self) -> float:
        """Share of its speed that the ball keeps in a cycle."""
        return min(max(self.server.ball_decay, _STILL), _FOREVER)

    @property
    def roll(self) -> float:
        """Share of its speed that the ball loses in a cycle: at v m / cycle it rolls v / roll metres."""
        return round(1.0 - self.ball_decay, 10)

    @property
    def fade(self) -> float:
        """Rate of that loss: after t cycles the ball has exp(-fade t) of its speed."""
        return round(-math.log(self.ball_decay), 4)

    @property
    def hands(self) -> float:
        """Metres that a goalie's hands reach."""
        return self.server.catchable_area_l * self.kind.catchable_area_l_stretch

    # ------------------------------------------------------------------ running and turning

    @property
    def top_speed(self) -> float:
        """m / cycle that he runs at most."""
        return min(self.kind.real_speed_max(self.server.max_dash_power), self.kind.player_speed_max)

    def pace(self, share: float) -> float:
        """m / cycle, as a share of the top speed."""
        return round(share * self.top_speed, 3)

    def power(self, acceleration: float) -> float:
        """Power of a dash that accelerates him ahead by so many m / cycle^2."""
        return round(acceleration / self.kind.dash_power_rate, 6)

    def hold(self, speed: float) -> float:
        """Power of dashes that hold a speed, m / cycle, against the decay."""
        return self.power(speed * (1.0 - self.kind.player_decay))

    def dash(self, share: float) -> float:
        """Power of a dash, as a share of the most."""
        return round(share * self.server.max_dash_power, 6)

    def stamina(self, share: float) -> str:
        """Stamina, as a share of the full one, in an expression."""
        return number(share * self.server.stamina_max)

    def turn(self, angle: str) -> str:
        """Expression of the moment that turns the body by `angle` degrees, against the inertia of one who moves at ``speed``."""
        return f"clip({angle} * (1 + {number(self.kind.inertia_moment)} * speed), {self.moments})"

    @property
    def moments(self) -> str:
        """Least and largest moment, in an expression."""
        return f"{number(self.server.minmoment)}, {number(self.server.maxmoment)}"


DEFAULT = Body()
"""A default player of a default server."""


def of_body(make: Callable[..., Made]) -> Callable[..., Made]:
    """A function of a `Body`, `DEFAULT` if none is given, and of what else it takes, that makes its value once for each."""
    cached = functools.lru_cache(maxsize=64)(make)
    usual = [p.default for p in inspect.signature(make).parameters.values()][1:]

    @functools.wraps(make)
    def made(body: Body = DEFAULT, *more: Any) -> Made:
        return cached(body, *more, *usual[len(more) :])

    return made
