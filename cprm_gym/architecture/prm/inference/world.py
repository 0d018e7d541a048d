"""A world that is watched: objects come and go, relations switch, and the belief is read as numbers.

    world = World(model, {"ball": "Ball", "o1": "Opponent"})
    tracker = world.tracker("exact", batch=64)
    seen = tracker.step({"ball.seen": "yes", "ball.obs_dist": readings}, relations=["attended(o1)"])
    seen.read("ball.dist", "expectation")                  # (64,) metres

Inference can have two grains (dissertation section 2.3.3: frequent simple, occasional deep inference): with ``deep="exact"`` the
tracker answers each step with its own, quicker engine, remembers the readings, and every so often, or when asked
(`Tracker.deepen`), infers them again with the deep one and goes on from its belief.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ....errors import ModelError, ParameterError, did_you_mean
from ..grounding.grounding import Grounding, GroundSlice, GroundVariable, Situation
from .engines.exact import ComponentCost
from .filter import Filter, Result
from .views import View

Relations = Iterable[str | tuple[str, ...]]


class World(Grounding):
    """A model and its objects, ready to be tracked.

    Takes what `Grounding` takes: the model, ``{object: class}``, and references where they are not obvious.
    """

    def tracker(self, engine: Any = "exact", batch: int = 1, **options: Any) -> Tracker:
        """A belief about this world.

        Parameters
        ----------
        engine : {"exact", "projection", "particles", "anytime"}
        batch : int
            W, the number of agents that share the world's relations, each with its own readings.
        **options
            Of `filtering.Filter` and the engine: ``on_impossible``, ``window``, ``seed``, ``memory_limit``, ...
        """
        return Tracker(self, engine, batch, **options)


class Posterior(Mapping[str, np.ndarray]):
    """Posteriors of one slice, a mapping from variable to (W, card) array, and numbers read from them.

    Attributes
    ----------
    result : filtering.Result
    situation : Situation
    milliseconds : float
        Wall-clock time that the step took.
    """

    def __init__(self, result: Result, situation: Situation, milliseconds: float) -> None:
        self.result = result
        self.situation = situation
        self.milliseconds = milliseconds

    def __getitem__(self, name: str) -> np.ndarray:
        return self.result[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.result)

    def __len__(self) -> int:
        return len(self.result)

    @property
    def variables(self) -> Mapping[str, GroundVariable]:
        """The variables of the slice."""
        return self.result.variables

    @property
    def log_likelihood(self) -> np.ndarray:
        """ln P(all readings so far), (W,)."""
        return self.result.log_likelihood

    @property
    def exact(self) -> bool:
        """No step so far has approximated anything."""
        return self.result.exact

    @property
    def loss(self) -> np.ndarray:
        """What a projection threw away in this step, (W,) nats."""
        return self.result.loss

    def read(self, variable: str, view: str | View = "expectation") -> np.ndarray:
        """A number from the belief about one variable, for each agent.

        Parameters
        ----------
        variable : str
        view : str or View
            ``"expectation"``, ``"probability(0..2)"``, ...: see `views`.

        Returns
        -------
        (W,) float array

        Raises
        ------
        ModelError
            For an unknown variable, or a view that it does not have.
        """
        made = View.parse(view) if isinstance(view, str) else view
        return made(self.result[variable], self.result.variables[variable])

    def read_all(self, places: Mapping[str, tuple[str, str | View]]) -> dict[str, np.ndarray]:
        """The numbers for many places, ``{"near": ("ball.dist", "probability(..2)")}``."""
        return {place: self.read(variable, view) for place, (variable, view) in places.items()}

    def joint(self, *names: str) -> np.ndarray:
        """Joint posterior of some variables, (W, card, card, ...)."""
        return self.result.joint(*names)


class Tracker:
    """The belief of W agents about a world whose objects and relations change.

    Parameters
    ----------
    world : Grounding
    engine, batch, **options
        As for `filtering.Filter`.
    deep : {"exact", "projection"}, optional
        Engine of the occasional inference; its belief replaces the one of `engine`, which must be "projection", "anytime" or
        "exact" (particles cannot be replaced by factors).
    every : int
        Steps from one deep inference to the next; as many readings are remembered.

    Attributes
    ----------
    filter : filtering.Filter
    deep : filtering.Filter or None
    situation : Situation or None
        Of the last step.
    """

    def __init__(
        self,
        world: Grounding,
        engine: Any = "exact",
        batch: int = 1,
        *,
        deep: str | None = None,
        every: int = 1000,
        **options: Any,
    ) -> None:
        self.world = world
        self.filter = Filter(world, batch=batch, engine=engine, **options)
        self.situation: Situation | None = None
        self.deep: Filter | None = None
        self.every = every
        self._remembered: list[tuple[dict[str, Any], Any, Situation, Any]] = []
        self._resets: Any = None
        if deep is None:
            return
        if deep not in ("exact", "projection") or engine not in ("exact", "projection", "anytime"):
            raise ParameterError(f"deep inference by {deep!r} cannot take over from engine {engine!r}; see `Tracker`")
        if every < 1:
            raise ParameterError(f"`every` is a number of steps, at least 1, got {every!r}")
        shared = {k: options[k] for k in ("on_impossible", "eps", "window", "memory_limit") if k in options}
        self.deep = Filter(world, batch=batch, engine=deep, **shared)

    def reset(self, agents: Any = None) -> None:
        """Begin anew from the prior: all agents, or only some of them (a mask or indices)."""
        self.filter.reset(agents)
        if self.filter.step_count == 0:
            self.situation = None
            self._remembered.clear()
            self._resets = None
            if self.deep is not None:
                self.deep.reset()
        elif self.deep is not None:
            chosen = np.zeros(self.filter.batch, bool) if self._resets is None else self._resets.copy()
            chosen[agents] = True
            self._resets = chosen

    def step(
        self,
        evidence: Mapping[str, Any] | None = None,
        relations: Relations = (),
        *,
        objects: Iterable[str] | None = None,
        soft: Mapping[str, Any] | None = None,
    ) -> Posterior:
        """Go on by one slice.

        Parameters
        ----------
        evidence : mapping of str to value, optional
            Variable -> state name, index, number, or an array with one value per agent; None or -1 where missing. What is given
            and left out takes its default.
        relations : iterable of str or tuple of str
            In force in this slice, ``"possesses(o3,ball)"``.
        objects : iterable of str, optional
            That exist in this slice; default all. One that was not there before enters with its prior.
        soft : mapping of str to array, optional
            Likelihood vectors.

        Returns
        -------
        Posterior

        Raises
        ------
        EvidenceError
            For a value that is none of its variable, or something given without value and default; the belief is as it was.
        ImpossibleEvidence
            For evidence of probability zero under the policy "raise"; the belief is as it was.
        ModelError
            For unknown or conflicting relations.
        """
        begun = time.perf_counter()
        situation = self.world.situation(relations, objects, self.situation)
        ground = self.world.ground(situation, first=self.filter.step_count == 0)
        readings = self.world.with_defaults(ground, evidence or {})
        result = self.filter.step(readings, soft=soft, relations=situation)
        self.situation = situation
        if self.deep is not None:
            kept = {n: v.copy() if isinstance(v, np.ndarray) else v for n, v in readings.items()}
            likelihoods = {n: np.array(v, dtype=float) for n, v in (soft or {}).items()}
            self._remembered.append((kept, likelihoods, situation, self._resets))
            self._resets = None
            if len(self._remembered) >= self.every:
                return self.deepen()
        return Posterior(result, situation, 1e3 * (time.perf_counter() - begun))

    def deepen(self) -> Posterior:
        """Infer the remembered readings again with the deep engine, and go on from its belief.

        Returns
        -------
        Posterior
            Of the last step, better founded.

        Raises
        ------
        ParameterError
            Without a deep engine, or when no step was made since the last deep inference.
        """
        if self.deep is None or not self._remembered:
            raise ParameterError("nothing to infer deeply: give the tracker a `deep` engine and make a step")
        begun = time.perf_counter()
        for readings, soft, situation, resets in self._remembered:
            if resets is not None:
                self.deep.reset(resets)
            result = self.deep.step(readings, soft=soft, relations=situation)
        self._remembered.clear()
        counted = self.filter.impossible_count
        self.filter.restore(replace(self.deep.snapshot(), engine=None))
        self.filter.impossible_count = counted
        self.filter.exact = self.deep.exact
        return Posterior(result, situation, 1e3 * (time.perf_counter() - begun))

    def predict(self, steps: int = 1, relations: Relations | None = None, given: Mapping[str, Any] | None = None) -> Posterior:
        """The belief some slices ahead; the tracker stays where it is.

        Parameters
        ----------
        steps : int
        relations : iterable, optional
            In force on the way; default those of the last step. Tuples that are new count as new in the first of the steps.
        given : mapping of str to value, optional
            On the way; what is left out takes its default.

        Returns
        -------
        Posterior
        """
        begun = time.perf_counter()
        kept, situation, deep = self.filter.snapshot(), self.situation, self.deep
        self.deep = None
        active: Relations = (situation.relations if situation else ()) if relations is None else tuple(relations)
        live = None if situation is None else situation.objects
        answer = None
        try:
            for _ in range(max(1, steps)):
                answer = self.step(given, active, objects=live)
        finally:
            self.filter.restore(kept)
            self.situation, self.deep = situation, deep
        assert answer is not None
        return Posterior(answer.result, answer.situation, 1e3 * (time.perf_counter() - begun))

    def cost(
        self,
        relations: Relations = (),
        objects: Iterable[str] | None = None,
        evidence: Mapping[str, Any] | None = None,
    ) -> list[ComponentCost]:
        """Bytes, operations and variables of each component of the next step, before it is run.

        Parameters
        ----------
        relations, objects
            As for `step`.
        evidence : mapping of str to value, optional
            What will be observed (the values do not matter); default what was observed in the last step.
        """
        return self.filter.cost(self.world.situation(relations, objects, self.situation), evidence)

    def slice(self) -> GroundSlice:
        """The ground slice of the last step.

        Raises
        ------
        ModelError
            Before the first step.
        """
        if self.situation is None:
            raise ModelError("the tracker has made no step")
        return self.world.ground(self.situation, first=self.filter.step_count == 1)

    def variable(self, name: str) -> GroundVariable:
        """A variable of the last slice, or a `ModelError` with the nearest name."""
        variables = self.slice().variables
        if name not in variables:
            raise ModelError(f"no variable {name!r} in this slice.{did_you_mean(name, variables)}")
        return variables[name]
