"""Behaviour tree: go_to_ball as conditions and actions under sequences and fallbacks, ticked once a cycle, in every world at once.

The same behaviour as the state machine (`fsm`), in the form that robots and games use most; it remembers nothing but how many looks in a
row did not show the ball.

    fallback
        sequence:  seen - ahead - dash
        sequence:  seen - face
        sequence:  searching - eye open - look round
        keep on
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from cprm_gym.agents.body import DEFAULT, Body
from cprm_gym.agents.percepts import ball_percepts
from cprm_gym.agents.skills.go_to_ball import AHEAD, DAMPING, LOOKS, TIRED
from cprm_gym.envs.actions import scaled
from cprm_gym.envs.controller import Action, Observation, no_action
from cprm_gym.envs.tasks import Task
from cprm_gym.errors import UnknownName
from cprm_gym.simulator.state import CommandKind

Node = Callable[["GoToBallTree", np.ndarray], np.ndarray]
"""Ticked in the worlds of a mask (N,); returns in which of them it succeeded."""


def sequence(*children: Node) -> Node:
    """Each child where those before it succeeded; succeeds where all do."""

    def tick(tree: GoToBallTree, worlds: np.ndarray) -> np.ndarray:
        for child in children:
            worlds = child(tree, worlds)
        return worlds

    return tick


def fallback(*children: Node) -> Node:
    """Each child where those before it failed; succeeds where one does."""

    def tick(tree: GoToBallTree, worlds: np.ndarray) -> np.ndarray:
        left = worlds
        for child in children:
            left = left & ~child(tree, left)
        return worlds & ~left

    return tick


def condition(holds: Callable[[Mapping[str, np.ndarray]], np.ndarray]) -> Node:
    """Succeeds where something holds of what he perceives."""
    return lambda tree, worlds: worlds & holds(tree.seen)


def command(kind: CommandKind, value: Callable[[GoToBallTree], np.ndarray]) -> Node:
    """Gives a command; succeeds at once."""

    def tick(tree: GoToBallTree, worlds: np.ndarray) -> np.ndarray:
        tree.action["type"][worlds] = kind
        tree.action["params"][worlds] = scaled(np.full(len(worlds), int(kind)), value(tree))[worlds]
        return worlds

    return tick


def dash_power(tree: GoToBallTree) -> np.ndarray:
    """All he has, as long as he is not tired."""
    return np.where(tree.seen["body.stamina"] > tree.tired, tree.powers[1], tree.powers[0])


def turn_by(tree: GoToBallTree, degrees: np.ndarray) -> np.ndarray:
    """The moment that turns him so far, at his speed."""
    return np.clip(degrees * (1.0 + tree.inertia_moment * tree.seen["body.speed"]), *tree.moments)


IN_SIGHT = condition(lambda seen: seen["ball.seen"] > 0)
ROOT = fallback(
    sequence(
        IN_SIGHT,
        condition(lambda seen: np.abs(seen["ball.direction_deg"]) <= AHEAD),
        command(CommandKind.DASH, dash_power),
    ),
    sequence(IN_SIGHT, command(CommandKind.TURN, lambda tree: turn_by(tree, DAMPING * tree.seen["ball.direction_deg"]))),
    sequence(
        lambda tree, worlds: worlds & (tree.unseen >= LOOKS),
        condition(lambda seen: seen["body.fresh"] > 0),
        command(CommandKind.TURN, lambda tree: turn_by(tree, np.full(len(tree.unseen), GoToBallTree.look_turn))),
    ),
    sequence(lambda tree, worlds: worlds & (tree.unseen < LOOKS) & tree.ran, command(CommandKind.DASH, dash_power)),
)
"""The tree."""


class GoToBallTree:
    """`ROOT` in N worlds, and the little that it remembers."""

    look_turn = 100.0
    """Degrees turned between two looks."""

    def __init__(self, body: Body = DEFAULT) -> None:
        self.inertia_moment = body.kind.inertia_moment
        self.moments = body.server.minmoment, body.server.maxmoment
        self.powers = body.dash(0.6), body.dash(1.0)
        self.tired = TIRED * body.server.stamina_max
        self.seen: Mapping[str, np.ndarray] = {}
        self.action: Action = {}

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Worlds that begin have not looked yet."""
        count = len(observation["level"])
        if worlds is None:
            self.unseen, self.ran = np.full(count, LOOKS), np.zeros(count, bool)
        else:
            self.unseen[worlds], self.ran[worlds] = LOOKS, False

    def act(self, observation: Observation) -> Action:
        """One tick."""
        self.seen = ball_percepts(observation)
        fresh = self.seen["body.fresh"] > 0
        self.unseen = np.where(self.seen["ball.seen"] > 0, 0, np.minimum(self.unseen + fresh, LOOKS))
        self.action = no_action(len(fresh))
        ROOT(self, np.ones(len(fresh), bool))
        self.ran = np.asarray(self.action["type"] == CommandKind.DASH)
        return self.action


def make_controller(task: Task, agent: str) -> GoToBallTree:
    """The tree for a task.

    Raises
    ------
    UnknownName
        For a task that it cannot play.
    """
    if task.name != "GoToBall":
        raise UnknownName(f"controller 'tree' cannot play task {task.name!r}; it plays GoToBall")
    return GoToBallTree(Body.of(task))
