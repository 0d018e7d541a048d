"""The passing pair (demonstration 3): pass, advance, receive, pass back, and shoot when near (dissertation §4.3, Fig. 4.3).

    on_ball -> passing ---passed---> advance | watch ---ball coming---> (advance aborted) receive ---received---> on_ball
       `-----> shoot  (goal near)
    recovery:  passing.failed, receive.missed, shoot.failed, an unclaimed ball -> go -> on_ball
               go.lost_ball, ball out of sight -> search -> go;   the team-mate nearer to the ball than he who fetches it -> advance

Both players run the same net, each on his own percepts; they say nothing to each other. What the net decides by is believed
(`PASSER_MODEL`): the ball's distance, bearing and motion, tracked through closed eyes, own steps and own kicks, and the place of the
partner. The partner is an object token: while it is held, the player attends to him (relation ``attendedTeammate``), and while
somebody is held to be at the ball he possesses it (``possessesTeammate``), which makes a pass expected before it is seen.

The safe state is having the ball, or else standing in place with the ball in sight. `passer_net(recovering=False)` is the same net
without the recovery transitions: what goes wrong then leaves a token in an error place that nobody takes.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..architecture.cprm import CPRM, Cluster, Observe
from ..architecture.petri import AnyPlace, Belief, Command, Continuous, Input, Math, ObjectPlace, PetriNet, Place, Selection, Transition
from ..architecture.prm.inference.engines.projection import ProjectionEngine
from ..envs.controller import Observation
from ..envs.tasks import Task
from ..errors import ParameterError
from ..lazy import made_on_use
from ..simulator.pitch import HALF_LENGTH
from .attacker import agent as attacker
from .attacker.constants import PairConstants
from .body import DEFAULT, Body, number
from .models import passer_model
from .percepts import NEVER, OFF_PITCH, Percepts, mate_attributes, passer_percepts
from .play import SoccerAgent
from .skills.advance import advance
from .skills.go_to_ball import go_to_ball_reflex
from .skills.pass_ball import pass_ball
from .skills.receive import receive
from .skills.shoot import shoot
from .skills.watch_ball import watch_ball

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
BESIDE = 0.215
"""Metres beyond his reach within which the ball is beside him: while he prepares a pass he looks at the team-mate."""
AT_BALL = 0.515
"""Metres beyond the reach of a leg within which a team-mate has the ball, as far as the eye can tell."""
AT_FEET = 0.915
"""Metres beyond his reach within which he acts on what he sees of the ball in this very cycle."""


def _believed(body: Body) -> tuple[AnyPlace, ...]:
    """What the model believes, the objects that switch its relations, and what follows from both."""
    return (
        Belief("believed_distance", variable="ball.dist"), Belief("believed_bearing", variable="ball.bearing_deg"),
        Belief("rolled", variable="ball.approach"), Belief("swung", variable="ball.swing_deg"),
        Belief("partner_x", variable="partner.x"), Belief("partner_y", variable="partner.y"),
        ObjectPlace("partner", "Teammate", Selection("Teammate", best="teammate.distance", where=f"teammate.age < {NEVER}", minimize=True)),
        ObjectPlace("holder", "Teammate",
                    Selection("Teammate", best="teammate.ball_gap", where=f"teammate.ball_gap < {number(body.reach + AT_BALL)}",
                                                    minimize=True)),
        # at his feet a reading is finer than any bins; everything else is as it is believed to be
        Input("seen", observes="ball.seen"), Input("seen_distance", observes="ball.distance"),
        Input("seen_bearing", observes="ball.bearing_deg"), Input("moving", observes="ball.moving"),
        Input("rolling", observes="ball.rolling"), Input("swinging", observes="ball.swinging_deg"),
        Math("at_feet", f"1 if seen and seen_distance < {number(body.reach + AT_FEET)} else 0"),
        Math("told", "1 if at_feet and moving else 0"),
        Math("ball_distance", "seen_distance if at_feet else believed_distance"),
        Math("ball_bearing", "seen_bearing if at_feet else believed_bearing"),
        Math("approach", f"rolling if told else {number(body.ball_decay)} * rolled"),
        Math("across", f"radians(swinging if told else {number(body.ball_decay)} * swung) * ball_distance"),
        # from there follow the direction from the body, the velocity along the body and to its right, the place on the pitch
        Math("ball_direction", "norm_deg(ball_bearing - facing)"),
        Math("vx", "-approach * cos(radians(ball_direction)) - across * sin(radians(ball_direction))"),
        Math("vy", "across * cos(radians(ball_direction)) - approach * sin(radians(ball_direction))"),
        Math("ball_x", "me_x + ball_distance * cos(radians(ball_bearing))"),
        Math("ball_y", "me_y + ball_distance * sin(radians(ball_bearing))"),
        Math("mate_x", f"partner_x if mate_age < {NEVER} else me_x"), Math("mate_y", f"partner_y if mate_age < {NEVER} else me_y"),
        Math("mate_direction", "norm_deg(degrees(atan2(mate_y - me_y, mate_x - me_x)) - facing) "
             "if hypot(mate_x - me_x, mate_y - me_y) > 0.01 else 0"),
    )  # fmt: skip


def _places(body: Body) -> tuple[AnyPlace, ...]:
    """What he knows, believes and derives from it."""
    return (
        Place("intend", capacity=1, tokens=1),
        *(Place(name, capacity=1) for name in ("on_ball", "in_place", "faced", "taking", "over", "search", "searched")),
        Place("looking", capacity=1, tokens=1),
        Input("me_x", observes="me.x"), Input("me_y", observes="me.y"), Input("facing", observes="me.facing_deg"),
        Input("ball_age", observes="ball.age"), Input("mate_age", observes="mate.age"),
        Input("goal_distance", observes="goal.distance"), Input("speed", observes="body.speed"),
        *_believed(body),
        # whose ball it is: how much nearer to it the team-mate is
        Math("mate_gap", f"hypot(mate_x - ball_x, mate_y - ball_y) if mate_age < {NEVER} else {OFF_PITCH}"),
        Math("mine", "mate_gap - ball_distance"), Math("his", "ball_distance - mate_gap"),
        # metres by which the team-mate is behind the ball; 50 where it does not matter
        Math("onside", "max(ball_x, 0) - mate_x if mate_x > 0 else 50"),
        Math("ball_speed", "hypot(vx, vy)"),
        Math("coming", f"1 if approach > {COMING} and ball_age < 5 else 0"),
        # where the pass goes: ahead of the team-mate and a little inwards
        Math("pass_x", f"min(mate_x + {LEAD}, {HALF_LENGTH - 5.5}) - me_x"), Math("pass_y", "0.8 * mate_y - me_y"),
        Continuous("softly", ARRIVING),
        Math("pass_distance", "max(1, hypot(pass_x, pass_y))"),
        Math("pass_direction", "norm_deg(degrees(atan2(pass_y, pass_x)) - facing) if hypot(pass_x, pass_y) > 0.01 else 0"),
        # where he waits for it: ahead of the ball, but beyond the halfway line behind it, so as never to be offside
        Math("wait_x", f"min(max(ball_x - 3, min(ball_x + 7, -2)), {HALF_LENGTH - 6.5})"),
        Math("wait_y", f"{LANE} if me_y >= mate_y else {-LANE}"),
        Math("off_place", "hypot(wait_x - me_x, wait_y - me_y)"),
        Math("gaze", f"mate_direction if passing.ongoing >= 1 and ball_distance < {number(body.reach + BESIDE)} "
                     "else ball_direction if ball_age < 15 else 0"),
        Math("off_axis", "abs(ball_direction)"),
        Math("search_moment", body.turn("60")),
        Math("face_moment", body.turn("ball_direction")),
    )  # fmt: skip


def _primary() -> tuple[Transition, ...]:
    """What happens when nothing goes wrong."""
    return (
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
        Transition("hold", (), ("advance.abort",), tests=("advance.ongoing", "watch.ball_coming"), inhibitors=("advance.abort",),
                   priority=1),
        Transition("get_ready", ("advance.aborted",), ("receive.begin",)),
        Transition("be_ready", ("in_place",), ("receive.begin",), tests=("watch.ball_coming",)),
        Transition("take", ("receive.received",), ("taking", "watch.stop")),
        Transition("have", ("taking", "watch.stopped"), ("on_ball",)),
        Transition("finish", ("shoot.shot",), ("over",)),
        Transition("look", ("looking",), ("looking",), delay=1, inhibitors=("watch.ongoing",), emits=Command("look", direction="gaze")),
    )  # fmt: skip


def _recovery(body: Body) -> tuple[Transition, ...]:
    """Errors passed up are taken here, and aborts passed down: each path ends in a safe state."""
    return (
        Transition("pass_again", ("passing.failed",), ("search",)),
        Transition("shoot_again", ("shoot.failed",), ("search",)),
        Transition("no_goal", ("over",), ("search",), delay=AFTER_SHOT),
        Transition("not_caught", ("receive.missed",), ("searching", "watch.stop")),
        Transition("unclaimed", ("in_place",), ("searching", "watch.stop"), tests={"mine": 0.0},
                   inhibitors={"ball_speed": 0.3, "ball_age": 4.0}, delay=UNCLAIMED),
        Transition("unclaimed_on_the_way", (), ("advance.abort", "fetching"), tests={"advance.ongoing": 1, "mine": 0.0},
                   inhibitors={"ball_speed": 0.3, "ball_age": 4.0, "advance.abort": 1, "fetching": 1, "watch.ball_coming": 1},
                   delay=UNCLAIMED),
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
        Transition("rolled_away", ("on_ball",), ("search",), tests={"ball_distance": round(body.reach + AT_FEET, 6)}),
        Transition("yielded", ("go.aborted",), ("search",)),
    )  # fmt: skip


def passer_net(recovering: bool = True, body: Body = DEFAULT) -> PetriNet:
    """The high level of a passer, with or without its recovery parts."""
    extra: tuple[AnyPlace, ...] = (Place("searching", capacity=1), Place("fetching", capacity=1)) if recovering else ()
    return PetriNet(
        "passer" if recovering else "passer_without_recovery",
        places=(*_places(body), *extra),
        modules={"passing": pass_ball(body), "advance": advance(body), "watch": watch_ball(body), "receive": receive(body),
                 "go": go_to_ball_reflex(body), "shoot": shoot(body)},
        fuse={"advance.place_x": "wait_x", "advance.place_y": "wait_y", "passing.target_distance": "pass_distance",
              "passing.target_direction": "pass_direction", "passing.arriving": "softly", "passing.mate_age": "mate_age",
              "watch.ball_direction": "ball_direction", "watch.coming": "coming", "receive.approach": "approach",
              "go.believed_distance": "ball_distance", "go.believed_direction": "ball_direction",
              "shoot.speed_ahead": "vx", "shoot.speed_aside": "vy",
              **{f"{skill}.{name}": f"ball_{name}" for skill in ("passing", "receive", "shoot") for name in ("distance", "direction")},
              **{f"{skill}.{name}": name for skill in ("passing", "receive") for name in ("vx", "vy")}},
        transitions=_primary() + (_recovery(body) if recovering else ()),
    )  # fmt: skip


PASSER_NET = passer_net()
"""With its recovery parts."""

CLUSTERS = (("ball.dist", "ball.approach"), ("ball.bearing_deg", "ball.swing_deg"))
"""What a possession has linked stays linked within the ball only: its belief is projected on these pairs."""
_KICKS = ("passing.kick", "passing.trap", "shoot.kick")


@functools.lru_cache(maxsize=64)
def passer_cprm(recovering: bool = True, mates: int = 1, body: Body = DEFAULT) -> CPRM:
    """The passer's net, his beliefs, and the links between them.

    Parameters
    ----------
    recovering : bool
    mates : int
        How many team-mates there are.
    body : Body
    """
    names = [f"m{k}" for k in range(1, mates + 1)]
    # what the net has just kicked, the model sees in the places of the kick; a ball that hit the body is as good as stopped
    sent, further, deflected = "0.001 if body.hit_ball >= 1 else -1", "0", "0"
    for kick in _KICKS:
        sent = f"max({kick}.leaves, 0.001) if {kick}.acted >= 1 else ({sent})"
        further = f"{kick}.sends - {kick}.leaves if {kick}.acted >= 1 else ({further})"
        deflected = f"{kick}.deflects if {kick}.acted >= 1 else ({deflected})"
    return CPRM(
        "passer" if recovering else "passer_without_recovery",
        net=passer_net(recovering, body),
        model=passer_model(body),
        objects={"ball": "Ball", **dict.fromkeys(names, "Teammate")},
        observations=(
            Observe("ball.met", f"me.met - ({further})", when="me.located"),
            Observe("ball.slid_deg", f"me.slid_deg - ({deflected})", when="me.located"),
            Observe("ball.eyes_deg", "me.eyes_deg", when="me.located"),
            Observe("ball.sent", sent),
            Observe("ball.seen_dist", "ball.distance", when="ball.seen"),
            Observe("ball.seen_bearing_deg", "ball.bearing_deg", when="ball.placed"),
            Observe("ball.seen_approach", "ball.rolling", when="ball.moving"),
            Observe("ball.seen_swing_deg", "ball.swinging_deg", when="ball.moving"),
            # within this distance it is felt, wherever he looks
            Observe("ball.seen", "ball.seen", when=f"body.fresh >= 1 and believed_distance > {body.server.visible_distance + 1.0}"),
            *(
                Observe(f"{m}.seen_{percept}", f"{m}.{percept}", when=f"{m}.{given}")
                for m in names
                for percept, given in (("x", "seen"), ("y", "seen"), ("facing", "faced"))
            ),
        ),
        clusters=(Cluster("attendedTeammate", ("partner",)), Cluster("possessesTeammate", ("holder", "=ball"))),
    )


class PasserAgent(SoccerAgent):
    """One of the pair as a controller.

    Parameters
    ----------
    recovering : bool
    mates : int
        How many team-mates he has.
    body : Body
    """

    def __init__(self, recovering: bool = True, mates: int = 1, body: Body = DEFAULT, **options: Any) -> None:
        cprm = passer_cprm(recovering, mates, body)

        def percepts(observation: Observation) -> Percepts:
            return passer_percepts(observation, body, mates)

        def objects(observation: Observation) -> Mapping[str, Mapping[str, np.ndarray]]:
            return {"Teammate": mate_attributes(observation, mates)}

        super().__init__(cprm, percepts, needs=("memory",), objects=objects, body=body, **{"engine": ProjectionEngine(CLUSTERS), **options})


def make_controller(task: Task, agent: str, recovering: bool = True, **options: Any) -> SoccerAgent:
    """One of the pair as a controller; against opponents an attacker who decides anew with every kick (`attacker`).

    Options are those of `CPRMRunner`.

    Raises
    ------
    ParameterError
        For options of the attacker, who has no model.
    """
    if task.right if agent.startswith("left") else task.left:
        if options:
            raise ParameterError(f"the agent of {task.name} has no model: there is no option {next(iter(options))!r}")
        return attacker.make_controller(task, agent, PairConstants())
    return PasserAgent(recovering, (task.left if agent.startswith("left") else task.right) - 1, Body.of(task), **options)


if TYPE_CHECKING:
    PASSER: CPRM
    """One of the pair."""
    PASSER_WITHOUT_RECOVERY: CPRM
    """For comparison."""

__getattr__ = made_on_use(__name__, {"PASSER": passer_cprm, "PASSER_WITHOUT_RECOVERY": lambda: passer_cprm(recovering=False)})
