"""One decision of an agent who is alone, percepts to action: python tests/benchmarks/bench_decisions.py [--against CHECKOUT]

CPU microseconds, median and 99th percentile over the cycles after the first 20, in episodes that follow each other: of the goalie, of one
of the passing pair, and of an outfield player of five a side, with their models as they are. *rehearsed*: with slices imagined before
the first (`CPRMRunner`, ``rehearsal``), where there is such an option. With ``--against`` the same file runs in turn on another checkout
of the project and on this one, so that a loaded machine hits both alike; medians over the rounds.
"""

from __future__ import annotations

import argparse
import inspect
import json
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve()
PLAYERS = {"goalie": ("Goalie", 0), "passer": ("PassAndAdvance", 0), "outfielder": ("Soccer5v5", 2)}
FIRST, REHEARSAL = 20, 400


def measure(name: str, cycles: int, rehearsal: int) -> dict[str, float]:
    """Median and 99th percentile of a decision, and what reset takes, CPU us."""
    from cprm_gym.agents import eleven, goalie, passer
    from cprm_gym.envs.core import SoccerCore
    from cprm_gym.envs.tasks import make_task

    task, me = PLAYERS[name]
    make = {"goalie": goalie, "passer": passer, "outfielder": eleven}[name].make_controller
    core = SoccerCore(make_task(task), 1, seed=2026, include=("memory",))
    observation = core.reset(2026)
    players = [make(core.task, agent, **({"rehearsal": rehearsal} if rehearsal and i == me else {})) for i, agent in enumerate(core.agents)]
    begin = time.process_time()
    for i, player in enumerate(players):
        player.reset({key: value[:, i] for key, value in observation.items()}, 3)
        if i == me:
            prepared = time.process_time() - begin
        begin = time.process_time()
    times = []
    for _ in range(cycles):
        actions = []
        for i, player in enumerate(players):
            own = {key: value[:, i] for key, value in observation.items()}
            begin = time.process_time()
            actions.append(player.act(own))
            if i == me:
                times.append(time.process_time() - begin)
        step = core.step({key: np.stack([action[key] for action in actions], axis=1) for key in actions[0]})
        over = step.terminated | step.truncated
        if over.any():
            core.reset(worlds=over)
            for i, player in enumerate(players):
                player.reset({key: value[:, i] for key, value in observation.items()}, 3, over)
    late = 1e6 * np.array(times[FIRST:])
    return {"median": float(np.median(late)), "99 %": float(np.percentile(late, 99)), "reset": 1e6 * prepared}


def everything(cycles: int) -> dict[str, dict[str, float]]:
    """All players, with and without a rehearsal."""
    from cprm_gym.architecture.cprm import CPRMRunner

    found = {}
    for name in PLAYERS:
        found[name] = measure(name, cycles, 0)
        if "rehearsal" in inspect.signature(CPRMRunner).parameters:
            found[f"{name}, rehearsed"] = measure(name, cycles, REHEARSAL)
    return found


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--against", type=Path, help="another checkout, measured in turn with this one")
    parser.add_argument("--cycles", type=int, default=1000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--json", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.json:
        print(json.dumps(everything(options.cycles)))
        return
    checkouts = {**({"before": options.against.resolve()} if options.against else {}), "now": HERE.parents[2]}
    found: dict[tuple[str, str], dict[str, list[float]]] = {}
    for _ in range(options.rounds):
        for head, checkout in checkouts.items():
            env = {**os.environ, "PYTHONPATH": f"{checkout}:{checkout / 'baselines'}"}
            run = [sys.executable, str(HERE), "--json", "--cycles", str(options.cycles)]
            answer = subprocess.run(run, env=env, capture_output=True, text=True, check=True).stdout
            for name, values in json.loads(answer.splitlines()[-1]).items():
                for kind, value in values.items():
                    found.setdefault((name, head), {}).setdefault(kind, []).append(value)
    print(f"{'':24}{'':8}{'median':>10}{'99 %':>10}{'reset':>12}   CPU us, medians of {options.rounds}")
    for (name, head), kinds in sorted(found.items()):
        median, worst, reset = (statistics.median(kinds[kind]) for kind in ("median", "99 %", "reset"))
        print(f"{name:24}{head:8}{median:10.0f}{worst:10.0f}{reset:12.0f}")


if __name__ == "__main__":
    main()
