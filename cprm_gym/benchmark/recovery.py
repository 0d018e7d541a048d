"""Recovery measured: the passing pair, the striker and attackers against opponents with and without their recovery parts, and with a
watchdog instead (dissertation ch. 4).

``python -m cprm_gym.benchmark.recovery --episodes 1000`` prints the pair's table, with ``--task KickOffShot`` the striker's, with ``--task
PassAndAdvance2v1`` that of a pair against an opponent.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..agents.body import Body
from ..agents.knowledge.players import PLAYERS
from ..agents.passer import make_controller
from ..agents.percepts import field_percepts
from ..agents.play import SoccerAgent
from ..agents.striker import make_controller as make_striker
from ..agents.striker import striker_cprm
from ..envs.controller import Action, Controller, Observation
from ..envs.core import SoccerCore
from ..envs.tasks import Task, make_task
from ..simulator.state import CommandKind, Count
from ..wrappers.disturbances import DISTURBANCES, Disturbance, Disturber
from .arguments import at_least
from .statistics import Interval, wilson_interval

WORLDS = 250
"""Most worlds that are played side by side; each plays its share of the episodes one after the other."""

IDLE = 60
"""Cycles without a command of the body after which the watchdog begins anew."""

Factory = Callable[[Task, str], Controller]


class Watchdog:
    """A controller that is reset, world by world, where its body has done nothing for a while.

    The simplest recovery there is, and the rival of any other: it knows nothing of what went wrong.

    Parameters
    ----------
    controller : Controller
    idle : int
        Cycles without a command of the body.
    """

    def __init__(self, controller: Controller, idle: int = IDLE) -> None:
        self.controller, self.idle = controller, idle
        self.needs: tuple[str, ...] = getattr(controller, "needs", ())
        self._seed = 0
        self._still = np.zeros(0, np.int64)

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes."""
        if worlds is None:
            self._still = np.zeros(len(observation["level"]), np.int64)
        else:
            self._still[worlds] = 0
        self._seed = seed
        self.controller.reset(observation, seed, worlds)

    def act(self, observation: Observation) -> Action:
        """As the controller does; where it has been idle for too long, it begins anew first."""
        stuck = self._still >= self.idle
        if stuck.any():
            self.controller.reset(observation, self._seed, stuck)
            self._still[stuck] = 0
        action = self.controller.act(observation)
        self._still = np.where(action["type"] == CommandKind.NONE, self._still + 1, 0)
        return action


def with_watchdog(task: Task, agent: str) -> Watchdog:
    """One of the pair without recovery parts, watched."""
    return Watchdog(make_controller(task, agent, recovering=False))


LOOP = {"no_pass", "no_return", "out_of_sight", "no_catch", "no_ball", "no_shot", "no_way", "no_goal"}
"""The striker's transitions back to finding and fetching the ball, whatever failed."""


def striker_without(task: Task, agent: str) -> SoccerAgent:
    """The striker's primary sequence alone."""
    body = Body.of(task)
    cprm = striker_cprm(body)
    assert cprm.net is not None
    once = replace(cprm.net, transitions=tuple(t for t in cprm.net.transitions if t.name not in LOOP))
    return SoccerAgent(replace(cprm, net=once), field_percepts, needs=("memory",), body=body)


SECOND_TRIES = {
    "sweep", "look_for_it", "forget_it", "not_taken", "no_longer_taken",
    *(f"{kick}_{outcome}" for kick in ("shoot", "push", "give") for outcome in ("failed", "aborted")),
}  # fmt: skip
"""The attacker's transitions after something went wrong: a lost ball is looked for, a kick that failed is followed by another decision."""


def attacker_on(task: Task, agent: str) -> SoccerAgent:
    """The attacker with the numbers tuned for what he knows here."""
    player = PLAYERS[task.name]
    made = player.make(task, agent, player.numbers("memory"))
    assert isinstance(made, SoccerAgent)
    return made


