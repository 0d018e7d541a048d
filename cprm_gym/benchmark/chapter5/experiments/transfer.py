"""Experiment 8: worlds for which nobody was tuned or trained."""

from __future__ import annotations

from ....agents.knowledge.players import PLAYERS as NETS
from ..cells import Cell, Size, Wanted
from ..comparisons import Comparison, compare
from ..conditions import DEFAULT, shifts_of
from ..pieces import FAILS, HOLDS, IN_PART, UNDECIDED, Curves, Finding, Point, Series, Table, Told, percent, points
from ..players import LEARNED, NET, STRUCTURES, UNTUNED, believes, plays
from ..results import Results

TITLE = "Other worlds"
QUESTION = "What is left of each where ball, players, starts or opponents differ?"
TASKS = ("Goalie", "Goalie2v1", "GoToBall", "LostAndFound", "HFO1v0")
QUICK_PLAYERS = (NET, UNTUNED, "fsm", "code")


def _tasks(size: Size) -> tuple[str, ...]:
    return TASKS if size.full else TASKS[:1]


def _players(task: str, size: Size) -> list[str]:
    names = (*_nets(task), *STRUCTURES[1:], LEARNED, "scripted") if size.full else QUICK_PLAYERS
    return [name for name in names if plays(name, task)]


def _nets(task: str) -> tuple[str, ...]:
    """The CPRM, and where the numbers of its net were tuned the net with these and with those set by hand."""
    if task not in NETS or NETS[task].study_for("memory") is None:
        return ("cprm",)
    return ("cprm", NET, UNTUNED) if believes(task) else (NET, UNTUNED)


def _conditions(task: str, size: Size) -> list[str]:
    shifts = shifts_of(task)
    return [DEFAULT, *(shifts if size.full else shifts[:2])]


def wanted(size: Size) -> list[Wanted]:
    """Tasks x shifts x players."""
    return [
        Wanted(Cell(task, where, player), size.curve)
        for task in _tasks(size) for where in _conditions(task, size) for player in _players(task, size)
    ]  # fmt: skip


def tell(results: Results, size: Size) -> Told:
    """Success in each world, and whether what is ahead at home is ahead there."""
    rows, panels, pairs = [], [], []
    for task in _tasks(size):
        conditions, series = _conditions(task, size), []
        for player in _players(task, size):
            points = []
            for x, where in enumerate(conditions):
                found = results.played(task, where, player)
                if found is None:
                    continue
                rows.append((task, where, player, str(found.n), percent(found.rate())))
                points.append(Point(float(x), *found.percents()))
                for own in (NET, "cprm"):
                    if player not in ("cprm", NET) and own in _players(task, size):
                        pair = results.pair(task, where, own, player)
                        pairs += [pair] if pair is not None else []
            series += [Series(player, tuple(points))] if points else []
        if series:
            ticks = tuple((float(x), "as it is" if where == DEFAULT else where) for x, where in enumerate(conditions))
            panels.append(Curves(task, tuple(series), ticks, ""))
    comparisons = compare(pairs)
    notes = (
        f"{UNTUNED} has the numbers set by hand, {NET} those tuned on the standard task; all other structures have the "
        f"net's. Where there is no {NET}, cprm is the only form of the net there. {LEARNED}: trained on the standard task, where "
        "such a policy comes with the project. Each controller knows the parameters of its server, as the server tells its players.",
    )
    head = ("task", "world", "player", "n", "success %, Wilson 95 %")
    return Told("transfer", TITLE, QUESTION, (Table("Success", head, tuple(rows)),), tuple(panels), tuple(comparisons),
                _findings(results, comparisons, size), notes)  # fmt: skip


def _learned(results: Results, size: Size) -> str:
    """What is left of the policies that were trained, beside the net."""
    parts = []
    for task in _tasks(size):
        shifts = _conditions(task, size)[1:]
        shown = []
        for player in (LEARNED, NET if NET in _nets(task) else "cprm"):
            home, away = results.played(task, DEFAULT, player), [results.played(task, where, player) for where in shifts]
            rates = [100 * found.rate()[0] for found in away if found is not None]
            if home is not None and rates:
                shown.append(f"{player} {100 * home.rate()[0]:.1f} %, elsewhere {min(rates):.1f} to {max(rates):.1f}")
        if len(shown) == 2:
            parts.append(f"{task} at home {'; '.join(shown)}")
    return f" Trained policies: {'. '.join(parts)}." if parts else ""


def _findings(results: Results, comparisons: list[Comparison], size: Size) -> tuple[Finding, ...]:
    signs = {(c.task, c.condition, c.first, c.second): (c.better == c.first) - (c.better == c.second) for c in comparisons}
    turned, kept, same, home_decided = 0, 0, 0, 0
    for (task, where, first, second), sign in signs.items():
        home = signs.get((task, DEFAULT, first, second))
        if where == DEFAULT or home is None:
            continue
        kept += home * sign >= 0
        turned += home * sign < 0
        home_decided += home != 0
        same += home * sign > 0
    tuned = [c for c in comparisons if c.second == UNTUNED and c.first == NET and c.condition != DEFAULT]
    if not kept and not turned:
        return ()
    enough = 0 < home_decided <= 2 * same
    whole = HOLDS if home_decided == same else IN_PART
    verdict = (whole if enough else UNDECIDED) if not turned else IN_PART if kept else FAILS
    text = f"Of {home_decided} comparisons that are decided at home {same} are decided the same way in another world, "
    text += f"{home_decided - same - turned} are no longer decided there and {turned} are turned round; {kept + turned} were made."
    more = ""
    if tuned:
        ahead, behind = sum(c.better == c.first for c in tuned), sum(c.better == c.second for c in tuned)
        least = min(tuned, key=lambda c: c.difference)
        more = (f"Numbers tuned at home are ahead of those set by hand in {ahead} and behind in {behind} of {len(tuned)}; at the least "
                f"{points(least)} ({least.task}, {least.condition}).")  # fmt: skip

    return (Finding("transfer", verdict, text, more + _learned(results, size)),)
