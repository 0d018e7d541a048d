"""The scene of each task: what the agent who plays it knows and can, for whoever decides."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from cprm_gym.agents.attacker import agent as attacker
from cprm_gym.agents.attacker import half_field
from cprm_gym.agents.body import Body
from cprm_gym.agents.finder.agent import finder_net, finder_percepts
from cprm_gym.agents.goalie import CLUSTERS, ReckoningGoalie, goalie_cprm, opponent_attributes, reckoning_cprm
from cprm_gym.agents.hiker.agent import WAY, hiker_net
from cprm_gym.agents.keeper.agent import make_controller as keeper
from cprm_gym.agents.knowledge.players import PLAYERS
from cprm_gym.agents.passer import AT_FEET, passer_net
from cprm_gym.agents.percepts import field_percepts, motion_percepts
from cprm_gym.agents.seeker import seeker_cprm
from cprm_gym.agents.skills.constants import FinderConstants, GoalieConstants
from cprm_gym.agents.skills.dribble import NEAR
from cprm_gym.agents.skills.go_to_ball import AHEAD, CLOSE, LOOKS, go_to_ball_reflex
from cprm_gym.agents.skills.kick import SURE
from cprm_gym.agents.striker import striker_net
from cprm_gym.agents.taker.agent import make_controller as taker
from cprm_gym.architecture.petri import Belief, Input, Math, PetriNet
from cprm_gym.architecture.prm.inference.engines.projection import ProjectionEngine
from cprm_gym.envs.tasks import Task
from cprm_gym.envs.tasks.half_field import LADDER
from cprm_gym.errors import unknown_name

from .believer import Believer
from .possession import Possession
from .scene import Scene

_LOOK: dict[str, tuple[str, dict[str, str | float]]] = {
    "look": ("look", {"direction": "gaze"}), "look at him": ("look", {"direction": "mate_direction"}),
    "face": ("turn", {"moment": "face_moment"}),
}  # fmt: skip
_RECKONED = {
    "ball_distance": "ball.reckoned_distance", "ball_direction": "ball.reckoned_direction_deg", "approach": "ball.approach",
    "vx": "ball.speed_ahead", "vy": "ball.speed_aside", "ball_x": "ball.x", "ball_y": "ball.y", "mate_x": "mate.x", "mate_y": "mate.y",
    "mate_direction": "mate.direction_deg",
}  # fmt: skip
"""What the passer believes -> what is reckoned."""


def _seeker(task: Task, agent: str) -> Scene:
    body = Body.of(task)
    net = PetriNet(
        "seeker",
        places=(
            Input("seen", observes="ball.seen"), Input("fresh", observes="body.fresh"), Input("age", observes="ball.age"),
            Input("speed", observes="body.speed"), Math("look_moment", body.turn("100")),
            Math("known", f"1 if age < {2 * LOOKS} else 0"),
        ),
        modules={"go": go_to_ball_reflex(body)},
    )  # fmt: skip
    return Scene(
        net,
        field_percepts,
        quantities={"aside": f"1 if go.off_axis >= {AHEAD} else 0"},
        orders={
            "dash": ("dash", {"power": "go.power", "direction": 0.0}), "turn": ("turn", {"moment": "go.moment"}),
            "search": ("turn", {"moment": "look_moment"}),
        },
    )  # fmt: skip


def _striker(task: Task, agent: str) -> Scene:
    body = Body.of(task)
    net = striker_net(body)
    more = {
        "not_begun": "game.waiting", "goal_distance": "goal.distance", "ball_x": "ball.x", "ball_y": "ball.y", "mate_x": "mate.x",
    }  # fmt: skip
    net = replace(net, places=(*net.places, *(Input(name, observes=observed) for name, observed in more.items())))
    return Scene(
        net,
        field_percepts,
        quantities={
            "at_ball": f"1 if ball_distance < {body.within(SURE)} else 0", "goal_near": f"1 if goal_distance < {NEAR} else 0",
            "mate_gap": "hypot(mate_x - ball_x, mate_y - ball_y)",
        },
        orders={**_LOOK, "sweep": ("turn", {"moment": "turn_moment"}), "stand": ("turn", {"moment": 0.0})},
    )  # fmt: skip


def _passer(task: Task, agent: str) -> Scene:
    body = Body.of(task)
    return Scene(
        passer_net(body=body),
        lambda observation: motion_percepts(observation, field_percepts(observation), body),
        instead=_RECKONED,
        without=("at_feet", "told", "ball_bearing", "across"),
        quantities={
            "out_of_reach": f"1 if ball_distance >= {body.reach + AT_FEET:.10g} else 0",
            "at_ball": f"1 if ball_distance < {body.within(CLOSE)} else 0",
        },
        orders={**_LOOK, "sweep": ("turn", {"moment": "search_moment"}), "stand": ("turn", {"moment": 0.0})},
    )


def _goalie_constants(task: Task) -> GoalieConstants:
    """His numbers, as they were tuned on his memory."""
    constants: Any = PLAYERS[task.name].numbers("memory")
    return constants


def _goalie(task: Task, agent: str) -> Scene:
    opponents = task.right if agent.startswith("left") else task.left
    whole = ReckoningGoalie(opponents, Body.of(task), _goalie_constants(task))
    return Scene(whole.cprm.net, whole.percepts)


def _finder(task: Task, agent: str) -> Scene:
    return Scene(finder_net(Body.of(task), FinderConstants.tuned("memory")), finder_percepts)


def believing_seeker(task: Task, agent: str) -> Scene:
    """The ball as it is believed to be, and how sure that is."""
    body = Body.of(task)
    views = (
        Belief("distance", variable="ball.dist"), Belief("bearing", variable="ball.dir_deg"),
        Belief("doubt", variable="ball.dir_deg", view="entropy"),
    )  # fmt: skip
    net = PetriNet(
        "seeker",
        places=(
            Input("believed_distance", observes="belief.distance"), Input("believed_bearing", observes="belief.bearing"),
            Input("doubt", observes="belief.doubt"), Input("speed", observes="body.speed"), Math("look_moment", body.turn("100")),
        ),
        modules={"go": go_to_ball_reflex(body)},
        fuse={"go.believed_distance": "believed_distance", "go.believed_direction": "believed_bearing"},
    )  # fmt: skip
    return Scene(
        net,
        field_percepts,
        orders={
            "dash": ("dash", {"power": "go.power", "direction": 0.0}), "turn": ("turn", {"moment": "go.moment"}),
            "search": ("turn", {"moment": "look_moment"}),
        },
        believer=Believer(seeker_cprm(body), views),
    )  # fmt: skip


def believing_goalie(task: Task, agent: str) -> Scene:
    """Ball and opponents as the goalie's model believes them to be, with the spread of the ball's place."""
    opponents = task.right if agent.startswith("left") else task.left
    body, constants = Body.of(task), _goalie_constants(task)
    whole = goalie_cprm(opponents, body=body)
    views = (*(p for p in whole.net.places if isinstance(p, Belief)), Belief("ball_doubt", variable="ball.y", view="variance"))
    net = reckoning_cprm(body, constants).net
    known = {"ball_x", "ball_y", "ball_vx", "ball_vy", "watched_x", "watched_y"}
    return Scene(
        replace(net, places=(*net.places, Input("ball_doubt", observes="belief.ball_doubt"))),
        ReckoningGoalie(opponents, body, constants).percepts,
        instead={name: f"belief.{name}" for name in known},
        believer=Believer(whole, views, lambda observation: opponent_attributes(observation, opponents), engine=ProjectionEngine(CLUSTERS)),
    )


def _hiker(task: Task, agent: str) -> Scene:
    return Scene(hiker_net(Body.of(task), getattr(task, "way", WAY)), field_percepts)


def _attacker(task: Task, agent: str) -> Scene:
    whole = half_field.make_controller(task, agent)
    return Scene(
        whole.cprm.net,
        whole.percepts,
        orders={
            "look": ("look", {"direction": "eyes"}), "face": ("turn", {"moment": "face_moment"}),
            "sweep": ("turn", {"moment": "search_moment"}),
        },
        memory=whole.motion,
        view="cone",
    )  # fmt: skip


def _combining(task: Task, agent: str) -> Scene:
    constants: Any = PLAYERS[task.name].numbers("memory")
    whole = attacker.make_controller(task, agent, constants)
    return Scene(
        whole.cprm.net,
        whole.percepts,
        orders={
            "look": ("look", {"direction": "eyes"}), "face": ("turn", {"moment": "face_moment"}),
            "sweep": ("turn", {"moment": "search_moment"}), "stand": ("turn", {"moment": 0.0}),
        },
        memory=whole.motion,
        view="cone",
        keeps=Possession(getattr(task, "passes", 0)),
    )  # fmt: skip


def _keeper(task: Task, agent: str) -> Scene:
    whole = keeper(task, agent)
    return Scene(
        whole.cprm.net,
        whole.percepts,
        orders={
            "look": ("look", {"direction": "eyes"}), "face": ("turn", {"moment": "face_moment"}),
            "sweep": ("turn", {"moment": "search_moment"}),
        },
        view="cone",
    )  # fmt: skip


def _taker(task: Task, agent: str) -> Scene:
    whole = taker(task, agent)
    return Scene(
        whole.cprm.net,
        whole.percepts,
        orders={
            "look": ("look", {"direction": "eyes"}), "face": ("turn", {"moment": "face_moment"}),
            "sweep": ("turn", {"moment": "search_moment"}), "tackle": ("tackle", {"direction": "out_direction", "foul": 0.0}),
        },
    )  # fmt: skip


def _keepaway(task: Task, agent: str) -> Scene:
    return (_taker if agent.startswith("right") else _keeper)(task, agent)


HALF_FIELD = ("HFO1v0", "HFO1v1", "HFO2v1", "HFO2v2", "HFO3v2", "HFO3v3", "HFO4v5")
DEFENDED = ("KickOffShot2v2", "PassAndAdvance2v1", "PassAndAdvance2v2", "PassAndAdvance2v3")
KEEPAWAY = ("Keepaway3v2", "Keepaway4v3", "Keepaway5v4")
SCENES = {
    "Hike": _hiker,
    "GoToBall": _seeker,
    "KickOffShot": _striker, "PassAndAdvance": _passer, "Goalie": _goalie, "Goalie2v1": _goalie, "Goalie3v2": _goalie,
    "LostAndFound": _finder,
    **dict.fromkeys((*HALF_FIELD, *LADDER), _attacker), **dict.fromkeys(KEEPAWAY, _keepaway), **dict.fromkeys(DEFENDED, _combining),
}  # fmt: skip
"""Task -> maker of its scene."""


def make_scene(task: Task, agent: str) -> Scene:
    """What the player of a task decides by and acts with.

    Raises
    ------
    UnknownName
        Listing the tasks that have one.
    """
    if task.name not in SCENES:
        raise unknown_name("task with a scene", task.name, SCENES)
    return SCENES[task.name](task, agent)
