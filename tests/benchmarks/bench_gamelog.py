"""Speed of logs and replays: ``python tests/benchmarks/bench_gamelog.py``. CPU time, median of five runs."""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from cprm_gym.simulator.conformance import replay_scenario
from cprm_gym.simulator.gamelog.reader import GameLogReader
from cprm_gym.simulator.gamelog.records import RECORD, RecordLogWriter
from cprm_gym.simulator.gamelog.writer import GameLogWriter
from cprm_gym.simulator.protocol.commands import parse_commands
from cprm_gym.simulator.simulator import Simulator

DATA = Path(__file__).parents[1] / "conformance" / "data"
CYCLES = 300


def cpu(work: Callable[[], object]) -> float:
    """Median CPU time (s) of five runs after one to warm up."""
    work()
    times = []
    for _ in range(5):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return statistics.median(times)


def write(path: Path, version: int) -> None:
    simulator = Simulator()
    simulator.trainer.start()
    kind = RecordLogWriter.for_simulator(path, simulator) if version == RECORD else None
    with kind or GameLogWriter.for_simulator(path, simulator, version=version) as writer:
        for _ in range(CYCLES):
            simulator.step()
            writer.record(simulator)


def main() -> None:
    print(f"{'work':44} {'CPU us':>12}")
    with tempfile.TemporaryDirectory() as folder:
        for version, name in ((6, "text 6"), (-1, "JSON"), (RECORD, "record")):
            path = Path(folder) / f"game{version}.rcg"
            print(f"{'write one cycle, ' + name:44} {cpu(lambda p=path, v=version: write(p, v)) / CYCLES * 1e6:12.1f}")
            print(f"{'read one cycle, ' + name:44} {cpu(lambda p=path: list(GameLogReader(p))) / CYCLES * 1e6:12.1f}")
    datagram = "(dash 100 30.5)(turn_neck -20)(change_focus 3 4)(done)"
    print(f"{'parse a datagram of four commands':44} {cpu(lambda: [parse_commands(datagram) for _ in range(1000)]) * 1e3:12.1f}")
    for name in ("stamina", "random/monkey_rules_0"):
        cycles = replay_scenario(DATA / f"{name}.jsonl.gz").cycles
        took = cpu(lambda n=name: replay_scenario(DATA / f"{n}.jsonl.gz"))
        print(f"{'replay and compare one cycle, ' + name:44} {took / cycles * 1e6:12.1f}")


if __name__ == "__main__":
    main()
