"""Rao-Blackwellised particles: modes are drawn instead of merged, numbers stay normals in each, or are drawn too where they bend too far.

A particle is a component of the mixture engine: a sequence of modes with a normal over the numbers. All that it can become is weighed, and
who stays is drawn by optimal resampling, unbiased and without two particles that are the same. Numbers named in `drawn` are drawn from
their CPD, so that what depends on them is exact, however it bends, and what is left is a straight line.

References
----------
Doucet, de Freitas, Murphy and Russell 2000; Fearnhead and Clifford 2003 (optimal resampling); Schoen, Gustafsson and Nordlund 2005
(marginalised particle filters); dissertation section 2.3.2.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, ClassVar

import numpy as np

from cprm_gym.errors import ParameterError

from ...model.schema import one_or_many
from ..compiled.slice_info import SliceInfo
from ..continuous.belief import MixtureBelief
from ..evidence import Readings
from .mixture import MixtureEngine
from .mixture_answers import MixtureResult


class RaoBlackwellEngine(MixtureEngine):
    """Particles over modes, normals over numbers.

    Parameters
    ----------
    particles : int
        For each part and agent, at most: as long as there are fewer modes the answer is that of all of them.
    drawn : iterable of str
        Numbers that are drawn, ``("ball.x", "ball.y")``.
    seed : int, SeedSequence or Generator
    split : float
        As of `MixtureEngine`.
    """

    name: ClassVar[str] = "rao-blackwell"
    divisible: ClassVar[bool] = False
    draws: ClassVar[bool] = True

    def __init__(self, particles: int = 100, drawn: Iterable[str] = (), seed: Any = None, split: float = 0.0) -> None:
        if isinstance(particles, bool) or not isinstance(particles, (int, np.integer)) or particles < 2:
            raise ParameterError(f"`particles` is at least 2, got {particles!r}")
        super().__init__(int(particles), 0.0, split)
        self.sampled = frozenset(one_or_many(drawn))
        self._root = np.random.default_rng(seed)
        self._rng = np.random.Generator(type(self._root.bit_generator)())

    def start(self, batch: int) -> MixtureBelief:
        (child,) = self._root.spawn(1)
        return super().start(batch)._replace(random=dict(child.bit_generator.state))

    def adopt(self, belief: MixtureBelief) -> MixtureBelief:
        """With a stream of random numbers of its own."""
        return belief._replace(random=self.start(belief.batch).random)

    def step(
        self,
        belief: MixtureBelief,
        info: SliceInfo,
        readings: Readings,
        wanted: frozenset[str] = frozenset(),
        label: str = "",
        room: int = 0,
    ) -> MixtureResult:
        """As the mixture engine's, with the random numbers that the belief has left."""
        for name in self.sampled & info.row.keys():
            if info.variables[name].quantity is None:
                raise ParameterError(f"`drawn`: {name!r} has states, which are drawn in any case; name real numbers")
        random: Mapping[str, Any] = belief.random
        self._rng.bit_generator.state = random
        result = super().step(belief, info, readings, wanted, label, room)
        result.belief = result.belief._replace(random=self._rng.bit_generator.state)
        return result

    def _numbers(self, rows: int, capacity: int, draws: int) -> tuple[np.ndarray, np.ndarray]:
        return self._rng.standard_normal((rows, capacity, draws)), self._rng.random(rows)
