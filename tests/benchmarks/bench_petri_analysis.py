"""Speed of the structural analysis: ``python tests/benchmarks/bench_petri_analysis.py [--quick]``.

CPU seconds, median of three runs, compiled kernels warm. The references are the CPU seconds of LoLA 2, verifypn and LTSmin on the
same models (one core of a small machine, reductions off, parsing included); SNAKES is measured here, in the same run, if installed.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "helpers"))

from contract_modules import turn_to_ball  # noqa: E402
from structure_nets import flexible_manufacturing, kanban, landing_detector, token_ring  # noqa: E402

from cprm_gym.architecture.analysis.behaviour.properties import analyze_structure  # noqa: E402
from cprm_gym.architecture.analysis.behaviour.state_space import explore  # noqa: E402
from cprm_gym.architecture.analysis.modules.contracts import check_contract  # noqa: E402
from cprm_gym.architecture.analysis.net_arrays import System  # noqa: E402
from cprm_gym.architecture.analysis.structure.invariants import flow_basis  # noqa: E402
from cprm_gym.architecture.analysis.timed.environment import closed_system  # noqa: E402
from cprm_gym.architecture.analysis.timed.state_space import explore_timed  # noqa: E402
from cprm_gym.architecture.petri import PetriNet  # noqa: E402
from cprm_gym.architecture.petri.files.pnml_reader import read_pnml  # noqa: E402

CASES = ROOT.parent / "shared" / "cases" / "petri" / "mcc"
REFERENCES = {  # LoLA 2, verifypn, LTSmin
    "Dekker-PT-010": (0.10, 0.086, 0.23),
    "AirplaneLD-PT-0010": (0.13, 0.12, 0.41),
    "TokenRing-PT-010": (0.38, 0.26, 1.8),
    "Kanban-PT-0005": (13.1, 12.1, 17.0),
    "FMS-PT-005": (37.1, 13.1, 20.5),
}


def median_cpu(run: Callable[[], object], times: int = 3) -> tuple[float, object]:
    """Median CPU seconds of a call, and what it returned last."""
    taken = []
    result: object = None
    for _ in range(times):
        before = time.process_time()
        result = run()
        taken.append(time.process_time() - before)
    return statistics.median(taken), result


def models(quick: bool) -> dict[str, Callable[[], PetriNet]]:
    """Name -> how to get the net."""
    found: dict[str, Callable[[], PetriNet]] = {}
    files = ["Dekker-PT-010", "AutoFlight-PT-03a", "SharedMemory-PT-000010", "LamportFastMutEx-PT-4", "Dekker-PT-015"]
    for name in files[: 2 if quick else None]:
        if (CASES / f"{name}.pnml").is_file():
            found[name] = lambda name=name: read_pnml(CASES / f"{name}.pnml")
    found["AirplaneLD-PT-0010"] = lambda: landing_detector(10)
    found["TokenRing-PT-010"] = lambda: token_ring(10)
    found["Kanban-PT-0004" if quick else "Kanban-PT-0005"] = lambda: kanban(4 if quick else 5)
    if not quick:
        found["FMS-PT-005"] = lambda: flexible_manufacturing(5)
    return found


def state_spaces(quick: bool) -> float:
    """Print the table of state spaces; returns markings per second on Kanban."""
    explore(System.from_net(kanban(1)))
    print(f"{'model':24}{'markings':>11}{'firings':>12}{'CPU s':>8}{'M/s':>7}{'B each':>8}{'words':>6}  against LoLA 2, verifypn, LTSmin")
    rate = 0.0
    for name, load in models(quick).items():
        system = System.from_net(load())
        seconds, space = median_cpu(lambda system=system: explore(system))
        per_second = space.n_states / seconds
        ratio = ", ".join(f"{r / seconds:.1f} x" for r in REFERENCES.get(name, ()))
        print(
            f"{name:24}{space.n_states:11,}{space.n_edges:12,}{seconds:8.3f}{per_second / 1e6:7.2f}"
            f"{space.bytes_per_state:8.1f}{space.layout.words:6}  {ratio}"
        )
        if name.startswith("Kanban"):
            rate = per_second
    return rate


def graphs(quick: bool) -> None:
    """Print what the edges cost: kept while exploring, and found in a second pass."""
    print(f"\n{'edges of':24}{'firings':>12}{'explore s':>11}{'kept s':>9}{'2nd pass s':>12}  graph / exploration: kept, second pass")
    for net in (token_ring(10), kanban(4 if quick else 5)):
        system = System.from_net(net)
        alone, space = median_cpu(lambda system=system: explore(system))
        kept, _ = median_cpu(lambda system=system: explore(system, edge_memory=1 << 40).graph())
        second, _ = median_cpu(space.graph)
        print(
            f"{net.name:24}{space.n_edges:12,}{alone:11.3f}{kept - alone:9.3f}{second:12.3f}  {kept / alone - 1:.2f}, {second / alone:.2f}"
        )


def snakes_rate(net: PetriNet, states: int) -> float | None:
    """Markings per CPU second of SNAKES on a plain net; None if it is not installed."""
    try:
        from snakes import nets
    except ImportError:
        return None
    built = nets.PetriNet(net.name)
    dot = nets.dot
    for p in net.places:
        built.add_place(nets.Place(p.name, [dot] * p.tokens, nets.tBlackToken))
    for t in net.transitions:
        built.add_transition(nets.Transition(f"fire {t.name}"))
        for arcs, add in ((t.inputs, built.add_input), (t.outputs, built.add_output)):
            for place, weight in arcs.items():
                value = nets.Value(dot)
                add(place, f"fire {t.name}", value if weight == 1 else nets.MultiArc([value] * weight))
    graph = nets.StateGraph(built)
    before = time.process_time()
    count = 0
    for _ in graph:
        count += 1
        if count >= states:
            break
    return count / (time.process_time() - before)


def main() -> None:
    """Run everything."""
    quick = "--quick" in sys.argv
    rate = state_spaces(quick)
    graphs(quick)
    reference = snakes_rate(kanban(5), 100 if quick else 300)
    if reference is None:
        print("\nSNAKES is not installed")
    else:
        print(f"\nSNAKES on Kanban-PT-0005: {reference:,.0f} markings/s; ours {rate:,.0f}: {rate / reference:,.0f} x")
    net = token_ring(5)
    seconds, _ = median_cpu(lambda: analyze_structure(net))
    print(f"\nall structural properties, TokenRing-PT-005: {seconds * 1e3:.1f} ms")
    system = System.from_net(token_ring(10))
    seconds, basis = median_cpu(lambda: flow_basis(system))
    print(f"P-invariant basis, TokenRing-PT-010 (121 places, 1111 transitions): {seconds * 1e3:.1f} ms, {len(basis.vectors)} vectors")
    module = turn_to_ball()
    check_contract(module)
    seconds, report = median_cpu(lambda: check_contract(module), 9)
    print(f"module contract, turn_to_ball: {seconds * 1e3:.1f} ms, {report.states} states, {report.nodes} steps")
    timed = closed_system(module)
    seconds, space = median_cpu(lambda: explore_timed(timed), 9)
    print(f"its steps alone: {space.n_nodes / seconds / 1e3:.0f} k steps/s")


if __name__ == "__main__":
    main()
