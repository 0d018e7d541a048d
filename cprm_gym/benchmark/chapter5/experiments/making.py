"""Experiment 9: what it costs to make each."""

from __future__ import annotations

from typing import Any

from ....agents.knowledge.players import PLAYERS
from ..cells import Cell, Size, Wanted
from ..conditions import DEFAULT
from ..facts import SIZE, TRAINING, TUNING
from ..pieces import FAILS, HOLDS, IN_PART, Finding, Table, Told, listed, percent
from ..players import LEARNED, NET, STRUCTURES, UNTUNED, plays
from ..results import Results

TITLE = "What it costs to make"
QUESTION = "Lines, parts, numbers and episodes that went into each; and how much experience a learner needs to be as good."
TASKS = ("GoToBall", "KickOffShot", "PassAndAdvance", "Goalie", "LostAndFound", "Hike")
LEARNERS = ("GoToBall", "Goalie", "HFO1v0")
"""Tasks for which policies may have been trained."""
OURS = {"cprm": "the CPRM", NET: "its net on dead reckoning", UNTUNED: "that net with numbers by hand"}


def _tasks(size: Size) -> tuple[str, ...]:
    return TASKS if size.full else TASKS[:4]


def _learned(size: Size) -> tuple[str, ...]:
    return tuple(task for task in LEARNERS[: 3 if size.full else 2] if plays(LEARNED, task))


def wanted(size: Size) -> list[Wanted]:
    """Sizes of the structures, the studies of the tasks that have any, the records of trained policies, and how good the CPRM is there."""
    sizes = [Wanted(Cell(task, SIZE, name)) for task in _tasks(size) for name in STRUCTURES if plays(name, task)]
    studies = [Wanted(Cell(task, TUNING, "studies")) for task in PLAYERS if PLAYERS[task].constants is not None]
    records = [Wanted(Cell(task, TRAINING, LEARNED)) for task in _learned(size)]
    goals = [Wanted(Cell(task, DEFAULT, player), size.curve) for task in _learned(size) for player in ("cprm", LEARNED)]
    return [*sizes, *studies, *records, *goals]


def tell(results: Results, size: Size) -> Told:
    """Three tables; of learners, when they were as good as the CPRM."""
    rows, lines, findings = [], dict.fromkeys(STRUCTURES, 0), []
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
    learning = _learning(results, size)
    notes = (
        "Lines of Python in the controller's own file for the task, without docstrings and comments. All share skills, "
        "thresholds and formulas "
        "written once, which stand in the CPRM's files; its file holds its net, and where it has a model what links "
        "the two; the model's classes are elsewhere. Places "
        "and transitions are counted with all modules embedded.",
        "Learners: the record that comes with each trained policy, so of the one training that is kept, the best of several; measured on "
        "its way in few episodes, so that a single figure may be off by some points. As good: the first measurement in which it succeeds "
        "at least as often as the other does here, drawing its actions or taking the likeliest. It learned from nothing but its steps; the "
        "episodes of tuning are of a net that somebody had written.",
    )
    tables = (
        Table("Experience of learners", ("task", "who is to be reached", "success %, Wilson 95 %", "learner", "as good after agent-steps",
                                         "trained for", "what it is made of"), tuple(learning), brief=True),
        Table("Size for a task", ("task", "player", "lines", "made of"), tuple(rows)),
        Table("Episodes of tuning, by tier", ("task", "numbers tuned", "tier, episodes"), tuple(tuning)),
    )  # fmt: skip
    if lines["cprm"]:
        said = ", ".join(f"{name} {count}" for name, count in lines.items() if count)
        ours, others = lines["cprm"], [count for name, count in lines.items() if name != "cprm" and count]
        verdict = HOLDS if ours <= min(others, default=ours) else IN_PART if ours <= max(others) else FAILS
        figure = f"Lines for {len(_tasks(size))} tasks: {said}."
        findings.append(Finding("cost", verdict, figure, "The CPRM's files also hold the formulas that the others read from them."))
    findings += _as_good(results, size)
    return Told("making", TITLE, QUESTION, tables, (), (), tuple(findings), notes)


def reached(curve: list[list[float]], rate: float) -> int | None:
    """Agent-steps of the first entry of a curve in which either way of acting succeeds at least so often; None if there is none."""
    return next((int(steps) for steps, *rates in curve if max(rates) >= rate), None)


def _learning(results: Results, size: Size) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for task in _learned(size):
        fact = results.fact(TRAINING, task, LEARNED)
        if fact is None:
            continue
        for player, who in OURS.items():
            found = results.played(task, DEFAULT, player)
            if found is not None:
                steps = reached(fact["curve"], found.rate()[0])
                rows.append((task, f"{player}: {who}", percent(found.rate()), f"{fact['algorithm']} on {fact['mode']} actions",
                             "never" if steps is None else f"{steps:,}", f"{int(fact['curve'][-1][0]):,}",
                             f"{fact['weights']:,} weights on {fact['inputs']} inputs"))  # fmt: skip
    return rows


def _as_good(results: Results, size: Size) -> list[Finding]:
    """Where a learner is as good as the CPRM, and where not within its training; nothing when no task was measured."""
    good, never = [], []
    for task in _learned(size):
        fact: dict[str, Any] | None = results.fact(TRAINING, task, LEARNED)
        found, policy = results.played(task, DEFAULT, "cprm"), results.played(task, DEFAULT, LEARNED)
        if fact is None or found is None:
            continue
        steps = reached(fact["curve"], found.rate()[0])
        rates = f"{100 * found.rate()[0]:.1f} %" + ("" if policy is None else f", the policy here {100 * policy.rate()[0]:.1f} %")
        if steps is None:
            never.append(f"{task} ({rates}; trained for {int(fact['curve'][-1][0]):,})")
        else:
            good.append(f"{task} after {steps:,} agent-steps ({rates})")
    if not (good or never):
        return []
    said = [f"A learner is as good as the CPRM in {listed(good)}."] * bool(good)
    said += [f"Never within its training in {listed(never)}."] * bool(never)
    verdict = HOLDS if not never else IN_PART if good else FAILS
    return [Finding("learning", verdict, " ".join(said), "Of the tasks for which a policy comes with the project.")]
