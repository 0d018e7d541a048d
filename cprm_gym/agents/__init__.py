"""Soccer behaviours built from the architecture: percepts, skills, models and whole agents.

============  ===========================================================================================
`percepts`    observation arrays -> named quantities, in metres and degrees
`skills`      behaviour modules, one file each
`models`      what the agents believe: classes, relations and views
`play`        `SoccerAgent`: a CPRM as a controller
`seeker`      the agents, one file each: `striker`, `passer`, `goalie`, `outfielder`, `eleven`, `match` too
`worlds`      stages, and worlds learned on them, for analysis
`catalogue`   every net that ships, by name
============  ===========================================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazy import lazy_face

if TYPE_CHECKING:
    from .catalogue import shipped_net as shipped_net
    from .catalogue import shipped_nets as shipped_nets
    from .eleven import Eleven as Eleven
    from .goalie import GoalieAgent as GoalieAgent
    from .goalie import goalie_cprm as goalie_cprm
    from .models import BALL_MODEL as BALL_MODEL
    from .outfielder.agent import OutfieldAgent as OutfieldAgent
    from .passer import PasserAgent as PasserAgent
    from .passer import passer_cprm as passer_cprm
    from .percepts import ball_percepts as ball_percepts
    from .percepts import body_percepts as body_percepts
    from .percepts import field_percepts as field_percepts
    from .percepts import motion_percepts as motion_percepts
    from .play import SoccerAgent as SoccerAgent
    from .registry import AGENTS as AGENTS
    from .registry import make_controller as make_controller
    from .seeker import SEEKER as SEEKER
    from .striker import STRIKER as STRIKER
else:
    __all__, __getattr__, __dir__ = lazy_face(
        __name__,
        {
            "play": "SoccerAgent",
            "registry": "AGENTS make_controller",
            "catalogue": "shipped_net shipped_nets",
            "models": "BALL_MODEL",
            "percepts": "ball_percepts body_percepts field_percepts motion_percepts",
            "seeker": "SEEKER",
            "striker": "STRIKER",
            "goalie": "GoalieAgent goalie_cprm",
            "passer": "PasserAgent passer_cprm",
            "outfielder.agent": "OutfieldAgent",
            "eleven": "Eleven",
        },
    )
