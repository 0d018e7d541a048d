"""The finder as code: two programs at once."""

from __future__ import annotations

from ..behaviour.programs import Agent, Program


def legs(me: Agent) -> Program:
    """To where the ball can be met."""
    while True:
        yield from me.do("legs")
        yield from me.wait()


def eyes(me: Agent) -> Program:
    """Where the ball is expected."""
    return (yield from me.do("eyes"))


MAINS = legs, eyes
