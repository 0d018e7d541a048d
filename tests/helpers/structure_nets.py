"""Nets for the tests of the structural analysis: families from the literature, and random ones."""

from __future__ import annotations

import random

from cprm_gym.architecture.petri import INFINITE, Belief, Input, Math, PetriNet, Place, Semantics, Transition


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


def random_net(seed: int, *, timed: bool = True, extended: bool = True, inputs: bool = True, immediate: bool = True) -> PetriNet:
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
    immediate : bool
        With immediate transitions.
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
        takes = dict.fromkeys(draw.sample(names, draw.randint(1, 2)), 1)
        gives = dict.fromkeys(draw.sample(names, draw.randint(0, 2)), 1)
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
        delay = draw.choice([0, 1, 2, 3] if immediate else [1, 2, 3]) if timed else 0
        transitions.append(
            Transition(
                f"t{k}",
                takes,
                gives,
                tests=tests,
                inhibitors=inhibitors,
                sets=sets,
                delay=delay,
                set_wins=True,
                priority=draw.choice([0, 0, 1]) if timed else 0,
                memory=draw.choice(["enabling", "age", "resampling"]),
                servers=draw.choice([1, 1, 2, INFINITE]),
            )
        )
    semantics = Semantics(capacity=draw.choice(["strong", "weak"]), persistence=draw.choice(["intermediate", "atomic"]), max_firings=100)
    return PetriNet("random", tuple(places), tuple(transitions), semantics=semantics)


def flexible_manufacturing(n: int) -> PetriNet:
    """The flexible manufacturing system of Ciardo and Trivedi (1993): three kinds of parts, `n` of each, three machines."""
    places: list[Place] = []
    transitions: list[Transition] = []
    for kind, machine, partner in (("1", "M1", "2"), ("2", "M2", "1")):
        p = f"P{kind}"
        places += [Place(p, tokens=n), *(Place(f"{p}{s}") for s in (f"w{machine}", machine, "d", "s", f"wP{partner}"))]
        transitions += [
            Transition(f"t{p}", (p,), (f"{p}w{machine}",)),
            Transition(f"t{machine}", (f"{p}w{machine}", machine), (f"{p}{machine}",)),
            Transition(f"t{p}{machine}", (f"{p}{machine}",), (f"{p}d", machine)),
            Transition(f"t{p}e", (f"{p}d",), (f"{p}s",)),
            Transition(f"t{p}j", (f"{p}d",), (f"{p}wP{partner}",)),
            Transition(f"t{p}s", (f"{p}s",), (p,)),
        ]
    places += [Place("P3", tokens=n), Place("P3M2"), Place("P3s"), *(Place(f"P12{s}") for s in ("", "wM3", "M3", "s"))]
    places += [Place("M1", tokens=3), Place("M2", tokens=1), Place("M3", tokens=2)]
    transitions += [
        Transition("tP3", ("P3",), ("P3M2",)),
        Transition("tP3M2", ("P3M2", "M2"), ("P3s", "M2")),
        Transition("tP3s", ("P3s",), ("P3",)),
        Transition("tx", ("P1wP2", "P2wP1"), ("P12",)),
        Transition("tP12", ("P12",), ("P12wM3",)),
        Transition("tM3", ("P12wM3", "M3"), ("P12M3",)),
        Transition("tP12M3", ("P12M3",), ("P12s", "M3")),
        Transition("tP12s", ("P12s",), ("P1", "P2")),
    ]
    return PetriNet("fms", tuple(places), tuple(transitions))


def token_ring(n: int) -> PetriNet:
    """Dijkstra's self-stabilising ring (1974): `n` + 1 processes copy their neighbour's value, the first counts on when all agree."""
    states = {(p, v): f"s{p}_{v}" for p in range(n + 1) for v in range(n + 1)}
    places = tuple(Place(name, tokens=int(p == v)) for (p, v), name in states.items())
    transitions = [
        Transition(f"count{v}", (states[0, v], states[n, v]), (states[0, (v + 1) % (n + 1)], states[n, v])) for v in range(n + 1)
    ]
    for p in range(1, n + 1):
        for v in range(n + 1):
            for w in range(n + 1):
                if v != w:
                    left = states[p - 1, w]
                    transitions.append(Transition(f"copy{p}_{v}_{w}", (states[p, v], left), (states[p, w], left)))
    return PetriNet("ring", places, tuple(transitions))


def landing_detector(n: int) -> PetriNet:
    """AirplaneLD of the Model Checking Contest, its instance `n`: does an aeroplane touch the ground?

    Two wheels' load, the altitude (2 n values) and two wheels' speed (n values) are sampled, any of its values each, and read in
    turn until one of them tells.
    """
    loads, heights, speeds = ("on", "off"), range(1, 2 * n + 1), range(1, n + 1)
    fast = set(range(n // 2 + 1, n))
    sensors = (
        ("load_left", "load", loads, {"on"}),
        ("load_right", "load", loads, {"on"}),
        ("height", "height", heights, set(range(1, n))),
        ("speed_left", "speed", speeds, fast),
        ("speed_right", "speed", speeds, fast),
    )
    places = [
        Place(f"{source}_{v}", tokens=1) for source, values in (("load", loads), ("height", heights), ("speed", speeds)) for v in values
    ]
    places += [Place("stage_1", tokens=1), *(Place(f"stage_{k}") for k in range(2, len(sensors) + 1)), Place("over")]
    places += [Place("ground"), Place("air")]
    transitions = []
    for k, (sensor, source, values, telling) in enumerate(sensors, 1):
        places.append(Place(f"{sensor}_waits", tokens=1))
        for v in values:
            places.append(Place(f"{sensor}_read_{v}"))
            transitions.append(
                Transition(f"sample_{sensor}_{v}", (f"{sensor}_waits", f"{source}_{v}"), (f"{source}_{v}", f"{sensor}_read_{v}"))
            )
            after = ("over", "ground") if v in telling else (f"stage_{k + 1}",) if k < len(sensors) else ("over", "air")
            transitions.append(Transition(f"judge_{sensor}_{v}", (f"{sensor}_read_{v}", f"stage_{k}"), after))
    return PetriNet("landing_detector", tuple(places), tuple(transitions))
