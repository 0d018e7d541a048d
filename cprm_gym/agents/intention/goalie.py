"""The goalie who acts on what the holder of the ball is about to do: the goalie's net, with thresholds on probabilities.

Where the chance of a shot is above a threshold, and its side is sure enough, the ball is taken as if it were on its way along the
expected line; all other decisions are the same net's.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...architecture.cprm import CPRM
from ...architecture.petri import Input, Math
from ...envs.controller import Observation
from ..body import DEFAULT, Body, number
from ..goalie import FAR, GOAL_X, SECOND, ReckoningGoalie, goalie_net
from ..percepts import Percepts
from ..play import SoccerAgent
from ..skills.constants import AttackedConstants, GoalieConstants, HoldingConstants, between
from .tier import Told


@dataclass(frozen=True, kw_only=True)
class IntentionConstants(GoalieConstants):
    """Of the goalie who expects shots."""

    whose: ClassVar[str] = "goalie_intention"

    sure: float = between(0.6, 0.05, 1.0)
    """Probability of a shot above which it is expected."""
    sided: float = between(0.6, 0.5, 1.0)
    """Probability of its side above which it is expected."""
    aim: float = between(1.0, 0.3, 1.3)
    """Share of the expected line's distance from the middle that is believed."""
    pace: float = between(1.0, 0.7, 1.3)
    """Share of the expected speed that is believed."""


@dataclass(frozen=True, kw_only=True)
class AttackedIntentionConstants(AttackedConstants, IntentionConstants):
    """Of the goalie who faces several attackers and expects their shots."""

    whose: ClassVar[str] = "goalie_attacked_intention"


@dataclass(frozen=True, kw_only=True)
class HoldingIntentionConstants(HoldingConstants, IntentionConstants):
    """Of the goalie who expects shots and catches by how likely he is to hold the ball."""

    whose: ClassVar[str] = "goalie_holding_intention"


INTENDED = (
    *(Input(f"known_{name}", observes=f"ball.{name}") for name in ("x", "y", "vx", "vy")),
    *(Input(f"shot_{name}", observes=f"intention.{name}") for name in ("chance", "side", "x", "y", "line", "speed")),
    Input("watched_x", observes="rival.x", value=FAR), Input("watched_y", observes="rival.y"),
)  # fmt: skip
"""The ball as it is known, the shot as it is expected, and the opponent nearest to the ball."""


def expecting(c: IntentionConstants) -> tuple[Math, ...]:
    """Places ``ball_x``, ``ball_y``, ``ball_vx``, ``ball_vy``: the ball as known, or of the shot that is expected."""
    return (
        Math("expected", f"1 if shot_chance > {number(c.sure)} and shot_side > {number(c.sided)} else 0"),
        Math("aim_y", f"{number(c.aim)} * shot_line"),
        Math("aim_way", f"max(0.1, hypot({GOAL_X} - shot_x, aim_y - shot_y))"),
        Math("ball_x", "shot_x if expected else known_x"), Math("ball_y", "shot_y if expected else known_y"),
        Math("ball_vx", f"{number(c.pace)} * shot_speed * ({GOAL_X} - shot_x) / aim_way if expected else known_vx"),
        Math("ball_vy", f"{number(c.pace)} * shot_speed * (aim_y - shot_y) / aim_way if expected else known_vy"),
    )  # fmt: skip


def holding_shots(body: Body, c: HoldingConstants) -> tuple[Input | Math, ...]:
    """Places ``hold`` and ``hold_next``: as believed, or, of a shot that is expected, by where the ball then is."""
    deep = number(round(body.hands - c.early, 10))
    return (
        Input("known_hold", observes="hands.now"), Input("known_next", observes="hands.next"),
        Math("hold", f"(1 if ball_distance < {number(body.hands)} else 0) if expected else known_hold"),
        Math("hold_next", f"(0 if ball_distance < {deep} or next_distance > ball_distance - {number(c.deepening)} else 2)"
                          " if expected else known_next"),
    )  # fmt: skip


@functools.lru_cache(maxsize=64)
def intention_cprm(body: Body = DEFAULT, constants: IntentionConstants = IntentionConstants(), focus: bool = False) -> CPRM:
    """The net on what is known and expected."""
    holds = holding_shots(body, constants) if isinstance(constants, HoldingConstants) else ()
    seen = (*INTENDED, *expecting(constants), *holds, *(SECOND if isinstance(constants, AttackedConstants) else ()))
    net = goalie_net(seen, attended=0, name="goalie_intention", body=body, constants=constants, focus=focus)
    return CPRM("goalie_intention", net=net)


class IntentionGoalie(ReckoningGoalie):
    """The goalie's net on the parts ``memory`` and ``intention`` of an observation (`IntentionTier`).

    Parameters
    ----------
    opponents : int
    body : Body
    constants : IntentionConstants
    focus : bool
        As for `cprm_gym.agents.goalie.goalie_net`.
    """

    def __init__(
        self, opponents: int = 11, body: Body = DEFAULT, constants: IntentionConstants = IntentionConstants(), focus: bool = False
    ) -> None:
        SoccerAgent.__init__(self, intention_cprm(body, constants, focus), self._read, needs=("memory",), body=body)
        self.opponents, self.constants = opponents, constants

    def _read(self, observation: Observation) -> Percepts:
        """As without intention, and ``intention.*``."""
        percepts = super()._read(observation)
        told = np.asarray(observation["intention"], np.float64)
        for name, column in (("chance", Told.CHANCE), ("side", Told.SIDE), ("x", Told.X), ("y", Told.Y), ("line", Told.LINE),
                             ("speed", Told.SPEED)):  # fmt: skip
            percepts[f"intention.{name}"] = told[:, column]
        return percepts
