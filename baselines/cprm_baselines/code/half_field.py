"""An attacker before the goal as code."""

from __future__ import annotations

from cprm_gym.agents.attacker.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.programs import Agent, Program


def legs(me: Agent) -> Program:
    """Who is first at the ball plays it, the others run free."""
    while True:
        if me("lost"):
            yield from me.send("sweep")
        elif me("reach"):
            yield from _play(me)
        elif me("chase"):
            if (yield from me.do("meet", until="lost or reach or not chase")) == "at_ball":
                yield from _play(me)
        elif me(f"off_place >= {OFF_PLACE}"):
            yield from me.do("walk", until="lost or reach or chase")
        else:
            yield from me.send("face") if me(f"off_axis >= {OFF_AXIS}") else me.wait()


def _play(me: Agent) -> Program:
    """Shoot, pass or push on."""
    return (yield from me.do("shoot" if me("can_shoot") else "give" if me("can_pass") else "push"))


def eyes(me: Agent) -> Program:
    """On the ball, and on the others."""
    while True:
        yield from me.send("look")


MAINS = legs, eyes
