"""Random nets: what analysis says holds no execution contradicts, and what it says fails some execution does.

One direction: many copies of a net are executed at random, the orders of equal priorities drawn too. The other: each run that a verdict
shows is performed by the reference interpreter, with observations found by trying.
"""

import itertools
import random
from dataclasses import replace

import numpy as np
import pytest
from module_random_nets import GRID, random_module, random_plain, random_user
from run_execution import RunExecution

from cprm_gym.architecture.analysis.behaviour.properties import analyze_structure
from cprm_gym.architecture.analysis.budget import Budget
from cprm_gym.architecture.analysis.modules.composition import check_composition
from cprm_gym.architecture.analysis.modules.contracts import check_contract
from cprm_gym.architecture.analysis.queries import can_become
from cprm_gym.architecture.analysis.timed.environment import caller, closed_system
from cprm_gym.architecture.analysis.timed.properties import judge_timed
from cprm_gym.architecture.analysis.timed.state_space import explore_timed
from cprm_gym.architecture.petri import Executor, Place, compile_net, instances
from cprm_gym.errors import ExpressionError, LivelockError

COPIES, CYCLES = 48, 10
SMALL, LARGE = 60, 10_200
MAKERS = (random_plain, random_module, random_user)


class Seen:
    """What executions at random showed."""

    def __init__(self, compiled, seed):
        self.net, self.compiled = compiled.net, compiled
        self.names = [p.name for p in self.net.places if isinstance(p, Place)]
        self.columns = [self.compiled.place(n) for n in self.names]
        self.ports = self.net.ports if self.net.ports.begin and self.net.ports.outcomes else None
        self.markings, self.fired, self.livelock, self.differ, self.overruled = [], set(), False, False, set()
        self.faults: set[str] = set()
        draw = np.random.default_rng(seed)
        self.executor = Executor(self.compiled, batch=COPIES, seed=seed, trace=True)
        self.waits = np.zeros(COPIES, bool)  # copies 2 k and 2 k + 1 are given the same
        self.asked = np.full(COPIES, -1)
        for _ in range(CYCLES):
            before = self.executor.marking[:, self.columns].copy()
            if self.ports:
                self.call(draw)
            try:
                values = {n: np.repeat(draw.choice(GRID, COPIES // 2), 2) for n in self.executor.input_names}
                commands = self.executor.step(values)
            except LivelockError:
                self.livelock = True
                break
            except ExpressionError:
                break
            now = self.executor.marking[:, self.columns]
            self.markings.append(now.copy())
            self.differ |= bool((now[0::2] != now[1::2]).any())
            self.overruled |= set(np.flatnonzero(commands.overruled.any(axis=0)).tolist())
            if self.differ:
                break
            if self.ports:
                self.judge(before)
        names = self.compiled.transition_names
        self.fired = {names[t] for _, events in self.executor.trace.cycles() for t in events[:, 2].tolist()}

    def tokens(self, name):
        return self.executor.marking[:, self.compiled.place(name)] > 0

    def call(self, draw):
        """What a caller does, before a cycle."""
        ends = np.array([self.tokens(o) for o in self.ports.outcomes])
        take = np.repeat(draw.random(COPIES // 2) < 0.7, 2)
        for o, there in zip(self.ports.outcomes, ends):
            taken = there & take & self.waits
            self.executor.write(o, 0, which=taken)
            self.waits &= ~taken
            self.asked[taken] = -1
        begin = ~self.waits & np.repeat(draw.random(COPIES // 2) < 0.6, 2) & ~self.tokens(self.ports.begin)
        self.executor.write(self.ports.begin, 1, which=begin)
        self.waits |= begin
        for i in self.ports.interrupts:
            ask = self.tokens(self.ports.ongoing) & ~self.tokens(i) & (self.asked < 0) & np.repeat(draw.random(COPIES // 2) < 0.3, 2)
            ask &= ~np.array([self.tokens(o) for o in self.ports.outcomes]).any(axis=0)
            self.executor.write(i, 1, which=ask)
            self.asked[ask] = 0

    def judge(self, before):
        """What the promises of a module say of the end of a cycle."""
        ongoing = self.tokens(self.ports.ongoing)
        ends = np.array([self.tokens(o) for o in self.ports.outcomes]).sum(axis=0)
        begin = self.tokens(self.ports.begin)
        if (self.waits & begin).any():
            self.faults.add("start")
        vanished = self.waits & ~begin & ~ongoing & (ends == 0)
        if (ends > 1).any() or (~self.waits & (ends > 0)).any() or ((ends == 1) & ongoing).any() or vanished.any():
            self.faults.add("exclusive end")
        self.asked[(self.asked >= 0) & (ends == 0)] += 1
        if (self.asked > self.ports.within + 1).any():
            self.faults.add("interruption")
        over = self.waits & (ends == 1) & ~ongoing
        free = {*self.ports.all}
        for k, name in enumerate(self.names):
            rest = self.net.place(name).tokens
            overwritten = all(name in t.sets for t in self.net.transitions if self.ports.begin in t.inputs)
            if name not in free and not overwritten and (self.executor.marking[over, self.columns[k]] != rest).any():
                self.faults.add("clean")


def check(seed):
    """Every claim about one net; returns what was said, to be counted."""
    draw = random.Random(seed)
    net = MAKERS[seed % len(MAKERS)](draw)
    compiled = compile_net(net)
    space = explore_timed(closed_system(compiled, limit=5), Budget(states=30_000))
    found = judge_timed(compiled, space)
    untimed = analyze_structure(space.system.untimed, Budget(states=30_000))
    seen = Seen(compiled, seed)
    where = f"net {seed}"
    flat = compiled.net
    is_module = bool(flat.ports.begin and flat.ports.outcomes)
    moves, extra = caller(flat, flat.ports.idle_interrupts == "consumed") if is_module else ([], {})
    said = [("deterministic", found.deterministic.holds), ("bounded", found.bounded.holds), ("quiet", found.becomes_quiet.holds)]

    # holds: no execution contradicts
    for marking in seen.markings:
        for name, column in zip(seen.names, marking.T):
            if untimed.complete:
                assert column.max() <= untimed.bounds[name], (where, name)
    if found.deterministic.holds:
        assert not seen.differ, (where, "two orders differ")
        immediate = {t.name for t in flat.transitions if not t.is_timed}
        assert not [c for c in seen.executor.conflicts if {c.fired, c.disabled} <= immediate], (where, seen.executor.conflicts)
    if found.becomes_quiet.holds:
        assert not seen.livelock, where
    if space.complete:
        assert not seen.fired & set(found.dead_transitions), where
        rows = {tuple(row) for row in space.markings[space.kinds == 4][:, [space.system.place(n) for n in seen.names]].tolist()}
        for marking in seen.markings:
            assert {tuple(map(int, row)) for row in marking} <= rows, where
        sent = {(e.first, e.second) for e in found.emissions} | {(e.second, e.first) for e in found.emissions}
        for t in seen.overruled:
            name = flat.transitions[t].name
            assert any(name in pair for pair in sent), (where, name)
    if found.modules:
        ongoing = {path: i.places[i.net.ports.ongoing] for path, i in instances(compiled.source).items() if path}
        for (a, b), verdict in found.modules.together.items():
            said.append(("together", verdict.holds))
            if verdict.holds is False:
                columns = [seen.names.index(ongoing[p]) for p in (a, b)]
                assert not any((m[:, columns] > 0).all(axis=1).any() for m in seen.markings), (where, a, b)

    # fails: some execution does
    performer = RunExecution(flat, moves, extra, GRID)
    shown = [found.deterministic, found.becomes_quiet, found.bounded, found.never_stops, found.reversible]
    if found.modules:
        shown += [replace(v, holds=False) for v in found.modules.together.values() if v.holds is True and v.run]
    for verdict in shown:
        if verdict.holds is False:
            assert performer.perform(verdict.run, verdict.loop) is not None, (where, verdict.why, [str(s) for s in verdict.run])
    for emission in found.emissions:
        if not emission.decided:
            continue
        assert performer.perform(emission.run) is not None, (where, str(emission), [str(s) for s in emission.run])

    # a predicate, both ways
    a, b = draw.choice(seen.names), draw.choice(seen.names)
    texts = [f"{a} >= 1 and {b} >= 1"] if a.isidentifier() and b.isidentifier() else []
    for text in texts:
        verdict = can_become(compiled, text, budget=Budget(states=30_000))
        said.append(("reach", verdict.holds))
        columns = [seen.names.index(a), seen.names.index(b)]
        if verdict.holds is False:
            assert not any((m[:, columns] >= 1).all(axis=1).any() for m in seen.markings), (where, text)
        elif verdict.holds:
            end = performer.perform(verdict.run)
            assert end is not None, (where, text, [str(s) for s in verdict.run])
            assert end.marking[a] >= 1, (where, text)
            assert end.marking[b] >= 1, (where, text)
    if is_module:
        said += contract(compiled, seen, where)
    if compiled.source.modules:
        report = check_composition(compiled, space=space)
        said.append(("composition", report.holds))
        for misuse in report.misuses:
            if misuse.run:
                assert performer.perform(misuse.run) is not None, (where, str(misuse), [str(s) for s in misuse.run])
    return said


def contract(compiled, seen, where):
    """Clauses that hold are kept by the executions; runs that break one are performed."""
    report = check_contract(compiled.source, budget=Budget(states=30_000), most_tokens=5)
    performer = RunExecution(compiled.net, *caller(compiled.net, True), GRID)
    for clause in report.clauses:
        if clause.holds:
            assert clause.name not in seen.faults, (where, clause.name)
        elif clause.holds is False and clause.run:
            performed = performer.perform(clause.run, clause.loop)
            assert performed is not None, (where, clause.name, clause.why, [str(s) for s in clause.run])
    return [(clause.name, clause.holds) for clause in report.clauses]


def tally(seeds):
    """How often each claim was made with each answer."""
    count: dict[tuple[str, bool | None], int] = {}
    for key in itertools.chain.from_iterable(check(seed) for seed in seeds):
        count[key] = count.get(key, 0) + 1
    return count


def decided(count):
    """Both answers were given, and far more often than "unknown"."""
    for claim in {name for name, _ in count}:
        known, unknown = sum(count.get((claim, h), 0) for h in (True, False)), count.get((claim, None), 0)
        assert unknown <= 0.25 * (known + unknown) + 3, (claim, known, unknown)
    return count


def test_analysis_and_execution_agree_on_random_nets():
    count = decided(tally(range(SMALL)))
    assert count["deterministic", True] > 10
    assert count["deterministic", False] > 5


@pytest.mark.slow
def test_analysis_and_execution_agree_on_ten_thousand_random_nets():
    """``pytest -m slow -n 0 tests/architecture/analysis/test_random_nets.py``: about six minutes of CPU time."""
    count = decided(tally(range(SMALL, SMALL + LARGE)))
    for claim in ("deterministic", "quiet", "together", "reach", "composition", "start", "exclusive end", "clean", "may end"):
        assert count[claim, True] > 50, claim
        assert count[claim, False] > 50, claim