def attacker_without(task: Task, agent: str) -> SoccerAgent:
    """The attacker for whom nothing goes wrong."""
    made = attacker_on(task, agent)
    net = made.cprm.net
    made.cprm = replace(made.cprm, net=replace(net, transitions=tuple(t for t in net.transitions if t.name not in SECOND_TRIES)))
    return made


ATTACKERS: dict[str, Factory] = {
    "recovering": attacker_on, "without": attacker_without, "watchdog": lambda task, agent: Watchdog(attacker_without(task, agent)),
}  # fmt: skip

RIVALS: dict[str, dict[str, Factory]] = {
    "PassAndAdvance": {"recovering": make_controller, "without": partial(make_controller, recovering=False), "watchdog": with_watchdog},
    "KickOffShot": {"recovering": make_striker, "without": striker_without,
                    "watchdog": lambda task, agent: Watchdog(striker_without(task, agent))},
    "PassAndAdvance2v1": ATTACKERS,
    "KickOffShot2v2": ATTACKERS,
}  # fmt: skip
"""What is compared in a task: the net with its recovery parts, without them, and without them but watched."""


@dataclass(frozen=True)
class Recovery:
    """What a controller made of a disturbance.

    Attributes
    ----------
    success : (N,) bool array
        The task was done.
    struck : (N,) bool array
        The disturbance came before the end of the episode.
    time : (N,) float array
        Cycles from the strike until an agent kicked the ball again, that is, until the pair had the ball; NaN where nobody did.
    cycles : (N,) int array
        Length of the episode.
    """

    success: np.ndarray
    struck: np.ndarray
    time: np.ndarray
    cycles: np.ndarray

    @property
    def interval(self) -> Interval:
        """Wilson interval of the rate of success."""
        return wilson_interval(int(self.success.sum()), len(self.success))

    @property
    def recovered(self) -> tuple[int, int]:
        """Episodes in which the pair had the ball again, and those that were struck."""
        return int(np.isfinite(self.time[self.struck]).sum()), int(self.struck.sum())

    @property
    def median_time(self) -> float:
        """Median of the cycles until it had the ball again, where it did; NaN if it never did."""
        times = self.time[self.struck & np.isfinite(self.time)]
        return float(np.median(times)) if len(times) else float("nan")


def measure(factory: Factory, disturbance: Disturbance | None, episodes: int = 1000, seed: int = 0, task: Task | None = None) -> Recovery:
    """Play episodes with a disturbance (or none); every controller meets the same starts and the same strikes.

    Parameters
    ----------
    factory : callable
        (task, agent) -> controller, called once for each agent.
    disturbance : Disturbance, optional
    episodes, seed : int
    task : Task, optional
        PassAndAdvance by default.
    """
    task = task or make_task("PassAndAdvance")
    worlds = min(WORLDS, episodes)
    core = SoccerCore(task, worlds, seed=seed, include=("memory",))
    players = [factory(task, agent) for agent in core.agents]
    observation = core.reset(seed)
    for i, player in enumerate(players):
        player.reset({key: value[:, i] for key, value in observation.items()}, seed)
    disturber = Disturber(core, disturbance, seed) if disturbance else None
    left = np.array([len(range(k, episodes, worlds)) for k in range(worlds)])
    tally = _Tally(worlds)
    rows = core.players - 1
    while (left > 0).any():
        if disturber:
            disturber()
        before = core.sim.world["counts"][:, rows, Count.KICK].sum(axis=1)
        actions = [player.act({key: value[:, i] for key, value in observation.items()}) for i, player in enumerate(players)]
        step = core.step({key: np.stack([action[key] for action in actions], axis=1) for key in actions[0]})
        kicked = core.sim.world["counts"][:, rows, Count.KICK].sum(axis=1) > before
        tally.note(core, disturber, kicked)
        over = (left > 0) & (step.terminated | step.truncated)
        if over.any():
            tally.close(over, np.asarray(step.success.any(axis=1)))
            left -= over
            again = over & (left > 0)
            observation = core.reset(worlds=again)
            for i, player in enumerate(players):
                player.reset({key: value[:, i] for key, value in observation.items()}, seed, again)
            if disturber:
                disturber.reset(again)
    return tally.result(episodes)


