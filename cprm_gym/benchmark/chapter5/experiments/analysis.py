"""Experiment 7: every method of analysis tried on every controller."""

from __future__ import annotations

from ..cells import Cell, Size, Wanted
from ..facts import ANALYSIS
from ..pieces import FAILS, HOLDS, IN_PART, Finding, Table, Told, listed
from ..players import plays, registered
from ..results import Results

TITLE = "What can be analysed"
QUESTION = "Which methods say something of which controller, in how much time?"
TASK = "GoToBall"
EPISODES = {True: 1000, False: 60}
EVERYWHERE = "every environment"
"""With which the names of those methods begin that hold whatever the world does."""


def _players(size: Size) -> list[str]:
    names = [name for name in registered() if plays(name, TASK)]
    return names if size.full else [name for name in names if name in ("cprm", "fsm", "code", "belief_region")]


def _player(name: str, size: Size) -> str:
    return f"{name}, {EPISODES[size.full]} episodes"


def wanted(size: Size) -> list[Wanted]:
    """All methods on one controller are one cell."""
    return [Wanted(Cell(TASK, ANALYSIS, _player(name, size))) for name in _players(size)]


def tell(results: Results, size: Size) -> Told:
    """Methods down, controllers across."""
    found = {name: results.fact(ANALYSIS, TASK, _player(name, size)) for name in _players(size)}
    said = {name: {entry["method"]: entry for entry in fact["found"]} for name, fact in found.items() if fact is not None}
    methods = list(dict.fromkeys(method for entries in said.values() for method in entries))
    rows = []
    for method in methods:
        cells = []
        for entries in said.values():
            entry = entries.get(method)
            cells.append(
                "-"
                if entry is None
                else f"{'yes' if entry['can'] else 'no'}: {entry['says']}" + (f" [{entry['seconds']:.1f} s]" if entry["can"] else "")
            )
        rows.append((method, *cells))
    able = {name: sum(e["can"] for e in entries.values()) for name, entries in said.items()}
    rows.append(("methods that say something", *(f"{able[name]} of {len(methods)}" for name in said)))
    notes = (
        f"{TASK}; a chain is learned from {EPISODES[size.full]} episodes and judged by as many others. What a "
        f"controller remembers is looked for "
        "from outside: a net's marking, or whole numbers that an object keeps for each world. The share of CPU time in brackets.",
    )
    head = ("method", *said)
    brief = tuple((row[0], *(cell.split(":")[0] for cell in row[1:])) for row in rows)
    tables = (Table("Methods, and what they say", head, tuple(rows)), Table("Which method says something", head, brief, brief=True))
    return Told("analysis", TITLE, QUESTION, tables, (), (), _findings(said), notes)


def _findings(said: dict[str, dict[str, dict[str, object]]]) -> tuple[Finding, ...]:
    if "cprm" not in said:
        return ()
    told = []

    def able(name: str, everywhere: bool) -> set[str]:
        return {m for m, entry in said[name].items() if entry["can"] and m.startswith(EVERYWHERE) == everywhere}

    if "code" in said:
        here, lost = able("code", False), able("cprm", True) - able("code", True)
        missing = able("cprm", False) - here
        verdict = IN_PART if here and lost else HOLDS if lost else FAILS
        text = "Of a controller as it plays, the tools here find what holds in every environment for the net alone. Of code, "
        text += f"{len(here)} of {len(here | missing)} methods that watch it in a world say something, the learned chain among them."
        kinds = listed([method.removeprefix(EVERYWHERE + ": ") for method in sorted(lost)])
        further = f"In every environment: {kinds}."
        further += f" In a world, nothing is said of code by: {listed(sorted(missing))}." if missing else ""
        told.append(Finding("code opaque", verdict, text, further))
    if "fsm" in said:
        more = (able("fsm", True) | able("fsm", False)) - (able("cprm", True) | able("cprm", False))
        said_of = len(able("cprm", True) | able("cprm", False)), len(able("fsm", True) | able("fsm", False))
        told.append(Finding("no better analysed", HOLDS if not more else FAILS,
                            f"{said_of[0]} methods say something of the net; of the state machine as it is played {said_of[1]} do, and all "
                            "of these of the net, too. Whose whole is explored sooner is told under state explosion."
                            if not more else f"Of the machine, not of the net: {listed(sorted(more))}."))  # fmt: skip
    return tuple(told)
