"""The same methods tried on every controller, through the interface that all have: what can be done, and what cannot.

``python -m cprm_gym.benchmark.behaviours.controllers --controllers cprm,fsm,behavior_tree,scripted --task GoToBall`` prints the table.

The dissertation (§5.3.3) says of code that neither Markov analysis nor backward analysis is to be had, and that states to begin in are hard
to name. Tried here: episodes are counted as of any system. What a controller remembers is looked for: a net's marking, or whole numbers
that an object keeps for each of its worlds. Cells of what the eye tells together with that make a closed-loop chain, which is solved,
bounded and asked for causes, whoever wrote the code; it says how far it is from episodes. What stays the net's alone is all that holds for
every environment.
"""

from __future__ import annotations

import argparse
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...agents.percepts import ball_percepts
from ...agents.play import SoccerAgent
from ...architecture.analysis.bounded.regular import path_bounds
from ...architecture.analysis.bounds import Bounds
from ...architecture.analysis.budget import Budget
from ...architecture.analysis.markov.chain import MarkovChain
from ...architecture.analysis.markov.over_time import outcomes_over_time
from ...architecture.analysis.rare.conditional import conditional
from ...architecture.analysis.report import analyze
from ...architecture.analysis.sampling.intervals import clopper_pearson
from ...architecture.petri import Place
from ...envs.controller import Controller, ControllerFactory
from ...envs.core import SoccerCore
from ...envs.others.registry import load_controller
from ...envs.tasks import Task, make_task
from ..arguments import at_least

CUTS: Mapping[str, tuple[float, ...]] = {
    "ball.seen": (0.5,),
    "ball.distance": (0.7, 1.0, 1.3, 1.7, 2.2, 3.0, 4.0, 6.0, 9.0, 13.0, 18.0, 25.0),
    "ball.direction_deg": (-90.0, -30.0, -12.0, 12.0, 30.0, 90.0),
    "body.fresh": (0.5,),
    "body.speed": (0.2,),
}
"""Where cells of what the eye tells are cut: the same for every controller."""
OUTCOMES = ("success", "failure", "out of time")


class Found(NamedTuple):
    """What one method says of one controller."""

    method: str
    can: bool
    says: str


@dataclass
class Tried:
    """One controller on one task, by every method.

    Attributes
    ----------
    name : str
    counts : dict of str to int
        Outcome -> fresh episodes.
    remembers : str
        Where its memory was found.
    chance : float
        Of success, from the closed-loop chain.
    states : int
        Of that chain.
    found : list of Found
    """

    name: str
    counts: dict[str, int]
    remembers: str
    chance: float
    states: int
    found: list[Found] = field(default_factory=list)


def memory_of(controller: Controller, worlds: int) -> tuple[str, list[Hashable]]:
    """What a controller remembers of each world, as far as it can be seen from outside, and where.

    Of a net its marking; of any object the whole or truth numbers that it, or a part of it, keeps as arrays of one entry for each world.
    Real numbers and beliefs are not told: they are infinitely many.
    """
    if isinstance(controller, SoccerAgent) and controller.controller is not None:
        executor = controller.controller.executor
        names = [p.name for p in executor.net.net.places if isinstance(p, Place)]
        columns = [executor.read(name) for name in names]
        return "marking", [tuple(float(c[w]) for c in columns) for w in range(worlds)]
    held = dict(vars(controller))
    held |= {f"{part}.{name}": v for part, inside in vars(controller).items() for name, v in getattr(inside, "__dict__", {}).items()}
    kept = {
        name: value
        for name, value in sorted(held.items())
        if isinstance(value, np.ndarray) and value.shape == (worlds,) and value.dtype.kind in "iub"
    }
    if not kept:
        return "", [()] * worlds
    return ", ".join(kept), [tuple(int(v[w]) for v in kept.values()) for w in range(worlds)]


