"""The firing rule once more, in plain Python: slow, without lists of consequences, read off the words of the package's docstring.

It works on the declared net, place by place and arc by arc, and looks at everything after every firing. The tests hold the
compiled executor against it.
"""

from __future__ import annotations

import math

import numpy as np

from cprm_gym.architecture.expressions import Expression
from cprm_gym.architecture.expressions.interpreter import interpret
from cprm_gym.architecture.petri import INFINITE, Belief, Input, Math, ObjectPlace, PetriNet, Place, compile_net, flatten
from cprm_gym.errors import ExpressionError, LivelockError

MASK = 2**64 - 1


class Reference:
    """One copy of a net."""

    def __init__(self, net: PetriNet, objects: dict[str, int] | None = None, seed: int | None = None, copy: int = 0) -> None:
        self.net = flatten(net)
        self.places = {p.name: p for p in self.net.places}
        compiled = compile_net(self.net)
        self.maths = compiled.math  # only their order; it is checked by itself
        self.sizes = objects or {}
        self.marking = {name: float(x) for name, x in zip(self.places, compiled.initial)}
        self.held = {p.name: -1 for p in self.net.places if isinstance(p, ObjectPlace)}
        self.running = {t.name: [] for t in self.net.transitions if t.is_timed}
        self.paused = {t.name: [] for t in self.net.transitions if t.is_timed}
        self.objects: dict[str, dict[str, list[float]]] = {}
        self.random = int(np.random.SeedSequence(seed).spawn(copy + 1)[copy].generate_state(1, np.uint64)[0])
        self.may_start = False
        self.cycle = 0

    # -- one cycle ----------------------------------------------------------------------------------------------------------

    def step(self, inputs: dict[str, float], beliefs: dict[str, float], objects: dict[str, dict[str, list[float]]]):
        """Returns the firings and the commands that go out (name -> parameters), and the transitions overruled."""
        for clocks in self.running.values():
            clocks[:] = [c + 1 for c in clocks]
        for place in self.net.places:
            if isinstance(place, Input) and place.observes in inputs:
                self.marking[place.name] = float(inputs[place.observes])
            if isinstance(place, Belief) and place.name in beliefs:
                self.marking[place.name] = float(beliefs[place.name])
        self.objects.update(objects)
        self.fired: list[str] = []
        self.sent: list[tuple[object, dict[str, float]]] = []
        texts = [s for p in self.net.places if isinstance(p, ObjectPlace) and p.select for s in (p.select.best, p.select.where) if s]
        names = {name for text in texts for name in Expression(text).names}
        if any(isinstance(self.places.get(name), Math) for name in names):
            self.evaluate()
        for place in self.net.places:
            if isinstance(place, ObjectPlace) and place.select:
                self.hold(place.name, self.choose(place.select))
        self.evaluate()
        self.may_start = False
        self.settle()
        self.may_start = True
        for t in self.net.transitions:
            if t.is_timed:
                self.adjust(t, self.enabled(t))
        while True:
            due = [t for t in self.net.transitions if t.is_timed and self.enabled(t) and self.is_due(t)]
            if not due:
                break
            self.fire(max(due, key=lambda t: t.priority))
            self.settle()
        self.cycle += 1
        return self.fired, *self.commands()

    def settle(self) -> None:
        count = 0
        while True:
            able = [t for t in self.net.transitions if not t.is_timed and self.enabled(t)]
            if not able:
                return
            best = max(t.priority for t in able)
            able = [t for t in able if t.priority == best]
            chosen = able[0]
            if self.net.semantics.choice == "random":
                left = self.draw() * sum(t.weight for t in able)
                for t in able:
                    if left >= 0.0:
                        chosen = t
                    left -= t.weight
            count += 1
            if count > self.net.semantics.max_firings:
                raise LivelockError("no end")
            self.fire(chosen)

    def draw(self) -> float:
        self.random = (self.random + 0x9E3779B97F4A7C15) & MASK
        z = self.random
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
        return ((z ^ (z >> 31)) >> 11) / 2**53

    # -- values -------------------------------------------------------------------------------------------------------------

    def values(self) -> dict[str, float]:
        """What an expression can read: places, and attributes of held objects (NaN when absent)."""
        found = dict(self.marking)
        for name, index in self.held.items():
            for attribute, values in self.objects.get(self.places[name].class_name, {}).items():
                found[f"{name}.{attribute}"] = values[index] if index >= 0 else math.nan
        return found

    def evaluate(self) -> None:
        for place in self.maths:
            known = self.values()
            tree = Expression(place.expression)
            if any(math.isnan(known.get(name, math.nan)) for name in tree.names if name not in self.places):
                self.marking[place.name] = float(place.default)
                continue
            value = interpret(tree.tree, known)
            if math.isnan(value):
                raise ExpressionError(place.name)
            self.marking[place.name] = value

    def choose(self, select) -> int:
        given = self.objects.get(select.class_name, {})
        scored = []
        for j in range(self.sizes.get(select.class_name, 0)):
            if given.get("present", [0] * (j + 1))[j] == 0:
                continue
            known = self.values() | {f"{select.candidate}.{a}": values[j] for a, values in given.items()}
            if select.where and interpret(Expression(select.where).tree, known) in (0.0,):
                continue
            if select.where and math.isnan(interpret(Expression(select.where).tree, known)):
                continue
            value = interpret(Expression(select.best).tree, known)
            if not math.isnan(value):
                scored.append((value if select.minimize else -value, j))
        scored.sort()
        return scored[select.k - 1][1] if len(scored) >= select.k else -1

    def hold(self, place: str, index: int) -> None:
        self.held[place] = index
        self.marking[place] = float(index >= 0)

    # -- transitions --------------------------------------------------------------------------------------------------------

    def enabled(self, t) -> bool:
        m = self.marking
        if any(m[p] < w for p, w in t.inputs.items()) or any(m[p] < w for p, w in t.tests.items()):
            return False
        if any(m[p] >= w for p, w in t.inhibitors.items()):
            return False
        for p, amount in t.outputs.items():
            capacity = 1 if isinstance(self.places[p], ObjectPlace) else self.places[p].capacity
            weak = self.net.semantics.capacity == "weak"
            back = t.inputs.get(p, 0)
            if capacity is None or (amount <= back and not weak):
                continue
            if m[p] + amount - (0 if weak else back) > capacity:
                return False
        return True

    def degree(self, t, tokens_only: bool = False) -> int:
        if not tokens_only and not self.enabled(t):
            return 0
        moved = (Place, ObjectPlace)
        for p, w in (*t.inputs.items(), *t.tests.items()):
            if isinstance(self.places[p], moved) and self.marking[p] < w:
                return 0
        return min((int(self.marking[p] // w) for p, w in t.inputs.items()), default=1)

    def trim(self, t, keep: int) -> None:
        clocks = self.running[t.name]
        clocks.sort(reverse=True)
        if t.memory == "age":
            self.paused[t.name] += clocks[keep:]
        del clocks[keep:]

    def adjust(self, t, enabled: bool) -> None:
        wanted = self.degree(t) if enabled else 0
        if t.servers != INFINITE:
            wanted = min(wanted, t.servers)
        self.trim(t, wanted)
        while self.may_start and len(self.running[t.name]) < wanted:
            oldest = max(self.paused[t.name], default=0)
            self.running[t.name].append(oldest)
            if oldest in self.paused[t.name]:
                self.paused[t.name].remove(oldest)

    def is_due(self, t) -> bool:
        return any(c >= t.delay for c in self.running[t.name])

    def fire(self, t) -> None:
        self.fired.append(t.name)
        if t.emits:
            read = {}
            for key, source in t.emits.params.items():
                read[key] = source if not isinstance(source, str) else self.held.get(source, self.marking[source])
            self.sent.append((t, read))
        before = {u.name: self.enabled(u) for u in self.net.transitions}
        if t.is_timed:
            self.running[t.name].remove(max(self.running[t.name]))
        token = next((self.held[p] for p in t.inputs if p in self.held), -1)
        for p, w in t.inputs.items():
            self.hold(p, -1) if p in self.held else self.add(p, -w)
        if self.net.semantics.persistence == "intermediate":
            for u in self.net.transitions:
                shared = [p for p in t.inputs if p in u.inputs or p in u.tests]
                if u.is_timed and shared and (u is not t or u.servers != 1):
                    self.trim(u, self.degree(u, tokens_only=True))
        for p, w in t.outputs.items():
            self.hold(p, token) if p in self.held else self.add(p, w)
        for p, value in t.sets.items():
            if p in self.held:
                self.hold(p, -1)
            else:
                self.marking[p] = float(value)
        self.evaluate()
        for u in self.net.transitions:
            if not u.is_timed:
                continue
            now = self.enabled(u)
            if u.memory == "resampling":
                self.running[u.name].clear()
            if before[u.name] or now:
                self.adjust(u, now)

    def add(self, place: str, amount: float) -> None:
        self.marking[place] += amount

    # -- commands -----------------------------------------------------------------------------------------------------------

    def commands(self, groups: tuple[tuple[str, ...], ...] = ()):
        out: dict[str, tuple[object, dict[str, float]]] = {}
        overruled = set()
        for t, values in self.sent:
            mates = next((g for g in self.groups if t.emits.name in g), (t.emits.name,))
            rival = next((name for name in mates if name in out), None)
            if rival is None:
                out[t.emits.name] = (t, values)
            elif t.priority > out[rival][0].priority:
                overruled.add(out.pop(rival)[0].name)
                out[t.emits.name] = (t, values)
            else:
                overruled.add(t.name)
        return {name: values for name, (_, values) in out.items()}, overruled

    groups: tuple[tuple[str, ...], ...] = ()
