"""What a player did in a cycle, from what he feels and what he sent, and what he then says of himself."""

from __future__ import annotations

import math

from .....envs.observations import BodyFeature, SelfFeature
from .....simulator.state import CommandKind
from . import kernel
from .reading import PI, turned_back

DEGREE = PI / 180.0
TURN, LEGS = int(CommandKind.TURN), int(CommandKind.DASH_LEGS)
NECK, PACE, WAY = int(BodyFeature.NECK), int(BodyFeature.SPEED), int(BodyFeature.SPEED_DIRECTION)
HIT_BALL, HIT_PLAYER, HIT_POST = int(BodyFeature.COLLIDED_BALL), int(BodyFeature.COLLIDED_PLAYER), int(BodyFeature.COLLIDED_POST)
TACKLED, CHARGED = int(BodyFeature.TACKLE_EXPIRES), int(BodyFeature.FOUL_CHARGED)
X, Y, VX, VY, BODY, FACE, LOCATED, FREE = (int(feature) for feature in SelfFeature)
(TWIST, MOMENT_LOW, MOMENT_HIGH, INERTIA, TURN_NOISE, NECK_LOW, NECK_HIGH, DECAY, STRAY, BUMPED) = range(10)
"""What the numbers of ``b`` are."""
LEGS_TWIST = 1.0
"""rad by which a dash of one leg may turn him."""
ANGLE_ERROR = 0.3 * DEGREE
"""Deviation of an angle that is told in whole degrees."""
SLIGHT = 1e-6


@kernel
def middle(angle):
    """The middle of the angles (rad) that are told so in whole degrees, towards 0."""
    degrees = round(angle / DEGREE)
    return angle + (0.5 * DEGREE if degrees > 0.0 else -0.5 * DEGREE if degrees < 0.0 else 0.0)


@kernel
def motion_of(felt, kinds, moments, necks, neck, speed, free, still, b, motion):
    """Motions of N agents as `pose.know_pose` takes them; `neck`, `speed` and `free` are brought up to date.

    felt : (N, 24) of `BodyFeature`; kinds : (N,) commands sent; moments, necks : (N,) turns of body and neck commanded, rad
    neck : (N,) rad; speed : (N,) m / cycle, as felt a cycle ago; free : (N,) bool, the body obeyed then
    still : (N,) bool, the news are those of before; motion : (N, 5)
    """
    for n in range(len(felt)):
        if still[n]:
            for i in range(5):
                motion[n, i] = 0.0
            continue
        body = felt[n]
        turn, twist = 0.0, b[TWIST]
        if kinds[n] == TURN and free[n]:
            turn = min(b[MOMENT_HIGH], max(b[MOMENT_LOW], moments[n])) / (1.0 + b[INERTIA] * speed[n])
            twist = math.hypot(twist, abs(turn) * b[TURN_NOISE])
        elif kinds[n] == LEGS:
            twist = LEGS_TWIST
        after = min(b[NECK_HIGH], max(b[NECK_LOW], neck[n] + necks[n]))
        # it is told in whole degrees, towards 0: what was commanded is better while it agrees
        told, mine = round(body[NECK] / DEGREE), after / DEGREE
        if math.trunc(mine + SLIGHT) != told and math.trunc(mine - SLIGHT) != told:
            after, twist = middle(body[NECK]), math.hypot(twist, ANGLE_ERROR)
        step = body[PACE] / b[DECAY] if b[DECAY] > 0.0 else 0.0
        stray = math.hypot(b[STRAY], ANGLE_ERROR * step)
        if body[HIT_BALL] > 0.0 or body[HIT_PLAYER] > 0.0 or body[HIT_POST] > 0.0:
            stray = b[BUMPED]
        motion[n, 0], motion[n, 1], motion[n, 2] = turn + after - neck[n], twist * twist, step
        motion[n, 3], motion[n, 4] = middle(body[WAY]), stray * stray
        neck[n], speed[n] = after, body[PACE]
        free[n] = body[TACKLED] <= 0.0 and body[CHARGED] <= 0.0


@kernel
def tell_self(felt, mean, known, free, me):
    """What N agents say of themselves, (N, 8) of `SelfFeature`, into `me`: the body is the face less the neck as felt."""
    for n in range(len(felt)):
        face, pace = mean[n, 0], felt[n, PACE]
        heading = face + middle(felt[n, WAY])
        me[n, X], me[n, Y] = mean[n, 1], mean[n, 2]
        me[n, VX], me[n, VY] = pace * math.cos(heading), pace * math.sin(heading)
        me[n, BODY], me[n, FACE] = turned_back(face - felt[n, NECK]), turned_back(face)
        me[n, LOCATED], me[n, FREE] = known[n], free[n]
