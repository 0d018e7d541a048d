"""What the architecture contains as controllers that go to the ball: the machine and the regions, run as such, and their nets.

The two of a pair send the same in the same worlds (dissertation Figs. 5.1 and 5.3).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np

from ...architecture.cprm import CPRM
from ...architecture.equivalences import MachineRunner, RegionsRunner, machine_net, regions_cprm
from ...envs.controller import Action, Observation, no_action
from ...envs.tasks import Task
from ...errors import ControllerError, UnknownName
from ...simulator.state import CommandKind
from ..body import Body
from ..kernels import actions as kernels
from ..percepts import Percepts, ball_percepts
from ..play import ACTION, SoccerAgent
from .go_to_ball import go_to_ball_machine, go_to_ball_regions


class Runner(Protocol):
    """Of one world."""

    def step(self, percepts: Mapping[str, float]) -> Mapping[str, Mapping[str, float]]:
        """One cycle: name of a command -> its parameters."""


class RunAsSuch(SoccerAgent):
    """A machine or a region policy as a controller, one runner for each world, without its net at work.

    Parameters
    ----------
    cprm : CPRM
        What it becomes in the architecture; of it only the commands are read that can go out.
    make : callable
        A runner that begins.
    percepts : callable
        Observation -> named quantities.
    body : Body
    """

    def __init__(self, cprm: CPRM, make: Callable[[], Runner], percepts: Callable[[Observation], Percepts], body: Body) -> None:
        super().__init__(cprm, percepts, body=body)
        self._make = make
        self._runners: list[Runner] = []

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes."""
        super().reset(observation, seed, worlds)
        count = len(observation["level"])
        begun = np.ones(count, bool) if worlds is None or len(self._runners) != count else worlds
        self._runners = [self._make() if begun[w] else self._runners[w] for w in range(count)]

    def act(self, observation: Observation) -> Action:
        """One cycle of every world."""
        if self.controller is None:
            raise ControllerError("act before reset: the controller does not know how many worlds there are")
        percepts, executor = self.perceive(observation), self.controller.executor
        fired, values = (np.zeros_like(one) for one in executor.sent)
        for w, runner in enumerate(self._runners):
            for name, parameters in runner.step({key: float(value[w]) for key, value in percepts.items()}).items():
                fired[w, executor.command_names.index(name)] = True
                for key, value in parameters.items():
                    values[w, executor.parameters(name)[key]] = value
        action, turned = no_action(len(fired)), np.empty(len(fired))
        speed, neck = (np.ascontiguousarray(percepts[name]) for name in ("body.speed", "body.neck_deg"))
        kernels.act(*self._sends, fired, values, speed, neck, int(CommandKind.TURN), *(action[key] for key in ACTION), turned)
        self._turned = turned
        return action


def make_contained(what: str, as_net: bool, task: Task) -> SoccerAgent:
    """One of a pair.

    Parameters
    ----------
    what : str
        ``state machine`` or ``belief regions``.
    as_net : bool
        Whether it is played by what it becomes in the architecture.
    task : Task

    Raises
    ------
    UnknownName
        For a task other than GoToBall.
    """
    if task.name != "GoToBall":
        raise UnknownName(f"{what}: task {task.name!r}; it plays GoToBall")
    body = Body.of(task)
    if what == "state machine":
        machine = go_to_ball_machine(body)
        cprm, make = CPRM(machine.name, net=machine_net(machine)), lambda: MachineRunner(machine)
        return SoccerAgent(cprm, ball_percepts, body=body) if as_net else RunAsSuch(cprm, make, ball_percepts, body)
    policy = go_to_ball_regions(body)
    cprm = regions_cprm(policy)
    return SoccerAgent(cprm, ball_percepts, body=body) if as_net else RunAsSuch(cprm, lambda: RegionsRunner(policy), ball_percepts, body)