class _Episodes(NamedTuple):
    outcomes: list[str]
    paths: list[list[Hashable]]
    remembers: str


def _play(make: ControllerFactory, task: Task, episodes: int, seed: int) -> _Episodes:
    """Episodes side by side: how each ended, and through which cells with which memory it went."""
    agent = "left_1"
    controller = make(task, agent)
    core = SoccerCore(task, episodes, seed=seed, include=tuple(getattr(controller, "needs", ())))
    observation = core.reset(seed)
    controller.reset({k: v[:, 0] for k, v in observation.items()}, seed)
    paths: list[list[Hashable]] = [[] for _ in range(episodes)]
    outcomes = [""] * episodes
    going = np.ones(episodes, bool)
    where, before = memory_of(controller, episodes)
    while going.any():
        mine = {k: v[:, 0] for k, v in observation.items()}
        cells = _cells(mine)
        for w in np.flatnonzero(going).tolist():
            paths[w].append((cells[w], before[w]))
        action = controller.act(mine)
        where, before = memory_of(controller, episodes)
        step = core.step({k: np.asarray(v)[:, None] for k, v in action.items()})
        observation = core.observation
        for w in np.flatnonzero(going & (step.terminated | step.truncated)).tolist():
            outcomes[w] = "success" if step.success[w].any() else "failure" if step.terminated[w] else "out of time"
            going[w] = False
    return _Episodes(outcomes, paths, where)


def _cells(observation: Mapping[str, NDArray[Any]]) -> list[tuple[int, ...]]:
    percepts = ball_percepts(observation)
    columns = [np.searchsorted(cut, np.nan_to_num(percepts[name], nan=-1e9), "right") for name, cut in CUTS.items()]
    return [tuple(row) for row in np.stack(columns, axis=1).tolist()]


def closed_loop(played: _Episodes) -> tuple[MarkovChain, list[dict[int, int]], dict[str, list[int]], dict[int, float]]:
    """The chain of cells with memory that episodes went through, its counts, outcomes and start."""
    number: dict[Hashable, int] = {}
    for path in played.paths:
        for state in path:
            number.setdefault(state, len(number))
    ends = {name: len(number) + k for k, name in enumerate(("success", "failure"))}
    counts: list[dict[int, int]] = [{} for _ in range(len(number) + len(ends))]
    start: dict[int, float] = {}
    for path, outcome in zip(played.paths, played.outcomes):
        start[number[path[0]]] = start.get(number[path[0]], 0.0) + 1.0 / len(played.paths)
        steps = [number[s] for s in path] + ([ends[outcome]] if outcome in ends else [])
        for a, b in pairwise(steps):
            counts[a][b] = counts[a].get(b, 0) + 1
    for i, row in enumerate(counts[: len(number)]):
        if not row:
            row[i] = 1  # where an episode ran out of time and no other ever was: it stays
    outcomes = {name: [k] for name, k in ends.items()}
    rows = [{j: n / sum(row.values()) for j, n in row.items()} for row in counts]
    names = [str(state) for state in number] + list(ends)
    return MarkovChain.from_rows(rows, outcomes, start, names), counts, outcomes, start


