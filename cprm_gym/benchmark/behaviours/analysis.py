"""One behaviour in the simulator's world: every method that applies, side by side, and what they say of a requirement."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...agents.worlds.learned import behaviour as named
from ...agents.worlds.learned import learn_world
from ...agents.worlds.runs import FilmedRun, StageRuns, film
from ...agents.worlds.stage import Change
from ...architecture.analysis.bounded.unknown_state import unknown_state_bounds
from ...architecture.analysis.bounded.value_iteration import IntervalBounds, interval_bounds
from ...architecture.analysis.bounds import Bounds
from ...architecture.analysis.budget import Budget
from ...architecture.analysis.markov.absorption import Absorption, absorption
from ...architecture.analysis.markov.over_time import OverTime, outcomes_over_time
from ...architecture.analysis.product.explore import Product, product
from ...architecture.analysis.product.learned_world import LearnedWorld
from ...architecture.analysis.product.runs import ProductRuns
from ...architecture.analysis.rare.conditional import conditional
from ...architecture.analysis.sampling.intervals import simultaneous
from ...architecture.analysis.sampling.properties import properties as parsed
from ...architecture.analysis.sampling.runs import UNFINISHED, ChainRuns, Run
from ...architecture.analysis.sampling.sample import Sample, sample
from ...architecture.petri import PetriNet
from ...errors import ModelError, NetError, unknown_name

FRESH = 1_000_003
"""Between the seed from which a world is learned and that of fresh episodes."""
METHODS = ("exact", "bounded", "sampled", "simulator")
"""exact: the learned cells' likeliest chances; bounded: within their intervals; sampled: runs of the same; simulator: fresh episodes."""


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
    bounded : IntervalBounds or None
    text : mapping of str to Bounds
        The text's own bounds (unknown state).
    sampled : Sample or None
    simulator : mapping of str to int
        Outcome -> fresh episodes that ended so.
    played : Sample or None
        The same with what properties hold of them.
    ended : (episodes,) int64
        When each of these ended, -1: not.
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
    bounded: IntervalBounds | None = None
    text: Mapping[str, Bounds] = field(default_factory=dict)
    sampled: Sample | None = None
    simulator: Mapping[str, int] = field(default_factory=dict)
    played: Sample | None = None
    ended: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
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

    def film(self) -> FilmedRun | None:
        """An episode of the simulator that came to the worst outcome, if any did, or else to the first there is."""
        if self.played is None or not self.played.runs:
            return None
        first = self.played.first
        outcome = next((o for o in (self.worst, *(o for o in first if o != self.done)) if o in first), self.done)
        return film(self.name, first.get(outcome, 0), self.seed + FRESH, self.change)

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
            if self.bounded is not None and outcome in self.bounded.probabilities:
                row["bounded"] = list(self.bounded.probabilities[outcome])
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
            "simulator_properties": self.played.to_json()["properties"] if self.played is not None else {},
            "difference": self.difference(),
            "require": self.require,
            "verdict": self.verdict,
            "witness": {self.worst: self.witness(self.worst)} if self.worst else {},
            "notes": list(self.notes),
            "interrupted": self.interrupted,
        }


