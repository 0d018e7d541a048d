"""Experiment 6: the hike, where the same world asks for opposite actions."""

from __future__ import annotations

from ..cells import Cell, Size, Wanted
from ..comparisons import compare
from ..conditions import DEFAULT
from ..facts import CONTAINED
from ..pieces import FAILS, HOLDS, IN_PART, Dots, Finding, Table, Told, percent
from ..players import INTERNAL, NET, STRUCTURES, plays
from ..results import Played, Results

TITLE = "Memory of an intention"
QUESTION = "Out and home through the same middle: who knows which way he is going, and what does it cost to know?"
TASK, REGIONS, WITHOUT = "Hike", "belief regions", "belief_region"
PLAYERS = (NET, *STRUCTURES, INTERNAL)


def wanted(size: Size) -> list[Wanted]:
    """The net and the structures on the hike, belief regions also with internal variables; and regions against their net."""
    cells = [Wanted(Cell(TASK, DEFAULT, player), size.table) for player in PLAYERS if plays(player, TASK)]
    return [*cells, Wanted(Cell("GoToBall", CONTAINED, REGIONS))]


def tell(results: Results, size: Size) -> Told:
    """Success and decision time."""
    found = {player: results.played(TASK, DEFAULT, player) for player in PLAYERS}
    there = {player: played for player, played in found.items() if played is not None}
    rows = tuple(
        (player, str(p.n), percent(p.rate()), f"{p.cycles[p.success].mean():.0f}" if p.success.any() else "-", f"{p.microseconds:.0f}")
        for player, p in there.items()
    )
    panels = (
        Dots("Hike: success", tuple((player, *p.percents()) for player, p in there.items())),
        Dots("Hike: a decision", tuple((player, p.microseconds, p.microseconds, p.microseconds) for player, p in there.items()), "us", 0.0),
    )
    pairs = [results.pair(TASK, DEFAULT, NET, other) for other in PLAYERS[1:]]
    head = ("player", "n", "success %, Wilson 95 %", "mean cycles of a hike", "us a decision")
    notes = (f"{INTERNAL}: whether he has been at the view is a variable of his model without a reading, inferred in every cycle from "
             "where he was. Decision times are CPU time for 50 worlds at once, divided by them.",)  # fmt: skip
    tables = (Table("The hike", head, rows, brief=True),)
    return Told("memory", TITLE, QUESTION, tables, panels, tuple(compare([p for p in pairs if p is not None])),
                _findings(results, found), notes)  # fmt: skip


def _findings(results: Results, found: dict[str, Played | None]) -> tuple[Finding, ...]:
    told = []
    same = results.fact(CONTAINED, "GoToBall", REGIONS)
    if same is not None:
        verdict = HOLDS if same["alike"] == same["cycles"] else FAILS
        told.append(
            Finding(
                "regions contained",
                verdict,
                f"Regions and their CPRM sent the same in {same['alike']} of {same['cycles']} cycles of random readings.",
            )
        )
    net, regions, internal = found[NET], found[WITHOUT], found[INTERNAL]
    if net is not None and regions is not None:
        lost, kept = regions.rate(), net.rate()
        verdict = HOLDS if lost[2] < kept[1] else FAILS
        told.append(
            Finding(
                "intention",
                verdict,
                f"Belief regions come home in {100 * lost[0]:.1f} % of {regions.n:,} hikes, the net in {100 * kept[0]:.1f} %.",
            )
        )
    if net is not None and internal is not None:
        rate, more = internal.rate(), internal.microseconds / max(net.microseconds, 1e-9)
        verdict = HOLDS if rate[1] > 0.9 and more > 1.5 else IN_PART if rate[1] > 0.9 or more > 1.5 else FAILS
        told.append(Finding("internal", verdict,
            f"With internal variables they come home in {100 * rate[0]:.1f} %, at {internal.microseconds:.0f} us a decision "
            f"instead of the net's {net.microseconds:.0f} ({more:.1f} times).",
            "Both are far below the 100,000 us of a cycle."))  # fmt: skip
    return tuple(told)
