"""CPRM: a Petri net that acts and a relational model that infers, each seeing the other in its own terms (dissertation §2.3.1, §2.3.4).

The net sees variables as places (`Belief` places: a view of a posterior), the model sees places as variables (`Observe`: a variable whose
reading is an expression over percepts and places), and relations follow object tokens (`Cluster`: while its object places hold objects,
the relation is active on them). `CPRM` is the value; `CPRMRunner` runs it for many agents at once. Neither knows what is being
controlled.

One cycle: percepts set input places -> every `period` cycles the relations that the object places ask for are switched, the model
is told its observations and inference runs -> belief places -> object selection -> math -> immediate transitions -> clocks -> timed
transitions -> commands.
"""

from .files import cprm_from_json, cprm_to_json, load_cprm, save_cprm
from .runner import CPRMRunner, Decision, Percepts
from .value import CPRM, Cluster, Event, Observe, view_of

__all__ = [
    "CPRM",
    "CPRMRunner",
    "Cluster",
    "Decision",
    "Event",
    "Observe",
    "Percepts",
    "cprm_from_json",
    "cprm_to_json",
    "load_cprm",
    "save_cprm",
    "view_of",
]
