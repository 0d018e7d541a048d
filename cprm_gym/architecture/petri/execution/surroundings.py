"""What comes to a running net from outside: observations, beliefs, objects."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ....errors import NetError, UnknownName, did_you_mean, unknown_name
from ..net.checks import shown
from ..net.places import ObjectPlace
from .compiled_net import UNBOUNDED, CompiledNet, PlaceKind
from .kernels import arrays
from .kernels import cycle as kernels
from .program import Layout
from .state import Objects, ObjectTable, Values

_MOST = sys.float_info.max


def numbers(value: Any, what: str) -> NDArray[np.float64]:
    """`value` as an array of numbers.

    Raises
    ------
    NetError
        When it is none.
    """
    try:
        return np.asarray(value, np.float64)
    except (TypeError, ValueError, OverflowError):
        raise _no_numbers(value, what) from None


def _no_numbers(value: Any, what: str) -> NetError:
    return NetError(f"{what} takes numbers, got {shown(value)}")


class Surroundings:
    """Writes what the world says into the state of an executor.

    Parameters
    ----------
    net : CompiledNet
    layout : Layout
        Where everything stands.
    state : arrays.State
        Written in place.
    batch : int
    failed : (2,) int64
        Where a kernel leaves what was wrong.
    """

    def __init__(self, net: CompiledNet, layout: Layout, state: arrays.State, batch: int, failed: NDArray[np.int64]) -> None:
        self.net = net
        self.layout = layout
        self.state = state
        self.batch = batch
        self.failed = failed
        self._tables: dict[tuple[str, tuple[str, ...]], list[tuple[int, int]] | None] = {}
        self._identity = np.arange(len(layout.beliefs), dtype=np.int32)

    def observe(self, inputs: Values) -> None:
        """Write observations into input places."""
        layout = self.layout
        if isinstance(inputs, Mapping):
            if self._all_at_once(inputs):
                return
            for name, value in inputs.items():
                if name not in layout.inputs:
                    raise unknown_name("input", name, layout.inputs)
                slots = layout.input_slots[layout.input_columns == layout.inputs.index(name)]
                self._set(name, slots, value)
            return
        self._write(inputs, "inputs", layout.inputs, layout.input_slots, layout.input_columns)

    def _all_at_once(self, inputs: Mapping[str, Any]) -> bool:
        """Write inputs that are all there as one array; False when there is anything to say about them."""
        layout = self.layout
        if len(inputs) != len(layout.inputs):
            return False
        values = np.empty((self.batch, len(layout.inputs)))
        try:
            for column, name in enumerate(layout.inputs):
                values[:, column] = inputs[name]
        except (KeyError, TypeError, ValueError, OverflowError):
            return False
        return self.observe_columns(values)

    def observe_columns(self, rows: NDArray[np.float64]) -> bool:
        """Write the inputs from an array of which they are the first columns; False at a number that is not finite."""
        return bool(kernels.write(self.state.row, self.layout.input_slots, self.layout.input_columns, rows, self.failed))

    def believe(self, beliefs: Values) -> None:
        """Write belief places."""
        layout = self.layout
        if isinstance(beliefs, Mapping):
            for name, value in beliefs.items():
                if name not in layout.beliefs:
                    raise unknown_name("belief place", name, layout.beliefs)
                self._set(name, layout.belief_slots[layout.beliefs.index(name)], value)
            return
        self._write(beliefs, "beliefs", layout.beliefs, layout.belief_slots, self._identity)

    def see(self, objects: Objects) -> None:
        """Write the attributes of objects."""
        layout = self.layout
        for name, given in objects.items():
            if name not in layout.attributes:
                raise unknown_name("class", name, layout.attributes)
            wanted = layout.attributes[name]
            if isinstance(given, ObjectTable) and self._see_table(name, given):
                continue
            for attribute in given:
                if attribute not in wanted and attribute != "present":
                    hint = f"{did_you_mean(attribute, wanted)} The net reads: {', '.join(wanted) or 'none'}."
                    raise UnknownName(f"unknown attribute {attribute!r} of class {name!r}.{hint}")
            missing = [attribute for attribute in wanted if attribute not in given]
            if missing:
                raise UnknownName(f"objects of class {name!r}: the net also reads {', '.join(map(repr, missing))}")
            if (name, "") not in layout.columns:
                continue
            size = layout.sizes[name]
            for attribute in wanted:
                values = numbers(given[attribute], f"attribute {attribute!r} of class {name!r}")
                if np.isinf(values).any():
                    raise NetError(f"objects of class {name!r}: attribute {attribute!r} holds an infinite number")
                self.block(name, attribute, size)[:] = self._fit(values, size, f"attribute {attribute!r} of class {name!r}")
            present = numbers(given.get("present", 1.0), f"'present' of class {name!r}")
            self.block(name, "", size)[:] = self._fit(present, size, f"'present' of class {name!r}")

    def _see_table(self, name: str, given: ObjectTable) -> bool:
        """Write all attributes of a class at once; False where there is anything to say about them."""
        size = self.layout.sizes.get(name, 0)
        key = name, given.names
        if key not in self._tables:
            wanted = self.layout.attributes[name]
            told = (*wanted, "present")
            fits = (name, "") in self.layout.columns and all(a in given.names for a in wanted) and all(a in told for a in given.names)
            names = ("", *wanted) if "present" in given.names else wanted
            self._tables[key] = [(given.names.index(a or "present"), self.layout.columns[name, a]) for a in names] if fits else None
        places = self._tables[key]
        if places is None or given.table.shape[1:] != (self.batch, size) or np.isinf(given.table).any():
            return False
        if "present" not in given.names:
            self.block(name, "", size)[:] = 1.0
        for k, column in places:
            self.state.data[:, column : column + size] = given.table[k]
        return True

    def block(self, class_name: str, attribute: str, size: int) -> NDArray[np.float64]:
        """(W, n) an attribute of the objects of a class; a view."""
        column = self.layout.columns[class_name, attribute]
        return self.state.data[:, column : column + size]

    def _fit(self, values: NDArray[np.float64], size: int, what: str) -> NDArray[np.float64]:
        if values.shape not in ((), (size,), (self.batch, size)):
            raise NetError(f"{what} must have shape ({size},) or ({self.batch}, {size}), got {values.shape}")
        return values

    def _write(self, data: Any, what: str, names: Sequence[str], slots: NDArray[np.int32], columns: NDArray[np.int32]) -> None:
        try:
            values = np.array(data, np.float64, order="C")  # a copy: one memory layout, so one compiled version
        except (TypeError, ValueError, OverflowError):
            raise _no_numbers(data, f"`{what}`") from None
        if values.shape != (self.batch, len(names)):
            if values.shape != (len(names),):
                raise NetError(f"`{what}` must have shape ({self.batch}, {len(names)}): {', '.join(names) or 'none'}; got {values.shape}")
            values = np.repeat(values[None], self.batch, axis=0)
        if not kernels.write(self.state.row, slots, columns, values, self.failed):
            copy, i = self.failed
            place, name = self.net.place_names[slots[i]], names[columns[i]]
            raise NetError(
                f"`{what}`: {name!r} (place {place!r}) of copy {copy} is {values[copy, columns[i]]}; a place holds finite numbers"
            )

    def _set(self, name: str, slots: Any, value: Any) -> None:
        if isinstance(value, (bool, int, float)):
            finite = -_MOST <= value <= _MOST
        else:
            value = numbers(value, repr(name))
            if value.shape not in ((), (1,), (self.batch,)):
                raise NetError(f"{name!r} takes a number or an array of shape ({self.batch},), got {value.shape}")
            finite = bool(np.isfinite(value).all())
            value = value[:, None] if value.ndim and slots.ndim else value
        if not finite:
            places = ", ".join(repr(self.net.place_names[s]) for s in np.atleast_1d(slots))
            raise NetError(f"{name!r} (place {places}) is {shown(value)}; a place holds finite numbers")
        self.state.row[:, slots] = value

    def write(self, place: str, value: ArrayLike, which: ArrayLike | None) -> None:
        """Set the marking of a place of some copies; see `Executor.write`."""
        p = self.net.place(place)
        kind = PlaceKind(int(self.net.kind[p]))
        values = numbers(value, f"place {place!r}")
        try:
            rows = np.arange(self.batch)[slice(None) if which is None else np.asarray(which)]
            values = np.broadcast_to(values, rows.shape)
        except (IndexError, ValueError):
            wanted = f"copies {shown(which)} of {self.batch}" if which is not None else f"{self.batch} copies"
            raise NetError(f"place {place!r}: one value or one for each of the {wanted}; got values of shape {values.shape}") from None
        if not np.isfinite(values).all():
            raise NetError(f"place {place!r} cannot hold {shown(value)}; a place holds finite numbers")
        if kind == PlaceKind.MATH:
            raise NetError(f"place {place!r} is set by its math transition {self.net.net.place(place)}")
        if kind in (PlaceKind.DISCRETE, PlaceKind.OBJECT) and (values != np.floor(values)).any():
            raise NetError(f"place {place!r} holds whole numbers, got {shown(value)}")
        if kind == PlaceKind.DISCRETE:
            capacity = int(self.net.capacity[p])
            if (values < 0).any() or (values > capacity).any():
                raise NetError(f"place {place!r} holds 0 to {'any' if capacity == UNBOUNDED else capacity} tokens, got {shown(value)}")
        if kind == PlaceKind.OBJECT:
            owner = self.net.net.places[p]
            assert isinstance(owner, ObjectPlace)
            size = self.layout.sizes.get(owner.class_name, 0)
            if (values < -1).any() or (size and (values >= size).any()):
                raise NetError(f"place {place!r} holds an object of {size}, -1 for none, got {shown(value)}")
            self.state.held[rows, self.layout.objects.index(place)] = values.astype(np.int32)
            values = (values >= 0).astype(np.float64)
        self.state.row[rows, p] = values
