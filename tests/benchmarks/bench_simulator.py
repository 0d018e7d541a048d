"""Speed of the simulator: ``python tests/benchmarks/bench_simulator.py [--cold]`` prints a table of CPU times.

Eleven against eleven with random commands, from one snapshot of play, so that every row does the same work. "bare loop" is the same
physics (dashes, motion with noise, collisions, stamina) as one numba loop over plain arrays, without commands, records or rules:
the ratio to it, measured in the same run, shows what the machinery costs. ``--cold`` also compiles everything in an empty cache.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from statistics import median

import numba
import numpy as np

from cprm_gym.simulator.parameters import Rules
from cprm_gym.simulator.player_types import PlayerParameters
from cprm_gym.simulator.simulator import Simulator, no_commands
from cprm_gym.simulator.state import WORLD, CommandKind, PlayMode

CYCLES, ROUNDS, KINDS = 400, 15, 64


@numba.njit(error_model="numpy")
def bare_loop(n, pos, vel, body, stamina, effort, recovery, capacity, power, angle, seed):
    """`n` cycles of 22 dashing players and a ball on plain arrays."""
    x = seed
    acc = np.zeros((23, 2))
    hit = np.zeros(23)
    for step in range(n):
        k = step % power.shape[0]
        for i in range(22):
            p = min(max(0.0, power[k, i]), 100.0)
            d = np.rint(min(max(-180.0, angle[k, i]), 180.0))
            cost = min(p, stamina[i] + 50.0)
            a = abs(d)
            rate = 0.7 - 0.3 * (1.0 - (a - 90.0) / 90.0) if a > 90.0 else 0.4 + 0.6 * (1.0 - a / 90.0)
            size = effort[i] * cost * rate * 0.006
            heading = body[i] + d * np.pi / 180.0
            acc[i + 1, 0], acc[i + 1, 1] = size * np.cos(heading), size * np.sin(heading)
            stamina[i] = max(0.0, stamina[i] - cost)
        for o in range(23):
            accel_max, speed_max, rand, decay = (2.7, 3.0, 0.05, 0.94) if o == 0 else (1.0, 1.05, 0.1, 0.4)
            ax, ay = acc[o, 0], acc[o, 1]
            if ax != 0.0 or ay != 0.0:
                size = np.sqrt(ax * ax + ay * ay)
                if size > accel_max:
                    ax *= accel_max / size
                    ay *= accel_max / size
                vel[o, 0] += ax
                vel[o, 1] += ay
                speed = np.sqrt(vel[o, 0] ** 2 + vel[o, 1] ** 2)
                if speed > speed_max:
                    vel[o, 0] *= speed_max / speed
                    vel[o, 1] *= speed_max / speed
            speed = np.sqrt(vel[o, 0] ** 2 + vel[o, 1] ** 2)
            x ^= x << np.uint64(13)
            x ^= x >> np.uint64(7)
            x ^= x << np.uint64(17)
            radius = rand * speed * (x >> np.uint64(11)) * 2.0**-53
            x ^= x << np.uint64(13)
            x ^= x >> np.uint64(7)
            x ^= x << np.uint64(17)
            turn = 2.0 * np.pi * (x >> np.uint64(11)) * 2.0**-53
            vel[o, 0] += radius * np.cos(turn)
            vel[o, 1] += radius * np.sin(turn)
            for c in range(2):
                pos[o, c] = min(max(-57.0, pos[o, c] + vel[o, c]), 57.0)
                vel[o, c] *= decay
                acc[o, c] = 0.0
        for _ in range(10):
            found = False
            for i in range(23):
                for j in range(i + 1, 23):
                    dx, dy = pos[j, 0] - pos[i, 0], pos[j, 1] - pos[i, 1]
                    reach = 0.385 if i == 0 else 0.6
                    gap = dx * dx + dy * dy
                    if gap < reach * reach:
                        found = True
                        hit[i], hit[j] = 1.0, 1.0
                        gap = max(np.sqrt(gap), 1e-10)
                        push = 0.5 * (reach - gap + 1e-10) / gap
                        pos[i, 0] -= dx * push
                        pos[i, 1] -= dy * push
                        pos[j, 0] += dx * push
                        pos[j, 1] += dy * push
            if not found:
                break
        for o in range(23):
            if hit[o]:
                vel[o, 0] *= -0.1
                vel[o, 1] *= -0.1
                hit[o] = 0.0
        for i in range(22):
            if stamina[i] <= 2400.0:
                recovery[i] = max(0.5, recovery[i] - 0.002)
                effort[i] = max(0.6, effort[i] - 0.005)
            if stamina[i] >= 4800.0:
                effort[i] = min(1.0, effort[i] + 0.01)
            gain = min(min(recovery[i] * 45.0, 8000.0 - stamina[i]), capacity[i])
            capacity[i] -= gain
            stamina[i] += gain
    return x


def cpu_per_cycle(run: Callable[[], None], restart: Callable[[], None] = lambda: None) -> float:
    """Median over rounds of the CPU time (us) of one of `CYCLES` cycles."""
    times = []
    for _ in range(ROUNDS):
        restart()
        start = time.process_time()
        run()
        times.append((time.process_time() - start) / CYCLES * 1e6)
    return median(times)


def some_commands(worlds: int, rng: np.random.Generator) -> np.ndarray:
    """Random commands of everybody: half dashes, some turns, kicks, tackles; necks move all the time."""
    commands = no_commands(worlds, 22)
    kinds = [CommandKind.DASH, CommandKind.TURN, CommandKind.KICK, CommandKind.TACKLE]
    commands["kind"] = rng.choice(kinds, (worlds, 22), p=[0.6, 0.2, 0.18, 0.02])
    for name, low, high in (("a", 0, 100), ("b", -180, 180), ("turn_neck", -90, 90)):
        commands[name] = rng.uniform(low, high, (worlds, 22))
    return commands


def in_play(worlds: int = 1, rules: Rules = Rules.ALL, **arguments: object) -> tuple[Simulator, np.ndarray]:
    """A simulator in open play with everybody spread over the field, and its snapshot."""
    simulator = Simulator(worlds, player_parameters=PlayerParameters(random_seed=1), rules=rules, seed=1, **arguments)
    simulator.trainer.start()
    rng = np.random.default_rng(0)
    simulator.world["pos"][:, 1:] = rng.uniform((-45, -30), (45, 30), (worlds, 22, 2))
    simulator.world["mode"] = PlayMode.play_on
    simulator.step()
    return simulator, simulator.snapshot()


def bench_cycles() -> list[tuple[str, float]]:
    """CPU times per cycle of one world."""
    rng = np.random.default_rng(1)
    commands = [some_commands(1, rng) for _ in range(KINDS)]
    power, angle = rng.uniform(0, 100, (KINDS, 22)), rng.uniform(-180, 180, (KINDS, 22))
    pos = rng.uniform((-45, -30), (45, 30), (23, 2))

    def bare() -> None:
        start = pos.copy(), np.zeros((23, 2)), np.zeros(22), np.full(22, 8000.0), np.ones(22), np.ones(22), np.full(22, 130600.0)
        bare_loop(CYCLES, *start, power, angle, np.uint64(88172645463325252))

    rows = []
    bare()
    rows.append(("bare loop: physics only, no rules, no commands", cpu_per_cycle(bare)))
    for label, rules, senses in (
        ("physics, no rules", Rules.NONE, ()),
        ("physics + rules", Rules.ALL, ()),
        ("physics + rules + see of 22 players", Rules.ALL, ("see",)),
        ("physics + rules + see + landmarks", Rules.ALL, ("see", "landmarks")),
    ):
        simulator, snapshot = in_play(rules=rules)
        buffers = [(getattr(simulator, sense), getattr(simulator, sense)()) for sense in senses]

        def run(simulator=simulator, buffers=buffers) -> None:
            for cycle in range(CYCLES):
                simulator.step(commands[cycle % KINDS])
                for sense, out in buffers:
                    sense(out)

        def restart(simulator=simulator, snapshot=snapshot) -> None:
            simulator.restore(snapshot)

        run()
        rows.append((label, cpu_per_cycle(run, restart)))
    return rows


def bench_batch(worlds: int = 1024, threads: int = 2, cycles: int = 30) -> tuple[float, float]:
    """Agent-steps per second (wall, CPU-second) of a batch with see."""
    simulator, snapshot = in_play(worlds, threads=threads)
    commands = [some_commands(worlds, np.random.default_rng(k)) for k in range(4)]
    out = simulator.see()
    rates = []
    for _ in range(5):
        simulator.restore(snapshot)
        wall, cpu = time.perf_counter(), time.process_time()
        for cycle in range(cycles):
            simulator.step(commands[cycle % 4])
            simulator.see(out)
        agents = worlds * 22 * cycles
        rates.append((agents / (time.perf_counter() - wall), agents / (time.process_time() - cpu)))
    return max(r[0] for r in rates), median(r[1] for r in rates)


FIRST_STEP = """
import time
wall, cpu = time.perf_counter(), time.process_time()
from cprm_gym.simulator.simulator import Simulator
simulator = Simulator()
simulator.step()
if {senses}:
    simulator.see(), simulator.sense_body(), simulator.hear(), simulator.landmarks()
