"""What a soccer player believes about the world: PRM classes built from the simulator's own senses and motion.

Distances in metres, directions in degrees relative to the player's body, one slice per cycle (100 ms).
"""

from __future__ import annotations

from ..architecture.prm.cpds import Chance, Noise, Prior, Switch, Table, Uniform
from ..architecture.prm.domains import BOOL, Bins, Labels
from ..architecture.prm.schema import Attribute, Input, Model, PRMClass, Relation, Replace, prev

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

# ------------------------------------------------------------------ what a goalie tracks, in the frame of his team's pitch

PITCH_X = Bins(
    (*(-53.5 + 0.5 * k for k in range(20)), *(float(x) for x in range(-43, -27)), -26.0, -24.0, -21.0, -18.0, -14.0, -9.0),
    unit="m",
    clip=True,
)
"""Towards the opponent's goal: half a metre wide in front of the own goal (the line is at -52.5)."""
PITCH_Y = Bins((-24.0, -18.0, -14.0, -11.0, *(-9.0 + 0.5 * k for k in range(37)), 11.0, 14.0, 18.0, 24.0), unit="m", clip=True)
"""Across the pitch: half a metre wide in front of the goal (posts at 7.01)."""
SPEED_X = Bins(
    (-3.1, -2.8, -2.5, -2.2, -1.95, -1.7, -1.5, -1.3, -1.1, -0.9, -0.7, -0.5, -0.3, -0.1, 0.1, 0.4, 1.0, 3.0), unit="m/cycle", clip=True
)
"""Of the ball, towards the opponent's goal; ``ball_speed_max`` is 3."""
SPEED_Y = Bins((-2.4, -1.7, -1.35, -1.1, -0.9, -0.75, -0.6, -0.48, -0.36, -0.24, -0.12, -0.04,
                0.04, 0.12, 0.24, 0.36, 0.48, 0.6, 0.75, 0.9, 1.1, 1.35, 1.7, 2.4), unit="m/cycle", clip=True)  # fmt: skip
"""Of the ball, across."""
COARSE_X = Bins((*(-53.0 + 2.0 * k for k in range(16)), -18.0, -14.0, -5.0, 10.0), unit="m", clip=True)
COARSE_Y = Bins((-34.0, -22.0, *(-16.0 + 2.0 * k for k in range(17)), 22.0, 34.0), unit="m", clip=True)
FACING = Labels(("goal", "aside", "away"))
"""Whether an opponent's body points to the own goal (within 40 degrees), aside of it, or away from it (over 110)."""

BALL_DECAY = 0.94
"""Share of its speed that the ball keeps in a cycle (SIMULATOR.md 3.1)."""
BALL_RAND = 0.05
"""Noise of its motion as a share of its speed: a vector spread evenly in direction and length, of which one coordinate has the standard
deviation ``BALL_RAND / sqrt(6)``."""
QUANTUM = 0.029
"""Standard deviation of a seen distance as its share: steps of 10 % (``quantize_step``), spread evenly (SIMULATOR.md 6.1.4)."""
KEEPER_X = -50.0
"""Where the goalie mostly stands: the eye's error grows with the distance from there."""

_ROLL = f"{BALL_RAND / 6**0.5:.4f}"
_TOUCHED = 0.03
"""Share of cycles in which somebody touches the ball, which then may have any velocity."""

