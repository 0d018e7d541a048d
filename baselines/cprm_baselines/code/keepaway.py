"""A keeper as code."""

from __future__ import annotations

from cprm_gym.agents.keeper.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.programs import Agent, Program


def legs(me: Agent) -> Program:
    """Who is first at the ball keeps it or passes it on, the others get open."""
    while True:
        if me("lost"):
            yield from me.send("sweep")
        elif me("reach"):
            yield from _keep(me)
        elif me("chase"):
            if (yield from me.do("meet", until="lost or reach or not chase")) == "at_ball":
                yield from _keep(me)
        elif me(f"off_place >= {OFF_PLACE}"):
            if (yield from me.do("walk", until="lost or reach or chase")) == "arrived":
                yield from me.wait()
        else:
            yield from me.send("face") if me(f"off_axis >= {OFF_AXIS}") else me.wait()


def _keep(me: Agent) -> Program:
    """Pass, or keep it behind the body."""
    return (yield from me.do("give" if me("can_pass") else "shelter"))


def eyes(me: Agent) -> Program:
    """On the ball, and on the others."""
    while True:
        yield from me.send("look")


MAINS = legs, eyes
