"""What the architecture contains (dissertation Figs. 5.1 and 5.3): a state machine and a belief-region policy against their nets."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....agents.equivalents.go_to_ball import GO_TO_BALL_MACHINE, GO_TO_BALL_REGIONS
from ....architecture.cprm import CPRMRunner
from ....architecture.equivalences import MachineRunner, RegionsRunner, machine_net, regions_cprm
from ....architecture.petri import Executor

CYCLES = {"state machine": 1000, "belief regions": 200}
"""Of random readings, on which both send the same."""


def same(what: str, seed: int) -> dict[str, Any]:
    """Cycles in which the thing and its net sent the same commands with the same parameters, of so many.

    Parameters
    ----------
    what : str
        Of `CYCLES`.
    seed : int
        Of the readings.
    """
    draws = np.random.default_rng([seed, len(what)])
    if what == "state machine":
        runner, executor = MachineRunner(GO_TO_BALL_MACHINE), Executor(machine_net(GO_TO_BALL_MACHINE), 1)
        alike = [runner.step(p) == executor.step(p).of() for p in (_machine_readings(draws) for _ in range(CYCLES[what]))]
        return {"alike": sum(alike), "cycles": len(alike)}
    regions, cprm = RegionsRunner(GO_TO_BALL_REGIONS), CPRMRunner(regions_cprm(GO_TO_BALL_REGIONS))
    alike = []
    for readings in (_region_readings(draws) for _ in range(CYCLES[what])):
        mine = regions.step(readings)
        its = cprm.step({name: np.array([value]) for name, value in readings.items()}).of(0)
        alike.append(set(mine) == set(its) and all(_close(mine[name], its[name]) for name in mine))
    return {"alike": sum(alike), "cycles": len(alike)}


def _close(one: dict[str, float], other: dict[str, float]) -> bool:
    return one.keys() == other.keys() and all(abs(one[key] - other[key]) < 1e-9 for key in one)


def _machine_readings(draws: np.random.Generator) -> dict[str, float]:
    return {
        "ball.seen": float(draws.integers(0, 2)), "body.fresh": float(draws.integers(0, 2)),
        "ball.direction_deg": draws.uniform(-30, 30), "body.speed": draws.random(), "body.stamina": draws.uniform(0, 8000),
    }  # fmt: skip


def _region_readings(draws: np.random.Generator) -> dict[str, float]:
    return {
        "ball.seen": float(draws.random() < 0.7), "body.fresh": float(draws.integers(0, 2)), "ball.distance": draws.uniform(0.5, 40),
        "ball.direction_deg": draws.uniform(-60, 60), "body.turned_deg": draws.uniform(-90, 90), "body.advanced": draws.uniform(0, 1),
    }  # fmt: skip
