"""What was observed, checked: from names and values as a user gives them to arrays of state indices.

An observation is a state index, a state's name, or a number that falls in a bin, for one agent or for all of them; -1 or None
means not observed. Everything else is refused by the variable's name: a NaN, a value outside the bins, an index that is no
state, a name that is no variable.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ....errors import EvidenceError, did_you_mean
from ..grounding.slices import GroundVariable

UNOBSERVED = -1


class Readings(NamedTuple):
    """The evidence of one slice.

    Attributes
    ----------
    hard : (V, W) int array
        State of each variable for each agent; -1 where not observed.
    soft : dict of str to (W, card) float array
        Likelihood vectors (Pearl): any scale, the scale only changes the log-likelihood.
    """

    hard: np.ndarray
    soft: dict[str, np.ndarray]

    def extended(self, count: int) -> Readings:
        """The readings with unobserved variables added at the end, `count` in all."""
        missing = count - len(self.hard)
        return self._replace(hard=np.pad(self.hard, ((0, missing), (0, 0)), constant_values=UNOBSERVED)) if missing else self

    def rows(self, agents: np.ndarray) -> Readings:
        """The readings of some agents."""
        return Readings(self.hard[:, agents], {name: likelihood[agents] for name, likelihood in self.soft.items()})


def bin_of(variable: GroundVariable, values: np.ndarray) -> np.ndarray:
    """Bins that numbers fall in.

    Parameters
    ----------
    variable : GroundVariable
        With edges.
    values : float array
        In the unit of the edges. Bin k holds ``edges[k] <= x < edges[k + 1]``, the last bin its upper edge too; a circular
        variable takes any finite value, and so does one that clips.

    Raises
    ------
    EvidenceError
        For a NaN or infinite value, or one outside the bins.
    """
    if variable.edges is None:
        raise EvidenceError(
            f"evidence for {variable.name!r}: got the number {values.flat[0]!r}, but its states are names: {_shown(variable)}"
        )
    if not np.isfinite(values).all():
        raise EvidenceError(f"evidence for {variable.name!r}: {values[~np.isfinite(values)].flat[0]} is not a finite number")
    edges = np.asarray(variable.edges, dtype=np.float64)
    if variable.circular:
        values = edges[0] + np.mod(values - edges[0], edges[-1] - edges[0])
    if variable.clip:
        values = np.clip(values, edges[0], edges[-1])
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
    value : int, str, float, None, or array of int or float, possibly masked
        An array has one entry for each agent. Masked entries are unobserved.

    Raises
    ------
    EvidenceError
        If the value is none of these or no state.
    """
    if value is None:
        return UNOBSERVED
    if isinstance(value, str):
        if value not in variable.states:
            hint = did_you_mean(value, variable.states)
            raise EvidenceError(f"evidence for {variable.name!r}: unknown state {value!r}.{hint} Known: {_shown(variable)}")
        return variable.states.index(value)
    array = np.asarray(value)
    if array.ndim and array.dtype.kind in "OUS":
        return np.array([state_of(variable, v) for v in array.ravel()], np.int64).reshape(array.shape)
    mask = np.ma.getmaskarray(value) if isinstance(value, np.ma.MaskedArray) else None
    if mask is not None:
        states = np.full(array.shape, UNOBSERVED, np.int64)
        seen = np.asarray(np.ma.getdata(value))[~mask]
        if seen.size:
            states[~mask] = state_of(variable, seen)
        return states
    if array.dtype.kind == "f":
        return bin_of(variable, np.atleast_1d(array)).reshape(array.shape)
    if array.dtype.kind not in "iub":
        raise EvidenceError(f"evidence for {variable.name!r}: got {value!r}; give a state index, a state's name or a number")
    return array.astype(np.int64)


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
        items = () if _all_at_once(hard, row, evidence) else (evidence or {}).items()
        for name, value in items:
            at = row.get(name)
            if at is None:
                raise EvidenceError(f"evidence for unknown variable {name!r}.{did_you_mean(name, names)}")
            if type(value) is int:
                hard[at] = value
                continue
            state = state_of(variables[name], value)
            if isinstance(state, np.ndarray) and state.shape not in ((), (1,), (batch,)):
                raise EvidenceError(f"evidence for {name!r} has shape {state.shape} for {batch} agents")
            hard[at] = state
    bad = (hard < UNOBSERVED) | (hard >= cards[:, None])
    if bad.any():
        at, agent = (int(i) for i in np.argwhere(bad)[0])
        raise EvidenceError(
            f"evidence for {names[at]!r}: {hard[at, agent]} is no state; allowed are 0 to {cards[at] - 1}, -1 is not observed"
        )
    return hard


def _all_at_once(hard: np.ndarray, row: Mapping[str, int], evidence: Mapping[str, Any] | None) -> bool:
    """Put in evidence that is all plain integers, or all integer arrays with one entry for each agent; else do nothing."""
    if not evidence:
        return True
    types = set(map(type, evidence.values()))
    if (types != {int} and types != {np.ndarray}) or not all(map(row.__contains__, evidence)):
        return False
    values = list(evidence.values())
    if types == {np.ndarray} and any(v.shape != (hard.shape[1],) or v.dtype != np.int64 for v in values):
        return False
    hard[list(map(row.__getitem__, evidence))] = np.array(values, np.int64).reshape(len(values), -1)
    return True


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
    read = {}
    for name, value in (soft or {}).items():
        if name not in variables:
            raise EvidenceError(f"soft evidence for unknown variable {name!r}.{did_you_mean(name, variables)}")
        likelihood = np.asarray(value, dtype=np.float64)
        card = variables[name].card
        if likelihood.shape not in ((card,), (batch, card)):
            raise EvidenceError(f"soft evidence for {name!r} has shape {likelihood.shape}; give one likelihood for each of {card} states")
        if not np.isfinite(likelihood).all() or (likelihood < 0).any():
            raise EvidenceError(f"soft evidence for {name!r} has a likelihood that is negative or not finite: {likelihood.tolist()}")
        read[name] = np.broadcast_to(likelihood, (batch, card))
    return read
