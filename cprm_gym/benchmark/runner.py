"""Tasks x controllers, the same worlds for all, in batches that can be interrupted and taken up again.

World k of a task depends on (seed, k) alone, so the worlds can be played in blocks of any workers and in any order with the same
results. A block that is finished is one line of ``episodes.jsonl``; what was to be played stands in ``plan.json`` beside it.
"""

from __future__ import annotations

import json
import multiprocessing
import signal
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..envs.controller import check_action
from ..envs.core import SoccerCore, select_agents
from ..envs.tasks import TASKS, make_task
from ..errors import CprmError, ParameterError, unknown_name
from ..files import write_atomically
from .registry import controller_entries, load_controller

BLOCK = 125
"""Episodes played as one batch; a fixed number, so that results do not depend on the number of workers."""


@dataclass(frozen=True)
class Plan:
    """What is to be measured.

    Raises
    ------
    UnknownName
        For a task or controller that does not exist; the message lists those that do.
    ParameterError
        For a number that makes no sense; the message names it, what was given and what is allowed.
    """

    tasks: tuple[str, ...] = ("GoToBall",)
    controllers: tuple[str, ...] = ("cprm", "fsm", "random")
    episodes: int = 500
    seed: int = 0

    def __post_init__(self) -> None:
        for kind, names, known in (("task", self.tasks, list(TASKS)), ("controller", self.controllers, list(controller_entries()))):
            if not names:
                raise ParameterError(f"{kind}s: none given; known are {', '.join(known)}")
            for i, name in enumerate(names):
                if name not in known:
                    raise unknown_name(kind, name, known)
                if name in names[:i]:
                    raise ParameterError(f"{kind} {name!r} is named twice")
        for number, value, least in (("episodes", self.episodes, 1), ("seed", self.seed, 0)):
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise ParameterError(f"{number}: {value!r} given, a whole number of at least {least} is needed")

    def blocks(self) -> list[Block]:
        """All blocks, in the order of the report."""
        return [
            Block(task, controller, first, min(BLOCK, self.episodes - first), self.seed)
            for task in self.tasks
            for controller in self.controllers
            for first in range(0, self.episodes, BLOCK)
        ]

    def write(self, folder: Path) -> None:
        """Note in the folder of a run what is to be played there (``plan.json``)."""
        write_atomically(folder / "plan.json", json.dumps(asdict(self), indent=2) + "\n")

    @classmethod
    def read(cls, folder: Path) -> Plan:
        """The plan noted by `write`.

        Raises
        ------
        CprmError
            When there is none, or it cannot be read.
        """
        path = folder / "plan.json"
        try:
            data = json.loads(path.read_text(encoding="utf-8"))
            values: Any = {key: tuple(value) if isinstance(value, list) else value for key, value in data.items()}
            return cls(**values)
        except FileNotFoundError:
            raise CprmError(f"{folder}: there is no plan.json; the folder of an interrupted run is needed") from None
        except CprmError as error:
            raise CprmError(f"{path}: {error}") from None
        except (OSError, ValueError, TypeError, AttributeError) as error:
            raise CprmError(f"{path}: not the plan of a run: {error}") from None


@dataclass(frozen=True)
class Block:
    """Episodes ``first ... first + count - 1`` of one task and controller."""

    task: str
    controller: str
    first: int
    count: int
    seed: int


