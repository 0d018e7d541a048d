"""The attacker: a player of two or more who attack against opponents (demonstrations 1 and 3 with a defence).

    decide --(before the kick-off)--> setup           decide --(ball out of sight, or before a set play the team-mate)--> look round
    decide --(he is first at the ball)--> meet (intercept) --> with_ball
    decide --(else)--> walk to where a pass can be taken, or turn to the ball
    with_ball --> shoot | give (a pass) | push (drives the ball) --> decide
    with_ball --(own set play)--> give --> hands_off --(somebody else was at the ball)--> decide
    beside it: the neck; and the count of passes, a change of who has the ball

Purely reflexive: what he knows of the pitch comes from the tier of knowledge. Each kick is decided anew: the push that gains most for the
room it keeps (a way past an opponent, or away from him, is one of them), the pass that does, into the run of the team-mate or to his feet,
and the point of the goal with the most room (`kernels`).
"""

from __future__ import annotations

import functools

import numpy as np

from ...architecture.cprm import CPRM
from ...architecture.petri import AnyPlace, Command, Continuous, Input, Math, PetriNet, Place, Transition
from ...envs.controller import Observation
from ...envs.tasks import Task
from ...simulator.state import ViewWidth
from ..body import DEFAULT, Body, number
from ..play import SoccerAgent
from ..skills.advance import advance
from ..skills.intercept import intercept
from ..skills.kick import SURE, kick
from ..skills.setup import setup
from .constants import AttackerConstants
from .percepts import AIM, PITCH, Ground, Motion, attacker_percepts, terms

LOST = 8
"""Cycles without a sight of the ball after which he looks round."""
MATE_SEEN = 10
"""Cycles without a sight of the team-mate after which he looks round for him before a set play: he may have been placed elsewhere."""
NARROW, NORMAL = int(ViewWidth.NARROW), int(ViewWidth.NORMAL)
OFF_PLACE = 2.0
"""Metres off his place at which he goes there."""
OFF_AXIS = 50.0
"""Degrees off the ball at which he turns to it."""

SOFTLY = 1.1
"""m / cycle with which a set play arrives."""
HARD = 1.5
"""m / cycle that a shot must have."""

WAIT, SEARCH, HAVE, MEET, WALK, FACE = 6, 5, 4, 3, 2, 1
"""What to do now: values of the place ``plan``."""
SET_PLAY, SHOT, PASS, PUSH = 4, 3, 2, 1
"""What to do with the ball: values of the place ``option``."""

_INPUTS = {
    "me_x": "me.x", "me_y": "me.y", "facing": "me.facing_deg", "speed": "body.speed", "ball_age": "ball.age",
    "ball_distance": "ball.reckoned_distance", "ball_direction": "ball.reckoned_direction_deg", "me_time": "me.time",
    "mate_time": "mate.time", "mate_gap": "mate.ball_gap", "mate_age": "mate.age", "mate_distance": "mate.distance",
    "mate_direction": "mate.direction_deg", "theirs": "rival.has_ball", "support_x": "support.x", "support_y": "support.y",
    "shot_distance": "goal.distance", "shot_direction": "goal.direction_deg", "shot_room": "shot.room", "shot_speed": "shot.speed",
    "way_distance": "way.distance", "way_direction": "way.direction_deg", "way_speed": "way.speed", "way_worth": "way.worth",
    "way_room": "way.room",
    "pass_distance": "pass.distance", "pass_direction": "pass.direction_deg", "pass_speed": "pass.speed", "pass_room": "pass.room",
    "pass_worth": "pass.worth", "line": "line.x", "gaze": "gaze.direction_deg", "narrow": "gaze.narrow", "approach": "ball.approach",
    "waiting": "game.waiting", "playing": "game.playing", "ours": "game.ours",
}  # fmt: skip


