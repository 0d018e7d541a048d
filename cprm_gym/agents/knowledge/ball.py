"""The ball from raw senses: a relational model of real numbers, and what a player is told as readings of it.

Where the ball is and how it moves is a normal for each mode: it rolls, or somebody changed its way; the look is of now, or of before the
step. Steps of the eye are intervals, and noise has its size.

References
----------
Dissertation Fig. 2.25 has the same variables on ten bins; specification/simulator.md 6.1.4 and 6.1.5 say what the eye tells.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...architecture.prm.model.cpds import CPD, Noise, Prior, Switch, Table
from ...architecture.prm.model.domains import BOOL, Interval, Real
from ...architecture.prm.model.model import Model
from ...architecture.prm.model.schema import Attribute, Given, PRMClass
from ...envs.controller import Observation
from ...envs.observations import ObjectFeature, SelfFeature
from ...envs.players.senses import NOISE, Senses
from ...simulator.senses import BallLevel
from ..body import Body, number
from ..skills.constants import Constants, between
from .kernels.eye import RATE_STEP, ROUNDING, SWING_STEP, all_told_between

SELF = ("x", "y", "vx", "vy")
"""What the player knows of himself: place and velocity; where he looks is in the readings."""


@dataclass(frozen=True, kw_only=True)
class BallConstants(Constants):
    """What the model of the ball has of its own; the defaults were found by the least error about the ball, as the tracker's."""

    whose: ClassVar[str] = "ball"

    kicked: float = between(0.15, 0.01, 0.9)
    """Probability that a player who can changes the ball's way in a cycle."""
    knocked: float = between(0.02, 0.0001, 0.1)
    """That it changes with nobody there who is known of."""
    swerve: float = between(1.4, 0.1, 2.5)
    """m / cycle by which it then does (standard deviation)."""
    turned: float = between(0.44, 0.1, 3.0)
    """Error of where he believes to look, degrees."""
    placed: float = between(0.1, 0.01, 0.5)
    """Error of where he believes to be, m."""
    paced: float = between(0.013, 0.002, 0.2)
    """Error of how he believes to move, m / cycle."""
    late: float = between(0.28, 0.01, 0.99)
    """Share of the looks of an asynchronous eye that show the world before the step."""


def ball_model(body: Body, senses: Senses, constants: BallConstants) -> Model:
    """The ball, as one player with these senses can know it.

    Parameters
    ----------
    body : Body
        Of whom it is the ball: the server's decay and noise.
    senses : Senses
        What is known of the noise.
    constants : BallConstants
    """
    c, decay, rand = constants, body.ball_decay, number(0.6 * body.server.ball_rand)
    kept = number(decay)
    given = [Given(f"{who}_{name}", Real("m")) for who in ("me", "was")[: 1 + senses.asynchronous] for name in SELF]
    given += [Given("seen_cos", Real(), 1.0), Given("seen_sin", Real(), 0.0), Given("told_far", Real("m"), 1.0)]
    given += [Given("told_rate", Real(), 0.0), Given("told_turn", Real(), 0.0)]
    given += [Given("rolling", Real("m/cycle"), 0.0)]
    given += [Given("push_x", Real("m/cycle"), 0.0), Given("push_y", Real("m/cycle"), 0.0), Given("played", BOOL, "no")]

    def velocity(axis: str) -> Attribute:
        moved = f"{kept} * (prev.v{axis} + push_{axis})"
        rolls = Noise(moved, sd=f"{kept} * ({rand} * (rolling + 0.15 * hypot(push_x, push_y)) + 0.003)")
        parents = (f"prev.v{axis}", "rolling", "push_x", "push_y", "kicked")
        cpd = Switch("kicked", {"no": rolls, "yes": Noise(moved, sd=c.swerve)})
        return Attribute(f"v{axis}", Real("m/cycle"), cpd, parents, initial=Noise("0", sd=1.5))

    def place(axis: str) -> Attribute:
        parents = (f"prev.{axis}", f"v{axis}")
        start = Noise(f"me_{axis}", sd=40.0)
        return Attribute(axis, Real("m"), Noise(f"prev.{axis} + v{axis} / {kept}", sd=0.005), parents, start, (f"me_{axis}",))

    kicked = Table({("yes",): (1.0 - c.kicked, c.kicked), ("no",): (1.0 - c.knocked, c.knocked)})
    attributes = [Attribute("kicked", BOOL, kicked, ("played",)), velocity("x"), velocity("y"), place("x"), place("y")]
    if senses.asynchronous:
        attributes.append(Attribute("late", BOOL, Prior((1.0 - c.late, c.late))))
    attributes += [_reading(name, senses, constants) for name in ("far", "aside", "approach", "swing")]
    return Model("ball from raw senses", (PRMClass("Ball", tuple(attributes), given=tuple(given)),))