TRACKED_BALL = PRMClass(
    "Ball",
    attributes=(
        # hidden: place and velocity; along and across the pitch they move apart, so that each pair is a small component of its own
        Attribute("x", PITCH_X, parents=(prev("x"), prev("vx")), initial=Uniform(), cpd=Noise("prev.x + prev.vx", sd=0.1)),
        Attribute("vx", SPEED_X, parents=(prev("vx"),), initial=Uniform(),
                  cpd=Noise(f"{BALL_DECAY} * prev.vx", sd=f"0.01 + {_ROLL} * abs(prev.vx)", floor=_TOUCHED)),
        Attribute("y", PITCH_Y, parents=(prev("y"), prev("vy")), initial=Uniform(), cpd=Noise("prev.y + prev.vy", sd=0.1)),
        Attribute("vy", SPEED_Y, parents=(prev("vy"),), initial=Uniform(),
                  cpd=Noise(f"{BALL_DECAY} * prev.vy", sd=f"0.01 + {_ROLL} * abs(prev.vy)", floor=_TOUCHED)),
        # observed, in cycles with a look at it
        Attribute("seen_x", PITCH_X, parents=("x",), cpd=Noise("x", sd=f"0.1 + {QUANTUM} * abs(x - {KEEPER_X})", floor=1e-3)),
        Attribute("seen_y", PITCH_Y, parents=("y",), cpd=Noise("y", sd=f"0.12 + {QUANTUM} * abs(y)", floor=1e-3)),
        Attribute("seen_vx", SPEED_X, parents=("vx",), cpd=Noise("vx", sd=f"0.03 + {QUANTUM} * abs(vx)", floor=1e-3)),
        Attribute("seen_vy", SPEED_Y, parents=("vy",), cpd=Noise("vy", sd=f"0.03 + {QUANTUM} * abs(vy)", floor=1e-3)),
    ),
)  # fmt: skip
"""The ball as a goalie tracks it: hidden place and velocity with links in time, and what is seen of them (Fig. 2.25)."""

OPPONENT = PRMClass(
    "Opponent",
    attributes=(
        Attribute("x", COARSE_X),
        Attribute("y", COARSE_Y),
        Attribute("facing", FACING, cpd=Prior((0.4, 0.35, 0.25))),
        Attribute("seen_x", COARSE_X, parents=("x",), cpd=Noise("x", sd=f"0.3 + {QUANTUM} * abs(x - {KEEPER_X})", floor=1e-3)),
        Attribute("seen_y", COARSE_Y, parents=("y",), cpd=Noise("y", sd=f"0.3 + {QUANTUM} * abs(y)", floor=1e-3)),
        Attribute("seen_facing", FACING, parents=("facing",), cpd=Table({"goal": (0.9, 0.09, 0.01), "aside": (0.08, 0.84, 0.08),
                                                                         "away": (0.01, 0.09, 0.9)})),
    ),
)  # fmt: skip
"""An opponent whom nobody watches: priors smooth what is seen, without memory (Fig. 2.26)."""

ATTENDED = Relation(
    "attendedOpponent",
    roles=(("o", "Opponent"),),
    changes=(
        Replace("o.x", parents=(prev("o.x"),), cpd=Noise("prev.o.x", sd=0.7)),
        Replace("o.y", parents=(prev("o.y"),), cpd=Noise("prev.o.y", sd=0.7)),
        Replace("o.facing", parents=(prev("o.facing"),), cpd=Table({"goal": (0.94, 0.05, 0.01), "aside": (0.07, 0.86, 0.07),
                                                                    "away": (0.01, 0.07, 0.92)})),
    ),
)  # fmt: skip
"""Attention: links in time for those opponents that matter (Fig. 2.27); 0.7 m a cycle is a running player."""

POSSESSES = Relation(
    "possessesOpponent",
    roles=(("o", "Opponent"), ("b", "Ball")),
    attributes=(
        Attribute("shoot", BOOL, parents=("o.x", "o.facing"),
                  cpd=Chance("clip((-18 - o.x) / 40, 0, 0.6) * (1 if o.facing < 0.5 else 0.2)")),
    ),
    changes=(
        Replace("b.vx", parents=(prev("b.vx"), "shoot"), cpd=Switch("shoot", {
            "yes": Noise("-2.2", sd=0.5, floor=0.01),
            "no": Noise(f"{BALL_DECAY} * prev.b.vx", sd=0.3, floor=0.01),
        })),
    ),
    conflict="mixture",
    keep_joint=(("b.x", "b.vx"), ("b.y", "b.vy")),
)  # fmt: skip
"""An opponent who has the ball: from his place and the way he faces follows whether he shoots, and then the ball flies (Fig. 2.28)."""

GOALIE_MODEL = Model("goalie", classes=(TRACKED_BALL, OPPONENT), relations=(ATTENDED, POSSESSES))
"""Ball, opponents, and the two relations between them (§2.3.5)."""
