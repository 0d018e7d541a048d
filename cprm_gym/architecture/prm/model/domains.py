"""What an attribute can be: one of some named states, a number cut into bins, or a real number.

A domain turns a value as a user writes it (a state's name, metres, radians) into a state index and back.
"""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....errors import EvidenceError, ModelError, did_you_mean


def listed(value: object, what: str, example: str) -> tuple[Any, ...]:
    """The items of a tuple, list or array; a single text or number is refused.

    Raises
    ------
    ModelError
    """
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise ModelError(f"{what} are a tuple, such as {example}, got {value!r}")
    return tuple(value)


@dataclass(frozen=True)
class Labels:
    """Named states, ``Labels(("own", "middle", "attack"))``.

    Attributes
    ----------
    names : tuple of str
        The states, in order; the order is what `Min`, `Max` and the index of a state mean.
    """

    names: tuple[str, ...]

    def __post_init__(self) -> None:
        names = listed(self.names, "states", "('no', 'yes')")
        if not all(isinstance(n, str) and n for n in names):
            raise ModelError(f"states are a tuple of names, got {self.names!r}")
        object.__setattr__(self, "names", names)
        if not self.names:
            raise ModelError("a domain needs at least one state")
        repeated = [n for n in self.names if self.names.count(n) > 1]
        if repeated:
            raise ModelError(f"state {repeated[0]!r} is named twice in {self.names}")
        if "*" in self.names:
            raise ModelError("a state cannot be called '*': in tables that means any state")

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states."""
        return self.names

    @property
    def stamp(self) -> tuple[str, ...]:
        """What a learned table remembers of the domain, to notice that it has changed."""
        return self.names

    def __len__(self) -> int:
        return len(self.names)

    @property
    def values(self) -> tuple[str, ...]:
        """What a function that makes a table is called with: the states' names."""
        return self.names


