"""The world of Appendix A as the simulator has it: its motion, and what its roundings leave of what an agent computes with.

Distances are told in bands: on a logarithmic scale, then in tenths of a metre (specification/simulator.md 6.1.4). The ends of each band are
where the share of the true distance that is told is least and most, so that finitely many quotients bound it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...architecture.analysis.certificates.slow_approach import Observer, SlowParams
from ...errors import ParameterError
from ...simulator.kernels.rounding import banded_distance
from ...simulator.parameters import Rules, ServerParameters
from ...simulator.simulator import Simulator, no_commands
from ...simulator.state import CommandKind, PlayMode
from ..body import Body

TENTH = 0.1
"""Metres to which distances are told (specification/simulator.md 6.1.4)."""
HUNDREDTH = 0.01
"""m / cycle to which one's own speed is felt (specification/simulator.md 6.2)."""
DEGREE = math.pi / 180
"""To which directions are told."""
TAU = 0.44
"""Radians off axis at which the approach turns: from here on the proof holds with the simulator's noise."""


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
    """Appendix A's world with the simulator's motion, noise and roundings.

    A turn is off by the noise, and by what the inertia is compensated with a felt speed: ``(1 + inertia felt) / (1 + inertia true)``.
    """
    server = parameters or ServerParameters()
    body = Body(server=server)
    kind = body.kind
    turning = (1 + server.player_rand) * (1 + kind.inertia_moment * HUNDREDTH / 2) - 1
    return SlowParams(
        gamma=kind.player_decay, delta_s=server.player_rand, delta_a=0.0, delta_omega=math.ceil(turning * 1e6) / 1e6,
        a_max=round(kind.dash_power_rate * body.server.maxpower, 9), epsilon_d=body.reach,
        observer=simulator_observer(server),
    )  # fmt: skip


def simulated_approaches(
    worlds: int, seed: int = 0, tau: float = TAU, start: float = 12.0, parameters: ServerParameters | None = None, limit: int = 400
) -> NDArray[np.int64]:
    """Cycles that the approach of Appendix A takes in the simulator, from anywhere up to a distance, standing, facing anywhere.

    The agent computes with what it is told: bands of distance, whole degrees, hundredths of a speed. The world is the simulator's own: a
    turn leaves the way that he already rolls, and noise stays in his speed, which the appendix leaves out.

    Parameters
    ----------
    worlds, seed : int
    tau : float
        He turns where he is told the ball farther off axis, radians.
    start : float
        Largest distance at the beginning, m.
    parameters : ServerParameters, optional
    limit : int

    Returns
    -------
    (worlds,) int64
        -1: not within the limit.
    """
    world = simulator_approach(parameters)
    server = parameters or ServerParameters()
    kind = Body(server=server).kind
    _, most = told_shares(server, world.epsilon_d, 60.0)
    sim = Simulator(worlds, server, rules=Rules.NONE, left=1, right=0, goalies=(0, 0), seed=seed)
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(1,)))
    sim.world["mode"] = PlayMode.play_on
    sim.trainer.place_ball(0.0, 0.0)
    away, angle = rng.uniform(world.epsilon_d, start, worlds), rng.uniform(-math.pi, math.pi, worlds)
    sim.trainer.place_player(1, away * np.cos(angle), away * np.sin(angle), rng.uniform(-math.pi, math.pi, worlds), (0.0, 0.0))
    kappa, gain = float(world.kappa), (1.0 - world.gamma) / (1.0 + world.delta_s)
    cycles, commands = np.full(worlds, -1, np.int64), no_commands(worlds, 22)
    told = np.vectorize(banded_distance, otypes=[float])
    for cycle in range(limit):
        me = sim.world["pos"][:, 1]
        distance = np.hypot(me[:, 0], me[:, 1])
        cycles[(cycles < 0) & (distance < world.epsilon_d)] = cycle
        if (cycles >= 0).all():
            break
        off = np.rint(_between(np.arctan2(-me[:, 1], -me[:, 0]) - sim.world["body"][:, 0]) / DEGREE)
        felt = np.rint(np.hypot(*sim.world["vel"][:, 1].T) / HUNDREDTH) * HUNDREDTH
        near, fast = told(distance, server.quantize_step) / most, (felt + HUNDREDTH / 2) / world.gamma
        turns = np.abs(off) * DEGREE > tau
        commands["kind"][:, 0] = np.where(turns, CommandKind.TURN, CommandKind.DASH)
        push = np.clip(gain * (near - kappa * fast), 0.0, world.a_max) / kind.dash_power_rate
        commands["a"][:, 0] = np.where(turns, np.clip(off * (1.0 + kind.inertia_moment * felt), -180.0, 180.0), push)
        commands["b"][:, 0] = 0.0
        sim.step(commands)
    return cycles


def _between(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same from -pi to pi."""
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)
