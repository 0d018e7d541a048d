"""Inference of a batch about the ball: whole tables and row by row, against bands and eight rows at a time, in turn in one run.

    python tests/benchmarks/bench_bands.py [agents]

The ball of the goalie, of the passer and of the outfielder, seen in half of the cycles. CPU microseconds of a step for an agent, least
of seven turns, and the largest relative difference of a posterior's entries between the two.
"""

from __future__ import annotations

import sys
import time
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from cprm_gym.agents.models import goalie_model, passer_model
from cprm_gym.agents.outfielder.model import outfield_model
from cprm_gym.architecture.prm.grounding.grounding import Grounding
from cprm_gym.architecture.prm.inference.compiled.lanes import kernels as lanes
from cprm_gym.architecture.prm.inference.compiled.operations import Builder
from cprm_gym.architecture.prm.inference.evidence import StateRows
from cprm_gym.architecture.prm.inference.filter import Filter
from cprm_gym.architecture.prm.model.model import Model

MODELS: dict[str, Callable[[], Model]] = {"goalie": goalie_model, "passer": passer_model, "outfielder": outfield_model}
STEPS, TURNS = 8, 7


@contextmanager
def as_before() -> Iterator[None]:
    """Plans that are made in here are of whole tables and run row by row."""
    by_bands, largest = Builder.by_bands, lanes.LARGEST
    Builder.by_bands, lanes.LARGEST = lambda *_: False, -1  # type: ignore[method-assign, misc]
    try:
        yield
    finally:
        Builder.by_bands, lanes.LARGEST = by_bands, largest  # type: ignore[method-assign, misc]


def readings(filtered: Filter, agents: int, rng: np.random.Generator) -> list[StateRows]:
    """What is seen and given in some slices."""
    variables = filtered.grounding.ground((), first=False).variables
    names = tuple(n for n in variables if ".seen" in n or n in filtered.grounding.ground((), first=False).given)
    cards = np.array([variables[n].card for n in names])[:, None]
    out = []
    for k in range(STEPS):
        states = (0.35 * cards + 0.3 * cards * rng.random((len(names), agents))).astype(np.int64)
        if k % 2:
            states[[".seen" in n for n in names]] = -1
        out.append(StateRows(names, states))
    return out


def measure(make: Callable[[], Model], agents: int) -> tuple[float, float, float, float]:
    """CPU us of a step for an agent before and now, the largest relative difference, MB that a run takes at most."""
    model = make()
    with as_before():
        before = Filter(Grounding(model, {"ball": "Ball"}), batch=agents, on_impossible="restart")
        told = readings(before, agents, np.random.default_rng(0))
        old = [before.step(t) for t in told]
    now = Filter(Grounding(model, {"ball": "Ball"}), batch=agents, on_impossible="restart")
    new = [now.step(t) for t in told]
    hidden = [n for n in old[-1].variables if ".seen" not in n and old[-1].variables[n].card > 1]
    pairs = [(a[n], b[n]) for a, b in zip(old, new) for n in hidden]
    apart = max(float((np.abs(a - b) / np.maximum(a, 1e-300)).max()) for a, b in pairs)
    times = []
    for _ in range(TURNS):
        row = []
        for filtered in (before, now):
            start = time.process_time()
            for t in told:
                filtered.step(t)
            row.append(time.process_time() - start)
        times.append(row)
    least = np.min(times, axis=0) / STEPS / agents * 1e6
    tracemalloc.start()
    for t in told:
        now.step(t)
    peak = tracemalloc.get_traced_memory()[1] / 2**20
    tracemalloc.stop()
    return float(least[0]), float(least[1]), apart, peak


def main(agents: int) -> None:
    """Print the table."""
    print(f"{'ball of the':14}{'before us':>11}{'now us':>9}{'ratio':>8}{'apart':>11}{'MB beyond':>11}   ({agents} agents)")
    for name, make in MODELS.items():
        before, now, apart, peak = measure(make, agents)
        print(f"{name:14}{before:11.2f}{now:9.2f}{now / before:8.2f}{apart:11.1e}{peak:11.1f}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 250)
