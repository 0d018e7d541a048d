"""Who plays what, and how large each is: the made tables of ``docs/baselines.md`` and ``docs/sizes.md``.

``python docs/players.py`` makes them anew: who plays by asking the registered controllers, sizes by reading and counting what they are made
of, decision times from ``docs/results/chapter5.json``.
"""

from __future__ import annotations

import functools
import json
import re
from pathlib import Path
from typing import Any, NamedTuple

from cprm_gym.agents.attacker.constants import HalfFieldConstants
from cprm_gym.agents.keeper.constants import KeeperConstants
from cprm_gym.agents.knowledge.players import PLAYERS
from cprm_gym.agents.match.constants import MatchConstants
from cprm_gym.agents.skills.constants import Constants
from cprm_gym.agents.taker.constants import TakerConstants
from cprm_gym.benchmark.chapter5.facts.sizes import size_of
from cprm_gym.benchmark.chapter5.players import NET
from cprm_gym.envs.others.registry import controller_entries, load_controller
from cprm_gym.envs.tasks import TASKS, make_task
from cprm_gym.errors import ParameterError, UnknownName

DOCS = Path(__file__).parent
RESULTS = DOCS / "results" / "chapter5.json"
PAGES = (DOCS / "baselines.md", DOCS / "sizes.md")
BLOCK = re.compile(r"(<!-- (plays|why|sizes|numbers|times) -->\n)(?:(?!<!-- ).)*(<!-- end -->)", re.DOTALL)


KINDS = ("FrontGoal", "HFO", "Keepaway", "PassAndAdvance", "Soccer", "Goalie", *TASKS)
"""With what names of tasks that are alike begin."""


class Family(NamedTuple):
    """Tasks that are played alike, and for which of their players."""

    tasks: tuple[str, ...]
    agent: str = "left_1"
    """One of these players."""
    who: str = ""
    """What they do, where the other side can be played, too."""
    constants: type[Constants] | None = None
    """Their free constants, where none stand in `PLAYERS`."""

    @property
    def name(self) -> str:
        """First column of a row; what a name shares with the one before it is left out."""
        kinds = [next(kind for kind in KINDS if task.startswith(kind)) for task in self.tasks]
        names = [t.removeprefix(k) if k == before else t for t, k, before in zip(self.tasks, kinds, ("", *kinds))]
        return ", ".join(names) + (f": {self.who}" if self.who else "")


HFO = tuple(name for name in TASKS if name.startswith("HFO"))
FRONT = tuple(name for name in TASKS if name.startswith("FrontGoal"))
PAIRS = ("PassAndAdvance2v1", "PassAndAdvance2v2", "PassAndAdvance2v3")
KEEPAWAY = ("Keepaway3v2", "Keepaway4v3", "Keepaway5v4")
ALONE = ("HFO1v0", "FrontGoalEmptyGoal")
"""Tasks without anybody who defends."""
FAMILIES = (
    Family(("GoToBall",)), Family(("LostAndFound",)), Family(("Hike",)), Family(("KickOffShot",)), Family(("KickOffShot2v2",)),
    Family(("Goalie", "Goalie2v1", "Goalie3v2")), Family(("PassAndAdvance",)), Family(PAIRS),
    Family(KEEPAWAY, "left_1", "keepers", KeeperConstants), Family(KEEPAWAY, "right_1", "takers", TakerConstants),
    Family(HFO, "left_1", "attack"), Family(FRONT, "left_1", "attack"),
    Family(tuple(t for t in (*HFO, *FRONT) if t not in ALONE and TASKS[t]().right > 1), "right_2", "defenders", MatchConstants),
    Family(tuple(t for t in (*HFO, *FRONT) if t not in ALONE), "right_1", "goalie"),
    Family(("Soccer", "Soccer5v5", "Soccer11v11"), "left_2", "outfield players", MatchConstants),
    Family(("Soccer", "Soccer5v5", "Soccer11v11"), "left_1", "goalie"),
)  # fmt: skip
"""All tasks, and everybody in them for whom players were written. Other opponents are the scripted ones of the environment."""
WRITTEN = ("cprm", "fsm", "subsumption", "behavior_tree", "code", "belief_region", "scripted")
"""Hand-written controllers, in the order of columns."""
ONE_TASK = ("goalie_memory", "goalie_raw")
"""Those of one task alone."""
ORDER = (*WRITTEN, "policy", "lesion", "random", "eased", *ONE_TASK)
WHY = {
    ("fsm", "subsumption", "behavior_tree", "code", "belief_region"):
        "do not play matches, nor defend half fields: the net of an outfield player has the attacker's decisions, a formation, marking and "
        "tackling in one, and nobody has written it a second time in five structures.",
    ("policy",): "plays where a policy was trained that ships, and whom it was trained for; elsewhere nobody is trained.",
    ("goalie_memory", "goalie_raw"): "are the goalie's net on less knowledge, for `Goalie`; elsewhere take the tier `memory` or `frozen`.",
}  # fmt: skip
"""Controllers -> why they do not play the tasks that they do not play."""


NOBODY = ("-", "not trained")
"""Cells of who does not play."""


