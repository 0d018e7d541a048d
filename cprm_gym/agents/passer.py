"""The passing pair (demonstration 3): pass, advance, receive, pass back, and shoot when near (dissertation §4.3, Fig. 4.3).

    on_ball -> passing ---passed---> advance | watch ---ball coming---> (advance aborted) receive ---received---> on_ball
       `-----> shoot  (goal near)
    recovery:  passing.failed, receive.missed, shoot.failed, an unclaimed ball -> go -> on_ball
               go.lost_ball, ball out of sight -> search -> go;   the team-mate nearer to the ball than he who fetches it -> advance

Both players run the same net, each on his own percepts; they say nothing to each other. The safe state is having the ball, or else
standing in place with the ball in sight. `passer_net(recovering=False)` is the same net without the recovery transitions: what goes
wrong then leaves a token in an error place that nobody takes.
"""

from __future__ import annotations

from ..architecture.cprm import CPRM
from ..architecture.petri import AnyPlace, Command, Continuous, Input, Math, PetriNet, Place, Transition
from ..envs.tasks import Task
from .percepts import field_percepts
from .play import SoccerAgent
from .skills.advance import ADVANCE
from .skills.go_to_ball import GO_TO_BALL_REFLEX
from .skills.pass_ball import PASS_BALL
from .skills.receive import RECEIVE
from .skills.shoot import SHOOT
from .skills.watch_ball import WATCH_BALL

IN_RANGE = 20.0
"""Metres from the goal at which he shoots."""
LEAD = 6.0
"""Metres that a pass goes ahead of the team-mate."""
ARRIVING = 0.6
"""m / cycle that a pass should have left when it arrives."""
LANE = 5.5
"""Metres from the middle at which each runs forward on his side."""
ONSIDE = 0.5
"""Metres by which the team-mate must be behind the ball for a pass, beyond the halfway line."""
PATIENCE = 40
"""Cycles for which he waits for that."""
COMING = 0.35
"""m / cycle at which a ball that comes nearer counts as coming."""
FORGOTTEN = 6.0
"""Cycles without a sight of the ball after which it is looked for."""
UNCLAIMED = 12
"""Cycles for which the ball lies still, nearer to him than to the team-mate, before he fetches it."""
YIELD = 10
"""Cycles for which the team-mate is clearly nearer before he leaves the ball to him."""
AFTER_SHOT = 30
"""Cycles after a shot in which the goal is expected."""

_PLACES: tuple[AnyPlace, ...] = (
    Place("intend", capacity=1, tokens=1),
    *(Place(name, capacity=1) for name in ("on_ball", "in_place", "faced", "taking", "over", "search", "searched")),
    Place("looking", capacity=1, tokens=1),
    Input("me_x", observes="me.x"), Input("me_y", observes="me.y"), Input("facing", observes="me.facing"),
    Input("ball_x", observes="ball.x"), Input("ball_y", observes="ball.y"), Input("ball_age", observes="ball.age"),
    Input("ball_distance", observes="ball.reckoned_distance"), Input("ball_direction", observes="ball.reckoned_direction"),
    Input("approach", observes="ball.approach"), Input("vx", observes="ball.speed_ahead"), Input("vy", observes="ball.speed_aside"),
    Input("mate_x", observes="mate.x"), Input("mate_y", observes="mate.y"), Input("mate_direction", observes="mate.direction"),
    Input("goal_distance", observes="goal.distance"), Input("speed", observes="body.speed"),
    # whose ball it is: how much nearer to it the team-mate is
    Math("mate_gap", "hypot(mate_x - ball_x, mate_y - ball_y)"),
    Math("mine", "mate_gap - ball_distance"), Math("his", "ball_distance - mate_gap"),
    # metres by which the team-mate is behind the ball; 50 where it does not matter
    Math("onside", "max(ball_x, 0) - mate_x if mate_x > 0 else 50"),
    Math("ball_speed", "hypot(vx, vy)"),
    Math("coming", f"1 if approach > {COMING} and ball_age < 5 else 0"),
    # where the pass goes: ahead of the team-mate and a little inwards
    Math("pass_x", f"min(mate_x + {LEAD}, 47) - me_x"), Math("pass_y", "0.8 * mate_y - me_y"),
    Continuous("softly", ARRIVING),
    Math("pass_distance", "max(1, hypot(pass_x, pass_y))"),
    Math("pass_direction", "norm_deg(degrees(atan2(pass_y, pass_x)) - facing) if hypot(pass_x, pass_y) > 0.01 else 0"),
    # where he waits for it: ahead of the ball, but beyond the halfway line behind it, so as never to be offside
    Math("wait_x", "min(max(ball_x - 3, min(ball_x + 7, -2)), 46)"), Math("wait_y", f"{LANE} if me_y >= mate_y else {-LANE}"),
    Math("off_place", "hypot(wait_x - me_x, wait_y - me_y)"),
    Math("gaze", "mate_direction if passing.ongoing >= 1 and ball_distance < 1.3 else ball_direction if ball_age < 15 else 0"),
    Math("off_axis", "abs(ball_direction)"),
    Math("search_moment", "clip(60 * (1 + 5 * speed), -180, 180)"),
    Math("face_moment", "clip(ball_direction * (1 + 5 * speed), -180, 180)"),
)  # fmt: skip

