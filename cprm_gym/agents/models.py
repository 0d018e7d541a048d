"""What a soccer player believes about the world: PRM classes built from the simulator's own senses and motion.

Distances in metres, directions in degrees relative to the player's body, one slice per cycle (100 ms).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..architecture.prm.model.cpds import Chance, Mixture, Noise, Prior, Switch, Table, Uniform
from ..architecture.prm.model.domains import BOOL, Bins, Labels
from ..architecture.prm.model.model import Model
from ..architecture.prm.model.schema import Attribute, Given, PRMClass, Relation, Replace, prev
from ..lazy import made_on_use
from ..simulator.parameters import ServerParameters
from ..simulator.pitch import HALF_LENGTH, HALF_WIDTH
from .body import Body, number, of_body

DISTANCE = Bins((0, 1, 2, 4, 7, 11, 16, 22, 30, 40, 60), unit="m", clip=True)
"""Ten bins, fine near the player: the eye's error grows with the distance (specification/simulator.md 6.1.4)."""
DIRECTION = Bins((-180, -125, -80, -50, -25, -8, 8, 25, 50, 80, 125, 180), unit="deg", circular=True)
"""Eleven bins, fine ahead."""
TURNED = Bins(tuple(float(d) for d in range(-185, 186, 10)), unit="deg", clip=True)
"""Degrees the body turned in the last cycle."""
ADVANCED = Bins((-0.15, 0.15, 0.45, 0.75, 1.05, 1.35), unit="m", clip=True)
"""Metres the body went ahead in the last cycle."""

VIEW_HALF = 60.0
"""Half of the normal view cone of 120 degrees (specification/simulator.md 4.7)."""


def _seen_ball(body: Body) -> PRMClass:
    """The ball: hidden distance and direction; observed distance, direction and whether it was seen (§2.3.5)."""
    return PRMClass(
        "Ball",
        given=(Given("turned_deg", TURNED, default=0.0), Given("advanced", ADVANCED, default=0.0)),
        attributes=(
            # hidden: where the ball is; what the player himself did moves it in his frame, the ball's own roll is the noise
            Attribute("dist", DISTANCE, parents=(prev("dist"), prev("dir_deg"), "advanced"), initial=Uniform(),
                      cpd=Noise("abs(prev.dist - advanced * cos(radians(prev.dir_deg)))", sd=0.5, points=12)),
            Attribute("dir_deg", DIRECTION, parents=(prev("dir_deg"), "turned_deg"), initial=Uniform(),
                      cpd=Noise("prev.dir_deg - turned_deg", sd="4 + 0.07 * abs(turned_deg)")),
            # observed: only in cycles with a look
            Attribute("seen", BOOL, parents=("dist", "dir_deg"),
                      cpd=Chance(f"0.98 if abs(dir_deg) < {VIEW_HALF} or dist < {number(body.server.visible_distance)} else 0.005")),
            Attribute("seen_dist", DISTANCE, parents=("seen", "dist"),
                      cpd=Switch("seen", {"yes": Noise("dist", sd="0.05 + 0.03 * dist"), "no": Uniform()})),
            Attribute("seen_dir_deg", DIRECTION, parents=("seen", "dir_deg"),
                      cpd=Switch("seen", {"yes": Noise("dir_deg", sd=1.0), "no": Uniform()})),
        ),
    )  # fmt: skip


@of_body
def ball_model(body: Body) -> Model:
    """One ball and the player's own motion."""
    return Model("ball", classes=(_seen_ball(body),))


# ------------------------------------------------------------------ what a goalie tracks, in the frame of his team's pitch

