"""The goalie who knows on the belief and expects shots, as a controller: ``cprm:model=intention``."""

from __future__ import annotations

from ...envs.players.senses import Senses
from ...envs.tasks import Task
from ...errors import ParameterError
from ..body import Body
from ..knowledge.belief import BeliefTier
from ..knowledge.players import PLAYERS
from ..knowledge.tiers import Informed
from .goalie import AttackedIntentionConstants, IntentionConstants, IntentionGoalie
from .model import learned
from .tier import IntentionTier

PLAYS = {"Goalie": "shooter", "Goalie2v1": "attackers", "Goalie3v2": "attackers"}
"""Task -> the play whose tables are learned."""


def make_controller(
    task: Task, agent: str, senses: Senses | None = None, attended: bool = True, possesses: bool = True, memory: bool = True
) -> Informed:
    """The goalie on the belief with the intention of who holds the ball.

    His numbers are those tuned for the memory, and of what he expects those set by hand.

    Parameters
    ----------
    task : Task
    agent : str
    senses : Senses, optional
        What his tier may know of the noise; the server's if not given.
    attended, possesses, memory : bool
        Lesions, as for `IntentionTier`; without possession nothing is ever expected.

    Raises
    ------
    ParameterError
        For a task in which nobody is expected to shoot.
    """
    if task.name not in PLAYS:
        raise ParameterError(f"the agent of {task.name} expects no shots; those of {', '.join(PLAYS)} do")
    body, opponents = Body.of(task), task.right if agent.startswith("left") else task.left
    kind = IntentionConstants if task.name == "Goalie" else AttackedIntentionConstants
    numbers = PLAYERS[task.name].numbers("memory")
    assert numbers is not None
    tier = IntentionTier(
        BeliefTier(senses or Senses(), body), learned(PLAYS[task.name]), opponents, attended=attended, possesses=possesses, memory=memory
    )  # fmt: skip
    return Informed(IntentionGoalie(opponents, body, kind.of(numbers.to_dict())), tier)
