"""Filtering a dynamic relational model: the belief of one agent or of many, slice by slice.

    filter = Filter(grounding, batch=1000)
    result = filter.step({"ball.obs_dist": readings}, relations=("attended(o3)",))
    result["ball.dist"]                                 # (1000, 10) posterior
    result.log_likelihood, result.exact, result.loss    # always reported

The relations in force are fixed before a slice is predicted. They may be any function of what happened before (a Petri net
decides them): they are context and contribute nothing to the likelihood. The answer is that of the unrolled,
non-homogeneous net. Readings that have a probability below some 1e-300 in one component of one step count as impossible; give
CPDs a floor, as integrated ones have.

References
----------
Dissertation sections 2.3.3 and 2.3.4; Murphy, Dynamic Bayesian Networks, 2002.
"""

from __future__ import annotations

import inspect
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from ....errors import EvidenceError, ImpossibleEvidence, ModelError, ParameterError, did_you_mean
from ..grounding.grounding import Grounding, Situation
from ..grounding.slices import STATIC, GroundSlice, GroundVariable
from ..model.domains import Index
from . import smoothing
from .compiled.steps import NeedsVariable, SliceInfo
from .engines.anytime import AnytimeEngine
from .engines.conflicts import explain, soften
from .engines.exact import ComponentCost, ExactEngine, FactoredBelief, Outcome
from .engines.merging import replace_agents
from .engines.particles import ParticleEngine
from .engines.projection import ProjectionEngine, given_clusters, project
from .evidence import UNOBSERVED, Readings, read_hard, read_soft
from .posterior import Past, Result, Snapshot

__all__ = ["POLICIES", "Filter", "Grounds", "Past", "Result", "Snapshot"]

POLICIES = ("raise", "drop", "soften", "restart")


class Grounds(Protocol):
    """Anything that makes slices: a `Grounding`, or a schedule of slices made by hand."""

    def ground(self, relations: Any = (), first: bool = False) -> GroundSlice:
        """The slice for the active relations; the same object for the same arguments."""


