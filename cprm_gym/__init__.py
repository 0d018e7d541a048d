"""cprm_gym: structured, concurrent, real-time action, and 2D soccer as Gymnasium and PettingZoo environments.

Importing the package registers the environments (``gymnasium.make("cprm/GoToBall-v2")``) and loads nothing else: the names below are loaded
when they are first used.

==================================================  ================================================================================
`PetriNet`, `Place`, `Transition`, `Executor`       write a behaviour and run it (`cprm_gym.architecture.petri`)
`Model`, `Filter`                                   write what is believed and keep it up to date (`cprm_gym.architecture.prm`)
`CPRM`                                              both, coupled (`cprm_gym.architecture`)
`load_net`, `analyze`, `check_contract`             read a net of any format; what it can do; whether a module keeps its contract
`soccer_v2`, `make_task`                            PettingZoo environments; a task by name (`cprm_gym.envs`)
`CprmError`                                         every error that this package raises on purpose
==================================================  ================================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from .envs.registration import register_all as _register_all
from .lazy import lazy_face

__version__ = "0.1.0"

_register_all()

if TYPE_CHECKING:
    from .architecture import CPRM as CPRM
    from .architecture.analysis import analyze as analyze
    from .architecture.analysis import check_contract as check_contract
    from .architecture.petri import Executor as Executor
    from .architecture.petri import PetriNet as PetriNet
    from .architecture.petri import Place as Place
    from .architecture.petri import Transition as Transition
    from .architecture.petri import load_net as load_net
    from .architecture.prm import Filter as Filter
    from .architecture.prm import Model as Model
    from .envs import make_task as make_task
    from .envs import soccer_v2 as soccer_v2
    from .errors import CprmError as CprmError
else:
    __all__, __getattr__, __dir__ = lazy_face(
        __name__,
        {
            "architecture": "CPRM",
            "architecture.analysis": "analyze check_contract",
            "architecture.petri": "Executor PetriNet Place Transition load_net",
            "architecture.prm": "Filter Model",
            "envs": "make_task soccer_v2",
            "errors": "CprmError",
        },
    )
