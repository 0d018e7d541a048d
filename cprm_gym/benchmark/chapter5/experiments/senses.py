"""Experiment 2: how much the senses take, and from where on inference gives it back."""

from __future__ import annotations

from ..cells import Cell, Size, Wanted
from ..comparisons import Comparison, compare
from ..conditions import DEFAULT, DELAYS, LOST, NOISES, VIEWS
from ..pieces import Curves, Finding, Point, Series, Table, Told, listed, percent, points, verdict_of
from ..players import NET, ON, TIERS_SHOWN
from ..results import Results

TITLE = "Worse senses, better knowledge"
QUESTION = "From where on does it pay to infer what is not seen, and how much of the loss comes back?"
TASKS = ("Goalie", "LostAndFound")
INFERRING = ("tracker", "belief")
RIVAL = "memory"
AXES: dict[str, tuple[tuple[float, str], ...]] = {
    "noise, multiples of (15 %, 8 deg)": ((0.0, DEFAULT), *((n, f"noise {n:g}") for n in NOISES)),
    "share of looks that are lost": ((0.0, DEFAULT), *((n, f"lost {n:g}") for n in LOST)),
    "cycles by which all news is late": ((0.0, DEFAULT), *((float(n), f"late {n}") for n in DELAYS)),
    "view cone, degrees": ((60.0, f"view {VIEWS[0]}"), (120.0, DEFAULT), (180.0, f"view {VIEWS[1]}")),
}
"""Axis -> (place, condition)."""
QUICK_AXES = {name: AXES[name][:4] for name in list(AXES)[:1]}


def _axes(size: Size) -> dict[str, tuple[tuple[float, str], ...]]:
    return AXES if size.full else QUICK_AXES


def _tasks(size: Size) -> tuple[str, ...]:
    return TASKS if size.full else TASKS[:1]


def _conditions(size: Size) -> list[str]:
    return list(dict.fromkeys(where for axis in _axes(size).values() for _, where in axis))


def wanted(size: Size) -> list[Wanted]:
    """Tasks x senses x tiers, the same net."""
    return [
        Wanted(Cell(task, where, f"{NET}{ON}{tier}"), size.curve)
        for task in _tasks(size) for where in _conditions(size) for tier in TIERS_SHOWN
    ]  # fmt: skip


def tell(results: Results, size: Size) -> Told:
    """Curves over tiers, and where inference is ahead of dead reckoning."""
    panels, rows, pairs = [], [], []
    for task in _tasks(size):
        for axis, places in _axes(size).items():
            series = []
            for tier in TIERS_SHOWN:
                points = []
                for x, where in places:
                    found = results.played(task, where, f"{NET}{ON}{tier}")
                    if found is not None:
                        points.append(Point(x, *found.percents()))
                series += [Series(tier, tuple(points))] if points else []
            if series:
                panels.append(Curves(f"{task}: {axis.split(',')[0]}", tuple(series), tuple((x, f"{x:g}") for x, _ in places), axis))
        for where in _conditions(size):
            cells = [results.played(task, where, f"{NET}{ON}{tier}") for tier in TIERS_SHOWN]
            if any(cell is not None for cell in cells):
                n = max(cell.n for cell in cells if cell is not None)
                rows.append((task, where, str(n), *("-" if cell is None else percent(cell.rate()) for cell in cells)))
            for tier in INFERRING:
                pair = results.pair(task, where, f"{NET}{ON}{tier}", f"{NET}{ON}{RIVAL}")
                pairs += [pair] if pair is not None else []
    comparisons = compare(pairs)
    head = ("task", "senses", "n", *(f"{tier} %" for tier in TIERS_SHOWN))
    notes = (
        "One net with one set of numbers for each tier (those of its study, else those of memory): only what it knows "
        "differs. frozen carries "
        "nothing on, memory is the environment's dead reckoning, tracker a Kalman filter, belief the relational model "
        "of real numbers; state "
        "is an oracle that knows the truth. Where news is late, memory and frozen are as old as it, tracker and belief roll it on to now.",
    )
    return Told("senses", TITLE, QUESTION, (Table("Success by tier", head, tuple(rows)),), tuple(panels), tuple(comparisons),
                _findings(results, comparisons), notes)  # fmt: skip


def _findings(results: Results, comparisons: list[Comparison]) -> tuple[Finding, ...]:
    if not comparisons:
        return ()
    ahead = [c for c in comparisons if c.better == c.first]
    behind = [c for c in comparisons if c.better == c.second]
    counts, places = [], []
    for task in dict.fromkeys(c.task for c in comparisons):
        played = list(dict.fromkeys(c.condition for c in comparisons if c.task == task))
        where = [name for name in played if any((c.task, c.condition) == (task, name) for c in ahead)]
        counts.append(f"in {len(where)} of {len(played)} senses in {task}")
        noisy = [float(name.split()[1]) for name in where if name.startswith("noise")]
        since = f" (so from noise {min(noisy):g} on)" if noisy else ""
        places.append(f"in {task} under {listed(where)}{since}" if where else f"in {task} nowhere decidedly")
    best = max(comparisons, key=lambda c: c.difference)
    text = f"The better of tracker and belief is ahead of dead reckoning {listed(counts)}. Most: {_short(best.first)} in {best.task}, "
    text += f"{spoken(best.condition)}, {points(best)}{room(results, best)}."
    more = f"Ahead {'; '.join(places)}."
    if behind:
        worst = min(behind, key=lambda c: c.difference)
        more += f" Behind it in {len(behind)} of {len(comparisons)} comparisons, worst {_short(worst.first)} in {worst.task}, "
        more += f"{spoken(worst.condition)}, {points(worst)}."
    return (Finding("inference", verdict_of(len(ahead), comparisons), text, more),)


def spoken(condition: str) -> str:
    """``late 2``: ``news 2 cycles late``."""
    kind, _, how = condition.partition(" ")
    said = {"noise": f"noise of size {how}", "lost": f"{how} of looks lost", "late": f"news {how} cycles late", "view": f"a {how} view"}
    return said.get(kind, "ordinary senses" if condition == DEFAULT else condition)


def _short(player: str) -> str:
    return player.removeprefix(NET + ON)


def room(results: Results, c: Comparison) -> str:
    """What dead reckoning, the better tier and the oracle reach there."""
    found = [results.played(c.task, c.condition, name) for name in (c.second, c.first, f"{NET}{ON}state")]
    rates = [f"{100 * cell.rate()[0]:.0f} %" for cell in found if cell is not None]
    return f": {rates[1]} instead of {rates[0]}, where who knows the truth has {rates[2]}" if len(rates) == 3 else ""