PITCH_X = Bins(
    tuple(
        x - HALF_LENGTH for x in (*(-1.0 + 0.5 * k for k in range(20)), *(9.5 + k for k in range(16)), 26.5, 28.5, 31.5, 34.5, 38.5, 43.5)
    ),
    unit="m",
    clip=True,
)
"""Towards the opponent's goal: half a metre wide in front of the own goal."""
PITCH_Y = Bins((-24.0, -18.0, -14.0, -11.0, *(-9.0 + 0.5 * k for k in range(37)), 11.0, 14.0, 18.0, 24.0), unit="m", clip=True)
"""Across the pitch: half a metre wide in front of the goal (posts at 7.01)."""
_SPEEDS_X = (-3.1, -2.8, -2.5, -2.2, -1.95, -1.7, -1.5, -1.3, -1.1, -0.9, -0.7, -0.5, -0.3, -0.1, 0.1, 0.4, 1.0, 3.0)
"""Of a ball of a default server, towards the opponent's goal."""
_SPEEDS_Y = (0.04, 0.12, 0.24, 0.36, 0.48, 0.6, 0.75, 0.9, 1.1, 1.35, 1.7, 2.4)
"""Across, to either side."""
_BOTH_WAYS = (*(-v for v in reversed(_SPEEDS_Y)), *_SPEEDS_Y)
_USUAL = ServerParameters().ball_speed_max


def speeds(body: Body, edges: Sequence[float]) -> Bins:
    """Bins of a velocity: those of a default server, stretched to what a ball can reach here."""
    stretch = body.server.ball_speed_max / _USUAL
    return Bins(tuple(round(edge * stretch, 6) for edge in edges), unit="m/cycle", clip=True)


COARSE_X = Bins(tuple(x - HALF_LENGTH for x in (*(-0.5 + 2.0 * k for k in range(16)), 34.5, 38.5, 47.5, 62.5)), unit="m", clip=True)
COARSE_Y = Bins((-HALF_WIDTH, -22.0, *(-16.0 + 2.0 * k for k in range(17)), 22.0, HALF_WIDTH), unit="m", clip=True)
FACING = Labels(("goal", "aside", "away"))
"""Whether an opponent's body points to the own goal (within 40 degrees), aside of it, or away from it (over 110)."""


def ball_noise(body: Body) -> float:
    """Standard deviation of a coordinate of the ball's velocity after a cycle, as a share of its speed.

    The server's noise is a vector spread evenly in direction, and in length up to ``ball_rand`` times the speed.
    """
    return round(body.server.ball_rand / 6**0.5, 4)


def quantum(body: Body) -> float:
    """Standard deviation of a seen distance as its share: steps of ``quantize_step``, spread evenly (specification/simulator.md 6.1.4)."""
    return round(body.server.quantize_step / 12**0.5, 3)


KEEPER_X = 2.5 - HALF_LENGTH
"""Where the goalie mostly stands: the eye's error grows with the distance from there."""

_TOUCHED = 0.03
"""Share of cycles in which somebody touches the ball, which then may have any velocity."""


def _tracked_ball(body: Body) -> PRMClass:
    """The ball as a goalie tracks it: hidden place and velocity with links in time, and what is seen of them (Fig. 2.25)."""
    return PRMClass(
        "Ball",
        attributes=(
            # hidden: place and velocity; along and across the pitch they move apart, so that each pair is a small component of its own
            Attribute("x", PITCH_X, parents=(prev("x"), prev("vx")), initial=Uniform(), cpd=Noise("prev.x + prev.vx", sd=0.1)),
            Attribute("vx", speeds(body, _SPEEDS_X), parents=(prev("vx"),), initial=Uniform(),
                      cpd=Noise(f"{number(body.ball_decay)} * prev.vx", sd=f"0.01 + {ball_noise(body)} * abs(prev.vx)", floor=_TOUCHED)),
            Attribute("y", PITCH_Y, parents=(prev("y"), prev("vy")), initial=Uniform(), cpd=Noise("prev.y + prev.vy", sd=0.1)),
            Attribute("vy", speeds(body, _BOTH_WAYS), parents=(prev("vy"),), initial=Uniform(),
                      cpd=Noise(f"{number(body.ball_decay)} * prev.vy", sd=f"0.01 + {ball_noise(body)} * abs(prev.vy)", floor=_TOUCHED)),
            # observed, in cycles with a look at it
            Attribute("seen_x", PITCH_X, parents=("x",), cpd=Noise("x", sd=f"0.1 + {quantum(body)} * abs(x - {KEEPER_X})", floor=1e-3)),
            Attribute("seen_y", PITCH_Y, parents=("y",), cpd=Noise("y", sd=f"0.12 + {quantum(body)} * abs(y)", floor=1e-3)),
            Attribute("seen_vx", speeds(body, _SPEEDS_X), parents=("vx",),
                      cpd=Noise("vx", sd=f"0.03 + {quantum(body)} * abs(vx)", floor=1e-3)),
            Attribute("seen_vy", speeds(body, _BOTH_WAYS), parents=("vy",),
                      cpd=Noise("vy", sd=f"0.03 + {quantum(body)} * abs(vy)", floor=1e-3)),
        ),
    )  # fmt: skip