@dataclass(frozen=True)
class Bins:
    """A number cut into bins, ``Bins((0, 2, 5, 10, 20, 40), unit="m")``.

    Attributes
    ----------
    edges : tuple of float
        Increasing edges; bin k holds ``edges[k] <= x < edges[k + 1]``, the last bin also its upper edge.
    unit : str
        For reports and drawings only.
    circular : bool
        An angle: the last bin is followed by the first, the edges span one period, and every finite value has a bin.
    clip : bool
        A value outside falls into the end bin instead of being refused. Integrated CPDs always give the end bins the tails.
    """

    edges: tuple[float, ...]
    unit: str = ""
    circular: bool = False
    clip: bool = False

    def __post_init__(self) -> None:
        given = listed(self.edges, "edges of bins", "(0.0, 1.0, 2.0)")
        try:
            edges = tuple(float(e) for e in given)
        except (TypeError, ValueError, OverflowError):
            raise ModelError(f"edges of bins are numbers, got {self.edges!r}") from None
        object.__setattr__(self, "edges", edges)
        if len(self.edges) < 2 or not all(math.isfinite(e) for e in self.edges):
            raise ModelError(f"bins need at least two finite edges, got {self.edges}")
        for k, (low, high) in enumerate(itertools.pairwise(self.edges)):
            if not low < high:
                raise ModelError(f"edges of bins must increase: edge {k} is {low!r}, edge {k + 1} is {high!r}")

    @classmethod
    def linear(cls, low: float, high: float, count: int, unit: str = "", clip: bool = False) -> Bins:
        """`count` bins of equal width from `low` to `high`."""
        if count < 1:
            raise ModelError(f"bins: count must be at least 1, got {count}")
        return cls(tuple(float(e) for e in np.linspace(low, high, count + 1)), unit, False, clip)

    @classmethod
    def circle(cls, count: int, unit: str = "rad", start: float | None = None) -> Bins:
        """`count` equal bins round the circle, from `start` (default minus half a turn) on.

        `unit` is ``"rad"`` or ``"deg"`` and fixes the period.
        """
        periods = {"rad": 2.0 * math.pi, "deg": 360.0}
        if unit not in periods:
            raise ModelError(f"bins of a circle: unit must be 'rad' or 'deg', got {unit!r}")
        first = -0.5 * periods[unit] if start is None else start
        return cls(tuple(float(first + periods[unit] * k / count) for k in range(count + 1)), unit, True)

    @property
    def stamp(self) -> tuple[str, ...]:
        """What a learned table remembers of the domain, to notice that it has changed: the exact edges."""
        return tuple(repr(e) for e in self.edges)

    def __len__(self) -> int:
        return len(self.edges) - 1

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the bins, ``"2..5"``."""
        short = [f"{e:g}" for e in self.edges]
        if len(set(short)) < len(short):
            short = [repr(e) for e in self.edges]
        return tuple(f"{a}..{b}" for a, b in itertools.pairwise(short))

    @property
    def values(self) -> tuple[float, ...]:
        """Mid-points of the bins."""
        return tuple(0.5 * (a + b) for a, b in itertools.pairwise(self.edges))

    @property
    def widths(self) -> tuple[float, ...]:
        """Widths of the bins."""
        return tuple(b - a for a, b in itertools.pairwise(self.edges))

    @property
    def period(self) -> float:
        """Length of a full turn of a circular domain."""
        return self.edges[-1] - self.edges[0]


class _Numbers:
    """What has no states: real numbers and angles."""

    @property
    def states(self) -> tuple[str, ...]:
        """None."""
        return ()

    @property
    def values(self) -> tuple[float, ...]:
        """None that could be listed."""
        return ()

    def __len__(self) -> int:
        return 0


@dataclass(frozen=True)
class Real(_Numbers):
    """A real number, ``Real("m")``: what Gaussian engines keep as it is and discrete ones cut into `bins`.

    Attributes
    ----------
    unit : str
        For reports and drawings only.
    low, high : float, optional
        Between which a `Uniform` lies; default the ends of the bins. A reading beyond them is as likely as one between them.
    bins : Bins, optional
        What discrete engines make of it.

    Raises
    ------
    ModelError
    """

    unit: str = ""
    low: float | None = None
    high: float | None = None
    bins: Bins | None = None

    def __post_init__(self) -> None:
        if self.bins is not None and (not isinstance(self.bins, Bins) or self.bins.circular):
            raise ModelError(f"a Real has straight Bins, got {self.bins!r}")
        if (self.low is None) != (self.high is None):
            raise ModelError(f"a Real has both limits or none, got low={self.low!r}, high={self.high!r}")
        if self.low is not None and self.high is not None:
            ends = (self.low, self.high)
            if any(isinstance(e, bool) or not isinstance(e, int | float) or not math.isfinite(e) for e in ends) or not ends[0] < ends[1]:
                raise ModelError(f"the limits of a Real are finite and increase, got low={self.low!r}, high={self.high!r}")

    @property
    def limits(self) -> tuple[float, float] | None:
        """Between which a `Uniform` lies, if anything says so."""
        if self.low is not None and self.high is not None:
            return float(self.low), float(self.high)
        return None if self.bins is None else (self.bins.edges[0], self.bins.edges[-1])

    @property
    def period(self) -> float:
        """0: it does not go round."""
        return 0.0

    @property
    def stamp(self) -> tuple[str, ...]:
        """What a learned table remembers of the domain."""
        return ("real", self.unit)


@dataclass(frozen=True)
class Angle(_Numbers):
    """A direction, ``Angle("deg")``: a real number that goes round.

    Attributes
    ----------
    unit : str
        ``"rad"`` or ``"deg"``, which fixes the period; values are told from minus half a turn to half a turn.
    bins : Bins, optional
        What discrete engines make of it: `Bins.circle`, or other circular ones of that period.

    Raises
    ------
    ModelError
    """

    unit: str = "rad"
    bins: Bins | None = None

    def __post_init__(self) -> None:
        if self.unit not in ("rad", "deg"):
            raise ModelError(f"an Angle is in 'rad' or 'deg', got {self.unit!r}")
        if self.bins is not None:
            if not isinstance(self.bins, Bins) or not self.bins.circular:
                raise ModelError(f"an Angle has circular Bins, got {self.bins!r}")
            if not math.isclose(self.bins.period, self.period):
                raise ModelError(f"an Angle in {self.unit} has bins of {self.period:g} all round, these span {self.bins.period:g}")

    @property
    def period(self) -> float:
        """A full turn."""
        return 360.0 if self.unit == "deg" else 2.0 * math.pi

    @property
    def limits(self) -> tuple[float, float]:
        """Half a turn each way."""
        return -0.5 * self.period, 0.5 * self.period

    @property
    def stamp(self) -> tuple[str, ...]:
        """What a learned table remembers of the domain."""
        return ("angle", self.unit)


Domain = Labels | Bins | Real | Angle


def is_continuous(domain: Domain) -> bool:
    """The domain is that of a real number or an angle, which has no states."""
    return isinstance(domain, Real | Angle)


@dataclass(frozen=True, eq=False)
class Interval:
    """A reading that is known to lie between two numbers: ``Interval(4.5, 5.0)``, or one pair for each agent.

    What a coarse sense tells is such a reading, and so is "farther than 20": ``Interval(20.0, inf)``.

    Attributes
    ----------
    low, high : float or (W,) float array
        NaN where nothing was observed; of an angle, `high` may be less than `low`, and the interval goes round.

    Raises
    ------
    EvidenceError
        For what are no numbers.
    """

    low: float | np.ndarray
    high: float | np.ndarray

    def __post_init__(self) -> None:
        for name in ("low", "high"):
            try:
                array = np.asarray(getattr(self, name), dtype=float)
            except (TypeError, ValueError, OverflowError):
                raise EvidenceError(f"an Interval has numbers, got {name}={getattr(self, name)!r}") from None
            object.__setattr__(self, name, array)


@dataclass(frozen=True, eq=False)
class Index:
    """The number of a state, or one for each agent, where a bare number would be a quantity: ``Index(3)`` is the fourth bin.

    Attributes
    ----------
    value : int or (W,) int array
        From 0; -1 where not observed.

    Raises
    ------
    EvidenceError
        For anything but integers.
    """

    value: int | np.ndarray

    def __post_init__(self) -> None:
        array = self.value if isinstance(self.value, np.ndarray) else np.asarray(self.value)
        if array.dtype.kind not in "iu":
            raise EvidenceError(f"an Index is an integer, or an array of integers, got {type(self.value).__name__} of {array.dtype}")


BOOL = Labels(("no", "yes"))
"""The two-state domain of flags; the second state is the one that holds."""


def as_domain(value: object, where: str) -> Domain:
    """A domain from what a user wrote: a domain, or a tuple of state names.

    Raises
    ------
    ModelError
    """
    if isinstance(value, Labels | Bins | Real | Angle):
        return value
    if isinstance(value, tuple | list) and all(isinstance(v, str) for v in value):
        return Labels(tuple(value))
    raise ModelError(f"{where}: states must be a tuple of names, Labels, Bins, Real or Angle, got {value!r}")


def state_index(domain: Domain, value: object, where: str) -> int:
    """Index of the state that an observed value falls into.

    Named states take a name (or a `bool` when there are two states, or an index); bins take a number; both an `Index`.

    Parameters
    ----------
    domain : Labels or Bins
    value : object
    where : str
        Start of the message, ``"evidence for 'ball.zone'"``.

    Raises
    ------
    EvidenceError
        For an unknown state, NaN, infinity, or a number outside the bins.
    """
    if isinstance(value, Index):
        state = int(value.value) if np.ndim(value.value) == 0 else -1
        if not 0 <= state < len(domain):
            raise EvidenceError(f"{where}: {value!r} is not one state index of 0 to {len(domain) - 1}")
        return state
    if isinstance(domain, Labels):
        return _label_index(domain, value, where)
    if isinstance(domain, Real | Angle):
        raise EvidenceError(f"{where}: a real number has no states; discrete engines need its `bins`")
    if isinstance(value, str) and value in domain.states:
        return domain.states.index(value)
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.integer | np.floating):
        raise EvidenceError(f"{where}: bins take a number{_unit(domain)}, got {value!r}")
    try:
        number = float(value)
    except OverflowError:
        raise EvidenceError(f"{where}: the number is too large") from None
    index = _bin_index(domain, number)
    if index < 0:
        what = "is not a finite number" if not math.isfinite(number) else "is outside the bins"
        raise EvidenceError(f"{where}: {number!r} {what}; allowed are {domain.edges[0]!r} to {domain.edges[-1]!r}{_unit(domain)}")
    return index


def _bin_index(domain: Bins, x: float) -> int:
    """Bin of one number; -1 where it is not finite or outside the bins."""
    if not math.isfinite(x):
        return -1
    edges, last = domain.edges, len(domain) - 1
    if domain.circular:
        x = edges[0] + (x - edges[0]) % domain.period
    if not domain.circular and not domain.clip and not edges[0] <= x <= edges[-1]:
        return -1
    return min(max(bisect.bisect_right(edges, x) - 1, 0), last)


def bin_indices(domain: Bins, values: np.ndarray) -> np.ndarray:
    """Bin of each number; -1 where it is not finite or outside the bins.

    Parameters
    ----------
    domain : Bins
    values : float array, any shape

    Returns
    -------
    int64 array of the same shape
    """
    x = np.asarray(values, dtype=float)
    finite = np.isfinite(x)
    edges = np.asarray(domain.edges)
    safe = np.where(finite, x, edges[0])
    if domain.circular:
        safe = edges[0] + np.mod(safe - edges[0], domain.period)
    index = np.searchsorted(edges, safe, side="right") - 1
    last = len(domain) - 1
    if domain.circular or domain.clip:
        index = np.clip(index, 0, last)
    else:
        index = np.where(safe == edges[-1], last, index)
        index = np.where((safe < edges[0]) | (safe > edges[-1]), -1, index)
    return np.asarray(np.where(finite, index, -1), dtype=np.int64)


def _label_index(domain: Labels, value: object, where: str) -> int:
    if isinstance(value, bool | np.bool_) and len(domain) == 2:
        return int(value)
    if isinstance(value, int | np.integer) and not isinstance(value, bool):
        if 0 <= int(value) < len(domain):
            return int(value)
        raise EvidenceError(f"{where}: state index {int(value)} is outside 0 to {len(domain) - 1}")
    if isinstance(value, str) and value in domain.names:
        return domain.names.index(value)
    known = ", ".join(domain.names)
    hint = did_you_mean(value, domain.names) if isinstance(value, str) else ""
    raise EvidenceError(f"{where}: unknown state {value!r}. Known: {known}.{hint}")


def _unit(domain: Bins) -> str:
    return f" {domain.unit}" if domain.unit else ""
