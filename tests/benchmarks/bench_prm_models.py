"""Speed of the modelling side: tables, grounding, switching, views, files and learning. CPU time, best of several.

python tests/benchmarks/bench_prm_models.py
python tests/benchmarks/bench_prm_models.py --bif munin4.bif    # a query, and what it takes to explain impossible readings of leaves
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))

from ball_world import scene, soccer

from cprm_gym.architecture.prm import Filter, Grounding
from cprm_gym.architecture.prm.inference.bayes_net import BayesNet
from cprm_gym.architecture.prm.inference.learning import Episode, Observed, em
from cprm_gym.architecture.prm.inference.views import view
from cprm_gym.architecture.prm.interchange.bif import load_bif
from cprm_gym.architecture.prm.interchange.json import model_from_json, model_to_json
from cprm_gym.architecture.prm.model import integration
from cprm_gym.architecture.prm.model import resolved as checking
from cprm_gym.architecture.prm.model.domains import Bins, Index
from cprm_gym.errors import ImpossibleEvidence


def clear() -> None:
    """Forget every table that was made."""
    checking._remembered.cache_clear()
    integration._integrated.cache_clear()


def cpu(action: Callable[[], object], times: int, repeats: int = 5, before: Callable[[], object] = lambda: None) -> float:
    """Milliseconds of one call, the best of some repeats."""
    best = np.inf
    for _ in range(repeats):
        before()
        start = time.process_time()
        for _ in range(times):
            action()
        best = min(best, (time.process_time() - start) / times)
    return float(1e3 * best)


def explanations(path: str) -> None:
    """Readings of the last leaves of a net, at random: what a query of all marginals takes, and what finding a conflict among them does."""
    net = BayesNet(load_bif(path))
    variables, cpds = net.info.slice.variables, net.info.slice.cpds
    parents = {parent for cpd in cpds for parent, _ in cpd.parents}
    leaves = [name for name in variables if name not in parents]
    rng = np.random.default_rng(0)
    states = {name: Index(int(rng.integers(variables[name].card))) for name in leaves}
    print(f"{path}: {len(variables)} variables; a query {cpu(net.query, 1, 3):.0f} ms")
    for count in (8, 30, len(leaves)):
        evidence = {name: states[name] for name in leaves[-count:]}
        start = time.process_time()
        try:
            net.query(evidence)
            found = "possible"
        except ImpossibleEvidence as error:
            found = f"{len(error.conflict)} of them conflict"
        print(f"{count} readings: {1e3 * (time.process_time() - start):.0f} ms, {found}")


def main() -> None:
    """Print the table."""
    if "--bif" in sys.argv:
        return explanations(sys.argv[sys.argv.index("--bif") + 1])
    rows: list[tuple[str, float]] = []
    for bins in (10, 20, 30):
        rows.append((f"model with all tables, {bins} bins", cpu(partial(soccer, bins), 1, 3, clear)))
    text = model_to_json(soccer(10))
    rows.append(("model read from JSON, tables remembered", cpu(lambda: model_from_json(text), 5)))
    world = scene(10, 11)
    rows.append(("slice of ball and 11 opponents, new", cpu(lambda: world.ground(["attended(o1)"]), 1, 20, world._slices.clear)))
    rows.append(("the same, switched to again", cpu(lambda: world.ground(["attended(o1)"]), 1000)))
    tracker = Filter(Grounding(soccer(10), world.objects))
    everyone = [f"attended(o{k})" for k in range(1, 12)]
    readings = {f"{o}.{a}": x for o in world.objects for a, x in (("obs_dist", 12.0), ("obs_dir", 0.2), ("seen", 1))}
    for _ in range(3):
        tracker.step(readings, everyone)
        tracker.step(readings, everyone[:5])
    rows.append(("filter step, ball and 11 attended", cpu(lambda: tracker.step(readings, everyone), 50)))

    def switch() -> None:
        tracker.step(readings, everyone[:5])
        tracker.step(readings, everyone)

    rows.append(("the same, switching six of them each step", cpu(switch, 20) / 2))
    beliefs = np.random.default_rng(0).dirichlet(np.ones(30), 1000)
    bins30 = Bins.linear(0, 60, 30)
    for name in ("expectation", "variance", "probability(3..17)", "quantile(0.9)", "entropy"):
        made = view(name)
        rows.append((f"view {name}, 1000 agents, 30 bins", cpu(partial(made, beliefs, bins30), 50)))
    single = scene(5, 0)
    steps = tuple(Observed({"ball.obs_dist": np.full(50, 10.0 + t), "ball.seen": 1}) for t in range(20))
    rows.append(("EM iteration, 50 runs of 20 steps, 5 bins", cpu(lambda: em(single, [Episode(steps, 50)], iterations=1), 1, 3)))
    width = max(len(name) for name, _ in rows)
    for name, ms in rows:
        print(f"{name:<{width}}  {ms:10.4f} ms")


if __name__ == "__main__":
    main()
