"""Worlds of cells learned from the simulator, a behaviour played alone in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from ...agents.body import Body
from ...agents.play import BODY_COMMANDS, SoccerAgent
from ...architecture.analysis.product.learned_world import LearnedWorld, thresholds_of
from ...architecture.cprm import CPRMRunner
from ...architecture.petri import PetriNet, Place, compile_net
from ...architecture.petri.net.modules import instances
from ...envs.core import SoccerCore
from ...errors import unknown_name
from ...simulator.parameters import Rules
from ..skills import SETTLE, TRIALS, _Stage

FINER: Mapping[str, tuple[float, ...]] = {
    "distance": (0.5, 0.7, 1.0, 1.3, 1.7, 2.2, 3.0, 4.0, 6.0, 9.0, 13.0, 18.0),
    "off_axis": (5.0, 30.0, 90.0),
    "speed": (0.1, 0.3),
}
"""By the last part of a place's name, where cells are cut beside the thresholds: metres, degrees, metres a cycle."""


@dataclass(frozen=True)
class Behaviour:
    """A behaviour and the outcomes by which it is judged.

    Attributes
    ----------
    trial : str
        Of `benchmark.skills.TRIALS`: where it starts.
    finer : mapping of str to tuple of float
        Further cuts, beside `FINER`.
    """

    trial: str
    finer: Mapping[str, tuple[float, ...]] = field(default_factory=dict)

    @property
    def limit(self) -> int:
        """Cycles after which it is cut off."""
        return TRIALS[self.trial].cycles


BEHAVIOURS: dict[str, Behaviour] = {
    "approach": Behaviour("approach"),
    "catch_ball": Behaviour("catch_ball"),
    "go_to_ball": Behaviour("go_to_ball"),
    "pass_ball": Behaviour("pass_ball"),
    "receive": Behaviour("receive"),
}
"""Those that can be analysed in the simulator's world."""


def behaviour(name: str) -> Behaviour:
    """The behaviour of that name.

    Raises
    ------
    UnknownName
    """
    if name not in BEHAVIOURS:
        raise unknown_name("behaviour", name, BEHAVIOURS)
    return BEHAVIOURS[name]


def outcomes_of(net: PetriNet) -> dict[str, str]:
    """Outcome -> place, of a net made by `benchmark.skills.alone`: done, and the errors of the skill within."""
    skill = net.modules["skill"]
    ports = skill.ports
    return {str(ports.done or "done"): "done", **{error: f"skill.{error}" for error in ports.errors}}


class Stage:
    """A behaviour alone in a batch of worlds of the simulator.

    Parameters
    ----------
    name : str
        Of `BEHAVIOURS`.
    worlds : int
    seed : int
    net : callable, optional
        Makes another net of the one that is played: a broken version.
    """

    def __init__(self, name: str, worlds: int, seed: int, net: Any = None) -> None:
        trial = TRIALS[behaviour(name).trial]
        if net is not None:
            made = trial.make
            trial = replace(trial, make=lambda *given: net(made(*given)))
        rules = Rules.CATCH if trial.goalie else Rules.NONE
        stage = _Stage(name="stage", left=2, left_goalie=int(trial.goalie), start=trial.start, rules=rules)
        task = replace(stage, max_cycles=10_000, others="hold")
        self.core = SoccerCore(task, worlds, seed=seed, include=("memory",))
        self.agent: SoccerAgent = trial.agent(behaviour(name).trial, Body.of(task))
        self.net: PetriNet = self.agent.cprm.net
        self.outcomes = outcomes_of(self.net)
        self.limit = trial.cycles + SETTLE
        self.worlds, self.seed = worlds, seed
        self.judge = trial.judge

    def play(self) -> Iterator[tuple[dict[str, np.ndarray], list[tuple[str, ...]], dict[str, np.ndarray], CPRMRunner]]:
        """Cycle by cycle: percepts (and beliefs), commands of the body of each world, whether each outcome is marked, the runner."""
        observation = self.core.reset(self.seed)
        mine = {k: v[:, 0] for k, v in observation.items()}
        self.agent.reset(mine, self.seed)
        runner = self.agent.controller
        assert runner is not None
        sent = [c for c in runner.executor.command_names if c in BODY_COMMANDS]
        for _ in range(self.limit):
            mine = {k: v[:, 0] for k, v in observation.items()}
            percepts = dict(self.agent.perceive(mine))
            action = self.agent.act(mine)
            fired = runner.executor._commands.fired
            commands = [tuple(c for c in sent if fired[c][w]) for w in range(self.worlds)]
            seen = {name: np.asarray(percepts[name], float) for name in runner.executor.input_names}
            seen |= {name: runner.executor.read(name) for name in runner.executor.belief_names}
            marks = {name: runner.executor.read(place) > 0 for name, place in self.outcomes.items()}
            yield seen, commands, marks, runner
            self.core.step({k: np.asarray(v)[:, None] for k, v in action.items()})


