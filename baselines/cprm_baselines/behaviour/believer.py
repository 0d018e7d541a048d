"""A posterior without a net: the model of an agent, told what he is told, and views of what it then believes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cprm_gym.agents.percepts import Percepts
from cprm_gym.architecture.cprm import CPRM, CPRMRunner
from cprm_gym.architecture.petri import Belief, ObjectPlace, PetriNet
from cprm_gym.envs.controller import Observation


class Believer:
    """The model of a CPRM in all worlds.

    Parameters
    ----------
    cprm : CPRM
        Its model, observations and clusters are taken; of its net the object places that switch relations.
    views : tuple of Belief
        What is looked at; the percepts are ``belief.NAME``.
    objects : callable, optional
        Observation -> attributes of the candidates, as for `SoccerAgent`.
    **options
        Of `CPRMRunner`.
    """

    def __init__(
        self, cprm: CPRM, views: tuple[Belief, ...], objects: Callable[[Observation], Mapping[str, Any]] | None = None, **options: Any
    ) -> None:
        held = tuple(p for p in cprm.net.places if isinstance(p, ObjectPlace))
        self.cprm = replace(cprm, net=PetriNet(f"{cprm.name}_beliefs", places=(*held, *views)))
        self.views, self.objects, self.options = views, objects, options
        self._runner: CPRMRunner | None = None

    def reset(self, worlds: int, chosen: np.ndarray | None) -> None:
        """Begin episodes."""
        if self._runner is None or self._runner.batch != worlds:
            self._runner, chosen = CPRMRunner(self.cprm, worlds, **self.options), None
        self._runner.reset(chosen)

    def believe(self, percepts: Percepts, observation: Observation) -> Percepts:
        """The views after the readings of this cycle."""
        assert self._runner is not None
        self._runner.step(percepts, self.objects(observation) if self.objects else None)
        return {f"belief.{view.name}": np.array(self._runner.executor.read(view.name), np.float64) for view in self.views}
