"""Behaviour as code: a program for one agent, of generators that wait for the next cycle; several of them run at once."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence

from .scene import Scene
from .skill import Mask
from .worldwise import Moment

Program = Generator[None, None, str]
"""Waits where it yields, until the next cycle."""


class Agent:
    """One agent, as its programs see it."""

    def __init__(self, moment: Moment, world: int) -> None:
        self._moment, self._world = moment, world

    def __call__(self, text: str) -> bool:
        """Whether a condition over the scene's quantities holds now."""
        return self._moment.holds(text, self._world)

    def do(self, skill: str, until: str = "", lasting: int = 0, raises: Sequence[str] = ()) -> Program:
        """Work with a skill until it ends, or a condition has held (for `lasting` cycles more); what ended it.

        Returns
        -------
        str
            The outcome of the skill, or the condition.
        """
        for flag in raises:
            self._moment.flag(flag, self._world, 1.0)
        outcome, fresh, held = "", True, -1
        while not outcome:
            held = held + 1 if until and self(until) else -1
            if until and held >= lasting:
                outcome = until
            else:
                outcome = self._moment.run(skill, self._world, fresh)
                fresh = False
                if not outcome:
                    yield
        for flag in raises:
            self._moment.flag(flag, self._world, 0.0)
        return outcome

    def send(self, order: str) -> Program:
        """Send a command that is no skill, and wait for the next cycle."""
        self._moment.order(order, self._world)
        yield
        return order

    def wait(self, cycles: int = 1) -> Program:
        """Do nothing for so many cycles."""
        for _ in range(cycles):
            yield
        return ""


class Programs:
    """Programs that run at once, in each world its own.

    Parameters
    ----------
    scene : Scene
    mains : sequence of callables
        Agent -> program; each is begun again when it has returned.
    """

    def __init__(self, scene: Scene, mains: Sequence[Callable[[Agent], Program]]) -> None:
        self._moment, self._mains = Moment(scene), tuple(mains)

    @property
    def programs(self) -> tuple[Callable[[Agent], Program], ...]:
        """Those that run at once."""
        return self._mains

    def begin(self, worlds: int, seed: int) -> None:
        """All programs at their beginning."""
        self._agents = [Agent(self._moment, world) for world in range(worlds)]
        self._programs = [[main(agent) for main in self._mains] for agent in self._agents]

    def restart(self, worlds: Mask) -> None:
        """Those of some worlds at their beginning."""
        for world in worlds.nonzero()[0]:
            self._programs[world] = [main(self._agents[world]) for main in self._mains]

    def decide(self, scene: Scene) -> None:
        """Each goes on until it waits."""
        self._moment.open()
        for world, programs in enumerate(self._programs):
            for k, main in enumerate(self._mains):
                try:
                    next(programs[k])
                except StopIteration:
                    programs[k] = main(self._agents[world])
                    next(programs[k], None)
        self._moment.close()
