"""Lesions: a CPRM agent with one of its parts taken out, to see what that part is worth.

    cprm-gym benchmark --tasks Goalie --controllers cprm:model=bins,lesion:without=relations,lesion:without=time
    python -m cprm_baselines.lesions --task Goalie --without relations,time --episodes 400 --seed 7        the same, paired
    python -m cprm_baselines.lesions --task Goalie2v1 --whole cprm:model=intention --without intention,attention,mind

``time``: its belief begins from the prior in every cycle, so that what was seen before is forgotten; ``relations``: no relation comes into
force, whatever the net attends to; ``reflexes``: the goalie acts on what he believes alone; ``recovery``: the primary sequence alone, with
``watched=true`` begun anew where its body has done nothing for 60 cycles; ``looking``: the neck stays straight and the view as it is. The
first four are of agents with a model of their own, or parts for recovery; anybody can be kept from looking. ``intention``: the goalie who
expects shots (``cprm:model=intention``) no longer knows that an opponent has the ball, and so expects nothing; ``attention``: opponents
whom he does not see are not carried on; ``mind``: what the holder is about is forgotten in each cycle.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from cprm_gym.agents.intention.agent import make_controller as expecting
from cprm_gym.agents.play import SoccerAgent, agent_in
from cprm_gym.agents.registry import BINS, MODELLED
from cprm_gym.agents.registry import make_controller as cprm
from cprm_gym.benchmark.arguments import at_least
from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.benchmark.recovery import RIVALS, Watchdog
from cprm_gym.benchmark.statistics import paired_difference, wilson_interval
from cprm_gym.envs.controller import Action, Controller, Observation
from cprm_gym.envs.others.registry import load_controller
from cprm_gym.envs.tasks import Task, make_task
from cprm_gym.errors import CprmError, ParameterError, unknown_name

REFLEXES = ("Goalie", "Goalie2v1", "Goalie3v2")
"""Tasks whose agent has reflexes that can be taken out."""


class Forgetful:
    """A CPRM agent without links in time: before each cycle the belief is the prior.

    Parameters
    ----------
    agent : SoccerAgent
        With a model.
    """

    def __init__(self, agent: SoccerAgent) -> None:
        self.controller, self.needs = agent, agent.needs

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes."""
        self.controller.reset(observation, seed, worlds)

    def act(self, observation: Observation) -> Action:
        """One cycle of every world."""
        runner = self.controller.controller
        if runner is not None and runner.bank is not None:
            runner.bank.reset()
        return self.controller.act(observation)


class Staring:
    """A controller whose neck stays straight and whose view stays as it is.

    Parameters
    ----------
    controller : Controller
    """

    def __init__(self, controller: Controller) -> None:
        self.controller, self.needs = controller, tuple(getattr(controller, "needs", ()))

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes."""
        self.controller.reset(observation, seed, worlds)

    def act(self, observation: Observation) -> Action:
        """One cycle of every world."""
        action = self.controller.act(observation)
        return {**action, "turn_neck": np.zeros_like(action["turn_neck"]), "view": np.zeros_like(action["view"])}


def _modelled(task: Task, agent: str, without: str) -> SoccerAgent:
    """The agent with a model of his own."""
    if task.name not in MODELLED:
        raise ParameterError(f"lesion: the agent of {task.name} has no model, of which {without} could be taken out")
    made = agent_in(cprm(task, agent, model=BINS))
    if made is None:
        raise ParameterError(f"lesion: {without} cannot be taken out of {agent} of {task.name}")
    return made


def _without_time(task: Task, agent: str) -> Controller:
    return Forgetful(_modelled(task, agent, "time"))


def _without_relations(task: Task, agent: str) -> Controller:
    made = _modelled(task, agent, "relations")
    if not made.cprm.clusters:
        raise ParameterError(f"lesion: no relation comes into force in {task.name}")
    made.cprm = replace(made.cprm, clusters=())
    return made


def _without_reflexes(task: Task, agent: str) -> Controller:
    if task.name not in REFLEXES:
        raise ParameterError(f"lesion: the agent of {task.name} has no reflexes to be taken out; those of {', '.join(REFLEXES)} have")
    return cprm(task, agent, model=BINS, reflexes="none")


def _without_recovery(task: Task, agent: str) -> Controller:
    if task.name not in RIVALS:
        raise ParameterError(f"lesion: the agent of {task.name} has no parts for recovery; those of {', '.join(RIVALS)} have")
    return RIVALS[task.name]["without"](task, agent)


def _without_looking(task: Task, agent: str) -> Controller:
    return Staring(cprm(task, agent))


def _without_intention(part: str, task: Task, agent: str) -> Controller:
    return expecting(task, agent, **{part: False})  # type: ignore[arg-type]


LESIONS: dict[str, Callable[[Task, str], Controller]] = {
    "looking": _without_looking, "time": _without_time, "relations": _without_relations, "reflexes": _without_reflexes,
    "recovery": _without_recovery, "intention": partial(_without_intention, "possesses"),
    "attention": partial(_without_intention, "attended"), "mind": partial(_without_intention, "memory"),
}  # fmt: skip
"""What is taken out -> maker of who is left."""


def make_controller(task: Task, agent: str, without: str = "looking", watched: bool = False) -> Controller:
    """The CPRM agent of a task without one of its parts.

    Parameters
    ----------
    task : Task
    agent : str
    without : str
        Of `LESIONS`.
    watched : bool
        Whether a watchdog begins it anew where its body has done nothing for 60 cycles.

    Raises
    ------
    UnknownName
        For a part that there is not, or a task that no CPRM plays.
    ParameterError
        For a part that the agent of the task does not have.
    """
    if without not in LESIONS:
        raise unknown_name("part to be taken out", without, LESIONS)
    made = LESIONS[without](task, agent)
    return Watchdog(made) if watched else made


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", default="Goalie")
    parser.add_argument("--whole", default=f"cprm:model={BINS}", help="controller beside which they are measured")
    parser.add_argument(
        "--without", default="time,relations", help=f"of {', '.join(LESIONS)}; +watched behind one puts it under a watchdog"
    )
    parser.add_argument("--episodes", type=at_least(1), default=400)
    parser.add_argument("--seed", type=at_least(0), default=0)
    given = parser.parse_args()
    try:
        task, names = make_task(given.task), given.without.split(",")
        makers = [partial(make_controller, without=name.removesuffix("+watched"), watched=name.endswith("+watched")) for name in names]
        for make in (whole := load_controller(given.whole), *makers):
            make(task, "left_1")
    except CprmError as error:
        parser.error(str(error))
    success = [play_episodes(task, make, given.episodes, given.seed).success for make in (whole, *makers)]
    print(f"{given.task}, {given.episodes} worlds of seed {given.seed}\n")
    print("| without | success %, Wilson 95 % | less the whole, paired 95 % |\n|---|---|---|")
    for name, found in zip((f"nothing: {given.whole}", *names), success):
        low, high = wilson_interval(int(found.sum()), given.episodes)
        less = paired_difference(found, success[0])
        said = f"{100 * less.mean:+.1f} ({100 * less.low:+.1f}, {100 * less.high:+.1f})" if found is not success[0] else ""
        print(f"| {name} | {100 * found.mean():.1f} ({100 * low:.1f} - {100 * high:.1f}) | {said} |")


if __name__ == "__main__":
    main()
