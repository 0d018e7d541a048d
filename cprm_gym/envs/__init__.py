"""The soccer world as Gymnasium and PettingZoo environments.

``soccer_v0`` is the PettingZoo module (`parallel_env`, `env`, `raw_env`); Gymnasium ids are ``cprm/<Task>-v0``. Importing this package
loads nothing of the simulator.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazy import lazy_face

if TYPE_CHECKING:
    from . import soccer_v0 as soccer_v0
    from .actions import ActionView as ActionView
    from .actions import action_view as action_view
    from .actions import scaled as scaled
    from .controller import Controller as Controller
    from .observations import BodyFeature as BodyFeature
    from .observations import ObjectFeature as ObjectFeature
    from .observations import SelfFeature as SelfFeature
    from .observations import observation_space as observation_space
    from .play import Film as Film
    from .rendering import Viewer as Viewer
    from .rewards import HausknechtStone as HausknechtStone
    from .single import SoccerEnv as SoccerEnv
    from .soccer import SoccerParallelEnv as SoccerParallelEnv
    from .tasks import TASKS as TASKS
    from .tasks import Outcome as Outcome
    from .tasks import Task as Task
    from .tasks import make_task as make_task
    from .vector import SoccerVectorEnv as SoccerVectorEnv
else:
    __all__, __getattr__, __dir__ = lazy_face(
        __name__,
        {
            "": "soccer_v0",
            "actions": "ActionView action_view scaled",
            "controller": "Controller",
            "observations": "BodyFeature ObjectFeature SelfFeature observation_space",
            "play": "Film",
            "rendering": "Viewer",
            "rewards": "HausknechtStone",
            "single": "SoccerEnv",
            "soccer": "SoccerParallelEnv",
            "tasks": "Outcome TASKS Task make_task",
            "vector": "SoccerVectorEnv",
        },
    )
