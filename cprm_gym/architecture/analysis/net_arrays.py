"""What the analysis sees of a net: plain arrays, one row per transition, one column per place.

`System` is the common ground of all structural methods: nets of the package, nets read from PNML and nets made up in a test all
become one. It knows ordinary, test, inhibitor and set arcs, capacities and priority groups; time and the environment live in
`timed/`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...errors import NetError, unknown_name
from ..petri import UNBOUNDED, Arcs, CompiledNet, ObjectPlace, PetriNet, compile_net

FREE = 0
"""In `System.inhibit`: no inhibitor arc."""
NEVER = -1
"""In `System.inhibit`: more is produced than the place can hold, so the transition is never enabled."""
KEEP = -1
"""In `System.sets`: no set arc. In `System.capacity`: no capacity."""


@dataclass(frozen=True, eq=False)
class System:
    """An untimed net as arrays.

    Attributes
    ----------
    places, transitions : tuple of str
        Names, P and T of them.
    marking : (P,) int64
        The initial marking.
    pre, post : (T, P) int32
        Weights of the input and output arcs.
    need : (T, P) int32
        Tokens that must be present: the larger of input and test arc.
    inhibit : (T, P) int32
        Enabled only while the place holds fewer tokens; 0 where there is no inhibitor arc. Capacities are in here too
        (a place of capacity K takes out - in tokens while it holds fewer than K - out + in + 1).
    sets : (T, P) int32
        Value a set arc writes, -1 where there is none.
    group : (T,) int64
        Transitions of a lower group pre-empt those of a higher one.
    preempts : (T,) bool
        Whether an enabled transition keeps later groups from firing; False for those whose enabledness hangs on the environment.
    """

    places: tuple[str, ...]
    transitions: tuple[str, ...]
    marking: np.ndarray
    pre: np.ndarray
    post: np.ndarray
    need: np.ndarray
    inhibit: np.ndarray
    sets: np.ndarray
    group: np.ndarray
    preempts: np.ndarray
    name: str = "net"
    capacity: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int64))

    @classmethod
    def from_arrays(
        cls,
        pre: np.ndarray,
        post: np.ndarray,
        marking: np.ndarray,
        *,
        places: tuple[str, ...] | None = None,
        transitions: tuple[str, ...] | None = None,
        test: np.ndarray | None = None,
        inhibit: np.ndarray | None = None,
        sets: np.ndarray | None = None,
        capacity: np.ndarray | None = None,
        priority: np.ndarray | None = None,
        weak_capacity: bool = False,
        name: str = "net",
    ) -> System:
        """A system from plain arrays; everything but the three first is optional.

        Parameters
        ----------
        pre, post : (T, P) int
        marking : (P,) int
        places, transitions : tuple of str, optional
            Names; ``p0``, ``p1``, ... and ``t0``, ``t1``, ... if absent.
        test, inhibit, sets : (T, P) int, optional
            Thresholds of test arcs (0: none) and inhibitor arcs (0: none), values of set arcs (-1: none).
        capacity : (P,) int, optional
            -1: none.
        priority : (T,) int, optional
            Higher first. If given, only the enabled transitions of the highest priority fire.
        weak_capacity : bool
            Count what a transition produces before it consumes.

        Raises
        ------
        NetError
            For shapes that do not fit, negative weights or an initial marking above a capacity.
        """
        pre = np.ascontiguousarray(pre, np.int32)
        post = np.ascontiguousarray(post, np.int32)
        marking = np.ascontiguousarray(marking, np.int64)
        t_count, p_count = pre.shape
        none = np.zeros((t_count, p_count), np.int32)
        test = none if test is None else np.ascontiguousarray(test, np.int32)
        inhibit = none.copy() if inhibit is None else np.array(inhibit, np.int32)
        sets = np.full((t_count, p_count), KEEP, np.int32) if sets is None else np.ascontiguousarray(sets, np.int32)
        capacity = np.full(p_count, KEEP, np.int64) if capacity is None else np.ascontiguousarray(capacity, np.int64)
        for what, array in (("post", post), ("test", test), ("inhibit", inhibit), ("sets", sets)):
            if array.shape != (t_count, p_count):
                raise NetError(f"net {name!r}: `{what}` must have shape {(t_count, p_count)}, got {array.shape}")
        if marking.shape != (p_count,) or capacity.shape != (p_count,):
            raise NetError(f"net {name!r}: `marking` and `capacity` must have shape {(p_count,)}, got {marking.shape}, {capacity.shape}")
        if min(a.min(initial=0) for a in (pre, post, test, inhibit, marking)) < 0:
            raise NetError(f"net {name!r}: weights, thresholds and tokens must not be negative")
        places = tuple(f"p{i}" for i in range(p_count)) if places is None else tuple(places)
        transitions = tuple(f"t{i}" for i in range(t_count)) if transitions is None else tuple(transitions)
        over = np.flatnonzero((capacity >= 0) & (marking > capacity))
        if len(over):
            p = over[0]
            raise NetError(f"net {name!r}, place {places[p]!r}: {marking[p]} tokens are above the capacity {capacity[p]}")
        _add_capacities(inhibit, pre, post, capacity, weak_capacity)
        if priority is None:
            group = np.zeros(t_count, np.int64)
        else:
            ranks = np.unique(np.asarray(priority, np.int64))
            group = len(ranks) - 1 - np.searchsorted(ranks, np.asarray(priority, np.int64))
        return cls(
            places, transitions, marking, pre, post, np.maximum(pre, test), inhibit, sets, group, np.ones(t_count, bool), name, capacity
        )

    @classmethod
    def from_net(cls, net: PetriNet | CompiledNet, *, timing: bool = False, initial_values: bool = False) -> System:
        """The untimed view of a net: discrete and object places; continuous, input and belief places may be anything.

        A guard on a place that may be anything leaves a transition enabled if some value satisfies all its guards on that
        place together. Timed transitions fire at any time unless an immediate one that hangs on no such guard is enabled.

        Parameters
        ----------
        net : PetriNet or CompiledNet
        timing : bool
            Let immediate transitions pre-empt timed ones, and higher priorities lower ones. Nets without timed transitions and
            priorities are the same either way.
        initial_values : bool
            Continuous, input, belief and math places keep their initial values instead of being anything, and no selection is made.
        """
        c = net if isinstance(net, CompiledNet) else compile_net(net)
        kept = np.flatnonzero(c.moved if initial_values else c.moved & ~selected_places(c))
        system = cls.from_arrays(
            _dense(c, c.inputs, kept, 0),
            _dense(c, c.outputs, kept, 0),
            c.initial[kept].astype(np.int64),
            places=tuple(c.place_names[p] for p in kept),
            transitions=c.transition_names,
            test=_dense(c, c.tests, kept, 0),
            inhibit=_dense(c, c.inhibitors, kept, FREE),
            sets=_dense(c, c.sets, kept, KEEP),
            capacity=np.where(c.capacity[kept] >= UNBOUNDED, KEEP, c.capacity[kept]),
            priority=np.where(c.delay == 0, c.priority + (1 << 40), 0) if timing else None,
            weak_capacity=c.net.semantics.capacity == "weak",
            name=c.net.name,
        )
        free = np.ones(c.n_places, bool)
        free[kept] = False
        for t in np.unique(np.concatenate([a.rows[free[a.place]] for a in (c.tests, c.inhibitors)])).tolist():
            least = {p: value for p, value in c.tests.of(t) if free[p]}
            below = {p: value for p, value in c.inhibitors.of(t) if free[p]}
            if initial_values:
                shut = any(c.initial[p] < v for p, v in least.items()) or any(c.initial[p] >= v for p, v in below.items())
                system.inhibit[t] = NEVER if shut else system.inhibit[t]
                continue
            if any(least.get(p, -np.inf) >= value for p, value in below.items()):
                system.inhibit[t] = NEVER
            system.preempts[t] = not (least or below)
        return system

    @property
    def incidence(self) -> np.ndarray:
        """``post - pre``, shape (T, P), int64; the columns of places that set arcs write say nothing for those transitions."""
        return self.post.astype(np.int64) - self.pre

    @property
    def pumpable(self) -> np.ndarray:
        """Places of which more tokens forbid nothing and are not overwritten, shape (P,) bool."""
        if self.group.any():
            return np.zeros(len(self.places), bool)
        return np.asarray(~((self.inhibit != FREE).any(axis=0) | (self.sets != KEEP).any(axis=0)))

    def place(self, name: str) -> int:
        """Column of the place `name`; `UnknownName` if there is none."""
        try:
            return self.places.index(name)
        except ValueError:
            raise unknown_name("place", name, self.places) from None

    def transition(self, name: str) -> int:
        """Row of the transition `name`; `UnknownName` if there is none."""
        try:
            return self.transitions.index(name)
        except ValueError:
            raise unknown_name("transition", name, self.transitions) from None

    def enabled(self, marking: np.ndarray) -> np.ndarray:
        """Which transitions may fire in `marking`, shape (T,), priorities included."""
        m = np.asarray(marking)
        free = (self.inhibit == FREE) | (m < self.inhibit)
        able = (m >= self.need).all(axis=1) & free.all(axis=1)
        if self.group.any() and able.any():
            stops = self.group[able & self.preempts]
            if len(stops):
                able &= self.group <= stops.min()
        return able

    def fire(self, t: int, marking: np.ndarray) -> np.ndarray:
        """The marking after transition `t`; its enabledness is the caller's business."""
        after = np.asarray(marking, np.int64) - self.pre[t] + self.post[t]
        return np.where(self.sets[t] != KEEP, self.sets[t], after)

    def run(self, sequence: tuple[str, ...]) -> list[np.ndarray]:
        """The markings along a firing sequence, from the initial one on: how every witness is checked.

        Raises
        ------
        NetError
            If a transition of the sequence is not enabled when its turn comes.
        """
        markings = [self.marking]
        for k, name in enumerate(sequence):
            t = self.transition(name)
            if not self.enabled(markings[-1])[t]:
                raise NetError(f"net {self.name!r}: firing {k} of the sequence, {name!r}, is not enabled")
            markings.append(self.fire(t, markings[-1]))
        return markings

    def describe(self, marking: np.ndarray) -> dict[str, int]:
        """The marked places of `marking` by name."""
        return {self.places[p]: int(marking[p]) for p in np.flatnonzero(np.asarray(marking))}