class Filter:
    """The belief of W agents about the same kind of world.

    Parameters
    ----------
    grounding : Grounding, or anything with ``ground(relations, first) -> GroundSlice``
    batch : int
        W, the number of agents. They share slices and relations; their readings, and what they did not observe, differ.
    engine : {"exact", "projection", "particles", "anytime"} or engine object
        Filters over one grounding that are given one object share its plans; not for several threads at once.
    on_impossible : {"raise", "drop", "soften", "restart"}
        What to do for agents whose readings have probability zero: raise `ImpossibleEvidence` and leave every belief as it
        was; ignore the conflicting readings; take them as true with probability ``1 - eps``; begin anew from the prior.
    eps : float
        For "soften".
    window : int
        How many past slices are remembered for `smooth` and `most_probable_path`.
    seed : int, SeedSequence or Generator
        For engines that sample.
    memory_limit : float
        Bytes that one component of an exact step may take before it is refused.
    static : iterable of str
        Static variables, drawn in the slice that defines them and never again. Only needed where neither the grounding nor
        the first two slices tell.
    **options
        Further options of the engine: `threads` of an exact or projecting one, `max_flops` and `clusters` of a projecting one,
        `particles` of a particle filter, `budget_ms` of an anytime engine; see there.
    """

    def __init__(
        self,
        grounding: Grounds,
        batch: int = 1,
        engine: Any = "exact",
        *,
        on_impossible: str = "raise",
        eps: float = 1e-6,
        window: int = 0,
        seed: Any = None,
        memory_limit: float = 2.0**31,
        static: Iterable[str] = (),
        **options: Any,
    ) -> None:
        if not isinstance(batch, (int, np.integer)) or batch < 1:
            raise ParameterError(f"`batch` is the number of agents, at least 1, got {batch!r}")
        if on_impossible not in POLICIES:
            hint = did_you_mean(str(on_impossible), POLICIES)
            raise ParameterError(f"`on_impossible` is one of {', '.join(POLICIES)}, got {on_impossible!r}.{hint}")
        if not 0.0 < eps < 1.0:
            raise ParameterError(f"`eps` is a probability between 0 and 1, got {eps!r}")
        self.grounding = grounding
        self.batch = int(batch)
        self.engine = make_engine(engine, seed, memory_limit, options)
        self.on_impossible, self.eps = on_impossible, eps
        self._static = frozenset(getattr(grounding, "static", ())) | frozenset(static)
        self._infos = self.engine.store.infos
        self._history: deque[Past] = deque(maxlen=max(window, 1))
        self.window = window
        self.impossible_count = np.zeros(self.batch, np.int64)
        self.reset()

    # ------------------------------------------------------------------------------------------------- life

    def reset(self, agents: Any = None) -> None:
        """Begin anew from the prior: the next step is the first slice.

        Parameters
        ----------
        agents : (W,) bool array or indices, optional
            Only these; the others go on. Their next answer is the one of a new filter.
        """
        if agents is None:
            self.belief = self.engine.start(self.batch)
            self.step_count = 0
            self.log_likelihood = np.zeros(self.batch)
            self._fresh = np.zeros(self.batch, bool)
            self._history.clear()
            self._relations: Any = ()
            self._atemporal: dict[str, GroundVariable] = {}
            self._owners: frozenset[str] = frozenset()
            self.exact = True
            return
        chosen = np.zeros(self.batch, bool)
        chosen[agents] = True
        if chosen.all():
            self.reset()
            return
        self._fresh |= chosen
        self.log_likelihood = np.where(chosen, 0.0, self.log_likelihood)
        if self.step_count == 0:
            self._fresh[:] = False

    def snapshot(self) -> Snapshot:
        """The state of the filter. Cheap: beliefs are never changed in place."""
        return Snapshot(
            self.belief,
            self.step_count,
            self.log_likelihood.copy(),
            self._fresh.copy(),
            tuple(self._history),
            self._relations,
            self.impossible_count.copy(),
            self.exact,
            self._atemporal,
            self._owners,
            self.engine.snapshot() if hasattr(self.engine, "snapshot") else None,
        )

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to a snapshot of this filter, or of one with other agents."""
        self.batch = len(snapshot.log_likelihood)
        self.belief, self.step_count = snapshot.belief, snapshot.step
        self.log_likelihood, self._fresh = snapshot.log_likelihood.copy(), snapshot.fresh.copy()
        self._history.clear()
        self._history.extend(snapshot.history)
        self._relations, self.impossible_count = snapshot.relations, snapshot.impossible.copy()
        self.exact, self._atemporal, self._owners = snapshot.exact, snapshot.static, snapshot.owners
        if snapshot.engine is not None:
            self.engine.restore(snapshot.engine)

    # ------------------------------------------------------------------------------------------------- steps

    def step(
        self,
        evidence: Mapping[str, Any] | np.ndarray | None = None,
        soft: Mapping[str, Any] | None = None,
        relations: Any = (),
        objects: Iterable[str] | None = None,
    ) -> Result:
        """Go on by one slice.

        Parameters
        ----------
        evidence : dict of name to observation, or (V, W) int array in the order of `variables`
            State index, state name or number for all agents, or one for each; -1 or None where not observed.
        soft : dict of name to (card,) or (W, card) array
            Likelihood vectors. To demand a posterior instead, see `jeffrey`.
        relations : relations in force, or a GroundSlice
            Handed to ``grounding.ground``; which of them are new follows from the step before.
        objects : iterable of str, optional
            The objects that exist in this slice, if the grounding knows objects; default all.

        Returns
        -------
        Result

        Raises
        ------
        EvidenceError
            An observation is no value of its variable; the belief is as it was.
        ImpossibleEvidence
            The readings have probability zero and the policy is "raise"; the belief is as it was.
        CostError
            A component is too large for exact inference; the belief is as it was.
        """
        relations = self._situation(relations, objects)
        info = self._info(self._ground(relations, self.step_count == 0))
        readings = self._read(info, evidence, soft)
        outcome, before, info = self._advance(info, readings)
        impossible = np.zeros(self.batch, bool)
        if self._fresh.any():
            outcome = self._begin_anew(outcome, readings, self._fresh, relations)
        if outcome.impossible.any():
            impossible = outcome.impossible.copy()
            outcome = self._impossible(outcome, before, info, readings, relations)
        fresh = self._fresh | impossible if self.on_impossible == "restart" else self._fresh
        self._commit(outcome, Past(before, info, outcome.readings, fresh, relations), relations)
        self.impossible_count += impossible
        return Result(outcome, self.step_count - 1, self.log_likelihood.copy(), self.exact, impossible)

    def predict(self, steps: int = 1, relations: Any = None, given: Mapping[str, Any] | None = None) -> Result:
        """The belief some slices ahead, without further readings; the filter stays where it is.

        Parameters
        ----------
        steps : int
            How far, at least 1.
        relations : relations, optional
            In force on the way; by default those of the last step.
        given : dict, optional
            Values of what is given on the way; by default those of the last step.
        """
        if steps < 1:
            raise ParameterError(f"`steps` is at least 1, got {steps!r}")
        return self._ahead(steps, relations, given, {})

    def _ahead(self, steps: int, asked: Any, given: Mapping[str, Any] | None, soft: Mapping[str, Any]) -> Result:
        """Predict, with likelihood vectors in the last of the slices."""
        kept = self.snapshot()
        given = dict(given or {})
        relations, objects = self._relations if asked is None else asked, None
        if isinstance(self._relations, Situation):  # what was new in the last step is not new again
            objects = self._relations.objects
            relations = self._relations.relations if asked is None else asked
        try:
            for left in reversed(range(steps)):
                situation = self._situation(relations, objects)
                ground = self._ground(situation, self.step_count == 0)
                last = self._history[-1] if self._history else None
                known = dict(given)
                for name in ground.given:
                    if name not in known and last is not None and name in last.info.row:
                        known[name] = Index(last.readings.hard[last.info.row[name]])
                result = self.step(known, soft if left == 0 else None, relations=situation)
        finally:
            self.restore(kept)
        return result

    def variables(self, relations: Any = ()) -> tuple[str, ...]:
        """Order of the rows of an evidence array for the next step."""
        return self._info(self._ground(self._situation(relations, None), self.step_count == 0)).names

    def cost(self, relations: Any = (), evidence: Mapping[str, Any] | None = None) -> list[ComponentCost]:
        """What the next step would take, for each component, without running it.

        Parameters
        ----------
        relations : relations
        evidence : dict, optional
            Names of the variables that will be observed matter, not their values. By default those that were observed in the
            last step.
        """
        if not hasattr(self.engine, "cost"):
            raise ParameterError(f"engine {self.engine.name!r} has no plans whose cost could be told")
        info = self._info(self._ground(self._situation(relations, None), self.step_count == 0))
        if evidence is not None:
            readings = self._read(info, evidence, None, checked=False)
        else:
            readings = self._as_in_last_step(info)
        before = self.belief
        for _ in range(1 + 2 * len(info.names)):
            try:
                slice_step = self.engine.slice_step(before, info, readings)
            except NeedsVariable as need:
                before, info = self._again_with(need, info)
                readings = readings.extended(len(info.names))
                continue
            found: list[ComponentCost] = self.engine.cost(slice_step, self.batch)
            return found
        raise ModelError("the belief cannot be kept in a form that the next slice needs")

    def prepare(self, *paths: Sequence[Any]) -> int:
        """Make the plans of steps to come, so that they need not be made in time.

        Parameters
        ----------
        *paths : sequences of relations
            Each a possible future from here, one entry for each slice; the same variables are observed as in the last step.

        Returns
        -------
        int
            How many plans were new.
        """
        engine = getattr(self.engine, "factored", self.engine)
        if not isinstance(engine, ExactEngine) or not isinstance(self.belief, FactoredBelief):
            raise ParameterError(f"engine {self.engine.name!r} has no plans to prepare")
        if not self._history:
            raise ParameterError("make a step first: what is observed is taken from the last one")
        compiled, kept = engine.compiler.compiled, (self._relations, self.step_count)
        try:
            for path in paths:
                self._relations, self.step_count = kept
                belief = self.belief
                for relations in path:
                    self._relations = self._situation(relations, None)
                    info = self._info(self._ground(self._relations, self.step_count == 0))
                    readings = self._as_in_last_step(info)
                    try:
                        made = engine.slice_step(belief, info, readings)
                    except NeedsVariable as need:
                        self.engine.note(need.kind)
                        break
                    belief = FactoredBelief(made.layout, (), readings.hard)
                    self.step_count += 1
        finally:
            self._relations, self.step_count = kept
        return engine.compiler.compiled - compiled

    def jeffrey(self, targets: Mapping[str, Any], relations: Any = None, given: Mapping[str, Any] | None = None) -> dict[str, np.ndarray]:
        """Likelihood vectors that turn the predicted marginals into the given ones, one variable after the other.

        Parameters
        ----------
        targets : dict of name to (card,) or (W, card) array
            Distributions that the posterior of each variable is to have (Jeffrey's rule).
        relations, given
            Of the next step, as for `predict`.

        Returns
        -------
        dict of str to (W, card) array
            To be given as `soft`. The last variable gets its target exactly; those before it are moved again where they depend
            on it, so the order matters.
        """
        found: dict[str, np.ndarray] = {}
        for name, target in targets.items():
            predicted = self._ahead(1, relations, given, found)
            q = np.broadcast_to(np.asarray(target, dtype=np.float64), predicted[name].shape)
            if (q < 0).any() or not np.allclose(q.sum(axis=1), 1.0, atol=1e-9):
                raise EvidenceError(f"jeffrey: {name!r} needs a distribution, got {q.tolist()}")
            if ((predicted[name] <= 0) & (q > 0)).any():
                raise ImpossibleEvidence(f"jeffrey: {name!r} is to take a state that the belief excludes")
            found[name] = np.divide(q, predicted[name], out=np.zeros(q.shape), where=predicted[name] > 0)
        return found

    def project(self, clusters: Sequence[Sequence[str]]) -> np.ndarray:
        """Replace the belief by the product of its clusters' marginals, now.

        Parameters
        ----------
        clusters : sequence of sequences of str
            Disjoint. Variables that are in none, but depend on some that are, become clusters of their own.

        Returns
        -------
        (W,) float array
            The loss: Kullback-Leibler divergence from the belief to the product, nats; 0 where nothing depended.
        """
        if not isinstance(self.belief, FactoredBelief):
            raise ParameterError(f"`project` needs a belief of factors; the engine {self.engine.name!r} keeps particles")
        known = {name for name, _ in self.belief.layout.variables()}
        for name in (n for c in clusters for n in c):
            if name not in known:
                raise ModelError(f"`project`: {name!r} is not a hidden variable of the belief.{did_you_mean(name, known)}")
        chosen = given_clusters(self.belief, clusters)
        if not chosen:
            return np.zeros(self.batch)
        self.belief, loss = project(getattr(self.engine, "factored", self.engine), self.belief, chosen)
        self.exact = False
        return loss

    # ------------------------------------------------------------------------------------------------- the window

    def smooth(self) -> list[smoothing.Smoothed]:
        """Posteriors of the slices of the window given all their readings, the oldest slice first.

        The window never reaches back over a step in which some agents began anew while others went on.

        Returns
        -------
        list of mapping of name to (W, card) array
        """
        self._need_window("smooth")
        return smoothing.smooth(self._window(), self.batch)

    def most_probable_path(self) -> list[dict[str, np.ndarray]]:
        """The most probable joint values of all variables of the window, the oldest slice first.

        Returns
        -------
        list of dict of name to (W,) int array
        """
        self._need_window("most_probable_path")
        return smoothing.most_probable_path(self._window(), self.batch)

    def expected_counts(self) -> dict[Any, np.ndarray]:
        """Expected number of times each row and state of each class-level CPD occurred in the window, all agents together.

        Returns
        -------
        dict of CPD key to array
            Shape of the CPD's table, parents first, child last.
        """
        self._need_window("expected_counts")
        return smoothing.expected_counts(self._window(), self.batch)

    def sample(self, count: int, seed: Any = None) -> dict[str, np.ndarray]:
        """Joint samples of the hidden variables from the belief.

        Returns
        -------
        dict of name to (W, count) int array
        """
        if not self._history:
            raise ParameterError("nothing to sample from: the filter has made no step")
        if not isinstance(self.belief, FactoredBelief):
            raise ParameterError("the belief is samples already: particles are in `filter.belief`")
        return smoothing.sample_belief(self.belief, self.batch, count, np.random.default_rng(seed))

    def _need_window(self, what: str) -> None:
        if not self.window:
            raise ParameterError(f"`{what}` needs a filter with `window` of at least 1")
        if not all(isinstance(past.before, FactoredBelief) for past in self._history):
            raise ParameterError(f"`{what}` needs a belief of factors; the engine {self.engine.name!r} kept particles")
        if not self._window():
            raise ParameterError(f"`{what}` needs a step in which all agents went on")

    def _window(self) -> list[smoothing.Slice]:
        """The slices of the window since the last step in which only some agents began anew."""
        slices: list[smoothing.Slice] = []
        for past in self._history:
            if past.fresh.any():
                slices.clear()
            else:
                slices.append(smoothing.Slice(past.before, past.info, past.readings))
        return slices

    # ------------------------------------------------------------------------------------------------- inside

    def _situation(self, relations: Any, objects: Iterable[str] | None) -> Any:
        """The relations with the objects, and which of both are new since the step before, if the grounding knows such things."""
        if isinstance(relations, (GroundSlice, Situation)) or not isinstance(self.grounding, Grounding):
            return relations
        before = self._relations if self.step_count and isinstance(self._relations, Situation) else None
        return self.grounding.situation(relations, objects, before)

    def _ground(self, relations: Any, first: bool) -> GroundSlice:
        return relations if isinstance(relations, GroundSlice) else self.grounding.ground(relations, first=first)

    def _info(self, ground: GroundSlice) -> SliceInfo:
        """The slice as the compiler sees it."""
        if self.step_count and not self._static and not self._atemporal:
            return self.slice_info(ground)
        static = self._static
        if self.step_count == 0:
            static = static | {p for cpd in ground.cpds for p, lag in cpd.parents if lag == STATIC}
        fixed = {n: ground.variables[n] for n in sorted(static & ground.variables.keys())}
        owners = {v.object_name for v in ground.variables.values()}
        for name, variable in self._atemporal.items():
            gone = bool(variable.object_name) and variable.object_name in self._owners and variable.object_name not in owners
            if name not in ground.variables and not gone:
                fixed[name] = variable
        return self._infos.fetch((ground, frozenset(fixed)), lambda: self._new_info(ground, fixed))

    def slice_info(self, ground: GroundSlice) -> SliceInfo:
        """A slice without static variables as the compiler sees it."""
        return self._infos.fetch((ground, frozenset()), lambda: self._new_info(ground, {}))

    def foresee(self, *situations: Sequence[Any]) -> None:
        """Keep, from the first slice on, the variables that slices with these relations need of the slice before them.

        Parameters
        ----------
        *situations : sequences of relations
            Each may hold in some later slice; the empty one always may.
        """
        for relations in ((), *situations):
            self.slice_info(self._ground(self._situation(relations, None), False))

    def _new_info(self, ground: GroundSlice, fixed: dict[str, GroundVariable]) -> SliceInfo:
        """A slice, indexed; the engine learns which variables have links in time."""
        info = SliceInfo(ground, fixed, self.engine.store)
        self.engine.learn(info)
        return info

    def _read(self, info: SliceInfo, evidence: Any, soft: Any, checked: bool = True) -> Readings:
        if checked and info.given.any() and isinstance(self.grounding, Grounding) and not isinstance(evidence, np.ndarray):
            evidence = self.grounding.with_defaults(info.slice, evidence or {})
        hard = read_hard(info.variables, info.names, info.cards, info.row, evidence, self.batch)
        if info.given.any():
            missing = info.given & (hard < 0).any(axis=1)
            if missing.any() and checked:
                names = [info.names[i] for i in np.flatnonzero(missing)]
                raise EvidenceError(f"{', '.join(map(repr, names))} must be given for every agent in every slice")
            hard[missing] = np.maximum(hard[missing], 0)
        for name in soft or ():
            if name in info.slice.given:
                raise EvidenceError(f"soft evidence for {name!r}: it is given, not inferred")
        return Readings(hard, read_soft(info.variables, soft, self.batch) if soft else {})

    def _advance(self, info: SliceInfo, readings: Readings) -> tuple[Any, Any, SliceInfo]:
        """One step of the engine. If it needs a variable that was summed out, the last step is done again with it kept."""
        before = self.belief
        for _ in range(1 + 2 * len(info.names)):
            try:
                return self.engine.advance(before, info, readings), before, info
            except NeedsVariable as need:
                before, info = self._again_with(need, info)
                readings = readings.extended(len(info.names))
        raise ModelError("the belief cannot be kept in a form that the next slice needs")

    def _again_with(self, need: NeedsVariable, info: SliceInfo) -> tuple[Any, SliceInfo]:
        """Do the last step again with a variable kept: the belief after it, and the slice that needs it."""
        if not self._history:
            raise ModelError(f"{need.name!r} of the previous slice is needed, but there is none") from None
        self._keep(need)
        past = self._history[-1]
        again = past._replace(info=self._info(past.info.slice))
        outcome = self.engine.advance(past.before, again.info, past.readings)
        if past.fresh.any():
            outcome = self._begin_anew(outcome, past.readings, past.fresh, past.relations)
        self._history[-1] = again
        return outcome.belief, self._info(info.slice)

    def _keep(self, need: NeedsVariable) -> None:
        """Keep a kind of variable in the belief from now on."""
        if not need.static:
            self.engine.note(need.kind)
            return
        if self.step_count != 1 or not self._history:
            raise ModelError(f"static variable {need.name!r} is used for the first time in slice {self.step_count}; name it in `static`")
        self._static |= {need.name}
        self._atemporal = {**self._atemporal, need.name: self._history[-1].info.variables[need.name]}

    def _as_in_last_step(self, info: SliceInfo) -> Readings:
        """The variables of a slice that are observed, if the same are as in the last step; the values do not matter."""
        hard = np.full((len(info.names), self.batch), UNOBSERVED, np.int64)
        hard[info.given] = 0
        if self._history:
            last = self._history[-1]
            for name, row in info.row.items():
                if name in last.info.row:
                    hard[row] = np.minimum(last.readings.hard[last.info.row[name]], info.cards[row] - 1)
        return Readings(hard, {})

    def _commit(self, outcome: Any, past: Past, relations: Any) -> None:
        self.belief = outcome.belief
        self.log_likelihood = self.log_likelihood + outcome.increment
        self.step_count += 1
        self.exact = self.exact and outcome.exact_step
        self._atemporal, self._owners = outcome.info.static_variables, outcome.info.owners
        self._fresh = np.zeros(self.batch, bool)
        self._relations = relations
        self._history.append(past)

    def _first_info(self, relations: Any) -> SliceInfo:
        """The first slice, for agents that begin anew."""
        ground = self._ground(relations, True)
        fixed = {n: ground.variables[n] for n in sorted(self._static & ground.variables.keys())}
        return self._infos.fetch((ground, frozenset(fixed)), lambda: self._new_info(ground, fixed))

    def _begin_anew(self, outcome: Any, readings: Readings, agents: np.ndarray, relations: Any, forgive: bool = False) -> Any:
        """Replace the answer for some agents by that of a first slice."""
        relations = replace(relations, entering=()) if isinstance(relations, Situation) else relations
        first = self._first_info(relations)
        if set(first.names) != set(outcome.info.names):
            odd = sorted(set(first.names) ^ set(outcome.info.names))
            raise ModelError(
                f"some agents begin anew while others go on, but the first slice differs in its variables: {', '.join(odd[:5])}"
            )
        order = [outcome.info.row[name] for name in first.names]
        chosen = np.flatnonzero(agents)
        part = Readings(readings.hard[order][:, chosen], {n: s[chosen] for n, s in readings.soft.items()})
        if isinstance(outcome, Outcome):
            return replace_agents(getattr(self.engine, "factored", self.engine), outcome, first, part, chosen, order)
        sampler = getattr(self.engine, "sampled", self.engine)
        return sampler.replace_agents(outcome, first, part, chosen, outcome.status[order], forgive)

    def _impossible(self, outcome: Any, before: Any, info: SliceInfo, readings: Readings, relations: Any) -> Any:
        """Apply the policy for readings of probability zero."""
        agents = np.flatnonzero(outcome.impossible)
        if self.on_impossible == "raise":
            raise explain(getattr(self.engine, "factored", self.engine), before, info, readings, outcome, agents, self.step_count)
        anew = self._fresh | (outcome.impossible if self.on_impossible == "restart" else False)
        if not isinstance(outcome, Outcome):
            return self._forgiven(outcome, before, info, readings, anew, relations)
        if self.on_impossible == "restart":
            again = self._begin_anew(outcome, readings, outcome.impossible, relations)
            if not again.impossible.any():
                return again
        changed, again = readings, outcome
        for extent in ("readings", "components", "everything"):
            for _ in range(len(info.names)):
                bad = np.flatnonzero(again.impossible)
                eps = self.eps if self.on_impossible == "soften" else None
                softer = soften(again, info, changed, bad, eps, extent)
                if softer is None:
                    break
                changed, again = softer, self.engine.advance(before, info, softer)
                if not isinstance(again, Outcome):
                    return self._forgiven(again, before, info, changed, anew, relations)
                if anew.any():
                    again = self._begin_anew(again, changed, anew, relations)
                if not again.impossible.any():
                    return again
        raise explain(getattr(self.engine, "factored", self.engine), before, info, readings, outcome, agents, self.step_count)

    def _forgiven(self, outcome: Any, before: Any, info: SliceInfo, readings: Readings, anew: np.ndarray, relations: Any) -> Any:
        """Particles that keep their weights where none of them fits the readings."""
        bad = np.flatnonzero(outcome.impossible)
        forgiven = self.engine.advance(before, info, readings, forgive=bad) if len(bad) else outcome
        return self._begin_anew(forgiven, readings, anew, relations, forgive=True) if anew.any() else forgiven


def make_engine(engine: Any, seed: Any, memory_limit: float, options: dict[str, Any]) -> Any:
    """An engine from its name.

    Raises
    ------
    ParameterError
        For an unknown name, or an option that the engine does not have.
    """
    if not isinstance(engine, str):
        return engine
    kinds: dict[str, Any] = {
        "exact": ExactEngine,
        "projection": ProjectionEngine,
        "particles": ParticleEngine,
        "anytime": AnytimeEngine,
    }
    if engine not in kinds:
        raise ParameterError(f"unknown engine {engine!r}.{did_you_mean(engine, kinds)} Known: {', '.join(kinds)}")
    known = inspect.signature(kinds[engine]).parameters
    for name in options:
        if name not in known:
            raise ParameterError(f"engine {engine!r} has no option {name!r}.{did_you_mean(name, known)} Known: {', '.join(known)}")
    given = {"seed": seed, "memory_limit": memory_limit}
    return kinds[engine](**{k: v for k, v in given.items() if k in known}, **options)
