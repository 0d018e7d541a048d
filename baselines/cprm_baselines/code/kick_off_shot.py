"""The striker as code: read from top to bottom."""

from __future__ import annotations

from cprm_gym.agents.striker import AFTER_SHOT, COMING, FORGOTTEN, WAIT

from ..behaviour.programs import Agent, Program

COMES = f"approach >= {COMING} and ball_age < {FORGOTTEN}"


def legs(me: Agent) -> Program:
    """Kick-off, pass, run, receive, dribble, shoot; then fetch the ball and finish, for good."""
    yield from me.do("setup")
    passed = (yield from me.do("passing", raises=("passing.ongoing",))) == "passed"
    if passed and (yield from _await(me)) and (yield from me.do("receive")) == "received":
        yield from _attack(me)
    while True:
        yield from _find(me)
        if (yield from me.do("go")) == "at_ball":
            yield from _attack(me)


def _await(me: Agent) -> Program:
    """Run forward and wait there for the ball; whether it comes."""
    if (yield from me.do("advance", until=COMES)) == COMES:
        return COMES
    for _ in range(WAIT):
        if me(COMES):
            return COMES
        if me(f"ball_age >= {2 * FORGOTTEN}"):
            break
        yield from me.send("face") if me("off_axis >= 60") else me.wait()
    return ""


def _attack(me: Agent) -> Program:
    if (yield from me.do("dribble")) == "there" and (yield from me.do("shoot")) == "shot":
        yield from me.wait(AFTER_SHOT)
    return ""


def _find(me: Agent) -> Program:
    """Until the ball is in sight and ahead."""
    while not me(f"ball_age < {FORGOTTEN} and off_axis < 60"):
        yield from me.send("sweep" if me(f"ball_age >= {FORGOTTEN}") else "face")
    return ""


def eyes(me: Agent) -> Program:
    """On the ball, or on the team-mate."""
    while True:
        yield from me.send("look")


MAINS = legs, eyes
