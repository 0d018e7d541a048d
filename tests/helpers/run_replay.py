"""Replays a run that the analysis shows, by the rule of execution and nothing else: a second opinion on every witness."""

from __future__ import annotations

import re

INF = float("inf")


class Replay:
    """One run, step by step; every illegal step fails an assertion. For transitions with enabling memory."""

    def __init__(self, system):
        self.system = system
        self.own = {t.name: t for t in system.transitions[: system.n_own]}
        self.outside = {t.name: t for t in system.transitions[system.n_own :]}
        self.capacity = {p.name: getattr(p, "capacity", None) for p in system.compiled.net.places}
        self.marking = dict(zip(system.places, map(int, system.start[: len(system.places)])))
        self.variable = {place: v.name for v in system.variables for place in v.places}
        self.known: dict[str, tuple[float, float]] = {}
        self.clock: dict[str, int] = {}
        self.cycle = 0

    def run(self, steps):
        """Replay all steps; returns the marking at the end."""
        for step in steps:
            while self.cycle < step.cycle:
                self.end_cycle()
            if step.kind == "observed":
                name, low, high = read_cell(step.what)
                assert name not in self.known, f"{name} is asked twice in cycle {self.cycle}"
                self.known[name] = (low, high)
            elif step.kind == "outside":
                assert self.tokens_allow(self.outside[step.what])
                self.move(self.outside[step.what])
            else:
                self.fire(self.own[step.what])
            assert {p: n for p, n in self.marking.items() if n} == dict(step.marking), step
        return self.marking

    def tokens_allow(self, t, marking=None):
        """Whether the tokens allow `t`."""
        m = marking or self.marking
        for p, w in t.inputs.items():
            if p in m and m[p] < w:
                return False
        if any(m[p] < w for p, w in t.tests.items() if p in m) or any(m[p] >= w for p, w in t.inhibitors.items() if p in m):
            return False
        for p, w in t.outputs.items():
            limit = self.capacity.get(p)
            if limit is not None and m[p] - t.inputs.get(p, 0) + w > limit:
                return False
        return True

    def cells_allow(self, t):
        """True or False if what was observed decides it, else None."""
        answers = []
        for arcs, sense in ((t.tests, True), (t.inhibitors, False)):
            for place, threshold in arcs.items():
                if place in self.variable:
                    low, high = self.known.get(self.variable[place], (-INF, INF))
                    above = True if low >= threshold else False if high <= threshold else None
                    answers.append(None if above is None else above == sense)
        return False if False in answers else None if None in answers else True

    def enabled(self, t):
        return self.tokens_allow(t) and self.cells_allow(t)

    def fire(self, t):
        assert self.tokens_allow(t), f"{t.name}: tokens"
        assert self.cells_allow(t) is True, f"{t.name}: {self.known}"
        for other in self.own.values():
            if other.delay == 0 and (t.delay > 0 or other.priority > t.priority):
                assert not self.enabled(other), f"{t.name} fires although {other.name} comes first"
        if t.delay:
            assert self.clock.get(t.name, -1) >= t.delay, f"{t.name}: clock {self.clock.get(t.name)}"
            self.clock.pop(t.name)
        self.move(t)

    def move(self, t):
        between = {p: n - t.inputs.get(p, 0) for p, n in self.marking.items()}
        after = {p: n + t.outputs.get(p, 0) for p, n in between.items()}
        after.update({p: v for p, v in t.sets.items() if p in after})
        self.marking = after
        for name in list(self.clock):
            u = self.own[name]
            needs = {p: max(u.inputs.get(p, 0), u.tests.get(p, 0)) for p in (*u.inputs, *u.tests) if p in between}
            if any(between[p] < w for p, w in needs.items()) or not self.tokens_allow(u) or self.cells_allow(u) is False:
                del self.clock[name]

    def end_cycle(self):
        for t in self.own.values():
            if t.delay == 0:
                assert not self.enabled(t), f"cycle {self.cycle} ends although {t.name} is enabled"
            elif self.enabled(t):
                self.clock.setdefault(t.name, 0)
                assert self.clock[t.name] < t.delay, f"cycle {self.cycle} ends although {t.name} is due"
            else:
                self.clock.pop(t.name, None)
        self.clock = {name: age + 1 for name, age in self.clock.items()}
        self.known = {}
        self.cycle += 1


def read_cell(text):
    """The variable and interval that a text such as ``3 <= off_axis < 5`` names."""
    number = r"[-+.\de]+"
    if m := re.fullmatch(rf"({number}) <= (\S+) < ({number})", text):
        return m[2], float(m[1]), float(m[3])
    if m := re.fullmatch(rf"(\S+) < ({number})", text):
        return m[1], -INF, float(m[2])
    m = re.fullmatch(rf"(\S+) >= ({number})", text)
    assert m, text
    return m[1], float(m[2]), INF
