"""A belief over real numbers as part of the state (§3.2.3, the third way): the agent filters with normals, by the engine "mixture".

The filter itself is run, from each belief that can come up, with the readings that the world gives. There are infinitely many beliefs:
with `grain` those whose views agree within it are one state, an approximation that gets better as it gets smaller ("these will also be
approximations", says the text); without, the belief is exact, for runs, which say how good the approximation is.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ....errors import ModelError, did_you_mean
from ...expressions import Expression
from ...prm.grounding.grounding import Grounding
from ...prm.inference.filter import Filter
from ...prm.inference.filtering import FilterState
from .worlds import Step, World


@dataclass(frozen=True, eq=False)
class GaussianBeliefWorld:
    """A world, and an agent's belief about real numbers of it as belief places of the net read it.

    Parameters
    ----------
    world : World
        The truth.
    model : Grounding
        What the agent believes with.
    readings : mapping of str to str
        Variable of the model (observed or given) -> expression over percepts of the world, and commands (1 where one goes out).
    views : mapping of str to (str, str)
        Belief place -> variable and view, ``("ball.x", "expectation")``.
    when : mapping of str to str, optional
        Variable -> expression that is true where there is a reading of it.
    grain : float
        Beliefs whose views differ by less are one state; 0: every belief is its own.
    engine : str
        Of the filter.

    Raises
    ------
    ModelError
        For a variable that the model does not have.
    """

    world: World
    model: Grounding
    readings: Mapping[str, str]
    views: Mapping[str, tuple[str, str]]
    when: Mapping[str, str] = field(default_factory=dict)
    grain: float = 0.0
    engine: str = "mixture"
    _beliefs: list[tuple[FilterState, dict[str, float]]] = field(default_factory=list, repr=False)
    _known: dict[Hashable, int] = field(default_factory=dict, repr=False)
    _steps: dict[Hashable, list[Step]] = field(default_factory=dict, repr=False)
    _after: dict[Hashable, int] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        if not self.grain >= 0.0:
            raise ModelError(f"beliefs: grain {self.grain} is negative")
        first = self.model.ground((), first=True)
        known = (*first.variables, *first.given)
        for name in (*self.readings, *self.when, *(variable for variable, _ in self.views.values())):
            if name not in known:
                raise ModelError(f"beliefs: unknown variable {name!r}.{did_you_mean(name, known)}")
        object.__setattr__(self, "_filter", Filter(self.model, 1, self.engine, on_impossible="restart"))
        object.__setattr__(self, "_fresh", self._filter.state)  # type: ignore[attr-defined]

    def start(self) -> Sequence[tuple[Hashable, float]]:
        """States of the world with the belief after the first readings."""
        return [((w, self._updated(-1, w, ())), p) for w, p in self.world.start()]

    def percepts(self, state: Hashable) -> Mapping[str, float]:
        """Those of the world, and the views of the belief."""
        w, k = _parts(state)
        return {**self.world.percepts(w), **self._beliefs[k][1]}

    def next(self, state: Hashable, commands: tuple[str, ...]) -> Sequence[Step]:
        """Where the world goes, and what the agent then believes."""
        w, k = _parts(state)
        if (state, commands) not in self._steps:
            found = []
            for step in self.world.next(w, commands):
                over = bool(self.world.ended(step.state))
                found.append(step._replace(state=(step.state, k if over else self._updated(k, step.state, commands))))
            if not self.grain:
                return found  # hardly any comes again
            self._steps[state, commands] = found
        return self._steps[state, commands]

    def ended(self, state: Hashable) -> str:
        """The world's own outcome."""
        return self.world.ended(_parts(state)[0])

    def name(self, state: Hashable) -> str:
        """The world's state and the views of the belief."""
        w, k = _parts(state)
        return f"{self.world.name(w)}, " + ", ".join(f"{place} {value:.3g}" for place, value in self._beliefs[k][1].items())

    @property
    def beliefs(self) -> int:
        """How many have come up."""
        return len(self._beliefs)

    def _updated(self, k: int, w: Hashable, commands: Sequence[str]) -> int:
        """The number of the belief after one more cycle; k = -1: before the first."""
        told = {**dict.fromkeys(commands, 1.0), **self.world.percepts(w)}
        evidence: dict[str, Any] = {}
        for variable, text in self.readings.items():
            if variable not in self.when or _value(self.when[variable], told):
                evidence[variable] = [_value(text, told)]
        same = (k, tuple((variable, value) for variable, (value,) in evidence.items()))
        if same in self._after:
            return self._after[same]
        filter_: Filter = self._filter  # type: ignore[attr-defined]
        filter_.state = self._fresh if k < 0 else self._beliefs[k][0]  # type: ignore[attr-defined]
        posterior = filter_.step(evidence)
        views = {place: float(posterior.read(variable, view)[0]) for place, (variable, view) in self.views.items()}
        key: Hashable = tuple(round(v / self.grain) for v in views.values()) if self.grain else len(self._beliefs)
        if key not in self._known:
            self._known[key] = len(self._beliefs)
            self._beliefs.append((filter_.state, views))
        self._after[same] = self._known[key]
        return self._known[key]


def _value(text: str, told: Mapping[str, float]) -> float:
    e = Expression(text)
    return e.evaluate({name: told.get(name, 0.0) for name in e.names})


def _parts(state: Hashable) -> tuple[Hashable, int]:
    assert isinstance(state, tuple)
    return state[0], state[1]
