"""The executor: a net that runs, in any number of copies at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ....errors import NetError, NotEnabled, unknown_name
from ..net.net import PetriNet
from ..net.places import Belief
from .commands import Commands
from .compiled_net import CompiledNet, compile_net
from .failures import failure, missing_conditions, two_commands
from .kernels import arrays
from .kernels import cycle as kernels
from .kernels.bit_sets import width_of, words_of
from .program import build
from .state import Conflict, Objects, Snapshot, Values
from .surroundings import Surroundings
from .tracing import Trace


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

    One class because all of it works on the same arrays: running, writing, reading, snapshots, firing by hand and saying why not.

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
        timed = int((self.net.delay > 0).sum())
        self._state = arrays.State(
            row=np.zeros((w, layout.n_slots)),
            held=np.full((w, len(layout.objects)), -1, np.int32),
            clock=np.full((w, layout.n_clocks), arrays.OFF, np.int32),
            random=np.zeros(w, np.uint64),
            cycle=np.zeros(w, np.int64),
            data=np.full((w, layout.n_columns), np.nan),
        )
        self._out = arrays.Output(
            fired=np.zeros((w, len(layout.commands)), np.bool_),
            source=np.zeros((w, len(layout.commands)), np.int32),
            value=np.zeros((w, layout.n_parameters)),
            winner=np.full((w, len(layout.groups)), -1, np.int32),
            overruled=np.zeros((w, t), np.bool_),
        )
        self._scratch = arrays.Scratch(
            stack=np.zeros(layout.depth),
            score=np.zeros(max([1, *layout.sizes.values()])),
            conflict=np.zeros((256, 3), np.int64),
            counts=np.zeros(5, np.int64),
            loop=np.zeros(arrays.LOOP, np.int32),
            event=np.zeros((0, 4), np.int64),
            event_enabled=np.zeros((0, t), np.uint8),
            stale=np.zeros(words_of(len(layout.math)), np.int64),
            unsure=np.zeros(words_of(t), np.int64),
            due=np.zeros(width_of(timed), np.int64),
        )
        self._cache = arrays.new_cache(self._state.row, t, timed)
        self._failed = np.zeros(2, np.int64)
        self._surroundings = Surroundings(self.net, layout, self._state, w, self._failed)
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

    def parameters(self, command: str) -> Mapping[str, int]:
        """The columns of `sent` in which the parameters of a command stand."""
        if command not in self._layout.commands:
            raise unknown_name("command", command, self._layout.commands)
        return self._layout.parameters[command]

    @property
    def sent(self) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
        """The commands of the last cycle as arrays: (W, command names) whether each went out, and (W, .) all parameters; views."""
        return self._out.fired, self._out.value

    @property
    def held(self) -> NDArray[np.int32]:
        """(W, O) index of the object in each of `object_names`, -1 for none; a view that must not be written."""
        view = self._state.held[:]
        view.flags.writeable = False
        return view

    @property
    def conflicts(self) -> list[Conflict]:
        """Conflicts among transitions of equal priority met since the executor was made."""
        names = self.net.transition_names
        found = self._scratch.conflict[: self._scratch.counts[arrays.CONFLICTS]].tolist()
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
            self._surroundings.observe(inputs)
        if beliefs is not None:
            self._surroundings.believe(beliefs)
        if objects is not None:
            self._surroundings.see(objects)
        return self.run()

    def observe(self, inputs: Values) -> None:
        """Write observations into input places: the first part of `step`."""
        self._surroundings.observe(inputs)

    def observe_columns(self, rows: NDArray[np.float64]) -> bool:
        """`observe` from an array (W, at least len(input_names)) whose columns begin with the inputs; False where one is not finite."""
        return self._surroundings.observe_columns(rows)

    def believe(self, beliefs: Values) -> None:
        """Write belief places: the second part of `step`."""
        self._surroundings.believe(beliefs)

    def see(self, objects: Objects) -> None:
        """Write the attributes of objects: the third part of `step`."""
        self._surroundings.see(objects)

    def run(self) -> Commands:
        """The last part of `step`: selection, math, immediate transitions, clocks, timed transitions, commands."""
        if self.trace is not None:
            return self._run_traced(self.trace)
        status = self._cycle()
        if status != arrays.OK:
            raise self._failure(status)
        if self.strict and self._out.overruled.any():
            raise two_commands(self.net, self._program, self._layout, self._state, self._out)
        return self._commands

    def _cycle(self) -> int:
        return int(kernels.cycle(self._program, self._state, self._cache, self._out, self._scratch, self._failed))

    def _trace_room(self, room: int) -> None:
        """Make room for the events of one cycle."""
        enabled = np.zeros((room, self.net.n_transitions), np.uint8)
        self._scratch = self._scratch._replace(event=np.zeros((room, 4), np.int64), event_enabled=enabled)

    def _run_traced(self, trace: Trace) -> Commands:
        if not len(self._scratch.event):
            self._trace_room(1024)
        before = self.snapshot()
        conflicts = self._scratch.conflict.copy(), int(self._scratch.counts[arrays.CONFLICTS])
        while True:
            self._scratch.counts[arrays.EVENTS] = 0
            status = self._cycle()
            if status != arrays.FULL:
                break
            self.restore(before)
            self._scratch.conflict[:], self._scratch.counts[arrays.CONFLICTS] = conflicts
            self._trace_room(2 * len(self._scratch.event))
        count = self._scratch.counts[arrays.EVENTS]
        trace.add(before, self._scratch.event[:count], self._scratch.event_enabled[:count])
        if status != arrays.OK:
            raise self._failure(status)
        if self.strict and self._out.overruled.any():
            raise two_commands(self.net, self._program, self._layout, self._state, self._out)
        return self._commands

    # -- writing and reading --------------------------------------------------------------------------------------------------

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
        self._surroundings.write(place, value, which)

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
        state.clock[which] = arrays.OFF
        state.cycle[which] = 0
        state.data[which] = np.nan
        for name in self._layout.sizes:
            if (name, "") in self._layout.columns:
                self._surroundings.block(name, "", self._layout.sizes[name])[which] = 0.0
        if seed is not None:
            self._seed_streams(seed, which)
        if self.trace is not None and mask is None:
            self.trace.clear()

    def _seed_streams(self, seed: int | None, which: NDArray[np.bool_]) -> None:
        if self.net.net.semantics.choice == "random":
            streams = np.random.SeedSequence(seed).spawn(self.batch)
            self._state.random[which] = np.array([s.generate_state(1, np.uint64)[0] for s in streams])[which]

    def snapshot(self, copies: slice = slice(None)) -> Snapshot:
        """The whole state, or that of some copies, as plain arrays.

        Raises
        ------
        NetError
            When a copy is none of these.
        """
        self._check_copies(copies)
        return Snapshot(*(array[copies].copy() for array in self._state))

    def restore(self, snapshot: Snapshot, copies: slice = slice(None)) -> None:
        """Return to a state of this net with this number of copies, or put a snapshot of some into as many of these.

        Raises
        ------
        NetError
            When a copy is none of these, or the snapshot is another net's or of another number of copies.
        """
        self._check_copies(copies)
        arrays = [np.asarray(array) for array in snapshot]
        for name, mine, theirs in zip(Snapshot._fields, self._state, arrays):
            if theirs.shape != mine[copies].shape:
                raise NetError(f"snapshot: `{name}` must have shape {mine[copies].shape}, got {theirs.shape}")
        for mine, theirs in zip(self._state, arrays):
            mine[copies] = theirs

    def _check_copies(self, copies: object) -> None:
        try:
            np.arange(self.batch)[copies]  # type: ignore[call-overload]
        except (IndexError, TypeError, ValueError):
            raise NetError(f"`copies` are of 0 to {self.batch - 1}, as a slice, places or a mask, got {copies!r}") from None

    def replay(self, trace: Trace) -> None:
        """Run through the cycles that an executor of the same net and batch recorded, and check that the same happens.

        Each cycle starts from the state recorded before it; what external places were set to is part of that. The own trace is left as
        it is.

        Raises
        ------
        NetError
            At the first firing that differs.
        """
        mine = Trace(self.net.transition_names, self.net.delay.tolist(), self.net.priority.tolist())
        kept, self.trace = self.trace, mine
        try:
            for before, events in trace.cycles():
                self.restore(before)
                self.run()
                again = mine.last()
                if not np.array_equal(again, events):
                    now = mine.show(again)
                    raise NetError(f"replay differs in cycle {int(before.cycle[0])}: {trace.show(events)}, now {now}")
        finally:
            self.trace = kept

    # -- one transition by hand -----------------------------------------------------------------------------------------------

    def enabled(self, copy: int = 0) -> tuple[str, ...]:
        """Names of the transitions enabled in the marking of one copy, clocks aside."""
        self._check_copy(copy)
        return tuple(name for t, name in enumerate(self.net.transition_names) if not self._missing(t, copy))

    def fire(self, transition: str, copy: int = 0) -> None:
        """Fire one transition of one copy by hand, whatever its clock says.

        Raises
        ------
        NotEnabled
            The message says what each missing condition needs and has.
        """
        t = self.net.transition(transition)
        self._check_copy(copy)
        reasons = self._missing(t, copy)
        if reasons:
            raise NotEnabled(f"transition {transition!r} is not enabled: {'; '.join(reasons)}")
        scratch = self._scratch._replace(event=np.zeros((0, 4), np.int64))
        self._out.winner[copy] = -1
        status = kernels.fire_one(self._program, self._state, self._cache, self._out, scratch, copy, t)
        if status != arrays.OK:
            self._failed[:] = copy, self._scratch.counts[arrays.DETAIL]
            raise self._failure(status)

    def why_not(self, transition: str, copy: int = 0) -> list[str]:
        """What keeps a transition of one copy from firing: its conditions that do not hold, else how far its clock is.

        Returns
        -------
        list of str
            Such as ``["facing needs 1, has 0"]`` or ``["enabled, but its clock is at 3 of 5"]``; empty when nothing keeps it.
        """
        t = self.net.transition(transition)
        self._check_copy(copy)
        missing = self._missing(t, copy)
        delay = int(self.net.delay[t])
        if missing or not delay:
            return missing
        clocks = self.clocks(transition)[copy]
        if (clocks < 0).all():
            return [f"enabled, but its clock of {delay} cycles starts when the next cycle has become quiet"]
        return [f"enabled, but its clock is at {int(clocks.max())} of {delay}"] if clocks.max() < delay else []

    def clocks(self, transition: str) -> NDArray[np.int32]:
        """(W, servers) cycles that the clocks of a timed transition have counted, -1 for one that is off; a copy.

        A clock with age memory keeps what it has counted while its transition is disabled. An immediate transition has no clocks.
        """
        span = self._program.transitions[self.net.transition(transition)]
        raw = self._state.clock[:, span["clock"] : span["clock_end"]]
        return np.where(raw < arrays.OFF, -2 - raw, raw).astype(np.int32)

    def _missing(self, t: int, copy: int) -> list[str]:
        return missing_conditions(self.net, self._program, self._state.row[copy], t)

    def _check_copy(self, copy: int) -> None:
        if not (isinstance(copy, (int, np.integer)) and 0 <= copy < self.batch):
            raise NetError(f"`copy` is 0 to {self.batch - 1}, got {copy!r}")

    def _failure(self, status: int) -> Exception:
        copy, detail = (int(x) for x in self._failed)
        return failure(self.net, self._program, self._layout, self._state, self._scratch, status, copy, detail)
