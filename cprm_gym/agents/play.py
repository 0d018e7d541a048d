"""A CPRM as a soccer controller: percepts in, commands out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..architecture.cprm import CPRM, CPRMRunner
from ..architecture.cprm.runner import check_options
from ..architecture.cprm.slow import Timing
from ..architecture.petri.execution.executor import Executor
from ..envs.actions import NECK_SCALE, PARAMETER_SCALES
from ..envs.controller import Action, Controller, Observation, no_action
from ..errors import ControllerError
from ..simulator.state import CommandKind
from .body import DEFAULT, Body
from .given import check_given
from .kernels import actions as kernels
from .percepts import Percepts

BODY_COMMANDS: Mapping[str, tuple[CommandKind, tuple[str, ...]]] = {
    "dash": (CommandKind.DASH, ("power", "direction")),
    "turn": (CommandKind.TURN, ("moment",)),
    "kick": (CommandKind.KICK, ("power", "direction")),
    "tackle": (CommandKind.TACKLE, ("direction", "foul")),
    "catch": (CommandKind.CATCH, ("direction",)),
    "move": (CommandKind.MOVE, ("x", "y")),
}
"""Name of a net's command -> kind and parameters, in the order of ``params``. One of them goes out per cycle."""
Objects = Mapping[str, Mapping[str, Any]]


class SoccerAgent:
    """Plays with a CPRM, one copy per world.

    Parameters
    ----------
    cprm : CPRM
        Its net emits the commands of `BODY_COMMANDS`, and ``turn_neck(moment)``, ``change_view(width)`` and ``look(direction)``: the neck
        turns so that the face points there, degrees from the body as it is now; a turn of the body in the same cycle is made up for.
    percepts : callable
        Observation -> named quantities.
    objects : callable, optional
        Observation -> class -> attribute -> (N, n) numbers: the candidates of the net's object places.
    body : Body
        His own, by which he knows what his commands do.
    needs : sequence of str
        Parts of the observation that the percepts read beyond what is always there (`observation_space`): ``memory``, ``landmarks``.
    given : mapping of str to str, optional
        Of readings of his own percepts that the model is told, the percepts that are 1 where they were given (`given.check_given`).
    **options
        Passed on to `CPRMRunner`.

    Raises
    ------
    ModelError
        When the model would be told a reading that may not have been given (`given`).
    ParameterError
        For an option, or an engine, that there is not, and a timing of inference that makes no sense.
    """

    def __init__(
        self,
        cprm: CPRM,
        percepts: Callable[[Observation], Percepts],
        needs: Sequence[str] = (),
        objects: Callable[[Observation], Objects] | None = None,
        body: Body = DEFAULT,
        given: Mapping[str, str] | None = None,
        **options: Any,
    ) -> None:
        check_given(cprm, given)
        check_options(options, ("exclusive", "seed"))
        Timing.of(cprm, **{name: options[name] for name in ("t_b", "latency", "demand") if name in options})
        self.cprm = cprm
        self.needs = tuple(needs)
        self.percepts = percepts
        self.objects = objects
        self.body = body
        self.options = options
        self.controller: CPRMRunner | None = None

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes; the copies are made at the first one."""
        count = len(observation["level"])
        if self.controller is None or self.controller.batch != count:
            self.controller = CPRMRunner(self.cprm, count, exclusive=exclusive_commands(self.cprm), seed=seed, **self.options)
            self._sends = sending(self.controller.executor, self.body)
            self._turned = np.zeros(count)
            worlds = None
        self.controller.reset(worlds)
        self._turned[slice(None) if worlds is None else worlds] = 0.0

    def perceive(self, observation: Observation) -> Percepts:
        """The percepts, and his own motion in the last cycle.

        Returns
        -------
        dict of (N,) float64
            With ``body.turned_deg``, the turn that was commanded, and ``body.advanced``, the metres that the body went ahead (the speed
            that it feels is what the decay left).
        """
        percepts = self.percepts(observation)
        percepts["body.turned_deg"] = self._turned
        along = np.cos(np.radians(percepts["body.speed_direction_deg"]))
        percepts["body.advanced"] = percepts["body.speed"] * along / self.body.kind.player_decay
        return percepts

    def act(self, observation: Observation) -> Action:
        """One cycle of every copy."""
        if self.controller is None:
            raise ControllerError("act before reset: the controller does not know how many worlds there are")
        percepts = self.perceive(observation)
        self.controller.step(percepts, self.objects(observation) if self.objects else None)
        action = no_action(self.controller.batch)
        self._turned = np.empty(self.controller.batch)
        fired, values = self.controller.executor.sent
        speed, neck = (np.ascontiguousarray(percepts[name]) for name in ("body.speed", "body.neck_deg"))
        kernels.act(*self._sends, fired, values, speed, neck, int(CommandKind.TURN), *(action[key] for key in ACTION), self._turned)
        return action


def agent_in(player: Controller) -> SoccerAgent | None:
    """Who plays with a CPRM in a player, who may be one on a tier of knowledge; None for other kinds."""
    inner = player if isinstance(player, SoccerAgent) else getattr(player, "controller", None)
    return inner if isinstance(inner, SoccerAgent) else None


ACTION = ("type", "params", "turn_neck", "view")


def sending(executor: Executor, body: Body) -> tuple[np.ndarray, ...]:
    """Where the commands that a net may send stand, as `kernels.act` takes it."""
    commands = executor.command_names
    table: list[tuple[int, int, int, int]] = []
    columns: list[int] = []
    scales: list[float] = []
    for name, (kind, parameters) in BODY_COMMANDS.items():
        if name in commands:
            table.append((commands.index(name), int(kind), len(columns), len(parameters)))
            columns += [executor.parameters(name).get(key, -1) for key in parameters]
            scales += PARAMETER_SCALES[kind][: len(parameters)].tolist()
    side = [
        (commands.index(name), executor.parameters(name).get(key, -1)) if name in commands else (-1, -1)
        for name, key in (("turn_neck", "moment"), ("look", "direction"), ("change_view", "width"))
    ]
    limits = (body.kind.inertia_moment, body.server.minneckang, body.server.maxneckang, NECK_SCALE)
    return (
        np.array(table, np.int64).reshape(-1, 4),
        np.array(columns, np.int64),
        np.array(scales, np.float64),
        np.array(side, np.int64),
        np.array(limits, np.float64),
    )


def exclusive_commands(cprm: CPRM) -> list[list[str]]:
    """The commands of a net that move the body: one of them goes out per cycle."""
    from ..architecture.petri import compile_net

    emitted = {t.emits.name for t in compile_net(cprm.net).net.transitions if t.emits is not None}
    group = [name for name in BODY_COMMANDS if name in emitted]
    return [group] if group else []
