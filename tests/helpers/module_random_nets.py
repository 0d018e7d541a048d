"""Random nets with observations, math over one observation, clocks, priorities, modules begun and interrupted, fused ports."""

from __future__ import annotations

import random

from cprm_gym.architecture.petri import Command, Input, Math, PetriNet, Place, Ports, Semantics, Transition

EXPRESSIONS = (
    "1 if d < 2 else 0", "1 if d < 1 else 0", "abs(d)", "d / 2", "d - 1", "-d", "d * d", "floor(d)", "max(d, 1)", "clip(d, 0, 2)",
    "d - e", "hypot(d, e)", "max(d, e)", "1 if d < e else 0", "d + {token}", "{token} * d", "1 if {token} > 0 and d < 2 else 0",
    "1 / d if d > 0 else 0",
)  # fmt: skip
OVER_MATH = ("1 if {m} < 1 else 0", "{m} + d", "abs({m})", "2 - {m}")
THRESHOLDS = (-1.0, 0.0, 0.5, 1.0, 2.0)
GRID = (-9.0, -3.0, -1.5, -1.25, -1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0, 4.5, 9.0)
"""Values of observations that are tried."""


def random_module(draw: random.Random, name: str = "module", interrupts: bool | None = None) -> PetriNet:
    """A behaviour module, well made or not."""
    abort = draw.random() < 0.5 if interrupts is None else interrupts
    names = ["begin", "ongoing", "done", "failed", *(["abort"] if abort else []), *(["inside"] if draw.random() < 0.6 else [])]
    places = [Place(p, capacity=draw.choice((1, 1, 1, 2, None)) if p == "inside" else 1) for p in names]
    places += _observed(draw, names)
    real = [p.name for p in places if not isinstance(p, Place)]
    forgets = {"inside": 0} if "inside" in names and draw.random() < 0.4 else {}
    hesitates = draw.random()
    late = {"delay": 1} if hesitates < 0.06 else _guard(draw, real, names, 0.8) if hesitates < 0.15 else {}
    transitions = [Transition("start", ("begin",), ("ongoing",), sets=forgets, **late)]
    for k, outcome in enumerate(("done", "failed")):
        guard = _guard(draw, real, names) if draw.random() < 0.8 else {}
        sets = {"inside": 0} if "inside" in names and draw.random() < 0.6 else {}
        transitions.append(_transition(draw, f"end{k}", ("ongoing",), (outcome,), sets=sets, **guard))
    if abort:
        transitions.append(_transition(draw, "stop", ("abort", "ongoing"), ("failed",), priority=draw.choice((0, 2))))
        if draw.random() < 0.7:
            transitions.append(Transition("drop", ("abort",), (), inhibitors=("ongoing",)))
    if "inside" in names and draw.random() < 0.15:  # by itself
        transitions.append(_transition(draw, "stir", (), ("inside",), inhibitors={"inside": 1}, delay=draw.choice((1, 2))))
    for k in range(draw.randint(0, 2)):
        takes = draw.sample(["ongoing", *(["inside"] if "inside" in names else [])], 1)
        gives = {*takes, *(["inside"] if "inside" in names and draw.random() < 0.5 else [])} if draw.random() < 0.8 else set()
        emits = Command(draw.choice(("dash", "kick", "say"))) if draw.random() < 0.6 else None
        transitions.append(_transition(draw, f"act{k}", tuple(takes), tuple(sorted(gives)), emits=emits, **_guard(draw, real, names)))
    return PetriNet(
        name,
        tuple(places),
        tuple(transitions),
        ports=Ports(
            begin="begin", ongoing="ongoing", done="done", errors=("failed",), interrupts=("abort",) if abort else (),
            within=draw.choice((1, 1, 2)), idle_interrupts=draw.choice(("consumed", "kept")),
        ),
        semantics=_semantics(draw),
    )  # fmt: skip


