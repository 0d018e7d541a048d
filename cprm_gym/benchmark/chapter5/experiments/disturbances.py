"""Experiment 3: something goes wrong once in each episode."""

from __future__ import annotations

from collections.abc import Sequence

from ....agents.knowledge.players import PLAYERS as NETS
from ....wrappers.disturbances import DISTURBANCES
from ..cells import Cell, Size, Wanted
from ..comparisons import Comparison, compare
from ..conditions import DEFAULT, EARLY, SOON
from ..pieces import Dots, Finding, Table, Told, listed, percent, points, verdict_of
from ..players import BARE, LEARNED, NET, STRUCTURES, WATCHED, believes, plays
from ..results import Results, median

TITLE = "Something goes wrong"
QUESTION = "Who gets over it, and is more needed than to begin anew?"
TASKS = ("KickOffShot", "Goalie", "PassAndAdvance")
"""The three demonstrations, the dear one last."""
SHORT = ("Goalie",)
"""Of these, the one whose episodes are mostly over before a disturbance's own time."""
QUICK_CONDITIONS = (DEFAULT, "ball displaced", "blind spell")
QUICK_PLAYERS = ("cprm", "fsm", "code", BARE, BARE + WATCHED)


def _conditions(task: str, size: Size) -> tuple[str, ...]:
    if not size.full:
        return QUICK_CONDITIONS
    return (DEFAULT, *(name + EARLY if task in SHORT else name for name in DISTURBANCES))


def _tasks(size: Size) -> tuple[str, ...]:
    return TASKS if size.full else TASKS[:1]


def _players(task: str, size: Size) -> list[str]:
    names = ("cprm", *_net(task), *STRUCTURES[1:], BARE, BARE + WATCHED, LEARNED, "scripted") if size.full else QUICK_PLAYERS
    return [name for name in names if plays(name, task)]


def _net(task: str) -> tuple[str, ...]:
    """The net on the knowledge of the other structures, where the CPRM has more."""
    return (NET,) if task in NETS and believes(task) else ()


def wanted(size: Size) -> list[Wanted]:
    """Demonstrations x disturbances x controllers, and the net without recovery, alone and watched."""
    return [
        Wanted(Cell(task, where, player), size.curve)
        for task in _tasks(size) for where in _conditions(task, size) for player in _players(task, size)
    ]  # fmt: skip


def tell(results: Results, size: Size) -> Told:
    """Success, who has the ball again, and after how many cycles."""
    rows, panels, pairs = [], [], []
    for task in _tasks(size):
        for where in _conditions(task, size):
            bars = []
            for player in _players(task, size):
                found = results.played(task, where, player)
                if found is None:
                    continue
                again, cycles = "-", "-"
                if where != DEFAULT:
                    struck = [a for s, a in zip(found.more["struck"], found.more["again"]) if s]
                    again = f"{sum(a is not None for a in struck)} of {len(struck)}"
                    middle = median(struck)
                    cycles = "-" if middle is None else f"{middle:.0f}"
                rows.append((task, where, player, str(found.n), percent(found.rate()), again, cycles))
                bars.append((player, *found.percents()))
                if player != "cprm":
                    fair = NET if player in STRUCTURES and _net(task) and size.full else "cprm"
                    pair = results.pair(task, where, fair, player)
                    pairs += [pair] if pair is not None else []
            if bars:
                panels.append(Dots(f"{task}: {'undisturbed' if where == DEFAULT else where}", tuple(bars)))
    comparisons = compare(pairs)
    head = ("task", "disturbance", "player", "n", "success %, Wilson 95 %", "had the ball again", "median cycles until then")
    notes = (
        "The strike of an episode is the same for all players. Had the ball again: kicked or caught it after the "
        "disturbance was over, of the "
        f"episodes that were struck before their end. {BARE} is the primary sequence alone; watched, it begins anew "
        f"where its body has done "
        "nothing for 60 cycles. A shot is over after a dozen cycles, so that the goalie is struck in the "
        f"{SOON[0]}nd to {SOON[1]}th. He has no parts for recovery that could be taken away: his places lead him back to his post by "
        f"themselves, so he has no such rival. His structures are compared with his {NET}, which knows what they know; the pair's cprm "
        "knows more than the other structures of the pair do (belief instead of dead reckoning).",
    )
    return Told("disturbances", TITLE, QUESTION, (Table("Success and recovery", head, tuple(rows)),), tuple(panels), tuple(comparisons),
                _findings(comparisons), notes)  # fmt: skip


def watchdogs(comparisons: Sequence[Comparison]) -> list[Comparison]:
    """Of recovery parts with a watchdog in their place, where something goes wrong."""
    return [c for c in comparisons if c.second == BARE + WATCHED and c.condition != DEFAULT]


def own_rules(comparisons: Sequence[Comparison]) -> list[Comparison]:
    """With structures that recover by their own rules, where something goes wrong."""
    return [c for c in comparisons if c.second in STRUCTURES and c.condition != DEFAULT]


def by_task(comparisons: Sequence[Comparison]) -> str:
    """``6 of 6 disturbances of KickOffShot and 0 of 6 of PassAndAdvance``: where the first is ahead."""
    said: list[str] = []
    for task in dict.fromkeys(c.task for c in comparisons):
        here = [c for c in comparisons if c.task == task]
        said.append(f"{sum(c.better == c.first for c in here)} of {len(here)} {'' if said else 'disturbances '}of {task}")
    return listed(said)


def _findings(comparisons: list[Comparison]) -> tuple[Finding, ...]:
    watched, others = watchdogs(comparisons), own_rules(comparisons)
    if not watched:
        return ()
    ahead, behind = [c for c in watched if c.better == c.first], [c for c in watched if c.better == c.second]
    least, most = min(watched, key=lambda c: c.difference), max(watched, key=lambda c: c.difference)
    text = f"Recovery parts are ahead of a watchdog in {by_task(watched)}, and behind in {len(behind)}: from "
    text += f"{points(least)} ({least.task}, {least.condition}) to {points(most)} ({most.task}, {most.condition})."
    more = ""
    if others:
        won, lost = sum(c.better == c.first for c in others), sum(c.better == c.second for c in others)
        more = "Against the other structures, which recover by their own rules, the net is ahead in "
        more += f"{won} and behind in {lost} of {len(others)}."
    return (Finding("recovery", verdict_of(len(ahead), watched), text, more),)
