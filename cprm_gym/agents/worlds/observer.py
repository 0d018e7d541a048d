"""The world of Appendix A as the simulator has it: its motion, and what its roundings leave of what an agent computes with.

Distances are told in bands: on a logarithmic scale, then in tenths of a metre (specification/simulator.md 6.1.4). The ends of each band are
where the share of the true distance that is told is least and most, so that finitely many quotients bound it.
"""

from __future__ import annotations

import math

import numpy as np

from ...architecture.analysis.certificates.slow_approach import Observer, SlowParams
from ...errors import ParameterError
from ...simulator.parameters import ServerParameters
from ..body import Body

TENTH = 0.1
"""Metres to which distances are told (specification/simulator.md 6.1.4)."""
HUNDREDTH = 0.01
"""m / cycle to which one's own speed is felt (specification/simulator.md 6.2)."""
DEGREE = math.pi / 180
"""To which directions are told."""


def told_shares(parameters: ServerParameters, near: float, far: float) -> tuple[float, float]:
    """Least and most that a told distance is of the true one, between `near` and `far`, m; a little outward for rounding.

    Raises
    ------
    ParameterError
        Where distances can be told as nothing, or are not told in bands.
    """
    step = parameters.quantize_step
    if not 0.0 < near < far or step < 1e-6:
        raise ParameterError(f"told distances between {near} and {far} m in steps of {step}: needs 0 < near < far and a step")
    bands = np.arange(math.floor(math.log(near) / step), math.ceil(math.log(far) / step) + 1)
    low, high = np.clip(np.exp((bands - 0.5) * step), near, far), np.clip(np.exp((bands + 0.5) * step), near, far)
    told = np.rint(np.exp(bands * step) / TENTH) * TENTH
    there = high > low
    least, most = float((told / high)[there].min()), float((told / low)[there].max())
    if least <= 0.0:
        raise ParameterError(f"told distances: {near} m can be told as 0")
    return math.floor(least * 1e6) / 1e6, math.ceil(most * 1e6) / 1e6


def simulator_observer(parameters: ServerParameters | None = None, near: float | None = None, far: float = 60.0) -> Observer:
    """What an agent computes with who divides told distances by the most that they may be too large, and felt speeds by the decay.

    Parameters
    ----------
    parameters : ServerParameters, optional
    near : float, optional
        Metres from which on it has to hold; how far the leg reaches if not given.
    far : float

    Raises
    ------
    ParameterError
    """
    server = parameters or ServerParameters()
    body = Body(server=server)
    least, most = told_shares(server, body.reach if near is None else near, far)
    felt = HUNDREDTH / 2 / body.kind.player_decay  # what is felt is what the decay has left
    return Observer(rho_d=math.floor(least / most * 1e6) / 1e6, rho_s=1.0, e_d=0.0, e_s=2 * felt, h=DEGREE / 2)


def simulator_approach(parameters: ServerParameters | None = None) -> SlowParams:
    """Appendix A's world with the simulator's motion, noise and roundings."""
    server = parameters or ServerParameters()
    body = Body(server=server)
    kind = body.kind
    return SlowParams(
        gamma=kind.player_decay, delta_s=server.player_rand, delta_a=0.0, delta_omega=server.player_rand,
        a_max=round(kind.dash_power_rate * body.server.maxpower, 9), epsilon_d=body.reach,
        observer=simulator_observer(server),
    )  # fmt: skip
