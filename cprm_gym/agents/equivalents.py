"""The baselines of chapter 5 that our architecture contains, for soccer: a state machine and a belief-region policy that go to the ball.

`GO_TO_BALL_MACHINE` is the table of `cprm_baselines.fsm`, `GO_TO_BALL_REGIONS` a policy over the belief of the seeker. What they
become as nets and CPRMs is in `cprm_gym.architecture.equivalences`.
"""

from __future__ import annotations

from ..architecture.equivalences import Region, RegionPolicy, Rule, StateMachine
from ..architecture.petri import Belief, Command
from .models import BALL_MODEL
from .seeker import SEEKER

_LOOK = Command("turn", moment="look_moment")
_TURN = Command("turn", moment="moment")
_DASH = Command("dash", power="power", direction=0.0)


def _sighted(state: str) -> tuple[Rule, ...]:
    """What every state does when it sees the ball."""
    return Rule(state, "run", "seen > 0 and off_axis <= 12", _DASH), Rule(state, "turn", "seen > 0", _TURN)


GO_TO_BALL_MACHINE = StateMachine(
    "go_to_ball_machine",
    states=("look", "turn", "turn_missed", "run", "run_missed"),
    percepts={
        "seen": "ball.seen", "fresh": "body.fresh", "bearing": "ball.direction_deg", "speed": "body.speed", "stamina": "body.stamina",
    },
    quantities={
        "off_axis": "abs(bearing)",
        "moment": "clip(0.9 * bearing * (1 + 5 * speed), -180, 180)",
        "look_moment": "clip(100 * (1 + 5 * speed), -180, 180)",
        "power": "100 if stamina > 3000 else 60",
    },
    rules=(
        *_sighted("look"), Rule("look", "look", "fresh > 0", _LOOK), Rule("look", "look"),
        *_sighted("turn"), Rule("turn", "turn_missed", "fresh > 0"), Rule("turn", "turn"),
        *_sighted("turn_missed"), Rule("turn_missed", "look", "fresh > 0", _LOOK), Rule("turn_missed", "turn_missed"),
        *_sighted("run"), Rule("run", "run_missed", "fresh > 0", _DASH), Rule("run", "run", "", _DASH),
        *_sighted("run_missed"), Rule("run_missed", "look", "fresh > 0", _LOOK), Rule("run_missed", "run_missed", "", _DASH),
    ),
)  # fmt: skip
"""LOOK, TURN and RUN; a state for each look that missed the ball, since a state machine has nothing else to remember it in (§5.3.1)."""

GO_TO_BALL_REGIONS = RegionPolicy(
    "go_to_ball_regions",
    model=BALL_MODEL,
    objects={"ball": "Ball"},
    observations=SEEKER.observations,
    views=(
        Belief("distance", variable="ball.dist"), Belief("bearing", variable="ball.dir_deg"),
        Belief("doubt", variable="ball.dir_deg", view="entropy"),
    ),
    quantities={"moment": "clip(0.9 * bearing, -180, 180)", "power": "clip(40 + 12 * distance, 30, 100)"},
    regions=(
        Region("search", "doubt >= 1.5", Command("turn", moment=90.0)),
        Region("face", "doubt < 1.5 and abs(bearing) >= 12", Command("turn", moment="moment")),
        Region("run", "doubt < 1.5 and abs(bearing) < 12 and distance >= 0.95", Command("dash", power="power", direction=0.0)),
    ),
)  # fmt: skip
"""Where the belief is vague, turn; where the ball is believed aside, face it; where it is believed ahead, run."""
