"""Methods beyond counting and solving: what each says of a behaviour, or why it says nothing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...agents.worlds.learned import heeds_of
from ...agents.worlds.observer import TAU, simulated_approaches, simulator_approach
from ...architecture.analysis.bounds import Bounds
from ...architecture.analysis.budget import Budget
from ...architecture.analysis.certificates.slow_approach import propose
from ...architecture.analysis.high_level.automatic import automatic_analysis
from ...architecture.analysis.markov.absorption import Absorption
from ...architecture.analysis.markov.chain import MarkovChain
from ...architecture.analysis.modules.contracts import check_contract
from ...architecture.analysis.product.learned_world import LearnedWorld
from ...architecture.analysis.rare.conditional import conditional
from ...architecture.analysis.rare.importance import importance_sampling, learned_h
from ...architecture.analysis.rare.splitting import split_chain
from ...architecture.analysis.sampling.runs import ChainRuns
from ...architecture.petri import PetriNet
from ...architecture.petri.net.modules import Instance, instances
from ...errors import CostError, ModelError

PROVED = ("approach",)
"""Behaviours of which a proof is stated: the last part of the approach is that of Appendix A."""
RUNS = 2000
"""Of conditional and split runs."""


@dataclass(frozen=True)
class Said:
    """What one method says.

    Attributes
    ----------
    applies : bool
    says : str
        In a sentence; of one that does not apply, why.
    lines : tuple of str
        In full.
    data : mapping
        As plain values.
    holds : bool or None
        Where the method gives a verdict.
    """

    applies: bool
    says: str
    lines: tuple[str, ...] = ()
    data: Mapping[str, Any] = field(default_factory=dict)
    holds: bool | None = None

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        return {"applies": self.applies, "says": self.says, "lines": list(self.lines), **self.data}


def rare(exact: Absorption, outcome: str, done: str, seed: int, confidence: float) -> Said:
    """The outcome that is feared: solved, drawn given that it comes, sampled with leaning runs and with split ones.

    Parameters
    ----------
    exact : Absorption
        Of the behaviour's chain.
    outcome, done : str
        What is feared, and what is wanted.
    seed : int
    confidence : float
    """
    chain = exact.chain
    if outcome not in chain.outcomes or not exact.probability(outcome).value > 0.0:
        return Said(False, f"along what was learned nothing comes but {done}: nothing to lean to or to draw")
    p = exact.probability(outcome)
    given = conditional(chain, outcome, exact)
    drawn = ChainRuns(given.chain).play(range(RUNS), seed, False)
    lengths = np.array([run.cycles for run in drawn], float)
    one = _from_one_state(chain)
    leaning = importance_sampling(one, outcome, learned_h(one, outcome, seed=seed), seed=seed, confidence=confidence)
    says = f"{outcome} has {p.value:.4g} along what was learned; leaning runs say {leaning.value:.4g} {_both(leaning.interval)}"
    lines = [
        f"{RUNS} runs drawn given that they end in {outcome}: {lengths.mean():.1f} cycles each, {lengths.min():.0f} to {lengths.max():.0f}",
        f"leaning runs (importance sampling): {leaning.value:.4g} {_both(leaning.interval)} from {leaning.steps:,} cycles"
        + ("" if leaning.trusted else "; not to be trusted: few of them carry most of it"),
    ]
    data: dict[str, Any] = {
        "outcome": outcome, "exact": p.value, "conditional_cycles": float(lengths.mean()),
        "importance": {"value": leaning.value, "interval": list(leaning.interval), "cycles": leaning.steps, "trusted": leaning.trusted},
    }  # fmt: skip
    try:
        level = np.append(np.log(np.maximum(given.h, 1e-300)), -np.inf)
        split = split_chain(one, outcome, level, RUNS // 4, 10, seed=seed, confidence=confidence)
        lines.append(
            f"split runs: {split.value:.4g} {_both(split.interval)} from {split.steps:,} cycles; "
            f"{split.zeros:.0%} of the repetitions found none"
        )
        data["splitting"] = {"value": split.value, "interval": list(split.interval), "cycles": split.steps, "zeros": split.zeros}
    except CostError as error:
        lines.append(f"split runs: none, {error}")
    return Said(True, says, tuple(lines), data)


def _from_one_state(chain: MarkovChain) -> MarkovChain:
    """The chain with one state more, from which it begins where it would."""
    begun = np.flatnonzero(chain.initial)
    initial = np.zeros(chain.n + 1)
    initial[-1] = 1.0
    return MarkovChain(
        np.append(chain.offsets, chain.offsets[-1] + len(begun)), np.concatenate((chain.targets, begun.astype(np.int32))),
        np.concatenate((chain.chances, chain.initial[begun])), chain.outcomes, initial,
    )  # fmt: skip


def modules(net: PetriNet, world: LearnedWorld, done: str, budget: Budget) -> Said:
    """The skill's modules one by one, chained (Algorithm 3.1).

    Parameters
    ----------
    net : PetriNet
    world : LearnedWorld
    done : str
    budget : Budget
    """
    skills = _skills(net)
    if len(skills) != 1:
        return Said(False, f"{' and '.join(sorted(skills))} work at once: they are analysed as one (Algorithm 3.2), by the chain")
    ((path, skill),) = skills.items()
    if not skill.net.modules:
        return Said(False, f"{skill.net.name} has no modules")
    parts = world.coarser(world.edges, heeds_of(net, parts=True))
    try:
        found = automatic_analysis(net, parts, path, budget=budget)
    except ModelError as error:
        return Said(False, f"{skill.net.name}: {error}")
    own = str(skill.net.ports.done)
    low, high = found.answer.outcomes.get(own, (0.0, 1.0))
    says = f"{done} with {_both(Bounds(low, high))} from its parts, of which the largest has {max(found.states.values())} states"
    if not found.complete:
        says += "; the budget ended it, so that parts are missing"
    outcomes = {name: list(bounds) for name, bounds in found.answer.outcomes.items()}
    return Said(True, says, tuple(str(found).splitlines()), {"outcomes": outcomes, "states": dict(found.states)})


def certificate(name: str, seed: int = 0) -> Said:
    """A proof that the behaviour closes with its goal, beside the longest of simulated approaches.

    Parameters
    ----------
    name : str
        Of the behaviour.
    seed : int
    """
    if name not in PROVED:
        return Said(False, f"no error metric is stated for {name}; there is one for {', '.join(PROVED)}")
    world = simulator_approach()
    proposed = propose(world, tau=TAU)
    if proposed is None:
        return Said(False, "no angles were found from which the proof of Appendix A follows")
    proof = proposed.check(world)
    broken = [c.name for c in proof.conditions if not c.holds]
    says = (
        f"Appendix A with the simulator's motion, noise and roundings: proved, at the ball within {proof.steps} cycles from 12 m"
        if proof.proved
        else f"Appendix A with the simulator's motion, noise and roundings: not proved, {', '.join(broken)} fails"
    )
    lines = [f"{c.name}: {'holds' if c.holds else 'fails'} by {float(c.margin):.4g}" for c in proof.conditions]
    if proof.proved:
        lines.append(f"each dash gives d' <= max({float(proof.ratio):.3f} d, d - {float(proof.amount):.3f})")
        played = simulated_approaches(RUNS, seed)
        slowest = "not all arrived" if (played < 0).any() else f"the slowest took {played.max()} cycles"
        lines.append(f"{RUNS} such approaches in the simulator: {slowest}")
    return Said(True, says, tuple(lines), {"proved": proof.proved, "steps": proof.steps}, proof.proved)


def contract(net: PetriNet, budget: Budget) -> Said:
    """What the skill promises its caller, in every environment.

    Parameters
    ----------
    net : PetriNet
    budget : Budget
    """
    reports = {path: check_contract(skill.net, budget=budget.part(0.9)) for path, skill in _skills(net).items()}
    holds = [r.holds for r in reports.values()]
    verdict = False if False in holds else None if None in holds else True
    broken = [f"{r.module}: {c.name} ({c.why})" for r in reports.values() for c in r.broken]
    words = {True: "kept in every environment", None: "undecided"}
    says = f"contract broken: {'; '.join(broken)}" if verdict is False else f"contract {words[verdict]}"
    lines = [line for r in reports.values() for line in str(r).splitlines()]
    return Said(True, says, tuple(lines), {"reports": {p: r.to_json() for p, r in reports.items()}}, verdict)


def _skills(net: PetriNet) -> dict[str, Instance]:
    """The skills of those who play, by their path."""
    return {path: i for path, i in instances(net).items() if path.split(".")[-1] == "skill"}


def _both(bounds: Bounds) -> str:
    return f"[{bounds.low:.4g}, {bounds.high:.4g}]"
