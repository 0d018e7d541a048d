"""One of the passing pair as code."""

from __future__ import annotations

from cprm_gym.agents.passer import AFTER_SHOT, FORGOTTEN, IN_RANGE, ONSIDE, PATIENCE, UNCLAIMED, YIELD

from ..behaviour.programs import Agent, Program

LIES = "mine >= 0 and ball_speed < 0.3 and ball_age < 4 and not coming"


def legs(me: Agent) -> Program:
    """Whose ball is it? He who has it plays it on, the other one runs free."""
    yield from me.wait(4)
    has = False
    while True:
        if has:
            has = yield from _with_ball(me)
        elif me("mine >= 0"):
            has = (yield from me.do("go", until="his >= 3", lasting=YIELD)) == "at_ball" or (yield from _search(me))
        else:
            has = yield from _run_free(me)


def _with_ball(me: Agent) -> Program:
    """Shoot, or pass and run free; whether he has the ball afterwards."""
    for waited in range(PATIENCE + 1):
        if me("out_of_reach or his >= 0.3"):
            return (yield from _search(me))
        if me(f"goal_distance < {IN_RANGE}"):
            if (yield from me.do("shoot")) == "shot":
                yield from me.wait(AFTER_SHOT)
            return (yield from _search(me))
        if me(f"onside >= {ONSIDE}") or waited == PATIENCE:
            break
        yield
    if (yield from me.do("passing", raises=("passing.ongoing",))) == "passed":
        return (yield from _run_free(me))
    return (yield from _search(me))


def _run_free(me: Agent) -> Program:
    """Where a pass can be taken, until it comes; whether he has got it."""
    while True:
        end = yield from me.do("advance", until=f"coming or {LIES}", lasting=0)
        if me("coming"):
            break
        if end != "arrived" and not (yield from _lies_still(me)):
            continue
        if end != "arrived":
            return (yield from _search(me))
        while not me("coming or off_place >= 1.8"):
            if me(f"ball_age >= {2 * FORGOTTEN}") or (me(LIES) and (yield from _lies_still(me))):
                return (yield from _search(me))
            yield from me.send("face") if me("off_axis >= 60") else me.wait()
        if me("coming"):
            break
    return (yield from me.do("receive")) == "received" or (yield from _search(me))


def _lies_still(me: Agent) -> Program:
    """Whether the ball goes on lying about, unclaimed."""
    for _ in range(UNCLAIMED):
        if not me(LIES):
            return ""
        yield
    return LIES


def _search(me: Agent) -> Program:
    """Until the ball is in sight and ahead; he does not have it."""
    while not me(f"ball_age < {FORGOTTEN} and off_axis < 60"):
        yield from me.send("sweep" if me(f"ball_age >= {FORGOTTEN}") else "face")
    yield
    return ""


def eyes(me: Agent) -> Program:
    """On the ball, or on the team-mate."""
    while True:
        yield from me.send("look")


MAINS = legs, eyes