def _decisions(body: Body, c: AttackerConstants, passes: int) -> tuple[AnyPlace, ...]:
    """What he derives from what he knows, and decides by."""
    return (
        # before a set play of his own the ball lies where it was last seen
        Math("lost", f"1 if ball_age > {LOST} and not ours else 0"),
        Math("may", "1 if playing or ours else 0"),
        Math("reach", f"1 if ball_distance < {body.within(SURE)} and (ours or ball_age < {number(c.trust)}) and may else 0"),
        Math("seeks", f"1 if ours and reach and mate_age > {MATE_SEEN} else 0"),
        Math("eyes", "0 if seeks or lost else gaze"),
        Math("cone", f"{NARROW} if narrow and not seeks and not lost else {NORMAL}"),
        Math("beyond", "1 if me_x > max(line, 0) + 0.2 else 0"),
        Math("chase", f"1 if may and not lost and not offside and me_time <= mate_time + {number(c.yielding)} else 0"),
        Math("off_place", "hypot(support_x - me_x, support_y - me_y)"),
        Math("off_axis", "abs(ball_direction)"),
        Math("off_ball", f"{WALK} if off_place >= {OFF_PLACE} else {FACE} if off_axis >= {OFF_AXIS} else 0"),
        Math("plan", f"{WAIT} if waiting else {SEARCH} if lost or seeks else {HAVE} if reach and not offside else "
                     f"{MEET} if chase else off_ball"),
        # with the ball
        Math("enough", f"1 if swaps + his >= {passes} else 0" if passes else "1"),
        Math("kicking", "1 if push.ongoing + give.ongoing >= 1 else 0"),
        Math("can_shoot", f"1 if enough and shot_speed > {number(HARD)} and (shot_distance < {number(c.shot_near)} or "
                          f"(shot_distance < {number(c.shot_far)} and "
                          f"(shot_room > {number(c.shot_room)} or (way_room < 0 and shot_room > {number(c.pressed)})))) else 0"),
        Math("can_pass", f"1 if pass_worth > -1000 and ((not enough and pass_room > {number(c.first)}) or "
                         f"pass_worth > way_worth + {number(c.bias)}) else 0"),
        Math("option", f"0 if not may else {SET_PLAY} if ours else {SHOT} if can_shoot else {PASS} if can_pass else {PUSH}"),
        Continuous("hard", body.server.ball_speed_max),
        # a kick's speed is that at its end and what it loses on the way
        Math("push_arriving", f"way_speed - {number(AIM * body.roll)}"),
        Math("give_arriving", f"{SOFTLY} if ours else pass_speed - {number(AIM * body.roll)}"),
        Math("give_distance", "mate_distance if ours else pass_distance"),
        Math("give_direction", "mate_direction if ours else pass_direction"),
        Math("mates", f"1 if mate_gap < {number(body.within(SURE) + c.tolerance)} and mate_age < 6 and ball_age < 6 and not reach else 0"),
        Math("his_ball", f"1 if mate_gap < {CLOSE} and mate_time < me_time and mate_age < {OFFSIDE_AGE} and not reach else 0"),
        Math("his_feet", f"1 if his_ball and mate_gap < {number(body.within(SURE) + c.tolerance)} else 0"),
        Math("released", "1 if mate_gap < 2 or approach > 0.2 else 0"),
        Math("search_moment", body.turn("60")),
        Math("face_moment", body.turn("ball_direction")),
    )  # fmt: skip


