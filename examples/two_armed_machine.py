"""Two arms, one press, noisy eyes: a CPRM outside soccer.

    python examples/two_armed_machine.py [machines] [cycles]

Each arm waits for a part at its feeder, grips it (2 cycles), and presses it (3 cycles); there is one press for both arms. An eye at each
feeder is wrong now and then, and a grip at an empty feeder costs its time. The net runs both arms at once as two instances of
one module; the press is a place with one token. The model believes in parts that the eye only suggests; gripping is an input of the
model, because it takes the part away. The same net without belief grips whenever the eye says so.
"""

from __future__ import annotations

import argparse
from typing import NamedTuple

import numpy as np

from cprm_gym.architecture.cprm import CPRM, CPRMRunner, Observe
from cprm_gym.architecture.petri import Belief, Command, Input, PetriNet, Place, Ports, Transition
from cprm_gym.architecture.prm.model.cpds import Prior, Table
from cprm_gym.architecture.prm.model.model import Model
from cprm_gym.architecture.prm.model.schema import Attribute, Given, PRMClass, prev

ARRIVES, HIT, FALSE = 0.06, 0.8, 0.2
"""A part arrives at an empty feeder; the eye sees a part that is there; it sees one that is not."""
SURE = 0.9
"""Probability of a part from which the arm grips."""


# ---------------------------------------------------------------------- the world


class Percepts(NamedTuple):
    """What W machines tell, each (W,)."""

    left_eye: np.ndarray
    right_eye: np.ndarray
    left_holds: np.ndarray
    right_holds: np.ndarray


class Machines:
    """W machines with two feeders each; the truth is theirs alone."""

    def __init__(self, count: int, seed: int) -> None:
        self.draws = np.random.default_rng(seed)
        self.part = np.zeros((count, 2), bool)
        self.holds = np.zeros((count, 2), bool)
        self.pressed = np.zeros(count, int)
        self.empty_grips = np.zeros(count, int)

    def look(self) -> Percepts:
        """The eyes' readings and whether the arms hold something."""
        u = self.draws.random(self.part.shape)
        eye = np.where(self.part, u < HIT, u < FALSE).astype(float)
        return Percepts(eye[:, 0], eye[:, 1], self.holds[:, 0].astype(float), self.holds[:, 1].astype(float))

    def step(self, grip: np.ndarray, press: np.ndarray) -> None:
        """One cycle: ``grip`` and ``press`` (W, 2) say what each arm does."""
        taken = grip & self.part & ~self.holds
        self.empty_grips += (grip & ~self.part).sum(axis=1)
        self.holds |= taken
        self.part &= ~taken
        done = press & self.holds
        self.pressed += done.sum(axis=1)
        self.holds &= ~done
        self.part |= self.draws.random(self.part.shape) < ARRIVES


# ---------------------------------------------------------------------- the agent


def arm(side: str, sure: Belief | Input) -> PetriNet:
    """One arm as a module: it starts at `begin`, is done when a part is pressed, or reports an empty grip."""
    return PetriNet(
        f"{side}_arm",
        ports=Ports(
            begin="begin", ongoing="ongoing", done="pressed", errors=("empty",), inputs=("press_free",), outputs=("press_back", "queueing")
        ),
        places=(
            Place("begin", capacity=1), Place("ongoing", capacity=1), Place("pressed", capacity=1), Place("empty", capacity=1),
            Place("waiting", capacity=1), Place("gripped", capacity=1), Place("queueing", capacity=1), Place("pressing", capacity=1),
            Place("press_free", capacity=1), Place("press_back", capacity=1),
            sure, Input("holds", observes=f"{side}.holds"),
        ),
        transitions=(
            Transition("start", ("begin",), ("ongoing", "waiting")),
            Transition("grip", ("waiting",), ("gripped",), tests={sure.name: SURE}, delay=1, emits=Command(f"grip_{side}")),
            Transition("got_it", ("gripped",), ("queueing",), tests=("holds",), delay=1, priority=1),
            Transition("missed", ("gripped", "ongoing"), ("empty",), inhibitors=("holds",), delay=1),
            Transition("take_press", ("queueing", "press_free"), ("pressing",)),
            Transition("press", ("pressing", "ongoing"), ("pressed", "press_back"), delay=3, emits=Command(f"press_{side}")),
        ),
    )  # fmt: skip


