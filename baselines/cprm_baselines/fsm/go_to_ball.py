"""Finite state machine: go_to_ball on raw observations, one state per world and no belief.

The same behaviour as the net `cprm_gym.agents.skills.go_to_ball`, written as people usually write it: a state variable, a
transition table, numbers read straight from the eye (dissertation 5.1).
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from cprm_gym.agents.body import DEFAULT, Body
from cprm_gym.agents.percepts import ball_percepts
from cprm_gym.agents.skills.go_to_ball import TIRED
from cprm_gym.envs.actions import scaled
from cprm_gym.envs.controller import Action, Observation, no_action
from cprm_gym.simulator.state import CommandKind


class State(IntEnum):
    """What the player is doing."""

    LOOK = 0
    """The ball is not in sight: turn and look again."""
    TURN = 1
    """The ball is in sight but not ahead: face it."""
    RUN = 2
    """The ball is ahead: dash."""


class GoToBallMachine:
    """LOOK, TURN and RUN; the ball is lost after two looks without it."""

    look_turn = 100.0
    """Degrees turned between two looks."""
    ahead = 12.0
    """Degrees within which the ball counts as ahead."""
    damping = 0.9
    """Share of the angle that is turned, against oscillation."""
    states = tuple(State.__members__)
    """Names of what it may be doing."""

    def __init__(self, body: Body = DEFAULT) -> None:
        self.inertia_moment = body.kind.inertia_moment
        self.moments = body.server.minmoment, body.server.maxmoment
        self.powers = body.dash(0.6), body.dash(1.0)
        self.tired = TIRED * body.server.stamina_max

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """All worlds that begin start looking."""
        count = len(observation["level"])
        if worlds is None:
            self.state = np.full(count, State.LOOK, np.int64)
            self.unseen = np.zeros(count, np.int64)
        else:
            self.state[worlds], self.unseen[worlds] = State.LOOK, 0

    def act(self, observation: Observation) -> Action:
        """One transition and one command per world."""
        ball = ball_percepts(observation)
        seen, fresh = ball["ball.seen"] > 0, ball["body.fresh"] > 0
        self.unseen = np.where(seen, 0, self.unseen + fresh)
        aligned = np.abs(ball["ball.direction_deg"]) <= self.ahead
        self.state = np.where(
            seen,
            np.where(aligned, State.RUN, State.TURN),
            np.where(self.unseen >= 2, State.LOOK, self.state),
        )
        action = no_action(len(seen))
        speed = ball["body.speed"]
        turn = np.where(self.state == State.TURN, self.damping * ball["ball.direction_deg"], self.look_turn)
        moment = np.clip(turn * (1.0 + self.inertia_moment * speed), *self.moments)
        # in blind cycles a turn would be a guess: TURN waits, LOOK waits for the eye, RUN runs on
        turning = ((self.state == State.TURN) & seen) | ((self.state == State.LOOK) & fresh)
        running = self.state == State.RUN
        power = np.where(ball["body.stamina"] > self.tired, self.powers[1], self.powers[0])
        action["type"] = np.where(running, CommandKind.DASH, np.where(turning, CommandKind.TURN, CommandKind.NONE))
        action["params"] = scaled(action["type"], np.where(running, power, np.where(turning, moment, 0.0)))
        return action
