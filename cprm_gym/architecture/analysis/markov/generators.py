"""Chains of any size for tests and measurements: like a behaviour, random, a sheet, a walk."""

from __future__ import annotations

import numpy as np

from .chain import MarkovChain, start_at


def behaviour_chain(stages: int, timer: int = 50, values: int = 20, seed: int = 0) -> MarkovChain:
    """Stages that each wait for the world with a time-out: ``stages * timer * values + 2`` states.

    In every cycle the world (`values` values) moves by a random matrix that is the same everywhere. In its best fifth the stage is done
    with probability 0.5; in its worst value all fails with 0.001; when the timer has run out the stage begins anew.

    Parameters
    ----------
    stages, timer, values : int
    seed : int

    Returns
    -------
    MarkovChain
        With outcomes ``done`` and ``failed``, from the first stage and value 0.
    """
    rng = np.random.default_rng(seed)
    moves = rng.dirichlet(np.full(values, 0.5), values)
    moves = moves / moves.sum(axis=1, keepdims=True)
    inner = stages * timer * values
    state = np.arange(inner)
    stage, left, value = state // (timer * values), state // values % timer, state % values
    leads = np.where(left + 1 < timer, state - value + values, stage * timer * values)
    good, bad = value >= values - max(1, values // 5), value == 0
    goes = np.where(good, 0.5, 0.0)
    fails = np.where(bad, 0.001, 0.0)
    after = np.where(stage + 1 < stages, (stage + 1) * timer * values + value, inner)
    targets = np.empty((inner, values + 2), np.int32)
    chances = np.empty((inner, values + 2))
    targets[:, :values] = leads[:, None] + np.arange(values)
    chances[:, :values] = moves[value] * (1.0 - goes - fails)[:, None]
    targets[:, values], chances[:, values] = after, goes
    targets[:, values + 1], chances[:, values + 1] = inner + 1, fails
    keep = chances > 0.0
    lengths = np.append(keep.sum(axis=1), [0, 0])
    outcomes = {"done": np.array([inner]), "failed": np.array([inner + 1])}
    offsets = np.concatenate(([0], np.cumsum(lengths)))
    return MarkovChain(offsets, targets[keep], chances[keep], outcomes, start_at(inner + 2, 0))


def random_chain(n: int, degree: int = 5, leak: float = 0.01, seed: int = 0) -> MarkovChain:
    """Each state leads to `degree` random ones, and with 0 to twice `leak` to the outcomes ``goal`` and ``lost``: ``n`` states in all."""
    rng = np.random.default_rng(seed)
    inner = n - 2
    targets = np.empty((inner, degree + 2), np.int32)
    targets[:, :degree] = rng.integers(0, inner, (inner, degree))
    targets[:, degree:] = (inner, inner + 1)
    chances = rng.random((inner, degree + 2))
    leaks = 2.0 * leak * rng.random((inner, 1))
    chances[:, :degree] *= (1.0 - leaks) / chances[:, :degree].sum(axis=1, keepdims=True)
    chances[:, degree:] *= leaks / chances[:, degree:].sum(axis=1, keepdims=True)
    offsets = np.append(np.arange(inner + 1), [inner, inner]) * (degree + 2)
    outcomes = {"goal": np.array([inner]), "lost": np.array([inner + 1])}
    return MarkovChain(offsets, targets.ravel(), chances.ravel(), outcomes, start_at(n, 0))


def grid_chain(side: int, forward: float = 0.26, back: float = 0.24) -> MarkovChain:
    """A walk on a sheet of ``side * side`` states that drifts from the first row (``lost``) to the last (``goal``).

    Sideways 0.25 each; at the sides it stays instead.
    """
    n = side * side
    state = np.arange(n)
    y, x = state // side, state % side
    sideways = (1.0 - forward - back) / 2
    targets = np.stack((state + side, state - side, np.where(x + 1 < side, state + 1, state), np.where(x > 0, state - 1, state)), axis=1)
    chances = np.broadcast_to([forward, back, sideways, sideways], (n, 4))
    inner = (y > 0) & (y < side - 1)
    offsets = np.concatenate(([0], np.cumsum(np.where(inner, 4, 0))))
    outcomes = {"goal": state[y == side - 1], "lost": state[y == 0]}
    return MarkovChain(offsets, targets[inner].ravel(), chances[inner].ravel(), outcomes, start_at(n, side // 2 * side + side // 2))


def walk_chain(n: int, up: float = 0.5, start: int | None = None) -> MarkovChain:
    """The gambler's ruin on states 0 to n: ``broke`` at 0, ``rich`` at n."""
    inner = np.arange(1, n)
    targets = np.stack((inner + 1, inner - 1), axis=1).ravel().astype(np.int32)
    chances = np.tile([up, 1.0 - up], n - 1)
    offsets = np.concatenate(([0, 0], 2 * np.arange(1, n), [2 * (n - 1)]))
    outcomes = {"rich": np.array([n]), "broke": np.array([0])}
    return MarkovChain(offsets, targets, chances, outcomes, start_at(n + 1, n // 2 if start is None else start))


def tandem_chain(overflow: int, arrival: float = 0.1, service: tuple[float, float] = (0.45, 0.45)) -> MarkovChain:
    """Two queues in a row, from one customer in the first to "overflow" (so many in both) or "empty".

    Steps are those of the embedded chain: the three rates, those of empty queues left out.

    Parameters
    ----------
    overflow : int
        Customers that are too many.
    arrival : float
    service : (float, float)
        Rates of the two servers.
    """
    number: dict[tuple[int, int], int] = {}
    for first in range(overflow + 1):
        for second in range(overflow + 1 - first):
            number[first, second] = len(number)
    rows: list[dict[int, float]] = []
    for first, second in number:
        if first + second in (0, overflow):
            rows.append({})
            continue
        moves = {(first + 1, second): arrival}
        if first:
            moves[first - 1, second + 1] = service[0]
        if second:
            moves[first, second - 1] = service[1]
        total = sum(moves.values())
        rows.append({number[state]: rate / total for state, rate in moves.items()})
    outcomes = {"overflow": [k for (a, b), k in number.items() if a + b == overflow], "empty": [0]}
    names = [f"{a} and {b}" for a, b in number]
    return MarkovChain.from_rows(rows, outcomes, number[1, 0], names)
