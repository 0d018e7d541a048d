"""The goalie's net without a model, on the environment's own memory: the fair rival of the goalie who believes.

Net and skills are those of `cprm_gym.agents.goalie`; where he holds beliefs, this one reads what the observation's part ``memory``
reckons: what was last seen, carried on through blind cycles by a decaying roll. What a model adds to the net is the difference to this
one, not that to `goalie_raw`, which freezes its readings.
"""

from __future__ import annotations

from cprm_gym.agents.body import Body
from cprm_gym.agents.goalie import ReckoningGoalie as MemoryGoalie
from cprm_gym.agents.skills.constants import GoalieConstants
from cprm_gym.envs.tasks import Task
from cprm_gym.errors import UnknownName


def make_controller(task: Task, agent: str) -> MemoryGoalie:
    """The goalie on his memory, with the numbers of his behaviour tuned for it.

    Raises
    ------
    UnknownName
        For a task without a goalie to play.
    """
    if task.name != "Goalie":
        raise UnknownName(f"controller 'goalie_memory' cannot play task {task.name!r}; it plays Goalie")
    return MemoryGoalie(task.right if agent.startswith("left") else task.left, Body.of(task), GoalieConstants.tuned("memory"))
