"""Numbers that a Petri net reads from a belief: expectation, variance, mode, probability, entropy, quantile.

A view is a frozen value with a text form, ``View.parse("probability(0..2.5)")``, and is evaluated over beliefs of any leading
shape, so the belief places of many agents are one call.

==============================  ==========================================================================
text                            value
==============================  ==========================================================================
``expectation``                 mean of bin mid-points; of state indices for named states; circular mean of an angle
``variance``                    bins count as uniform inside (``+ w**2 / 12``); about the circular mean for an angle
``variance(midpoints)``         bins count as points
``deviation``                   square root of ``variance``
``mode``                        mid-point of the likeliest bin; index of the likeliest named state
``argmax``                      index of the likeliest state
``probability(state)``          of one state, or of several, ``probability(own|middle)``
``probability(a..b)``           of an interval, uniform inside bins; ``a..`` and ``..b`` are open; an angle may wrap, ``3..-3``; there
                                is nothing beyond the bins, and an interval that lies wholly there is an error
``entropy``                     in nats
``quantile(q)``                 the value below which the share q lies, uniform inside bins
``resultant``                   length of the mean direction of an angle: 1 certain, 0 spread evenly
==============================  ==========================================================================

Of a real number the belief is a `NormalMixture`; every view but ``argmax`` and those of states is there too, ``entropy`` by quadrature
(-inf of one that is known).
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ....errors import EvidenceError, ModelError, did_you_mean
from ..grounding.slices import GroundVariable
from ..model.domains import Angle, Bins, Domain, Real
from ..model.moments import circular_mean, is_angle, mean, points, quantile, resultant, variance
from .continuous.normal_mixture import NormalMixture

PLAIN = ("expectation", "variance", "deviation", "mode", "argmax", "entropy", "resultant")
WITH_ARGUMENT = ("probability", "quantile")
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_INTERVAL = re.compile(rf"\s*({_NUMBER})?\s*\.\.\s*({_NUMBER})?\s*\Z")


@dataclass(frozen=True)
class View:
    """One number from a distribution.

    Attributes
    ----------
    kind : str
        ``"expectation"``, ``"variance"``, ... as in the table above.
    argument : str
        What stands in brackets, or empty.

    Raises
    ------
    ModelError
        For an unknown kind or an argument that does not belong to it.
    """

    kind: str
    argument: str = ""

    def __post_init__(self) -> None:
        known = (*PLAIN, *WITH_ARGUMENT)
        if self.kind not in known:
            raise ModelError(f"unknown view {self.kind!r}.{did_you_mean(self.kind, known)} Known: {', '.join(known)}")
        if self.kind in WITH_ARGUMENT and not self.argument:
            example = "0.9" if self.kind == "quantile" else "state"
            raise ModelError(f"view {self.kind!r} needs an argument, such as {self.kind}({example})")
        if self.kind in PLAIN and self.argument and (self.kind, self.argument) != ("variance", "midpoints"):
            raise ModelError(f"view {self.kind!r} takes no argument {self.argument!r}")
        if self.kind == "quantile":
            try:
                share = float(self.argument)
            except ValueError:
                share = math.nan
            if not 0.0 <= share <= 1.0:
                raise ModelError(f"view {self.text}: a share is 0 to 1, got {self.argument!r}")

    @classmethod
    def parse(cls, text: str) -> View:
        """The view that a text names."""
        head, bracket, rest = text.strip().partition("(")
        if bracket and not rest.endswith(")"):
            raise ModelError(f"view {text!r}: the bracket is not closed")
        if bracket and not rest[:-1].strip():
            raise ModelError(f"view {text!r}: nothing stands in the brackets")
        return cls(head.strip(), rest[:-1].strip())

    @property
    def text(self) -> str:
        """The text form; parsing it gives an equal view."""
        return f"{self.kind}({self.argument})" if self.argument else self.kind

    def check(self, of: Domain | GroundVariable) -> None:
        """Refuse a view that the variable does not have: an unknown state, an interval of named states, a quantile of an angle.

        Raises
        ------
        ModelError
        """
        domain = _domain(of)
        if isinstance(domain, Real | Angle):
            one = np.ones(1)
            self(NormalMixture(one, one, one, domain.period), domain)
            return
        size = len(domain)
        self(np.full(size, 1.0 / size), domain)

    def __call__(self, p: np.ndarray | NormalMixture, of: Domain | GroundVariable) -> np.ndarray:
        """The number for each distribution.

        Parameters
        ----------
        p : (..., K) float array, or NormalMixture
            Distributions over the K states, or of a real number.
        of : Domain or GroundVariable
            What they are distributions of.

        Returns
        -------
        (...) float array

        Raises
        ------
        EvidenceError
            If the last axis does not have one entry per state.
        """
        domain = _domain(of)
        if isinstance(domain, Real | Angle):
            if not isinstance(p, NormalMixture):
                raise EvidenceError(f"view {self.text}: the belief about a real number is a NormalMixture, got {type(p).__name__}")
            return self._of_number(p)
        p = np.asarray(p, dtype=float)
        if p.ndim == 0 or p.shape[-1] != len(domain):
            needed = f"a belief over {len(domain)} states is needed, got an array of shape {p.shape}"
            raise EvidenceError(f"view {self.text}: {needed}")
        if self.kind == "probability":
            return mean(p, probability_weights(self.argument, domain))
        if self.kind == "expectation":
            return circular_mean(p, domain) if is_angle(domain) else mean(p, points(domain))
        if self.kind == "variance":
            return variance(p, domain, within_bins=self.argument != "midpoints")
        if self.kind == "deviation":
            return np.asarray(np.sqrt(variance(p, domain)))
        if self.kind == "argmax":
            return np.asarray(np.argmax(p, axis=-1), dtype=float)
        if self.kind == "mode":
            return np.asarray(points(domain)[np.argmax(p, axis=-1)])
        if self.kind == "entropy":
            return np.asarray(-np.sum(p * np.log(np.where(p > 0.0, p, 1.0)), axis=-1)) + 0.0
        if self.kind == "quantile":
            return quantile(p, domain, float(self.argument))
        return resultant(p, domain)

    def _of_number(self, p: NormalMixture) -> np.ndarray:
        """The number for mixtures of normals."""
        if self.kind == "probability":
            interval = _INTERVAL.match(self.argument)
            if interval is None:
                raise ModelError(f"view {self.text}: a real number has no states; write an interval, probability(a..b)")
            low, high = (default if text is None else float(text) for text, default in zip(interval.groups(), (-math.inf, math.inf)))
            return p.probability(low, high)
        if self.kind == "quantile":
            return p.quantile(float(self.argument))
        if self.kind == "argmax" or self.argument:
            raise ModelError(f"view {self.text}: a real number has no states")
        if self.kind == "deviation":
            return np.asarray(np.sqrt(p.variance()))
        if self.kind == "resultant":
            return np.asarray(np.abs(p.phasor()))
        return np.asarray(getattr(p, self.kind)())


def view(text: str) -> View:
    """The view that a text names, ``view("quantile(0.9)")``."""
    return View.parse(text)


def _domain(of: Domain | GroundVariable) -> Domain:
    return of.domain if isinstance(of, GroundVariable) else of


@lru_cache(maxsize=1024)
def probability_weights(argument: str, domain: Domain) -> np.ndarray:
    """Share of every state that belongs to a state, a set of states or an interval.

    Parameters
    ----------
    argument : str
        ``"own"``, ``"own|middle"``, ``"2.5..7"``, ``"..7"``, ``"2.5.."``.
    domain : Labels or Bins

    Returns
    -------
    (K,) float array, 0 to 1

    Raises
    ------
    ModelError
    """
    weights: np.ndarray = np.zeros(len(domain))
    interval = _INTERVAL.match(argument)
    names = [s.strip() for s in argument.split("|")]
    if all(s in domain.states for s in names):
        for s in names:
            weights[domain.states.index(s)] = 1.0
    elif interval is None or not isinstance(domain, Bins):
        unknown = next(s for s in names if s not in domain.states)
        hint = did_you_mean(unknown, domain.states)
        raise ModelError(f"view probability({argument}): unknown state {unknown!r}.{hint} Known: {', '.join(domain.states)}")
    else:
        weights = _interval_weights(interval.group(1), interval.group(2), domain, argument)
    weights.flags.writeable = False
    return weights


def _interval_weights(low: str | None, high: str | None, domain: Bins, argument: str) -> np.ndarray:
    edges = np.asarray(domain.edges)
    a = float(edges[0]) if low is None else float(low)
    b = float(edges[-1]) if high is None else float(high)
    if not domain.circular:
        if b < edges[0] or a > edges[-1]:
            raise ModelError(f"view probability({argument}): the interval lies outside the bins, {edges[0]:g} to {edges[-1]:g}")
        if a > b:
            raise ModelError(f"view probability({argument}): the interval is empty")
        return _overlap(edges, a, b)
    if b - a >= domain.period:
        return np.full(len(domain), 1.0)
    a = float(edges[0] + (a - edges[0]) % domain.period)
    end = float(edges[0] + (b - edges[0]) % domain.period)
    if end == edges[0] and b != a:
        end = float(edges[-1])
    if end >= a:
        return _overlap(edges, a, end)
    tail = _overlap(edges, a, float(edges[-1]))
    return np.asarray(tail + _overlap(edges, float(edges[0]), end))


def _overlap(edges: np.ndarray, a: float, b: float) -> np.ndarray:
    inside = np.minimum(edges[1:], b) - np.maximum(edges[:-1], a)
    return np.asarray(np.clip(inside / np.diff(edges), 0.0, 1.0))