@dataclass
class BlockResult:
    """What a block gave, or the error that its controller raised."""

    block: Block
    success: list[bool] = field(default_factory=list)
    cycles: list[int] = field(default_factory=list)
    """Cycles of each episode until success, other end or time-out."""
    reward: list[float] = field(default_factory=list)
    error: str | None = None
    wall_seconds: float = 0.0
    controller_seconds: float = 0.0
    """CPU seconds inside the controller."""
    decisions: int = 0
    played: int = 0
    """Cycles of worlds simulated."""

    def to_json(self) -> str:
        """One line of ``episodes.jsonl``."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, line: str) -> BlockResult:
        """The result written by `to_json`."""
        data = json.loads(line)
        return cls(**{**data, "block": Block(**data["block"])})


def play_block(block: Block) -> BlockResult:
    """Play the episodes of one block.

    A controller that raises yields a result with its error; everything else is an error of ours and propagates.
    """
    result = BlockResult(block)
    begin = time.perf_counter()
    try:
        _play(replace(block, count=1), BlockResult(block), most=3)  # compiles what is not compiled yet, before the clock runs
        begin = time.perf_counter()
        _play(block, result)
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{Path(where.filename).name}, line {where.lineno}, in {where.name}"
        result = BlockResult(block, error=f"{type(error).__name__}: {error} ({place})")
    result.wall_seconds = time.perf_counter() - begin
    return result


def _play(block: Block, result: BlockResult, most: int | None = None) -> None:
    """All episodes of the block at once, until the last one is over (or `most` cycles have been played)."""
    task, count = make_task(block.task), block.count
    agents = select_agents(task.controlled, task.left, task.right)
    # several agents of one world: each has a controller of its own, which sees nothing but that agent's observation
    controllers = [load_controller(block.controller)(task, agent) for agent in agents]
    needs = tuple(dict.fromkeys(part for controller in controllers for part in getattr(controller, "needs", ())))
    core = SoccerCore(task, count, controlled=agents, seed=block.seed, first_world=block.first, view="hybrid", include=needs)
    observation = core.reset(block.seed)
    spent = -time.process_time()
    for i, controller in enumerate(controllers):
        controller.reset(_of_agent(observation, i), _controller_seed(block, i))
    spent += time.process_time()
    running = np.ones(count, bool)
    success, cycles, reward = np.zeros(count, bool), np.zeros(count, np.int64), np.zeros(count)
    while running.any() and (most is None or result.played < most * count):
        actions = []
        for i, controller in enumerate(controllers):
            spent -= time.process_time()
            action = controller.act(_of_agent(observation, i))
            spent += time.process_time()
            actions.append(check_action(block.controller, action, count))
        step = core.step({key: np.stack([np.asarray(action[key]) for action in actions], axis=1) for key in actions[0]})
        cycles += running
        reward += np.where(running, step.reward.mean(axis=1), 0.0)
        success |= running & step.success
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
    plan: Plan,
    *,
    workers: int = 1,
    journal: Path | None = None,
    on_result: Callable[[BlockResult, int, int], Any] | None = None,
) -> Iterator[BlockResult]:
    """Play all blocks of a plan that the journal does not hold yet.

    Parameters
    ----------
    plan : Plan
    workers : int
        Processes; 1 plays in this process.
    journal : Path, optional
        ``episodes.jsonl``: finished blocks are read from it and appended to it.
    on_result : callable, optional
        Called with (result, done, total) after every block.

    Yields
    ------
    BlockResult
        In the order in which they are finished; those of the journal first.

    Raises
    ------
    ParameterError
        For fewer workers than one.
    CprmError
        When a worker dies.
    """
    check_workers(workers)
    blocks = plan.blocks()
    if journal is not None:
        _cut_torn_line(journal)
    finished = {r.block: r for r in read_journal(journal)} if journal is not None else {}
    done, total = 0, len(blocks)
    for block in blocks:
        if block in finished:
            done += 1
            if on_result:
                on_result(finished[block], done, total)
            yield finished[block]
    todo = [b for b in blocks if b not in finished]
    for result in _play_all(todo, workers):
        if journal is not None and result.error is None:
            with journal.open("a", encoding="utf-8") as file:
                file.write(result.to_json() + "\n")
        done += 1
        if on_result:
            on_result(result, done, total)
        yield result


def check_workers(workers: int) -> None:
    """Refuse a number of workers below one."""
    if workers < 1:
        raise ParameterError(f"workers: {workers!r} given, at least 1 is needed")


def _play_all(blocks: Sequence[Block], workers: int) -> Iterator[BlockResult]:
    if workers == 1 or len(blocks) < 2:
        yield from map(play_block, blocks)
        return
    # fresh processes: threads and compiled code of this one are not copied into them
    pool = ProcessPoolExecutor(min(workers, len(blocks)), mp_context=multiprocessing.get_context("spawn"))
    before = set(multiprocessing.active_children())
    try:
        with _deaf_to_interrupts():
            pending: set[Future[BlockResult]] = {pool.submit(play_block, b) for b in blocks}
        while pending:
            ready, pending = wait(pending, return_when=FIRST_COMPLETED)
            for future in ready:
                yield future.result()
    except BaseException as error:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in set(multiprocessing.active_children()) - before:
            process.terminate()
        if isinstance(error, BrokenProcessPool):
            raise CprmError("a worker was ended from outside, perhaps for want of memory: take fewer --workers") from None
        raise
    finally:
        pool.shutdown()


@contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Processes started here leave Ctrl-C to this one, which ends them."""
    if threading.current_thread() is not threading.main_thread():  # only that one may say so
        yield
        return
    previous = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous)


def _cut_torn_line(path: Path) -> None:
    """Remove a last line that an interruption left unfinished, so that the next one begins on a line of its own."""
    if path.exists():
        content = path.read_bytes()
        whole = content.rfind(b"\n") + 1
        if whole < len(content):
            with path.open("r+b") as file:
                file.truncate(whole)


def read_journal(path: Path) -> list[BlockResult]:
    """The finished blocks of a journal; a last line cut short by an interruption is left out.

    Raises
    ------
    CprmError
        When another line cannot be read; the message names file and line.
    """
    if not path.exists():
        return []
    lines = path.read_text(encoding="utf-8", errors="replace").split("\n")
    results = []
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            results.append(BlockResult.from_json(line))
        except (ValueError, TypeError, KeyError) as error:
            if number == len(lines):
                break
            reason = f"there is no {error}" if isinstance(error, KeyError) else str(error)
            raise CprmError(f"{path}, line {number}: not a result of a block: {reason}") from error
    return results
