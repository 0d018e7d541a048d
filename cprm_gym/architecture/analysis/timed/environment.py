"""The surroundings of a net: any observation, and for a behaviour module a caller who does everything that a caller may do.

The caller begins when the last run is over and its outcome was taken; takes the outcome at any later instant, or never; puts a token
into an interrupt at any instant, one at a time; puts tokens into further inputs (up to their capacity, one where there is none) and takes
them from further outputs whenever it likes. It may act between any two firings of the module.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ...petri import CompiledNet, ObjectPlace, PetriNet, Place, Transition, compile_net
from .system import TimedSystem, timed_system

IDLE, RUNNING = "caller idle", "caller waits"


def closed_system(
    net: PetriNet | CompiledNet,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    limit: int = 255,
    enough: Callable[[], bool] = lambda: False,
) -> TimedSystem:
    """The net with what its surroundings may do: a caller if it is a behaviour module, nothing but observations otherwise."""
    compiled = net if isinstance(net, CompiledNet) else compile_net(net)
    ports = compiled.net.ports
    if ports.begin and ports.ongoing and ports.outcomes:
        moves, extra = caller(compiled.net, ports.idle_interrupts == "consumed")
        return timed_system(compiled, moves, extra, bounds, limit, enough)
    return timed_system(compiled, bounds=bounds, limit=limit, enough=enough)


def caller(flat: PetriNet, idle_interrupts: bool) -> tuple[list[Transition], dict[str, int]]:
    """What a caller may do, as transitions of the outside, and the places that keep its books.

    Parameters
    ----------
    flat : PetriNet
        A behaviour module without modules in it.
    idle_interrupts : bool
        Also interrupt while the module is not ongoing.
    """
    ports = flat.ports
    assert ports.begin
    assert ports.ongoing
    extra = {IDLE: 1, RUNNING: 0, **{asked(i): 0 for i in ports.interrupts}}
    moves = [Transition("caller begins", (IDLE,), (RUNNING, ports.begin))]
    forget = {asked(i): 0 for i in ports.interrupts}
    moves += [Transition(f"caller takes {o}", (RUNNING, o), (IDLE,), sets=forget) for o in ports.outcomes]
    for i in ports.interrupts:
        moves.append(Transition(f"caller interrupts: {i}", (), (i, asked(i)), tests=(ports.ongoing,), inhibitors=(asked(i), i)))
        if idle_interrupts:
            moves.append(Transition(f"caller interrupts the idle module: {i}", (), (i,), inhibitors=(ports.ongoing, i)))
    own = {p.name: p for p in flat.places}
    for name in (*ports.inputs, *ports.parameters):
        place = own[name]
        if isinstance(place, Place):
            moves.append(Transition(f"outside puts {name}", (), (name,), inhibitors={name: place.capacity or 1}))
        elif isinstance(place, ObjectPlace) and place.select is None:
            moves += [
                Transition(f"outside puts {name}", (), (name,), inhibitors=(name,)),
                Transition(f"outside takes {name}", (name,), ()),
            ]
    for name in ports.outputs:
        if isinstance(own[name], (Place, ObjectPlace)):
            moves.append(Transition(f"outside takes {name}", (name,), ()))
    return moves, extra


def asked(interrupt: str) -> str:
    """The place of the caller's books that is marked from an interrupt that he gave until he takes the outcome."""
    return f"asked: {interrupt}"
