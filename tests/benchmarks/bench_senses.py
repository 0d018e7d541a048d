"""Speed of the senses: microseconds of CPU per world and cycle, the best of several rounds.

Run it with ``python tests/benchmarks/bench_senses.py [--worlds N] [--rounds N]``. Each table names what is measured in one cycle of one
11 v 11 world. The bare loop is the least that such a see can do (distance, cone, quantised distance and direction by the C library's
functions, no draws, no levels, identities not hidden): the ratio to it shows the overhead on any machine.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable

import numba
import numpy as np

from cprm_gym.simulator.senses import new_body, new_hear, new_landmarks, new_see
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import CommandKind, PlayMode


@numba.njit
def bare_see(pos, face, half_cone, out):
    """22 observers look at 22 others: the arithmetic of seeing and nothing else."""
    for k in range(pos.shape[0]):
        for i in range(22):
            for j in range(23):
                dx, dy = pos[k, j, 0] - pos[k, i + 1, 0], pos[k, j, 1] - pos[k, i + 1, 1]
                angle = math.atan2(dy, dx) - face[k, i]
                angle -= 2 * math.pi * np.rint(angle / (2 * math.pi))
                seen = j != i + 1 and abs(angle) < half_cone
                out[k, i, j, 0] = out[k, i, j, 1] = 0.0
                if seen:
                    distance = math.sqrt(dx * dx + dy * dy)
                    quantised = math.exp(np.rint(math.log(distance + 1e-10) / 0.1) * 0.1)
                    out[k, i, j, 0] = np.rint(quantised / 0.1) * 0.1
                    out[k, i, j, 1] = np.rint(np.degrees(angle))


def scattered(worlds: int, threads: int = 1, spread: float = 1.0) -> Simulator:
    """Everybody somewhere on the pitch, looking somewhere, with a message due in this cycle."""
    sim = Simulator(worlds, threads=threads)
    rng = np.random.default_rng(0)
    w = sim.world
    w["mode"], w["kick_cycles"], w["saw"] = PlayMode.play_on, -1, 1
    w["pos"] = rng.uniform(-1, 1, (worlds, 23, 2)) * (50 * spread, 32 * spread)
    w["vel"] = rng.normal(0, 0.3, (worlds, 23, 2))
    w["body"], w["neck"] = rng.uniform(-np.pi, np.pi, (worlds, 22)), rng.uniform(-np.pi / 2, np.pi / 2, (worlds, 22))
    return sim


def cost(run: Callable[[], object], worlds: int, rounds: int, clock: Callable[[], float] = time.process_time) -> float:
    """Microseconds per world of the fastest round."""
    run()
    best = math.inf
    for _ in range(rounds):
        start = clock()
        run()
        best = min(best, clock() - start)
    return best / worlds * 1e6


def show(name: str, value: float, bare: float | None = None) -> None:
    """One line of the table."""
    print(f"{name:58s} {value:8.2f} us" + (f"   {value / bare:5.2f} x bare" if bare else ""))


def senses(worlds: int, rounds: int) -> None:
    """Every sense alone."""
    sim = scattered(worlds)
    w = sim.world
    out, pitch, body, ears = new_see(worlds), new_landmarks(worlds), new_body(worlds), new_hear(worlds)
    scratch = np.zeros((worlds, 22, 23, 2))
    bare = {
        name: cost(lambda h=half: bare_see(w["pos"], w["body"] + w["neck"], h, scratch), worlds, rounds)
        for name, half in (("narrow", math.pi / 6), ("normal", math.pi / 3), ("wide", math.pi / 2))
    }
    print(f"\nsenses of 22 players, all due, {worlds} worlds, one thread")
    show("bare see, normal", bare["normal"])
    for width, name in ((1, "narrow"), (2, "normal"), (3, "wide")):
        w["view_width"] = width
        show(f"see, {name}", cost(lambda: sim.see(out), worlds, rounds), bare[name])
    w["view_width"] = 2
    for change, value in (("focus_distance", 15.0), ("gaussian", 1)):
        before = w[change].copy()
        w[change] = value
        show(f"see, normal, {change} {value:g}", cost(lambda: sim.see(out), worlds, rounds), bare["normal"])
        w[change] = before
    show("landmarks and lines, normal", cost(lambda: sim.landmarks(pitch), worlds, rounds))
    show("sense_body", cost(lambda: sim.sense_body(body), worlds, rounds))
    show("hear, nobody spoke", cost(lambda: sim.hear(ears), worlds, rounds))
    w["saw"], w["see_counter"] = 0, 0
    show("see, nobody due", cost(lambda: sim.see(out), worlds, rounds))


def playing(worlds: int, threads: int = 1) -> Simulator:
    """Everybody runs and turns about, at play, for as long as it takes."""
    sim = Simulator(worlds, threads=threads)
    sim.world["mode"] = PlayMode.play_on
    rng = np.random.default_rng(1)
    commands = sim.commands
    commands["kind"] = rng.choice([CommandKind.DASH, CommandKind.DASH, CommandKind.TURN, CommandKind.KICK], (worlds, 22))
    commands["a"], commands["b"] = rng.uniform(0, 60, (worlds, 22)), rng.uniform(-90, 90, (worlds, 22))
    commands["turn_neck"] = rng.uniform(-30, 30, (worlds, 22))
    sim.world["pos"][:, 1:] = rng.uniform(-1, 1, (worlds, 22, 2)) * (50, 32)
    for _ in range(20):
        sim.step()
    return sim


def cycles(worlds: int, rounds: int) -> None:
    """Whole cycles: commands, physics, rules, senses."""
    sim = playing(worlds)
    out, pitch = new_see(worlds), new_landmarks(worlds)

    def with_see() -> None:
        sim.step()
        sim.world["saw"] = 1
        sim.see(out)

    def with_landmarks() -> None:
        with_see()
        sim.landmarks(pitch)

    def as_due() -> None:
        sim.step()
        sim.see(out)

    print(f"\ncycles of 11 v 11, random commands, {worlds} worlds, one thread")
    show("commands, physics, rules", cost(sim.step, worlds, rounds))
    show("... with the masked see of all 22 players", cost(with_see, worlds, rounds))
    show("... and landmarks", cost(with_landmarks, worlds, rounds))
    show("... with see as due (normal width: every second cycle)", cost(as_due, worlds, rounds))


def batch(rounds: int) -> None:
    """1024 worlds on two threads: wall time, and processor time for when others use the cores too."""
    worlds = 1024
    sim = playing(worlds, threads=2)
    out = new_see(worlds)

    def run() -> None:
        sim.step()
        sim.world["saw"] = 1
        sim.see(out)

    wall, processor = cost(run, worlds, rounds, time.perf_counter), cost(run, worlds, rounds)
    print(f"\nbatch of {worlds} worlds, two threads, with see of all 22 players")
    show("wall time per world and cycle", wall)
    print(f"{'agent-steps per second, as the machine is loaded now':58s} {22 / wall:8.2f} million")
    show("processor time per world and cycle, both threads", processor)
    print(f"{'agent-steps per second of two free cores':58s} {44 / processor:8.2f} million")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--worlds", type=int, default=32, help="worlds per call")
    parser.add_argument("--rounds", type=int, default=200, help="rounds, of which the fastest counts")
    given = parser.parse_args()
    senses(given.worlds, given.rounds)
    cycles(given.worlds, given.rounds)
    batch(max(given.rounds // 20, 3))


if __name__ == "__main__":
    main()
