"""Experiment 1: all tasks, all controllers."""

from __future__ import annotations

import numpy as np

from ....agents.knowledge.players import PLAYERS
from ....agents.registry import MODELLED
from ....envs.tasks import TASKS, make_task
from ..cells import Cell, Size, Wanted
from ..comparisons import Comparison, Pair, compare
from ..conditions import DEFAULT
from ..pieces import FAILS, HOLDS, IN_PART, MATTERS, UNDECIDED, Dots, Finding, Table, Told, listed, numbers, percent
from ..players import AGAIN, NET, STRUCTURES, WEAKENED, believes, not_installed, plays, registered
from ..results import Results

TITLE = "Every task, every controller"
QUESTION = "Who succeeds at what, how fast, and what does a decision cost?"
QUICK_TASKS = ("GoToBall", "LostAndFound", "Hike", "KickOffShot", "Goalie")
MATCHES = ("Soccer", "Soccer5v5", "Soccer11v11")
"""Left out: a match takes as long as hundreds of drills."""
FORGETS = "belief_region"
"""The structure without a memory."""
CLOSE = 0.1
"""How far behind the best structure the others may be and still count as able."""
SECONDS = 0.1


def tasks(size: Size) -> tuple[str, ...]:
    """What is played."""
    return tuple(name for name in TASKS if name not in MATCHES) if size.full else QUICK_TASKS


def players(task: str) -> list[str]:
    """Who plays a task: the registered controllers, and the task's net on the memory where the CPRM is more than that."""
    names = [name for name in registered() if plays(name, task)]
    apart = (task in PLAYERS or task not in MODELLED) and believes(task)
    return names[:1] + [NET] + names[1:] if apart else names


def wanted(size: Size) -> list[Wanted]:
    """Tasks x controllers."""
    return [Wanted(Cell(task, DEFAULT, player), size.table) for task in tasks(size) for player in players(task)]


def tell(results: Results, size: Size) -> Told:
    """The table, and who is better than whom."""
    rows, panels, pairs = [], [], []
    for task in tasks(size):
        bars: list[tuple[str, float, float, float]] = []
        metric = make_task(task).metric
        cells = {player: results.played(task, DEFAULT, player) for player in players(task)}
        common = min((cell.n for cell in cells.values() if cell is not None), default=0)
        for player, cell in cells.items():
            if cell is None:
                continue
            found = cell.first(common)
            cycles = found.cycles[found.success]
            if metric == "duration":
                mean, spread = SECONDS * found.cycles.mean(), SECONDS * found.cycles.std() / found.n**0.5
                value = (float(mean), float(mean - 1.96 * spread), float(mean + 1.96 * spread))
                shown = f"{value[0]:.1f} s ({value[1]:.1f} - {value[2]:.1f})"
                bars.append((player, *value))
            else:
                shown = percent(found.rate())
                bars.append((player, *found.percents()))
            rows.append((task, player, str(found.n), shown, f"{np.median(cycles):.0f}" if len(cycles) else "-",
                         f"{found.reward.mean():.2f}", f"{found.microseconds:.0f}"))  # fmt: skip
        if bars:
            panels.append(
                Dots(task, tuple(bars), "seconds" if metric == "duration" else "success, %", 0.0 if metric == "duration" else 100.0)
            )
        pairs += _pairs(results, task)
    comparisons = tuple(compare(pairs))
    head = ("task", "player", "n", "success %, Wilson 95 %; or seconds", "median cycles to success", "reward", "us a decision")
    told = Told("table", TITLE, QUESTION, (Table("All of it", head, tuple(rows)),), tuple(panels), comparisons)
    return Told(**{**vars(told), "findings": _findings(results, told, size), "notes": _notes(size)})


def _pairs(results: Results, task: str) -> list[Pair]:
    """CPRM and net, each with everybody else."""
    found = []
    names = [p for p in players(task) if p not in WEAKENED]
    for own in [name for name in ("cprm", NET) if name in names]:
        for other in names:
            if other not in ("cprm", NET) or (own == "cprm" and other == NET):
                pair = results.pair(task, DEFAULT, own, other)
                found += [pair] if pair is not None else []
    return found


def _findings(results: Results, told: Told, size: Size) -> tuple[Finding, ...]:
    found = []
    compared = [c for c in told.comparisons if c.first in ("cprm", NET) and c.second not in ("cprm", NET)]
    if compared:
        ours = [c for c in compared if c.better == c.first]
        theirs = [c for c in compared if c.better == c.second]
        worst = min(compared, key=lambda c: c.difference)
        figure = (
            f"Of {len(compared)} comparisons of the CPRM or its net with another controller, {len(ours)} are decided "
            f"for it and {len(theirs)} "
            f"against it. The worst for it: {worst.first} less {worst.second} in {worst.task}, {numbers(worst)}."
        )
        alike = [
            c for c in compared if c.second in STRUCTURES and c.second != FORGETS and (c.first == NET or not _has_net(compared, c.task))
        ]
        apart = [c for c in alike if c.better and abs(c.difference) > MATTERS]
        wide = [c for c in alike if max(-c.low, c.high) > 2 * MATTERS]
        figure += (
            f" Structures that remember, with the same knowledge as the net, differ decidedly by more than {100 * MATTERS:.0f} points in "
        )
        figure += f"{len(apart)} of {len(alike)}."
        verdict = (HOLDS if not wide else UNDECIDED) if not apart else IN_PART if 2 * len(apart) <= len(alike) else FAILS
        found.append(Finding("performance", verdict, figure))
    behind, tried = [], 0
    for task in tasks(size):
        code = results.played(task, DEFAULT, "code")
        best = [r for r in (results.played(task, DEFAULT, name) for name in ("cprm", NET)) if r is not None]
        if code is None or not best or make_task(task).metric == "duration":
            continue
        tried += 1
        gap = max(r.rate()[0] for r in best) - code.rate()[0]
        behind += [f"{task} ({100 * gap:.1f} points)"] if gap > CLOSE else []
    if tried:
        verdict = HOLDS if not behind else IN_PART if len(behind) < tried else FAILS
        said = (
            f"behind by more than {100 * CLOSE:.0f} points in {listed(behind)}"
            if behind
            else f"within {100 * CLOSE:.0f} points of it, or ahead, in all"
        )
        found.append(Finding("code can", verdict, f"Code plays {tried} tasks that the CPRM plays: {said}."))
    return tuple(found)


def _has_net(compared: list[Comparison], task: str) -> bool:
    return any(c.first == NET and c.task == task for c in compared)


def _notes(size: Size) -> tuple[str, ...]:
    alone = [task for task in tasks(size) if "cprm" not in players(task)]
    notes = [f"{NET} is the task's own Petri net on the environment's dead reckoning: what the other structures know, too; it stands "
             "where cprm knows more than that, and is else the same. Each has the numbers that were tuned for what it knows."]  # fmt: skip
    notes.append(f"{listed(WEAKENED)} are weak on purpose: a floor, and not compared. {listed(AGAIN)} are the CPRM and its net under other "
                 "names, and not played again.")  # fmt: skip
    if alone:
        notes.append(f"No CPRM plays {listed(alone)}; nothing of ours is compared there.")
    notes += [f"{name} did not play: the package {package} is not installed." for name, package in not_installed().items()]
    notes.append(f"Matches ({listed(MATCHES)}) are not part of the suite.")
    return tuple(notes)
