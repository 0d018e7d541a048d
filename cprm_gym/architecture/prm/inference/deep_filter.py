"""Inference with two grains: frequent simple, occasional deep (dissertation section 2.3.3).

A `DeepFilter` answers each step with its own, quicker engine, remembers the readings, and every so often, or when asked
(`DeepFilter.deepen`), infers them again with the deep one and goes on from its belief.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ....errors import ParameterError
from . import filtering
from .engines.engine import Engine
from .evidence import UNOBSERVED, Readings
from .filter import Filter, make_engine
from .filtering import FilterState
from .posterior import Posterior


class DeepFilter(Filter):
    """A filter with an occasional deeper inference.

    Parameters
    ----------
    grounding, batch, engine, **options
        As for `Filter`; an engine that can go on from a belief of factors, "projection", "anytime" or "exact", or one that keeps real
        numbers, "mixture" or "rao-blackwell".
    deep : {"exact", "projection", "mixture", "rao-blackwell"} or Engine
        Engine of the occasional inference; one that keeps real numbers if the other does.
    every : int
        Steps from one deep inference to the next; as many readings are remembered.

    Attributes
    ----------
    deep_state : FilterState
        After the last deep inference.
    """

    def __init__(
        self, grounding: Any, batch: int = 1, engine: Any = "projection", *, deep: str | Engine = "exact", every: int = 1000, **options: Any
    ) -> None:
        super().__init__(grounding, batch, engine, **options)
        if every < 1:
            raise ParameterError(f"`every` is a number of steps, at least 1, got {every!r}")
        self.every = every
        engine, below = self.engine, make_engine(deep, options.get("seed"), options.get("memory_limit", 2.0**31))
        if engine.continuous != below.continuous:
            keeps, bins = (engine, below) if engine.continuous else (below, engine)
            raise ParameterError(f"{keeps.name!r} keeps real numbers and {bins.name!r} has bins: no engine goes on from the other's belief")
        self.deep_settings = replace(self.settings, engine=below)
        self.deep_state: FilterState = filtering.begin(self.deep_settings, batch)
        engine.adopt(below.handed_over(self.deep_state.belief))
        self._remembered: list[tuple[Readings, tuple[str, ...], Any, np.ndarray]] = []

    def reset(self, agents: Any = None) -> None:
        super().reset(agents)
        if self.state.step == 0:
            self._remembered.clear()
            self.deep_state = filtering.begin(self.deep_settings, self.batch)

    def step(
        self,
        evidence: Mapping[str, Any] | np.ndarray | None = None,
        relations: Any = (),
        *,
        objects: Iterable[str] | None = None,
        soft: Mapping[str, Any] | None = None,
    ) -> Posterior:
        settings, state = self.settings, self.state
        situation = settings.grounding.situation(relations, objects, state.relations if state.step else None)
        info = filtering.slice_info(settings, state, settings.grounding.ground(situation, first=state.step == 0))
        readings = filtering.read(info, state.batch, evidence, soft)
        self.state, posterior = filtering.advance(settings, state, readings, situation, info)
        self._remembered.append((readings, info.names, situation, state.fresh))
        return self.deepen() if len(self._remembered) >= self.every else posterior

    def deepen(self) -> Posterior:
        """Infer the remembered readings again with the deep engine, and go on from its belief.

        Returns
        -------
        Posterior
            Of the last step, better founded.

        Raises
        ------
        ParameterError
            When no step was made since the last deep inference.
        """
        if not self._remembered:
            raise ParameterError("nothing to infer deeply: make a step first")
        settings, state = self.deep_settings, self.deep_state
        for readings, names, situation, fresh in self._remembered:
            if fresh.any():
                state = filtering.begin_anew(state, fresh)
            info = filtering.slice_info(settings, state, settings.grounding.ground(situation, first=state.step == 0))
            row = {name: k for k, name in enumerate(names)}
            order = np.array([row.get(name, -1) for name in info.names])
            hard = np.where(order[:, None] < 0, UNOBSERVED, readings.hard[order])
            state, posterior = filtering.advance(settings, state, Readings(hard, readings.soft, readings.numbers), situation)
        self._remembered.clear()
        self.deep_state = state
        belief = self.engine.adopt(settings.engine.handed_over(state.belief))
        self.state = state._replace(belief=belief, impossible=self.state.impossible)
        return posterior
