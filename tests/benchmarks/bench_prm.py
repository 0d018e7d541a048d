"""What a step of the filter costs: ``python tests/benchmarks/bench_prm.py [--quick]``.

CPU time of this process in milliseconds, medians. The world is the one of `tests/architecture/prm/inference_scene.py`: a ball and
opponents with four hidden quantities each. A step takes the readings, makes the new belief and reads off every hidden marginal.
The other engines answer the same questions about the same two slices; they are given their belief for free, only their inference
is timed.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

warnings.simplefilter("ignore")
try:
    import pyagrum  # before anything that loads torch: the two libraries do not start in the other order
except ImportError:
    pyagrum = None

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))
import ball_world  # noqa: E402
from inference_scene import Active, Scene  # noqa: E402

from cprm_gym.architecture.prm.grounding.slices import GroundSlice  # noqa: E402
from cprm_gym.architecture.prm.inference.filter import Filter  # noqa: E402
from cprm_gym.architecture.prm.inference.filter_bank import FilterBank  # noqa: E402
from cprm_gym.architecture.prm.inference.links import Link, Role  # noqa: E402
from cprm_gym.architecture.prm.model.domains import Index  # noqa: E402

QUICK = "--quick" in sys.argv


def median_ms(run: Callable[[int], Any], times: int) -> float:
    """Median CPU time of ``run(k)``."""
    spent = []
    for k in range(max(3, times // 4) if QUICK else times):
        begun = process_time()
        run(k)
        spent.append(process_time() - begun)
    return 1e3 * float(np.median(spent))


class Stepper:
    """A filter with readings made beforehand."""

    def __init__(self, scene: Scene, active: Active, width: int = 1, engine: str = "exact", **options: Any) -> None:
        rng = np.random.default_rng(1)
        self.scene, self.active = scene, active
        self.filter = Filter(scene, batch=width, engine=engine, **options)
        self.readings = [scene.readings(rng, width) for _ in range(20)]
        self.names = scene.hidden(active)
        self.filter.step(self.readings[0])
        for k in range(6):
            self(k)

    def __call__(self, k: int, active: Active | None = None) -> Any:
        result = self.filter.step(self.readings[k % 20], relations=active or self.active)
        for name in self.names:
            result[name]
        return result


def line(what: str, value: float, goal: float | None = None, more: str = "") -> None:
    """One row of the table."""
    verdict = "" if goal is None else f"goal {goal:g} {'met' if value <= goal else 'MISSED'}"
    print(f"{what:58s} {value:10.3f} ms  {verdict:20s} {more}", flush=True)


def steps() -> None:
    """One agent."""
    print("\none agent, one step")
    for bins in (10, 30):
        line(f"ball, {bins} bins", median_ms(Stepper(Scene(bins, 0), Active()), 300))
    line("ball, seen couples all four, 10 bins", median_ms(Stepper(Scene(10, 0, coupled=True), Active()), 100))
    for bins, goal in ((10, 1.0), (30, 2.0)):
        scene = Scene(bins)
        for attended in (0, 3, 11):
            active = Active(scene.opponents[:attended])
            line(f"ball + 11, {attended} attended, {bins} bins", median_ms(Stepper(scene, active), 300), goal)
    pair = Active(("o1",), "o1")
    line("possession pair, exact, 10 bins", median_ms(Stepper(Scene(10, 1), pair), 60), 5.0)
    stepper = Stepper(Scene(30, 1), pair, engine="projection")
    losses: list[float] = []
    spent = median_ms(lambda k: losses.append(float(stepper(k).loss[0])), 100)
    line(
        "possession pair, projected, 30 bins",
        spent,
        5.0,
        f"loss of a projection: mean {np.mean(losses):.1e}, worst {np.max(losses):.1e} nats",
    )
    line("ball, 10 bins, anytime", median_ms(Stepper(Scene(10, 0), Active(), engine="anytime"), 100))
    for particles in (100, 1000, 10_000):
        stepper = Stepper(Scene(10, 0), Active(), engine="particles", particles=particles, seed=0)
        line(f"ball, 10 bins, {particles} particles", median_ms(stepper, 40))


def batches() -> None:
    """Many agents."""
    print("\nball + 11 attended, 10 bins, for each agent of a batch")
    scene = Scene(10)
    for width in (1, 10, 100, 1000):
        line(f"{width} agents", median_ms(Stepper(scene, scene.all_attended(), width), 200 // width + 4) / width, 0.3)


def switches() -> None:
    """Relations that go on and off."""
    print("\nswitching, on top of a step that does not switch")
    scene = Scene(10)
    one, other = Active(scene.opponents[:6]), Active(scene.opponents[3:9])
    stepper = Stepper(scene, one)
    for k in range(12):
        stepper(k, (one, other)[k % 2])
    switching = median_ms(lambda k: stepper(k, (one, other)[k % 2]), 200)
    steady = median_ms(lambda k: stepper(k, one), 200)
    line("attention moves, structures known", max(switching - steady, 0.0), 0.1, f"{switching:.3f} against {steady:.3f}")
    scene = Scene(10, 1)
    spent = []
    for seed in range(3 if QUICK else 9):
        fresh = Stepper(scene, Active(("o1",)))
        begun = process_time()
        fresh(seed, Active(("o1",), "o1"))
        spent.append(process_time() - begun)
    line("possession begins, structure never seen (10 bins)", 1e3 * float(np.median(spent)), 50.0)
    spent = []
    scene = Scene(30)
    for seed in range(3 if QUICK else 9):
        fresh = Stepper(scene, Active(scene.opponents[:5]))
        begun = process_time()
        fresh(seed, Active(scene.opponents[:6]))
        spent.append(process_time() - begun)
    line("one opponent more attended, never seen (30 bins)", 1e3 * float(np.median(spent)), 50.0)


def wandering() -> None:
    """Attention that moves at random in a model with its own grounding, where steps are made by form."""
    print("\nattention at random, ball + 11, 10 bins, after 1000 steps of it")
    rng = np.random.default_rng(0)
    for many in (3, None):
        filter_ = Filter(ball_world.scene(10, 11))
        names = filter_.variables()
        readings = np.full((len(names), 1), -1)
        for k, name in enumerate(names):
            readings[k] = {"obs_dist": 2, "obs_dir": 5, "seen": 1}.get(name.partition(".")[2], -1)

        def attended() -> tuple[str, ...]:
            return tuple(f"attended(o{k})" for k in rng.permutation(np.arange(1, 12))[: many or rng.integers(0, 12)])  # noqa: B023

        for _ in range(1000):
            filter_.step(readings, attended())
        sets = [attended() for _ in range(500)]
        fixed = median_ms(lambda k: filter_.step(readings, sets[0]), 300)  # noqa: B023
        moving = median_ms(lambda k: filter_.step(readings, sets[k]), 500)  # noqa: B023
        what = f"{many} of 11" if many else "any number of 11"
        line(
            f"{what} attended at random",
            moving,
            2.0 * fixed if many else None,
            f"the same ones all the time: {fixed:.3f}, {moving / fixed:.2f} times",
        )


def banks() -> None:
    """Agents of a bank, each of whom attends to two opponents at random."""
    print("\na bank, ball + 11, 10 bins, each agent attends to two others in every step")
    rng = np.random.default_rng(0)
    for width in (1, 8, 250):
        bank = FilterBank(ball_world.scene(10, 11), width)
        told = {f"{o}.seen": rng.integers(0, 2, width) for o in bank.grounding.objects}
        told |= {f"{o}.obs_dist": Index(rng.integers(2, 5, width)) for o in bank.grounding.objects}

        def step(_: int) -> None:
            pairs = rng.permuted(np.tile(np.arange(11), (width, 1)), axis=1)[:, :2].T  # noqa: B023
            bank.step(told, [Link("attended", (Role("Opponent", whom),)) for whom in pairs])  # noqa: B023

        for k in range(20 if width > 8 else 200):
            step(k)
        line(f"{width} agents", median_ms(step, 20 if width > 8 else 200))


def growth() -> None:
    """Opponents that nobody attends to."""
    print("\nunattended opponents, 10 bins")
    last = None
    for opponents in (11, 22, 44, 88, 176):
        spent = median_ms(Stepper(Scene(10, opponents), Active()), 100)
        line(f"ball + {opponents}", spent, None, "" if last is None else f"{spent / last:.2f} times the row above")
        last = spent


# ------------------------------------------------------------------------------------------------------ other engines


Belief = dict[tuple[str, ...], np.ndarray]
"""Joints of groups of variables that are independent of each other."""


def two_slices(ground: GroundSlice, belief: Belief) -> list[tuple[str, list[str], np.ndarray]]:
    """CPDs of a two-slice net: (child, parents, table with the child last); a past variable is called ``name@``.

    A joint of the past is written as a chain, P(a) P(b | a) P(c | a, b) ...
    """
    out: list[tuple[str, list[str], np.ndarray]] = []
    for names, joint in belief.items():
        for k, name in enumerate(names):
            upto = joint.sum(axis=tuple(range(k + 1, joint.ndim)))
            total = upto.sum(axis=-1, keepdims=True)
            chain = np.where(total > 0, upto / np.where(total > 0, total, 1.0), 1.0 / upto.shape[-1])
            out.append((f"{name}@", [f"{n}@" for n in names[:k]], chain))
    for c in ground.cpds:
        out.append((c.child, [f"{p}@" if lag else p for p, lag in c.parents], c.table))
    return out


def belief_of(result: Any, linked: Sequence[str], possessor: str = "") -> Belief:
    """What the next step needs: joints of each object's linked pairs, or all of a possessor."""
    groups: list[tuple[str, ...]] = []
    for o in linked:
        if possessor:
            groups += [tuple(f"{o}.{x}" for x in ("dist", "vdist", "dir", "vdir", "orient"))] if o == possessor else []
            continue
        groups += [(f"{o}.dist", f"{o}.vdist"), (f"{o}.dir", f"{o}.vdir")] + ([(f"{o}.orient",)] if o != "b" else [])
    return {names: result.joint(*names)[0] for names in groups}


