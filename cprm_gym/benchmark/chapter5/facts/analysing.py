"""The methods of analysis, each tried on a controller; further ones join by name (`METHODS`)."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from ....architecture.analysis.budget import Budget
from ....architecture.analysis.modules.contracts import check_contract
from ....architecture.analysis.report import analyze
from ....envs.tasks import Task, make_task
from ...behaviours.controllers import try_methods
from ..conditions import Condition
from ..players import make_player

SECONDS = 10.0
"""That a method may take on a net."""
Says = list[dict[str, Any]]
"""For each thing that a method tells: ``method``, ``can`` (whether it told anything), ``says``, ``seconds``."""


def in_a_world(controller: str, task: Task, episodes: int, seed: int) -> Says:
    """Episodes, a learned chain, its bounds, causes: through the interface that all controllers have."""
    begin = time.process_time()
    tried = try_methods(controller, task, episodes, make=make_player(controller, Condition()), seed=seed, proofs=SECONDS)
    each = (time.process_time() - begin) / max(1, len(tried.found))
    return [{"method": f.method, "can": f.can, "says": f.says, "seconds": each} for f in tried.found if f.method not in _NETS]


_NETS = ("every environment: deadlocks, reachability", "contracts and proofs")


def structure(controller: str, task: Task, episodes: int, seed: int) -> Says:
    """What holds in every environment: of a net, invariants and what never happens; of anything else there is nothing to explore."""
    net = _net(controller, task)
    method = "every environment: states, standstill, bounds"
    if net is None:
        return [{"method": method, "can": False, "says": "there is no net to explore", "seconds": 0.0}]
    begin = time.process_time()
    report = analyze(net, budget=Budget(seconds=SECONDS), contract=False)
    timed, untimed = report.timed, report.untimed
    whole = timed is not None and timed.complete
    states = timed.states if timed is not None else untimed.states
    says = f"{states:,} states{'' if whole else ' and more'}, bounded: {_word(untimed.bounded.holds)}"
    if timed is not None:
        says += f", never stands still: {_word(timed.never_stops.holds)}"
    return [{"method": method, "can": True, "says": says, "seconds": time.process_time() - begin}]


def contracts(controller: str, task: Task, episodes: int, seed: int) -> Says:
    """Whether each module of a net keeps the contract of behaviour modules in every environment."""
    net, method = _net(controller, task), "every environment: contracts of the modules"
    if net is None or not net.modules:
        return [{"method": method, "can": False, "says": "nothing says what its parts promise", "seconds": 0.0}]
    begin = time.process_time()
    kept = {name: check_contract(module, budget=Budget(seconds=SECONDS)).holds for name, module in sorted(net.modules.items())}
    good = sum(holds is True for holds in kept.values())
    others = ", ".join(f"{name}: {_word(holds)}" for name, holds in kept.items() if holds is not True)
    says = f"{good} of {len(kept)} modules keep theirs" + (f" ({others})" if others else "")
    return [{"method": method, "can": True, "says": says, "seconds": time.process_time() - begin}]


METHODS: dict[str, Callable[[str, Task, int, int], Says]] = {"in a world": in_a_world, "structure": structure, "contracts": contracts}
"""Name -> method: (controller, task, episodes, seed) -> what it says. A further one is put in under its name."""


def _word(holds: bool | None) -> str:
    return {True: "yes", False: "no", None: "not decided"}[holds]


def _net(controller: str, task: Task) -> Any:
    cprm = getattr(make_player(controller, Condition())(task, "left_1"), "cprm", None)
    return None if cprm is None else cprm.net


def tried(task: str, player: str, seed: int) -> dict[str, Any]:
    """All methods on one controller; ``player`` is ``controller, EPISODES episodes``."""
    controller, episodes = player.rsplit(", ", 1)
    made, found = make_task(task), []
    for method in METHODS.values():
        found += method(controller, made, int(episodes.split()[0]), seed)
    return {"found": found}