def random_user(draw: random.Random) -> PetriNet:
    """A net around one or two modules: calls them in turn, at once, too early, kills them; or fuses a port with a place of its own."""
    modules = {n: random_module(draw, n) for n in ("a", "b")[: draw.choice((1, 2, 2))]}
    semantics = _semantics(draw)
    modules = {n: PetriNet(m.name, m.places, m.transitions, ports=m.ports, semantics=semantics) for n, m in modules.items()}
    own = ["idle", "x"]
    places = [Place("idle", capacity=1, tokens=1), Place("x", capacity=draw.choice((1, 2)), tokens=draw.choice((0, 0, 1)))]
    places += _observed(draw, own)
    real = [p.name for p in places if not isinstance(p, Place)]
    fuse: dict[str, str] = {}
    first = next(iter(modules))
    if draw.random() < 0.25:
        port = draw.choice(("begin", "done", "ongoing"))
        places.append(Place("shared", capacity=1))
        fuse[f"{first}.{port}"] = "shared"
        own.append("shared")

    def port(name: str) -> str:
        return fuse.get(name, name)

    begins = [port(f"{n}.begin") for n in modules]
    transitions = [_transition(draw, "call", ("idle",), tuple(begins if draw.random() < 0.6 else begins[:1]), **_guard(draw, real, own))]
    for n, module in modules.items():
        for outcome in module.ports.outcomes:
            if draw.random() < 0.85:
                following = [b for b in begins if draw.random() < 0.3] or ["idle"]
                taken = port(f"{n}.{outcome}")
                transitions.append(_transition(draw, f"{n} {outcome}", (taken,), tuple(following), **_guard(draw, real, own, 0.3)))
        if module.ports.interrupts and draw.random() < 0.7:
            tests = {port(f"{n}.ongoing"): 1} if draw.random() < 0.7 else {}
            guard = _guard(draw, real, own, 0.7)
            guard["tests"] = {**guard["tests"], **tests}
            transitions.append(_transition(draw, f"{n} abort", ("x",), (f"{n}.abort",), **guard))
        if draw.random() < 0.15:
            transitions.append(_transition(draw, f"{n} kill", (port(f"{n}.ongoing"),), ("idle",), delay=1))
    if draw.random() < 0.5:
        transitions.append(_transition(draw, "more", (), ("x",), inhibitors={"x": 1}, delay=draw.choice((1, 2))))
    if "shared" in own and draw.random() < 0.5:
        transitions.append(_transition(draw, "own", ("shared",), draw.choice(((), ("idle",), ("shared",)))))
    return PetriNet("user", tuple(places), tuple(transitions), modules=modules, fuse=fuse, semantics=semantics)


def random_plain(draw: random.Random) -> PetriNet:
    """A net without modules."""
    names = [f"p{k}" for k in range(draw.randint(2, 4))]
    places = [Place(n, capacity=draw.choice((1, 1, 2, 2, None)), tokens=draw.choice((0, 1))) for n in names]
    places += _observed(draw, names)
    real = [p.name for p in places if not isinstance(p, Place)]
    transitions = []
    for k in range(draw.randint(2, 6)):
        takes, gives = draw.sample(names, draw.choice((1, 1, 2))), draw.sample(names, draw.choice((0, 1, 1, 2)))
        sets = {draw.choice(names): draw.choice((0, 1))} if draw.random() < 0.15 else {}
        emits = Command(draw.choice(("dash", "kick", "say"))) if draw.random() < 0.4 else None
        guard = _guard(draw, real, names, 0.7)
        transitions.append(_transition(draw, f"t{k}", tuple(takes), tuple(gives), sets=sets, emits=emits, set_wins=True, **guard))
    return PetriNet("plain", tuple(places), tuple(transitions), semantics=_semantics(draw))


def _semantics(draw: random.Random) -> Semantics:
    return Semantics(
        capacity=draw.choice(("strong", "strong", "weak")),
        persistence=draw.choice(("intermediate", "intermediate", "atomic")),
        choice="random",  # execution tries every order that analysis follows
        max_firings=100,
    )


def _observed(draw: random.Random, tokens: list[str]) -> list[Input | Math]:
    places: list[Input | Math] = [Input("d", observes="ball.d"), Input("e", observes=draw.choice(("ball.d", "ball.e")))]
    for k in range(draw.randint(0, 2)):
        places.append(Math(f"m{k}", draw.choice(EXPRESSIONS).format(token=draw.choice(tokens))))
    if len(places) > 2 and draw.random() < 0.3:
        places.append(Math("n", draw.choice(OVER_MATH).format(m="m0")))
    return places


def _guard(draw: random.Random, real: list[str], tokens: list[str], chance: float = 0.6) -> dict[str, dict[str, float]]:
    tests: dict[str, float] = {}
    inhibitors: dict[str, float] = {}
    for name in real:
        if draw.random() < chance / len(real) * 1.5:
            (tests if draw.random() < 0.5 else inhibitors)[name] = draw.choice(THRESHOLDS)
    if draw.random() < 0.15:
        (tests if draw.random() < 0.5 else inhibitors)[draw.choice(tokens)] = 1
    return {"tests": tests, "inhibitors": inhibitors}


def _transition(draw: random.Random, name: str, inputs, outputs, **fields) -> Transition:
    fields.setdefault("delay", draw.choice((0, 0, 1, 2)))
    fields.setdefault("priority", draw.choice((0, 0, 0, 1)))
    fields.setdefault("memory", draw.choice(("enabling", "enabling", "enabling", "age", "resampling")))
    return Transition(name, inputs, outputs, **fields)
