"""Every skill alone: started where its precondition holds, judged by the world and not by what it says of itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ...architecture.cprm import CPRM
from ...architecture.petri import Command, Continuous, Input, Math, PetriNet, Place, Transition
from ...envs.core import SoccerCore
from ...envs.pitch import Pitch, wrapped
from ...envs.tasks import Task
from ...envs.tasks.base import Outcome
from ...simulator.pitch import HALF_LENGTH, PENALTY_X, PENALTY_Y
from ...simulator.state import PlayMode
from ..body import DEFAULT, Body
from ..finder.agent import finder_percepts
from ..goalie import BALL, BALL_SEEN, GOAL_X, goalie_percepts, kinematics
from ..models import goalie_model
from ..play import SoccerAgent
from ..skills.accelerate import CLOSE, accelerate
from ..skills.advance import advance
from ..skills.approach import approach
from ..skills.catch_ball import catch_ball
from ..skills.clear import clear
from ..skills.constants import FIRST
from ..skills.cruise import cruise
from ..skills.dribble import dribble
from ..skills.drive import drive
from ..skills.go_to_ball import go_to_ball_reflex
from ..skills.intercept import intercept
from ..skills.kick import kick
from ..skills.look_out import look_out
from ..skills.meet_ball import meet_ball
from ..skills.orient import orient
from ..skills.pass_ball import pass_ball
from ..skills.receive import receive
from ..skills.reposition import reposition
from ..skills.setup import setup
from ..skills.shoot import shoot
from ..skills.slow import slow
from ..skills.watch_ball import watch_ball

WATCHED = 50
"""Cycles after which a skill that never ends is judged."""
_FEET = (0.307, 0.593)
"""Shares of the kickable ring between which the ball lies at his feet."""
SETTLE = 4
"""Cycles in which he may look about him before he begins."""
Start = Callable[[SoccerCore, np.ndarray, np.ndarray], None]
Judge = Callable[[SoccerCore], np.ndarray]


def alone(skill: PetriNet, given: Mapping[str, float | str], whom: str = "ball", settle: int = SETTLE) -> PetriNet:
    """A net that begins the skill after `settle` cycles, keeps the eyes on the ball (or ``mate``), and notes that it is done.

    What is given to the skill is a number or the name of a percept. A skill that never ends looks itself, and is called done after
    `WATCHED` cycles.
    """
    done = skill.ports.done
    look = Transition("look", ("looking",), ("looking",), delay=1, emits=Command("look", direction="gaze"))
    finish = Transition("finish", (f"skill.{done}",), ("done",)) if done else Transition("finish", ("watched",), ("done",), delay=WATCHED)
    return PetriNet(
        f"{skill.name} alone",
        places=(
            Place("intend", capacity=1, tokens=1), Place("done", capacity=1), Place("looking", capacity=1, tokens=1),
            Place("watched", capacity=1),
            Input("direction", observes="mate.direction_deg" if whom == "mate" else "ball.reckoned_direction_deg"),
            Input("age", observes=f"{whom}.age"), Math("gaze", "direction if age < 15 else 0"),
            *(Input(f"given_{k}", observes=v) if isinstance(v, str) else Continuous(f"given_{k}", v) for k, v in given.items()),
        ),
        modules={"skill": skill},
        fuse={f"skill.{k}": f"given_{k}" for k in given},
        transitions=(
            Transition("set_out", ("intend",), ("skill.begin", *(() if done else ("watched",))), delay=settle),
            finish,
            *((look,) if done else ()),
        ),
    )  # fmt: skip


def goalie_alone(skill: PetriNet, body: Body = DEFAULT, settle: int = SETTLE) -> CPRM:
    """The same for a skill of the goalie, with his belief about the ball and what he derives from it.

    A skill that never ends is called done after `WATCHED` cycles.
    """
    done = skill.ports.done
    look = Transition("look", ("looking",), ("looking",), delay=1, emits=Command("look", direction="ball_direction"))
    finish = Transition("finish", (f"skill.{done}",), ("done",)) if done else Transition("finish", ("watched",), ("done",), delay=WATCHED)
    net = PetriNet(
        f"{skill.name} alone",
        places=(
            Place("intend", capacity=1, tokens=1), Place("done", capacity=1), Place("looking", capacity=1, tokens=1),
            Place("watched", capacity=1), *BALL, Continuous("watched_x", 40.0), Continuous("watched_y"),
            Input("x", observes="self.x"), Input("y", observes="self.y"), Input("body", observes="self.body_deg"),
            Input("own_vx", observes="self.vx"), Input("own_vy", observes="self.vy"),
            Input("seen_distance", observes="ball.distance"), Input("ball_age", observes="ball.age"), *kinematics(body),
        ),
        modules={"skill": skill},
        fuse={f"skill.{p}": "hand_distance" if (skill.name, p) == ("clear", "ball_distance") else p for p in skill.ports.parameters},
        transitions=(Transition("set_out", ("intend",), ("skill.begin", "watched"), delay=settle), finish, *((look,) if done else ())),
    )  # fmt: skip
    return CPRM(net.name, net, goalie_model(body), {"ball": "Ball"}, observations=BALL_SEEN)


@dataclass(frozen=True)
class Trial:
    """How a skill is tried.

    Attributes
    ----------
    make : callable
        The skill of a `Body`.
    start : callable
        (core, worlds, (n, 6) draws) puts players and ball.
    judge : callable
        core -> (W,) bool: whether the world is as the skill promises.
    criterion : str
        The same in words.
    given : mapping of str to float or str
        Parameters of the skill: a number, or a percept.
    cycles : int
        Cycles after which it is judged if it has not ended.
    wait : int
        Cycles between its end and the judgement.
    any_time : bool
        Whether it is enough that the judge agrees once.
    eyes : str
        What he looks at: ``ball`` or ``mate``.
    goalie : bool
        Whether it is a skill of the goalie, who has a belief about the ball.
    """

    make: Callable[..., PetriNet]
    start: Start
    judge: Judge
    criterion: str
    given: Mapping[str, float | str] = field(default_factory=dict)
    cycles: int = 150
    wait: int = 0
    any_time: bool = False
    eyes: str = "ball"
    goalie: bool = False

    @property
    def skill(self) -> PetriNet:
        """The skill of a default player."""
        return self.make()

    def agent(self, name: str, body: Body = DEFAULT, settle: int = SETTLE) -> SoccerAgent:
        """A player who does nothing else, from cycle `settle` on."""
        skill = self.make(body)
        if self.goalie:
            cprm = goalie_alone(skill, body, settle)
            return SoccerAgent(cprm, lambda observation: goalie_percepts(observation, 0), needs=("memory",), body=body)
        return SoccerAgent(CPRM(name, alone(skill, self.given, self.eyes, settle)), finder_percepts, needs=("memory",), body=body)


def _apart(core: SoccerCore) -> np.ndarray:
    return core.distance(0, 1)


def _bearing(core: SoccerCore) -> np.ndarray:
    w = core.sim.world
    d = w["pos"][:, 0] - w["pos"][:, 1]
    angle = np.arctan2(d[:, 1], d[:, 0]) - w["body"][:, 0]
    return np.degrees(np.abs((angle + np.pi) % (2 * np.pi) - np.pi))


def _speed(core: SoccerCore) -> np.ndarray:
    return np.hypot(*core.sim.world["vel"][:, 1].T)


def _fast(core: SoccerCore) -> np.ndarray:
    """He has five eighths of his top speed; what stands in the world is what the decay has left of it."""
    body = Body.of(core.task)
    return np.asarray(_speed(core) > 0.625 * body.kind.player_decay * body.top_speed)


def _standing_at_ball(core: SoccerCore) -> np.ndarray:
    return core.kickable(1) & (_speed(core) < 0.15)


def _ball_at(near: float, far: float, aside: float, x: float = 0.0, feet: bool = False) -> Start:
    """He stands around (x, 0) looking forward within `aside` degrees of the ball, which is `near` to `far` metres before him.

    At his `feet` they are shares of the kickable ring.
    """

    def start(core: SoccerCore, worlds: np.ndarray, u: np.ndarray) -> None:
        place = np.stack([x + 4 * (u[:, 0] - 0.5), 20 * (u[:, 1] - 0.5)], axis=1)
        low, high = (Body.of(core.task).within(share) for share in (near, far)) if feet else (near, far)
        angle, far_off = 2 * np.pi * (u[:, 2] - 0.5) * (1.0 if x == 0 else 0.2), low + (high - low) * u[:, 3]
        ball = place + far_off[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        core.place_ball(*ball.T, worlds=worlds)
        core.place_player(1, *place.T, wrapped(angle + np.radians(aside) * (2 * u[:, 4] - 1)), worlds=worlds)

    return start


def _ball_comes(core: SoccerCore, worlds: np.ndarray, u: np.ndarray) -> None:
    """A ball 12 to 20 m away that rolls to within 12 degrees of him, and far enough."""
    _ball_at(12.0, 20.0, 60.0)(core, worlds, u)
    w = core.sim.world
    d = w["pos"][worlds, 1] - w["pos"][worlds, 0]
    gap = np.hypot(d[:, 0], d[:, 1])
    angle = np.arctan2(d[:, 1], d[:, 0]) + np.radians(12.0) * (2 * u[:, 5] - 1)
    speed = Body.of(core.task).roll * gap + 0.4 + 0.4 * u[:, 0]
    core.place_ball(*w["pos"][worlds, 0].T, speed * np.cos(angle), speed * np.sin(angle), worlds=worlds)


def _with_mate(core: SoccerCore, worlds: np.ndarray, u: np.ndarray) -> None:
    """The ball at his feet, the team-mate 8 to 18 m away in any direction."""
    _ball_at(*_FEET, 30.0, feet=True)(core, worlds, u)
    angle, far = 2 * np.pi * u[:, 5], 8.0 + 10.0 * u[:, 1]
    place = core.sim.world["pos"][worlds, 1] + (far * np.stack([np.cos(angle), np.sin(angle)])).T
    core.place_player(2, *place.T, wrapped(angle + np.pi), (0.0, 0.0), worlds=worlds)


def before_kick_off(core: SoccerCore, worlds: np.ndarray, u: np.ndarray) -> None:
    """The start of KickOffShot."""


def _near_mate(core: SoccerCore) -> np.ndarray:
    return core.distance(0, 2) < 2.0


def _near_line(core: SoccerCore) -> np.ndarray:
    """The ball flies within 7 degrees of the middle of the goal."""
    w = core.sim.world
    to_goal = np.array([HALF_LENGTH, 0.0]) - w["pos"][:, 0]
    angle = np.arctan2(w["vel"][:, 0, 1], w["vel"][:, 0, 0]) - np.arctan2(to_goal[:, 1], to_goal[:, 0])
    moving: np.ndarray = np.hypot(*w["vel"][:, 0].T) > 0.2
    return moving & (np.abs(np.degrees((angle + np.pi) % (2 * np.pi) - np.pi)) < 7.0)


def _shot(core: SoccerCore, worlds: np.ndarray, u: np.ndarray) -> None:
    """A ball that comes from 20 to 30 m and would cross the line within 5 m of the middle of the goal; the goalie stands ready."""
    far, angle = 20.0 + 10.0 * u[:, 0], np.radians(45.0) * (2 * u[:, 1] - 1)
    ball = np.stack([GOAL_X + far * np.cos(angle), far * np.sin(angle)], axis=1)
    way = np.stack([np.full(len(u), GOAL_X), 5.0 * (2 * u[:, 2] - 1)], axis=1) - ball
    length = np.hypot(way[:, 0], way[:, 1])
    speed = Body.of(core.task).roll * length + 0.4 + 0.4 * u[:, 3]
    core.place_ball(*ball.T, *(speed[:, None] * way / length[:, None]).T, worlds=worlds)
    guard = np.stack([GOAL_X + 4.0 * np.cos(angle), 4.0 * np.sin(angle)], axis=1)
    core.place_player(1, *guard.T, wrapped(angle + np.radians(FIRST.side_on)), worlds=worlds)


def _in_hand(core: SoccerCore, worlds: np.ndarray, u: np.ndarray) -> None:
    """The ball lies at the goalie's hands as after a catch, somewhere in his penalty area."""
    place = np.stack([GOAL_X + 2.0 + 8.0 * u[:, 0], 16.0 * (2 * u[:, 1] - 1)], axis=1)
    angle = 2 * np.pi * u[:, 2]
    ball = place + 0.4 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    core.place_ball(*ball.T, worlds=worlds)
    core.place_player(1, *place.T, wrapped(angle + np.radians(20.0) * (2 * u[:, 3] - 1)), worlds=worlds)


