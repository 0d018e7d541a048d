"""What was observed of real numbers, checked: a number, an `Interval`, or one for each agent.

None, NaN and masked entries are not observed; a number alone must be finite, an interval may be open at an end. To a variable with bins
an interval is a likelihood: the share of each bin that lies in it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from .....errors import EvidenceError
from ...grounding.slices import GroundVariable
from ...model.domains import Bins, Index, Interval


class Numbers(NamedTuple):
    """Readings of one real number.

    Attributes
    ----------
    low, high : (W,) float arrays
        Equal where a number was read, an interval otherwise; NaN where nothing was.
    """

    low: np.ndarray
    high: np.ndarray

    @property
    def seen(self) -> np.ndarray:
        """(W,) bool array: where something was read."""
        return np.asarray(~np.isnan(self.low))

    def rows(self, agents: np.ndarray) -> Numbers:
        """Those of some agents."""
        return Numbers(self.low[agents], self.high[agents])

    def without(self, agents: np.ndarray) -> Numbers:
        """The same with nothing read by some agents."""
        low, high = self.low.copy(), self.high.copy()
        low[agents] = high[agents] = np.nan
        return Numbers(low, high)

    def filled(self, value: float) -> Numbers:
        """The same with a number where nothing was read."""
        return Numbers(np.where(self.seen, self.low, value), np.where(self.seen, self.high, value))


def nothing(batch: int) -> Numbers:
    """Nothing read."""
    return Numbers(np.full(batch, np.nan), np.full(batch, np.nan))


def read_numbers(variable: GroundVariable, value: Any, batch: int) -> Numbers:
    """Readings of a real number from what a user tells.

    Parameters
    ----------
    variable : GroundVariable
        With a quantity.
    value : float, Interval, None, or an array or list with an entry for each agent
    batch : int

    Raises
    ------
    EvidenceError
        For anything else, an infinite number, an empty interval, or a wrong number of agents.
    """
    where = f"evidence for {variable.name!r}"
    if value is None:
        return nothing(batch)
    if isinstance(value, Interval):
        low, high = _numbers(value.low, batch, where), _numbers(value.high, batch, where)
        if (np.isnan(low) != np.isnan(high)).any():
            raise EvidenceError(f"{where}: an interval has one end that is NaN")
        if variable.circular:
            if np.isinf(low).any() or np.isinf(high).any():
                raise EvidenceError(f"{where}: an interval of an angle has finite ends")
            period = variable.domain.period  # type: ignore[union-attr]
            return Numbers(low, low + np.mod(high - low, period))
        if (low > high).any() or np.isposinf(low).any() or np.isneginf(high).any():
            at = int(np.argmax((low > high) | np.isposinf(low) | np.isneginf(high)))
            raise EvidenceError(f"{where}: the interval from {low[at]} to {high[at]} is empty")
        return Numbers(low, high)
    if isinstance(value, Index | str | bool | np.bool_):
        raise EvidenceError(f"{where}: got {value!r}; give a number or an Interval, or one of them for each agent")
    read = _numbers(value, batch, where)
    if np.isinf(read).any():
        raise EvidenceError(f"{where}: {read[np.isinf(read)][0]} is not a finite number")
    return Numbers(read, read)


def plain_numbers(variables: Mapping[str, GroundVariable], evidence: Mapping[str, Any], batch: int) -> dict[str, Numbers]:
    """Readings of real numbers that are floats, or arrays of them with one for each agent, all at once; not those to be refused."""
    found: list[str] = []
    values: list[Any] = []
    for name, value in evidence.items():
        variable = variables.get(name)
        if variable is None or variable.quantity is None:
            continue
        if type(value) is float or (type(value) is np.ndarray and value.dtype == np.float64 and value.shape == (batch,)):
            found.append(name)
            values.append(value)
    table = np.empty((len(found), batch))
    for row, value in zip(table, values):
        row[:] = value
    if np.isinf(table).any():
        return {}
    return {name: Numbers(row, row) for name, row in zip(found, table)}


def _numbers(value: Any, batch: int, where: str) -> np.ndarray:
    if isinstance(value, np.ma.MaskedArray):
        value = np.where(np.ma.getmaskarray(value), np.nan, np.ma.getdata(value).astype(float))
    elif isinstance(value, list | tuple):
        value = [np.nan if v is None else v for v in value]
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "iufO" or (array.dtype.kind == "O" and any(isinstance(v, str | bool) for v in array.flat)):
            raise ValueError
        array = array.astype(float)
    except (TypeError, ValueError, OverflowError):
        raise EvidenceError(f"{where}: got {value!r:.60}; give a number or an Interval, or one of them for each agent") from None
    if array.shape not in ((), (1,), (batch,)):
        raise EvidenceError(f"{where} has shape {array.shape} for {batch} agents")
    return np.array(np.broadcast_to(array, (batch,)))


def interval_likelihood(variable: GroundVariable, value: Interval, batch: int) -> np.ndarray:
    """Likelihood of an interval for each bin of a variable, (batch, bins); ones where nothing was read.

    Raises
    ------
    EvidenceError
        For a variable without bins, or an interval that lies beyond them.
    """
    domain, where = variable.domain, f"evidence for {variable.name!r}"
    if not isinstance(domain, Bins):
        raise EvidenceError(f"{where}: an Interval is of numbers; the states are {variable.states}")
    low, high = _numbers(value.low, batch, where), _numbers(value.high, batch, where)
    edges = np.asarray(domain.edges)
    if domain.circular:
        high = low + np.mod(high - low, domain.period)
        shifts = [k * domain.period for k in (-2, -1, 0, 1, 2)]
        start = edges[0] + np.mod(low - edges[0], domain.period)
        low, high = start, start + (high - low)
    else:
        shifts = [0.0]
        if domain.clip:
            low, high = np.minimum(low, edges[-1]), np.maximum(high, edges[0])
    inside = np.zeros((batch, len(domain)))
    for shift in shifts:
        ends = np.minimum(edges[1:], (high + shift)[:, None]) - np.maximum(edges[:-1], (low + shift)[:, None])
        inside += np.clip(ends, 0.0, None)
    point = (low == high)[:, None]
    likelihood = np.where(point, (edges[:-1] <= low[:, None]) & (low[:, None] <= edges[1:]), inside / np.diff(edges))
    seen = ~np.isnan(low)
    if (likelihood[seen].sum(axis=1) <= 0.0).any():
        raise EvidenceError(f"{where}: an interval lies outside its bins, {edges[0]} to {edges[-1]}")
    return np.where(seen[:, None], likelihood, 1.0)
