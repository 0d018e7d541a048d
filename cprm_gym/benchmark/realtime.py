"""The eleven against the clock: one cycle each 100 ms, as the real server plays it, and what is late is not played.

``python -m cprm_gym.benchmark.realtime --cycles 600`` plays a match of the CPRM eleven against a scripted team in real time and prints
what its decisions took, what is to spare, and how many came too late; ``--fast`` does not wait for the clock.

A cycle begins when the server plays it. The players then get what they perceive and decide one after the other on one core: each alone,
as eleven clients would, or (``--together``) the goalie and the ten outfield players as one batch. An action that is ready before the
next cycle begins is sent; one that is not is dropped, and its player does nothing in that cycle, as at the server. If the decisions of
one cycle take even longer, the server goes on without the team, and the cycles in between are missed too.

The garbage collector does not run while anybody decides: what exists when the match begins is frozen, automatic collection is off, and
young objects are collected in the time to spare of each cycle, old ones every `FULL` cycles. What that takes is reported. Before the
match the players practise: plans of inference are made at the first use of each relation, and kernels are loaded.
"""

from __future__ import annotations

import argparse
import gc
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..agents.eleven import Eleven
from ..envs.controller import Action, no_action
from ..envs.core import SoccerCore
from ..envs.players.scripted import STRENGTHS
from ..envs.tasks import make_task
from ..errors import ParameterError, unknown_name
from .arguments import at_least

CYCLE_MS = 100.0
"""A cycle of the server (``simulator_step``)."""
PRACTICE = 300
"""Cycles that the players play among themselves before the match."""
FULL = 50
"""Cycles between two collections of all generations."""


@dataclass(frozen=True)
class Course:
    """What a match took.

    Attributes
    ----------
    cycle_ms, deadline_ms : float
        Length of a cycle, and the time after its beginning up to which an action counts.
    agents : tuple of str
        Who decides: ``left_1``, or ``left_2 ... left_11`` for a batch.
    wall, cpu : (cycles, agents) float arrays
        Time of each decision, ms, from what was perceived to the action; `cpu` is that of the whole process.
    late : (cycles, players) bool array
        Whose action was not sent.
    skipped : int
        Cycles that the server played while a decision of an earlier one was still going on; they count as missed by everybody.
    collect : (cycles,) float array
        Time of the garbage collector in the time to spare, ms.
    server : (cycles,) float array
        Time in which the server and the scripted team played the cycle, ms.
    goals : (int, int)
    """

    cycle_ms: float
    deadline_ms: float
    agents: tuple[str, ...]
    wall: np.ndarray
    cpu: np.ndarray
    late: np.ndarray
    skipped: int
    collect: np.ndarray
    server: np.ndarray
    goals: tuple[int, int]

    @property
    def misses(self) -> int:
        """Actions that were not sent."""
        return int(self.late.sum()) + self.skipped * self.late.shape[1]

    @property
    def together(self) -> tuple[np.ndarray, np.ndarray]:
        """(cycles,) wall and CPU time of all decisions of a cycle, ms."""
        return self.wall.sum(axis=1), self.cpu.sum(axis=1)


