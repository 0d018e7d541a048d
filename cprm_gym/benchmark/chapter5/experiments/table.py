"""Experiment 1: all tasks, all controllers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....agents.knowledge.players import PLAYERS
from ....agents.registry import MODELLED
from ....envs.tasks import TASKS
from ..cells import Cell, Size, Wanted
from ..comparisons import Comparison, Pair, compare
from ..conditions import DEFAULT, MATCHES, metric_of
from ..pieces import FAILS, HOLDS, IN_PART, MATTERS, UNDECIDED, Dots, Finding, Table, Told, listed, percent, points
from ..players import AGAIN, NET, STRUCTURES, TRACKING, WEAKENED, believes, not_installed, plays, registered
from ..results import Results

TITLE = "Every task, every controller"
QUESTION = "Who succeeds at what, how fast, and what does a decision cost?"
QUICK_TASKS = ("GoToBall", "LostAndFound", "Hike", "KickOffShot", "Goalie")
TWICE = {"Soccer": "Soccer11v11"}
"""Tasks that are others under an older name."""
COLUMNS = ("cprm", TRACKING, NET)
HIDDEN = ("eased", "goalie_raw")
"""Not in the short table."""
FORGETS = "belief_region"
"""The structure without a memory."""
CLOSE = 0.1
"""How far behind the best structure the others may be and still count as able."""
SECONDS = 0.1
UNITS = {"success": "success, %", "cycles": "seconds", "goals": "goals ahead"}
"""Metric -> what the axis says."""


def tasks(size: Size) -> tuple[str, ...]:
    """What is played."""
    return tuple(name for name in TASKS if name not in TWICE) if size.full else QUICK_TASKS


def players(task: str) -> list[str]:
    """Who plays a task: the registered controllers, and where the CPRM knows more than dead reckoning its net on that and on a tracker."""
    names = [name for name in registered() if plays(name, task)]
    apart = (task in PLAYERS or task not in MODELLED) and believes(task)
    tracking = [TRACKING] if task in PLAYERS else []
    return names[:1] + tracking + [NET] + names[1:] if apart else names


def wanted(size: Size) -> list[Wanted]:
    """Tasks x controllers."""
    return [Wanted(Cell(task, DEFAULT, player), size.table) for task in tasks(size) for player in players(task)]


def tell(results: Results, size: Size) -> Told:
    """The table, and who is better than whom."""
    rows, panels, pairs = [], [], []
    for task in tasks(size):
        bars: list[tuple[str, float, float, float]] = []
        metric = metric_of(task)
        cells = {player: results.played(task, DEFAULT, player) for player in players(task)}
        common = min((cell.n for cell in cells.values() if cell is not None), default=0)
        for player, cell in cells.items():
            if cell is None:
                continue
            found = cell.first(common)
            cycles = found.cycles[found.success]
            if metric != "success":
                measured, unit = (found.reward, "goals") if metric == "goals" else (SECONDS * found.cycles, "s")
                mean, spread = measured.mean(), measured.std() / found.n**0.5
                value = (float(mean), float(mean - 1.96 * spread), float(mean + 1.96 * spread))
                sign, digits = ("+", 2) if metric == "goals" else ("", 1)
                shown = f"{value[0]:{sign}.{digits}f} {unit} ({value[1]:{sign}.{digits}f} - {value[2]:{sign}.{digits}f})"
                bars.append((player, *value))
            else:
                shown = percent(found.rate())
                bars.append((player, *found.percents()))
            rows.append((task, player, str(found.n), shown, _quartiles(cycles), _mean(found.reward), f"{found.microseconds:.0f}"))
        if bars:
            panels.append(Dots(task, tuple(bars), UNITS[metric], 100.0 if metric == "success" else 0.0))
        pairs += _pairs(results, task)
    comparisons = tuple(compare(pairs))
    head = (
        "task",
        "player",
        "n",
        "success %, Wilson 95 %; or seconds; or goals ahead",
        "cycles to success, median and quartiles",
        "reward, mean 95 %",
        "us a decision",
    )
    tables = (Table("All of it", head, tuple(rows)), _matrix(rows, comparisons, size))
    told = Told("table", TITLE, QUESTION, tables, tuple(panels), comparisons)
    return Told(**{**vars(told), "findings": _findings(results, told, size), "notes": _notes(size)})


def _pairs(results: Results, task: str) -> list[Pair]:
    """CPRM and net, each with everybody else."""
    found = []
    names = [p for p in players(task) if p not in WEAKENED and p != TRACKING]
    rival = results.pair(task, DEFAULT, "cprm", TRACKING)
    found += [rival] if rival is not None else []
    for own in [name for name in ("cprm", NET) if name in names]:
        for other in names:
            if other not in ("cprm", NET) or (own == "cprm" and other == NET):
                pair = results.pair(task, DEFAULT, own, other)
                found += [pair] if pair is not None else []
    return found


def _quartiles(cycles: np.ndarray) -> str:
    if not len(cycles):
        return "-"
    low, middle, high = np.percentile(cycles, (25, 50, 75))
    return f"{middle:.0f} ({low:.0f} - {high:.0f})"


def _mean(values: np.ndarray) -> str:
    half = 1.96 * float(values.std()) / len(values) ** 0.5
    return f"{values.mean():.2f} ({values.mean() - half:.2f} - {values.mean() + half:.2f})"


def _matrix(rows: Sequence[tuple[str, ...]], comparisons: Sequence[Comparison], size: Size) -> Table:
    """Rates without intervals, and who is decidedly better or worse than the net."""
    shown = {(row[0], row[1]): row[3].split(" (")[0] for row in rows}
    names = [name for name in (*COLUMNS, *registered()) if name not in HIDDEN and any(player == name for _, player in shown)]
    names = list(dict.fromkeys(names))
    marks = {}
    for c in comparisons:
        if c.better and c.first == _fair(comparisons, c.task):
            marks[c.task, c.second] = " ▲" if c.better == c.second else " ▼"
        if c.better and (c.first, c.second) == ("cprm", NET):
            marks[c.task, c.first] = " ▲" if c.better == c.first else " ▼"
    there = [task for task in tasks(size) if any((task, name) in shown for name in names)]
    cells = tuple((task, *(shown.get((task, name), "") + marks.get((task, name), "") for name in names)) for task in there)
    return Table("Success in percent, or seconds, or goals ahead", ("task", *names), cells, brief=True)


def _fair(comparisons: Sequence[Comparison], task: str) -> str:
    """Who stands for the architecture in a task: its net, where that is played apart from the CPRM."""
    return NET if _has_net(comparisons, task) else "cprm"


def same_knowledge(comparisons: Sequence[Comparison]) -> list[Comparison]:
    """Of the net and another structure that know the same: where the CPRM has a model and its net is not played apart, there are none."""
    return [
        c for c in comparisons
        if c.second in STRUCTURES and c.second != "cprm" and (c.first == NET or not (_has_net(comparisons, c.task) or believes(c.task)))
    ]  # fmt: skip


def believing(comparisons: Sequence[Comparison]) -> str:
    """What knowing more is worth at ordinary senses: the CPRM less its net on dead reckoning; empty where none was played apart."""
    pairs = [c for c in comparisons if (c.first, c.second) == ("cprm", NET)]
    if not pairs:
        return ""
    ahead, behind = [c for c in pairs if c.better == c.first], [c for c in pairs if c.better == c.second]
    most = [max(some, key=lambda c: c.difference) for some in (
        [c for c in ahead if c.metric == "success"], [c for c in ahead if c.metric != "success"]) if some]  # fmt: skip
    where = f" ({listed([c.task for c in ahead])}; at most {listed([f'{points(c)} in {c.task}' for c in most])})" if ahead else ""
    undecided = len(pairs) - len(ahead) - len(behind)
    text = (
        f"With ordinary senses the CPRM, on a belief, is ahead of its net on dead reckoning in {len(ahead)} of {len(pairs)} tasks{where} "
    )
    text = f"{text}and behind in {len(behind)}; in {undecided} nothing is decided."
    rivals = [c for c in comparisons if (c.first, c.second) == ("cprm", TRACKING)]
    if rivals:
        won, lost = ([c.task for c in rivals if c.better == who] for who in ("cprm", TRACKING))
        more, less = (f" ({listed(names)})" if names else "" for names in (won, lost))
        text += f" Of the net on a tracker it is ahead in {len(won)} of {len(rivals)}{more} and behind in {len(lost)}{less}."
    return text


def _findings(results: Results, told: Told, size: Size) -> tuple[Finding, ...]:
    found = []
    compared = [c for c in told.comparisons if c.first in ("cprm", NET) and c.second not in ("cprm", NET, TRACKING)]
    if compared:
        alike = [c for c in same_knowledge(compared) if c.second != FORGETS]
        rates, times = [c for c in alike if c.metric == "success"], [c for c in alike if c.metric == "cycles"]
        apart = [c for c in rates if c.better and abs(c.difference) > MATTERS]
        wide = [c for c in rates if max(-c.low, c.high) > 2 * MATTERS]
        figure = f"Structures that remember and know the same as the net differ from it decidedly by more than {100 * MATTERS:.0f} points "
        figure += f"in {len(apart)} of {len(rates)} comparisons"
        if apart:
            worst, best = min(apart, key=lambda c: c.difference), max(apart, key=lambda c: c.difference)
            ends = [worst] if worst is best else [worst, best]
            figure += f": {listed([f'{c.first} less {c.second} in {c.task} {points(c)}' for c in ends])}"
        figure += "."
        if times:
            figure += f" How long the ball is kept differs decidedly in {sum(bool(c.better) for c in times)} of {len(times)}."
        ours, theirs = [c for c in compared if c.better == c.first], [c for c in compared if c.better == c.second]
        more = f"Of all {len(compared)} comparisons of the CPRM or its net with another controller, {len(ours)} are decided for it and "
        more += f"{len(theirs)} against it."
        more += f" {believing(told.comparisons)}".rstrip()
        lost = [c for c in theirs if c.metric == "success"]
        if lost:
            worst = min(lost, key=lambda c: c.difference)
            more += f" The worst for it: {worst.first} less {worst.second} in {worst.task}, {points(worst)}."
        verdict = (HOLDS if rates and not wide else UNDECIDED) if not apart else IN_PART if 2 * len(apart) <= len(rates) else FAILS
        found.append(Finding("performance", verdict, figure, more))
    behind, tried = [], 0
    for task in tasks(size):
        code = results.played(task, DEFAULT, "code")
        best_of = [r for r in (results.played(task, DEFAULT, name) for name in ("cprm", NET)) if r is not None]
        if code is None or not best_of or metric_of(task) != "success":
            continue
        tried += 1
        gap = max(r.rate()[0] for r in best_of) - code.rate()[0]
        behind += [f"{task} ({100 * gap:.1f} points)"] if gap > CLOSE else []
    if tried:
        verdict = HOLDS if not behind else IN_PART if len(behind) < tried else FAILS
        said = (
            f"As estimated, code is behind by more than {100 * CLOSE:.0f} points in {listed(behind)}, of {tried} tasks that both play."
            if behind
            else f"No counterexample in {tried} tasks that both play: as estimated, code is within {100 * CLOSE:.0f} points or ahead."
        )
        found.append(Finding("code can", verdict, said))
    return tuple(found)


def _has_net(compared: Sequence[Comparison], task: str) -> bool:
    return any(c.first == NET and c.task == task for c in compared)


def _notes(size: Size) -> tuple[str, ...]:
    alone = [task for task in tasks(size) if "cprm" not in players(task)]
    notes = [f"{NET} is the task's own Petri net on the environment's dead reckoning: what the other structures know, too; it stands "
             "where cprm knows more than that, and is else the same. Tuned numbers are those for what is known."]  # fmt: skip
    notes.append(f"{listed(WEAKENED)} are weak on purpose: a floor, and not compared. {listed(AGAIN)} are the CPRM and its net under other "
                 "names, and not played again.")  # fmt: skip
    if alone:
        notes.append(f"No CPRM plays {listed(alone)}; nothing of ours is compared there.")
    notes += [f"{name} did not play: the package {package} is not installed." for name, package in not_installed().items()]
    if any(task in MATCHES for task in tasks(size)):
        seconds = round(SECONDS * next(iter(MATCHES.values()))["max_cycles"])
        notes.append(
            f"Of matches ({listed(tuple(MATCHES))}) {seconds} s are played, from the left side's kick-off on, against the strong scripted "
            f"team, and told is by how many goals the left side is ahead then. {listed(tuple(TWICE))} is {listed(tuple(TWICE.values()))} "
            "under an older name."
        )
    return tuple(notes)
