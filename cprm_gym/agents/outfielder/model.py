"""What an outfield player believes: the ball, the opponent at it and the team-mate whom he would pass to, on the whole pitch.

In the frame of his team's pitch, metres; a slice is `PERIOD` cycles, since the eye opens every second one. The same scheme as the
goalie's (`models.GOALIE_MODEL`), with wider bins over the whole pitch, with team-mates, and with relations that never tie the ball to
a player: so every object stays a small component of its own, and a slice is filtered in a fraction of a millisecond.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...architecture.prm.model.cpds import Chance, Noise, Switch, Uniform
from ...architecture.prm.model.domains import BOOL, Bins
from ...architecture.prm.model.model import Model
from ...architecture.prm.model.schema import Attribute, PRMClass, Relation, Replace, prev
from ...lazy import made_on_use
from ..body import Body, of_body
from ..models import speeds

PERIOD = 2
"""Cycles of a slice, if no other number is asked for."""
BALL_PLACE = Bins.linear(-54.0, 54.0, 72, "m", clip=True)
"""A metre and a half wide: where the eye has the ball, the net goes by the eye; this is for when it has not. The same along and across
the pitch, so that both coordinates are filtered as two copies of one component."""
_SPEEDS = (0.06, 0.2, 0.4, 0.7, 1.1, 1.6, 2.2, 3.0)
"""Of the ball along an axis, either way, fine where it is slow."""
PLAYER_PLACE = Bins.linear(-54.0, 54.0, 54, "m", clip=True)
"""Two metres wide."""
EYE = 0.8
"""Standard deviation of a seen coordinate, m: that of a reading from about 25 m, with the own place that it is reckoned from."""
RUN = 1.1
"""What a running player may move in two cycles along an axis, m (standard deviation)."""
TOUCHED = 0.1
"""Share of two cycles in which somebody kicks the ball, which then may have any velocity."""


def _kept(body: Body, period: int) -> str:
    """Share of its speed that the ball keeps in a slice."""
    return f"{body.ball_decay**period:.4f}"


def _in_slice(share: float, period: int) -> float:
    """Share of slices in which happens what happens in a share of two cycles."""
    return share if period == 2 else round(1.0 - (1.0 - share) ** (period / 2), 4)


def _coordinate(body: Body, name: str, period: int) -> tuple[Attribute, ...]:
    """A hidden coordinate of the ball, its velocity, and what is seen of both."""
    v, velocity = f"v{name}", speeds(body, (*(-s for s in reversed(_SPEEDS)), *_SPEEDS))
    way = f"{sum(body.ball_decay**k for k in range(period)):.4f}"
    roll = f"{(period / 6) ** 0.5 * body.server.ball_rand:.4f}"
    return (
        Attribute(name, BALL_PLACE, parents=(prev(name), prev(v)), initial=Uniform(),
                  cpd=Noise(f"prev.{name} + {way} * prev.{v}", sd=0.125 * period)),
        Attribute(v, velocity, parents=(prev(v),), initial=Noise("0", sd=0.8),
                  cpd=Noise(f"{_kept(body, period)} * prev.{v}", sd=f"0.03 + {roll} * abs(prev.{v})",
                            floor=_in_slice(TOUCHED, period))),
        Attribute(f"seen_{name}", BALL_PLACE, parents=(name,), cpd=Noise(name, sd=EYE, floor=1e-3)),
        Attribute(f"seen_{v}", velocity, parents=(v,), cpd=Noise(v, sd=f"0.1 + 0.1 * abs({v})", floor=1e-3)),
    )  # fmt: skip


PLAYER = PRMClass(
    "Player",
    abstract=True,
    attributes=(
        Attribute("x", PLAYER_PLACE),
        Attribute("y", PLAYER_PLACE),
        Attribute("seen_x", PLAYER_PLACE, parents=("x",), cpd=Noise("x", sd=EYE, floor=1e-3)),
        Attribute("seen_y", PLAYER_PLACE, parents=("y",), cpd=Noise("y", sd=EYE, floor=1e-3)),
    ),
)  # fmt: skip
"""A player whom he does not attend to: where he is seen, and no memory."""
OPPONENT = PRMClass("Opponent", extends="Player")
TEAMMATE = PRMClass("Teammate", extends="Player")


def _attended(class_name: str, role: str, period: int) -> Relation:
    """Attention: links in time for those who matter now."""
    run = RUN if period == 2 else round(RUN * (period / 2) ** 0.5, 4)
    return Relation(
        f"attended{class_name}",
        roles=((role, class_name),),
        changes=(
            Replace(f"{role}.x", parents=(prev(f"{role}.x"),), cpd=Noise(f"prev.{role}.x", sd=run)),
            Replace(f"{role}.y", parents=(prev(f"{role}.y"),), cpd=Noise(f"prev.{role}.y", sd=run)),
        ),
    )


def _possesses(body: Body, period: int) -> Relation:
    """An opponent who has the ball: it comes towards the own goal, as fast as he runs, or faster if he kicks it."""
    return Relation(
        "possessesOpponent",
        roles=(("o", "Opponent"), ("b", "Ball")),
        attributes=(Attribute("kicks", BOOL, cpd=Chance(f"{_in_slice(0.2, period)}")),),
        changes=(
            Replace("b.vx", parents=(prev("b.vx"), "kicks"), cpd=Switch("kicks", {
                "yes": Noise("-1.5", sd=0.8, floor=0.01),
                "no": Noise(f"min({_kept(body, period)} * prev.b.vx, -0.3)", sd=0.3, floor=0.01),
            })),
            Replace("b.vy", parents=(prev("b.vy"),), cpd=Noise(f"{_kept(body, period)} * prev.b.vy", sd=0.5, floor=0.01)),
        ),
    )  # fmt: skip


@of_body
def outfield_model(body: Body, period: int = PERIOD) -> Model:
    """Ball, players of both teams, and the three relations: attention to the opponent nearest to the ball and to the team-mate to whom it
    would be passed, and possession.

    Along and across the pitch the ball moves apart: two components of place and velocity.

    Parameters
    ----------
    body : Body
    period : int
        Cycles of a slice.
    """
    ball = PRMClass("Ball", attributes=(*_coordinate(body, "x", period), *_coordinate(body, "y", period)))
    relations = (_attended("Opponent", "o", period), _attended("Teammate", "t", period), _possesses(body, period))
    return Model("outfielder", classes=(ball, PLAYER, OPPONENT, TEAMMATE), relations=relations)


if TYPE_CHECKING:
    OUTFIELD_MODEL: Model
    """Of a default player."""

__getattr__ = made_on_use(__name__, {"OUTFIELD_MODEL": outfield_model})