class Match:
    """A match of the CPRM eleven, on the left, against a scripted team.

    Parameters
    ----------
    opponent : str
        Strength of the scripted team: ``weak``, ``medium`` or ``strong``.
    together : bool
        The outfield players decide as one batch.
    cycle_ms : float
    deadline_ms : float, optional
        Time after the beginning of a cycle up to which an action counts; the whole cycle if not given.
    fast : bool
        Do not wait for the clock: the next cycle begins when the decisions of this one are made.
    seed : int
    practice : int
        Cycles of practice before the match.
    clock, sleep : callables
        Time now, and waiting, in seconds.

    Raises
    ------
    UnknownName
        For another opponent.
    ParameterError
        For a time that is not positive.
    """

    def __init__(
        self,
        opponent: str = "weak",
        together: bool = False,
        *,
        cycle_ms: float = CYCLE_MS,
        deadline_ms: float | None = None,
        fast: bool = False,
        seed: int = 0,
        practice: int = PRACTICE,
        clock: Callable[[], float] = time.perf_counter,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        if opponent not in STRENGTHS:
            raise unknown_name("opponent", opponent, STRENGTHS)
        deadline_ms = cycle_ms if deadline_ms is None else deadline_ms
        for name, value in (("cycle_ms", cycle_ms), ("deadline_ms", deadline_ms)):
            if not value > 0.0:
                raise ParameterError(f"{name} {value!r}: a time in milliseconds above 0 is expected")
        self.cycle_ms, self.deadline_ms, self.fast, self.seed = cycle_ms, deadline_ms, fast, seed
        self.clock, self.sleep = clock, sleep
        self.task = make_task("Soccer11v11")
        self.eleven = Eleven(self.task, "left", together)
        self.core = SoccerCore(self.task, 1, controlled="left", others=("hold", opponent), include=("memory",), seed=seed)
        self._idle = self._actions([None] * len(self.eleven.agents))
        self._begin(seed + 1)
        for _ in range(practice):
            self._step(self.eleven.act(self.core.observation))
        self._begin(seed)

    def _begin(self, seed: int) -> None:
        self.core.reset(seed)
        self.eleven.reset(self.core.observation, seed)

    def _step(self, action: Action) -> bool:
        """One cycle of the server; True when the match is over."""
        step = self.core.step(action)
        return bool(step.terminated[0] or step.truncated[0])

    def _actions(self, chosen: list[Action | None]) -> Action:
        """The actions of all players as one; nothing for those of whom there is none."""
        rows = self.eleven.rows
        parts = [no_action(row.stop - row.start) if action is None else action for row, action in zip(rows, chosen)]
        return {key: np.concatenate([part[key] for part in parts])[None] for key in parts[0]}

    def play(self, cycles: int) -> Course:
        """Play some cycles, or up to the end of the match.

        The garbage collector is as it was afterwards.
        """
        agents, players = len(self.eleven.agents), len(self.eleven.names)
        wall, cpu, late = np.zeros((cycles, agents)), np.zeros((cycles, agents)), np.zeros((cycles, players), bool)
        collect, server = np.zeros(cycles), np.zeros(cycles)
        done, skipped, over = 0, 0, False
        was_on = gc.isenabled()
        gc.collect()
        gc.freeze()
        gc.disable()
        try:
            begin = self.clock()
            while done < cycles and not over:
                chosen: list[Action | None] = []
                for i, (agent, rows) in enumerate(zip(self.eleven.agents, self.eleven.rows)):
                    start, used = self.clock(), time.process_time()
                    action = agent.act(self.eleven.view(self.core.observation, i))
                    cpu[done, i] = 1e3 * (time.process_time() - used)
                    now = self.clock()
                    wall[done, i] = 1e3 * (now - start)
                    in_time = 1e3 * (now - begin) <= self.deadline_ms
                    late[done, rows] = not in_time
                    chosen.append(action if in_time else None)
                spare = self.clock()
                gc.collect(2 if done % FULL == FULL - 1 else 0)
                collect[done] = 1e3 * (self.clock() - spare)
                begin, missed = self._next_cycle(begin)
                over = self._step(self._actions(chosen))
                for _ in range(missed):
                    over = over or self._step(self._idle)
                skipped += missed
                server[done] = 1e3 * (self.clock() - begin)
                done += 1
        finally:
            gc.unfreeze()
            if was_on:
                gc.enable()
        left, right = (int(goals) for goals in self.core.sim.world["score"][0])
        names = tuple(_name(self.eleven.names[rows]) for rows in self.eleven.rows)
        return Course(self.cycle_ms, self.deadline_ms, names, wall[:done], cpu[:done], late[:done], skipped, collect[:done], server[:done],
                      (left, right))  # fmt: skip

    def _next_cycle(self, begin: float) -> tuple[float, int]:
        """Wait for the next cycle: when it begins, and how many have gone by since the one that began at `begin`."""
        now = self.clock()
        if self.fast:
            return now, 0
        period = 1e-3 * self.cycle_ms
        missed = max(0, int((now - begin) / period + 1e-9))
        begin += period * (missed + 1)
        if missed == 0 or begin > now:
            self.sleep(max(0.0, begin - now))
        return begin, missed


def _name(agents: tuple[str, ...]) -> str:
    return agents[0] if len(agents) == 1 else f"{agents[0]} ... {agents[-1]}"


def table(course: Course) -> str:
    """The times and what is to spare, as text."""
    wall, cpu = course.together
    lines = [f"{'ms':26}{'wall':>8}{'99 %':>8}{'worst':>8}{'CPU':>10}{'99 %':>8}{'worst':>8}"]
    lines.append(_row("all decisions of a cycle", wall, cpu))
    lines += [_row(name, course.wall[:, i], course.cpu[:, i]) for i, name in enumerate(course.agents)]
    lines += [_row("server and opponents", course.server), _row("garbage collector", course.collect)]
    spare = [
        f"{what} median {1.0 - np.median(values) / course.cycle_ms:.1%}, 99 % {1.0 - np.percentile(values, 99) / course.cycle_ms:.1%}"
        for what, values in (("CPU", cpu), ("wall", wall))
    ]
    lines.append(f"to spare of {course.cycle_ms:g} ms: {'; '.join(spare)}")
    cycles, players = course.late.shape
    lines.append(f"deadline {course.deadline_ms:g} ms: {course.misses} of {(cycles + course.skipped) * players} actions missed, "
                 f"{course.skipped} cycles skipped")  # fmt: skip
    return "\n".join(lines)


def _row(name: str, *series: np.ndarray) -> str:
    """Median, 99th percentile and worst of each series."""
    numbers = [f"{np.median(v):{10 if k else 8}.2f}{np.percentile(v, 99):8.2f}{v.max():8.2f}" for k, v in enumerate(series)]
    return f"{name:26}" + "".join(numbers)


def main(arguments: list[str] | None = None) -> None:
    """Play and print."""
    parser = argparse.ArgumentParser(description="The CPRM eleven against a scripted team, against the clock.")
    parser.add_argument("--cycles", type=at_least(1), default=600)
    parser.add_argument("--cycle-ms", type=float, default=CYCLE_MS)
    parser.add_argument("--deadline-ms", type=float, default=None, help="the whole cycle if not given")
    parser.add_argument("--opponent", choices=tuple(STRENGTHS), default="weak")
    parser.add_argument("--together", action="store_true", help="the outfield players as one batch")
    parser.add_argument("--fast", action="store_true", help="do not wait for the clock")
    parser.add_argument("--seed", type=at_least(0), default=0)
    parser.add_argument("--practice", type=at_least(0), default=PRACTICE, help="cycles of practice before the match")
    options = parser.parse_args(arguments)
    match = Match(
        options.opponent, options.together, cycle_ms=options.cycle_ms, deadline_ms=options.deadline_ms, fast=options.fast,
        seed=options.seed, practice=options.practice,
    )  # fmt: skip
    course = match.play(options.cycles)
    way = "a batch of ten and the goalie" if options.together else "eleven apart"
    pace = "as fast as it goes" if options.fast else f"{options.cycle_ms:g} ms a cycle"
    print(f"CPRM eleven ({way}) against {options.opponent}, {len(course.wall)} cycles, {pace}, seed {options.seed}: "
          f"goals {course.goals[0]} : {course.goals[1]}")  # fmt: skip
    print(table(course))


if __name__ == "__main__":
    main()