_PRIMARY = (
    Transition("mine_first", ("intend",), ("go.begin",), tests={"mine": 0.0}, delay=4),
    Transition("his_first", ("intend",), ("advance.begin", "watch.begin"), inhibitors={"mine": 0.0}, delay=4),
    Transition("arrive", ("go.at_ball",), ("on_ball",)),
    Transition("try_goal", ("on_ball",), ("shoot.begin",), inhibitors={"goal_distance": IN_RANGE}),
    Transition("play_on", ("on_ball",), ("passing.begin",), tests={"goal_distance": IN_RANGE, "onside": ONSIDE}),
    Transition("play_anyway", ("on_ball",), ("passing.begin",), delay=PATIENCE),
    Transition("go_on", ("passing.passed",), ("advance.begin", "watch.begin")),
    Transition("stand", ("advance.arrived",), ("in_place",)),
    Transition("move_up", ("in_place",), ("advance.begin",), tests={"off_place": 1.8}, delay=1),
    Transition("face", ("in_place",), ("faced",), tests={"off_axis": 60.0}, inhibitors={"off_place": 1.8},
               emits=Command("turn", moment="face_moment"), priority=-1),
    Transition("faced_it", ("faced",), ("in_place",), delay=1),
    Transition("hold", (), ("advance.abort",), tests=("advance.ongoing", "watch.ball_coming"), inhibitors=("advance.abort",), priority=1),
    Transition("get_ready", ("advance.aborted",), ("receive.begin",)),
    Transition("be_ready", ("in_place",), ("receive.begin",), tests=("watch.ball_coming",)),
    Transition("take", ("receive.received",), ("taking", "watch.stop")),
    Transition("have", ("taking", "watch.stopped"), ("on_ball",)),
    Transition("finish", ("shoot.shot",), ("over",)),
    Transition("look", ("looking",), ("looking",), delay=1, inhibitors=("watch.ongoing",), emits=Command("look", direction="gaze")),
)  # fmt: skip
"""What happens when nothing goes wrong."""

_RECOVERY = (
    Transition("pass_again", ("passing.failed",), ("search",)),
    Transition("shoot_again", ("shoot.failed",), ("search",)),
    Transition("no_goal", ("over",), ("search",), delay=AFTER_SHOT),
    Transition("not_caught", ("receive.missed",), ("searching", "watch.stop")),
    Transition("unclaimed", ("in_place",), ("searching", "watch.stop"), tests={"mine": 0.0},
               inhibitors={"ball_speed": 0.3, "ball_age": 4.0}, delay=UNCLAIMED),
    Transition("unclaimed_on_the_way", (), ("advance.abort", "fetching"), tests={"advance.ongoing": 1, "mine": 0.0},
               inhibitors={"ball_speed": 0.3, "ball_age": 4.0, "advance.abort": 1, "fetching": 1, "watch.ball_coming": 1}, delay=UNCLAIMED),
    Transition("fetch_now", ("fetching", "advance.aborted"), ("searching", "watch.stop"), priority=2),
    Transition("fetch_at_place", ("fetching", "advance.arrived"), ("searching", "watch.stop"), priority=2),
    Transition("blind_in_place", ("in_place",), ("searching", "watch.stop"), tests={"ball_age": 2 * FORGOTTEN}),
    Transition("eyes_free", ("searching", "watch.stopped"), ("search",)),
    Transition("sweep", ("search",), ("searched",), tests={"ball_age": FORGOTTEN}, emits=Command("turn", moment="search_moment")),
    Transition("turn_round", ("search",), ("searched",), tests={"off_axis": 60.0}, inhibitors={"ball_age": FORGOTTEN},
               emits=Command("turn", moment="face_moment")),
    Transition("look_again", ("searched",), ("search",), delay=1),
    Transition("fetch", ("search",), ("go.begin",), tests={"mine": 0.0}, inhibitors={"ball_age": FORGOTTEN, "off_axis": 60.0}),
    Transition("leave_it", ("search",), ("advance.begin", "watch.begin"),
               inhibitors={"ball_age": FORGOTTEN, "off_axis": 60.0, "mine": 0.0}),
    Transition("lost", ("go.lost_ball",), ("search",)),
    Transition("yield", (), ("go.abort",), tests={"go.ongoing": 1, "his": 3.0}, inhibitors=("go.abort",), delay=YIELD),
    Transition("after_you", ("on_ball",), ("search",), tests={"his": 0.3}, delay=3),
    Transition("rolled_away", ("on_ball",), ("search",), tests={"ball_distance": 2.0}),
    Transition("yielded", ("go.aborted",), ("search",)),
)  # fmt: skip
"""Errors passed up are taken here, and aborts passed down: each path ends in a safe state."""


def passer_net(recovering: bool = True) -> PetriNet:
    """The high level of a passer, with or without its recovery parts."""
    extra: tuple[AnyPlace, ...] = (Place("searching", capacity=1), Place("fetching", capacity=1)) if recovering else ()
    return PetriNet(
        "passer" if recovering else "passer_without_recovery",
        places=(*_PLACES, *extra),
        modules={"passing": PASS_BALL, "advance": ADVANCE, "watch": WATCH_BALL, "receive": RECEIVE, "go": GO_TO_BALL_REFLEX,
                 "shoot": SHOOT},
        fuse={"advance.place_x": "wait_x", "advance.place_y": "wait_y", "passing.target_distance": "pass_distance",
              "passing.target_direction": "pass_direction", "passing.arriving": "softly", "watch.ball_direction": "ball_direction",
              "watch.coming": "coming"},
        transitions=_PRIMARY + (_RECOVERY if recovering else ()),
    )  # fmt: skip


PASSER_NET = passer_net()
"""With its recovery parts."""
PASSER = CPRM("passer", net=PASSER_NET)
"""One of the pair."""
PASSER_WITHOUT_RECOVERY = CPRM("passer_without_recovery", net=passer_net(recovering=False))
"""For comparison."""


def make_controller(task: Task, agent: str, recovering: bool = True) -> SoccerAgent:
    """One of the pair as a controller."""
    return SoccerAgent(PASSER if recovering else PASSER_WITHOUT_RECOVERY, field_percepts, needs=("memory",))
