"""The architecture: a Petri net that acts, a relational model that infers, and their coupling. It knows no soccer.

=============  ==========================================================================================
`expressions`  the one small language of math places, selections, formulas and conditions
`petri`        extended Petri nets: written, run, drawn, saved
`prm`          dynamic probabilistic relational models: written, grounded, filtered, learned, saved
`cprm`         both coupled (`CPRM`), and run for many agents at once (`CPRMRunner`)
`analysis`     what a net can do, and whether a module keeps its contract
=============  ==========================================================================================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazy import lazy_face

if TYPE_CHECKING:
    from .cprm import CPRM as CPRM
    from .cprm import Cluster as Cluster
    from .cprm import CPRMRunner as CPRMRunner
    from .cprm import Decision as Decision
    from .cprm import Event as Event
    from .cprm import Observe as Observe
    from .cprm import cprm_from_json as cprm_from_json
    from .cprm import cprm_to_json as cprm_to_json
    from .cprm import load_cprm as load_cprm
    from .cprm import save_cprm as save_cprm
else:
    __all__, __getattr__, __dir__ = lazy_face(
        __name__,
        {
            "cprm": "CPRM CPRMRunner Cluster Decision Event Observe cprm_from_json cprm_to_json load_cprm save_cprm",
        },
    )