def _opponent(body: Body) -> PRMClass:
    """An opponent whom nobody watches: priors smooth what is seen, without memory (Fig. 2.26)."""
    return PRMClass(
        "Opponent",
        attributes=(
            Attribute("x", COARSE_X),
            Attribute("y", COARSE_Y),
            Attribute("facing", FACING, cpd=Prior((0.4, 0.35, 0.25))),
            Attribute("seen_x", COARSE_X, parents=("x",), cpd=Noise("x", sd=f"0.3 + {quantum(body)} * abs(x - {KEEPER_X})", floor=1e-3)),
            Attribute("seen_y", COARSE_Y, parents=("y",), cpd=Noise("y", sd=f"0.3 + {quantum(body)} * abs(y)", floor=1e-3)),
            Attribute("seen_facing", FACING, parents=("facing",), cpd=Table({"goal": (0.9, 0.09, 0.01), "aside": (0.08, 0.84, 0.08),
                                                                             "away": (0.01, 0.09, 0.9)})),
        ),
    )  # fmt: skip


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


def _possesses(body: Body) -> Relation:
    """An opponent who has the ball: from his place and the way he faces follows whether he shoots, and then the ball flies (Fig. 2.28)."""
    return Relation(
        "possessesOpponent",
        roles=(("o", "Opponent"), ("b", "Ball")),
        attributes=(
            Attribute("shoot", BOOL, parents=("o.x", "o.facing"),
                      cpd=Chance("clip((-18 - o.x) / 40, 0, 0.6) * (1 if o.facing < 0.5 else 0.2)")),
        ),
        changes=(
            Replace("b.vx", parents=(prev("b.vx"), "shoot"), cpd=Switch("shoot", {
                "yes": Noise("-2.2", sd=0.5, floor=0.01),
                "no": Noise(f"{number(body.ball_decay)} * prev.b.vx", sd=0.3, floor=0.01),
            })),
        ),
        conflict="mixture",
        keep_joint=(("b.x", "b.vx"), ("b.y", "b.vy")),
    )  # fmt: skip


@of_body
def goalie_model(body: Body) -> Model:
    """Ball, opponents, and the two relations between them (§2.3.5)."""
    return Model("goalie", classes=(_tracked_ball(body), _opponent(body)), relations=(ATTENDED, _possesses(body)))


# ------------------------------------------------------------------ what a player of the passing pair tracks, from where he is

_RANGES: tuple[float, ...] = (0.0, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95, 1.05, 1.16, 1.28)
RANGE = Bins((*_RANGES, *(round(1.28 * 1.105**k, 2) for k in range(1, 40))), unit="m", clip=True)
"""Metres from the player in the steps of the eye: a tenth of the distance, a decimetre where near (specification/simulator.md 6.1.4)."""
_APPROACHES = (0.04, 0.13, 0.24, 0.37, 0.53, 0.73, 1.0, 1.4, 2.0, 3.0)
APPROACH = Bins((*(-a for a in reversed(_APPROACHES)), *_APPROACHES), unit="m/cycle", clip=True)
"""Of the ball towards the player, by its own motion."""
BEARING = Bins.circle(72, "deg")
"""Direction from the player, in the frame of his team's pitch: his own turns do not change it."""
_SWINGS = (0.3, 1.0, 2.2, 4.5, 8.0, 14.0, 26.0, 60.0)
SWING = Bins((*(-s for s in reversed(_SWINGS)), *_SWINGS), unit="deg/cycle", clip=True)
"""Change of the bearing by the ball's own motion."""
MET = Bins.linear(-1.1, 1.1, 11, "m", clip=True)
"""Metres by which the ball came nearer in the last cycle by the player's own way and kick."""
_SLIDES = (0.5, 1.5, 3.0, 5.0, 8.0, 13.0, 22.0, 40.0, 80.0, 180.0)
SLID = Bins((*(-a for a in reversed(_SLIDES)), *_SLIDES), unit="deg", clip=True)
"""Change of the bearing by the player's own way and kick, with the opposite sign."""
SENT = Bins((-1.0, 0.0, 0.04, 0.2, 0.5, 0.8, 1.1, 1.4, 1.8, 2.2, 3.0), unit="m/cycle", clip=True)
"""Speed at which his own kick was to send the ball away, about 0 where it hit his body; -1 for neither."""
EYES = Bins.circle(36, "deg")
"""Where the face points, in the frame of the pitch."""
FIELD_X = Bins.linear(-HALF_LENGTH - 3.5, HALF_LENGTH + 3.5, 112, "m", clip=True)
FIELD_Y = Bins.linear(-HALF_WIDTH - 2.0, HALF_WIDTH + 2.0, 72, "m", clip=True)
TOWARDS = Labels(("me", "aside", "away"))
"""Whether a team-mate's body points at the player (within 40 degrees), aside of him, or away from him (over 110)."""

