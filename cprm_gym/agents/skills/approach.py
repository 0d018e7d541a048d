"""approach: go to a ball that lies still and stop beside it (dissertation Fig. 3.1).

begin -> orient --facing--> accelerate --distant--> cruise --close--> slow --there--> arrived
            |                  |   `------close--------------------->  ^
            |                  strayed, cruise.strayed, slow.strayed -> orient (at most TRIES times)
          failed -> failed
"""

from __future__ import annotations

from ...architecture.petri import PetriNet, Place, Transition
from ..body import Body, of_body
from .accelerate import accelerate
from .cruise import cruise
from .orient import orient
from .parts import interface, interface_places, within_module
from .slow import slow

TRIES = 3
"""Times that he begins anew after having strayed."""

_PORTS = interface("arrived", "failed")


@of_body
def approach(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``arrived``, ``failed`` and ``aborted``."""
    parts = {"orient": orient(body), "accelerate": accelerate(body), "cruise": cruise(body), "slow": slow(body)}
    return PetriNet(
        "approach",
        ports=_PORTS,
        places=(
            *interface_places(_PORTS, *(f"{name}s" for name in parts), *(f"stopping_{name}" for name in parts), "strayed"),
            Place("tries", capacity=TRIES),
        ),
        modules=parts,
        transitions=(
            Transition("start", ("begin",), ("ongoing", "orients", "orient.begin")),
            Transition("ignore", ("abort",), inhibitors=("ongoing", "begin"), priority=8),
            Transition("stop_strayed", ("abort", "ongoing", "strayed"), ("aborted",), sets={"tries": 0}, priority=9),
            *(t for name, part in parts.items() for t in within_module(name, part.ports.outcomes, f"{name}s", ("tries",))),
            Transition("run", ("orients", "orient.facing"), ("accelerates", "accelerate.begin"), priority=5),
            Transition("roll", ("accelerates", "accelerate.distant"), ("cruises", "cruise.begin"), priority=5),
            Transition("brake_soon", ("accelerates", "accelerate.close"), ("slows", "slow.begin"), priority=5),
            Transition("brake", ("cruises", "cruise.close"), ("slows", "slow.begin"), priority=5),
            Transition("finish", ("slows", "ongoing", "slow.there"), ("arrived",), sets={"tries": 0}, priority=5),
            Transition("cannot_face", ("orients", "ongoing", "orient.failed"), ("failed",), sets={"tries": 0}, priority=5),
            *(
                Transition(f"stray_{name}", (f"{name}s", f"{name}.strayed"), ("strayed",), priority=5)
                for name in ("accelerate", "cruise", "slow")
            ),
            Transition("try_again", ("strayed",), ("orients", "orient.begin", "tries"), inhibitors={"tries": TRIES}, delay=1),
            Transition("give_up", ("strayed", "ongoing"), ("failed",), tests={"tries": TRIES}, sets={"tries": 0}),
        ),
    )  # fmt: skip


APPROACH = approach()
"""Of a default player."""
