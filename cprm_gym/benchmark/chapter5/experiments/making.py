"""Experiment 9: what it costs to make each."""

from __future__ import annotations

from ....agents.knowledge.players import PLAYERS
from ..cells import Cell, Size, Wanted
from ..facts import SIZE, TUNING
from ..pieces import FAILS, HOLDS, IN_PART, Finding, Table, Told
from ..players import STRUCTURES, plays
from ..results import Results

TITLE = "What it costs to make"
QUESTION = "Lines, parts, numbers and episodes that went into each; and what learners need."
TASKS = ("GoToBall", "KickOffShot", "PassAndAdvance", "Goalie", "LostAndFound", "Hike")


def _tasks(size: Size) -> tuple[str, ...]:
    return TASKS if size.full else TASKS[:4]


def wanted(size: Size) -> list[Wanted]:
    """Sizes of the structures, and the studies of the tasks that have any."""
    sizes = [Wanted(Cell(task, SIZE, name)) for task in _tasks(size) for name in STRUCTURES if plays(name, task)]
    return sizes + [Wanted(Cell(task, TUNING, "studies")) for task in PLAYERS if PLAYERS[task].constants is not None]


def tell(results: Results, size: Size) -> Told:
    """Two tables; there is nothing random in them."""
    rows, lines = [], dict.fromkeys(STRUCTURES, 0)
    for task in _tasks(size):
        for name in STRUCTURES:
            fact = results.fact(SIZE, task, name)
            if fact is None:
                continue
            parts = "-" if fact["parts"] is None else f"{fact['parts']} {fact['what']}"
            if fact["transitions"] is not None:
                parts += f", {fact['transitions']} transitions, {fact['modules']} modules, {fact['variables']} attributes of its model"
            rows.append((task, name, "-" if fact["lines"] is None else str(fact["lines"]), parts))
            lines[name] += fact["lines"] or 0
    tuning = []
    for task in PLAYERS:
        fact = results.fact(TUNING, task, "studies")
        if fact is not None:
            told = ", ".join(f"{tier} {episodes:,}" for tier, episodes in fact["studies"].items()) or "none: set by hand"
            tuning.append((task, str(fact["numbers"]), told))
    notes = (
        "Lines of Python in the controller's own file for the task, without docstrings and comments. All share skills, "
        "thresholds and formulas "
        "written once, which stand in the CPRM's files; its file holds its net, and where it has a model what links "
        "the two; the model's classes are elsewhere. Places "
        "and transitions are counted with all modules embedded.",
        "Learners are not trained here, so the experience that they need is not compared. What trained policies took and reach: "
        "`docs/learning.md`; how to train one: `cprm-gym train --help`.",
    )
    tables = (
        Table("Size for a task", ("task", "player", "lines", "made of"), tuple(rows)),
        Table("Episodes of tuning, by tier", ("task", "numbers tuned", "tier, episodes"), tuple(tuning)),
    )
    findings = []
    if rows:
        said = ", ".join(f"{name} {count}" for name, count in lines.items() if count)
        ours, others = lines["cprm"], [count for name, count in lines.items() if name != "cprm" and count]
        verdict = HOLDS if ours <= min(others, default=ours) else IN_PART if ours <= max(others) else FAILS
        figure = f"Lines for {len(_tasks(size))} tasks: {said}; the CPRM's files also hold the formulas that the others read from them."
        figure += " Learners were not trained, so nothing is said of them."
        findings = [Finding("cost", verdict, figure)]
    return Told("making", TITLE, QUESTION, tables, (), (), tuple(findings), notes)
