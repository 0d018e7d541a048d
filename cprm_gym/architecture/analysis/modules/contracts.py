"""Module contracts: does a behaviour module keep its interface, in every environment?

A behaviour module promises its caller (§2.2.6, §4.2): a token in `begin` starts it, `ongoing` is marked while it works, it ends in
exactly one of `done` and its errors, it leaves nothing behind, it answers interrupts in time. `check_contract` closes the module
with a caller that does everything a caller may do, lets inputs, beliefs and continuous places be anything in every cycle, explores all
that can happen cycle by cycle (`timed/state_space.py`) and judges each promise (`clauses.py`). A broken promise comes with the shortest
run that breaks it.

What the caller does stands in `timed/environment.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from ....errors import NetError
from ...petri import PetriNet, compile_net
from ..budget import Budget
from ..timed.environment import caller
from ..timed.state_space import TimedStateSpace, explore_timed
from ..timed.system import timed_system
from ..verdicts import Verdict
from .clauses import Judge


@dataclass(frozen=True)
class ContractReport:
    """The verdict on a module.

    Attributes
    ----------
    module : str
    clauses : tuple of Verdict
    warnings : tuple of str
        Transitions that never fire, outcomes that never come.
    within : int
        Cycles granted for answering an interrupt.
    states, nodes : int
        Distinct (marking, clocks) at the ends of cycles; steps explored.
    complete : bool
        Whether everything was explored.
    assumptions : tuple of str
        What the verdict rests on.
    """

    module: str
    clauses: tuple[Verdict, ...]
    warnings: tuple[str, ...] = ()
    within: int = 1
    states: int = 0
    nodes: int = 0
    complete: bool = True
    assumptions: tuple[str, ...] = field(default_factory=tuple)

    @property
    def holds(self) -> bool | None:
        """True if every clause holds, False if one is broken, None if some are not known."""
        verdicts = [c.holds for c in self.clauses]
        return False if False in verdicts else None if None in verdicts else True

    @property
    def broken(self) -> tuple[Verdict, ...]:
        """The clauses that do not hold."""
        return tuple(c for c in self.clauses if c.holds is False)

    def clause(self, name: str) -> Verdict:
        """The clause of that name."""
        return next(c for c in self.clauses if c.name == name)

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "module": self.module,
            "holds": self.holds,
            "within": self.within,
            "states": self.states,
            "nodes": self.nodes,
            "complete": self.complete,
            "clauses": [c.to_json() for c in self.clauses],
            "warnings": list(self.warnings),
            "assumptions": list(self.assumptions),
        }

    def __str__(self) -> str:
        signs = {True: "holds", False: "BROKEN", None: "unknown"}
        lines = [f"contract of {self.module!r}: {signs[self.holds]} ({self.states} states, {self.nodes} steps)"]
        for c in self.clauses:
            lines.append(f"  {signs[c.holds]:8} {c.name}: {c.why or c.title}")
            lines += [f"             {step}" for step in c.run]
            lines += [f"             for ever: {step}" for step in c.loop]
        return "\n".join([*lines, *(f"  warning  {w}" for w in self.warnings)])


def check_contract(
    module: PetriNet,
    k: int | None = None,
    *,
    budget: Budget | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    most_tokens: int = 255,
) -> ContractReport:
    """Check the contract of a behaviour module, for all environments.

    Parameters
    ----------
    module : PetriNet
        With `begin`, `ongoing` and at least one outcome among its ports.
    k : int, optional
        Cycles within which an interrupt must be answered; by default what the ports declare (`within`).
    budget : Budget, optional
    bounds : mapping from place to (least, largest), optional
        What is known about continuous, input, belief and math places; otherwise they may be anything.
    most_tokens : int
        Tokens beyond which a place without capacity counts as filling up.

    Raises
    ------
    NetError
        When the net is no behaviour module.
    """
    ports = module.ports
    if not (ports.begin and ports.ongoing and ports.outcomes):
        raise NetError(f"net {module.name!r}: a behaviour module has ports begin, ongoing and done or errors; it has {ports}")
    k = ports.within if k is None else k
    budget, clock = (budget or Budget()).start()
    compiled = compile_net(module)
    flat = compiled.net
    moves, extra = caller(flat, idle_interrupts=False)
    system = timed_system(compiled, moves, extra, bounds, most_tokens, clock.spent)
    space = explore_timed(system, budget.part(0.45 if ports.interrupts else 0.9))
    spaces = [space]

    @cache
    def judge(s: TimedStateSpace) -> Judge:
        return Judge(flat, k, s)

    def judged(check: Callable[[Judge], Verdict]) -> Verdict:
        return space.judged(lambda s: check(judge(s)))

    clauses = [judged(Judge.start), judged(Judge.exclusive_end), judged(Judge.clean)]
    if ports.interrupts:
        clauses.append(judged(Judge.interruption))
        known = {c.name for c in clauses if c.holds is not True}
        other = explore_timed(system.with_outside(caller(flat, idle_interrupts=True)[0]), budget.part(0.9))
        clauses.append(other.judged(lambda s: judge(s).idle_interrupt(known)))
        spaces.append(other)
    clauses += [judged(Judge.spontaneous), judged(Judge.bounded), judge(space).may_end(), judged(Judge.quiet)]
    return ContractReport(
        module.name,
        tuple(clauses),
        (*_warnings(flat, spaces), *judge(space).ends_only_by_interrupt()),
        k,
        space.n_states,
        sum(s.n_nodes for s in spaces),
        all(s.complete for s in spaces),
        (
            "the environment may set every input, belief and continuous place to anything in every cycle"
            + (", within the bounds given" if bounds else ""),
            "no fairness: `may end` says that an end stays possible, not that it comes",
            "what the caller does is no firing: it resets no clock with resampling memory",
        ),
    )


def _warnings(flat: PetriNet, spaces: list[TimedStateSpace]) -> tuple[str, ...]:
    """What never happens although it was written."""
    if not all(s.complete for s in spaces):
        return ()
    fired = np.unique(np.concatenate([s.graph.labels for s in spaces]))
    found = [f"transition {t.name!r} never fires" for n, t in enumerate(flat.transitions) if n not in fired]
    for o in flat.ports.outcomes:
        if not any(s.markings[:, s.system.place(o)].any() for s in spaces):
            found.append(f"outcome {o!r} never comes")
    return tuple(found)
