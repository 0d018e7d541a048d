"""A registered agent as one state machine: the same percepts, the same commands, and no net at work.

``MachineAgent(agent_in(make_controller(task, agent)))`` plays what the agent plays (`architecture.product_machine`).
"""

from __future__ import annotations

import numpy as np

from ...architecture.petri import Executor
from ...architecture.product_machine import ProductMachine, ProductRunner
from ...envs.controller import Action, Observation, no_action
from ...errors import ControllerError, ParameterError
from ...simulator.state import CommandKind
from ..kernels import actions as kernels
from ..play import ACTION, SoccerAgent, exclusive_commands, sending


class MachineAgent:
    """The machine of an agent's net as a controller.

    Parameters
    ----------
    agent : SoccerAgent
        Without a model of his own, and without object places.

    Attributes
    ----------
    machine : ProductMachine
        Grows as it meets what it has not met before.

    Raises
    ------
    ParameterError
        For an agent with a model.
    NetError
        For a net that has no state machine.
    """

    def __init__(self, agent: SoccerAgent) -> None:
        if agent.cprm.model is not None:
            raise ParameterError(f"the agent {agent.cprm.name!r} infers with a model of his own; a machine of his net alone is not he")
        self.agent, self.needs = agent, agent.needs
        exclusive = exclusive_commands(agent.cprm)
        self.machine = ProductMachine(agent.cprm.net, exclusive)
        self._sends = sending(Executor(agent.cprm.net, exclusive=exclusive), agent.body)
        self._runner: ProductRunner | None = None

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes."""
        count = len(observation["level"])
        self.agent.reset(observation, seed, worlds)
        if self._runner is None or self._runner.batch != count:
            self._runner, worlds = ProductRunner(self.machine, count), None
        self._runner.reset(worlds)

    def act(self, observation: Observation) -> Action:
        """One cycle of every world."""
        if self._runner is None:
            raise ControllerError("act before reset: the controller does not know how many worlds there are")
        percepts, count = self.agent.perceive(observation), self._runner.batch
        self._runner.step(percepts)
        action, turned = no_action(count), np.empty(count)
        speed, neck = (np.ascontiguousarray(percepts[name]) for name in ("body.speed", "body.neck_deg"))
        kernels.act(*self._sends, *self._runner.sent, speed, neck, int(CommandKind.TURN), *(action[key] for key in ACTION), turned)
        self.agent._turned = turned
        return action
