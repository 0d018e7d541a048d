"""Appendix A in closed form: the approach to a ball that lies still (specification/appendix_a.md 4).

In every cycle the agent turns or accelerates. Turn: alpha = theta - omega (1 + xi), s' = g s. Accelerate: alpha = theta,
s' = g s + a (1 + xi). Both: d' exp(i theta') = d exp(i alpha) - s' (1 + xi), |xi| <= ds complex. It sees theta up to h, and computes with
d_c and s_c, rho_d d - e_d <= d_c <= d and s <= s_c <= rho_s s + e_s; a = clip(c (d_c - kappa s_c), a_min, a_max).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from ....errors import ModelError
from .rationals import PI_HIGH, PI_LOW, cosine, down, root, sine, up


def exact(x: float | Fraction) -> Fraction:
    """A number as the decimal that it is written as: 0.1 is 1/10."""
    return x if isinstance(x, Fraction) else Fraction(repr(float(x)))


@dataclass(frozen=True)
class Observer:
    """What the agent computes with."""

    rho_d: float = 0.857
    rho_s: float = 1.0
    e_d: float = 0.0
    e_s: float = 0.025
    h: float = 0.0087266463
    """Error of the direction, radians."""


@dataclass(frozen=True)
class SlowParams:
    """The world of Appendix A.

    Attributes
    ----------
    gamma : float
        Share of the speed that is left in the next cycle.
    delta_s, delta_a, delta_omega : float
        Errors of motion, acceleration, rotation.
    a_max, theta_max : float
        Bounds of the inputs.
    epsilon_d : float
        Arrived below this distance.
    observer : Observer

    Raises
    ------
    ModelError
    """

    gamma: float = 0.4
    delta_s: float = 0.1
    delta_a: float = 0.0
    delta_omega: float = 0.1
    a_max: float = 0.6
    theta_max: float = 3.15
    epsilon_d: float = 1.085
    observer: Observer = Observer()

    def __post_init__(self) -> None:
        if not (0 < self.gamma < 1 and 0 <= self.delta_s < 1 and 0 <= self.delta_a < 1 and self.delta_omega >= 0):
            raise ModelError(f"slow approach: needs 0 < gamma < 1 and errors from 0 below 1, got {self}")
        if not (self.a_max > 0 and self.epsilon_d > 0):
            raise ModelError(f"slow approach: a_max {self.a_max} and epsilon_d {self.epsilon_d} must be positive")

    @property
    def w(self) -> Fraction:
        """W: the largest speed, as a share of the distance."""
        return (1 - exact(self.gamma)) / (1 + exact(self.delta_s))

    @property
    def kappa(self) -> Fraction:
        """The invariant is d >= kappa s."""
        return exact(self.gamma) * (1 + exact(self.delta_s)) / (1 - exact(self.gamma))

    @property
    def w_min(self) -> Fraction:
        """The least speed after an unsaturated acceleration, as a share of the distance (lemma L2)."""
        o, da = self.observer, exact(self.delta_a)
        eta = (exact(o.e_d) + self.kappa * exact(o.e_s)) / exact(self.epsilon_d)
        keeps = (1 - da) / (1 + da)
        return self.w * min(keeps * (exact(o.rho_d) - eta), 1 - exact(o.rho_s) + exact(o.rho_d) - eta)

    def turned(self, x: Fraction) -> Fraction:
        """R(x): the most that the ball is off axis after a turn from x (lemma L5)."""
        h = exact(self.observer.h)
        return h + exact(self.delta_omega) * min(x + h, PI_HIGH)


class Condition(NamedTuple):
    """A named condition, and by how much it holds (negative: fails), a lower bound."""

    name: str
    margin: Fraction

    @property
    def holds(self) -> bool:
        """Whether it is shown to hold."""
        return self.margin >= 0


@dataclass(frozen=True)
class Certificate:
    """Angles from which the proof follows.

    Attributes
    ----------
    e_w : float
        Most that the ball is off axis when he may turn.
    e_a : float
        Most that it is after a turn and its cycle.
    tau : float or None
        He turns where he sees it farther off axis; None: strictly in turn, turning first.
    """

    e_w: float
    e_a: float
    tau: float | None = None

    def check(self, params: SlowParams, start: float = 12.0) -> Proof:
        """Check every condition in exact fractions, and bound the steps from a distance.

        Parameters
        ----------
        params : SlowParams
        start : float
            Distance at the beginning, m.
        """
        p, e_w, e_a, h = params, exact(self.e_w), exact(self.e_a), exact(params.observer.h)
        a = e_a if self.tau is None else exact(self.tau) + h
        conditions = [
            Condition("S1: a step goes forward", p.w_min - Fraction(1, 10**12)),
            Condition("S2: turns are not cut", exact(p.theta_max) - min(e_w + h, PI_HIGH)),
            Condition("C1: an acceleration keeps the cone", _cone(p, a, e_w)),
            Condition("C2: a turn brings it into the inner cone", _cone(p, p.turned(e_w), e_a)),
            Condition("P1: accelerating closes in", _closes(p, a) - Fraction(1, 10**12)),
            Condition("P2: turning does not lead away", _closes(p, p.turned(e_w))),
        ]
        if self.tau is not None:
            conditions.append(Condition("T: what is seen off axis is worth a turn", exact(self.tau) - h - e_a))
        anyhow = min(_cone(p, p.turned(PI_HIGH), e_w), _closes(p, p.turned(PI_HIGH))) >= 0
        if not all(c.holds for c in conditions):
            return Proof(tuple(conditions), Fraction(1), Fraction(0), None, anyhow)
        w = p.w
        mu = down((1 - root(up(1 + w * w - 2 * w * cosine(a)[0]))[1] - exact(p.delta_s) * w) / w)
        ratio, amount = up(1 - mu * p.w_min), down(mu * (1 - exact(p.delta_a)) * exact(p.a_max))
        steps = _steps(exact(start), exact(p.epsilon_d), ratio, amount)
        return Proof(tuple(conditions), ratio, amount, None if steps is None else 2 * steps + 1 + anyhow, anyhow)


class Proof(NamedTuple):
    """What follows from a certificate."""

    conditions: tuple[Condition, ...]
    ratio: Fraction
    amount: Fraction
    """Each acceleration gives d' <= max(ratio d, d - amount)."""
    steps: int | None
    """Bound on all steps from the start's distance; None where nothing is proved."""
    any_direction: bool
    """Whether it holds from every direction (one more turn, counted), else from those within e_w."""

    @property
    def proved(self) -> bool:
        """Whether all conditions hold."""
        return all(c.holds for c in self.conditions) and self.steps is not None