_KNOCKED = 0.01
"""Share of cycles in which somebody or something else changes how the ball moves."""
_LOST = 0.003
"""Share of cycles in which the ball is somewhere else than its motion says: somebody touched it, or the player was moved."""
_BLURRED = 0.05
"""Share of readings that are much worse than the eye is by itself."""
_NO_KICK = "sent < 0"


def _read(mean: str, sd: str, blurred: str) -> Mixture:
    """A reading as the eye gives it, or now and then a blurred one, which tells a little still."""
    return Mixture((1.0 - _BLURRED, Noise(mean, sd=sd)), (_BLURRED, Noise(mean, sd=blurred, floor=1e-3)))


def _passed_ball(body: Body) -> PRMClass:
    """The ball as a player tracks it who runs and kicks himself: distance, bearing and their rates (Fig. 2.25).

    ``seen`` hangs on the bearing alone, not on the distance, for the dissertation's reason: distance and bearing stay components of their
    own. So it must be observed only of a ball too far off to be felt (``visible_distance``).
    """
    return PRMClass(
        "Ball",
        given=(
            Given("met", MET, default=0.0), Given("slid_deg", SLID, default=0.0), Given("sent", SENT, default=-1.0),
            Given("eyes_deg", EYES, default=0.0),
        ),
        attributes=(
            # hidden: how it moves, and then where it is; distance and bearing are components of their own, so that both are cheap
            Attribute("approach", APPROACH, parents=(prev("approach"), "sent"), initial=Uniform(),
                      cpd=Mixture((1.0 - _KNOCKED, Noise(f"{number(body.ball_decay)} * prev.approach if {_NO_KICK} else -sent", points=3,
                                                         sd=f"0.01 + 0.04 * abs(prev.approach) if {_NO_KICK} else 0.02 + 0.15 * sent")),
                                  (_KNOCKED, Noise("0", sd=1.0)))),
            Attribute("dist", RANGE, parents=(prev("dist"), "approach", "met"), initial=Uniform(),
                      cpd=Noise("prev.dist - approach - met", sd=0.03, floor=_LOST, points=2)),
            Attribute("swing_deg", SWING, parents=(prev("swing_deg"), "sent"), initial=Uniform(),
                      cpd=Mixture((1.0 - _KNOCKED, Noise(f"{number(body.ball_decay)} * prev.swing_deg if {_NO_KICK} else 0", points=3,
                                                         sd=f"0.1 + 0.25 * abs(prev.swing_deg) if {_NO_KICK} else 1 + 4 * sent")),
                                  (_KNOCKED, Noise("0", sd=15.0)))),
            Attribute("bearing_deg", BEARING, parents=(prev("bearing_deg"), "swing_deg", "slid_deg"), initial=Uniform(),
                      cpd=Noise("prev.bearing_deg + swing_deg - slid_deg", sd=0.6, floor=_LOST, points=1)),
            # observed in cycles with a look, the velocities where the eye tells them; they are what the decay has left
            Attribute("seen_dist", RANGE, parents=("dist",), cpd=_read("dist", f"0.03 + {quantum(body)} * dist", "0.1 + 0.2 * dist")),
            Attribute("seen_approach", APPROACH, parents=("approach",),
                      cpd=_read(f"{number(body.ball_decay)} * approach", f"0.03 + {quantum(body)} * abs(approach)", "0.4")),
            Attribute("seen_bearing_deg", BEARING, parents=("bearing_deg",), cpd=_read("bearing_deg", "1.2", "10")),
            Attribute("seen_swing_deg", SWING, parents=("swing_deg",),
                      cpd=_read(f"{number(body.ball_decay)} * swing_deg", "0.1 + 0.05 * abs(swing_deg)", "8")),
            # a ball that is not where the player looks is somewhere else
            Attribute("seen", BOOL, parents=("bearing_deg", "eyes_deg"),
                      cpd=Chance(f"0.98 if abs(norm_deg(bearing_deg - eyes_deg)) < {VIEW_HALF} else 0.005", points=8)),
        ),
    )  # fmt: skip


