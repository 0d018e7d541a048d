"""Tasks x controllers, the same worlds for all, in batches that can be interrupted and taken up again.

World k of a task depends on (seed, k) alone, so the worlds can be played in blocks of any workers and in any order with the same
results. A block that is finished is one line of ``episodes.jsonl`` (`journal`); what was to be played stands in ``plan.json`` beside it.
"""

from __future__ import annotations

import math
import os
import shlex
import signal
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import nullcontext
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from ..envs.controller import Controller, check_action
from ..envs.core import SoccerCore, select_agents
from ..envs.others.registry import load_controller
from ..envs.play import rehearse
from ..envs.tasks import make_task
from ..errors import ControllerError, ParameterError
from ..workers import check_workers, results
from .journal import Journal, Planned
from .plan import Block, BlockResult

START_SECONDS = 2.5
"""CPU time that a worker takes to start."""
COMPILING = 600.0
"""Seconds beyond the time-out that a first decision may take, in which kernels are compiled."""


def play_block(block: Block, timeout: float = math.inf) -> BlockResult:
    """Play the episodes of one block.

    Parameters
    ----------
    block : Block
    timeout : float
        Seconds that one decision may take.

    Returns
    -------
    BlockResult
        With the error of a controller that raised, ended the program or thought for too long; everything else is an error of ours and
        propagates.
    """
    result = BlockResult(block)
    begin = time.perf_counter()
    try:
        # compiles what is not compiled yet, before the clock runs
        _play(replace(block, count=1), BlockResult(block), Limit(timeout + COMPILING), most=3)
        begin = time.perf_counter()
        _play(block, result, Limit(timeout))
    except (Exception, SystemExit, GeneratorExit) as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{Path(where.filename).name}, line {where.lineno}, in {where.name}"
        result = BlockResult(block, error=f"{type(error).__name__}: {error} ({place})")
    result.wall_seconds = time.perf_counter() - begin
    return result


class Limit:
    """Ends what takes too long.

    Where the operating system has an alarm clock and this is the main thread, as it is in workers, Python code and waiting are interrupted;
    elsewhere, and in compiled code, the excess is found when the call returns.

    Parameters
    ----------
    seconds : float
        From the beginning of each ``with`` to its end.
    """

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        rings = hasattr(signal, "setitimer") and threading.current_thread() is threading.main_thread()
        self._rings = rings and math.isfinite(seconds)

    def __enter__(self) -> None:
        self._begin = time.monotonic()
        if self._rings:
            self._previous = signal.signal(signal.SIGALRM, self._ring)
            signal.setitimer(signal.ITIMER_REAL, self.seconds)

    def __exit__(self, kind: object, *_: object) -> None:
        if self._rings:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, self._previous)
        if kind is None and time.monotonic() - self._begin > self.seconds:
            self._ring()

    def _ring(self, *_: object) -> None:
        raise ControllerError(f"a decision took longer than {self.seconds:g} s (--timeout)")


def _play(block: Block, result: BlockResult, limit: Limit, most: int | None = None) -> None:
    """All episodes of the block, until the last one is over (or `most` cycles have been played): at once, or on a server in turn."""
    task = make_task(block.task)
    agents = select_agents(task.controlled, task.left, task.right)
    # several agents of one world: each has a controller of its own, which sees nothing but that agent's observation
    controllers = [load_controller(block.controller)(task, agent) for agent in agents]
    needs = tuple(dict.fromkeys(part for controller in controllers for part in getattr(controller, "needs", ())))
    worlds = 1 if block.backend else block.count
    if block.backend:
        rehearse(task, load_controller(block.controller), agents[0])
    core = SoccerCore(task, worlds, controlled=agents, seed=block.seed, first_world=block.first, include=needs, backend=block.backend)
    try:
        for first in range(block.first, block.first + block.count, worlds):
            core.sim.first_world = first
            part = BlockResult(replace(block, first=first, count=worlds))
            _play_core(part.block, part, limit, most, core, controllers)
            for name in ("success", "cycles", "reward", "decisions", "played", "controller_seconds"):
                setattr(result, name, getattr(result, name) + getattr(part, name))
    finally:
        core.close()


def _play_core(block: Block, result: BlockResult, limit: Limit, most: int | None, core: SoccerCore, controllers: list[Controller]) -> None:
    """Episodes of an engine by its agents' controllers."""
    count, agents = core.worlds, core.agents
    observation = core.reset(block.seed)
    spent = -time.process_time()
    for i, controller in enumerate(controllers):
        with limit:
            controller.reset(_of_agent(observation, i), _controller_seed(block, i))
    spent += time.process_time()
    running = np.ones(count, bool)
    success, cycles, reward = np.zeros(count, bool), np.zeros(count, np.int64), np.zeros(count)
    while running.any() and (most is None or result.played < most * count):
        actions = []
        for i, controller in enumerate(controllers):
            spent -= time.process_time()
            with limit:
                action = controller.act(_of_agent(observation, i))
            spent += time.process_time()
            actions.append(check_action(block.controller, action, count))
        step = core.step({key: np.stack([np.asarray(action[key]) for action in actions], axis=1) for key in actions[0]})
        cycles += running
        reward += np.where(running, step.reward.mean(axis=1), 0.0)
        success |= running & step.success.any(axis=1)
        running &= ~(step.terminated | step.truncated)
        result.decisions += count * len(agents)
        result.played += count
    result.success, result.cycles, result.reward = success.tolist(), cycles.tolist(), reward.tolist()
    result.controller_seconds = spent


