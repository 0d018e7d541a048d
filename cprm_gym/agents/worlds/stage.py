"""A stage: a behaviour, of one player or of two, in a batch of worlds of the simulator."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...architecture.petri import Command, Input, PetriNet
from ...envs.core import SoccerCore
from ...envs.tasks import Task
from ...simulator.parameters import Rules
from ..body import Body
from ..play import BODY_COMMANDS, SoccerAgent
from .trials import SETTLE, TRIALS, StageTask

Change = Callable[[PetriNet], PetriNet]
"""Makes another net of one: a version to be compared."""


class Cycle(NamedTuple):
    """One cycle on a stage, of all its worlds."""

    seen: Mapping[str, NDArray[np.float64]]
    """What the net observes and believes: name -> (W,)."""
    commands: list[tuple[str, ...]]
    """Of the bodies, in each world."""
    marks: Mapping[str, NDArray[np.bool_]]
    """Outcome -> (W,) whether its place is marked."""
    read: Callable[[str], NDArray[np.float64]]
    """Place of the net -> (W,)."""


@dataclass(frozen=True)
class Cast:
    """Who plays what.

    Attributes
    ----------
    task : Task
    agents : mapping of str to SoccerAgent
        Prefix of its names -> agent; one alone has none.
    net : PetriNet
        Of all of them.
    outcomes : mapping of str to str
        Outcome -> place; the wanted one first.
    limit : int
        Cycles after which it is cut off.
    promised : callable
        core -> (W,) Whether the world is as the behaviour promises, judged by the world itself.
    """

    task: Task
    agents: Mapping[str, SoccerAgent]
    net: PetriNet
    outcomes: Mapping[str, str]
    limit: int
    promised: Callable[[SoccerCore], NDArray[np.bool_]]

    @property
    def acts(self) -> tuple[str, ...]:
        """Commands of the bodies."""
        return tuple(f"{prefix}{c}" for prefix in self.agents for c in BODY_COMMANDS)


def outcomes_of(net: PetriNet) -> dict[str, str]:
    """Outcome -> place, of a net made by `trials.alone`: done, and the errors of the skill within."""
    ports = net.modules["skill"].ports
    return {str(ports.done or "done"): "done", **{error: f"skill.{error}" for error in ports.errors}}


def alone_on_stage(trial: str, change: Change | None = None) -> Cast:
    """One player and his skill, as it is tried."""
    tried = TRIALS[trial]
    if change is not None:
        made = tried.make
        tried = replace(tried, make=lambda *given: change(made(*given)))
    task = stage_task(tried.start, goalie=tried.goalie)
    agent = tried.agent(trial, Body.of(task))
    return Cast(task, {"": agent}, agent.cprm.net, outcomes_of(agent.cprm.net), tried.cycles + SETTLE, tried.judge)


def stage_task(start: Any, goalie: bool = False, controlled: str = "left_1") -> Task:
    """A task without an end that begins as given."""
    stage = StageTask(name="stage", left=2, left_goalie=int(goalie), start=start, rules=Rules.CATCH if goalie else Rules.NONE)
    return replace(stage, max_cycles=10_000, others="hold", controlled=controlled)


def spoken(net: PetriNet, prefix: str) -> PetriNet:
    """A net whose observations and commands have a prefix, all through its modules: one of several in one world."""
    places = tuple(replace(p, observes=f"{prefix}{p.observes}") if isinstance(p, Input) else p for p in net.places)
    transitions = []
    for t in net.transitions:
        if t.emits is not None:
            t = _with(t, Command(f"{prefix}{t.emits.name}", **t.emits.params))
        transitions.append(t)
    return replace(net, places=places, transitions=tuple(transitions), modules={k: spoken(m, prefix) for k, m in net.modules.items()})


def _with(t: Any, emits: Command) -> Any:
    from ...architecture.petri import Transition

    keys = ("inputs", "outputs", "tests", "inhibitors", "sets", "delay", "priority", "weight", "memory", "servers", "set_wins")
    return Transition(t.name, **{k: getattr(t, k) for k in keys}, emits=emits)


class Stage:
    """A cast in a batch of worlds of the simulator.

    Parameters
    ----------
    cast : Cast
    worlds : int
    seed : int
    """

    def __init__(self, cast: Cast, worlds: int, seed: int) -> None:
        self.cast, self.worlds, self.seed = cast, worlds, seed
        self.core = SoccerCore(cast.task, worlds, seed=seed, include=("memory",))

    def play(self, seeds: Sequence[np.random.SeedSequence] | None = None) -> Iterator[Cycle]:
        """Cycle by cycle, until the limit; each world with a seed of its own where they are given."""
        observation = self.core.reset(self.seed if seeds is None else seeds)
        agents = self.cast.agents
        for at, agent in enumerate(agents.values()):
            agent.reset({k: v[:, at] for k, v in observation.items()}, self.seed)
        for _ in range(self.cast.limit):
            seen: dict[str, NDArray[np.float64]] = {}
            fired: dict[str, NDArray[np.bool_]] = {}
            actions = []
            for at, (prefix, agent) in enumerate(agents.items()):
                mine = {k: v[:, at] for k, v in observation.items()}
                percepts = agent.perceive(mine)
                actions.append(agent.act(mine))
                runner = agent.controller
                assert runner is not None
                seen |= {f"{prefix}{name}": np.asarray(percepts[name], float) for name in runner.executor.input_names}
                seen |= {f"{prefix}{name}": runner.executor.read(name) for name in runner.executor.belief_names}
                sent = runner.executor._commands.fired
                fired |= {f"{prefix}{c}": sent[c].copy() for c in runner.executor.command_names if c in BODY_COMMANDS}
            commands = [tuple(c for c, who in fired.items() if who[w]) for w in range(self.worlds)]
            yield Cycle(seen, commands, {o: self._read(place) > 0 for o, place in self.cast.outcomes.items()}, self._read)
            self.core.step({k: np.stack([np.asarray(a[k]) for a in actions], axis=1) for k in actions[0]})

    def _read(self, place: str) -> NDArray[np.float64]:
        for prefix, agent in self.cast.agents.items():
            if place.startswith(prefix):
                assert agent.controller is not None
                return np.asarray(agent.controller.executor.read(place[len(prefix) :]))
        raise KeyError(place)
