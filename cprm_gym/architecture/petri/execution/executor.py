"""The executor: a net that runs, in any number of copies at once."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ....errors import CommandError, ExpressionError, LivelockError, NetError, NotEnabled, UnknownName, did_you_mean, unknown_name
from ...expressions import Expression
from ..net.net import PetriNet
from ..net.places import Belief, ObjectPlace
from . import kernels
from .commands import Commands
from .compiled_net import UNBOUNDED, CompiledNet, PlaceKind, compile_net
from .program import build, capacity_limit
from .tracing import Firing, Trace

Values = ArrayLike | Mapping[str, ArrayLike]
"""An array with one column per name, or a mapping from names to numbers or (W,) arrays."""

Objects = Mapping[str, Mapping[str, ArrayLike]]
"""Class -> attribute -> values of its objects, (n,) for all copies alike or (W, n); attribute ``present`` is a mask."""


class Snapshot(NamedTuple):
    """The whole state of an executor; W copies."""

    row: NDArray[np.float64]  # (W, S) marking, then attributes of objects
    held: NDArray[np.int32]  # (W, object places) index of the object, -1 for none
    clock: NDArray[np.int32]  # (W, clocks)
    random: NDArray[np.uint64]  # (W,)
    cycle: NDArray[np.int64]  # (W,)
    data: NDArray[np.float64]  # (W, columns) attributes of all objects


class Conflict(NamedTuple):
    """Execution picked one of several legal behaviours: firing one transition disabled another of equal priority."""

    fired: str
    disabled: str
    times: int


class Executor:
    """Runs a net, cycle by cycle, for a batch of copies at once.

    Parameters
    ----------
    net : PetriNet or CompiledNet
    batch : int
        W, the number of copies; each has its own marking and clocks.
    objects : mapping, optional
        Class -> number of objects, for the classes of the net's object places whose attributes it reads.
    exclusive : sequence of sequences of command names
        Groups of which one command goes out per cycle: the one of the highest transition priority, at a tie the first that
        fired. Two commands of one name are always exclusive.
    strict : bool
        Raise `CommandError` instead of overruling.
    seed : int, optional
        Of the random choice among equal priorities, where the net's semantics ask for it; copy k draws the same whatever W.
    trace : bool
        Record every firing.

    Examples
    --------
    >>> from cprm_gym.architecture.petri import Place, PetriNet, Transition
    >>> net = PetriNet("two", (Place("a", tokens=1), Place("b")), (Transition("go", ("a",), ("b",), delay=2),))
    >>> executor = Executor(net)
    >>> for _ in range(3):
    ...     _ = executor.step()
    >>> executor.read("b")
    array([1.])
    """

    def __init__(
        self,
        net: PetriNet | CompiledNet,
        batch: int = 1,
        *,
        objects: Mapping[str, int] | None = None,
        exclusive: Sequence[Sequence[str]] = (),
        strict: bool = False,
        seed: int | None = None,
        trace: bool = False,
    ) -> None:
        if not (isinstance(batch, (int, np.integer)) and batch >= 1):
            raise NetError(f"`batch` is a whole number from 1, got {batch!r}")
        self.net = net if isinstance(net, CompiledNet) else compile_net(net)
        self.batch = int(batch)
        self.strict = strict
        self._program, self._layout = build(self.net, objects or {}, exclusive)
        w, layout, t = self.batch, self._layout, self.net.n_transitions
        self._state = kernels.State(
            row=np.zeros((w, layout.n_slots)),
            held=np.full((w, len(layout.objects)), -1, np.int32),
            clock=np.full((w, layout.n_clocks), kernels.OFF, np.int32),
            random=np.zeros(w, np.uint64),
            cycle=np.zeros(w, np.int64),
            data=np.full((w, layout.n_columns), np.nan),
        )
        self._out = kernels.Output(
            fired=np.zeros((w, len(layout.commands)), np.bool_),
            source=np.zeros((w, len(layout.commands)), np.int32),
            value=np.zeros((w, layout.n_parameters)),
            winner=np.full((w, len(layout.groups)), -1, np.int32),
            overruled=np.zeros((w, t), np.bool_),
        )
        self._scratch = kernels.Scratch(
            enabled=np.zeros(t, np.uint8),
            stack=np.zeros(layout.depth),
            score=np.zeros(max([1, *layout.sizes.values()])),
            conflict=np.zeros((256, 3), np.int64),
            counts=np.zeros(5, np.int64),
            loop=np.zeros(kernels.LOOP, np.int32),
            event=np.zeros((0, 4), np.int64),
            event_enabled=np.zeros((0, t), np.uint8),
        )
        self._failed = np.zeros(2, np.int64)
        self._identity = np.arange(len(layout.beliefs), dtype=np.int32)
        self._commands = self._views()
        self.trace = Trace(self.net.transition_names, self.net.delay.tolist(), self.net.priority.tolist()) if trace else None
        self.reset()
        self._seed_streams(seed, np.ones(w, np.bool_))

    def _views(self) -> Commands:
        out, layout = self._out, self._layout
        return Commands(
            fired={name: out.fired[:, c] for c, name in enumerate(layout.commands)},
            values={name: {key: out.value[:, q] for key, q in layout.parameters[name].items()} for name in layout.commands},
            source={name: out.source[:, c] for c, name in enumerate(layout.commands)},
            overruled=out.overruled,
        )

    # -- what there is --------------------------------------------------------------------------------------------------------

    @property
    def input_names(self) -> tuple[str, ...]:
        """The observed quantities: columns of the input array."""
        return self._layout.inputs

    @property
    def belief_names(self) -> tuple[str, ...]:
        """The belief places: columns of the belief array."""
        return self._layout.beliefs

    @property
    def belief_places(self) -> tuple[Belief, ...]:
        """The belief places, in the same order, with the variable and view of each."""
        return tuple(p for p in self.net.net.places if isinstance(p, Belief))

    @property
    def object_names(self) -> tuple[str, ...]:
        """The object places."""
        return self._layout.objects

    @property
    def attributes(self) -> Mapping[str, tuple[str, ...]]:
        """Class -> attributes of its objects that the net reads and `step` must be given."""
        return self._layout.attributes

    @property
    def command_names(self) -> tuple[str, ...]:
        """Commands that the net may emit."""
        return self._layout.commands

    @property
    def cycle(self) -> NDArray[np.int64]:
        """(W,) cycles run since the last reset; a copy."""
        return np.array(self._state.cycle)

    @property
    def marking(self) -> NDArray[np.float64]:
        """(W, P) marking of every place in the order of ``net.place_names``; a view that must not be written."""
        view = self._state.row[:, : self.net.n_places]
        view.flags.writeable = False
        return view

    @property
    def conflicts(self) -> list[Conflict]:
        """Conflicts among transitions of equal priority met since the executor was made."""
        names = self.net.transition_names
        found = self._scratch.conflict[: self._scratch.counts[kernels.CONFLICTS]].tolist()
        return [Conflict(names[t], names[u], times) for t, u, times in found]

    # -- the cycle ------------------------------------------------------------------------------------------------------------

    def step(self, inputs: Values | None = None, *, beliefs: Values | None = None, objects: Objects | None = None) -> Commands:
        """Run one cycle.

        Parameters
        ----------
        inputs : (W, len(input_names)) or mapping from observed quantity to number or (W,), optional
            What is not given keeps its value.
        beliefs : (W, len(belief_names)) or mapping from belief place to number or (W,), optional
        objects : mapping, optional
            Class -> attribute -> (n,) or (W, n). NaN: unknown.

        Returns
        -------
        Commands
            Views, overwritten by the next cycle.

        Raises
        ------
        UnknownName, NetError
            For a name or shape that does not fit, or a number that is not finite.
        LivelockError
            When immediate transitions go on without end; the message names the cycle of transitions.
        ExpressionError
            When a math place has no finite value.
        CommandError
            In strict mode, when two commands of one group are emitted.

        Notes
        -----
        After an error in the cycle itself every other copy has completed it; the copy that failed should be reset.
        """
        if inputs is not None:
            self.observe(inputs)
        if beliefs is not None:
            self.believe(beliefs)
        if objects is not None:
            self.see(objects)
        return self.run()

    def observe(self, inputs: Values) -> None:
        """Write observations into input places: the first part of `step`."""
        layout = self._layout
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
        layout = self._layout
        if len(inputs) != len(layout.inputs):
            return False
        values = np.empty((self.batch, len(layout.inputs)))
        try:
            for column, name in enumerate(layout.inputs):
                values[:, column] = inputs[name]
        except (KeyError, TypeError, ValueError):
            return False
        return bool(kernels.write(self._state.row, layout.input_slots, layout.input_columns, values, self._failed))

    def believe(self, beliefs: Values) -> None:
        """Write belief places: the second part of `step`."""
        layout = self._layout
        if isinstance(beliefs, Mapping):
            for name, value in beliefs.items():
                if name not in layout.beliefs:
                    raise unknown_name("belief place", name, layout.beliefs)
                self._set(name, layout.belief_slots[layout.beliefs.index(name)], value)
            return
        self._write(beliefs, "beliefs", layout.beliefs, layout.belief_slots, self._identity)

    def see(self, objects: Objects) -> None:
        """Write the attributes of objects: the third part of `step`."""
        layout = self._layout
        for name, given in objects.items():
            if name not in layout.attributes:
                raise unknown_name("class", name, layout.attributes)
            wanted = layout.attributes[name]
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
                values = np.asarray(given[attribute], np.float64)
                if np.isinf(values).any():
                    raise NetError(f"objects of class {name!r}: attribute {attribute!r} holds an infinite number")
                self._block(name, attribute, size)[:] = self._fit(values, size, f"attribute {attribute!r} of class {name!r}")
            present = np.asarray(given.get("present", 1.0), np.float64)
            self._block(name, "", size)[:] = self._fit(present, size, f"'present' of class {name!r}")

    def _block(self, class_name: str, attribute: str, size: int) -> NDArray[np.float64]:
        column = self._layout.columns[class_name, attribute]
        return self._state.data[:, column : column + size]

    def _fit(self, values: NDArray[np.float64], size: int, what: str) -> NDArray[np.float64]:
        if values.shape not in ((), (size,), (self.batch, size)):
            raise NetError(f"{what} must have shape ({size},) or ({self.batch}, {size}), got {values.shape}")
        return values

    def run(self) -> Commands:
        """The last part of `step`: selection, math, immediate transitions, clocks, timed transitions, commands."""
        if self.trace is not None:
            return self._run_traced(self.trace)
        status = kernels.cycle(self._program, self._state, self._out, self._scratch, self._failed)
        if status != kernels.OK:
            self._raise(status)
        if self.strict and self._out.overruled.any():
            self._raise_overruled()
        return self._commands

    def _trace_room(self, room: int) -> None:
        """Make room for the events of one cycle."""
        enabled = np.zeros((room, self.net.n_transitions), np.uint8)
        self._scratch = self._scratch._replace(event=np.zeros((room, 4), np.int64), event_enabled=enabled)

    def _run_traced(self, trace: Trace) -> Commands:
        if not len(self._scratch.event):
            self._trace_room(1024)
        before = self.snapshot()
        conflicts = self._scratch.conflict.copy(), int(self._scratch.counts[kernels.CONFLICTS])
        while True:
            self._scratch.counts[kernels.EVENTS] = 0
            status = kernels.cycle(self._program, self._state, self._out, self._scratch, self._failed)
            if status != kernels.FULL:
                break
            self.restore(before)
            self._scratch.conflict[:], self._scratch.counts[kernels.CONFLICTS] = conflicts
            self._trace_room(2 * len(self._scratch.event))
        count = self._scratch.counts[kernels.EVENTS]
        trace.add(before, self._scratch.event[:count], self._scratch.event_enabled[:count])
        if status != kernels.OK:
            self._raise(status)
        if self.strict and self._out.overruled.any():
            self._raise_overruled()
        return self._commands

    # -- writing and reading --------------------------------------------------------------------------------------------------

    def _write(self, data: Any, what: str, names: Sequence[str], slots: NDArray[np.int32], columns: NDArray[np.int32]) -> None:
        values = np.array(data, np.float64, order="C")  # a copy: one memory layout, so one compiled version
        if values.shape != (self.batch, len(names)):
            if values.shape != (len(names),):
                raise NetError(f"`{what}` must have shape ({self.batch}, {len(names)}): {', '.join(names) or 'none'}; got {values.shape}")
            values = np.repeat(values[None], self.batch, axis=0)
        if not kernels.write(self._state.row, slots, columns, values, self._failed):
            copy, i = self._failed
            place, name = self.net.place_names[slots[i]], names[columns[i]]
            raise NetError(
                f"`{what}`: {name!r} (place {place!r}) of copy {copy} is {values[copy, columns[i]]}; a place holds finite numbers"
            )

    def _set(self, name: str, slots: Any, value: Any) -> None:
        if isinstance(value, (bool, int, float)):
            finite = math.isfinite(value)
        else:
            value = np.asarray(value, np.float64)
            if value.shape not in ((), (1,), (self.batch,)):
                raise NetError(f"{name!r} takes a number or an array of shape ({self.batch},), got {value.shape}")
            finite = bool(np.isfinite(value).all())
            value = value[:, None] if value.ndim and slots.ndim else value
        if not finite:
            places = ", ".join(repr(self.net.place_names[s]) for s in np.atleast_1d(slots))
            raise NetError(f"{name!r} (place {places}) is {value}; a place holds finite numbers")
        self._state.row[:, slots] = value

    def read(self, place: str) -> NDArray[np.float64]:
        """(W,) marking of a place: tokens, value, or for an object place 1 and 0; a copy."""
        return np.array(self._state.row[:, self.net.place(place)])

    def holds(self, place: str) -> NDArray[np.int32]:
        """(W,) index of the object in an object place, -1 for none; a copy."""
        if place not in self._layout.objects:
            raise unknown_name("object place", place, self._layout.objects)
        return np.array(self._state.held[:, self._layout.objects.index(place)])

    def write(self, place: str, value: ArrayLike, which: ArrayLike | None = None) -> None:
        """Set the marking of a place from outside.

        Parameters
        ----------
        place : str
        value : number or one per copy
            Tokens within the capacity, a real value, or the index of an object (-1: none).
        which : indices or mask, optional
            Which copies; default all.
        """
        p = self.net.place(place)
        kind = PlaceKind(int(self.net.kind[p]))
        rows = slice(None) if which is None else np.asarray(which)
        values = np.asarray(value, np.float64)
        if not np.isfinite(values).all():
            raise NetError(f"place {place!r} cannot hold {value!r}; a place holds finite numbers")
        if kind == PlaceKind.MATH:
            raise NetError(f"place {place!r} is set by its math transition {self.net.net.place(place)}")
        if kind in (PlaceKind.DISCRETE, PlaceKind.OBJECT) and (values != np.floor(values)).any():
            raise NetError(f"place {place!r} holds whole numbers, got {value!r}")
        if kind == PlaceKind.DISCRETE:
            capacity = int(self.net.capacity[p])
            if (values < 0).any() or (values > capacity).any():
                raise NetError(f"place {place!r} holds 0 to {'any' if capacity == UNBOUNDED else capacity} tokens, got {value!r}")
        if kind == PlaceKind.OBJECT:
            owner = self.net.net.places[p]
            assert isinstance(owner, ObjectPlace)
            size = self._layout.sizes.get(owner.class_name, 0)
            if (values < -1).any() or (size and (values >= size).any()):
                raise NetError(f"place {place!r} holds an object of {size}, -1 for none, got {value!r}")
            self._state.held[rows, self._layout.objects.index(place)] = values.astype(np.int32)
            values = (values >= 0).astype(np.float64)
        self._state.row[rows, p] = values

    def reset(self, mask: ArrayLike | None = None, seed: int | None = None) -> None:
        """Bring copies back to the initial marking, clocks off.

        Parameters
        ----------
        mask : (W,) bool, optional
            Which copies; default all.
        seed : int, optional
            New seed of the random choice; without, the streams of the copies go on.
        """
        which = np.ones(self.batch, np.bool_) if mask is None else np.asarray(mask, np.bool_)
        if which.shape != (self.batch,):
            raise NetError(f"`mask` must have shape ({self.batch},), got {which.shape}")
        state = self._state
        state.row[which, : self.net.n_places] = self.net.initial
        state.row[which, self.net.n_places :] = np.nan
        state.held[which] = -1
        state.clock[which] = kernels.OFF
        state.cycle[which] = 0
        state.data[which] = np.nan
        for name in self._layout.sizes:
            if (name, "") in self._layout.columns:
                self._block(name, "", self._layout.sizes[name])[which] = 0.0
        if seed is not None:
            self._seed_streams(seed, which)
        if self.trace is not None and mask is None:
            self.trace.clear()

    def _seed_streams(self, seed: int | None, which: NDArray[np.bool_]) -> None:
        if self.net.net.semantics.choice == "random":
            streams = np.random.SeedSequence(seed).spawn(self.batch)
            self._state.random[which] = np.array([s.generate_state(1, np.uint64)[0] for s in streams])[which]

    def snapshot(self) -> Snapshot:
        """The whole state, as plain arrays."""
        return Snapshot(*(array.copy() for array in self._state))

    def restore(self, snapshot: Snapshot) -> None:
        """Return to a state of this net with this number of copies."""
        arrays = [np.asarray(array) for array in snapshot]
        for name, mine, theirs in zip(Snapshot._fields, self._state, arrays):
            if theirs.shape != mine.shape:
                raise NetError(f"snapshot: `{name}` must have shape {mine.shape}, got {theirs.shape}")
        for mine, theirs in zip(self._state, arrays):
            mine[...] = theirs

    # -- one transition by hand -----------------------------------------------------------------------------------------------

    def enabled(self, copy: int = 0) -> tuple[str, ...]:
        """Names of the transitions enabled in the marking of one copy, clocks aside."""
        return tuple(name for name in self.net.transition_names if not self.why_not(name, copy))

    def fire(self, transition: str, copy: int = 0) -> None:
        """Fire one transition of one copy by hand, whatever its clock says.

        Raises
        ------
        NotEnabled
            The message says what each missing condition needs and has.
        """
        t = self.net.transition(transition)
        reasons = self.why_not(transition, copy)
        if reasons:
            raise NotEnabled(f"transition {transition!r} is not enabled: {'; '.join(reasons)}")
        scratch = self._scratch._replace(event=np.zeros((0, 4), np.int64))
        self._out.winner[copy] = -1
        status = kernels.fire_one(self._program, self._state, self._out, scratch, copy, t)
        if status != kernels.OK:
            self._failed[:] = copy, self._scratch.counts[kernels.DETAIL]
            self._raise(status)

    def why_not(self, transition: str, copy: int = 0) -> list[str]:
        """What keeps a transition of one copy from being enabled; empty when it is enabled."""
        t = self.net.transition(transition)
        row = self._state.row[copy]
        consumed, produced = dict(self.net.inputs.of(t)), dict(self.net.outputs.of(t))
        reasons = []
        span = self._program.transitions[t]
        for place, _, low, high in self._program.conditions[span["cond"] : span["cond_end"]].tolist():
            name, has = self.net.place_names[place], row[place]
            if has < low:
                reasons.append(f"{name} needs {low:g}, has {has:g}")
            elif has >= high:
                full = high == capacity_limit(self.net, t, place, consumed, produced)
                reasons.append(f"{name} is full with {has:g}" if full else f"{name} must be below {high:g}, has {has:g}")
        return reasons

    # -- errors ---------------------------------------------------------------------------------------------------------------

    def _raise(self, status: int) -> None:
        copy, detail = (int(x) for x in self._failed)
        where = f"net {self.net.net.name!r}, copy {copy}, cycle {self._state.cycle[copy]}"
        if status == kernels.LIVELOCK:
            names = self.net.transition_names
            loop = _period(self._scratch.loop[: self._scratch.counts[kernels.LOOPED]].tolist())
            circle = " -> ".join(names[t] for t in [*loop, loop[0]])
            if len(loop) > 20:
                circle = f"among {', '.join(names[t] for t in dict.fromkeys(loop))}"
            most = self.net.net.semantics.max_firings
            raise LivelockError(f"{where}: more than {most} immediate firings without becoming quiet: {circle}")
        if status == kernels.CLOCKS:
            name = self.net.transition_names[detail]
            raise NetError(
                f"{where}: transition {name!r} has infinite servers and is enabled more often than it has clocks "
                f"({self._program.transitions['clock_end'][detail] - self._program.transitions['clock'][detail]}); "
                f"give its input places capacities"
            )
        place = self.net.math[detail]
        operands = ", ".join(f"{name} = {self._operand(name, copy):g}" for name in Expression(place.expression).names)
        what = f"math place {place.name!r} = {place.expression!r}"
        raise ExpressionError(f"{where}: {what} has no finite value at {operands or 'no operands'}")

    def _operand(self, name: str, copy: int) -> float:
        index = self.net.place_index.get(name)
        if index is not None:
            return float(self._state.row[copy, index])
        place, _, attribute = name.rpartition(".")
        owner = self.net.net.place(place)
        assert isinstance(owner, ObjectPlace)
        held = int(self.holds(place)[copy])
        return float(self._block(owner.class_name, attribute, self._layout.sizes[owner.class_name])[copy, held])

    def _raise_overruled(self) -> None:
        copy, loser = np.argwhere(self._out.overruled)[0]
        command, group = (int(self._program.transitions[key][loser]) for key in ("command", "group"))
        winner = int(self._out.winner[copy, group])
        names, commands = self.net.transition_names, self._layout.commands
        raise CommandError(
            f"net {self.net.net.name!r}, copy {copy}, cycle {self._state.cycle[copy] - 1}: two commands in one cycle, "
            f"{commands[winner]!r} of {names[self._out.source[copy, winner]]!r} and {commands[command]!r} of {names[loser]!r}"
        )


def _period(sequence: Sequence[int]) -> list[int]:
    """The shortest piece whose repetition ends `sequence`; all of it when there is none."""
    n = len(sequence)
    for length in range(1, n // 2 + 1):
        if all(sequence[n - 1 - i] == sequence[n - 1 - i - length] for i in range(n - length)):
            return list(sequence[n - length :])
    return list(sequence)


__all__ = ["Commands", "Conflict", "Executor", "Firing", "Snapshot", "Trace"]
