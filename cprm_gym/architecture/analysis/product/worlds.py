"""What a net is put into."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import NamedTuple, Protocol


class Step(NamedTuple):
    """A next state and its chance: the likeliest value, and within which it lies."""

    state: Hashable
    chance: float
    low: float
    high: float


class World(Protocol):
    """A world of finitely many states that a net perceives and acts on.

    One that also says which places it `heeds` (a tuple of names) is told with the commands how many tokens these hold, ``"turns=2"``: where
    what comes next depends on how far the behaviour is.
    """

    def start(self) -> Sequence[tuple[Hashable, float]]:
        """States at the beginning and their probabilities."""
        ...

    def percepts(self, state: Hashable) -> Mapping[str, float]:
        """What the net observes in a state: a number for every quantity that its input places observe.

        Belief places are found here too, by their names: the belief is what is known of the state (§3.2.3, first way).
        """
        ...

    def next(self, state: Hashable, commands: tuple[str, ...]) -> Sequence[Step]:
        """Where the world goes when these commands go out; chances sum to one."""
        ...

    def ended(self, state: Hashable) -> str:
        """The outcome that this state is of the world's own, such as an accident; empty for none."""
        ...

    def name(self, state: Hashable) -> str:
        """What a state is called."""
        ...


def heeded(world: World) -> tuple[str, ...]:
    """Places of the net whose tokens a world is told of."""
    return tuple(getattr(world, "heeds", ()))
