"""``cprm-gym ladder``: a round robin of graded opponents, and their ratings."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from ...errors import CprmError
from ...workers import check_workers
from ..runner import again_with, run
from .plan import LadderPlan, Standing, play_games, save, standings


class Played(NamedTuple):
    """A round robin, as far as it came."""

    plan: LadderPlan
    folder: Path
    table: list[Standing]
    again: str
    """The command that goes on, where it was interrupted; empty otherwise."""


def play_ladder(
    given: dict[str, Any],
    resume: Path | None,
    new_folder: Callable[[], Path],
    workers: int | None,
    told: Callable[[int, int, str], None],
    said: Callable[[str], None] | None = None,
    ray: str | None = None,
) -> Played:
    """Play a round robin, or go on with one, and write ``ladder.json`` and ``ladder.md`` in its folder.

    Parameters
    ----------
    given : dict
        Fields of `LadderPlan`.
    resume : Path, optional
        Folder of an interrupted one, which says what is played.
    new_folder : callable
        Makes the folder otherwise.
    workers : int, optional
        Processes; ratings do not depend on it. None: as many as pay.
    told : callable
        Called with blocks done, blocks in all and who has just played.
    said : callable, optional
        Called with the number of workers that was chosen, in words.
    ray : str, optional
        A Ray cluster that plays instead of workers.

    Raises
    ------
    CprmError
        For a plan that is given twice, and as `standings`.
    """
    check_workers(workers)
    if resume is not None:
        if given:
            raise CprmError("--resume takes up a round robin as it was planned: leave out what is to be played")
        plan, folder = LadderPlan.read(resume), resume
    else:
        plan = LadderPlan(**given)
        folder = new_folder()
        plan.write(folder)
    results, again = [], ""
    total = len(plan.blocks())
    try:
        for result in run(plan, workers=workers, journal=folder / "episodes.jsonl", play=play_games, told=said, ray=ray):
            results.append(result)
            told(len(results), total, result.block.controller)
    except KeyboardInterrupt:
        again = f"cprm-gym ladder --resume {shlex.quote(str(folder))}{again_with(workers, ray)}"
    if again and not results:
        return Played(plan, folder, [], again)
    table, ratings = standings(plan, results)
    save(folder, plan, table, ratings)
    return Played(plan, folder, table, again)