def _transitions(passes: int) -> tuple[Transition, ...]:
    return (
        Transition("wait", ("decide",), ("setup.begin",), tests={"plan": WAIT}),
        Transition("sweep", ("decide",), ("acted",), tests={"plan": SEARCH}, inhibitors={"plan": WAIT},
                   emits=Command("turn", moment="search_moment")),
        Transition("have", ("decide",), ("with_ball",), tests={"plan": HAVE}, inhibitors={"plan": SEARCH}),
        Transition("run_to_it", ("decide",), ("meet.begin",), tests={"plan": MEET}, inhibitors={"plan": HAVE}),
        Transition("support", ("decide",), ("walk.begin",), tests={"plan": WALK}, inhibitors={"plan": MEET}),
        Transition("face", ("decide",), ("acted",), tests={"plan": FACE}, inhibitors={"plan": WALK},
                   emits=Command("turn", moment="face_moment")),
        Transition("rest", ("decide",), ("acted",), inhibitors={"plan": FACE}),
        Transition("on", ("acted",), ("decide",), delay=1),
        # with the ball
        Transition("take_it", ("with_ball",), ("taking", "give.begin"), tests={"option": SET_PLAY}),
        Transition("shoot_it", ("with_ball",), ("shoot.begin",), tests={"option": SHOT}, inhibitors={"option": SET_PLAY}),
        Transition("pass_it", ("with_ball",), ("give.begin",), tests={"option": PASS}, inhibitors={"option": SHOT}),
        Transition("push_it", ("with_ball",), ("push.begin",), tests={"option": PUSH}, inhibitors={"option": PASS}),
        Transition("let_be", ("with_ball",), ("acted",), inhibitors={"option": PUSH}),
        # after a set play of his own somebody else must touch the ball next
        Transition("hands_on", ("hands_off",), ("acted",), tests={"released": 1}),
        Transition("forget_it", ("hands_off",), ("acted",), delay=PATIENCE),
        # aborts passed down: something else is to be done
        Transition("leave_walk", (), ("walk.abort",), tests={"walk.ongoing": 1, "plan": MEET}, inhibitors=("walk.abort", "walk.begin"),
                   priority=7),
        Transition("leave_meet", (), ("meet.abort",), tests={"meet.ongoing": 1},
                   inhibitors={"meet.abort": 1, "meet.begin": 1, "plan": MEET}, priority=7),
        Transition("have_it", (), ("meet.abort",), tests={"meet.ongoing": 1, "plan": HAVE},
                   inhibitors={"meet.abort": 1, "meet.begin": 1, "meet.at_ball": 1, "plan": SEARCH}, priority=7),
        Transition("look_for_it", (), ("meet.abort",), tests={"meet.ongoing": 1, "plan": SEARCH},
                   inhibitors={"meet.abort": 1, "meet.begin": 1}, priority=7),
        # the neck
        Transition("look", ("looking",), ("looking",), delay=1, emits=Command("look", direction="eyes")),
        Transition("narrow_or_widen", ("viewing",), ("viewing",), delay=1, emits=Command("change_view", width="cone")),
        *_possession(passes),
    )  # fmt: skip


CLOSE, OFFSIDE_AGE = 2.5, 12
"""Metres from the ball, and cycles since he was seen, within which the team-mate is taken to have it where offside is judged."""
PLAYED = 2
"""Cycles that an opponent must have had the ball to have played it."""
PATIENCE = 60
"""Cycles after which a set play is taken to be over."""


def _possession(passes: int) -> tuple[Transition, ...]:
    """Who of the team kicked last, how often that has changed, and whether he himself was offside when the other one did."""
    swap = ("swaps",) if passes else ()
    free = ("theirs",)
    return (
        Transition("mine_first", ("nobodys",), ("mine",), tests={"kicking": 1}, inhibitors=free, priority=9),
        Transition("his_first", ("nobodys",), ("his",), tests={"mates": 1}, inhibitors=("kicking", *free), priority=9),
        Transition("to_him", ("mine",), ("his", *swap), tests={"mates": 1}, inhibitors=("kicking", *free), priority=9),
        Transition("to_me", ("his",), ("mine", *swap), tests={"kicking": 1}, inhibitors=free, priority=9),
        # an opponent at the ball kicks it too
        Transition("taken_from_me", ("mine",), ("nobodys",), tests={"theirs": 1}, priority=9),
        Transition("taken_from_him", ("his",), ("nobodys",), tests={"theirs": 1}, priority=9),
        Transition("be_offside", (), ("offside",), tests={"his_ball": 1, "beyond": 1}, inhibitors=("offside",), priority=9),
        # judged when the team-mate plays the ball: one that he has just pushed draws the line with it
        Transition("be_onside", ("offside",), (), tests={"his_feet": 1}, inhibitors={"beyond": 1}, priority=9),
        # an opponent whom the ball passes, or who is beside the team-mate, may not have played it
        Transition("put_onside", ("offside",), (), tests={"theirs": 1}, inhibitors={"his_ball": 1}, delay=PLAYED, priority=9),
    )


def _ends(module: str, outcomes: tuple[str, ...], then: str) -> tuple[Transition, ...]:
    """The outcomes of a module lead on to `then`, once it has no interrupt left that came too late."""
    late = (f"{module}.abort",) if module in ("walk", "meet") else ()
    return tuple(Transition(f"{module}_{outcome}", (f"{module}.{outcome}",), (then,), inhibitors=late) for outcome in outcomes)


_OUTCOMES = (
    *_ends("meet", ("at_ball",), "with_ball"), *_ends("meet", ("aborted",), "decide"),
    *_ends("walk", ("aborted",), "decide"), *_ends("walk", ("arrived",), "acted"), *_ends("setup", ("set", "aborted"), "acted"),
    *_ends("shoot", ("kicked", "failed", "aborted"), "decide"), *_ends("push", ("kicked", "failed", "aborted"), "decide"),
    Transition("taken", ("taking", "give.kicked"), ("hands_off",), priority=1),
    Transition("not_taken", ("taking", "give.failed"), ("acted",), priority=1),
    Transition("no_longer_taken", ("taking", "give.aborted"), ("acted",), priority=1),
    *(
        Transition(f"give_{outcome}", (f"give.{outcome}",), ("decide",), inhibitors=("taking",))
        for outcome in ("kicked", "failed", "aborted")
    ),
)  # fmt: skip