def _dense(c: CompiledNet, arcs: Arcs, kept: np.ndarray, nothing: int) -> np.ndarray:
    """Arcs of one kind as a table (T, len(kept)) int32; thresholds are rounded up, which is the same for whole tokens."""
    column = np.full(c.n_places, -1, np.int64)
    column[kept] = np.arange(len(kept))
    table = np.full((c.n_transitions, len(kept)), nothing, np.int32)
    there = column[arcs.place] >= 0
    table[arcs.rows[there], column[arcs.place[there]]] = np.ceil(arcs.value[there]).astype(np.int32)
    return table


def selected_places(c: CompiledNet) -> np.ndarray:
    """Object places that a selection sets every cycle: the environment's, shape (P,) bool."""
    return np.array([isinstance(p, ObjectPlace) and p.select is not None for p in c.net.places], bool)


def _add_capacities(inhibit: np.ndarray, pre: np.ndarray, post: np.ndarray, capacity: np.ndarray, weak: bool) -> None:
    """Write each capacity as inhibitor threshold of the transitions that may exceed it, in place.

    What a transition produces needs its room even where a set arc then overwrites it.
    """
    t, p = np.nonzero((post > 0) & (capacity >= 0))  # few of all pairs: large nets have millions
    gain = post[t, p].astype(np.int64) - (0 if weak else pre[t, p])
    exceeding = (gain > 0) | weak
    t, p, gain = t[exceeding], p[exceeding], gain[exceeding]
    room, held = np.maximum(capacity[p] - gain + 1, 0), inhibit[t, p]
    inhibit[t, p] = np.where(room == 0, NEVER, np.where(held == FREE, room, np.minimum(room, held)))
