"""What was observed, checked: from names and values as a user gives them to arrays of state indices.

A *number* given to a variable with bins is a quantity, whether it is written ``5``, ``5.0`` or ``np.int64(5)``; it is never the number of a
bin. Named states take a name, and since a number cannot be anything else there, the index of a state. What is meant as an index
everywhere is said to be one: ``Index(3)``, ``Index(np.array([0, -1, 2]))`` with -1 where nothing was observed. None, NaN and masked
entries are not observed, for one agent or for all; everything else is refused by the variable's name.

Who has state indices already, row by row, hands them over as `StateRows`, or as an array of all variables.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ....errors import EvidenceError, ImpossibleEvidence, did_you_mean
from ..grounding.slices import GroundVariable
from ..model.domains import Index, Interval
from .continuous.number_evidence import Numbers, interval_likelihood, plain_numbers, read_numbers

UNOBSERVED = -1


class Readings(NamedTuple):
    """The evidence of one slice.

    Attributes
    ----------
    hard : (V, W) int array
        State of each variable for each agent; -1 where not observed; 0 where a real number was.
    soft : dict of str to (W, card) float array
        Likelihood vectors (Pearl): any scale, the scale only changes the log-likelihood.
    numbers : dict of str to Numbers
        Readings of real numbers.
    """

    hard: np.ndarray
    soft: dict[str, np.ndarray]
    numbers: Mapping[str, Numbers] = MappingProxyType({})

    def extended(self, count: int) -> Readings:
        """The readings with unobserved variables added at the end, `count` in all."""
        missing = count - len(self.hard)
        return self._replace(hard=np.pad(self.hard, ((0, missing), (0, 0)), constant_values=UNOBSERVED)) if missing else self

    def rows(self, agents: np.ndarray) -> Readings:
        """The readings of some agents."""
        return Readings(
            self.hard[:, agents],
            {name: likelihood[agents] for name, likelihood in self.soft.items()},
            {name: numbers.rows(agents) for name, numbers in self.numbers.items()},
        )


class StateRows(Mapping[str, Index]):
    """Evidence as one array of state indices, a row for each of some variables.

    Parameters
    ----------
    names : tuple of str
    states : (n, W) int64 array
        -1 where not observed.
    checked : bool
        Every entry is known to be a state of its variable, or -1.
    """

    def __init__(self, names: tuple[str, ...], states: np.ndarray, checked: bool = False) -> None:
        self.names, self.states, self.checked = names, states, checked

    def __getitem__(self, name: str) -> Index:
        if name not in self.names:
            raise KeyError(name)
        return Index(self.states[self.names.index(name)])

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)


def bin_of(variable: GroundVariable, values: np.ndarray) -> np.ndarray:
    """Bins that numbers fall in.

    Parameters
    ----------
    variable : GroundVariable
        With edges.
    values : float array
        In the unit of the edges. Bin k holds ``edges[k] <= x < edges[k + 1]``, the last bin its upper edge too; a circular
        variable takes any finite value, and so does one that clips.

    Returns
    -------
    int64 array
        -1 for NaN.

    Raises
    ------
    EvidenceError
        For an infinite value, or one outside the bins.
    """
    assert variable.edges is not None
    seen = ~np.isnan(values)
    if not seen.all():
        states = np.full(values.shape, UNOBSERVED, np.int64)
        states[seen] = bin_of(variable, values[seen])
        return states
    if not np.isfinite(values).all():
        raise EvidenceError(f"evidence for {variable.name!r}: {values[~np.isfinite(values)].flat[0]} is not a finite number")
    edges = np.asarray(variable.edges, dtype=np.float64)
    if variable.circular:
        values = edges[0] + np.mod(values - edges[0], edges[-1] - edges[0])
    if variable.clip:  # `np.clip` takes three times as long for few values
        values = np.minimum(np.maximum(values, edges[0]), edges[-1])
    outside = (values < edges[0]) | (values > edges[-1])
    if outside.any():
        raise EvidenceError(f"evidence for {variable.name!r}: {values[outside].flat[0]} lies outside its bins, {edges[0]} to {edges[-1]}")
    return np.minimum(np.searchsorted(edges, values, side="right") - 1, variable.card - 1)


def _shown(variable: GroundVariable) -> str:
    """The states of a variable, the first ones if there are many."""
    states = [str(s) for s in variable.states]
    return ", ".join(states[:12]) + (", ..." if len(states) > 12 else "")


def state_of(variable: GroundVariable, value: Any) -> np.ndarray | int:
    """State index or indices of one observation.

    Parameters
    ----------
    variable : GroundVariable
    value : Index, str, number, None, or an array or list of them, possibly masked
        A list or array has one entry for each agent. None, NaN and masked entries are unobserved.

    Returns
    -------
    int or int64 array
        -1 where not observed.

    Raises
    ------
    EvidenceError
        If the value is none of these, or no state.
    """
    if value is None:
        return UNOBSERVED
    if isinstance(value, Index):
        return _indices(variable, value.value)
    if isinstance(value, str):
        if value not in variable.states:
            hint = did_you_mean(value, variable.states)
            raise EvidenceError(f"evidence for {variable.name!r}: unknown state {_brief(value)}.{hint} Known: {_shown(variable)}")
        return variable.states.index(value)
    if isinstance(value, np.ma.MaskedArray):
        return _unmasked(variable, value)
    try:
        array = np.asarray(value)
    except (ValueError, OverflowError):  # ragged, or deeper than arrays may be
        raise _wrong(variable, value) from None
    if array.dtype.kind in "OUS" and array.ndim == 1:
        return np.array([_one(variable, v) for v in (value if isinstance(value, list | tuple) else array.tolist())], np.int64)
    if array.dtype.kind == "U" and not array.ndim:
        return state_of(variable, str(array))
    if array.dtype.kind == "O" and isinstance(value, int):  # beyond 64 bits
        raise EvidenceError(f"evidence for {variable.name!r}: an integer of {value.bit_length()} bits is too large")
    if array.dtype.kind not in "iufb":
        raise _wrong(variable, value)
    if variable.edges is None:
        return _indices(variable, array)
    if array.dtype.kind == "b":
        raise _wrong(variable, value)
    return bin_of(variable, np.atleast_1d(array).astype(np.float64)).reshape(array.shape)


def _one(variable: GroundVariable, value: Any) -> int:
    """State of an entry of a list: an array inside it is a mistake."""
    if isinstance(value, list | tuple | np.ndarray):
        raise _wrong(variable, value)
    return int(state_of(variable, value))


def _indices(variable: GroundVariable, value: Any) -> np.ndarray:
    """State indices from numbers that are meant to be such; NaN is not observed."""
    array = np.asarray(value)
    if array.dtype.kind == "f":
        unseen = np.isnan(array)
        if not unseen.all():
            found = array[~unseen].flat[0]
            raise EvidenceError(f"evidence for {variable.name!r}: got the number {found!r}, but its states are names: {_shown(variable)}")
        return np.full(array.shape, UNOBSERVED, np.int64)
    if array.dtype.kind == "b" and variable.card != 2:
        raise _wrong(variable, value)
    if ((array < UNOBSERVED) | (array >= variable.card)).any():
        found = int(array[(array < UNOBSERVED) | (array >= variable.card)].flat[0])
        raise EvidenceError(_no_state(variable.name, found, variable.card))
    return array.astype(np.int64)


def _unmasked(variable: GroundVariable, value: np.ma.MaskedArray[Any, Any]) -> np.ndarray:
    mask, data = np.ma.getmaskarray(value), np.asarray(np.ma.getdata(value))
    states = np.full(data.shape, UNOBSERVED, np.int64)
    if not mask.all():
        states[~mask] = state_of(variable, data[~mask])
    return states


def _brief(value: Any) -> str:
    try:
        text = repr(value)
    except (RecursionError, ValueError):  # nested beyond reason, or an int of more digits than are written out
        return f"a {type(value).__name__}"
    return text if len(text) <= 60 else text[:57] + "..."


def _wrong(variable: GroundVariable, value: Any) -> EvidenceError:
    kind = "a number" if variable.edges is not None else "a state's name"
    return EvidenceError(f"evidence for {variable.name!r}: got {_brief(value)}; give {kind}, an Index, or one of them for each agent")


def _no_state(name: str, found: int, card: int) -> str:
    return f"evidence for {name!r}: {found} is no state; allowed are 0 to {card - 1}, -1 is not observed"


def read_hard(
    variables: Mapping[str, GroundVariable],
    names: Sequence[str],
    cards: np.ndarray,
    row: Mapping[str, int],
    evidence: Mapping[str, Any] | np.ndarray | None,
    batch: int,
) -> np.ndarray:
    """Evidence as an array of state indices.

    Parameters
    ----------
    variables : dict of str to GroundVariable
    names : sequence of str
        Order of the rows.
    cards : (V,) int array
    row : dict of str to int
    evidence : dict of name to value, or (V, W) int array, or None
    batch : int
        Number of agents.

    Returns
    -------
    (V, W) int array

    Raises
    ------
    EvidenceError
    """
    if isinstance(evidence, np.ndarray):
        if evidence.shape != (len(names), batch) or evidence.dtype.kind not in "iu":
            raise EvidenceError(
                f"an evidence array has shape (variables, agents) = {(len(names), batch)} and integers, got {evidence.shape}"
            )
        hard = evidence.astype(np.int64, copy=True)
    else:
        hard = np.full((len(names), batch), UNOBSERVED, np.int64)
        if evidence is not None and not isinstance(evidence, Mapping):
            raise EvidenceError(f"evidence is a mapping of variables to what was observed, got {_brief(evidence)}")
        items = () if _all_at_once(hard, variables, row, evidence) else (evidence or {}).items()
        for name, value in items:
            at = row.get(name)
            if at is None:
                raise EvidenceError(f"evidence for unknown variable {name!r}.{did_you_mean(name, names)}")
            state = state_of(variables[name], value)
            if isinstance(state, np.ndarray) and state.shape not in ((), (1,), (batch,)):
                raise EvidenceError(f"evidence for {name!r} has shape {state.shape} for {batch} agents")
            hard[at] = state
    bad = (hard < UNOBSERVED) | (hard >= cards[:, None])
    if bad.any():
        at, agent = (int(i) for i in np.argwhere(bad)[0])
        raise EvidenceError(_no_state(names[at], int(hard[at, agent]), int(cards[at])))
    return hard


def _all_at_once(
    hard: np.ndarray, variables: Mapping[str, GroundVariable], row: Mapping[str, int], evidence: Mapping[str, Any] | None
) -> bool:
    """Put in evidence that is rows of state indices, or whose values all are indices of named states; else do nothing."""
    if not evidence:
        return True
    if not all(map(row.__contains__, evidence)):
        return False
    rows = list(map(row.__getitem__, evidence))
    if isinstance(evidence, StateRows):
        if evidence.states.shape != (len(rows), hard.shape[1]):
            raise EvidenceError(f"state rows have shape {evidence.states.shape} for {len(rows)} variables and {hard.shape[1]} agents")
        hard[rows] = evidence.states
        return True
    values: list[Any] = []
    for name, value in evidence.items():
        if isinstance(value, Index):
            values.append(value.value)
        elif variables[name].edges is None:
            values.append(value)
        else:
            return False
    types = set(map(type, values))
    if types != {int} and types != {np.ndarray}:
        return False
    if types == {np.ndarray} and any(v.shape != (hard.shape[1],) or v.dtype != np.int64 for v in values):
        return False
    try:
        hard[rows] = np.array(values, np.int64).reshape(len(values), -1)
    except OverflowError:
        return False  # the message names the variable
    return True


def split_numbers(
    variables: Mapping[str, GroundVariable], evidence: Mapping[str, Any] | np.ndarray | None, batch: int
) -> tuple[dict[str, Any], dict[str, Numbers], dict[str, np.ndarray]]:
    """Evidence parted into states, readings of real numbers, and likelihoods of intervals of bins.

    Raises
    ------
    EvidenceError
    """
    if isinstance(evidence, np.ndarray):
        name = next(n for n, v in variables.items() if v.quantity is not None)
        raise EvidenceError(f"an array of evidence holds state indices; {name!r} is a real number: give a mapping")
    if evidence is not None and not isinstance(evidence, Mapping):
        raise EvidenceError(f"evidence is a mapping of variables to what was observed, got {_brief(evidence)}")
    rest: dict[str, Any] = {}
    numbers: dict[str, Numbers] = {}
    soft: dict[str, np.ndarray] = {}
    plain = plain_numbers(variables, evidence or {}, batch)
    numbers.update(plain)
    for name, value in (evidence or {}).items():
        if name in plain:
            continue
        variable = variables.get(name)
        if variable is not None and variable.quantity is not None:
            numbers[name] = read_numbers(variable, value, batch)
        elif variable is not None and isinstance(value, Interval):
            soft[name] = interval_likelihood(variable, value, batch)
        else:
            rest[name] = value
    return rest, numbers, soft


def read_soft(variables: Mapping[str, GroundVariable], soft: Mapping[str, Any] | None, batch: int) -> dict[str, np.ndarray]:
    """Likelihood vectors as arrays.

    Parameters
    ----------
    variables : dict of str to GroundVariable
    soft : dict of name to (card,) or (W, card) array, or None
    batch : int

    Returns
    -------
    dict of str to (W, card) float array

    Raises
    ------
    EvidenceError
        For an unknown name, a wrong shape, or a negative or non-finite likelihood.
    """
    if soft is not None and not isinstance(soft, Mapping):
        raise EvidenceError(f"soft evidence is a mapping of variables to likelihoods, got {_brief(soft)}")
    read = {}
    for name, value in (soft or {}).items():
        if name not in variables:
            raise EvidenceError(f"soft evidence for unknown variable {name!r}.{did_you_mean(name, variables)}")
        try:
            likelihood = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            raise EvidenceError(f"soft evidence for {name!r}: got {_brief(value)}; give one likelihood for each state") from None
        card = variables[name].card
        if likelihood.shape not in ((card,), (batch, card)):
            raise EvidenceError(f"soft evidence for {name!r} has shape {likelihood.shape}; give one likelihood for each of {card} states")
        if not np.isfinite(likelihood).all() or (likelihood < 0).any():
            raise EvidenceError(f"soft evidence for {name!r} has a likelihood that is negative or not finite: {likelihood.tolist()}")
        read[name] = np.broadcast_to(likelihood, (batch, card))
    return read


def one_hot(values: np.ndarray, card: int) -> np.ndarray:
    """(W, card) array with a one at each value, and a row of ones where nothing was observed (-1)."""
    out = np.ones((len(values), card))
    seen = np.flatnonzero(values >= 0)
    out[seen] = 0.0
    out[seen, values[seen]] = 1.0
    return out


def jeffrey_likelihood(name: str, predicted: np.ndarray, target: Any) -> np.ndarray:
    """The likelihood vectors that turn predicted marginals of a variable into given ones (Jeffrey's rule).

    Parameters
    ----------
    name : str
    predicted : (W, card) array
    target : (card,) or (W, card) array

    Returns
    -------
    (W, card) array

    Raises
    ------
    EvidenceError
        If the target is no distribution.
    ImpossibleEvidence
        If it has a state that the belief excludes.
    """
    q = np.asarray(target, dtype=np.float64)
    if q.shape not in (predicted.shape, predicted.shape[1:]) or (q < 0).any() or not np.allclose(q.sum(axis=-1), 1.0, atol=1e-9):
        raise EvidenceError(f"jeffrey: {name!r} needs a distribution over {predicted.shape[1]} states, got {q.tolist()}")
    q = np.broadcast_to(q, predicted.shape)
    if ((predicted <= 0) & (q > 0)).any():
        raise ImpossibleEvidence(f"jeffrey: {name!r} is to take a state that the belief excludes", conflict=(name,))
    return np.asarray(np.divide(q, predicted, out=np.zeros(q.shape), where=predicted > 0))
