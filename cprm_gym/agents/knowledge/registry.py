"""Tiers of knowledge by name, and controllers on them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...envs.controller import ControllerFactory
from ...envs.players.senses import Senses
from ...envs.tasks import Task
from ...errors import ParameterError, unknown_name
from ..body import Body
from .belief import BeliefTier
from .bins import BinsTier
from .oracles import Foresight, State
from .tiers import Frozen, Informed, Memory, Tier
from .tracker import Tracker

TIERS: dict[str, Callable[..., Tier]] = {
    "frozen": lambda task, agent, senses: Frozen(),
    "memory": lambda task, agent, senses: Memory(),
    "bins": lambda task, agent, senses: BinsTier(task, agent),
    "tracker": lambda task, agent, senses: Tracker(senses, Body.of(task)),
    "belief": lambda task, agent, senses, hands=False: BeliefTier(senses, Body.of(task), hands=hands),
    "state": lambda task, agent, senses: State(),
    "foresight": lambda task, agent, senses, **options: Foresight(**options),
}
"""Name -> maker; the poorest first."""
OPTIONS = {"belief": "hands", "foresight": "ahead"}
"""Name -> the option that it has."""
ORACLES = ("state", "foresight")
"""Those that read the truth."""


def make_tier(name: str, task: Task, agent: str, senses: Senses | None = None, **options: Any) -> Tier:
    """The tier of that name.

    Parameters
    ----------
    name : str
    task : Task
    agent : str
    senses : Senses, optional
        What a tracker may know of the noise; the server's if not given.
    **options
        Those of `OPTIONS`: ``ahead`` of `Foresight`, ``hands`` of `BeliefTier`.

    Raises
    ------
    UnknownName
        Listing the tiers there are.
    ParameterError
        For options that the tier does not have.
    """
    if name not in TIERS:
        raise unknown_name("tier", name, TIERS)
    if options and list(options) != [OPTIONS.get(name)]:
        known = ", ".join(f"{tier} has {option}" for tier, option in OPTIONS.items())
        raise ParameterError(f"tier {name!r}: options {', '.join(options)} given; {known}, the others none")
    if senses is not None and not isinstance(senses, Senses):
        raise ParameterError(f"tier {name!r}: senses: {senses!r} given; Senses are needed")
    return TIERS[name](task, agent, senses or Senses(), **options)


def informed(factory: ControllerFactory, tier: str, senses: Senses | None = None, **options: Any) -> Callable[[Task, str], Informed]:
    """A factory of the same controllers on a tier; of one that is on a tier already, with this one instead.

    Who catches by how likely his hands are to take the ball (``holds``) is told so by a tier that has the option ``hands``.
    """

    def make(task: Task, agent: str) -> Informed:
        made = factory(task, agent)
        controller = made.controller if isinstance(made, Informed) else made
        told = {"hands": True} if OPTIONS.get(tier) == "hands" and getattr(controller, "holds", False) else {}
        return Informed(controller, make_tier(tier, task, agent, senses, **told, **options))

    return make