def _reading(name: str, senses: Senses, constants: BallConstants) -> Attribute:
    """One of the readings: how far the ball is along the line on which it was seen and beside it, and how it moves along and across."""
    own = ("x", "y") if name in ("far", "aside") else SELF
    now = _look(name, "", "me", senses, constants)
    share = {"approach": ("told_rate",), "swing": ("told_turn",)}.get(name, ())
    parents = (*own, *(f"me_{part}" for part in own), "seen_cos", "seen_sin", "told_far", *share)
    if not senses.asynchronous:
        return Attribute(f"seen_{name}", Real("m"), now, parents)
    late = Switch("late", {"no": now, "yes": _look(name, "prev.", "was", senses, constants)})
    more = (*(f"prev.{part}" for part in own), *(f"was_{part}" for part in own), "late")
    return Attribute(f"seen_{name}", Real("m"), late, (*parents, *more), now, parents)


def _look(name: str, lag: str, me: str, senses: Senses, constants: BallConstants) -> CPD:
    """A reading as the eye gives it from a place `me`, of the ball in this slice or, with a lag, the one before.

    The frame is turned to where the ball was seen: all is a straight line of what is sought. Changes are told as shares of the distance:
    what is read of a velocity is by how much it differs from that share of how far the ball is, whatever that may be.
    """
    c, noise = constants, senses.noise * np.array(NOISE)
    v = "" if name in ("far", "aside") else "v"
    far, aside = shares(senses, constants)
    dx, dy = f"({lag}{v}x - {me}_{v}x)", f"({lag}{v}y - {me}_{v}y)"
    along, across = f"{dx} * seen_cos + {dy} * seen_sin", f"{dy} * seen_cos - {dx} * seen_sin"
    away = f"(({lag}x - {me}_x) * seen_cos + ({lag}y - {me}_y) * seen_sin)"
    mean, sd = {
        "far": (along, f"hypot({number(c.placed)}, {number(far)} * told_far)"),
        "aside": (across, f"hypot({number(c.placed)}, {number(aside)} * told_far)"),
        "approach": (f"{along} - told_rate * {away}", number(float(np.hypot(c.paced, noise[2])))),
        "swing": (f"{across} - told_turn * {away}", f"hypot({number(c.paced)}, {number(float(noise[3]))} * told_far)"),
    }[name]
    return Noise(mean, sd=sd)


def shares(senses: Senses, constants: BallConstants) -> tuple[float, float]:
    """Deviations of a reading along the line of sight and across it, besides the steps of the eye, as shares of the distance."""
    noise = senses.noise * np.array(NOISE)
    return float(np.hypot(2.0 * senses.gaussian, noise[0])), float(np.hypot(np.radians(constants.turned), noise[1]))


def misplaced(readings: Mapping[str, Any], away: np.ndarray, senses: Senses, constants: BallConstants) -> np.ndarray:
    """By how much the ball is elsewhere in the player's own picture, because he is not where he believes to be.

    What a reading leaves beside the belief is his own error by the share that this has in their variance: its expectation, as all is
    a straight line with normal noise.

    Parameters
    ----------
    readings : dict
        Of `ball_readings`.
    away : (N, 2) array
        Where the ball is believed to be, from where he believes to be, m.
    senses : Senses
    constants : BallConstants

    Returns
    -------
    (N, 2) array
        m; 0 where nothing was read.
    """
    cos, sin, far = (np.asarray(readings[f"ball.{name}"]) for name in ("seen_cos", "seen_sin", "told_far"))
    found = []
    for name, at, share in zip(
        ("far", "aside"), (away[:, 0] * cos + away[:, 1] * sin, away[:, 1] * cos - away[:, 0] * sin), shares(senses, constants)
    ):
        low, high = readings[f"ball.seen_{name}"].low, readings[f"ball.seen_{name}"].high
        others = (share * far) ** 2 + (high - low) ** 2 / 12.0
        found.append(np.nan_to_num((0.5 * (low + high) - at) * constants.placed**2 / (constants.placed**2 + others)))
    along, across = found
    return np.stack([along * cos - across * sin, along * sin + across * cos], axis=1)


