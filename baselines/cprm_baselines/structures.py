"""Structure x knowledge: the same skills, the same worlds, other structures, other tiers of knowledge.

    python -m cprm_baselines.structures --task Goalie --senses "noise .5" --tiers memory,tracker,belief --episodes 400
    python -m cprm_baselines.structures --task KickOffShot

Every structure plays the same worlds with the same skills and numbers, so a row differs from the next in structure alone, a tier from
the next in knowledge alone. ``net`` is the agents' own Petri net, on what the tier knows. The difference is paired, to the net on the
same tier.
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

from cprm_gym.agents.knowledge import informed
from cprm_gym.agents.knowledge.players import PLAYERS
from cprm_gym.agents.registry import BINS
from cprm_gym.agents.registry import make_controller as cprm
from cprm_gym.benchmark.arguments import at_least
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.knowledge import SENSES
from cprm_gym.benchmark.statistics import paired_difference, wilson_interval
from cprm_gym.envs.controller import Controller
from cprm_gym.envs.tasks import Task, make_task
from cprm_gym.errors import UnknownName, unknown_name

STRUCTURES = ("net", "fsm", "subsumption", "behavior_tree", "code", "belief_region")


class Row(NamedTuple):
    """What one structure did on one tier."""

    structure: str
    tier: str
    success: float
    low: float
    high: float
    cycles: float
    """Mean length of an episode."""
    difference: tuple[float, float, float] | None
    """Success less that of the net on the same tier, and its 95 % interval."""
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


def compare(
    task: str,
    senses: str = "default",
    tiers: Sequence[str] = ("memory",),
    structures: Sequence[str] = STRUCTURES,
    episodes: int = 400,
    seed: int = 0,
) -> list[Row]:
    """Play them.

    Parameters
    ----------
    task, senses : str
        Senses as the suite ``knowledge`` names them.
    tiers, structures : sequence of str
    episodes, seed : int

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
    made = make_task(task, **(PLAYERS[task].options if task in PLAYERS else {}))
    rows, net = [], {}
    for tier in tiers:
        for structure in structures:
            make = maker(structure, task)
            try:
                make(made, "left_1")
            except UnknownName:
                continue
            begin = time.process_time()
            played = play_episodes(made, informed(make, tier, SENSES[senses]), episodes, seed, senses=SENSES[senses])
            spent = time.process_time() - begin
            if structure == "net":
                net[tier] = played.success
            interval = wilson_interval(int(played.success.sum()), episodes)
            other = paired_difference(played.success, net[tier]) if tier in net and structure != "net" else None
            rows.append(
                Row(
                    structure, tier, float(played.success.mean()), interval.low, interval.high, float(played.cycles.mean()),
                    None if other is None else (other.mean, other.low, other.high), 1e6 * spent / float(played.cycles.sum()),
                )
            )  # fmt: skip
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
    parser.add_argument("--json", type=Path, help="add the rows to this file")
    given = parser.parse_args()
    try:
        rows = compare(given.task, given.senses, given.tiers.split(","), given.structures.split(","), given.episodes, given.seed)
    except UnknownName as error:
        parser.error(str(error))
    if not rows:
        parser.error(f"none of {given.structures} plays {given.task}")
    print(f"{given.task}, {given.senses}, {given.episodes} worlds of seed {given.seed}\n")
    print("| structure | tier | success %, Wilson 95 % | less the net, paired 95 % | cycles | us a cycle |\n|---|---|---|---|---|---|")
    for row in rows:
        less = "" if row.difference is None else "{:+.1f} ({:+.1f}, {:+.1f})".format(*(100 * v for v in row.difference))
        print(
            f"| {row.structure} | {row.tier} | {100 * row.success:.1f} ({100 * row.low:.1f} - {100 * row.high:.1f}) | {less} | "
            f"{row.cycles:.1f} | {row.microseconds:.0f} |"
        )
    if given.json is not None:
        kept = json.loads(given.json.read_text(encoding="utf-8")) if given.json.exists() else []
        kept += [
            {"task": given.task, "senses": given.senses, "episodes": given.episodes, "seed": given.seed, **row._asdict()} for row in rows
        ]
        given.json.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
