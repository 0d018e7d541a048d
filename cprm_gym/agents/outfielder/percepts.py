"""What an outfield player perceives, beyond `field_percepts`: whose ball it is, where to shoot, to whom to pass, which way is free.

All from his own observation: positions are those that he remembers. Formulas as the scripted players use them, computed in
`kernels.outfield`; N copies, 11 team-mates, 11 opponents. Metres, cycles, degrees from the own body, in the frame of his team.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping

import numpy as np

from ...architecture.cprm.percepts import PerceptNames, PerceptTable
from ...architecture.petri.execution.state import ObjectTable
from ...envs.controller import Observation
from ...envs.players.scripted import FORMATION
from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ..body import DEFAULT, Body
from ..kernels import outfield as kernels
from ..percepts import GOAL_X, NEVER, OFF_PITCH, parts, table
from .model import PERIOD

STRIDE, START = 0.95, 1.0
"""A running player's share of the top speed, and the cycles that a turn to the ball costs."""
REACHED = 0.593
"""Share of the kickable ring at which a player who runs to the ball has it."""
AT_FEET = 4.0
"""Metres from the ball within which he looks for shots and free ways."""
RECENT = 15
"""Cycles within which an opponent must have been seen to be in the way."""
FORGOTTEN = 40
"""Cycles after which an opponent no longer counts for the offside line."""
CORNER = 0.87
"""How far from its middle he aims at the goal, as a share of its half width."""
SHOT_SPEED = 0.867
"""Speed of a shot, as the lane is judged, as a share of ``ball_speed_max``."""
WAY = 6.0
"""Metres ahead that a free way is looked for."""
SPREAD = 0.35
"""Radians between the ways that are considered, around that to the goal."""
_COLUMNS = PerceptNames(kernels.OUTFIELD)
_PLACES = np.ascontiguousarray(FORMATION, np.float64)


@functools.lru_cache(maxsize=64)
def terms(own: Body = DEFAULT) -> kernels.Terms:
    """What ways, shots and races are judged by; everybody is taken to run as he does."""
    return kernels.Terms(
        goal_x=GOAL_X, half_length=HALF_LENGTH, half_width=HALF_WIDTH, never=NEVER, off_pitch=OFF_PITCH,
        roll=own.roll, fade=own.fade, pace=own.pace(STRIDE), near=own.within(REACHED), start=START, at_feet=AT_FEET,
        recent=float(RECENT), forgotten=float(FORGOTTEN), period=float(PERIOD), aim=CORNER * own.server.goal_width / 2,
        shot=SHOT_SPEED * own.server.ball_speed_max, way=WAY, spread=SPREAD,
    )  # fmt: skip


def outfield_percepts(observation: Observation, own: Body = DEFAULT) -> PerceptTable:
    """What an outfield player perceives.

    Parameters
    ----------
    observation : dict of (N, ...) arrays
        With the part ``memory``.
    own : Body

    Returns
    -------
    dict of (N,) float64
        `field_percepts`, where ``goal.distance`` and ``goal.direction_deg`` are of the point of the goal with the clearest way to it, and
        ``goal.room`` says how clear (m; -20 while the ball is not at his feet); ``way.direction_deg`` (degrees, the freest way ahead);
        ``me.time``, ``meet.x``, ``meet.y`` (when and where he meets the ball); ``place.x``, ``place.y`` (his in the formation); ``line.x``
        (a team-mate beyond it would be offside); ``ball.vx``, ``ball.vy``; ``ball.placed`` (he saw it in the last `PERIOD` cycles, and knew
        where he was); ``game.ours``, ``game.theirs`` (set plays), ``game.kick_off``; for each player of both teams ``t1.seen`` (likewise),
        ``t1.x``, ``t1.y``, ``o1.seen``, ...
    """
    known = parts(observation, "body", "ball", "level", "self", "memory", "memory_age")
    out = table(_COLUMNS, len(known[0]))
    kernels.everybody(*known, _PLACES, terms(own), out.table)
    return out


def outfield_attributes(observation: Observation, own: Body = DEFAULT) -> Mapping[str, Mapping[str, np.ndarray]]:
    """By what he chooses players: attributes of the candidates of his object places.

    Returns
    -------
    dict of str to dict of str to (N, 11) float64
        ``Teammate``: ``x``, ``y``, ``age`` (cycles since he was seen), ``time`` (cycles until he meets the ball, as he was last seen),
        ``distance`` (m from the ball), ``ahead`` (m that a pass to him gains), ``beyond`` (m beyond the offside line), and, 0 while the
        ball is not at the own feet, ``room`` (m, how clear the way to him is) and ``free`` (m to the opponent nearest to him); himself
        and those never seen are not ``present``. ``Opponent``: ``x``, ``y``, ``age``, ``danger`` (the nearer to the ball the more, 0 for
        those not seen for two seconds), ``ball_gap`` (m; 99 for those not seen for half a second).
    """
    known = parts(observation, "body", "self", "memory", "memory_age")
    mates, rivals = (np.empty((len(names), len(known[0]), 11)) for names in (kernels.MATES, kernels.RIVALS))
    kernels.judgements(*known, terms(own), mates, rivals)
    return {"Teammate": ObjectTable(kernels.MATES, mates), "Opponent": ObjectTable(kernels.RIVALS, rivals)}