class _Tally:
    """What happens in the episodes that are being played, and what happened in those that are over."""

    def __init__(self, worlds: int) -> None:
        self.struck, self.time = np.zeros(worlds, bool), np.full(worlds, np.nan)
        self.cycles = np.zeros(worlds, np.int64)
        self.played = np.zeros(worlds, np.int64)
        self.closed: list[tuple[int, int, bool, bool, float, int]] = []

    def note(self, core: SoccerCore, disturber: Disturber | None, kicked: np.ndarray) -> None:
        """The cycle just played."""
        self.cycles += 1
        if disturber:
            self.struck |= disturber.struck >= 0
            since = core.cycle - disturber.struck
            again = self.struck & kicked & (since >= disturber.disturbance.duration) & np.isnan(self.time)
            self.time[again] = since[again]

    def close(self, over: np.ndarray, success: np.ndarray) -> None:
        """The episodes of these worlds are over."""
        for k in np.flatnonzero(over):
            entry = bool(success[k]), bool(self.struck[k]), float(self.time[k]), int(self.cycles[k])
            self.closed.append((int(self.played[k]), int(k), *entry))
        self.played += over
        self.struck[over], self.time[over], self.cycles[over] = False, np.nan, 0

    def result(self, episodes: int) -> Recovery:
        """In the order of rounds and worlds, whichever ended first."""
        _, _, success, struck, time, cycles = zip(*sorted(self.closed)[:episodes])
        return Recovery(np.array(success), np.array(struck), np.array(time), np.array(cycles))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Recovery of the passing pair or the striker: with recovery parts, without, watched.")
    parser.add_argument("--task", choices=list(RIVALS), default="PassAndAdvance")
    parser.add_argument("--episodes", type=at_least(1), default=1000)
    parser.add_argument("--seed", type=at_least(0), default=0)
    parser.add_argument("--rivals", nargs="+", choices=["recovering", "without", "watchdog"], default=["recovering", "without", "watchdog"])
    parser.add_argument(
        "--only",
        action="append",
        choices=list(DISTURBANCES),
        help="one disturbance, several times for more; undisturbed always",
    )
    options = parser.parse_args()
    task, rivals = make_task(options.task, **(PLAYERS[options.task].options if options.task in PLAYERS else {})), options.rivals
    print(f"{task.name}, {options.episodes} episodes, seed {options.seed}; success with its Wilson interval (95 %)")
    print(f"{'disturbance':18}" + "".join(f"{rival:24}" for rival in rivals), end="")
    print("ball again:" + "".join(f"{rival:>12}" for rival in rivals) + "  cycles:" + "".join(f"{rival:>12}" for rival in rivals))
    for name, disturbance in (("undisturbed", None), *DISTURBANCES.items()):
        # without the undisturbed row no other one says anything
        if disturbance is not None and options.only and name not in options.only:
            continue
        results = [measure(RIVALS[task.name][rival], disturbance, options.episodes, options.seed, task) for rival in rivals]
        cells = [f"{r.success.mean():6.1%} [{r.interval.low:.1%}, {r.interval.high:.1%}]" for r in results]
        again = ["{}/{}".format(*r.recovered) if disturbance else "" for r in results]
        times = [f"{r.median_time:.0f}" if disturbance else "" for r in results]
        print(f"{name:18}" + "".join(f"{c:24}" for c in cells) + " " * 11 + "".join(f"{a:>12}" for a in again), end="")
        print(" " * 9 + "".join(f"{t:>12}" for t in times), flush=True)


if __name__ == "__main__":
    main()
