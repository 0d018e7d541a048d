"""Set arcs compiled away: the equivalent net of Fig. 4.2.

A transition with set arcs loses them and instead puts a token into a *lock* and one into a *pending* place per set place. While
a place is pending, helper transitions of the highest priority drain or fill it, one token at a time, until it holds its value;
then its pending token goes. When none is pending, the lock opens. All this happens in one instant, and the lock inhibits every
other immediate transition meanwhile. Timed transitions need no inhibitor: none fires before the instant is over; and with one
their clocks would be forgotten, which a set arc does not do. (For the same reason the lock has no capacity; it never holds two.)

The helpers move each place straight from its old to its new value. A condition on the place that holds before and after
therefore holds all along, so clocks run on exactly as with the set arc. (Not so for a condition on a math place whose expression
is not monotone in a set place: it sees the values in between.)
"""

from __future__ import annotations

from dataclasses import replace

from ....errors import NetError
from .modules import flatten
from .net import PetriNet
from .places import AnyPlace, Place
from .transitions import Transition

LOCK = "set.lock"
"""Name of the place that holds a token while set values are being established."""


def eliminate_set_arcs(net: PetriNet) -> PetriNet:
    """A net without set arcs that behaves the same on the places of `net`, whenever the lock is open.

    Parameters
    ----------
    net : PetriNet
        Flattened first, if it has modules.

    Returns
    -------
    PetriNet
        `net` itself (flat) when it has no set arcs. Names of what is added start with ``set.``. The firings of what is added count
        towards ``Semantics(max_firings=...)``.

    Raises
    ------
    NetError
        When a name of `net` already starts with ``set.``.
    """
    flat = flatten(net)
    setters = [t for t in flat.transitions if t.sets]
    if not setters:
        return flat
    for part in (*flat.places, *flat.transitions):
        if part.name.startswith("set."):
            raise NetError(f"net {flat.name!r}: {part.name!r} has a name that the elimination of set arcs uses; rename it")
    top = 1 + max(t.priority for t in flat.transitions)
    places = [*flat.places, Place(LOCK)]
    transitions = []
    helpers: list[Transition] = []
    pending: list[str] = []
    for t in flat.transitions:
        arcs = _arcs_without_sets(flat, t)
        for place, value in t.sets.items():
            waiting = f"set.{t.name}.{place}"
            places.append(Place(waiting))
            pending.append(waiting)
            arcs["outputs"] |= {waiting: 1, LOCK: 1}
            helpers += _helpers(waiting, flat.place(place), value, top)
        if not t.is_timed:
            arcs["inhibitors"][LOCK] = 1
        transitions.append(replace(t, **arcs, sets={}, set_wins=False))  # type: ignore[arg-type]
    helpers.append(Transition("set.open", inputs=(LOCK,), inhibitors=tuple(pending), priority=top))
    return replace(flat, places=tuple(places), transitions=(*transitions, *helpers))


def _arcs_without_sets(net: PetriNet, t: Transition) -> dict[str, dict[str, float]]:
    """The arcs of `t`, those to set places reduced to their conditions: what they move is overwritten anyway."""
    arcs: dict[str, dict[str, float]] = {key: dict(getattr(t, key)) for key in ("inputs", "outputs", "tests", "inhibitors")}
    weak, atomic = net.semantics.capacity == "weak", net.semantics.persistence == "atomic"
    for name in t.sets:
        place = net.place(name)
        if not isinstance(place, Place):
            continue
        produced, back = arcs["outputs"].pop(name, 0), 0 if weak else t.inputs.get(name, 0)
        if place.capacity is not None and produced > back:
            full = place.capacity - produced + back + 1
            arcs["inhibitors"][name] = min(full, arcs["inhibitors"].get(name, full))
        if atomic and name in t.inputs:
            arcs["tests"][name] = max(arcs["inputs"].pop(name), arcs["tests"].get(name, 1))
    return arcs


def _helpers(waiting: str, place: AnyPlace, value: int, priority: int) -> list[Transition]:
    """Drain `place` while it holds more than `value`, fill it while it holds less, and stop at `value`."""
    name = place.name
    capacity = place.capacity if isinstance(place, Place) else 1
    found = []
    may_exceed = capacity is None or value < capacity
    if may_exceed:
        more = {name: value + 1} if value else {}
        found.append(Transition(f"{waiting}.drain", inputs=(name,), tests={waiting: 1, **more}, priority=priority))
    if value:
        less = {name: value}
        found.append(Transition(f"{waiting}.fill", outputs=(name,), tests=(waiting,), inhibitors=less, priority=priority))
    equal_tests = {name: value} if value else {}
    equal_inhibitors = {name: value + 1} if may_exceed else {}
    done = Transition(f"{waiting}.done", inputs=(waiting,), tests=equal_tests, inhibitors=equal_inhibitors, priority=priority)
    return [*found, done]