def _controller_seed(block: Block, agent: int = 0) -> int:
    """A seed for the controller of an agent of a block that depends on the seed, the worlds and the agent alone."""
    key = [block.seed, block.first] + [agent] * (agent > 0)
    return int(np.random.SeedSequence(key).generate_state(1)[0])


def _of_agent(observation: dict[str, np.ndarray], agent: int) -> dict[str, np.ndarray]:
    """Views of one agent's observations."""
    return {key: value[:, agent] for key, value in observation.items()}


def run(
    plan: Planned,
    *,
    workers: int | None = 1,
    journal: Path | None = None,
    timeout: float = math.inf,
    on_result: Callable[[BlockResult, int, int], Any] | None = None,
    told: Callable[[str], Any] | None = None,
    play: Callable[[Block, float], BlockResult] | None = None,
    ray: str | None = None,
) -> Iterator[BlockResult]:
    """Play all blocks of a plan that the journal does not hold yet.

    Parameters
    ----------
    plan : Planned
    workers : int, optional
        Processes; 1 plays in this process. None: as many as pay (`workers_for`), judged by the first block, which is played here.
    journal : Path, optional
        ``episodes.jsonl``: finished blocks are read from it and appended to it, by one process at a time.
    timeout : float
        Seconds that one decision may take; longer is an error of the controller.
    on_result : callable, optional
        Called with (result, done, total) after every block.
    told : callable, optional
        Called with what was chosen where `workers` is None.
    play : callable, optional
        How a block is played, (block, timeout) -> result, if not by `play_block`; a function of a module, so that workers find it.
    ray : str, optional
        A Ray cluster that plays instead of `workers` (`cprm_gym.workers.results`).

    Yields
    ------
    BlockResult
        In the order in which they are finished; those of the journal first.

    Raises
    ------
    ParameterError
        For fewer workers than one, or a time-out that is not positive.
    CprmError
        When workers die again and again, the journal is damaged or another process writes it.
    """
    check_workers(workers)
    if not timeout > 0:
        raise ParameterError(f"timeout: {timeout!r} given, a number of seconds above 0 is needed")
    blocks = plan.blocks()
    kept = None if journal is None else Journal(journal, plan)
    with nullcontext() if kept is None else kept.held():
        if kept is not None:
            kept.cut_torn_line()
        finished = {} if kept is None else kept.read()
        todo = [block for block in blocks if block not in finished]
        known = (finished[block] for block in blocks if block in finished)
        for done, result in enumerate(chain(known, _play_as_pays(todo, workers, timeout, play or play_block, told, ray)), 1):
            if kept is not None and result.error is None and result.block not in finished:
                kept.append(result)
            if on_result:
                on_result(result, done, len(blocks))
            yield result


def workers_for(seconds: float, blocks: int) -> int:
    """How many processes pay for blocks that take so many seconds each: starting them is at most a quarter of the work.

    No more than there are processors for this process, or blocks.
    """
    processors = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return max(1, min(processors, blocks, int(seconds * blocks / (4 * START_SECONDS))))


def again_with(workers: int | None, ray: str | None = None) -> str:
    """How a command says who plays when it is typed again."""
    if ray is not None:
        return f" --ray {shlex.quote(ray)}"
    return f" --workers {workers}" if workers is not None and workers > 1 else ""


def _play_as_pays(
    blocks: Sequence[Block], workers: int | None, timeout: float, play: Callable[[Block, float], BlockResult],
    told: Callable[[str], Any] | None, ray: str | None,
) -> Iterator[BlockResult]:  # fmt: skip
    """The blocks, by so many workers, or after a first block by as many as pay, or by a Ray cluster."""
    if workers is not None or ray is not None or len(blocks) < 2:
        yield from results(play, [(block, timeout) for block in blocks], workers or 1, ray)
        return
    begin = time.process_time()
    yield play(blocks[0], timeout)
    seconds, left = time.process_time() - begin, len(blocks) - 1
    workers = workers_for(seconds, left)
    if told is not None:
        told(f"{workers} {'worker' if workers == 1 else 'workers'}: {left} blocks of about {seconds:.1f} s are left")
    yield from results(play, [(block, timeout) for block in blocks[1:]], workers)