print(time.perf_counter() - wall, time.process_time() - cpu)
"""


def first_step(cache: str | None, senses: bool) -> tuple[float, float]:
    """(wall, CPU) seconds from the start of the import to the end of the first step, in a new process."""
    environment = {**os.environ, "CPRM_GYM_QUIET": "1"} | ({"CPRM_GYM_CACHE": cache} if cache else {})
    code = FIRST_STEP.format(senses=senses)
    output = subprocess.run([sys.executable, "-c", code], env=environment, check=True, capture_output=True, text=True).stdout
    wall, cpu = map(float, output.split())
    return wall, cpu


def main() -> None:
    """Print the table."""
    rows = bench_cycles()
    bare = rows[0][1]
    print(f"{'one world, 11 against 11, one core':<52}{'us / cycle':>11}{'ratio to bare':>15}")
    for label, cost in rows:
        print(f"{label:<52}{cost:>11.2f}{cost / bare:>15.2f}")
    wall, cpu = bench_batch()
    print(f"\nbatch of 1024 with see, 2 threads: {wall / 1e6:.2f} M agent-steps/s (wall), {cpu / 1e6:.2f} M per CPU second")
    print(f"state: {WORLD.itemsize} bytes per world")
    first_step(None, True)
    times = [first_step(None, False) for _ in range(3)]
    print(f"import to first step, cached: {min(t[0] for t in times):.2f} s wall, {min(t[1] for t in times):.2f} s CPU")
    if "--cold" in sys.argv:
        with tempfile.TemporaryDirectory() as folder:
            wall, cpu = first_step(folder, True)
            print(f"cold compile of step and all senses: {wall:.1f} s wall, {cpu:.1f} s CPU")


if __name__ == "__main__":
    main()
