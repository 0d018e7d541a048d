"""The soccer world as Gymnasium and PettingZoo environments.

``soccer_v2`` is the PettingZoo module (`parallel_env`, `env`, `raw_env`); Gymnasium ids are ``cprm/<Task>-v2``. Options: `EnvOptions`; what
every face tells beside observation and reward: `cprm_gym.envs.infos`; the engine: `SoccerCore`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..lazy import lazy_face

if TYPE_CHECKING:
    from . import soccer_v2 as soccer_v2
    from .actions import ActionView as ActionView
    from .actions import action_view as action_view
    from .actions import scaled as scaled
    from .controller import Controller as Controller
    from .core import SoccerCore as SoccerCore
    from .observations import BodyFeature as BodyFeature
    from .observations import ObjectFeature as ObjectFeature
    from .observations import SelfFeature as SelfFeature
    from .observations import observation_space as observation_space
    from .options import EnvOptions as EnvOptions
    from .others.registry import controller_entries as controller_entries
    from .others.registry import load_controller as load_controller
    from .pitch import Pitch as Pitch
    from .play import Film as Film
    from .rendering import Viewer as Viewer
    from .rewards import HausknechtStone as HausknechtStone
    from .rewards import named_terms as named_terms
    from .single import SoccerEnv as SoccerEnv
    from .soccer_v2 import SoccerParallelEnv as SoccerParallelEnv
    from .tasks import TASKS as TASKS
    from .tasks import Outcome as Outcome
    from .tasks import Status as Status
    from .tasks import Task as Task
    from .tasks import make_task as make_task
    from .vector import SoccerVectorEnv as SoccerVectorEnv
else:
    __all__, _load, __dir__ = lazy_face(
        __name__,
        {
            "": "soccer_v2",
            "actions": "ActionView action_view scaled",
            "controller": "Controller",
            "core": "SoccerCore",
            "observations": "BodyFeature ObjectFeature SelfFeature observation_space",
            "options": "EnvOptions",
            "others.registry": "controller_entries load_controller",
            "pitch": "Pitch",
            "play": "Film",
            "rendering": "Viewer",
            "rewards": "HausknechtStone named_terms",
            "single": "SoccerEnv",
            "soccer_v2": "SoccerParallelEnv",
            "tasks": "TASKS Outcome Status Task make_task",
            "vector": "SoccerVectorEnv",
        },
    )

    def __getattr__(name: str) -> Any:
        """The names of the face, loaded when they are first used; older versions are answered by what replaced them."""
        from .registration import REPLACED, replaced

        if name in REPLACED:
            replaced(name)
        return _load(name)
