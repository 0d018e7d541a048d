"""Speed of the executor: CPU time per cycle and copy of behaviour nets, in a batch and for one copy through Python.

    python tests/benchmarks/bench_petri_execution.py

The 60-transition net holds ten behaviour modules of six transitions each. *Busy*: all of them run, so that in every cycle each
emits a command, counts, and reads its inputs through math. *At work*: one of them runs. *Quiet*: all wait. *Large nets* have more such
modules, all of them running, with inputs that stay or that change in every cycle; *before* is the cycle that looked at everything
(`tests/helpers/scanning_cycle.py`), run in turn. The last lines run a token game without timing, for comparison with a library that
does nothing else (SNAKES, when it is installed).
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from cprm_gym.architecture.expressions import Expression
from cprm_gym.architecture.expressions.compiler import Assembler
from cprm_gym.architecture.expressions.kernels import run_rows
from cprm_gym.architecture.petri import Belief, Command, Executor, Input, Math, PetriNet, Place, Ports, Transition

sys.path.append(str(Path(__file__).parents[1] / "helpers"))
from scanning_cycle import ScanningExecutor

ORIENT = PetriNet(
    "orient",
    ports=Ports(begin="begin", ongoing="ongoing", done="facing", errors=("failed",), interrupts=("abort",)),
    places=(
        Place("begin", 1), Place("ongoing", 1), Place("facing", 1), Place("failed", 1), Place("abort", 1), Place("turns", 10**9),
        Input("ball_seen", observes="ball.seen"), Input("speed", observes="body.speed"), Belief("bearing", "ball.direction"),
        Math("off_axis", "abs(bearing)"), Math("moment", "clip(0.9 * bearing * (1 + 5 * speed), -180, 180)"),
    ),
    transitions=(
        Transition("start", ("begin",), ("ongoing",), sets={"turns": 0}),
        Transition("turn", ("ongoing",), ("ongoing", "turns"), delay=1, tests={"off_axis": 3.0, "ball_seen": 1},
                   inhibitors={"turns": 10**9}, emits=Command("turn", moment="moment")),
        Transition("arrive", ("ongoing",), ("facing",), inhibitors={"off_axis": 3.0}),
        Transition("give_up", ("ongoing",), ("failed",), tests={"turns": 10**9, "off_axis": 3.0}),
        Transition("stop", ("abort", "ongoing"), ("failed",), priority=10),
        Transition("ignore", ("abort",), inhibitors=("ongoing",), priority=9),
    ),
)  # fmt: skip


def behaviours(count: int, running: int) -> PetriNet:
    """So many orient modules side by side, the first `running` of them begun, the others waiting."""
    return PetriNet(
        f"{count} behaviours",
        tuple(Place(f"go_{i}", 1, int(i < running)) for i in range(count)),
        modules={f"m{i}": ORIENT for i in range(count)},
        fuse={f"m{i}.begin": f"go_{i}" for i in range(count)},
    )


def cpu(work: Callable[[], object], repeat: int = 7) -> tuple[float, float]:
    """Least and median CPU seconds of `work`."""
    times = []
    for _ in range(repeat):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times), statistics.median(times)


def report(name: str, seconds: tuple[float, float], per: float, unit: str) -> None:
    least, median = (s / per * 1e6 for s in seconds)
    print(f"{name:64s} {least:8.2f} {median:8.2f}  us per {unit}")


def bench_net(net: PetriNet, batch: int, cycles: int, as_names: bool = False) -> tuple[float, float]:
    executor = Executor(net, batch, exclusive=[("turn",)])
    inputs = np.ones((batch, len(executor.input_names)))
    inputs[:, executor.input_names.index("body.speed")] = 0.1
    beliefs = np.full((batch, len(executor.belief_names)), 40.0)
    named = {"ball.seen": 1.0, "body.speed": 0.1}
    believed = dict.fromkeys(executor.belief_names, 40.0)
    executor.step(inputs, beliefs=beliefs)

    def work() -> None:
        for _ in range(cycles):
            if as_names:
                executor.step(named, beliefs=believed)
            else:
                executor.step(inputs, beliefs=beliefs)

    return cpu(work)


def cycles_of(executor: Executor, changing: bool) -> Callable[[int], float]:
    """CPU seconds of so many cycles, whose inputs change every time or never."""
    ones = np.ones((executor.batch, len(executor.input_names)))
    speed = executor.input_names.index("body.speed")
    inputs = [ones.copy() for _ in range(2)]
    for k, observed in enumerate(inputs):
        observed[:, speed] = 0.1 + 0.01 * k * changing
    beliefs = [np.full((executor.batch, len(executor.belief_names)), 40.0 + k * changing) for k in range(2)]
    executor.step(inputs[0], beliefs=beliefs[0])

    def run(cycles: int) -> float:
        start = time.process_time()
        for k in range(cycles):
            executor.step(inputs[k % 2], beliefs=beliefs[k % 2])
        return time.process_time() - start

    return run


def bench_large(modules: int, batch: int, cycles: int, repeat: int = 7) -> None:
    """The cycle before and as it is, in turn, on a net of so many running modules."""
    net = behaviours(modules, modules)
    for changing in (False, True):
        runs = [cycles_of(kind(net, batch, exclusive=[("turn",)]), changing) for kind in (ScanningExecutor, Executor)]
        times = np.array([[run(cycles) for run in runs] for _ in range(repeat)])
        before, now = (times.min(axis=0) / cycles / batch * 1e6).tolist()
        what = f"{6 * modules} transitions, {batch} copies, inputs {'change' if changing else 'stay'}: before, now, ratio"
        print(f"{what:76s} {before:8.2f} {now:8.2f} {now / before:6.3f}  us per cycle and copy", flush=True)


LAPS = 200


def ring(places: int) -> PetriNet:
    """One token that goes round in immediate firings, `LAPS` times."""
    names = tuple(Place(f"p{i}", tokens=int(i == 0)) for i in range(places))
    first = Transition("t0", ("p0", "laps"), ("p1",))
    steps = tuple(Transition(f"t{i}", (f"p{i}",), (f"p{(i + 1) % places}",)) for i in range(1, places))
    return PetriNet("ring", (*names, Place("laps", tokens=LAPS)), (first, *steps))


def snakes_ring(places: int) -> Callable[[int], None]:
    from snakes.nets import PetriNet as Snakes
    from snakes.nets import Place as SPlace
    from snakes.nets import Substitution, Value
    from snakes.nets import Transition as STransition

    net = Snakes("ring")
    for i in range(places):
        net.add_place(SPlace(f"p{i}", [1] if i == 0 else []))
    for i in range(places):
        net.add_transition(STransition(f"t{i}"))
        net.add_input(f"p{i}", f"t{i}", Value(1))
        net.add_output(f"p{(i + 1) % places}", f"t{i}", Value(1))

    def run(firings: int) -> None:
        for k in range(firings):
            for t in net.transition():
                modes = t.modes()
                if modes:
                    t.fire(Substitution(modes[0].dict()))
                    break
            del k

    return run


def main() -> None:
    print(f"{'':64s} {'least':>8s} {'median':>8s}")
    for state, running in (("busy", 10), ("at work", 1), ("quiet", 0)):
        net = behaviours(10, running)
        report(f"60 transitions, {state}, batch of 1000 copies", bench_net(net, 1000, 20), 20 * 1000, "cycle and copy")
        report(f"60 transitions, {state}, one copy, arrays", bench_net(net, 1, 1000), 1000, "cycle")
    report("60 transitions, busy, one copy, inputs by name", bench_net(behaviours(10, 10), 1, 1000, as_names=True), 1000, "cycle")
    report("6 transitions, busy, batch of 1000 copies", bench_net(behaviours(1, 1), 1000, 50), 50 * 1000, "cycle and copy")

    for modules, batch in ((10, 1000), (100, 100), (333, 30), (10, 1)):
        bench_large(modules, batch, 20 if batch > 1 else 1000)

    assembler = Assembler(["bearing", "speed"].index)
    assembler.add(Expression("clip(0.9 * bearing * (1 + 5 * speed), -180, 180)").tree)
    code = assembler.finish()
    rows, out, stack = np.random.default_rng(0).normal(size=(20_000, 2)), np.zeros(20_000), np.zeros(code.depth)
    run_rows(code.code, code.constants, 0, len(code.code), rows, stack, out)
    work = lambda: run_rows(code.code, code.constants, 0, len(code.code), rows, stack, out)  # noqa: E731
    report("expression of 12 operations, byte code", cpu(work), 20_000, "value")

    places = 41
    executor = Executor(ring(places))
    start = executor.snapshot()
    executor.step()

    def burn() -> None:
        executor.restore(start)
        executor.step()

    ours = cpu(burn)
    report(f"token game, ring of {places} places", ours, LAPS * places, "firing")
    if find_spec("snakes") is not None:
        run = snakes_ring(places)
        theirs = cpu(lambda: run(200), repeat=3)
        report(f"token game, ring of {places} places, SNAKES", theirs, 200, "firing")
        print(f"ratio: {theirs[0] / 200 / (ours[0] / (LAPS * places)):.0f}")


if __name__ == "__main__":
    main()