def _cone(p: SlowParams, a: Fraction, e: Fraction) -> Fraction:
    """Margin of: off axis by at most a before the cycle, at most e after it (lemma L3)."""
    if e >= PI_HIGH:
        return Fraction(1)
    if a > e:
        return e - a
    most = up(p.w * (sine(e)[1] + exact(p.delta_s)))
    least = sine(e - a)[0]
    if e > PI_LOW / 2:
        least = min(least, sine(e)[0])
    return least - most


def _closes(p: SlowParams, a: Fraction) -> Fraction:
    """Margin of: moving while off axis by at most a brings it nearer (r_A < 1, lemma L4)."""
    if a > PI_LOW:
        return Fraction(-1)
    return 2 * (cosine(a)[0] - exact(p.delta_s)) - p.w * (1 - exact(p.delta_s) ** 2)


def _steps(start: Fraction, goal: Fraction, ratio: Fraction, amount: Fraction) -> int | None:
    """Accelerations from a distance below the goal's."""
    d, count = up(start), 0
    while d >= goal:
        d, count = up(max(ratio * d, d - amount)), count + 1
        if count > 100_000:
            return None
    return count


def propose(params: SlowParams, *, tau: float | None = None) -> Certificate | None:
    """Angles that should do, found in floats: to be checked.

    Parameters
    ----------
    params : SlowParams
    tau : float, optional
        Threshold; default: alternate strictly.

    Returns
    -------
    Certificate or None
        None where no fixed point is found.
    """
    w, ds, h, dw = float(params.w), params.delta_s, params.observer.h, params.delta_omega

    def widened(a: float) -> float:
        far = math.sqrt(max(1 + w * w - 2 * w * math.cos(a), 1e-300))
        return math.pi + 1e-3 if a >= math.pi or ds * w >= far else math.atan2(math.sin(a), math.cos(a) - w) + math.asin(ds * w / far)

    def turned(x: float) -> float:
        return h + dw * min(x + h, math.pi)

    a = turned(0.0) if tau is None else tau + h
    for _ in range(10_000):
        e_w = widened(a) + 1e-4
        e_a = widened(turned(min(e_w, math.pi))) + 1e-4
        if tau is not None:
            return Certificate(round(e_w, 9), round(e_a, 9), tau)
        if e_a <= a:
            return Certificate(round(e_w, 9), round(a, 9))
        a = max(e_a, a + 1e-9)
        if a >= math.pi:
            return None
    return None


class Printed(NamedTuple):
    """What becomes of the conditions as Figure A.5 prints them."""

    feasible: bool
    contradictory: tuple[str, ...]
    """Conditions that cannot hold together, whatever the bounds."""
    gain: float
    """(pi / 2 gamma)^2 delta_omega: from 1 on c2 and c3 exclude each other."""


def printed_conditions(params: SlowParams, h_s: float = 0.0) -> Printed:
    """Whether any bounds satisfy the seven printed conditions (specification/appendix_a.md 2).

    With M = pi / (2 gamma) and T = ds + h (1 + dw): feasible iff M^2 dw < 1, (M^2 T + M ds) / (1 - M^2 dw) + ds <= arccos(1 - gamma) and
    h_s <= da. A contradiction is certain (pi is bounded from below).

    Parameters
    ----------
    params : SlowParams
    h_s : float
        The printed error of the observed speed.
    """
    p, h = params, exact(params.observer.h)
    m = PI_LOW / (2 * exact(p.gamma))
    ds, dw = exact(p.delta_s), exact(p.delta_omega)
    gain = m * m * dw
    wrong: tuple[str, ...] = ()
    if gain >= 1:
        wrong = ("c2", "c3")
    else:
        t = ds + h * (1 + dw)
        bound = (m * m * t + m * ds) / (1 - gain) + ds
        if bound > PI_HIGH or cosine(bound)[1] < 1 - exact(p.gamma):
            wrong = ("c2", "c3", "c7")
    if exact(h_s) > exact(p.delta_a):
        wrong = (*wrong, "c5")
    return Printed(not wrong, wrong, float(gain))
