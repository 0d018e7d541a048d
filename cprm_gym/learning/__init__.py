"""Learning: policies trained with stable-baselines3, shipped as safe files, played as controllers.

``cprm-gym train ALGORITHM --task TASK`` trains (`configuration` says how, `training` does it, `report` tells); a `Policy` runs in NumPy,
without PyTorch, and plays as the controller ``policy`` (`player`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazy import lazy_face

if TYPE_CHECKING:
    from .configuration import ALGORITHMS as ALGORITHMS
    from .configuration import Configuration as Configuration
    from .configuration import read_configuration as read_configuration
    from .player import PolicyController as PolicyController
    from .policy import Description as Description
    from .policy import Policy as Policy
    from .policy import load_policy as load_policy
    from .policy import save_policy as save_policy
    from .policy import shipped as shipped
    from .training import Plan as Plan
    from .training import train as train
else:
    __all__, __getattr__, __dir__ = lazy_face(
        __name__,
        {
            "configuration": "ALGORITHMS Configuration read_configuration",
            "player": "PolicyController",
            "policy": "Description Policy load_policy save_policy shipped",
            "training": "Plan train",
        },
    )
