"""The goalie as code."""

from __future__ import annotations

from ..behaviour.programs import Agent, Program


def legs(me: Agent) -> Program:
    """Take place and watch; save what comes, clear what lies at hand."""
    while True:
        if (yield from me.do("post", until="coming")) == "in_place":
            yield from me.wait()
            while not me("coming") and not me("at_hand") and not me("displaced"):
                yield
        caught = me("coming") and (yield from me.do("save")) == "caught"
        if caught or me("at_hand"):
            yield from me.do("away")
        yield from me.wait()


def eyes(me: Agent) -> Program:
    """On the ball."""
    return (yield from me.do("eyes"))


MAINS = legs, eyes
