"""The baselines of chapter 5 that our architecture contains, for soccer: a state machine and a belief-region policy that go to the ball.

`GO_TO_BALL_MACHINE` is the table of `cprm_baselines.fsm.go_to_ball`, `GO_TO_BALL_REGIONS` a policy over the belief of the seeker. What they
become as nets and CPRMs is in `cprm_gym.architecture.equivalences`.
"""

from __future__ import annotations

from ...architecture.equivalences import Region, RegionPolicy, Rule, StateMachine
from ...architecture.petri import Belief, Command
from ..body import Body, of_body
from ..models import ball_model
from ..seeker import seeker_cprm
from ..skills.go_to_ball import CLOSE, TIRED

_LOOK = Command("turn", moment="look_moment")
_TURN = Command("turn", moment="moment")
_DASH = Command("dash", power="power", direction=0.0)


def _sighted(state: str) -> tuple[Rule, ...]:
    """What every state does when it sees the ball."""
    return Rule(state, "run", "seen > 0 and off_axis <= 12", _DASH), Rule(state, "turn", "seen > 0", _TURN)


@of_body
def go_to_ball_machine(body: Body) -> StateMachine:
    """LOOK, TURN and RUN; a state for each look that missed the ball, since a state machine has nothing else to remember it in (§5.3.1)."""
    return StateMachine(
        "go_to_ball_machine",
        states=("look", "turn", "turn_missed", "run", "run_missed"),
        percepts={
            "seen": "ball.seen", "fresh": "body.fresh", "bearing": "ball.direction_deg", "speed": "body.speed", "stamina": "body.stamina",
        },
        quantities={
            "off_axis": "abs(bearing)",
            "moment": body.turn("0.9 * bearing"),
            "look_moment": body.turn("100"),
            "power": f"{body.dash(1.0)} if stamina > {body.stamina(TIRED)} else {body.dash(0.6)}",
        },
        rules=(
            *_sighted("look"), Rule("look", "look", "fresh > 0", _LOOK), Rule("look", "look"),
            *_sighted("turn"), Rule("turn", "turn_missed", "fresh > 0"), Rule("turn", "turn"),
            *_sighted("turn_missed"), Rule("turn_missed", "look", "fresh > 0", _LOOK), Rule("turn_missed", "turn_missed"),
            *_sighted("run"), Rule("run", "run_missed", "fresh > 0", _DASH), Rule("run", "run", "", _DASH),
            *_sighted("run_missed"), Rule("run_missed", "look", "fresh > 0", _LOOK), Rule("run_missed", "run_missed", "", _DASH),
        ),
    )  # fmt: skip


GO_TO_BALL_MACHINE = go_to_ball_machine()
"""Of a default player."""


@of_body
def go_to_ball_regions(body: Body) -> RegionPolicy:
    """Where the belief is vague, turn; where the ball is believed aside, face it; where it is believed ahead, run."""
    return RegionPolicy(
        "go_to_ball_regions",
        model=ball_model(body),
        objects={"ball": "Ball"},
        observations=seeker_cprm(body).observations,
        views=(
            Belief("distance", variable="ball.dist"), Belief("bearing", variable="ball.dir_deg"),
            Belief("doubt", variable="ball.dir_deg", view="entropy"),
        ),
        quantities={"moment": f"clip(0.9 * bearing, {body.moments})",
                    "power": f"clip({body.hold(0.4)} + {body.hold(0.12)} * distance, {body.dash(0.3)}, {body.dash(1.0)})"},
        regions=(
            Region("search", "doubt >= 1.5", Command("turn", moment=90.0)),
            Region("face", "doubt < 1.5 and abs(bearing) >= 12", Command("turn", moment="moment")),
            Region("run", f"doubt < 1.5 and abs(bearing) < 12 and distance >= {body.within(CLOSE)}",
                   Command("dash", power="power", direction=0.0)),
        ),
    )  # fmt: skip


GO_TO_BALL_REGIONS = go_to_ball_regions()
"""Of a default player."""
