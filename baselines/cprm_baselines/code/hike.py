"""The hiker as code: the next line remembers for him."""

from __future__ import annotations

from ..behaviour.programs import Agent, Program


def legs(me: Agent) -> Program:
    """Out, then home."""
    yield from me.do("out")
    while True:
        yield from me.do("home")
        yield from me.wait()


MAINS = (legs,)
