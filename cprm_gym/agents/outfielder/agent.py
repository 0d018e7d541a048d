"""The outfield player: one of ten who play the same net, each on his own percepts and beliefs (dissertation §2.3.4, §2.3.5, ch. 4).

    decide --(waiting)--> setup                    decide --(ball out of sight)--> look round
    decide --(first at the ball)--> receive | run | go --> with_ball
    decide --(else)--> walk (advance to his place in the formation, which shifts with the ball)
    with_ball --> shoot | passing | quick (a kick to the receiver) | boot (clear) | drive (dribble) --> decide
    with_ball --(own set play)--> taking (a kick to the receiver, or far ahead) --> hands_off --(the ball is gone)--> decide
    beside all of it his eyes: ahead of him while the ball is lost, on the goal while it is at his feet, else on the ball

Legs and eyes are two strands of the net, each with one token. What he wants to do is chosen by transitions, the first of whose conditions
holds; what is under way is left by an interrupt passed down when something more urgent comes up.

Whose ball it is, to whom he passes, whom he marks and who presses him are object places: the best of a class in some respect, subject
to a condition. The opponent nearest to the ball and the receiver are attended to in the model while the places hold them, and an
opponent at the ball possesses it. Where the ball was not seen for a while, the net goes by the belief about it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ...architecture.cprm import CPRM, Cluster, Observe
from ...architecture.petri import AnyPlace, Belief, Command, Continuous, Input, Math, ObjectPlace, PetriNet, Place, Selection, Transition
from ...envs.controller import Action, Observation
from ...envs.observations import BodyFeature
from ...envs.tasks import Task
from ...lazy import made_on_use
from ...simulator.pitch import CENTRE_RADIUS, HALF_LENGTH, HALF_WIDTH
from ..body import DEFAULT, Body, number, of_body
from ..percepts import Percepts
from ..play import SoccerAgent
from ..skills.advance import advance
from ..skills.clear import AT_HAND, clear
from ..skills.dribble import NEAR
from ..skills.drive import drive
from ..skills.go_to_ball import go_to_ball_reflex
from ..skills.kick import kick
from ..skills.pass_ball import pass_ball
from ..skills.receive import receive
from ..skills.setup import setup
from ..skills.shoot import shoot
from .model import PERIOD, outfield_model
from .percepts import outfield_attributes, outfield_percepts

LOST = 6
"""Cycles without a sight of the ball after which he looks round."""
STALE = 3
"""Cycles without a sight of the ball after which the belief about it counts for more than what was last seen, carried on."""
YIELD = 3.0
"""Cycles by which a team-mate must be nearer to the ball before he leaves it to him."""
LEAD = 1.5
"""Metres that a pass goes ahead of the receiver."""
GONE = 8.0
"""Metres that the ball must have gone after an own set play before he plays it again: others must touch it first."""
COMING = 0.35
"""m / cycle at which a ball that comes nearer counts as coming."""
SLOW = 0.4
"""m / cycle at which a rolling ball is met on its way, and not run after."""
IN_RANGE = 20.0
"""Metres from the goal at which he shoots if the way is clear; from `NEAR` he shoots in any case."""
CLEAR_WAY = -0.6
"""Metres of room (`outfield_percepts`) at which the way is clear enough."""
PRESSED, FREE = 3.0, 9.0
"""Metres of the attended opponent within which a pass is in haste, and beyond which there is time to turn and look."""
OFF_PLACE = 2.5
"""Metres off his place at which he goes there."""
OFF_AXIS = 40.0
"""Degrees off the ball at which he turns to it."""
AT_BALL = 0.515
"""Metres beyond the reach of a leg within which an opponent has the ball."""
KEEP_OFF = CENTRE_RADIUS + 1.35
"""Metres that are kept from the ball at a set play of the opponents, a little more than the rule asks for."""
FAR = 60.0
"""Where the attended opponent is while there is none, m."""

WORTH = "0.6 * {t}.ahead + min({t}.room, 4) + 0.7 * min({t}.free, 6) - 0.08 * {t}.distance + (4 if {t}.x > 30 else 0)"
"""What a pass to a team-mate is worth: metres gained, room on the way, room around him; more in front of the goal."""


def _objects(body: Body) -> tuple[AnyPlace, ...]:
    """The team-mate who is first at the ball; he to whom a pass is worth most; who is nearest to the ball; who has it; who to mark."""
    return (
        ObjectPlace("first", "Teammate", Selection(  # set plays are not left to the goalie
            "Teammate", best="teammate.time", where="teammate.age <= 20 and (teammate.x > -45 or not ours)", minimize=True)),
        ObjectPlace("receiver", "Teammate", Selection(
            "Teammate", best=WORTH.format(t="teammate"),
            where="ball_distance < 3 and teammate.age <= 8 and teammate.distance > 4 and teammate.distance < 30 and teammate.room > 0.3 "
                  "and teammate.beyond < 0 and teammate.x > -42")),  # not the goalie, who must not take a pass back with his hands
        ObjectPlace("watched", "Opponent", Selection("Opponent", best="opponent.danger", where="opponent.danger > 0")),
        ObjectPlace("holder", "Opponent",
                    Selection("Opponent", best="opponent.danger", where=f"opponent.ball_gap < {number(body.reach + AT_BALL)}")),
        ObjectPlace("marked", "Opponent", Selection(
            "Opponent", best="hypot(opponent.x - home_x, opponent.y - home_y)", minimize=True,
            where="opponent.age <= 20 and hypot(opponent.x - home_x, opponent.y - home_y) < 9")),
    )  # fmt: skip


_BELIEFS: tuple[AnyPlace, ...] = (
    *(Belief(f"believed_{v}", variable=f"ball.{v}") for v in ("x", "y")),
    Belief("rival_x", variable="watched.x", value=FAR), Belief("rival_y", variable="watched.y"),
    Belief("mate_x", variable="receiver.x", value=FAR), Belief("mate_y", variable="receiver.y"),
)  # fmt: skip

_INPUTS = {
    "me_x": "me.x", "me_y": "me.y", "facing": "me.facing_deg", "speed": "body.speed", "seen_x": "ball.x", "seen_y": "ball.y",
    "vx": "ball.speed_ahead", "vy": "ball.speed_aside", "ball_age": "ball.age", "ball_distance": "ball.reckoned_distance",
    "ball_direction": "ball.reckoned_direction_deg", "approach": "ball.approach", "me_time": "me.time", "meet_x": "meet.x",
    "meet_y": "meet.y", "place_x": "place.x", "place_y": "place.y", "line": "line.x",
    "goal_distance": "goal.distance", "goal_direction": "goal.direction_deg", "goal_room": "goal.room",
    "way_direction": "way.direction_deg", "waiting": "game.waiting", "playing": "game.playing", "ours": "game.ours",
    "theirs": "game.theirs", "kick_off": "game.kick_off",
}  # fmt: skip


def _situation(body: Body) -> tuple[AnyPlace, ...]:
    """Whose ball it is, and where."""
    return (
        Math("lost", f"1 if ball_age > {LOST} else 0"),
        # where it was seen, where a kick-off puts it, or where it is believed to be
        Math("ball_x", f"seen_x if ball_age <= {STALE} else 0 if kick_off else believed_x"),
        Math("ball_y", f"seen_y if ball_age <= {STALE} else 0 if kick_off else believed_y"),
        Math("ball_speed", "hypot(vx, vy)"),
        Math("off_ball_x", "ball_x - me_x"), Math("off_ball_y", "ball_y - me_y"),
        Math("look_angle", "norm_deg(degrees(atan2(off_ball_y, off_ball_x)) - facing) if hypot(off_ball_x, off_ball_y) > 0.01 else 0"),
        # may he touch the ball, and is he the one to do it
        Math("may", "1 if playing or ours else 0"),
        Math("mates_time", "first.time", default=99.0),
        Math("mine", "mates_time - me_time"),
        Math("chase", "1 if may and mine >= 0 and not lost else 0"),
        Math("leave", f"1 if not may or mine < -{YIELD} else 0"),
        Math("reach", f"1 if ball_distance < {body.within(AT_HAND)} and ball_age <= 2 and may else 0"),
        Math("coming", f"1 if approach > {COMING} and ball_age < 5 and ball_distance > 3 else 0"),
        Math("at_feet", "1 if ball_distance < 2.5 and ball_age <= 2 and passing.ongoing < 1 else 0"),
    )  # fmt: skip


def _formation() -> tuple[AnyPlace, ...]:
    """Where he goes without the ball."""
    return (
        Math("deepest", "-46 if place_x < -30 else -38"),
        Math("shifted", "place_x + 0.55 * (ball_x + 10) + (4 if ball_x > 0 else 0)"),
        Math("onside", "max(line - 1, deepest)"),
        Math("ahead", "max(shifted, ball_x + 22) if place_x > -12 and ball_x > -15 else shifted"),
        Math("home_x", "clip(min(ahead, onside), deepest, -0.5 if kick_off else 44)"),
        Math("home_y", f"clip(0.85 * place_y + 0.35 * ball_y, {2.0 - HALF_WIDTH}, {HALF_WIDTH - 2.0})"),
        # he who marks stands between his man and the goal
        Math("goal_way", f"max(0.5, hypot(marked.x + {HALF_LENGTH}, marked.y))", default=1.0),
        Math("mark_x", f"marked.x - 1.5 * (marked.x + {HALF_LENGTH}) / goal_way", default=FAR),
        Math("mark_y", "marked.y - 1.5 * marked.y / goal_way", default=0.0),
        Math("marking", f"1 if playing and ball_x < 0 and mark_x < {FAR} - 1 else 0"),
        # the distance at a set play of theirs
        Math("home_gap", "max(0.1, hypot(home_x - ball_x, home_y - ball_y))"),
        Math("back", f"1 if theirs and home_gap < {KEEP_OFF} else 0"),
        Math("back_x", f"clip(ball_x + {KEEP_OFF} * min(home_x - ball_x, -0.05) / home_gap, -46, 40)"),
        Math("go_x", "back_x if back else mark_x if marking else home_x"),
        Math("go_y", f"ball_y + {KEEP_OFF} * (home_y - ball_y) / home_gap if back else mark_y if marking else home_y"),
        Math("off_place", "hypot(go_x - me_x, go_y - me_y)"),
        Math("off_axis", "abs(look_angle)"),
    )  # fmt: skip


def _with_ball(body: Body) -> tuple[AnyPlace, ...]:
    """What to do with it."""
    return (
        Math("pressure", "hypot(rival_x - me_x, rival_y - me_y)"),
        Math("pressed", f"1 if pressure < {PRESSED} else 0"),
        Math("worth", WORTH.format(t="receiver"), default=-99.0),
        # to the flank on which he is; or to the receiver, as he is believed to stand, or as he was seen until he is attended to
        Math("mate_age", "receiver.age", default=99.0),
        Math("seen_mate_x", "receiver.x", default=FAR), Math("seen_mate_y", "receiver.y"),
        Math("sure", "1 if hypot(mate_x - seen_mate_x, mate_y - seen_mate_y) < 3 else 0"),
        Math("flank_x", "min(45, me_x + 30)"), Math("flank_y", "22 if me_y >= 0 else -22"),
        Math("to_x", f"((mate_x + seen_mate_x) / 2 + {LEAD} if sure else seen_mate_x + {LEAD} if mate_age < 90 else flank_x) - me_x"),
        Math("to_y", "((mate_y + seen_mate_y) / 2 if sure else seen_mate_y if mate_age < 90 else flank_y) - me_y"),
        Math("pass_distance", "max(1, hypot(to_x, to_y))"),
        Math("pass_direction", "norm_deg(degrees(atan2(to_y, to_x)) - facing) if hypot(to_x, to_y) > 0.01 else 0"),
        Math("can_shoot", f"1 if goal_distance < {NEAR} or (goal_distance < {IN_RANGE} and goal_room > {CLEAR_WAY}) else 0"),
        Math("can_pass", "1 if worth > (-90 if ours else 5 if pressed else 9) else 0"),
        Math("must_clear", "1 if ours or (pressed and me_x < -25) else 0"),
        Math("unmolested", f"1 if pressure >= {FREE} else 0"),
        Math("off_run", "1 if leave or ball_distance < 2.5 or ball_speed < 0.25 else 0"),
        Math("gone", f"1 if ball_distance >= {GONE} or ball_speed < 0.3 else 0"),
        Math("flank", "norm_deg(degrees(atan2(flank_y - me_y, flank_x - me_x)) - facing)"),
        Continuous("softly", 1.0), Continuous("stride", 10.0), Continuous("ahead_of_him", 0.0),
        Math("turn_moment", body.turn("look_angle")),
        Math("search_moment", body.turn("(look_angle if ball_age < 20 and abs(look_angle) > 40 else 60)")),
    )  # fmt: skip


_LEGS = (
    Transition("wait", ("decide",), ("setup.begin",), tests={"waiting": 1}, priority=8),
    Transition("sweep", ("decide",), ("acted",), tests={"lost": 1}, emits=Command("turn", moment="search_moment"), priority=7),
    Transition("have", ("decide",), ("with_ball",), tests={"reach": 1}, priority=6),
    Transition("expect", ("decide",), ("receive.begin",), tests={"chase": 1, "coming": 1}, priority=5),
    Transition("meet", ("decide",), ("run.begin",), tests={"chase": 1, "ball_speed": SLOW, "ball_distance": 3.0}, priority=4),
    Transition("fetch", ("decide",), ("go.begin",), tests={"chase": 1}, priority=3),
    Transition("to_place", ("decide",), ("walk.begin",), tests={"off_place": OFF_PLACE}, priority=2),
    Transition("face", ("decide",), ("acted",), tests={"off_axis": OFF_AXIS}, emits=Command("turn", moment="turn_moment"), priority=1),
    Transition("rest", ("decide",), ("acted",)),
    Transition("on", ("acted",), ("decide",), delay=1),
    # with the ball
    Transition("take_it", ("with_ball",), ("taking.begin",), tests={"ours": 1}, priority=6),
    Transition("shoot_it", ("with_ball",), ("shoot.begin",), tests={"playing": 1, "can_shoot": 1}, priority=5),
    Transition("pass_it", ("with_ball",), ("passing.begin",), tests={"playing": 1, "can_pass": 1, "unmolested": 1}, priority=4),
    Transition("pass_fast", ("with_ball",), ("quick.begin",), tests={"playing": 1, "can_pass": 1}, priority=3),
    Transition("boot_it", ("with_ball",), ("boot.begin",), tests={"playing": 1, "must_clear": 1}, priority=2),
    Transition("drive_it", ("with_ball",), ("drive.begin",), tests={"playing": 1}, priority=1),
    Transition("let_be", ("with_ball",), ("acted",)),
    # after a set play of his own somebody else must touch the ball next
    Transition("hands_on", ("hands_off",), ("acted",), tests={"gone": 1}),
)  # fmt: skip
"""What to do now, and what to do with the ball: the first that applies."""

_EYES = (
    Transition("look_ahead", ("looking",), ("looked",), tests={"lost": 1}, emits=Command("look", direction="ahead_of_him"), priority=2),
    Transition("look_at_goal", ("looking",), ("looked",), tests={"at_feet": 1}, emits=Command("look", direction="goal_direction"),
               priority=1),
    Transition("look_at_ball", ("looking",), ("looked",), emits=Command("look", direction="look_angle")),
    Transition("blink", ("looked",), ("looking",), delay=1),
)  # fmt: skip
"""Where he looks, whatever his legs do."""

_LEAVES: tuple[tuple[str, str, Mapping[str, float], Mapping[str, float]], ...] = (
    ("walk", "waiting", {"waiting": 1}, {}), ("walk", "lost", {"lost": 1}, {}), ("walk", "reach", {"reach": 1}, {}),
    ("walk", "chase", {"chase": 1}, {}),
    ("go", "to_another", {"leave": 1}, {}), ("run", "it_is_there", {"off_run": 1}, {}),
    ("drive", "in_vain", {}, {"may": 1}), ("drive", "to_shoot", {"reach": 1, "can_shoot": 1}, {}),
    ("drive", "to_pass", {"reach": 1, "can_pass": 1}, {}), ("drive", "to_clear", {"reach": 1, "must_clear": 1}, {}),
)  # fmt: skip
"""Module, why it is left, what has to hold and what must not."""
_INTERRUPTS = tuple(
    Transition(f"leave_{module}_{why}", outputs=(f"{module}.abort",), tests={f"{module}.ongoing": 1, **when},
               inhibitors={f"{module}.abort": 1, f"{module}.begin": 1, **unless}, priority=9)
    for module, why, when, unless in _LEAVES
)  # fmt: skip
"""Aborts passed down: something else is to be done, or a team-mate is nearer to the ball."""


def _ends(module: str, outcomes: tuple[str, ...], then: str) -> tuple[Transition, ...]:
    """The outcomes of a module lead on to `then`, once it has no interrupt left that came too late."""
    late = (f"{module}.abort",) if module in ("walk", "go", "run", "drive") else ()
    return tuple(Transition(f"{module}_{outcome}", (f"{module}.{outcome}",), (then,), inhibitors=late) for outcome in outcomes)


_OUTCOMES = (
    *_ends("go", ("at_ball",), "with_ball"), *_ends("receive", ("received",), "with_ball"), *_ends("drive", ("there",), "with_ball"),
    *(t for module in ("walk", "go", "run", "receive", "drive") for t in _ends(module, ("aborted",), "decide")),
    *_ends("setup", ("set", "aborted"), "acted"), *_ends("walk", ("arrived",), "acted"), *_ends("run", ("arrived",), "acted"),
    *_ends("go", ("lost_ball",), "acted"), *_ends("receive", ("missed",), "acted"), *_ends("drive", ("lost_ball",), "acted"),
    *_ends("shoot", ("shot", "failed", "aborted"), "acted"), *_ends("passing", ("passed", "failed", "aborted"), "acted"),
    *_ends("taking", ("kicked",), "hands_off"), *_ends("taking", ("failed", "aborted"), "acted"),
    *_ends("quick", ("kicked", "failed", "aborted"), "acted"), *_ends("boot", ("cleared", "failed", "aborted"), "acted"),
)  # fmt: skip
"""Outcomes passed up: he has the ball, or he decides anew, at once or a cycle later."""


@of_body
def outfielder_net(body: Body) -> PetriNet:
    """What he does, built from skills; the same for the ten."""
    return PetriNet(
        "outfielder",
        places=(
            Place("looked", capacity=1, tokens=1), Place("decide", capacity=1, tokens=1),
            *(Place(name, capacity=1) for name in ("looking", "acted", "with_ball", "hands_off")),
            *(Input(name, observes=observes) for name, observes in _INPUTS.items()),
            *_objects(body), *_BELIEFS, *_situation(body), *_formation(), *_with_ball(body),
        ),
        modules={"setup": setup(body), "walk": advance(body), "run": advance(body), "go": go_to_ball_reflex(body),
                 "receive": receive(body), "passing": pass_ball(body), "quick": kick(body), "taking": kick(body), "boot": clear(body),
                 "drive": drive(body), "shoot": shoot(body)},
        fuse={
            "setup.place_x": "place_x", "setup.place_y": "place_y",
            "walk.place_x": "go_x", "walk.place_y": "go_y", "run.place_x": "meet_x", "run.place_y": "meet_y",
            **{f"{kick}.target_distance": "pass_distance" for kick in ("passing", "quick", "taking")},
            **{f"{kick}.target_direction": "pass_direction" for kick in ("passing", "quick", "taking")},
            **{f"{kick}.arriving": "softly" for kick in ("passing", "quick", "taking")}, "passing.mate_age": "mate_age",
            "boot.ball_distance": "ball_distance", "boot.flank": "flank", "drive.way_distance": "stride",
            "drive.way_direction": "way_direction",
        },
        transitions=(*_LEGS, *_EYES, *_INTERRUPTS, *_OUTCOMES),
    )  # fmt: skip


OUTFIELDER_NET = outfielder_net()
"""Of a default player."""

_NUMBERS = range(1, 12)


@of_body
def outfielder_cprm(body: Body, period: int = PERIOD) -> CPRM:
    """Net, beliefs, and the links between them; `period` is of a slice, in cycles."""
    return CPRM(
        "outfielder",
        net=outfielder_net(body),
        model=outfield_model(body, period),
        objects={"ball": "Ball", **{f"t{k}": "Teammate" for k in _NUMBERS}, **{f"o{k}": "Opponent" for k in _NUMBERS}},
        observations=(
            Observe("ball.seen_x", "ball.x", when="ball.placed"), Observe("ball.seen_y", "ball.y", when="ball.placed"),
            Observe("ball.seen_vx", "ball.vx", when="ball.moving"), Observe("ball.seen_vy", "ball.vy", when="ball.moving"),
            *(Observe(f"{o}{k}.seen_{v}", f"{o}{k}.{v}", when=f"{o}{k}.seen") for o in "to" for k in _NUMBERS for v in "xy"),
        ),
        clusters=(
            Cluster("attendedOpponent", ("watched",)),
            Cluster("attendedTeammate", ("receiver",)),
            Cluster("possessesOpponent", ("holder", "=ball")),
        ),
        period=period,
    )  # fmt: skip


class OutfieldAgent(SoccerAgent):
    """An outfield player as a controller; each copy may be another of the ten.

    He remembers whether the last look told how the ball moves: a slice of his model is longer than a cycle, so that it may take in a look
    of the cycle before. Players with odd numbers begin a cycle later, so that of ten on one core half infer in every cycle. Where
    inferences are an odd number of cycles apart (``t_b``), a slice is one cycle.
    """

    def __init__(self, body: Body = DEFAULT, **options: Any) -> None:
        super().__init__(
            outfielder_cprm(body, 1 if isinstance(t_b := options.get("t_b"), int) and t_b % PERIOD else PERIOD),
            self._perceive,
            needs=("memory",),
            objects=lambda observation: outfield_attributes(observation, body),
            body=body,
            **options,
        )
        self._waiting = self._moving = np.zeros(0, bool)

    def _perceive(self, observation: Observation) -> Percepts:
        """`outfield_percepts`, where ``ball.moving`` is what the last look told, as ``ball.placed`` is."""
        percepts = outfield_percepts(observation, self.body)
        looked = percepts["ball.age"] == 0
        self._moving = np.where(looked, percepts["ball.moving"] > 0, self._moving)
        percepts["ball.moving"] = percepts["ball.placed"] * self._moving
        return percepts

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes; the copies are made at the first one."""
        super().reset(observation, seed, worlds)
        odd = np.asarray(observation["body"])[:, BodyFeature.UNUM].astype(np.int64) % 2 == 1
        before = self._waiting if len(self._waiting) == len(odd) else np.zeros(len(odd), bool)
        self._waiting = odd if worlds is None else np.where(worlds, odd, before)
        moved = self._moving if len(self._moving) == len(odd) else np.zeros(len(odd), bool)
        self._moving = np.zeros(len(odd), bool) if worlds is None else moved & ~np.asarray(worlds, bool)

    def act(self, observation: Observation) -> Action:
        """One cycle of every copy."""
        action = super().act(observation)
        if self.controller is not None and self._waiting.any():
            self.controller.reset(self._waiting)
            self._waiting = np.zeros(len(self._waiting), bool)
        return action


def make_controller(task: Task, agent: str) -> OutfieldAgent:
    """An outfield player as a controller."""
    return OutfieldAgent(Body.of(task))


if TYPE_CHECKING:
    OUTFIELDER: CPRM
    """Of a default player."""

__getattr__ = made_on_use(__name__, {"OUTFIELDER": outfielder_cprm})
