"""One of two who attack against a defence as code."""

from __future__ import annotations

from cprm_gym.agents.attacker.agent import OFF_AXIS, OFF_PLACE

from ..behaviour.programs import Agent, Program

_URGENT = "waiting or barred or lost or seeks or (reach and not offside)"


def legs(me: Agent) -> Program:
    """Who is first at the ball plays it, the other runs free."""
    while True:
        if me("waiting"):
            yield from me.do("setup")
            yield from me.wait()
        elif me("barred"):
            yield from me.send("stand")
        elif me("lost or seeks"):
            yield from me.send("sweep")
        elif me("reach and not offside"):
            yield from _play(me)
        elif me("chase"):
            if (yield from me.do("meet", until=f"{_URGENT} or not chase")) == "at_ball":
                yield from _play(me)
        elif me(f"off_place >= {OFF_PLACE}"):
            yield from me.do("walk", until=f"{_URGENT} or chase")
        else:
            yield from me.send("face") if me(f"off_axis >= {OFF_AXIS}") else me.wait()


def _play(me: Agent) -> Program:
    """Take a set play, shoot, pass or push on."""
    if me("ours or not may"):
        if me("ours"):
            yield from me.do("give")
        yield from me.wait()
        return ""
    return (yield from me.do("shoot" if me("can_shoot") else "give" if me("can_pass") else "push"))


def eyes(me: Agent) -> Program:
    """On the ball, and on the others."""
    while True:
        yield from me.send("look")


MAINS = legs, eyes
