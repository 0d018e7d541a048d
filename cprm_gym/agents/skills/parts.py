"""What the skills have in common: the standard interface, the answer to `abort`, and one command per cycle.

begin --> [start] --> ongoing + ready
ready --> [an action of the skill] --> acted --(one cycle, tick)--> ready
ready + ongoing --> [an outcome of the skill] --> its place
abort + ongoing --> [stop_...] --> aborted, the inside emptied by set arcs (Fig. 4.1);  abort while idle --> [ignore]
"""

from __future__ import annotations

from collections.abc import Sequence

from ...architecture.petri import Place, Ports, Transition


def interface(done: str, *errors: str, parameters: Sequence[str] = ()) -> Ports:
    """The ports of a skill: ``begin``, ``ongoing``, `done`, the errors with ``aborted`` last, and the interrupt ``abort``."""
    return Ports(begin="begin", ongoing="ongoing", done=done, errors=(*errors, "aborted"), interrupts=("abort",),
                 parameters=tuple(parameters))  # fmt: skip


def interface_places(ports: Ports, *inside: str) -> tuple[Place, ...]:
    """The discrete ports, and further places of capacity 1."""
    return tuple(Place(name, capacity=1) for name in (*ports.entries, *ports.exits, *inside))


def standard_transitions(
    states: Sequence[str] = ("ready", "acted"), counters: Sequence[str] = (), pace: bool = True
) -> tuple[Transition, ...]:
    """The transitions that every skill has.

    Parameters
    ----------
    states : sequence of str
        The places of which exactly one is marked while the skill works; the first is marked at the start.
    counters : sequence of str
        Set to 0 by an abort.
    pace : bool
        Whether there is ``acted``, which becomes ``ready`` a cycle later.
    """
    stops = tuple(
        Transition(f"stop_{state}", ("abort", "ongoing", state), ("aborted",), sets=dict.fromkeys(counters, 0), priority=9)
        for state in states
    )
    ticks = (Transition("tick", ("acted",), ("ready",), delay=1),) if pace else ()
    return (
        Transition("start", ("begin",), ("ongoing", states[0])),
        *stops,
        Transition("ignore", ("abort",), inhibitors=("ongoing", "begin"), priority=8),
        *ticks,
    )


def within_module(instance: str, outcomes: Sequence[str], running: str, counters: Sequence[str] = ()) -> tuple[Transition, ...]:
    """How a skill that works through a module answers `abort`: it aborts the module, and ends when the module has ended, however.

    Needs a place ``stopping_<instance>``. `outcomes` are those of the module, `running` is marked while it works; `counters` are
    set to 0.
    """
    stopping = f"stopping_{instance}"
    return (
        Transition(f"stop_{running}", ("abort", running), (stopping, f"{instance}.abort"), tests=("ongoing",), priority=9),
        *(
            Transition(
                f"stopped_{instance}_{outcome}",
                (stopping, "ongoing", f"{instance}.{outcome}"),
                ("aborted",),
                sets=dict.fromkeys(counters, 0),
                priority=2,
            )
            for outcome in outcomes
        ),
    )
