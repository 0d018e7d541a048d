"""The goalie: watches the ball, gets into the way of shots, catches, clears and goes back to his place (dissertation §2.3.5).

    guard --> post (reposition) --> watching --(the ball is coming)--> save (catch_ball)
    save: caught, or missed with the ball at hand --> away (clear) --> guard        over, past, missed --> guard
    eyes (watch_ball) runs beside all of it

He believes in the ball's place and velocity, seen with noise and every second cycle only; from them follow the point where its way
comes closest and the cycle in which it lies in his hands. Opponents are objects; the `ATTENDED` nearest to the ball are watched
(relation ``attendedOpponent``), and one who is at the ball possesses it (``possessesOpponent``), which makes a shot expected
before it is seen. The object places of the net decide both.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..architecture.cprm import CPRM, Cluster, Observe
from ..architecture.cprm.percepts import PerceptNames, PerceptTable
from ..architecture.petri import Belief, Continuous, Input, Math, ObjectPlace, PetriNet, Place, Selection, Transition
from ..architecture.petri.execution.state import ObjectTable
from ..architecture.prm.inference.engines.projection import ProjectionEngine
from ..envs.controller import Observation
from ..envs.tasks import Task
from ..errors import ParameterError, unknown_name
from ..simulator.pitch import HALF_LENGTH, PENALTY_X, PENALTY_Y
from .body import DEFAULT, Body, number
from .kernels import goalie as kernels
from .models import goalie_model
from .percepts import Percepts, parts, table
from .play import SoccerAgent
from .skills.catch_ball import catch_ball
from .skills.clear import AT_HAND, clear
from .skills.constants import FIRST, AttackedConstants, GoalieConstants, HoldingConstants
from .skills.reposition import attacked, guarding_place, reposition
from .skills.watch_ball import watch_ball

ATTENDED = 2
"""Opponents who are watched."""
AT_BALL = 0.515
"""Metres beyond the reach of a leg within which an opponent has the ball, as far as the eye can tell."""
GOAL_X = -HALF_LENGTH
"""The own goal line."""
BOX_X, BOX_Y = -PENALTY_X - 1.0, PENALTY_Y - 1.16
"""The own penalty area, where he may use his hands, less what he may err about his place, m."""


def race(body: Body, who: str, x: str, y: str, time: str) -> tuple[Math, ...]:
    """Places ``{who}_time``, ``{who}_x`` and ``{who}_y``: when and where somebody at (x, y) meets the rolling ball."""
    places: list[Math] = []
    at = ("ball_x", "ball_y")
    for k in ("_1", "_2", "_3", ""):
        way = f"hypot({at[0]} - {x}, {at[1]} - {y})"
        now, last = f"{who}_time{k}", places[-3].name if places else ""
        needed = time.format(way=way)
        places += [
            Math(now, f"0.5 * ({last} + {needed})" if last else needed),
            Math(f"{who}_x{k}", f"ball_x + ball_vx * (1 - exp(-{body.fade} * {now})) / {number(body.roll)}"),
            Math(f"{who}_y{k}", f"ball_y + ball_vy * (1 - exp(-{body.fade} * {now})) / {number(body.roll)}"),
        ]
        at = (places[-2].name, places[-1].name)
    return tuple(places)


def late(body: Body, way: str, c: GoalieConstants) -> tuple[Math, ...]:
    """Place ``late_{way}``: cycles by which he comes too late to where the ball is after that many metres of its way."""
    reach = f"hypot(dx + {way} * ux, dy + {way} * uy)"
    roll = f"-log(max(0.02, 1 - {number(body.roll)} * {way} / max(ball_speed, 0.05))) / {body.fade}"
    return (Math(f"late_{way}", f"{number(c.haste)} + max(0, {reach} - {body.within(c.at_feet)}) / {body.pace(c.run)} - ({roll})"),)


HANDS = {
    "hands": "seen_distance if ball_age <= 2 and seen_distance < 2 else ball_distance",
    "none": "ball_distance",
    "eye": "ball_distance",
}
"""Reflexes -> by what he judges whether the ball is near enough to kick: ``hands`` have a ball seen near by as the eye had it, which is
finer than any bins; with ``none`` all is as it is believed; of ``eye`` see `REFLEX`."""


def kinematics(body: Body, c: GoalieConstants = FIRST, reflexes: str = "hands") -> tuple[Math, ...]:
    """Quantities derived from place and velocity of ball and goalie, by which he decides (Fig. 2.29)."""
    deepest, pace, feet = number(GOAL_X + c.deepest), body.pace(c.run), body.within(c.at_feet)
    return (
        # where the ball is from the goalie
        Math("dx", "ball_x - x"), Math("dy", "ball_y - y"),
        Math("ball_distance", "hypot(dx, dy)"),
        Math("ball_angle", "degrees(atan2(dy, dx)) if ball_distance > 0.01 else 0"),
        Math("ball_direction", "norm_deg(ball_angle - body)"),
        Math("next_distance", "hypot(dx + ball_vx - own_vx, dy + ball_vy - own_vy)"),
        # its way: unit vector, what is left of it up to the point closest to him, that point
        Math("ball_speed", "hypot(ball_vx, ball_vy)"),
        Math("ux", "ball_vx / ball_speed if ball_speed > 0.05 else 0"), Math("uy", "ball_vy / ball_speed if ball_speed > 0.05 else 0"),
        # who is first at a ball that nobody holds: a few steps of "where is it when I am there" for him and for the nearest opponent
        *race(body, "own", "x", "y", f"{number(c.start)} + {{way}} / {pace}"),
        *race(body, "rival", "watched_x", "watched_y", f"max({{way}} - {feet}, 0) / {pace}"),
        Math("in_box", f"1 if {GOAL_X} < own_x and own_x < {BOX_X} and abs(own_y) < {BOX_Y} else 0"),
        *attacked(body, c),
        Math("loose", f"1 if in_box and not shot and own_time < rival_time + {number(c.dare)}{c.caution} else 0"),
        # where to meet a shot: at the point closest to him if he is there in time, else half-way on to the goal line, or at the line
        Math("along", "max(0, -(dx * ux + dy * uy))"),
        Math("to_deepest", f"max(0, (ball_x - {deepest}) * ball_speed / -ball_vx) if ball_vx < -0.2 else along"),
        Math("first", "min(along, to_deepest)"), Math("second", "0.5 * (first + to_deepest)"),
        *late(body, "first", c), *late(body, "second", c), *late(body, "to_deepest", c),
        Math("way", "first if late_first <= 0 else second if late_second <= 0 else to_deepest "
             "if late_to_deepest < min(late_first, late_second) else second if late_second < late_first else first"),
        Math("meet_x", f"ball_x + way * ux if shot else max(own_x, {deepest})"),
        Math("meet_y", "ball_y + way * uy if shot else own_y"),
        Math("way_distance", "hypot(meet_x - x, meet_y - y)"),
        Math("way_direction", "norm_deg(degrees(atan2(meet_y - y, meet_x - x)) - body) if way_distance > 0.01 else 0"),
        # is it coming: it crosses the goal line near the goal, and rolls that far
        Math("goal_y", f"ball_y + ball_vy / ball_vx * ({GOAL_X} - ball_x) if ball_vx < -0.2 else 99"),
        Math("to_line", f"(ball_x - {GOAL_X}) * ball_speed / -ball_vx if ball_vx < -0.2 else 999"),
        Math("shot", f"1 if abs(goal_y) < {number(round(body.server.goal_width / 2 + c.wide, 6))} and "
                     f"to_line < ball_speed / {number(body.roll)} + 1 and to_line < 40 and ball_x > {GOAL_X}{c.no_dribble} else 0"),
        Math("coming", "1 if shot or loose else 0"),
        Math("behind", f"1 if ball_x < {GOAL_X} - 0.5 else 0"),
        *guarding_place(c),
        Math("post_distance", "hypot(post_x - x, post_y - y)"),
        Math("post_direction", "norm_deg(degrees(atan2(post_y - y, post_x - x)) - body) if post_distance > 0.01 else 0"),
        Math("side_left", f"norm_deg(ball_angle - {number(c.side_on)} - body)"),
        Math("side_right", f"norm_deg(ball_angle + {number(c.side_on)} - body)"),
        Math("side_turn", "side_left if abs(side_left) < abs(side_right) else side_right"),
        Math("displaced", f"1 if post_distance > {number(c.displaced)} or abs(side_turn) > {number(c.turned)} else 0"),
        Math("flank", "norm_deg((60 if ball_y >= 0 else -60) - body)"),
        Math("hand_distance", HANDS[reflexes]),
        Math("at_hand", f"1 if hand_distance < {body.within(AT_HAND)} else 0"),
    )  # fmt: skip


TRANSITIONS = (
    Transition("open_eyes", ("shut",), ("eyes.begin",)),
    Transition("set_out", ("guard",), ("post.begin",)),
    Transition("be_there", ("post.in_place",), ("watching",), delay=1),
    # a cycle passes before he changes his mind, so that no reading can drive him round in circles within an instant
    Transition("give_way", ("post.aborted",), ("watching",)),
    Transition("alarm", outputs=("post.abort",), tests=("post.ongoing", "eyes.ball_coming"), inhibitors=("post.abort", "post.begin"),
               priority=3),
    Transition("seize", outputs=("post.abort",), tests={"post.ongoing": 1, "at_hand": 1}, inhibitors=("post.abort", "post.begin"),
               priority=3),
    Transition("leap", ("watching",), ("save.begin",), tests=("eyes.ball_coming",), priority=4),
    Transition("pick_up", ("watching",), ("away.begin",), tests={"at_hand": 1}, priority=2),
    Transition("follow", ("watching",), ("guard",), tests={"displaced": 1}, priority=1),
    Transition("hold", ("save.caught",), ("away.begin",)),
    Transition("calm_down", ("save.over",), ("guard",), delay=1),
    Transition("let_past", ("save.past",), ("guard",), delay=1),
    Transition("parry", ("save.missed",), ("away.begin",), tests={"at_hand": 1}, priority=1),
    Transition("drop", ("save.missed",), ("guard",), delay=1),
    Transition("break_off", ("save.aborted",), ("guard",), delay=1),
    Transition("cleared", ("away.cleared",), ("guard",)),
    Transition("stuck", ("away.failed",), ("guard",)),
    Transition("leave", ("away.aborted",), ("guard",)),
)  # fmt: skip
"""Watch, danger, catch, clear, reposition, and again (Fig. 2.30)."""


def goalie_net(
    seen: tuple[Any, ...], attended: int = ATTENDED, name: str = "goalie", body: Body = DEFAULT, constants: GoalieConstants = FIRST,
    reflexes: str = "hands", focus: bool = False,
) -> PetriNet:  # fmt: skip
    """The goalie's net.

    Parameters
    ----------
    seen : tuple of places
        ``ball_x``, ``ball_y``, ``ball_vx``, ``ball_vy``, and ``watched_x``, ``watched_y`` of the opponent nearest to the ball: belief
        places (`BELIEVED`), or inputs for a goalie without a model. With `AttackedConstants` also ``second_x``, ``second_y`` of the one
        of the others who is nearest to the goal.
    attended : int
        Opponents who are watched; 0 for a net without object places.
    name : str
    body : Body
    constants : GoalieConstants
        Numbers of his behaviour, fitted to what he knows.
    reflexes : str
        Of `HANDS`.
    focus : bool
        He narrows his view to the ball (`watch_ball`).
    """
    modules = {"eyes": watch_ball(body, focus), "post": reposition(body), "save": catch_ball(body, constants), "away": clear(body)}
    watch = tuple(
        ObjectPlace(f"watched_{k}", "Opponent", Selection("Opponent", best="opponent.danger", where="opponent.danger > 0", k=k))
        for k in range(1, attended + 1)
    )
    holder = Selection("Opponent", best="opponent.danger", where=f"opponent.ball_gap < {number(body.reach + AT_BALL)}")
    return PetriNet(
        name,
        places=(
            Place("shut", capacity=1, tokens=1), Place("guard", capacity=1, tokens=1), Place("watching", capacity=1),
            *seen, *watch, *((ObjectPlace("holder", "Opponent", holder),) if attended else ()),
            Input("x", observes="self.x"), Input("y", observes="self.y"), Input("body", observes="self.body_deg"),
            Input("own_vx", observes="self.vx"), Input("own_vy", observes="self.vy"),
            Input("seen_distance", observes="ball.distance"), Input("ball_age", observes="ball.age"),
            *kinematics(body, constants, reflexes),
        ),
        modules=modules,
        transitions=TRANSITIONS,
        # what the skills read is what is derived here
        fuse={"eyes.ball_direction": "ball_direction", "eyes.coming": "coming",
              **{f"{skill}.{p}": p for skill in ("save", "post") for p in modules[skill].ports.parameters},
              "away.ball_distance": "hand_distance", "away.flank": "flank"},
    )  # fmt: skip


FAR = 40.0
"""Where the nearest opponent is while none is watched, m."""
BALL = tuple(Belief(f"ball_{name}", variable=f"ball.{name}") for name in ("x", "y", "vx", "vy"))
BELIEVED = (*BALL, Belief("watched_x", variable="watched_1.x", value=FAR), Belief("watched_y", variable="watched_1.y"))
"""The ball, and the opponent nearest to it, as they are believed to be."""

REFLEX = (
    *(Belief(f"believed_{name}", variable=f"ball.{name}") for name in ("x", "y", "vx", "vy")),
    Input("placed", observes="ball.placed"), Input("moving", observes="ball.moving"),
    *(Input(f"read_{name}", observes=f"ball.{name}") for name in ("x", "y", "vx", "vy")),
    *(Math(f"ball_{name}", f"read_{name} if placed else believed_{name}") for name in ("x", "y")),
    *(Math(f"ball_{name}", f"read_{name} if moving else believed_{name}") for name in ("vx", "vy")),
    Belief("watched_x", variable="watched_1.x", value=FAR), Belief("watched_y", variable="watched_1.y"),
)  # fmt: skip
"""As `BELIEVED`, with reflexes: in a cycle in which the ball is seen the net acts on that reading, whenever inference comes to it."""

BALL_SEEN = tuple(
    Observe(f"ball.seen_{name}", f"ball.{name}", when=f"ball.{given}")
    for name, given in (("x", "placed"), ("y", "placed"), ("vx", "moving"), ("vy", "moving"))
)
"""What he is told of the ball."""


@functools.lru_cache(maxsize=64)
def goalie_cprm(
    opponents: int = 11, attended: int = ATTENDED, body: Body = DEFAULT, constants: GoalieConstants = FIRST,
    reflexes: str = "hands", focus: bool = False,
) -> CPRM:  # fmt: skip
    """The goalie's net, his beliefs, and the links between them.

    Parameters
    ----------
    opponents : int
        How many opponents there may be.
    attended : int
        How many of them are watched at most.
    body : Body
    constants : GoalieConstants
    reflexes : str
        Which inputs act in the same cycle, before any inference: of `HANDS`. With ``eye`` at least one opponent has to be watched.
    focus : bool
        As for `goalie_net`.

    Raises
    ------
    UnknownName
        For other reflexes.
    """
    if reflexes not in HANDS:
        raise unknown_name("reflexes", reflexes, HANDS)
    names = [f"o{k}" for k in range(1, opponents + 1)]
    watched = min(attended, opponents)
    if reflexes == "eye" and not watched:
        raise ParameterError(f"goalie: reflexes 'eye' go with opponents who are watched; of {opponents} opponents {attended} are")
    believed = REFLEX if reflexes == "eye" else BELIEVED
    seen = [
        Observe(f"{o}.seen_{percept}", f"{o}.{percept}", when=f"{o}.{given}")
        for o in names
        for percept, given in (("x", "seen"), ("y", "seen"), ("facing", "faced"))
    ]
    return CPRM(
        "goalie",
        net=goalie_net(
            believed if watched else (*BALL, Continuous("watched_x", FAR), Continuous("watched_y")),
            watched,
            body=body,
            constants=constants,
            reflexes=reflexes,
            focus=focus,
        ),
        model=goalie_model(body),
        objects={"ball": "Ball", **dict.fromkeys(names, "Opponent")},
        observations=(*BALL_SEEN, *seen),
        clusters=(
            *(Cluster("attendedOpponent", (f"watched_{k}",)) for k in range(1, watched + 1)),
            *((Cluster("possessesOpponent", ("holder", "=ball")),) if watched else ()),
        ),
    )


def goalie_percepts(observation: Observation, opponents: int = 11) -> PerceptTable:
    """What the goalie feels and sees, in the frame of his team's pitch (metres, degrees, m / cycle).

    Parameters
    ----------
    observation : dict of (N, ...) arrays
        With the part ``memory``.
    opponents : int

    Returns
    -------
    dict of (N,) float64
        `body_percepts`; ``self.x``, ``self.y``, ``self.body_deg``, ``self.vx``, ``self.vy``; ``game.stopped``; ``ball.seen``,
        ``ball.placed`` (he knew his place as well), ``ball.moving`` (its velocity was told too), ``ball.x``, ``ball.y``, ``ball.vx``,
        ``ball.vy``, ``ball.distance`` (from him), ``ball.age``; for each opponent ``o1.seen``, ``o1.x``, ``o1.y``, ``o1.faced`` (the way he
        faces was told: only of one who is seen with his number), ``o1.facing`` (index of `FACING`).
    """
    known = parts(observation, "body", "self", "level", "memory", "memory_age", "players")
    out = table(_columns(opponents), len(known[0]))
    kernels.guards(*known, opponents, GOAL_X, out.table)
    return out


@functools.lru_cache(maxsize=32)
def _columns(opponents: int) -> PerceptNames:
    return PerceptNames((*kernels.GOALIE, *(f"o{k + 1}.{part}" for k in range(opponents) for part in kernels.OPPONENT)))


def opponent_attributes(observation: Observation, opponents: int = 11) -> Mapping[str, Mapping[str, np.ndarray]]:
    """By what the goalie chooses whom to watch: attributes of the candidates of his object places.

    Returns
    -------
    dict of str to dict of str to (N, opponents) float64
        ``Opponent``: ``danger`` (the nearer to the ball the more, 0 for those not seen for two seconds), ``ball_gap`` (m).
    """
    memory, age = parts(observation, "memory", "memory_age")
    out = np.empty((2, len(memory), opponents))
    kernels.dangers(memory, age, opponents, *out)
    return {"Opponent": ObjectTable(kernels.ATTRIBUTES, out)}


CLUSTERS = (("ball.x", "ball.vx"), ("ball.y", "ball.vy"))
"""What a possession has linked stays linked within the ball only: its belief is projected on these pairs."""


class GoalieAgent(SoccerAgent):
    """The goalie as a controller.

    Parameters
    ----------
    opponents, attended : int
        As for `goalie_cprm`.
    body : Body
    constants : GoalieConstants
    reflexes, focus
        As for `goalie_cprm`.
    """

    def __init__(
        self, opponents: int = 11, attended: int = ATTENDED, body: Body = DEFAULT, constants: GoalieConstants = FIRST,
        reflexes: str = "hands", focus: bool = False, **options: Any,
    ) -> None:  # fmt: skip
        super().__init__(
            goalie_cprm(opponents, attended, body, constants, reflexes, focus),
            lambda observation: goalie_percepts(observation, opponents),
            needs=("memory",),
            objects=(lambda observation: opponent_attributes(observation, opponents)) if min(attended, opponents) else None,
            body=body,
            **{"engine": ProjectionEngine(CLUSTERS), **options},
        )


RECKONED = (
    *(Input(f"ball_{name}", observes=f"ball.{name}") for name in ("x", "y", "vx", "vy")),
    Input("watched_x", observes="rival.x", value=FAR), Input("watched_y", observes="rival.y"),
)  # fmt: skip
"""The ball as it is reckoned, and the opponent nearest to it, in the places of beliefs."""
SECOND = Input("second_x", observes="second.x", value=FAR), Input("second_y", observes="second.y")
"""The opponent to whom could be passed."""
HELD = Input("hold", observes="hands.now"), Input("hold_next", observes="hands.next")
"""How likely his hands are to take the ball (`cprm_gym.agents.knowledge.hands`)."""


@functools.lru_cache(maxsize=64)
def reckoning_cprm(body: Body = DEFAULT, constants: GoalieConstants = FIRST, focus: bool = False) -> CPRM:
    """The net alone, on what is reckoned instead of believed."""
    seen = (
        *RECKONED,
        *(SECOND if isinstance(constants, AttackedConstants) else ()),
        *(HELD if isinstance(constants, HoldingConstants) else ()),
    )
    net = goalie_net(seen, attended=0, name="goalie_memory", body=body, constants=constants, focus=focus)
    return CPRM("goalie_memory", net=net)


def certain_hands(percepts: Percepts, body: Body, constants: GoalieConstants) -> np.ndarray:
    """(N, 2) how likely the hands are to take a ball that is where it is reckoned to be.

    Certain or impossible now; later worth waiting for (2) as long as it comes deeper into them.
    """
    dx, dy, distance = percepts["ball.x"] - percepts["self.x"], percepts["ball.y"] - percepts["self.y"], percepts["ball.distance"]
    later = np.hypot(dx + percepts["ball.vx"] - percepts["self.vx"], dy + percepts["ball.vy"] - percepts["self.vy"])
    waits = (distance >= body.hands - constants.early) & (later <= distance - constants.deepening)
    return np.stack([distance < body.hands, 2.0 * waits], axis=1)


class ReckoningGoalie(SoccerAgent):
    """The goalie's net without a model, on the observation's part ``memory``, whoever fills it (`knowledge`).

    Parameters
    ----------
    opponents : int
    body : Body
    constants : GoalieConstants
    focus : bool
        As for `goalie_net`.
    """

    def __init__(self, opponents: int = 11, body: Body = DEFAULT, constants: GoalieConstants = FIRST, focus: bool = False) -> None:
        super().__init__(reckoning_cprm(body, constants, focus), self._read, needs=("memory",), body=body)
        self.opponents, self.constants = opponents, constants

    @property
    def holds(self) -> bool:
        """Whether he catches by how likely his hands are to take the ball."""
        return isinstance(self.constants, HoldingConstants)

    def _read(self, observation: Observation) -> Percepts:
        """`goalie_percepts`, the place of the opponent who is most dangerous, and of the other one who is nearest to the goal."""
        percepts = goalie_percepts(observation, self.opponents)
        if self.holds:
            told = observation["hands"] if "hands" in observation else certain_hands(percepts, self.body, self.constants)
            percepts["hands.now"], percepts["hands.next"] = np.asarray(told, np.float64).T
        danger = np.asarray(opponent_attributes(observation, self.opponents)["Opponent"]["danger"])
        nearest, rows = danger.argmax(axis=1), np.arange(len(danger))
        known = danger[rows, nearest] > 0
        memory = np.asarray(observation["memory"], np.float64)[rows, 12 + nearest]
        percepts["rival.x"] = np.where(known, memory[:, 0], FAR)
        percepts["rival.y"] = np.where(known, memory[:, 1], 0.0)
        others = np.asarray(observation["memory"], np.float64)[:, 12 : 12 + self.opponents]
        to_goal = np.where(danger > 0, np.hypot(others[..., 0] - GOAL_X, others[..., 1]), np.inf)
        to_goal[rows, nearest] = np.inf
        second = to_goal.argmin(axis=1)
        known = np.isfinite(to_goal[rows, second])
        percepts["second.x"] = np.where(known, others[rows, second, 0], FAR)
        percepts["second.y"] = np.where(known, others[rows, second, 1], 0.0)
        return percepts


GOALIE_NET = goalie_net(BELIEVED)
"""His net, with two opponents watched."""


def make_controller(task: Task, agent: str, **options: Any) -> GoalieAgent:
    """The goalie as a controller; options are those of `GoalieAgent` and `CPRMRunner`."""
    return GoalieAgent(task.right if agent.startswith("left") else task.left, body=Body.of(task), **options)
