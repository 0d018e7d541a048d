"""drive: dribble along a way that the net around it chooses, until the goal is near (dissertation §2.2.7).

The same as `dribble`, but for the light kicks, which go towards (`way_distance`, `way_direction`): past an opponent, along the wing.

(me)o-> . . o->
              `. . o   the way is looked at again with every kick
"""

from __future__ import annotations

from dataclasses import replace

from ...architecture.petri import Continuous
from .dribble import DRIBBLE

_PORTS = DRIBBLE.ports

DRIVE = replace(
    DRIBBLE,
    name="drive",
    ports=replace(_PORTS, parameters=(*_PORTS.parameters, "way_distance", "way_direction")),
    places=(*DRIBBLE.places, Continuous("way_distance", 10.0), Continuous("way_direction")),  # metres, degrees from the body
    fuse={**DRIBBLE.fuse, "kick.target_distance": "way_distance", "kick.target_direction": "way_direction"},
)
"""The skill as a module; its outcomes are ``there``, ``lost_ball`` and ``aborted``."""
