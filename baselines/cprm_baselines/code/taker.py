"""A taker as code."""

from __future__ import annotations

from cprm_gym.agents.taker.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.programs import Agent, Program


def legs(me: Agent) -> Program:
    """Who is of the first at the ball kicks it out, the others cover."""
    while True:
        if me("lost"):
            yield from me.send("sweep")
        elif me("reach"):
            yield from me.do("oust")
        elif me("tackles"):
            yield from me.send("tackle")
        elif me("chase"):
            if (yield from me.do("meet", until="lost or reach or tackles or not chase")) == "at_ball":
                yield from me.do("oust")
        elif me(f"off_place >= {OFF_PLACE}"):
            if (yield from me.do("walk", until="lost or reach or tackles or chase")) == "arrived":
                yield from me.wait()
        else:
            yield from me.send("face") if me(f"off_axis >= {OFF_AXIS}") else me.wait()


def eyes(me: Agent) -> Program:
    """On the ball."""
    while True:
        yield from me.send("look")


MAINS = legs, eyes
