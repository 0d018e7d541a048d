"""Appendix A on a grid of distance, speed and |direction| (specification/appendix_a.md 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .attractor import Attractor, Branch, must_reach
from .slow_approach import SlowParams

WIDER = 1e-9
"""By which every bound is moved outwards: far more than the rounding of the few operations that lead to it."""


@dataclass(frozen=True)
class Grid:
    """Cells of the state: metres, metres a cycle, radians."""

    d_max: float = 12.0
    d_step: float = 0.1
    s_max: float = 1.05
    s_step: float = 0.05
    theta_cells: int = 36

    def edges(self, params: SlowParams) -> tuple[NDArray[np.float64], ...]:
        """Where cells begin and end; distances begin at the goal."""
        d = np.append(np.arange(params.epsilon_d, self.d_max, self.d_step), self.d_max)
        s = np.linspace(0.0, self.s_max, round(self.s_max / self.s_step) + 1)
        return d, s, np.linspace(0.0, np.pi, self.theta_cells + 1)


def threshold_attractor(params: SlowParams, tau: float, grid: Grid | None = None) -> Attractor:
    """From where the agent that turns where it sees the ball farther off axis than `tau` arrives for sure, and within how many steps.

    Parameters
    ----------
    params : SlowParams
        Accelerations are forward only (a_min = 0).
    tau : float
        Radians.
    grid : Grid, optional
    """
    edges = (grid or Grid()).edges(params)
    return must_reach(edges, branches(params, tau, edges), params.epsilon_d)


def branches(params: SlowParams, tau: float, edges: tuple[NDArray[np.float64], ...]) -> tuple[Branch, Branch]:
    """What turning, and accelerating, may do from each cell."""
    low = np.stack([x.ravel() for x in np.meshgrid(*(e[:-1] for e in edges), indexing="ij")], axis=1)
    high = np.stack([x.ravel() for x in np.meshgrid(*(e[1:] for e in edges), indexing="ij")], axis=1)
    g, h = params.gamma, params.observer.h
    (d1, s1, t1), (d2, s2, t2) = low.T, high.T
    ds, da, dw, o = params.delta_s, params.delta_a, params.delta_omega, params.observer
    kappa, c = float(params.kappa), (1 - g) / ((1 + ds) * (1 + da))
    off = h + dw * np.minimum(t2 + h, np.pi)
    turn = _moved(params, d1, d2, np.zeros_like(d1), np.minimum(off + WIDER, np.pi), g * s1, g * s2)
    if da == 0.0:  # c kappa = gamma: the speed drops out but for what is seen wrongly
        least = c * (o.rho_d * d1 - o.e_d) - g * ((o.rho_s - 1) * s2 + o.e_s)
        v1, v2 = np.clip(least, g * s1, g * s1 + params.a_max), np.clip(c * d2, g * s2, g * s2 + params.a_max)
    else:
        a1 = np.clip(c * (o.rho_d * d1 - o.e_d - kappa * (o.rho_s * s2 + o.e_s)), 0.0, params.a_max)
        a2 = np.clip(c * (d2 - kappa * s1), 0.0, params.a_max)
        v1, v2 = g * s1 + (1 - da) * a1, g * s2 + (1 + da) * a2
    dash = _moved(params, d1, d2, t1, t2, v1, v2)
    made = []
    for may, (a, b) in ((t2 + h > tau - WIDER, turn), (t1 - h <= tau + WIDER, dash)):
        made.append(Branch(may, a, b, b[:, 0] < params.epsilon_d))
    return made[0], made[1]


def _moved(
    params: SlowParams, d1: NDArray[np.float64], d2: NDArray[np.float64], a1: NDArray[np.float64], a2: NDArray[np.float64],
    v1: NDArray[np.float64], v2: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:  # fmt: skip
    """Enclosure of the next (d, s, |theta|): from distance, bearing |alpha| and speed."""
    v1, v2 = np.maximum(v1 - WIDER, 0.0), v2 + WIDER
    noise = params.delta_s * v2
    cos1, cos2 = np.cos(a2), np.cos(a1)  # least and most
    along1, along2 = np.minimum(d1 * cos1, d2 * cos1) - v2, np.maximum(d1 * cos2, d2 * cos2) - v1
    across1 = d1 * np.minimum(np.sin(a1), np.sin(a2))
    near = np.where((along1 <= 0) & (along2 >= 0), 0.0, np.minimum(np.abs(along1), np.abs(along2)))
    least = np.hypot(near, across1)
    most = np.zeros_like(d1)
    for d in (d1, d2):
        for v in (v1, v2):
            for cosine in (cos1, cos2):
                most = np.maximum(most, np.sqrt(np.maximum(d * d - 2 * d * v * cosine + v * v, 0.0)))
    plain = (noise < least * (1 - 1e-9)) & (d1 > v2)  # the bearing grows with alpha and v and falls with d
    spread = np.arcsin(np.where(plain, np.minimum(noise / np.where(least > 0, least, 1.0), 1.0), 1.0))
    theta1 = np.where(plain, np.arctan2(d2 * np.sin(a1), d2 * np.cos(a1) - v1) - spread, 0.0)
    theta2 = np.where(plain, np.arctan2(d1 * np.sin(a2), d1 * np.cos(a2) - v2) + spread, np.pi)
    low = np.stack((least - noise, v1, np.clip(theta1, 0.0, np.pi)), axis=1) - WIDER
    high = np.stack((most + noise, v2, np.clip(theta2, 0.0, np.pi)), axis=1) + WIDER
    low[:, 1:] = np.maximum(low[:, 1:], 0.0)  # neither is negative
    high[:, 2] = np.minimum(high[:, 2], np.pi)
    return low, high
