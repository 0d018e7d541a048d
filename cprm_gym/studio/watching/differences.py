"""What differs between two runs in one cycle: part by part, so that a page can mark it in both, and in words."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping
from typing import Any

from ..running.frames import Message

TABLES = ("marking", "holds", "clocks", "commands", "beliefs", "evidence")
"""Of an agent's inside, what is compared entry by entry."""
WORDS = {"marking": "marking", "holds": "holds", "clocks": "clock", "beliefs": "belief", "evidence": "reading", "quantities": "quantity"}
"""Table -> the word for one entry of it, in the order in which they are said."""
NAMED = 3
"""Names of a kind that are said in words; the rest is counted."""


def differences(mine: Message, theirs: Message, quantities: Mapping[str, Collection[str]] | None = None) -> Message:
    """What differs between two frames of one cycle.

    Parameters
    ----------
    mine, theirs : dict
        As of `frames.frame`.
    quantities : mapping of str to collection of str, optional
        Agent -> places of its net that are set anew in every cycle (inputs, beliefs, math), told apart from those that hold tokens.

    Returns
    -------
    dict
        Empty where nothing differs. Else some of ``players``, numbers of objects, 0 the ball; ``commands``, agents; ``agents``, name ->
        for each of ``marking``, ``holds``, ``clocks``, ``commands``, ``beliefs``, ``evidence``, ``fired``, ``enabled``, ``relations``
        and ``quantities`` the names that differ; ``status``, both; and always ``what``, the same in words.
    """
    found: Message = {}
    here, there = mine["commands"], theirs["commands"]
    if commands := [name for name in _names(here, there) if here.get(name) != there.get(name)]:
        found["commands"] = commands
    agents = {}
    for name, inner in mine["agents"].items():
        if differs := _inside(inner, theirs["agents"].get(name, {}), (quantities or {}).get(name, ())):
            agents[name] = differs
    if agents:
        found["agents"] = agents
    if players := _players(mine["world"], theirs["world"]):
        found["players"] = players
    if mine["status"] != theirs["status"]:
        found["status"] = [mine["status"], theirs["status"]]
    return {**found, "what": _said(found, mine, theirs)} if found else {}


def _names(*tables: Mapping[str, Any]) -> list[str]:
    return list(dict.fromkeys(name for table in tables for name in table))


def _inside(mine: Mapping[str, Any], theirs: Mapping[str, Any], quantities: Collection[str]) -> Message:
    """Of one agent. One that has no net in one of the runs is compared by what both have."""
    found: Message = {}
    for table in TABLES:
        here, there = mine.get(table), theirs.get(table)
        if here is None or there is None:
            continue
        empty = 0 if table == "marking" else None  # a place that is not said holds nothing
        if names := [name for name in _names(here, there) if here.get(name, empty) != there.get(name, empty)]:
            found[table] = names
    marked = found.pop("marking", [])
    for key, chosen in (("marking", False), ("quantities", True)):
        if names := [name for name in marked if (name in quantities) == chosen]:
            found[key] = names
    for kind in ("fired", "enabled", "relations"):
        here, there = mine.get(kind), theirs.get(kind)
        if here is None or there is None or here == there:
            continue
        a, b = Counter(here), Counter(there)
        other = [x for pair in zip(here, there) if pair[0] != pair[1] for x in pair]  # the same in another order
        found[kind] = list(((a - b) + (b - a)) or dict.fromkeys(other))
    return found


def _players(mine: Mapping[str, Any], theirs: Mapping[str, Any]) -> list[int]:
    """Numbers of the objects that are elsewhere, move or look otherwise, 0 the ball."""
    here, there = ({row[0]: row[1:6] for row in world["players"]} for world in (mine, theirs))
    ball = [0] if mine["ball"] != theirs["ball"] else []
    return ball + [number for number in dict.fromkeys((*here, *there)) if here.get(number) != there.get(number)]


# ------------------------------------------------------------------ in words


def _said(found: Mapping[str, Any], mine: Message, theirs: Message) -> list[str]:
    said = [f"{name}: {mine['commands'].get(name) or 'nothing'}, there {theirs['commands'].get(name) or 'nothing'}"
            for name in found.get("commands", ())]  # fmt: skip
    for name, differs in found.get("agents", {}).items():
        if "fired" in differs:
            here, there = ([t for t in run["agents"][name]["fired"] if t in differs["fired"]] for run in (mine, theirs))
            said.append(f"{name}: fired {', '.join(here) or 'nothing'}; there {', '.join(there) or 'nothing'}")
        for table, word in WORDS.items():
            if table in differs:
                said.append(f"{name}: {word} of {_few(differs[table])}")
        if "relations" in differs:
            said.append(f"{name}: relations {_few(differs['relations'])}")
    said += ["the ball" if number == 0 else _name(number) for number in found.get("players", ())]
    if "status" in found:
        said.append(f"{found['status'][0]}, there {found['status'][1]}")
    return said


def _few(names: list[str]) -> str:
    more = len(names) - NAMED
    return ", ".join(names[:NAMED]) + (f" and {more} more" if more > 0 else "")


def _name(k: int) -> str:
    return f"left_{k}" if k <= 11 else f"right_{k - 11}"