def ask_pyagrum(
    cpds: list[tuple[str, list[str], np.ndarray]], names: list[str], pairs: list[tuple[str, ...]]
) -> Callable[[dict[str, int]], Any]:
    """A function that gives all marginals, and the joints that are the next belief."""
    net = pyagrum.BayesNet()
    for child, _, table in cpds:
        net.add(pyagrum.LabelizedVariable(child, child, table.shape[-1]))
    for child, parents, table in cpds:
        for p in parents:
            net.addArc(p, child)
        scope = [*parents, child]
        net.cpt(child)[:] = np.ascontiguousarray(np.transpose(table, [scope.index(n) for n in net.cpt(child).names[::-1]]))

    def step(evidence: dict[str, int]) -> dict[str, np.ndarray]:
        engine = pyagrum.LazyPropagation(net)
        engine.setEvidence(evidence)
        engine.setTargets(set(names))
        for pair in pairs:
            engine.addJointTarget(set(pair))
        engine.makeInference()
        for pair in pairs:
            engine.jointPosterior(set(pair)).toarray()
        return {n: engine.posterior(n).toarray() for n in names}

    return step


def ask_pgmpy(
    cpds: list[tuple[str, list[str], np.ndarray]], names: list[str], pairs: list[tuple[str, ...]]
) -> Callable[[dict[str, int]], Any]:
    """The same with pgmpy's variable elimination, one query for each marginal and joint."""
    from pgmpy.factors.discrete import TabularCPD
    from pgmpy.inference import VariableElimination
    from pgmpy.models import DiscreteBayesianNetwork

    net = DiscreteBayesianNetwork()
    net.add_nodes_from([child for child, _, _ in cpds])
    net.add_edges_from([(p, child) for child, parents, _ in cpds for p in parents])
    for child, parents, table in cpds:
        rows = np.moveaxis(table, -1, 0).reshape(table.shape[-1], -1)
        net.add_cpds(TabularCPD(child, rows.shape[0], rows, parents, list(table.shape[:-1])))
    engine = VariableElimination(net)

    def step(evidence: dict[str, int]) -> dict[str, np.ndarray]:
        for pair in pairs:
            engine.query(list(pair), evidence=evidence, show_progress=False)
        return {n: engine.query([n], evidence=evidence, show_progress=False).values for n in names}

    return step