def try_methods(
    name: str, task: Task | str = "GoToBall", episodes: int = 1000, *, make: ControllerFactory | None = None, seed: int = 0,
    confidence: float = 0.95, proofs: float = 10.0,
) -> Tried:  # fmt: skip
    """Every method on one controller.

    Parameters
    ----------
    name : str
        Registered, unless a factory is given.
    task : Task or str
        With one agent.
    episodes, seed : int
        So many teach the chain, so many fresh ones are counted.
    make : callable, optional
        Makes the controller.
    confidence : float
    proofs : float
        Seconds for what is shown of a net.

    Raises
    ------
    UnknownName, ControllerError
    """
    task = make_task(task) if isinstance(task, str) else task
    factory = make or load_controller(name)
    taught, fresh = _play(factory, task, episodes, seed), _play(factory, task, episodes, seed + 1_000_003)
    counts = {o: fresh.outcomes.count(o) for o in OUTCOMES}
    chain, *_ = closed_loop(taught)
    cycles = task.max_cycles
    p = float(outcomes_over_time(chain, cycles).by("success")[-1])
    tried = Tried(name, counts, taught.remembers, p, chain.n)
    real = clopper_pearson(counts["success"], episodes, confidence)
    add = tried.found.append
    add(Found("episodes, with intervals", True, f"success {counts['success'] / episodes:.3f} {_both(real)}"))
    add(Found("what it remembers", bool(taught.remembers), taught.remembers or "nothing that can be seen from outside"))
    add(Found("Markov chain, closed loop", True, f"success {p:.3f} in {chain.n} states; {_aside(p, real)}"))
    bounds = path_bounds(_ended(taught), _ended(fresh), ("success", "failure"), confidence).probabilities["success"]
    add(Found("bounds of that chain", bounds.width < 0.5, f"success {_both(bounds)}"))
    what = "failure" if taught.outcomes.count("failure") else "success"
    if taught.outcomes.count(what):
        run, share = conditional(chain, what).likeliest_run()
        add(Found("what led to it", True, f"likeliest run to {what}: {len(run) - 1} cycles, {share:.2g} of all such runs"))
    else:
        add(Found("what led to it", False, "it never ends in time"))
    net = getattr(factory(task, "left_1"), "cprm", None)
    add(Found("from a state of one's choice", bool(taught.remembers), "its memory can be set" if taught.remembers else "its memory cannot"))
    if net is None:
        add(Found("every environment: deadlocks, reachability", False, "there is no net to explore"))
        add(Found("contracts and proofs", False, "nothing says what its parts promise"))
        return tried
    report = analyze(net.net, budget=Budget(seconds=proofs))
    timed = report.timed
    told = f"{timed.states} states; never stands still: {timed.never_stops}" if timed is not None else str(report.untimed.deadlock_free)
    add(Found("every environment: deadlocks, reachability", True, told))
    modules = sorted(net.net.modules)
    add(Found("contracts and proofs", bool(modules), f"of its modules: {', '.join(modules)}" if modules else "it has no modules"))
    return tried


def _ended(played: _Episodes) -> list[list[Hashable]]:
    """Paths with how they ended; one that ran out of time ends where it was."""
    return [path + ([] if outcome == "out of time" else [outcome]) for path, outcome in zip(played.paths, played.outcomes)]


def _both(bounds: Bounds) -> str:
    return f"[{bounds.low:.3f}, {bounds.high:.3f}]"


def _aside(p: float, real: Bounds) -> str:
    return "as episodes say" if real.holds(p) else f"{max(real.low - p, p - real.high):.3f} outside of what episodes say"


def to_markdown(tried: Sequence[Tried]) -> str:
    """Methods down, controllers across."""
    methods = list(dict.fromkeys(f.method for t in tried for f in t.found))
    lines = ["| method | " + " | ".join(t.name for t in tried) + " |", "|" + "---|" * (len(tried) + 1)]
    for method in methods:
        cells = []
        for t in tried:
            found = next((f for f in t.found if f.method == method), None)
            cells.append("" if found is None else f"{'yes' if found.can else 'no'}: {found.says}".replace("|", "/"))
        lines.append(f"| {method} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Every method of analysis, tried on controllers.")
    parser.add_argument("--controllers", default="cprm,fsm,behavior_tree,scripted,random")
    parser.add_argument("--task", default="GoToBall")
    parser.add_argument("--episodes", type=at_least(2), default=1000)
    parser.add_argument("--seed", type=at_least(0), default=0)
    options = parser.parse_args()
    names = options.controllers.split(",")
    print(to_markdown([try_methods(name, options.task, options.episodes, seed=options.seed) for name in names]))


if __name__ == "__main__":
    main()