def ball_readings(
    observation: Observation, me: np.ndarray, senses: Senses, step: float, expected: np.ndarray | None = None
) -> tuple[dict[str, Any], np.ndarray]:
    """What the eye tells as readings of `ball_model`, and who saw the ball.

    Parameters
    ----------
    observation : dict of (N, ...) arrays
    me : (N, 8) array of `SelfFeature`
        What he believes of himself.
    senses : Senses
    step : float
        Of the eye in the logarithm of a distance (``quantize_step``).
    expected : (N,) array, optional
        How far the ball was expected to be, m; NaN where nothing is known. Errors are shares of the true distance: if those of what is
        told were taken, readings that are too short would count for more.

    Returns
    -------
    readings : dict of str to Interval or (N,) array
    seen : (N,) bool array
    """
    row = np.asarray(observation["ball"], np.float64)
    level = np.asarray(observation["level"])[:, 0]
    seen = (level > 0) & (me[:, SelfFeature.LOCATED] > 0)
    told = np.where(seen, np.maximum(row[:, ObjectFeature.DISTANCE], 0.05), np.nan)
    moving = seen & (level >= BallLevel.MOVING)
    blurred = senses.noise * NOISE[0]
    coarse = 0.0 if senses.gaussian else 1.0
    half, rounding = coarse * 0.5 * senses.quantise * step, coarse * 0.5 * ROUNDING
    mean = np.exp(-0.5 * blurred**2)  # of a distance whose logarithm has a normal error, as a share of the mean of what is told
    low, high = np.maximum(told - rounding, 0.0) * np.exp(-half) * mean, (told + rounding) * np.exp(half) * mean
    if senses.noise == 0.0 and not senses.gaussian:
        all_told_between(told, step, float(senses.quantise), low, high)
    far = middle = 0.5 * (low + high)
    if expected is not None:
        most = 3.0 * np.hypot(2.0 * senses.gaussian, blurred) + half
        near = np.clip(expected, middle / (1.0 + most), middle / max(1.0 - most, 0.25))
        far = np.where(np.isnan(expected), middle, near)
    approach, turn = row[:, ObjectFeature.DISTANCE_CHANGE], row[:, ObjectFeature.DIRECTION_CHANGE]
    # a change of distance is told as a share of the distance that is told, unless one of them was blurred or coarsened afterwards
    tied = senses.gaussian > 0.0 or (senses.noise == 0.0 and senses.quantise == 1.0)
    rate = np.where(moving, approach / told, 0.0) if tied else np.zeros(len(told))
    pace = 0.25 * RATE_STEP if senses.gaussian else 0.5 * RATE_STEP * far
    afterwards = blurred + (0.5 * senses.quantise * step if senses.quantise > 1.0 else 0.0) if tied else 0.5 * step
    if not tied or afterwards:
        pace = pace + np.abs(approach) * afterwards
    sight = me[:, SelfFeature.FACE] + row[:, ObjectFeature.DIRECTION]

    def interval(middle: Any, half: Any, there: np.ndarray) -> Interval:
        return Interval(np.where(there, middle - half, np.nan), np.where(there, middle + half, np.nan))

    nothing = np.zeros(len(told))
    readings: dict[str, Any] = {
        "seen_far": Interval(low, high),
        "seen_aside": interval(nothing, np.radians(0.5 * senses.quantise) * far, seen),
        "seen_approach": interval(nothing if tied else approach, pace + 0.002, moving),
        "seen_swing": interval(nothing, 0.5 * np.radians(SWING_STEP) * far + 0.002, moving),
        "seen_cos": np.cos(sight), "seen_sin": np.sin(sight), "told_far": np.where(seen, far, 1.0),
        "told_rate": rate, "told_turn": np.where(moving, turn, 0.0),
    }  # fmt: skip
    return {f"ball.{name}": reading for name, reading in readings.items()}, seen