def others() -> None:
    """The same step by pyAgrum and pgmpy, and that they agree."""
    print("\nthe same step by other engines (CPU ms, and how many times ours)")
    cases = [
        ("ball, 10 bins", Scene(10, 0), Active()),
        ("ball, 30 bins", Scene(30, 0), Active()),
        ("ball + 11, 3 attended, 10 bins", Scene(10), Active(("o1", "o2", "o3"))),
        ("ball + 11, all attended, 10 bins", Scene(10), Scene(10).all_attended()),
        ("ball + 11, all attended, 30 bins", Scene(30), Scene(30).all_attended()),
        ("possession pair, 10 bins", Scene(10, 1), Active(("o1",), "o1")),
    ]
    for what, scene, active in cases:
        stepper = Stepper(scene, active)
        ours = median_ms(stepper, 200)
        belief = belief_of(stepper(0), ["b", *active.attended], active.possessor)
        cpds = two_slices(scene.ground(active), belief)
        pairs = [names for names in belief if len(names) > 1]
        rng = np.random.default_rng(3)
        given = [{n: s for n, s in scene.readings(rng).items() if s >= 0} for _ in range(8)]
        snapshot = stepper.filter.state
        answers = stepper.filter.step(given[0], relations=active)
        stepper.filter.state = snapshot
        for name, ask, times in (("pyAgrum LazyPropagation", ask_pyagrum, 12), ("pgmpy VariableElimination", ask_pgmpy, 4)):
            if name.startswith("pyAgrum") and pyagrum is None:
                print(f"{what}: pyAgrum is not installed")
                continue
            step = ask(cpds, scene.hidden(active), pairs)
            worst = max(float(np.abs(p - answers[n][0]).max()) for n, p in step(given[0]).items())
            theirs = median_ms(lambda k, step=step, given=given: step(given[k % 8]), times)
            print(
                f"{what:36s} {name:26s} {theirs:10.2f} ms  ours {ours:7.3f}  {theirs / ours:8.1f} times  (differ by {worst:.0e})",
                flush=True,
            )


def endurance() -> None:
    """Many steps."""
    print("\nball, 10 bins, 10^5 steps" if not QUICK else "\nball, 10 bins, 10^4 steps")
    stepper = Stepper(Scene(10, 0), Active())
    parts = []
    worst = 0.0
    for _ in range(10):
        begun = process_time()
        for k in range(1000 if QUICK else 10_000):
            result = stepper.filter.step(stepper.readings[k % 20])
        parts.append(1e6 * (process_time() - begun) / (k + 1))
        worst = max(worst, *(abs(float(result[n].sum()) - 1.0) for n in stepper.names))
    print(f"microseconds for a step, tenth by tenth: {', '.join(f'{p:.0f}' for p in parts)}; |sum - 1| at most {worst:.1e}")


if __name__ == "__main__":
    for part in (steps, batches, switches, wandering, banks, growth, others, endurance):
        part()
