"""Random nets with every feature, for the tests that compare two executions of one net."""

from __future__ import annotations

import numpy as np

from cprm_gym.architecture.petri import (
    INFINITE,
    Belief,
    Command,
    Continuous,
    Input,
    Math,
    ObjectPlace,
    PetriNet,
    Place,
    Selection,
    Semantics,
    Transition,
)

OBJECTS = {"Opponent": 4}


def random_net(rng: np.random.Generator, *, objects: bool = True, small: bool = False, random_choice: bool = True) -> PetriNet:
    """A small net in which things happen."""
    discrete = []
    for i in range(rng.integers(3, 5 if small else 8)):
        capacity = pick(rng, [1, 2, 3] if small else [1, 3, 6, 20])
        discrete.append(Place(f"p{i}", capacity=capacity, tokens=int(rng.integers(0, capacity + 1))))
    reals = [Input("i0", observes="o0"), Input("i1", observes="o1"), Input("i2", observes="o0"), Belief("b0", variable="v")]
    reals.append(Continuous("c0", 0.5))
    names = [p.name for p in discrete]
    held: list[ObjectPlace] = []
    if objects:
        k, smallest = int(rng.integers(1, 3)), bool(rng.integers(2))
        select = Selection("Opponent", "opponent.x - i0", where=pick(rng, ["", "opponent.y > b0"]), k=k, minimize=smallest)
        held = [ObjectPlace("s0", "Opponent", select), ObjectPlace("h0", "Opponent"), ObjectPlace("h1", "Opponent")]
    maths = [
        Math("m0", pick(rng, ["i0 * 2 - b0", f"{names[0]} + i1", "norm_deg(i0 * 100)", "abs(i0) % 1"])),
        Math("m1", pick(rng, [f"m0 + {names[1]}", "max(m0, i2)", f"hypot(m0, {names[2]})", "-m0 if m0 < 0 else m0"])),
    ]
    if objects:
        maths.append(Math("m2", pick(rng, ["h0.x + m1", "s0.y", "h1.x if h1 > 0 else 1"]), default=-1.0))
    readable = [p.name for p in (*reals, *maths)]
    movable = [p.name for p in held]
    transitions = [random_transition(rng, i, names, readable, movable) for i in range(rng.integers(5, 12))]
    semantics = Semantics(
        capacity=pick(rng, ["strong", "strong", "weak"]),
        persistence=pick(rng, ["intermediate", "intermediate", "atomic"]),
        choice=pick(rng, ["declared", "declared", "random"]) if random_choice else "declared",
        max_firings=60,
    )
    return PetriNet("random", (*discrete, *reals, *held, *maths), tuple(transitions), semantics=semantics)


def pick(rng: np.random.Generator, options):
    """One of the options."""
    return options[int(rng.integers(len(options)))]


def random_transition(rng, i: int, names: list[str], readable: list[str], held: list[str]) -> Transition:
    delay = int(rng.integers(1, 5)) if rng.random() < 0.75 else 0
    source, target = names[i % len(names)], pick(rng, names)  # tokens go round
    inputs = {source: 1} if rng.random() < 0.9 else {}
    outputs = {target: 1}
    for table in (inputs, outputs):
        if rng.random() < 0.3:
            table[pick(rng, names)] = 1
    tests: dict[str, float] = {}
    inhibitors: dict[str, float] = {}
    for table, chance in ((tests, 0.15), (inhibitors, 0.15)):
        if rng.random() < chance:
            table[str(rng.choice(names))] = 1
        if rng.random() < chance / 2:
            table[str(rng.choice(readable))] = float(np.round(rng.normal(), 1))
    if not inputs and not tests and not inhibitors:
        inhibitors[str(rng.choice(names))] = 1
    if held and rng.random() < 0.2:
        inputs[str(rng.choice(held))] = 1
        if rng.random() < 0.7:
            outputs[str(rng.choice(held[1:]))] = 1
    if held and rng.random() < 0.2:
        (tests if rng.random() < 0.5 else inhibitors)[str(rng.choice(held))] = 1
    set_to = {}
    if rng.random() < 0.15:
        set_to = {str(p): int(rng.integers(0, 2)) for p in rng.choice(names, size=rng.integers(1, 3), replace=False)}
        if held and rng.random() < 0.3:
            set_to["h0"] = 0
    emits = None
    if rng.random() < 0.4:
        emits = pick(rng, [Command("turn", moment="m0"), Command("kick", power="m1", to="h0" if held else 1.0), Command("say", what="p0")])
    memory = pick(rng, ["enabling", "enabling", "age", "resampling"])
    servers = pick(rng, [1, 1, 2, INFINITE])
    return Transition(
        f"t{i}", inputs, outputs, tests=tests, inhibitors=inhibitors, sets=set_to, delay=delay, priority=int(rng.integers(0, 3)),
        emits=emits, weight=float(rng.integers(1, 4)), memory=memory, servers=servers, set_wins=True,
    )  # fmt: skip


def random_world(rng: np.random.Generator) -> tuple[dict[str, float], dict[str, float], dict[str, dict[str, list[float]]]]:
    """Inputs, beliefs and objects of one copy in one cycle."""
    n = OBJECTS["Opponent"]
    inputs = {"o0": float(np.round(rng.normal(), 1)), "o1": float(rng.integers(0, 2))}
    x = np.round(rng.normal(size=n), 1)
    x[rng.random(n) < 0.2] = np.nan
    given = {
        "x": x.tolist(),
        "y": np.round(rng.normal(size=n), 1).tolist(),
        "present": rng.integers(0, 2, n).astype(float).tolist(),
    }
    return inputs, {"b0": float(np.round(rng.normal(), 1))}, {"Opponent": given}
