"""Structure x knowledge: the same skills, the same worlds, other structures, other tiers of knowledge.

    python -m cprm_baselines.structures --task Goalie --senses "noise .5" --tiers memory,tracker,belief --episodes 400
    python -m cprm_baselines.structures --task PassAndAdvance2v3 --others hold,medium --structures net --tiers memory,tracker,belief,state

Every structure plays the same worlds with the same skills and the numbers tuned for `memory`, so a row differs from the next in structure
alone, a tier from the next in knowledge alone. ``net`` is the agents' own Petri net, on what the tier knows. Differences are paired: to the
net on the same tier, and to the same structure on the first tier. Where the metric of a task is the duration, seconds are told.
"""

from __future__ import annotations

import argparse
import importlib
import json
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cprm_gym.agents.knowledge import informed
from cprm_gym.agents.knowledge.players import PLAYERS
from cprm_gym.agents.registry import BINS
from cprm_gym.agents.registry import make_controller as cprm
from cprm_gym.benchmark.arguments import at_least
from cprm_gym.benchmark.chapter5.comparisons import Pair, interval
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.knowledge import SENSES
from cprm_gym.benchmark.statistics import wilson_interval
from cprm_gym.envs.controller import Controller
from cprm_gym.envs.tasks import Task, make_task
from cprm_gym.errors import UnknownName, unknown_name

SLOTS = 250
"""Episodes played side by side."""
SECONDS = 0.1
"""Of a cycle."""
STRUCTURES = ("net", "fsm", "subsumption", "behavior_tree", "code", "belief_region")


class Row(NamedTuple):
    """What one structure did on one tier."""

    structure: str
    tier: str
    success: float
    """Share of episodes, or seconds that they last."""
    low: float
    high: float
    cycles: float
    """Mean length of an episode."""
    difference: tuple[float, float, float] | None
    """Less the net on the same tier, and its 95 % interval."""
    knowledge: tuple[float, float, float] | None
    """Less the same structure on the first tier, and its 95 % interval."""
    microseconds: float
    """CPU time of a cycle of one world, the world's own included."""


def maker(structure: str, task: str) -> Callable[[Task, str], Controller]:
    """Makes the controllers of a structure for a task."""
    if structure not in STRUCTURES:
        raise unknown_name("structure", structure, STRUCTURES)
    if structure != "net":
        factory: Callable[[Task, str], Controller] = importlib.import_module(f"cprm_baselines.{structure}").make_controller
        return factory
    if task in PLAYERS:
        player = PLAYERS[task]
        return lambda made, agent: player.make(made, agent, player.numbers("memory"))
    return partial(cprm, model=BINS)


def less(task: str, ones: np.ndarray, others: np.ndarray) -> tuple[float, float, float]:
    """Mean difference in the same worlds and its 95 % interval."""
    return interval(Pair(task, "", "", "", "success" if make_task(task).metric == "success" else "seconds", ones, others), 0.05)


def compare(
    task: str,
    senses: str = "default",
    tiers: Sequence[str] = ("memory",),
    structures: Sequence[str] = STRUCTURES,
    episodes: int = 400,
    seed: int = 0,
    others: str = "",
) -> list[Row]:
    """Play them.

    Parameters
    ----------
    task, senses : str
        Senses as the suite ``knowledge`` names them.
    tiers, structures : sequence of str
    episodes, seed : int
    others : str
        Policies of the scripted players, ``left,right``, if they are not those that the task's player is tuned against.

    Returns
    -------
    list of Row
        Without those that do not play the task.

    Raises
    ------
    UnknownName
        For names that there are not.
    """
    if senses not in SENSES:
        raise unknown_name("senses", senses, SENSES)
    options = dict(PLAYERS[task].options) if task in PLAYERS else {}
    made = make_task(task, **(options | {"others": tuple(others.split(","))} if others else options))
    rows: list[Row] = []
    net: dict[str, np.ndarray] = {}
    first: dict[str, np.ndarray] = {}
    for tier in tiers:
        for structure in structures:
            make = maker(structure, task)
            try:
                make(made, "left_1")
            except UnknownName:
                continue
            begin = time.process_time()
            played = play_episodes(made, informed(make, tier, SENSES[senses]), episodes, seed, senses=SENSES[senses], slots=SLOTS)
            spent = time.process_time() - begin
            if made.metric == "success":
                worth, (low, high) = played.success, wilson_interval(int(played.success.sum()), episodes)
            else:
                worth = SECONDS * played.cycles
                low, high = less(task, worth, np.zeros(episodes))[1:]
            known = less(task, worth, first[structure]) if structure in first else None
            first.setdefault(structure, worth)
            other = less(task, worth, net[tier]) if tier in net and structure != "net" else None
            if structure == "net":
                net[tier] = worth
            cost = 1e6 * spent / float(played.cycles.sum())
            rows.append(Row(structure, tier, float(worth.mean()), low, high, float(played.cycles.mean()), other, known, cost))
    return rows


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", default="Goalie")
    parser.add_argument("--senses", default="default")
    parser.add_argument("--tiers", default="memory")
    parser.add_argument("--structures", default=",".join(STRUCTURES))
    parser.add_argument("--episodes", type=at_least(1), default=400)
    parser.add_argument("--seed", type=at_least(0), default=0)
    parser.add_argument("--others", default="", help="policies of the scripted players, LEFT,RIGHT")
    parser.add_argument("--json", type=Path, help="add the rows to this file")
    given = parser.parse_args()
    tiers, structures = given.tiers.split(","), given.structures.split(",")
    try:
        rows = compare(given.task, given.senses, tiers, structures, given.episodes, given.seed, given.others)
    except UnknownName as error:
        parser.error(str(error))
    if not rows:
        parser.error(f"none of {given.structures} plays {given.task}")
    print(f"{given.task}, {given.senses}, {given.episodes} worlds of seed {given.seed}\n")
    lasts = make_task(given.task).metric == "duration"
    what, scale = ("seconds, 95 %", 1.0) if lasts else ("success %, Wilson 95 %", 100.0)
    print(f"| structure | tier | {what} | less the net, paired 95 % | less it on {tiers[0]} | cycles | us a cycle |")
    print("|---|---|---|---|---|---|---|")
    for row in rows:
        net, known = (
            "" if one is None else "{:+.1f} ({:+.1f}, {:+.1f})".format(*(scale * v for v in one)) for one in (row.difference, row.knowledge)
        )
        worth = f"{scale * row.success:.1f} ({scale * row.low:.1f} - {scale * row.high:.1f})"
        print(f"| {row.structure} | {row.tier} | {worth} | {net} | {known} | {row.cycles:.1f} | {row.microseconds:.0f} |")
    if given.json is not None:
        kept = json.loads(given.json.read_text(encoding="utf-8")) if given.json.exists() else []
        kept += [
            {"task": given.task, "senses": given.senses, "episodes": given.episodes, "seed": given.seed, **row._asdict()} for row in rows
        ]
        given.json.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
