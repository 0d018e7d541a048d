"""One block of a cell: played, or, where it is a fact, found out."""

from __future__ import annotations

import math
import time
import traceback
from pathlib import Path

from ..episodes import play_episodes
from ..plan import Block, BlockResult
from ..runner import COMPILING, Limit
from .cells import FACT, Cell
from .conditions import condition
from .facts import FACTS
from .players import make_player
from .watching import Answering, Disturbing

SLOTS = 250
"""Episodes played side by side."""
_warm: set[tuple[str, str]] = set()
"""(task, player) whose kernels this process has."""


def play_cell(block: Block, timeout: float = math.inf) -> BlockResult:
    """Play the episodes of one block.

    Parameters
    ----------
    block : Block
        Its controller is ``condition/player`` (`Cell`).
    timeout : float
        Seconds that one decision may take.

    Returns
    -------
    BlockResult
        With the error of a player that raised, ended the program, sent what is no command, or thought for too long.
    """
    begin = time.perf_counter()
    result = BlockResult(block)
    try:
        _measure(block, result, timeout)
    except (Exception, SystemExit, GeneratorExit) as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{Path(where.filename).name}, line {where.lineno}, in {where.name}"
        result = BlockResult(block, error=f"{type(error).__name__}: {error} ({place})")
    result.wall_seconds = time.perf_counter() - begin
    return result


def _measure(block: Block, result: BlockResult, timeout: float) -> None:
    cell = Cell.of(block)
    if block.count == FACT:
        spent = time.process_time()
        result.more = FACTS[cell.condition](cell.task, cell.player, block.seed)
        result.controller_seconds = time.process_time() - spent
        return
    how = condition(cell.condition)
    task, make = how.task(cell.task), make_player(cell.player, how)
    if (cell.task, cell.player) not in _warm:
        play_episodes(task, make, 1, block.seed, block.first, how.senses, limit=Limit(timeout + COMPILING), most=3)
        _warm.add((cell.task, cell.player))
    observer: Disturbing | Answering | None = None
    happening = how.happening()
    if happening is not None:
        observer = Disturbing(happening, block.count, block.seed)
    elif task.name == "Goalie":
        observer = Answering(block.count)
    found = play_episodes(task, make, block.count, block.seed, block.first, how.senses, SLOTS, observer, Limit(timeout))
    result.success, result.cycles, result.reward = found.success.tolist(), found.cycles.tolist(), found.reward.tolist()
    result.controller_seconds, result.decisions, result.played = found.seconds, found.decisions, int(found.cycles.sum())
    if observer is not None:
        result.more = dict(observer.found(block.count))