def edges_of(name: str, net: PetriNet) -> dict[str, tuple[float, ...]]:
    """Where cells of a behaviour's world are cut: its net's thresholds, and finer."""
    more = {**FINER, **behaviour(name).finer}
    return {
        place: tuple(sorted({*cuts, *(more.get(place.rpartition(".")[2], ()) if len(cuts) else ())}))
        for place, cuts in thresholds_of(compile_net(net)).items()
    }


def heeds_of(net: PetriNet, parts: bool = False) -> tuple[str, ...]:
    """Places that say how far a behaviour is: what its modules (its innermost `parts` alone) count, and which of them are at work."""
    found = []
    for path, instance in instances(net).items():
        if not path or (parts and instance.net.modules):
            continue
        names = [p.name for p in instance.net.places if isinstance(p, Place) and (p.capacity or 2) > 1]
        found += [instance.places[n] for n in (*names, *filter(None, (instance.net.ports.ongoing,)))]
    return tuple(dict.fromkeys(found))


def learn_world(
    name: str,
    episodes: int = 2000,
    seed: int = 0,
    *,
    net: Any = None,
    confidence: float = 0.95,
    heed: Literal["all", "parts", "nothing"] = "all",
) -> tuple[PetriNet, dict[str, str], LearnedWorld]:
    """The world of a behaviour, from episodes in the simulator.

    Parameters
    ----------
    name : str
        Of `BEHAVIOURS`.
    episodes, seed : int
    net : callable, optional
        A broken version, as for `Stage`.
    confidence : float
        Of the intervals, all at once.
    heed : {"all", "parts", "nothing"}
        How far the world is told where the behaviour is (`heeds_of`): all it counts and all that is at work; only that of its innermost
        modules, which can then be analysed apart; or nothing, so that cells forget all but themselves.

    Returns
    -------
    (PetriNet, outcomes, LearnedWorld)
    """
    stage = Stage(name, episodes, seed, net)
    heeds = heeds_of(stage.net, parts=heed == "parts") if heed != "nothing" else ()
    world = LearnedWorld(edges_of(name, stage.net), confidence, tuple(BODY_COMMANDS), heeds)
    before: list[tuple[int, ...] | None] = [None] * episodes
    commands: list[tuple[str, ...]] = [()] * episodes
    going = np.ones(episodes, bool)
    for seen, sent, marks, runner in stage.play():
        cells = world.cells({place: runner.executor.read(place) for place in world.edges})
        rows = [tuple(row) for row in cells.tolist()]
        tokens = {place: runner.executor.read(place) for place in heeds}
        for w in np.flatnonzero(going).tolist():
            last = before[w]
            if last is None:
                world.begin(rows[w], _reading(seen, w))
            elif rows[w] in world.readings:
                world.saw(last, commands[w], rows[w], {})
            else:
                world.saw(last, commands[w], rows[w], _reading(seen, w))
            before[w] = rows[w]
            commands[w] = sent[w] + tuple(f"{place}={held[w]:g}" for place, held in tokens.items() if held[w])
        for marked in marks.values():
            going &= ~marked
        if not going.any():
            break
    return stage.net, stage.outcomes, world


def _reading(seen: Mapping[str, np.ndarray], w: int) -> dict[str, float]:
    return {name: float(values[w]) for name, values in seen.items()}


def simulate(name: str, episodes: int, seed: int, *, net: Any = None) -> tuple[dict[str, int], np.ndarray]:
    """Outcomes of fresh episodes in the simulator, and the cycle in which each ended (-1: cut off)."""
    stage = Stage(name, episodes, seed, net)
    counts = dict.fromkeys((*stage.outcomes, "unfinished"), 0)
    ended = np.full(episodes, -1)
    for cycle, (_, _, marks, _) in enumerate(stage.play()):
        for outcome, marked in marks.items():
            fresh = marked & (ended < 0)
            counts[outcome] += int(fresh.sum())
            ended[fresh] = cycle
        if (ended >= 0).all():
            break
    counts["unfinished"] = int((ended < 0).sum())
    return counts, ended
