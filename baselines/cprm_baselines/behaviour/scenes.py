"""The scene of each task: what the agent who plays it knows and can, for whoever decides."""

from __future__ import annotations

from dataclasses import replace

from cprm_gym.agents.body import Body
from cprm_gym.agents.finder.agent import finder_net, finder_percepts
from cprm_gym.agents.goalie import ReckoningGoalie
from cprm_gym.agents.passer import AT_FEET, passer_net
from cprm_gym.agents.percepts import field_percepts, motion_percepts
from cprm_gym.agents.skills.constants import AttackedConstants, FinderConstants, GoalieConstants
from cprm_gym.agents.skills.dribble import NEAR
from cprm_gym.agents.skills.go_to_ball import AHEAD, CLOSE, LOOKS, go_to_ball_reflex
from cprm_gym.agents.skills.kick import SURE
from cprm_gym.agents.striker import striker_net
from cprm_gym.architecture.petri import Input, Math, PetriNet
from cprm_gym.envs.tasks import Task
from cprm_gym.errors import unknown_name

from .scene import Scene

_LOOK = {"look": ("look", {"direction": "gaze"}), "face": ("turn", {"moment": "face_moment"})}
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
    net = replace(net, places=(*net.places, Input("not_begun", observes="game.waiting"), Input("goal_distance", observes="goal.distance")))
    return Scene(
        net,
        field_percepts,
        quantities={
            "at_ball": f"1 if ball_distance < {body.within(SURE)} else 0", "goal_near": f"1 if goal_distance < {NEAR} else 0",
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


def _goalie(task: Task, agent: str) -> Scene:
    opponents = task.right if agent.startswith("left") else task.left
    if task.name == "Goalie":
        constants = GoalieConstants.tuned("memory")
    else:
        constants = AttackedConstants.tuned("memory", task.name.lower().replace("goalie", "goalie_"))
    whole = ReckoningGoalie(opponents, Body.of(task), constants)
    return Scene(whole.cprm.net, whole.percepts)


def _finder(task: Task, agent: str) -> Scene:
    return Scene(finder_net(Body.of(task), FinderConstants.tuned("memory")), finder_percepts)


SCENES = {
    "GoToBall": _seeker,
    "KickOffShot": _striker, "PassAndAdvance": _passer, "Goalie": _goalie, "Goalie2v1": _goalie, "Goalie3v2": _goalie,
    "LostAndFound": _finder,
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
