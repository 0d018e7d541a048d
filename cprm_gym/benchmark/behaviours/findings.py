"""What the methods say of one behaviour, side by side."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...agents.worlds.learned import behaviour as named
from ...agents.worlds.runs import FilmedRun, film
from ...agents.worlds.stage import Change
from ...architecture.analysis.bounded.regular import RegularBounds
from ...architecture.analysis.bounded.value_iteration import IntervalBounds
from ...architecture.analysis.bounds import Bounds
from ...architecture.analysis.markov.absorption import Absorption
from ...architecture.analysis.markov.over_time import OverTime
from ...architecture.analysis.product.explore import Product
from ...architecture.analysis.product.learned_world import LearnedWorld
from ...architecture.analysis.rare.conditional import conditional
from ...architecture.analysis.sampling.intervals import simultaneous
from ...architecture.analysis.sampling.runs import UNFINISHED, ChainRuns
from ...architecture.analysis.sampling.sample import Sample
from .judged import Judged
from .methods import Said

FRESH = 1_000_003
"""Between the seed from which a world is learned and that of fresh episodes."""


@dataclass
class BehaviourReport:
    """What the methods say of one behaviour.

    Attributes
    ----------
    name : str
    done : str
        The outcome that is wanted.
    episodes, seed : int
        From how many episodes the world was learned, and as many fresh ones played.
    product : Product or None
    exact : Absorption or None
    over_time : OverTime or None
    bounds : mapping of str to Bounds
        What holds of each outcome: the best of both that follow, at once with the confidence of the report.
    regular : RegularBounds or None
        From what most runs keep to, with what the rest can be.
    rows : IntervalBounds or None
        From every row by itself.
    text : mapping of str to Bounds
        The text's own bounds (unknown state).
    sampled : Sample or None
    simulator : mapping of str to int
        Outcome -> fresh episodes that ended so.
    played : Sample or None
        The same with what properties hold of them.
    ended : (episodes,) int64
        When each of these ended, -1: not.
    judged : list of Judged
        Conditions that the behaviour is said to keep, as they came out in these.
    said : dict of str to Said
        Method -> what it says beside these numbers, or why it says nothing.
    require : float or None
        What the wanted outcome's probability has to be at least.
    notes : list of str
        What did not apply, and why.
    """

    name: str
    done: str
    episodes: int
    seed: int
    confidence: float = 0.95
    world: LearnedWorld | None = None
    product: Product | None = None
    exact: Absorption | None = None
    over_time: OverTime | None = None
    bounds: Mapping[str, Bounds] = field(default_factory=dict)
    regular: RegularBounds | None = None
    rows: IntervalBounds | None = None
    text: Mapping[str, Bounds] = field(default_factory=dict)
    sampled: Sample | None = None
    simulator: Mapping[str, int] = field(default_factory=dict)
    played: Sample | None = None
    ended: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    judged: list[Judged] = field(default_factory=list)
    said: dict[str, Said] = field(default_factory=dict)
    require: float | None = None
    notes: list[str] = field(default_factory=list)
    interrupted: bool = False
    change: Change | None = None

    @property
    def outcomes(self) -> tuple[str, ...]:
        """All that any method names, in its order."""
        names: list[str] = [*self.simulator]
        if self.product is not None:
            names = [*self.product.chain.outcomes, *names]
        return tuple(dict.fromkeys(names))

    @property
    def simulated(self) -> dict[str, Bounds]:
        """Clopper-Pearson intervals of the fresh episodes, holding at once."""
        return simultaneous(dict(self.simulator), self.confidence) if self.simulator else {}

    @property
    def verdict(self) -> bool | None:
        """Whether the requirement holds in the simulator: None where the interval holds it, or nothing was required or played."""
        if self.require is None or not self.simulator:
            return None
        interval = self.simulated[self.done]
        return True if interval.low >= self.require else False if interval.high < self.require else None

    @property
    def failing(self) -> list[str]:
        """Conditions that do not hold, and clauses of the contract that are broken, in words."""
        found = [str(j) for j in self.judged if j.holds is False]
        said = self.said.get("contract")
        return found + ([said.says] if said is not None and said.holds is False else [])

    @property
    def broken(self) -> bool:
        """Whether a requirement, a condition or the contract is."""
        return self.verdict is False or bool(self.failing)

    def difference(self) -> str:
        """How far the learned cells are from the simulator, in words."""
        if self.exact is None or not self.simulator:
            return ""
        p, real = self.exact.probability(self.done).value, self.simulated[self.done]
        if real.holds(p):
            return f"the learned cells say {p:.4f}, within the simulator's {real}"
        unseen = self.exact.probability("unseen").value if "unseen" in self.exact.outcomes else 0.0
        why = f"runs that come to what was never seen have {unseen:.4f} of it; " if unseen > 0 else ""
        return (
            f"the learned cells say {p:.4f}, the simulator {real}: {why}within a cell the past still matters (how far, how fast, how long "
            "unseen), which cells forget"
        )

    def witness(self, outcome: str) -> list[str]:
        """The likeliest run to an outcome, cycle by cycle; empty where it does not come."""
        if self.product is None or self.exact is None:
            return []
        if outcome == UNFINISHED:
            return self.product.tell(self._going_on())
        if outcome not in self.product.chain.outcomes:
            return []
        if not self.exact.probability(outcome).value > 0:
            return []
        run, _ = conditional(self.product.chain, outcome, self.exact).likeliest_run()
        return self.product.tell(run)

    def _going_on(self) -> list[int]:
        """The states of a run of the chain that has not ended in time."""
        assert self.product is not None
        n = self.product.chain.n
        runs = ChainRuns(self.product.chain, named(self.name).limit, {"state": np.arange(n, dtype=float)})
        for run in runs.play(range(1000), self.seed, True):
            if run.outcome == UNFINISHED:
                return [int(s) for s in run.signals["state"]]
        return []

    def causes(self, most: int = 5) -> list[str]:
        """Steps of the chain that set runs to the worst outcome apart from others, in words; empty where there are none."""
        if self.product is None or self.exact is None or self.worst not in self.product.chain.outcomes:
            return []
        if not self.exact.probability(self.worst).value > 0:
            return []
        chain = self.product.chain
        return [
            f"{chain.name(c.source)} -> {', '.join(self.product.commands[c.source]) or 'nothing'} -> {chain.name(c.target)}: "
            f"{c.flow:.2f} times in such a run, {c.lift:.3g} times as often as in others"
            for c in conditional(chain, self.worst, self.exact).causes(most)
        ]

    def shown(self) -> tuple[str, int] | None:
        """Which episode is filmed, and why: one that breaks a condition, or that came to the worst outcome, or any that there is."""
        if self.played is None or not self.played.runs:
            return None
        for j in self.judged:
            if j.holds is False:
                return f"An episode of the simulator that breaks: {j.condition.name}", j.first
        first = self.played.first
        outcome = next((o for o in (self.worst, *(o for o in first if o != self.done)) if o in first), self.done)
        return f"A run of the simulator to {outcome}", first.get(outcome, 0)

    def film(self) -> FilmedRun | None:
        """That episode."""
        found = self.shown()
        return None if found is None else film(self.name, found[1], self.seed + FRESH, self.change)

    @property
    def worst(self) -> str:
        """The likeliest outcome that is not wanted; `UNFINISHED` where most of the rest does not end in time."""
        if self.exact is None:
            return ""
        chances = {o: self.exact.probability(o).value for o in self.exact.chain.outcomes if o not in (self.done, "unseen")}
        if self.over_time is not None:
            chances[UNFINISHED] = float(self.over_time.remaining[-1])
        return max(chances, key=chances.__getitem__, default="")

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        rows: dict[str, Any] = {}
        for outcome in self.outcomes:
            row: dict[str, Any] = {}
            if self.exact is not None and outcome in self.exact.outcomes:
                p = self.exact.probability(outcome)
                row["exact"] = {"value": p.value, "error": p.error}
            if outcome in self.bounds:
                row["bounded"] = list(self.bounds[outcome])
            if self.rows is not None and outcome in self.rows.probabilities:
                row["every_row"] = list(self.rows.probabilities[outcome])
                row["unknown_state"] = list(self.text[outcome])
            if self.sampled is not None and outcome in self.sampled.outcomes:
                row["sampled"] = list(self.sampled.intervals()[outcome])
            if outcome in self.simulated:
                row["simulator"] = {"count": self.simulator[outcome], "interval": list(self.simulated[outcome])}
            rows[outcome] = row
        return {
            "behaviour": self.name,
            "wanted": self.done,
            "episodes": self.episodes,
            "seed": self.seed,
            "confidence": self.confidence,
            "states": self.product.chain.n if self.product is not None else None,
            "outcomes": rows,
            "expected_cycles": self.exact.expected_time.value if self.exact is not None else None,
            "simulator_cycles": float(self.ended[self.ended >= 0].mean()) if (self.ended >= 0).any() else None,
            "properties": self.sampled.to_json()["properties"] if self.sampled is not None else {},
            "simulator_properties": {
                name: found for name, found in (self.played.to_json()["properties"] if self.played is not None else {}).items()
                if name not in {j.condition.name for j in self.judged}
            },
            "conditions": [
                {"name": j.condition.name, "kind": j.condition.kind, "formula": j.condition.formula, "holds": j.holds,
                 "interval": list(j.interval), "floor": j.floor, "first_episode": None if j.first < 0 else j.first}
                for j in self.judged
            ],
            "methods": {name: said.to_json() for name, said in self.said.items()},
            "difference": self.difference(),
            "require": self.require,
            "verdict": self.verdict,
            "failing": self.failing,
            "witness": {self.worst: self.witness(self.worst)} if self.worst else {},
            "notes": list(self.notes),
            "interrupted": self.interrupted,
        }  # fmt: skip