def analyze_behaviour(
    name: str, *, methods: Sequence[str] = METHODS, properties: Sequence[str] | Mapping[str, str] = (), episodes: int = 2000, seed: int = 0,
    confidence: float = 0.95, require: float | None = None, change: Change | None = None, budget: Budget | None = None,
    learned: LearnedWorld | None = None, progress: Callable[[str], object] | None = None,
) -> BehaviourReport:  # fmt: skip
    """Analyse a behaviour in the simulator's world.

    The world is learned from episodes: cells of what the net tests, cut at its own thresholds and finer, with intervals of all chances. Net
    and cells make one chain. The sampled answer plays that chain, the simulator's answer plays fresh episodes (other seeds) of the true
    thing: what differs between these two is what the cells forget.

    Parameters
    ----------
    name : str
        Of `BEHAVIOURS`.
    methods : sequence of str
        Of `METHODS`.
    properties : sequence or mapping of str
        Formulas over what the net observes and the commands that go out, looked at in sampled runs.
    episodes, seed : int
    confidence : float
    require : float, optional
        What the probability of the wanted outcome has to be at least.
    change : callable, optional
        Makes another net of the skill's: a version to be compared.
    budget : Budget, optional
    learned : LearnedWorld, optional
        A world at hand, instead of learning one.
    progress : callable, optional
        Told what is done now.

    Raises
    ------
    UnknownName, ModelError, ExpressionError
    """
    for method in methods:
        if method not in METHODS:
            raise unknown_name("method", method, METHODS)
    if not methods:
        raise ModelError(f"methods: none; there are {', '.join(METHODS)}")
    parsed(properties)  # before anything is played
    if episodes < 2 or (require is not None and not 0 < require < 1):
        raise ModelError(f"episodes {episodes}, require {require}: needs two episodes, and a probability")
    say = progress or (lambda _: None)
    limits, clock = (budget or Budget(states=200_000)).start()
    limit = named(name).limit
    report = BehaviourReport(name, "", episodes, seed, confidence, require=require, change=change)
    try:
        say("learning the world")
        _, half = limits.part(0.5).start()
        net, outcomes, world = learn_world(name, episodes if learned is None else 2, seed, net=change, confidence=confidence, clock=half)
        if half.spent() and learned is None:
            report.notes.append("the episodes that teach the world were ended before their time: what would have followed is 'unseen'")
        world = learned or world
        report.world, report.done = world, next(iter(outcomes))
        if clock.interrupted:
            raise KeyboardInterrupt
        if {"exact", "bounded"} & set(methods):
            say("exploring net and world")
            report.product = product(net, world, outcomes, budget=limits)
            if not report.product.complete:
                report.notes.append("net and world have more states than the budget grants: the rest is the outcome 'unexplored'")
        made = report.product
        if "exact" in methods and made is not None and not clock.spent():
            report.exact, report.over_time = absorption(made.chain), outcomes_over_time(made.chain, limit)
        if "bounded" in methods and made is not None and not clock.spent():
            say("bounding")
            report.bounded = interval_bounds(made.bounded)
            report.text = {o: unknown_state_bounds(made.bounded, o) for o in made.bounded.outcomes}
        if "sampled" in methods and not clock.spent():
            say("playing the learned world")
            runs = ProductRuns(net, world, outcomes, limit=20 * limit, ends=("unseen",))
            report.sampled = sample(runs, episodes, seed=seed + 1, confidence=confidence, properties_=properties, budget=limits)
        if "simulator" in methods and not clock.spent():
            say("playing the simulator")
            noted = _Noted(StageRuns(name, change))
            report.played = sample(
                noted, episodes, seed=seed + FRESH, confidence=confidence, properties_=properties, budget=limits, block=500
            )
            report.simulator, report.ended = {o: report.played.count(o) for o in noted.outcomes}, np.array(noted.ended)
        if properties and not {"sampled", "simulator"} & set(methods):
            report.notes.append("properties are looked at in runs, which were not asked for")
        if clock.interrupted or "interrupted" in {found.reason for found in (report.sampled, report.played) if found is not None}:
            raise KeyboardInterrupt
        if clock.spent():
            report.notes.append(f"the budget ended it: {clock.reason}")
    except KeyboardInterrupt:
        report.interrupted = True
        report.notes.append("interrupted; what is there was finished before")
    return report


@dataclass
class _Noted:
    """Runs whose ends are noted: the cycle, -1 where they were cut off."""

    runs: StageRuns
    ended: list[int] = field(default_factory=list)

    @property
    def outcomes(self) -> tuple[str, ...]:
        return self.runs.outcomes

    def play(self, numbers: Sequence[int], seed: int, signals: bool) -> list[Run]:
        found = self.runs.play(numbers, seed, signals)
        self.ended += [run.cycles if run.outcome != UNFINISHED else -1 for run in found]
        return found


def negated(place: str) -> Change:
    """A version of a net in which a math place has the other sign, wherever it is called so: turns the wrong way, say.

    Raises
    ------
    NetError
        When no math place has that name.
    """
    from dataclasses import replace

    from ...architecture.petri import Math

    def change(net: PetriNet) -> PetriNet:
        hits = 0

        def inside(n: PetriNet) -> PetriNet:
            nonlocal hits
            places = []
            for p in n.places:
                if isinstance(p, Math) and p.name == place:
                    hits += 1
                    p = replace(p, expression=f"-({p.expression})")
                places.append(p)
            modules = {k: inside(m) if isinstance(m, PetriNet) else m for k, m in n.modules.items()}
            return replace(n, places=tuple(places), modules=modules)

        made = inside(net)
        if not hits:
            raise NetError(f"net {net.name!r} has no math place {place!r}")
        return made

    return change
