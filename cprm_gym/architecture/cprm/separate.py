"""Beliefs of agents kept one by one, for CPRMs that say what a `FilterBank` does not take.

These are objects that enter and leave, soft evidence, events over several variables, variables of relations, selectors of mixtures, and
occasional deep inference. It costs a filter's step for each agent instead of one for all that are in like situations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...errors import ModelError
from ..prm.grounding.grounding import Grounding
from ..prm.grounding.slices import GroundSlice
from ..prm.inference.deep_filter import DeepFilter
from ..prm.inference.filter import Filter
from ..prm.inference.filtering import begin
from ..prm.inference.posterior import Posterior
from ..prm.inference.views import View, probability_weights
from ..prm.model.domains import Index
from ..prm.model.schema import parse_tuple
from .value import CPRM, SELECTOR, Event, Observe


class Holding(NamedTuple):
    """Whom an agent means: the object in each object place, the relation tuple of each cluster, the same by name; None for nobody."""

    objects: Mapping[str, str | None]
    clusters: tuple[str | None, ...]
    tuples: Mapping[str, str | None]

    def variable(self, text: str) -> str | None:
        """The variable of the model that a link means for this agent."""
        owner, _, attribute = text.partition(".")
        for known in (self.objects, self.tuples):
            if owner in known:
                return None if known[owner] is None else f"{known[owner]}.{attribute}"
        return text


class Told(NamedTuple):
    """What an agent perceives of one observation: a number, or a likelihood for each state; None where it is not observed."""

    link: Observe
    value: float | None
    likelihood: np.ndarray | None


class Perceived(NamedTuple):
    """What a batch of agents perceives in a cycle."""

    told: Sequence[tuple[Observe, np.ndarray, np.ndarray]]
    """Each observation: (n, W) values, and (W,) whether it is made."""
    held: Mapping[str, np.ndarray]
    """Object place -> (W,) index of whom it holds."""
    present: Mapping[str, np.ndarray]
    """Object -> (W,) whether it exists."""


class SeparateBeliefs:
    """The beliefs of a batch of agents, each in a filter of its own.

    Parameters
    ----------
    cprm : CPRM
    grounding : Grounding
    filters : sequence of Filter
        One for each agent.
    """

    def __init__(self, cprm: CPRM, grounding: Grounding, filters: Sequence[Filter]) -> None:
        self.cprm, self.grounding, self.filters = cprm, grounding, filters
        self.answers: list[Posterior | None] = [None] * len(filters)
        """The posterior of each agent's last step; None before the first."""
        self._events = {e.name: e for e in cprm.events}

    def reset(self, mask: np.ndarray) -> None:
        """Let agents begin anew from the prior."""
        for k in np.flatnonzero(mask).tolist():
            self.filters[k].reset()
            self.answers[k] = None

    def alike(self) -> SeparateBeliefs:
        """Other beliefs of the same agents, at their beginning and without deep inference."""
        filters = [Filter.of(one.settings, begin(one.settings, 1)) for one in self.filters]
        return SeparateBeliefs(self.cprm, self.grounding, filters)

    def take(self, other: SeparateBeliefs, agents: np.ndarray) -> None:
        """Give agents, a (W,) bool array, what they believe in the other."""
        for k in np.flatnonzero(agents).tolist():
            self.filters[k].state, self.answers[k] = other.filters[k].state, other.answers[k]

    def step(self, agent: int, told: Sequence[Told], holding: Holding, objects: Sequence[str] | None, blind: bool = False) -> None:
        """Go on by one slice with one agent.

        Parameters
        ----------
        agent : int
        told : sequence of Told
            What is no variable of the slice (of an object that does not exist, a relation that does not hold) is left out.
        holding : Holding
        objects : sequence of str, optional
            That exist in this slice; default all.
        blind : bool
            Nothing is observed; what is given is.
        """
        one = self.filters[agent]
        there = set(self.grounding.objects if objects is None else objects)
        tuples = tuple(dict.fromkeys(t for t in holding.clusters if t is not None and set(parse_tuple(t)[1]) <= there))
        first = one.state.step == 0
        situation = self.grounding.situation(tuples, objects, None if first else one.state.relations)
        evidence, soft = self._readings(told, holding, self.grounding.ground(situation, first=first), blind)
        self.answers[agent] = one.step(evidence, tuples, objects=objects, soft=soft)

    def _readings(self, told: Sequence[Told], holding: Holding, ground: GroundSlice, blind: bool) -> tuple[dict[str, Any], dict[str, Any]]:
        evidence: dict[str, Any] = {}
        soft: dict[str, Any] = {}
        for link, value, likelihood in told:
            name = holding.variable(link.variable)
            if name is None or name not in ground.variables or (value is None and likelihood is None):
                continue
            if blind and name not in ground.given:
                continue
            if likelihood is not None:
                soft[name] = likelihood
            elif name.endswith(f".{SELECTOR}") and not ground.variables[name].class_name:
                chosen = self._cluster(link, value, holding)
                if chosen in ground.variables[name].states:
                    evidence[name] = chosen
            elif ground.variables[name].edges is None and ground.variables[name].quantity is None:
                evidence[name] = Index(round(value or 0.0))
            else:
                evidence[name] = value
        return evidence, soft

    def _cluster(self, link: Observe, value: float | None, holding: Holding) -> str | None:
        number, clusters = round(value or 0.0), self.cprm.clusters
        if not 0 <= number < len(clusters):
            raise ModelError(
                f"cprm {self.cprm.name!r}: {link.variable!r} takes the number of a cluster, 0 to {len(clusters) - 1}, got {number}"
            )
        return holding.clusters[number]

    def read(self, agent: int, variable: str, view: View, holding: Holding, default: float) -> float:
        """A number from an agent's belief; `default` for what does not exist for it now, or before its first step."""
        posterior = self.answers[agent]
        if posterior is None:
            return default
        if variable in self._events:
            return self._probability(posterior, self._events[variable], holding, default)
        name = holding.variable(variable)
        if name is None or name not in posterior.variables:
            return default
        found = posterior.variables[name]
        if view.kind == "probability" and name.endswith(f".{SELECTOR}") and not found.class_name:
            meant = holding.tuples.get(view.argument)
            return default if meant is None else float(posterior[name][0, found.states.index(meant)]) if meant in found.states else 0.0
        return float(view(posterior[name], found)[0])

    def _probability(self, posterior: Posterior, event: Event, holding: Holding, default: float) -> float:
        """Of all that an event says, from the joint posterior."""
        weights: dict[str, np.ndarray] = {}
        for text, states in event.states.items():
            name = holding.variable(text)
            if name is None or name not in posterior.variables:
                return default
            inside = probability_weights(states, posterior.variables[name].domain)
            weights[name] = inside * weights.get(name, 1.0)
        joint = posterior.joint(*weights)[0]
        for inside in reversed(weights.values()):
            joint = joint @ inside
        return float(joint)


def separate_filters(
    grounding: Grounding, batch: int, engine: Any, deep: str | None, every: int, seed: int | None, on_impossible: str
) -> list[Filter]:
    """A filter for each agent; exact and projecting ones share their plans."""
    seeds: Sequence[Any] = [None] * batch if seed is None else np.random.SeedSequence(seed).spawn(batch)
    made: list[Filter] = []
    for own in seeds:
        shared = made[0].engine if made and engine in ("exact", "projection") else engine
        if deep is None:
            made.append(Filter(grounding, 1, shared, on_impossible=on_impossible, seed=own))
        else:
            made.append(DeepFilter(grounding, 1, engine, deep=deep, every=every, on_impossible=on_impossible, seed=own))
    return made
