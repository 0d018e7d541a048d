"""drive: dribble along a way that the net around it chooses, until the goal is near (dissertation §2.2.7).

The same as `dribble`, but for the light kicks, which go towards (`way_distance`, `way_direction`): past an opponent, along the wing.

(me)o-> . . o->
              `. . o   the way is looked at again with every kick
"""

from __future__ import annotations

from dataclasses import replace

from ...architecture.petri import Continuous, PetriNet
from ..body import Body, of_body
from .dribble import dribble


@of_body
def drive(body: Body) -> PetriNet:
    """The skill of a player as a module; its outcomes are ``there``, ``lost_ball`` and ``aborted``."""
    net = dribble(body)
    return replace(
        net,
        name="drive",
        ports=replace(net.ports, parameters=(*net.ports.parameters, "way_distance", "way_direction")),
        places=(*net.places, Continuous("way_distance", 10.0), Continuous("way_direction")),  # metres, degrees from the body
        fuse={**net.fuse, "kick.target_distance": "way_distance", "kick.target_direction": "way_direction"},
    )


DRIVE = drive()
"""Of a default player."""
