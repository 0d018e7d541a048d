"""What a soccer player believes about the world: PRM classes built from the simulator's own senses and motion.

Distances in metres, directions in degrees relative to the player's body, one slice per cycle (100 ms).
"""

from __future__ import annotations

from ..architecture.prm.cpds import Chance, Noise, Switch, Uniform
from ..architecture.prm.domains import BOOL, Bins
from ..architecture.prm.schema import Attribute, Input, Model, PRMClass, prev

DISTANCE = Bins((0, 1, 2, 4, 7, 11, 16, 22, 30, 40, 60), unit="m", clip=True)
"""Ten bins, fine near the player: the eye's error grows with the distance (SIMULATOR.md 6.1.4)."""
DIRECTION = Bins((-180, -125, -80, -50, -25, -8, 8, 25, 50, 80, 125, 180), unit="deg", circular=True)
"""Eleven bins, fine ahead."""
TURNED = Bins(tuple(float(d) for d in range(-185, 186, 10)), unit="deg", clip=True)
"""Degrees the body turned in the last cycle."""
ADVANCED = Bins((-0.15, 0.15, 0.45, 0.75, 1.05, 1.35), unit="m", clip=True)
"""Metres the body went ahead in the last cycle."""

VIEW_HALF = 60.0
"""Half of the normal view cone of 120 degrees (SIMULATOR.md 4.7)."""
FELT = 3.0
"""Metres within which things are felt without being seen (``visible_distance``)."""

BALL = PRMClass(
    "Ball",
    inputs=(Input("turned", TURNED, default=0.0), Input("advanced", ADVANCED, default=0.0)),
    attributes=(
        # hidden: where the ball is; what the player himself did moves it in his frame, the ball's own roll is the noise
        Attribute("dist", DISTANCE, parents=(prev("dist"), prev("dir"), "advanced"), initial=Uniform(),
                  cpd=Noise("abs(prev.dist - advanced * cos(radians(prev.dir)))", sd=0.5)),
        Attribute("dir", DIRECTION, parents=(prev("dir"), "turned"), initial=Uniform(),
                  cpd=Noise("prev.dir - turned", sd="4 + 0.07 * abs(turned)")),
        # observed: only in cycles with a look
        Attribute("seen", BOOL, parents=("dist", "dir"),
                  cpd=Chance(f"0.98 if abs(dir) < {VIEW_HALF} or dist < {FELT} else 0.005")),
        Attribute("seen_dist", DISTANCE, parents=("seen", "dist"),
                  cpd=Switch("seen", {"yes": Noise("dist", sd="0.05 + 0.03 * dist"), "no": Uniform()})),
        Attribute("seen_dir", DIRECTION, parents=("seen", "dir"),
                  cpd=Switch("seen", {"yes": Noise("dir", sd=1.0), "no": Uniform()})),
    ),
)  # fmt: skip
"""The ball: hidden distance and direction; observed distance, direction and whether it was seen (§2.3.5)."""

BALL_MODEL = Model("ball", classes=(BALL,))
"""One ball and the player's own motion."""
