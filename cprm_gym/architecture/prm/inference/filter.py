"""The belief of one agent or of many about a world that changes, slice by slice.

    filter = Filter(grounding, batch=1000)
    posterior = filter.step({"ball.obs_dist": readings}, relations=("attended(o3)",))
    posterior["ball.dist"]                              # (1000, 10)
    posterior.read("ball.dist", "expectation")          # (1000,) metres
    posterior.log_likelihood, posterior.exact, posterior.loss    # always reported

A `Filter` remembers a `FilterState`; what it does stands in `filtering.py`.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ....errors import ModelError, ParameterError, did_you_mean
from ..grounding.grounding import Situation
from ..grounding.slices import Grounds
from ..model.domains import Index
from ..model.schema import one_or_many
from . import filtering, smoothing
from .compiled.slice_info import NeedsVariable
from .engines.anytime import AnytimeEngine
from .engines.engine import ComponentCost, Engine
from .engines.exact import ExactEngine
from .engines.mixture import MixtureEngine
from .engines.particles import ParticleEngine
from .engines.projection import ProjectionEngine
from .engines.rao_blackwell import RaoBlackwellEngine
from .filtering import POLICIES, FilterSettings, FilterState
from .forms import Forms, Order
from .posterior import Posterior

ENGINES: dict[str, type[Engine]] = {
    e.name: e for e in (ExactEngine, ProjectionEngine, ParticleEngine, AnytimeEngine, MixtureEngine, RaoBlackwellEngine)
}


SETTLED = 8
"""Sets of relations from which on a filter makes its steps by form, if it can."""


class Filter:
    """The belief of W agents about the same kind of world.

    Parameters
    ----------
    grounding : Grounding, or other Grounds
    batch : int
        W, the number of agents. They share slices and relations; their readings, and what they did not observe, differ.
    engine : {"exact", "projection", "particles", "anytime", "mixture", "rao-blackwell"} or Engine
        Filters over one grounding that are given one object share its plans; not for several threads at once.
    on_impossible : {"raise", "drop", "soften", "restart"}
        What to do for agents whose readings have probability zero: raise `ImpossibleEvidence` and leave every belief as it
        was; ignore a smallest set of conflicting readings (and another one, if the rest still conflicts); take these as true with
        probability ``1 - eps``; begin anew from the prior. An agent's answer does not depend on the others in the batch.
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
        `particles` of a particle filter, `budget_ms` of an anytime engine, `components` of a mixture; see there.

    Attributes
    ----------
    state : FilterState
        May be kept, and put back, or put into a filter with the same settings.
    settings : FilterSettings
    """

    def __init__(
        self,
        grounding: Grounds,
        batch: int = 1,
        engine: str | Engine = "exact",
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
        made = make_engine(engine, seed, memory_limit, options)
        settings = make_settings(grounding, made, on_impossible, eps, window, static)
        self._begin(settings, filtering.begin(settings, int(batch)))

    def _begin(self, settings: FilterSettings, state: FilterState) -> None:
        self.settings = settings
        self._seen: set[tuple[Any, ...]] | None = set() if Forms.applies(settings) else None
        self._forms: Forms | None = None
        self._state, self._asked = state, False
        self._order: Order | None = None

    @classmethod
    def of(cls, settings: FilterSettings, state: FilterState) -> Filter:
        """A filter that goes on from a state."""
        made = cls.__new__(cls)
        made._begin(settings, state)
        return made

    @property
    def state(self) -> FilterState:
        """All that the filter knows, a value."""
        if self._order is not None:
            assert self._forms is not None
            self._state, self._order = self._forms.in_own_names(self._state, self._order), None
        self._asked = True
        return self._state

    @state.setter
    def state(self, state: FilterState) -> None:
        self._state, self._order, self._asked = state, None, False

    @property
    def grounding(self) -> Grounds:
        """What makes the slices."""
        return self.settings.grounding

    @property
    def engine(self) -> Engine:
        """What carries the belief on."""
        return self.settings.engine

    @property
    def batch(self) -> int:
        """W, the number of agents."""
        return self._state.batch

    @property
    def step_count(self) -> int:
        """Number of slices so far."""
        return self._state.step

    @property
    def log_likelihood(self) -> np.ndarray:
        """ln P(readings since the agent began), (W,)."""
        return self._state.log_likelihood

    @property
    def impossible_count(self) -> np.ndarray:
        """How often an agent's readings were impossible, (W,)."""
        return self._state.impossible

    @property
    def exact(self) -> bool:
        """No step has approximated anything."""
        return self._state.exact

    # ------------------------------------------------------------------------------------------------- life

    def reset(self, agents: Any = None) -> None:
        """Begin anew from the prior: the next step is the first slice.

        Parameters
        ----------
        agents : (W,) bool array or indices, optional
            Only these; the others go on. Their next answer is the one of a new filter.
        """
        chosen = np.zeros(self.batch, bool)
        chosen[slice(None) if agents is None else agents] = True
        if chosen.all():
            self.state = filtering.begin(self.settings, self.batch)._replace(impossible=self.state.impossible, late=self.state.late)
        else:
            self.state = filtering.begin_anew(self.state, chosen)

    # ------------------------------------------------------------------------------------------------- steps

    def step(
        self,
        evidence: Mapping[str, Any] | np.ndarray | None = None,
        relations: Any = (),
        *,
        objects: Iterable[str] | None = None,
        soft: Mapping[str, Any] | None = None,
    ) -> Posterior:
        """Go on by one slice.

        Parameters
        ----------
        evidence : dict of name to observation, or (V, W) int array in the order of `variables`
            A state's name, a number (a quantity for bins, the index of a named state) or an `Index`, for all agents or one for each;
            None, NaN or masked where not observed. The array holds state indices, -1 where not observed. What is given
            and left out takes its default.
        relations : iterable of str or tuple of str
            In force in this slice, ``"possesses(o3,ball)"``; which of them are new follows from the step before.
        objects : iterable of str, optional
            That exist in this slice, if the grounding knows objects; default all. One that was not there before enters with its
            prior.
        soft : dict of name to (card,) or (W, card) array
            Likelihood vectors. To demand a posterior instead, see `jeffrey`.

        Returns
        -------
        Posterior

        Raises
        ------
        EvidenceError
            An observation is no value of its variable, or something given has neither value nor default; the belief is as it was.
        ImpossibleEvidence
            The readings have probability zero and the policy is "raise"; the belief is as it was.
        CostError
            A component is too large for exact inference; the belief is as it was.
        ModelError
            For unknown or conflicting relations, and for what are none.
        """
        if self._seen is not None and objects is None and not isinstance(relations, Situation):
            relations = one_or_many(relations, "relations")
            forms = self._forms_of(relations, self._seen)
            made = forms.step(self._state, self._order, evidence, relations, soft) if forms is not None else None
            if made is not None:
                self._state, self._order, posterior = made
                return posterior
        settings, state = self.settings, self.state
        situation = settings.grounding.situation(relations, objects, state.relations if state.step else None)
        info = filtering.slice_info(settings, state, settings.grounding.ground(situation, first=state.step == 0))
        readings = filtering.read(info, state.batch, evidence, soft)
        self.state, posterior = filtering.advance(settings, state, readings, situation, info)
        return posterior

    def _forms_of(self, relations: tuple[Any, ...], seen: set[tuple[Any, ...]]) -> Forms | None:
        """Forms, where there were many sets of relations, and nobody looked at the state since the last step."""
        if len(seen) < SETTLED:
            seen.add(relations)
            return None
        if self._forms is None:
            self._forms = Forms(self.settings)
        return None if self._asked else self._forms

    def predict(self, steps: int = 1, relations: Any = None, given: Mapping[str, Any] | None = None) -> Posterior:
        """The belief some slices ahead, without further readings; the filter stays where it is.

        Parameters
        ----------
        steps : int
            How far, at least 1.
        relations : relations, optional
            In force on the way; by default those of the last step. Tuples that are new count as new in the first of the steps.
        given : dict, optional
            Values of what is given on the way. What is left out takes its default, or without one the value of the last step.
        """
        if steps < 1:
            raise ParameterError(f"`steps` is at least 1, got {steps!r}")
        return filtering.look_ahead(self.settings, self.state, steps, relations, given)

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
        return filtering.jeffrey(self.settings, self.state, targets, relations, given)

    # ------------------------------------------------------------------------------------------------- plans

    def variables(self, relations: Any = ()) -> tuple[str, ...]:
        """Order of the rows of an evidence array for the next step."""
        return filtering.next_slice(self.settings, self.state, relations).names

    def cost(
        self, relations: Any = (), objects: Iterable[str] | None = None, evidence: Mapping[str, Any] | None = None
    ) -> list[ComponentCost]:
        """What the next step would take, for each component, without running it.

        Parameters
        ----------
        relations, objects
            As for `step`.
        evidence : dict, optional
            Names of the variables that will be observed matter, not their values. By default those that were observed in the
            last step.
        """
        settings, state = self.settings, self.state
        info = filtering.next_slice(settings, state, relations, objects)
        for _ in range(1 + 2 * len(info.names)):
            if evidence is not None:
                readings = filtering.read(info, state.batch, evidence, None)
            else:
                readings = filtering.as_in_last_step(state, info)
            try:
                return settings.engine.cost(state.belief, info, readings)
            except NeedsVariable as need:
                state = filtering.made_again(settings, state, need)
                info = filtering.slice_info(settings, state, info.slice)
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
        settings, engine = self.settings, self.engine
        if not self.state.history:
            raise ParameterError("make a step first: what is observed is taken from the last one")
        compiled = engine.compiled
        for path in paths:
            state = self.state
            for relations in path:
                situation = settings.grounding.situation(relations, None, state.relations)
                info = filtering.slice_info(settings, state, settings.grounding.ground(situation, first=False))
                readings = filtering.as_in_last_step(state, info)
                try:
                    belief = engine.prepare(state.belief, info, readings)
                except NeedsVariable as need:
                    engine.note(need.kind)
                    break
                state = state._replace(belief=belief, step=state.step + 1, relations=situation, info=info)
        return engine.compiled - compiled

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
        belief, loss = self.engine.project(self.state.belief, clusters)
        if belief is not self.state.belief:
            self.state = self.state._replace(belief=belief, exact=False)
        return loss

    # ------------------------------------------------------------------------------------------------- the window

    def smooth(self) -> list[smoothing.Smoothed]:
        """Posteriors of the slices of the window given all their readings, the oldest slice first.

        The window never reaches back over a step in which some agents began anew while others went on.

        Returns
        -------
        list of mapping of name to (W, card) array
        """
        return self.engine.smooth(self._window("smooth"))

    def most_probable_path(self) -> list[dict[str, Index]]:
        """The most probable joint values of all declared variables of the window, the oldest slice first.

        Slices before the window, and aggregates and selectors, which nobody declared, are summed out.

        Returns
        -------
        list of dict of name to Index of a (W,) int array
            Evidence as `step` takes it.
        """
        return self.engine.most_probable_path(self._window("most_probable_path"))

    def expected_counts(self) -> dict[Any, np.ndarray]:
        """Expected number of times each row and state of each class-level CPD occurred in the window, all agents together.

        Returns
        -------
        dict of CPD key to array
            Shape of the CPD's table, parents first, child last.
        """
        return self.engine.expected_counts(self._window("expected_counts"))

    def sample(self, count: int, seed: Any = None) -> dict[str, np.ndarray]:
        """Joint samples of the hidden variables from the belief.

        Returns
        -------
        dict of name to (W, count) int array
        """
        if not self.state.step:
            raise ParameterError("nothing to sample from: the filter has made no step")
        return self.engine.sample(self.state.belief, count, np.random.default_rng(seed))

    def _window(self, what: str) -> list[smoothing.Slice]:
        if not self.settings.window:
            raise ParameterError(f"`{what}` needs a filter with `window` of at least 1")
        window = filtering.window_of(self.state)
        if not window:
            raise ParameterError(f"`{what}` needs a step in which all agents went on")
        return window


