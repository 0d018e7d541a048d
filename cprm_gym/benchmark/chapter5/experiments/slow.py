"""Experiment 4: inference that is slow, with reflexes and without."""

from __future__ import annotations

from ..cells import Cell, Size, Wanted
from ..comparisons import Comparison, Pair, compare
from ..conditions import DEFAULT, LATENCIES, PERIODS
from ..pieces import Curves, Finding, Point, Series, Table, Told, percent, points, verdict_of
from ..players import BELIEVING, BLIND, LATE, NET, ON, REFLEXES
from ..results import Played, Results
from ..watching import MOST

TITLE = "Slow inference"
QUESTION = "What is left of an agent whose inference takes time, and what do reflexes save?"
TASK = "Goalie"
WITH, WITHOUT, REGIONS = BELIEVING, BLIND, f"belief_region{ON}belief{LATE}"
SEEING = f"belief_region{ON}belief{REFLEXES}"
"""The same regions, told by the eye what it sees in this cycle."""
PLAYERS = (WITH, WITHOUT, REGIONS, SEEING)
AXES: dict[str, tuple[tuple[float, str], ...]] = {
    "latency: cycles until a result is there": ((0.0, DEFAULT), *((float(n), f"inference {n} late") for n in LATENCIES)),
    "t_B: cycles from one inference to the next": ((1.0, DEFAULT), *((float(n), f"inference every {n}") for n in PERIODS)),
}


def _axes(size: Size) -> dict[str, tuple[tuple[float, str], ...]]:
    return AXES if size.full else {name: axis[:3] for name, axis in list(AXES.items())[:1]}


def _conditions(size: Size) -> list[str]:
    return list(dict.fromkeys(where for axis in _axes(size).values() for _, where in axis))


def wanted(size: Size) -> list[Wanted]:
    """The goalie with his model and his belief regions under both kinds of slowness; his net on dead reckoning, which nothing slows."""
    slow = [Wanted(Cell(TASK, where, player), size.curve) for where in _conditions(size) for player in PLAYERS]
    return [*slow, Wanted(Cell(TASK, DEFAULT, NET), size.curve)]


def _answer(found: Played) -> tuple[float | None, int, int]:
    """Mean cycles to the first answer, answers, events; an event without an answer counts `MOST`."""
    asked = [a for s, a in zip(found.more["asked"], found.more["answer"]) if s]
    mean = sum(MOST if a is None else a for a in asked) / len(asked) if asked else None
    return mean, sum(a is not None for a in asked), len(asked)


def tell(results: Results, size: Size) -> Told:
    """Success and cycles to the first answer."""
    panels, rows, pairs = [], [], []
    for axis, places in _axes(size).items():
        success, speed = [], []
        for player in PLAYERS:
            rates, times = [], []
            for x, where in places:
                found = results.played(TASK, where, player)
                if found is None:
                    continue
                rates.append(Point(x, *found.percents()))
                middle = _answer(found)[0]
                times += [Point(x, middle, middle, middle)] if middle is not None else []
            success += [Series(player, tuple(rates))] if rates else []
            speed += [Series(player, tuple(times))] if times else []
        reckoning = results.played(TASK, DEFAULT, NET)
        if reckoning is not None:  # it does not infer, so nothing is late
            success.append(Series(NET, tuple(Point(x, *reckoning.percents()) for x, _ in places)))
        ticks = tuple((x, f"{x:g}") for x, _ in places)
        if success:
            name = axis.split(":")[0]
            panels.append(Curves(f"{TASK}: {name}, success", tuple(success), ticks, axis))
            panels.append(Curves(f"{TASK}: {name}, cycles from a shot to the first answer", tuple(speed), ticks, axis, "cycles, mean"))
    for where in _conditions(size):
        for player in (*PLAYERS, NET):
            found = results.played(TASK, where, player)
            if found is None:
                continue
            middle, answered, asked = _answer(found)
            rows.append(
                (where, player, str(found.n), percent(found.rate()), "-" if middle is None else f"{middle:.1f}", f"{answered} of {asked}")
            )
        for one, other in ((WITH, WITHOUT), (SEEING, REGIONS), (WITH, REGIONS), (WITH, SEEING)):
            pair = results.pair(TASK, where, one, other)
            pairs += [pair] if pair is not None else []
        slowed, reckoning = results.played(TASK, where, WITH), results.played(TASK, DEFAULT, NET)
        if slowed is not None and reckoning is not None:
            n = min(slowed.n, reckoning.n)
            pairs.append(Pair(TASK, where, WITH, NET, "success", slowed.success[:n], reckoning.success[:n]))
    comparisons = compare(pairs)
    head = (
        "inference",
        "player",
        "n",
        "success %, Wilson 95 %",
        f"mean cycles from a shot to the first answer ({MOST} where there was none)",
        "shots answered",
    )
    notes = (
        f"{WITH}: in a cycle in which the goalie sees the ball he acts on that reading, in others on the belief, of "
        f"which a late result is rolled "
        f"on to now; {WITHOUT}: on the belief alone. {REGIONS}: all that decides is as old as the inference, and taken "
        f"as it is; {SEEING}: the same, but for the own body and a ball that is seen, which he has as the eye tells them in this cycle. "
        f"{NET}: the same decisions on dead reckoning, without a model, which nothing slows. An answer to a shot is the first cycle "
        "after which he moves towards "
        "the ball's way or stands in it.",
    )
    return Told("slow", TITLE, QUESTION, (Table("Success and answers", head, tuple(rows)),), tuple(panels), tuple(comparisons),
                _findings(results, comparisons), notes)  # fmt: skip


def _findings(results: Results, comparisons: list[Comparison]) -> tuple[Finding, ...]:
    told, texts = [], []
    for one, other, whose in ((WITH, WITHOUT, "the net with a model"), (SEEING, REGIONS, "belief regions")):
        slow = [c for c in comparisons if c.condition != DEFAULT and (c.first, c.second) == (one, other)]
        if not slow:
            continue
        told += slow
        most = max(slow, key=lambda c: c.difference)
        times = [_mean(results.played(TASK, most.condition, player)) for player in (one, other)]
        texts.append(
            f"Reflexes put {whose} ahead in {sum(c.better == c.first for c in slow)} of {len(slow)} kinds of slowness, most under "
            f"{most.condition}: {points(most)}; the first answer takes {times[0]} cycles instead of {times[1]}."
        )
    if not told:
        return ()
    more = ""
    without = [c for c in comparisons if c.second == NET]
    if without:
        best = max(without, key=lambda c: c.difference)
        won, lost = sum(c.better == c.first for c in without), sum(c.better == c.second for c in without)
        more = "Against the same decisions on dead reckoning, which nothing slows, the net with model and reflexes is ahead in "
        more += f"{won} and behind in {lost} of {len(without)}; at best {points(best)} ({best.condition})."
    return (Finding("slow", verdict_of(sum(c.better == c.first for c in told), told), " ".join(texts), more),)


def _mean(found: Played | None) -> str:
    mean = None if found is None else _answer(found)[0]
    return "-" if mean is None else f"{mean:.1f}"