@functools.lru_cache(maxsize=256)
def attacker_net(passes: int = 0, body: Body = DEFAULT, constants: AttackerConstants | None = None) -> PetriNet:
    """What he does, built from skills.

    Parameters
    ----------
    passes : int
        How many must be made before a goal counts.
    body : Body
    constants : AttackerConstants, optional
        Those set by hand if not given.
    """
    c = constants or AttackerConstants()
    return PetriNet(
        "attacker" if passes == 0 else "combining_attacker",
        places=(
            Place("looking", capacity=1, tokens=1), Place("viewing", capacity=1, tokens=1), Place("decide", capacity=1, tokens=1),
            *(Place(name, capacity=1) for name in ("acted", "with_ball", "taking", "hands_off", "mine", "his", "offside")),
            Place("nobodys", capacity=1, tokens=1), *((Place("swaps", capacity=passes),) if passes else ()),
            *(Input(name, observes=observes) for name, observes in _INPUTS.items()),
            *_decisions(body, c, passes),
        ),
        modules={"setup": setup(body), "walk": advance(body), "meet": intercept(body), "shoot": kick(body), "give": kick(body),
                 "push": kick(body)},
        fuse={
            "walk.place_x": "support_x", "walk.place_y": "support_y",
            "shoot.target_distance": "shot_distance", "shoot.target_direction": "shot_direction", "shoot.arriving": "hard",
            "shoot.at_most": "shot_speed",
            "push.target_distance": "way_distance", "push.target_direction": "way_direction", "push.arriving": "push_arriving",
            "give.target_distance": "give_distance", "give.target_direction": "give_direction", "give.arriving": "give_arriving",
        },
        transitions=(*_transitions(passes), *_OUTCOMES),
    )  # fmt: skip


@functools.lru_cache(maxsize=256)
def attacker_cprm(passes: int = 0, body: Body = DEFAULT, constants: AttackerConstants | None = None) -> CPRM:
    """The net alone: this agent infers nothing."""
    net = attacker_net(passes, body, constants)
    return CPRM(net.name, net=net)


ATTACKER_NET = attacker_net()
"""Of a default player, who may shoot at once."""
COMBINING_NET = attacker_net(3)
"""Of a default player, before whose shot three passes must be made."""


class AttackerAgent(SoccerAgent):
    """An attacker as a controller.

    Parameters
    ----------
    passes : int
        How many must be made before a goal counts.
    opponents, mates : int
        How many there are.
    keeper : int
        Number of the opponents' keeper; 0 if there is none.
    body : Body
    constants : AttackerConstants, optional
        Those set by hand if not given.
    ground : Ground
        Where is played.

    Attributes
    ----------
    motion : Motion
        How the opponents moved, which he remembers.
    """

    def __init__(
        self, passes: int = 0, opponents: int = 1, mates: int = 1, keeper: int = 0, body: Body = DEFAULT,
        constants: AttackerConstants | None = None, ground: Ground = PITCH,
    ) -> None:  # fmt: skip
        c = constants or AttackerConstants()
        judged_by, self.motion = terms(body, c, keeper - 1, ground), Motion(opponents)
        super().__init__(
            attacker_cprm(passes, body, c),
            lambda observation: attacker_percepts(observation, judged_by, self.motion, mates, c.stale, c.focus),
            needs=("memory",),
            body=body,
        )

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes; the copies are made at the first one."""
        super().reset(observation, seed, worlds)
        self.motion.reset(len(observation["level"]), worlds)


def make_controller(task: Task, agent: str, constants: AttackerConstants | None = None, ground: Ground = PITCH) -> AttackerAgent:
    """An attacker of a task as a controller."""
    left = agent.startswith("left")
    mates, opponents, keeper = (task.left, task.right, task.right_goalie) if left else (task.right, task.left, task.left_goalie)
    return AttackerAgent(getattr(task, "passes", 0), opponents, mates - 1, keeper, Body.of(task), constants, ground)
