"""What the rules cost: the step with all of the referee's modules against the step without them, in the same run.

CPU time per world and cycle, 22 players who dash, medians of several repetitions. Run it as a script.
"""

from __future__ import annotations

import statistics
import time

import numpy as np

from cprm_gym.simulator.parameters import Rules, ServerParameters
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import CommandKind

WORLDS, CYCLES, REPETITIONS = 64, 60, 9


def match(rules: Rules, mode: str) -> Simulator:
    """`WORLDS` worlds with players all over the pitch, all of them running."""
    random = np.random.default_rng(0)
    sim = Simulator(WORLDS, ServerParameters(half_time=-1), seed=1, rules=rules)
    for player in range(1, 23):
        sim.trainer.place_player(player, random.uniform(-40, 40, WORLDS), random.uniform(-30, 30, WORLDS))
    sim.trainer.place_ball(random.uniform(-30, 30, WORLDS), random.uniform(-20, 20, WORLDS))
    sim.trainer.change_mode(mode)
    sim.commands["kind"], sim.commands["a"], sim.commands["b"] = CommandKind.DASH, 60.0, 0.0
    sim.step()
    return sim


def cost(sim: Simulator) -> float:
    """Microseconds of CPU time per world and cycle."""
    start = time.process_time()
    for _ in range(CYCLES):
        sim.step()
    return (time.process_time() - start) / CYCLES / WORLDS * 1e6


def main() -> None:
    """Print the table."""
    print(f"{'mode':12} {'without rules':>14} {'with rules':>11} {'rules':>8}   us per world and cycle, {WORLDS} worlds, medians")
    for mode in ("play_on", "free_kick_l", "goal_kick_l", "offside_l"):
        sims = [match(rules, mode) for rules in (Rules.NONE, Rules.ALL)]
        starts = [sim.snapshot() for sim in sims]
        times: list[list[float]] = [[], []]
        for _ in range(REPETITIONS):
            for sim, start, measured in zip(sims, starts, times):
                sim.restore(start)
                measured.append(cost(sim))
        without, with_rules = map(statistics.median, times)
        print(f"{mode:12} {without:14.2f} {with_rules:11.2f} {with_rules - without:8.2f}")


if __name__ == "__main__":
    main()
