"""Nets for the tests of the structural analysis: families from the literature, and random ones."""

from __future__ import annotations

import random

from cprm_gym.architecture.petri import Belief, Input, Math, PetriNet, Place, Semantics, Transition


def kanban(n: int) -> PetriNet:
    """The Kanban system of Ciardo and Tilgner (1996): four cells, `n` tickets each."""
    places, transitions = [], []
    for i in (1, 2, 3, 4):
        places += [Place(f"m{i}"), Place(f"back{i}"), Place(f"kan{i}", tokens=n), Place(f"out{i}")]
        transitions += [
            Transition(f"redo{i}", (f"m{i}",), (f"back{i}",)),
            Transition(f"again{i}", (f"back{i}",), (f"m{i}",)),
            Transition(f"ok{i}", (f"m{i}",), (f"out{i}",)),
        ]
    transitions += [
        Transition("in1", ("kan1",), ("m1",)),
        Transition("synch1_23", ("out1", "kan2", "kan3"), ("kan1", "m2", "m3")),
        Transition("synch23_4", ("out2", "out3", "kan4"), ("kan2", "kan3", "m4")),
        Transition("out4", ("out4",), ("kan4",)),
    ]
    return PetriNet("kanban", tuple(places), tuple(transitions))


def philosophers(n: int, polite: bool = False) -> PetriNet:
    """Dining philosophers who take the left fork first; the `polite` one of them takes the right one first."""
    places = [Place(f"fork{i}", tokens=1) for i in range(n)]
    transitions = []
    for i in range(n):
        left, right = f"fork{i}", f"fork{(i + 1) % n}"
        if polite and i == 0:
            left, right = right, left
        places += [Place(f"thinks{i}", tokens=1), Place(f"waits{i}"), Place(f"eats{i}")]
        transitions += [
            Transition(f"first{i}", (f"thinks{i}", left), (f"waits{i}",)),
            Transition(f"second{i}", (f"waits{i}", right), (f"eats{i}",)),
            Transition(f"leave{i}", (f"eats{i}",), (f"thinks{i}", left, right)),
        ]
    return PetriNet("philosophers", tuple(places), tuple(transitions))


def producer(capacity: int | None) -> PetriNet:
    """A producer and a consumer around a buffer."""
    return PetriNet(
        "producer",
        (Place("idle", tokens=1), Place("busy"), Place("buffer", capacity=capacity), Place("hungry", tokens=1), Place("full")),
        (
            Transition("start", ("idle",), ("busy",)),
            Transition("produce", ("busy",), ("idle", "buffer")),
            Transition("consume", ("buffer", "hungry"), ("full",)),
            Transition("digest", ("full",), ("hungry",)),
        ),
    )


def random_net(seed: int, *, timed: bool = True, extended: bool = True, inputs: bool = True) -> PetriNet:
    """A random net of a few small places.

    Parameters
    ----------
    seed : int
    timed : bool
        With delays and priorities.
    extended : bool
        With test, inhibitor and set arcs.
    inputs : bool
        With an input, a belief and a math place that transitions read.
    """
    draw = random.Random(seed)
    names = [f"p{i}" for i in range(draw.randint(2, 5))]
    capacity = draw.choice([1, 2, 2, 3])
    places = [Place(n, capacity=capacity, tokens=draw.randint(0, min(1, capacity))) for n in names]
    real = []
    if inputs:
        real = ["seen", "bearing", "off"]
        places += [Input("seen"), Belief("bearing", "ball.direction"), Math("off", f"bearing + {names[0]}")]
    transitions = []
    for k in range(draw.randint(2, 6)):
        takes = {n: 1 for n in draw.sample(names, draw.randint(1, 2))}
        gives = {n: 1 for n in draw.sample(names, draw.randint(0, 2))}
        tests, inhibitors, sets = {}, {}, {}
        if extended and draw.random() < 0.4:
            tests[draw.choice(names)] = draw.randint(1, capacity)
        if extended and draw.random() < 0.4:
            inhibitors[draw.choice(names)] = draw.randint(1, capacity)
        if extended and draw.random() < 0.3:
            sets[draw.choice(names)] = draw.randint(0, capacity)
        for name in real:
            if draw.random() < 0.4:
                (tests if draw.random() < 0.5 else inhibitors)[name] = draw.choice([-1.0, 0.5, 2.0])
        delay = draw.choice([0, 1, 2, 3]) if timed else 0
        transitions.append(
            Transition(
                f"t{k}", takes, gives, tests=tests, inhibitors=inhibitors, sets=sets, delay=delay, set_wins=True,
                priority=draw.choice([0, 0, 1]) if timed else 0, memory=draw.choice(["enabling", "age", "resampling"]),
            )  # fmt: skip
        )
    semantics = Semantics(capacity=draw.choice(["strong", "weak"]), persistence=draw.choice(["intermediate", "atomic"]), max_firings=100)
    return PetriNet("random", tuple(places), tuple(transitions), semantics=semantics)