def machine_net(believing: bool) -> PetriNet:
    """Both arms around one press; each begins again after its outcome."""
    arms = {}
    for side in ("left", "right"):
        sure: Belief | Input = Input("sure", observes=f"{side}.eye")
        if believing:
            sure = Belief("sure", variable=f"{side}.part", view="probability", state="yes")
        arms[side] = arm(side, sure)
    transitions = []
    for side in arms:
        transitions += [
            Transition(f"{side}_again", (f"{side}.pressed",), (f"{side}.begin",)),
            Transition(f"{side}_retry", (f"{side}.empty",), (f"{side}.begin",)),
            Transition(f"{side}_lend", ("press",), (f"{side}.press_free",), tests=(f"{side}.queueing",)),
            Transition(f"{side}_return", (f"{side}.press_back",), ("press",)),
            Transition(f"{side}_set_out", (f"{side}_rests",), (f"{side}.begin",)),
        ]
    places = (Place("press", capacity=1, tokens=1), Place("left_rests", capacity=1, tokens=1), Place("right_rests", capacity=1, tokens=1))
    return PetriNet("machine", places=places, modules=arms, transitions=tuple(transitions))


FEEDER = PRMClass(
    "Feeder",
    given=(Given("gripped", ("no", "yes"), default="no"),),
    attributes=(
        Attribute("part", ("no", "yes"), parents=(prev("part"), "gripped"), initial=Prior((1 - ARRIVES, ARRIVES)), cpd=Table({
            ("no", "*"): (1 - ARRIVES, ARRIVES),
            ("yes", "no"): (0.0, 1.0),
            ("yes", "yes"): (1 - ARRIVES, ARRIVES),
        })),
        Attribute("eye", ("no", "yes"), parents=("part",), cpd=Table({("no",): (1 - FALSE, FALSE), ("yes",): (1 - HIT, HIT)})),
    ),
)  # fmt: skip

BELIEVER = CPRM(
    "machine",
    net=machine_net(believing=True),
    model=Model("feeders", classes=(FEEDER,)),
    objects={"left": "Feeder", "right": "Feeder"},
    observations=(
        Observe("left.eye", "left.eye"), Observe("right.eye", "right.eye"),
        Observe("left.gripped", "left.gripped"), Observe("right.gripped", "right.gripped"),
    ),
)  # fmt: skip
"""Grips when a part is likely."""

GULLIBLE = CPRM("machine without belief", net=machine_net(believing=False))
"""Grips when the eye says so."""


def run(cprm: CPRM, machines: int, cycles: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """(parts pressed, empty grips) of each machine."""
    world, controller = Machines(machines, seed), CPRMRunner(cprm, machines)
    gripped = np.zeros((machines, 2))
    for _ in range(cycles):
        seen = world.look()
        commands = controller.step(
            {
                "left.eye": seen.left_eye, "right.eye": seen.right_eye, "left.holds": seen.left_holds, "right.holds": seen.right_holds,
                "left.gripped": gripped[:, 0], "right.gripped": gripped[:, 1],
            }
        )  # fmt: skip
        grip = np.stack([commands.fired["grip_left"], commands.fired["grip_right"]], axis=1)
        press = np.stack([commands.fired["press_left"], commands.fired["press_right"]], axis=1)
        gripped = grip.astype(float)
        world.step(grip, press)
    return world.pressed, world.empty_grips


def main() -> None:
    parser = argparse.ArgumentParser(description="Two arms, one press, noisy eyes: a CPRM outside soccer.")
    parser.add_argument("machines", type=int, nargs="?", default=200)
    parser.add_argument("cycles", type=int, nargs="?", default=400)
    options = parser.parse_args()
    machines, cycles = options.machines, options.cycles
    if min(machines, cycles) < 1:
        parser.error(f"machines {machines}, cycles {cycles}: allowed is 1 and more")
    print(f"{machines} machines, {cycles} cycles each")
    for cprm in (BELIEVER, GULLIBLE):
        pressed, empty = run(cprm, machines, cycles)
        share = empty.sum() / max(1, (empty + pressed).sum())
        print(f"{cprm.name:24s} {pressed.mean():6.1f} parts pressed (sd {pressed.std():.1f}), {100 * share:4.1f} % of grips empty")


if __name__ == "__main__":
    main()