@functools.cache
def plays(controller: str, task: str, agent: str) -> bool:
    """Whether a registered controller plays an agent of a task."""
    try:
        load_controller(controller)(make_task(task), agent)
    except (UnknownName, ParameterError):
        return False
    return True


def cell(controller: str, family: Family) -> str:
    """``yes`` for all tasks, ``-`` for none, else which; those who play by tasks, not by families, are asked for each."""
    none = "-"
    if controller == "policy":  # was trained for the side that learns in the task
        none = "not trained"
        if family.agent != "left_1":
            return none
    asked = family.tasks if controller in ("policy", *ONE_TASK) else family.tasks[:1]
    played = [task for task in asked if plays(controller, task, family.agent)]
    if not played:
        return none
    return "yes" if len(played) == len(asked) else ", ".join(played)


def columns() -> tuple[str, ...]:
    """The registered controllers, in order.

    Raises
    ------
    ValueError
        For one that the order does not name.
    """
    entries = controller_entries()
    others = set(entries) - set(ORDER)
    if others:
        raise ValueError(f"`ORDER` does not name the registered {', '.join(sorted(others))}")
    return tuple(name for name in ORDER if name in entries)


def who_plays() -> str:
    """Families x controllers."""
    names = columns()
    return table(["task", *names], [[family.name, *(cell(name, family) for name in names)] for family in FAMILIES])


def why() -> str:
    """For each controller that does not play everything, why."""
    gaps = {name for name in columns() for family in FAMILIES if cell(name, family) != "yes"}
    told = {name for names in WHY for name in names}
    if gaps != told:
        raise ValueError(f"`WHY` has to tell of {', '.join(sorted(gaps))}; it tells of {', '.join(sorted(told))}")
    return "\n".join(f"* {', '.join(f'`{name}`' for name in names)} {text}" for names, text in WHY.items())


def made_of(found: dict[str, Any]) -> str:
    """Parts of a controller in words."""
    if found["what"] == "places":
        places, transitions = found["apart"]
        text = f"{places} places, {transitions} transitions; with {counted(found['modules'], 'skills')} {found['parts']} and "
        return f"{text}{found['transitions']}" + (f"; {found['variables']} attributes" if found["variables"] else "")
    if found["parts"] is None:
        return "kernels"
    return counted(found["parts"], found["what"]) + (f", {found['rules']} rules" if found["rules"] else "")


def counted(number: int, things: str) -> str:
    """A number of things; of one it is not the plural."""
    return f"{number} {things.removesuffix('s') if number == 1 else things}"


def sizes() -> str:
    """Lines of code and what it is made of, for the first task of each family."""
    rows = []
    for family in FAMILIES:
        for name in WRITTEN:
            if name != "scripted" and cell(name, family) not in NOBODY:
                found = size_of(family.tasks[0], name, 0, family.agent)
                rows.append([family.name, name, str(found["lines"]), str(found["written"]), made_of(found)])
    found = size_of("GoToBall", "scripted", 0)
    rows.append(["all", "scripted", str(found["lines"]), str(found["written"]), f"{made_of(found)} of the environments, for all tasks"])
    return table(["task", "controller", "lines", "numbers written", "made of"], rows)


def constants_of(family: Family) -> type[Constants] | None:
    """The class of the free constants of a family's players."""
    player = PLAYERS.get(family.tasks[0]) if family.agent == "left_1" else None
    if player is not None:
        return player.constants
    return family.constants or (HalfFieldConstants if family.who == "attack" else None)


def numbers() -> str:
    """Free constants that all structures of a family share."""
    rows = []
    for family in FAMILIES:
        kind = constants_of(family)
        if kind is not None:
            rows.append([family.name, f"`{kind.__name__}`", str(len(kind.extents()))])
    return table(["task", "constants", "how many"], rows)


def times() -> str:
    """Microseconds of a decision, by task and controller, as the suite of chapter 5 measured them."""
    cells = {(c["task"], c["player"]): c for c in json.loads(RESULTS.read_text(encoding="utf-8"))["cells"] if c["condition"] == "default"}
    names = ["cprm", NET, *WRITTEN[1:]]
    rows = []
    for task in TASKS:
        if any((task, name) in cells for name in names):
            rows.append([task, *(f"{cells[task, name]['microseconds']:.0f}" if (task, name) in cells else "" for name in names)])
    return table(["task", *names], rows)


MADE = {"plays": who_plays, "why": why, "sizes": sizes, "numbers": numbers, "times": times}
"""Name of a block -> what makes it."""


def table(head: list[str], rows: list[list[str]]) -> str:
    """In Markdown."""
    return "\n".join(["| " + " | ".join(head) + " |", "|" + "---|" * len(head), *("| " + " | ".join(row) + " |" for row in rows)])


def with_parts(text: str, without: tuple[str, ...] = ()) -> str:
    """The page with its made parts anew, but for those `without`."""

    def made(match: re.Match[str]) -> str:
        return match[0] if match[2] in without else f"{match[1]}\n{MADE[match[2]]()}\n\n{match[3]}"

    return BLOCK.sub(made, text)


def main() -> None:
    """Write both pages."""
    for page in PAGES:
        page.write_text(with_parts(page.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