def _off_post(core: SoccerCore, worlds: np.ndarray, u: np.ndarray) -> None:
    """The goalie up to 9 m from the middle of his goal, looking anywhere; the ball 12 to 30 m from it."""
    for kind, near, far, v in ((1, 1.0, 9.0, u[:, :2]), (0, 12.0, 30.0, u[:, 2:4])):
        away, angle = near + (far - near) * v[:, 0], np.radians(60.0) * (2 * v[:, 1] - 1)
        place = np.stack([GOAL_X + away * np.cos(angle), away * np.sin(angle)], axis=1)
        if kind:
            core.place_player(1, *place.T, wrapped(2 * np.pi * u[:, 4]), worlds=worlds)
        else:
            core.place_ball(*place.T, worlds=worlds)


def _ball_passes(core: SoccerCore, worlds: np.ndarray, u: np.ndarray) -> None:
    """The goalie stands still; a ball 10 to 20 m before him rolls across, at up to 1 m a cycle."""
    place = np.tile([-50.0, 0.0], (len(u), 1))
    angle, far = np.radians(50.0) * (2 * u[:, 0] - 1), 10.0 + 10.0 * u[:, 1]
    across = angle + np.pi / 2 * np.sign(u[:, 2] - 0.5)
    speed = 0.3 + 0.7 * u[:, 3]
    core.place_player(1, *place.T, 0.0, worlds=worlds)
    ball = place + far[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    core.place_ball(*ball.T, speed * np.cos(across), speed * np.sin(across), worlds=worlds)


def _in_view(core: SoccerCore) -> np.ndarray:
    """The ball stands within the view cone."""
    w = core.sim.world
    d = w["pos"][:, 0] - w["pos"][:, 1]
    angle = np.arctan2(d[:, 1], d[:, 0]) - w["body"][:, 0] - w["neck"][:, 0]
    return np.asarray(np.degrees(np.abs((angle + np.pi) % (2 * np.pi) - np.pi)) < 60.0)


def _out_of_box(core: SoccerCore) -> np.ndarray:
    ball = core.sim.world["pos"][:, 0]
    return np.asarray((ball[:, 0] > -PENALTY_X) | (np.abs(ball[:, 1]) > PENALTY_Y))


def _guarding(core: SoccerCore) -> np.ndarray:
    """Between ball and goal (`KINEMATICS`), side-on to the ball."""
    w = core.sim.world
    ball, me = w["pos"][:, 0], w["pos"][:, 1]
    off = ball - [GOAL_X, 0.0]
    gap = np.hypot(off[:, 0], off[:, 1])
    post = np.array([GOAL_X, 0.0]) + (np.clip(0.3 * gap + 1.0, 1.0, 8.0) / gap)[:, None] * off
    angle = np.degrees(np.arctan2(*(ball - me).T[::-1]) - w["body"][:, 0])
    side = np.abs(np.abs((angle + 180.0) % 360.0 - 180.0) - FIRST.side_on)
    return np.asarray((np.hypot(*(post - me).T) < 1.0) & (side < 25.0))


_BALL = {"gaze": "ball.reckoned_direction_deg", "ball_age": "ball.age"}
_MEETING = {"ball_distance": "ball.reckoned_distance", "meet_distance": "ball.reckoned_distance",
            "meet_direction": "ball.reckoned_direction_deg"}  # fmt: skip
"""What the finder's skills are given: he runs at the ball itself."""
TRIALS: dict[str, Trial] = {
    "setup": Trial(setup, before_kick_off, lambda c: c.kickable(1), "at the kick-off the ball is in reach"),
    "orient": Trial(orient, _ball_at(3, 25, 180), lambda c: _bearing(c) < 8, "ball within 8 degrees of ahead", cycles=20),
    "accelerate": Trial(accelerate, _ball_at(12, 25, 4), _fast, "fast, before the ball is close", cycles=30),
    "cruise": Trial(cruise, _ball_at(12, 25, 4), lambda c: np.abs(_apart(c) - CLOSE) < 1.3, "at the ball's neighbourhood"),
    "slow": Trial(slow, _ball_at(2, 4, 4), _standing_at_ball, "standing at the ball", cycles=60),
    "approach": Trial(approach, _ball_at(8, 25, 180), _standing_at_ball, "standing at the ball"),
    "go_to_ball": Trial(go_to_ball_reflex, _ball_at(5, 25, 45), lambda c: c.kickable(1), "ball in reach"),
    "meet_ball": Trial(meet_ball, _ball_comes, lambda c: c.kickable(1), "the rolling ball is in reach", given={**_BALL, **_MEETING}),
    "look_out": Trial(look_out, _ball_passes, _in_view, f"after {WATCHED} cycles the ball that passes is in view", given=_BALL),
    "kick": Trial(kick, _ball_at(*_FEET, 60, 30.0, feet=True), _near_line, "ball within 7 degrees of the aim", wait=1),
    "pass_ball": Trial(pass_ball, _with_mate, _near_mate, "ball within 2 m of the team-mate", cycles=60, wait=40, any_time=True,
                       eyes="mate"),
    "dribble": Trial(dribble, _ball_at(*_FEET, 30, 15.0, feet=True), lambda c: c.kickable(1), "near the goal, ball in reach", cycles=200),
    "shoot": Trial(shoot, _ball_at(*_FEET, 30, 35.0, feet=True), lambda c: c.crossed_goal_line(True), "goal", wait=30, any_time=True),
    "receive": Trial(receive, _ball_comes, lambda c: c.kickable(1), "ball in reach", cycles=80),
    "intercept": Trial(intercept, _ball_at(5, 25, 45), lambda c: c.kickable(1), "ball in reach",
                       given={"way": "ball.reckoned_distance", "bearing": "ball.reckoned_direction_deg"}),
    "advance": Trial(advance, _ball_at(5, 25, 180), lambda c: np.hypot(*(c.sim.world["pos"][:, 1] - [20.0, 10.0]).T) < 1.5,
                     "within 1.5 m of the place", given={"place_x": 20.0, "place_y": 10.0}),
    "drive": Trial(drive, _ball_at(*_FEET, 30, 15.0, feet=True), lambda c: c.kickable(1), "near the goal, ball in reach", cycles=200,
                   given={"way_direction": "goal.direction_deg"}),
    "watch_ball": Trial(watch_ball, _ball_passes, _in_view, f"after {WATCHED} cycles the ball that passes is in view", goalie=True),
    "catch_ball": Trial(catch_ball, _shot, lambda c: c.kickable(1) & ~c.crossed_goal_line(False), "the shot is in his hands", cycles=60,
                        goalie=True),
    "clear": Trial(clear, _in_hand, _out_of_box, "ball out of the penalty area", cycles=20, wait=40, any_time=True, goalie=True),
    "reposition": Trial(reposition, _off_post, _guarding, "within 1 m of the guarding place, side-on within 25 degrees", goalie=True),
}  # fmt: skip
"""Skill -> how it is tried."""


@dataclass(frozen=True)
class StageTask(Task):
    """A task without an end, whose start is that of a trial."""

    start: Start = before_kick_off

    def setup(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """Play is on; the team-mate is far off unless the trial places him."""
        core = pitch
        assert isinstance(core, SoccerCore)
        core.sim.world["mode"][worlds] = PlayMode.play_on
        core.place_player(2, -30.0, -30.0, 0.0, worlds=worlds)
        self.start(core, worlds, core.draw(worlds, 6))

    def outcome(self, pitch: Pitch) -> Outcome:
        """Nothing counts."""
        shape = (pitch.worlds, len(pitch.players))
        return Outcome(np.zeros(shape), np.zeros(pitch.worlds, bool), np.zeros(shape, bool), np.zeros(pitch.worlds, np.int64), {})