TEAMMATE = PRMClass(
    "Teammate",
    attributes=(
        Attribute("x", FIELD_X),
        Attribute("y", FIELD_Y),
        Attribute("facing", TOWARDS, cpd=Prior((0.3, 0.5, 0.2))),
        Attribute("seen_x", FIELD_X, parents=("x",), cpd=Noise("x", sd=0.35, floor=1e-3)),
        Attribute("seen_y", FIELD_Y, parents=("y",), cpd=Noise("y", sd=0.35, floor=1e-3)),
        Attribute("seen_facing", TOWARDS, parents=("facing",), cpd=Table({"me": (0.9, 0.09, 0.01), "aside": (0.08, 0.84, 0.08),
                                                                          "away": (0.01, 0.09, 0.9)})),
    ),
)  # fmt: skip
"""A team-mate to whom nobody attends: his place is a guess from the present glance (as Fig. 2.26)."""

ATTENDED_MATE = Relation(
    "attendedTeammate",
    roles=(("m", "Teammate"),),
    changes=(
        Replace("m.x", parents=(prev("m.x"),), cpd=Noise("prev.m.x", sd=0.6)),
        Replace("m.y", parents=(prev("m.y"),), cpd=Noise("prev.m.y", sd=0.4)),
        Replace("m.facing", parents=(prev("m.facing"),), cpd=Table({"me": (0.9, 0.09, 0.01), "aside": (0.06, 0.88, 0.06),
                                                                    "away": (0.01, 0.09, 0.9)})),
    ),
)  # fmt: skip
"""Attention: the place of the partner is remembered, and becomes less certain at the pace of a runner (as Fig. 2.27)."""


def _possesses_mate(body: Body) -> Relation:
    """A team-mate who has the ball: from the way he faces follows whether he passes, and then the ball comes (as Fig. 2.28)."""
    return Relation(
        "possessesTeammate",
        roles=(("m", "Teammate"), ("b", "Ball")),
        attributes=(
            Attribute("pass", BOOL, parents=("m.facing",), cpd=Table({"me": (0.9, 0.1), "aside": (0.97, 0.03), "away": (0.995, 0.005)})),
        ),
        changes=(
            Replace("b.approach", parents=(prev("b.approach"), "b.sent", "pass"), cpd=Switch("pass", {
                "yes": Noise("1.3", sd=0.4, floor=0.01),
                "no": Noise(f"{number(body.ball_decay)} * prev.b.approach if b.sent < 0 else -b.sent",
                            sd="0.1 + 0.04 * abs(prev.b.approach) if b.sent < 0 else 0.02 + 0.15 * b.sent", floor=_TOUCHED, points=3),
            })),
        ),
        conflict="mixture",
        keep_joint=(("b.dist", "b.approach"), ("b.bearing_deg", "b.swing_deg")),
    )  # fmt: skip


@of_body
def passer_model(body: Body) -> Model:
    """Ball, team-mates, and the two relations between them."""
    return Model("passer", classes=(_passed_ball(body), TEAMMATE), relations=(ATTENDED_MATE, _possesses_mate(body)))


if TYPE_CHECKING:
    BALL_MODEL: Model
    """Of a default player."""
    GOALIE_MODEL: Model
    """Of a default goalie."""
    PASSER_MODEL: Model
    """Of a default player."""

__getattr__ = made_on_use(__name__, {"BALL_MODEL": ball_model, "GOALIE_MODEL": goalie_model, "PASSER_MODEL": passer_model})
