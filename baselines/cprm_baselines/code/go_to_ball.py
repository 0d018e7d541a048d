"""go_to_ball as code."""

from __future__ import annotations

from ..behaviour.programs import Agent, Program


def legs(me: Agent) -> Program:
    """Run, turn, look, or wait for the eye."""
    while True:
        if me("known and not aside"):
            yield from me.send("dash")
        elif me("seen"):
            yield from me.send("turn")
        elif me("fresh and not known"):
            yield from me.send("search")
        else:
            yield


MAINS = (legs,)
