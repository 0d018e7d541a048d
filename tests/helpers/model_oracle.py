"""Random relational models, and the slow way to filter them: from the words of the model alone, by going through every case.

The oracle knows neither ground slices nor factors. It keeps the probability of every joint state of what a slice leaves to the next,
and goes on by trying all values of all variables, aggregates included, with their meaning written out anew.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cprm_gym.architecture.prm import (
    BOOL,
    All,
    AnyCause,
    Attribute,
    Bins,
    Count,
    Dense,
    Exists,
    Max,
    Mean,
    Min,
    Model,
    PRMClass,
    Reference,
    Relation,
    Replace,
)

EDGES = (0.0, 1.0, 3.0, 4.5)
WIDE = Bins(EDGES, unit="m")


@dataclass
class Case:
    """A model, its objects, and what is needed to know it otherwise than the model does."""

    model: Model
    objects: dict[str, str]
    card: int
    tables: dict[str, np.ndarray]
    aggregates: dict[str, Any]
    past: dict[str, bool]
    static_parent: bool
    readings: tuple[str, ...] = field(default=())


def rows(rng: np.random.Generator, *shape: int, zeros: float = 0.0) -> np.ndarray:
    """A random CPD, child last."""
    table = rng.dirichlet(np.ones(shape[-1]), size=shape[:-1]) + 1e-2
    table = np.where(rng.random(table.shape) < zeros, 0.0, table)
    table[..., 0] += table.sum(axis=-1) == 0
    return table / table.sum(axis=-1, keepdims=True)


def aggregate(rng: np.random.Generator, path: str, bins: bool) -> Any:
    """Any aggregate over a path."""
    state = str(rng.choice(WIDE.states if bins else BOOL.names))
    kind = rng.integers(0, 7)
    if kind == 0:
        return Exists(path, state)
    if kind == 1:
        return All(path, state)
    if kind == 2:
        return Count(path, state, int(rng.integers(1, 4)))
    if kind == 3:
        return Min(path)
    if kind == 4:
        return Max(path)
    if kind == 5:
        return Mean(path, empty=state)
    return AnyCause(path, state, strength=float(rng.choice([0.1, 0.5, 0.9])), leak=float(rng.choice([0.0, 0.2])))


def distribution(made: Any, values: Sequence[int], card: int) -> np.ndarray:
    """P(aggregate | states of the objects), by the definition of each."""
    states = WIDE.states if card == 3 else BOOL.names
    hits = sum(states[v] == made.state for v in values) if not isinstance(made, Min | Max | Mean) else 0
    if isinstance(made, Exists):
        return np.eye(2)[int(hits > 0)]
    if isinstance(made, All):
        return np.eye(2)[int(hits == len(values))]
    if isinstance(made, Count):
        return np.eye(made.at_most + 1)[min(hits, made.at_most)]
    if isinstance(made, Min):
        return np.eye(card)[min(values, default=card - 1)]
    if isinstance(made, Max):
        return np.eye(card)[max(values, default=0)]
    if isinstance(made, Mean):
        if not values:
            return np.eye(card)[states.index(made.empty)]
        if card == 3:
            middles = [(EDGES[v] + EDGES[v + 1]) / 2 for v in values]
            mean = sum(middles) / len(middles)
            return np.eye(3)[min(sum(mean + 1e-9 >= e for e in EDGES[1:-1]), 2)]
        return np.eye(card)[int(np.floor(sum(values) / len(values) + 0.5 + 1e-9))]
    none = 1.0 if not hits else (1.0 - made.strength) ** hits
    none *= 1.0 - made.leak
    return np.array([none, 1.0 - none])


def random_case(seed: int, alike: bool = False) -> Case:
    """Things that move, a watcher who counts them in two ways, perhaps a trait that never changes and has no other attribute."""
    rng = np.random.default_rng(seed)
    bins = bool(rng.random() < 0.6)
    domain: Any = WIDE if bins else BOOL
    card = len(domain)
    zeros = float(rng.choice([0.0, 0.0, 0.3]))
    static_parent = bool(rng.random() < 0.5) and not alike
    things = int(rng.integers(1, 4))
    tables = {
        "prior": rows(rng, card),
        "trait": rows(rng, 2),
        "seen": rows(rng, card, card, zeros=zeros),
        "move": rows(rng, card, 2, card, zeros=zeros) if static_parent else rows(rng, card, card, zeros=zeros),
        "drift": rows(rng, card, card),
        "calm": rows(rng, 2),
    }
    trait = (PRMClass("Trait", (Attribute("bold", BOOL, Dense(tables["trait"]), static=True),)),) if static_parent else ()
    move = Attribute(
        "x",
        domain,
        Dense(tables["move"]),
        parents=("prev.x", "trait.bold") if static_parent else ("prev.x",),
        initial=Dense(tables["prior"]),
    )
    thing = PRMClass(
        "Thing",
        (move, Attribute("seen", domain, Dense(tables["seen"]), parents=("x",))),
        references=(Reference("trait", "Trait"),) if static_parent else (),
    )
    aggregates, past, attributes = {}, {}, []
    for name in ("a", "b"):
        path = "things.x"
        past[name] = bool(rng.random() < 0.3) and not alike
        made = aggregate(rng, ("prev." if past[name] else "") + path, bins)
        aggregates[name] = made
        size = made.at_most + 1 if isinstance(made, Count) else card if isinstance(made, Min | Max | Mean) else 2
        tables[name] = rows(rng, size, 2)
        attributes.append(Attribute(name, BOOL, Dense(tables[name]), parents=(made,)))
    watcher = PRMClass("Watcher", tuple(attributes), references=(Reference("things", "Thing", many=True),))
    relations = [Relation("calm", {"w": "Watcher"}, (Replace("w.a", (), Dense(tables["calm"])),))]
    relations.append(Relation("drifts", {"t": "Thing"}, (Replace("t.x", ("prev.t.x",), Dense(tables["drift"])),)))
    objects = {f"t{k}": "Thing" for k in range(things)} | {"w": "Watcher"} | ({"trait": "Trait"} if static_parent else {})
    model = Model("random", (*trait, thing, watcher), tuple(relations))
    seen = tuple(f"t{k}.seen" for k in range(things)) + ("w.a", "w.b")
    return Case(model, objects, card, tables, aggregates, past, static_parent, seen)


Before = dict[tuple[int, ...], float]


class Oracle:
    """The belief of one agent, state by state: a state is the things' x, then the trait."""

    def __init__(self, case: Case) -> None:
        self.case = case
        self.things = [o for o, c in case.objects.items() if c == "Thing"]
        self._all = list(itertools.product(range(case.card), repeat=len(self.things)))
        self._sums: dict[Any, np.ndarray] = {}
        self.reset()

    def reset(self) -> None:
        """Begin anew."""
        self.belief: Before = {}
        self.log_likelihood = 0.0

    def step(self, evidence: Mapping[str, int], relations: Sequence[str]) -> dict[str, np.ndarray] | None:
        """Marginals after one slice; None if the evidence is impossible, and the belief stays."""
        case, tables = self.case, self.case.tables
        found = {f"{t}.x": np.zeros(case.card) for t in self.things} | {"w.a": np.zeros(2), "w.b": np.zeros(2)}
        if case.static_parent:
            found["trait.bold"] = np.zeros(2)
        after: Before = {}
        starts: list[tuple[tuple[int, ...] | None, int, float]]
        if self.belief:
            starts = [(state[:-1], state[-1], p) for state, p in self.belief.items()]
        elif case.static_parent:
            starts = [(None, bold, float(tables["trait"][bold])) for bold in range(2)]
        else:
            starts = [(None, 0, 1.0)]
        remembers = any(case.past.values())
        cases: dict[Any, float] = {}
        for old, bold, p in starts:
            moves = [self._move(old, k, bold, name, relations).tolist() for k, name in enumerate(self.things)]
            for xs in self._all:
                q = p
                for move, x in zip(moves, xs):
                    q *= move[x]
                if q:
                    key = (old if remembers else old is None, xs, bold)
                    cases[key] = cases.get(key, 0.0) + q
        for (last, xs, bold), p in cases.items():
            q = p * float(np.prod([tables["seen"][x, evidence[f"{t}.seen"]] for t, x in zip(self.things, xs) if f"{t}.seen" in evidence]))
            old = last if remembers else None if last else ()
            flags = [self._flag(name, old, xs, relations) for name in ("a", "b")]
            for name, flag in zip(("a", "b"), flags):
                if f"w.{name}" in evidence:
                    flag[1 - evidence[f"w.{name}"]] = 0.0
            joint = self._joint(flags, old, xs, relations, evidence)
            total = q * float(joint.sum())
            if total == 0.0:
                continue
            after[(*xs, bold)] = after.get((*xs, bold), 0.0) + total
            for name, x in zip(self.things, xs):
                found[f"{name}.x"][x] += total
            found["w.a"] += q * joint.sum(axis=1)
            found["w.b"] += q * joint.sum(axis=0)
            if case.static_parent:
                found["trait.bold"][bold] += total
        mass = sum(after.values())
        if mass == 0.0:
            return None
        self.belief = {state: p / mass for state, p in after.items()}
        self.log_likelihood += float(np.log(mass))
        return {name: table / mass for name, table in found.items()}

    def _move(self, old: tuple[int, ...] | None, k: int, bold: int, name: str, relations: Sequence[str]) -> np.ndarray:
        tables = self.case.tables
        if old is None:
            return tables["prior"]
        if f"drifts({name})" in relations:
            return tables["drift"][old[k]]
        return tables["move"][old[k], bold] if self.case.static_parent else tables["move"][old[k]]

    def _sum(self, name: str, old: tuple[int, ...] | None, xs: tuple[int, ...]) -> np.ndarray:
        """P(aggregate of an attribute | things)."""
        values: Sequence[int] = xs if not self.case.past[name] else old or ()
        known = self._sums.get((name, tuple(values)))
        if known is None:
            known = self._sums[name, tuple(values)] = distribution(self.case.aggregates[name], values, self.case.card)
        return known

    def _flag(self, name: str, old: tuple[int, ...] | None, xs: tuple[int, ...], relations: Sequence[str]) -> np.ndarray:
        if name == "a" and "calm(w)" in relations:
            return self.case.tables["calm"].copy()
        if self.case.past[name] and old is None:
            return np.full(2, 0.5)
        return self._sum(name, old, xs) @ self.case.tables[name]

    def _joint(
        self,
        flags: Sequence[np.ndarray],
        old: tuple[int, ...] | None,
        xs: tuple[int, ...],
        relations: Sequence[str],
        evidence: Mapping[str, int],
    ) -> np.ndarray:
        """P(a, b and what was read of them | things): one variable for both, if both sum up the same in the same way."""
        begins = old is None and self.case.past["a"]
        if begins or "calm(w)" in relations or self.case.aggregates["a"] != self.case.aggregates["b"]:
            return np.outer(*flags)
        joint = np.einsum("k,ki,kj->ij", self._sum("a", old, xs), self.case.tables["a"], self.case.tables["b"])
        for axis, name in enumerate(("a", "b")):
            if f"w.{name}" in evidence:
                index: list[Any] = [slice(None), slice(None)]
                index[axis] = 1 - evidence[f"w.{name}"]
                joint[tuple(index)] = 0.0
        return joint


def quantity(rng: np.random.Generator, state: int) -> Any:
    """A number that lies in a bin, an integer where there is one."""
    low, high = EDGES[state], EDGES[state + 1]
    whole: list[Callable[[int], Any]] = [int, np.int64, np.int32, float]
    inside = [k for k in range(10) if low <= k < high]
    return whole[int(rng.integers(0, 4))](inside[0]) if inside else (low + high) / 2