def make_settings(
    grounding: Grounds, engine: Engine, on_impossible: str = "raise", eps: float = 1e-6, window: int = 0, static: Iterable[str] = ()
) -> FilterSettings:
    """Settings, checked.

    Raises
    ------
    ParameterError
    """
    if on_impossible not in POLICIES:
        hint = did_you_mean(str(on_impossible), POLICIES)
        raise ParameterError(f"`on_impossible` is one of {', '.join(POLICIES)}, got {on_impossible!r}.{hint}")
    if not 0.0 < eps < 1.0:
        raise ParameterError(f"`eps` is a probability between 0 and 1, got {eps!r}")
    if not engine.continuous:
        grounding = grounding.binned()
    return FilterSettings(grounding, engine, on_impossible, eps, window, frozenset(grounding.static) | frozenset(one_or_many(static)))


def make_engine(engine: str | Engine, seed: Any = None, memory_limit: float = 2.0**31, options: Mapping[str, Any] | None = None) -> Engine:
    """An engine from its name.

    Raises
    ------
    ParameterError
        For an unknown name, or an option that the engine does not have.
    """
    if isinstance(engine, Engine):
        return engine
    if engine not in ENGINES:
        raise ParameterError(f"unknown engine {engine!r}.{did_you_mean(str(engine), ENGINES)} Known: {', '.join(ENGINES)}")
    known = inspect.signature(ENGINES[engine]).parameters
    for name in options or ():
        if name not in known:
            raise ParameterError(f"engine {engine!r} has no option {name!r}.{did_you_mean(name, known)} Known: {', '.join(known)}")
    given = {"seed": seed, "memory_limit": memory_limit}
    return ENGINES[engine](**{k: v for k, v in given.items() if k in known}, **(options or {}))
