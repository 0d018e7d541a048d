"""Other versions of a net, broken on purpose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ...agents.worlds.stage import Change
from ...architecture.petri import Math, PetriNet
from ...errors import NetError

WRONG = {
    "approach": "moment", "catch_ball": "reachable", "go_to_ball": "moment", "pass_and_receive": "power", "pass_ball": "moment",
    "receive": "power",
}  # fmt: skip
"""Behaviour -> a math place in which a wrong sign breaks it."""


def negated(place: str) -> Change:
    """A version of a net in which a math place has the other sign, wherever it is called so: turns the wrong way, say.

    Raises
    ------
    NetError
        When no math place has that name.
    """

    def part(net: PetriNet) -> tuple[PetriNet, int]:
        hit = [isinstance(p, Math) and p.name == place for p in net.places]
        places = tuple(replace(p, expression=f"-({p.expression})") if h and isinstance(p, Math) else p for p, h in zip(net.places, hit))
        return replace(net, places=places), sum(hit)

    return _everywhere(part, f"math place {place!r}")


def without(transition: str) -> Change:
    """A version of a net that lacks a transition, wherever it is called so: forgets to answer, say.

    Raises
    ------
    NetError
        When no transition has that name.
    """

    def part(net: PetriNet) -> tuple[PetriNet, int]:
        kept = tuple(t for t in net.transitions if t.name != transition)
        return replace(net, transitions=kept), len(net.transitions) - len(kept)

    return _everywhere(part, f"transition {transition!r}")


def _everywhere(part: Callable[[PetriNet], tuple[PetriNet, int]], what: str) -> Change:
    """A change of a net and of all its modules."""

    def inside(net: PetriNet) -> tuple[PetriNet, int]:
        made, hits = part(net)
        modules = {}
        for name, module in made.modules.items():
            modules[name], more = inside(module)
            hits += more
        return replace(made, modules=modules), hits

    def change(net: PetriNet) -> PetriNet:
        made, hits = inside(net)
        if not hits:
            raise NetError(f"net {net.name!r} has no {what}")
        return made

    return change
