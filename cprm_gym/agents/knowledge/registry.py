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

TIERS: dict[str, Callable[[Task, str, Senses], Tier]] = {
    "frozen": lambda task, agent, senses: Frozen(),
    "memory": lambda task, agent, senses: Memory(),
    "bins": lambda task, agent, senses: BinsTier(task, agent),
    "tracker": lambda task, agent, senses: Tracker(senses, Body.of(task)),
    "belief": lambda task, agent, senses: BeliefTier(senses, Body.of(task)),
    "state": lambda task, agent, senses: State(),
    "foresight": lambda task, agent, senses: Foresight(),
}
"""Name -> maker; the poorest first."""
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
        Of `Foresight` alone: ``ahead``.

    Raises
    ------
    UnknownName
        Listing the tiers there are.
    ParameterError
        For options that the tier does not have.
    """
    if name not in TIERS:
        raise unknown_name("tier", name, TIERS)
    if options and (name != Foresight.name or set(options) != {"ahead"}):
        raise ParameterError(f"tier {name!r}: options {', '.join(options)} given; only foresight has one, ahead")
    if senses is not None and not isinstance(senses, Senses):
        raise ParameterError(f"tier {name!r}: senses: {senses!r} given; Senses are needed")
    return Foresight(**options) if options else TIERS[name](task, agent, senses or Senses())


def informed(factory: ControllerFactory, tier: str, senses: Senses | None = None, **options: Any) -> Callable[[Task, str], Informed]:
    """A factory of the same controllers on a tier; of one that is on a tier already, with this one instead."""

    def make(task: Task, agent: str) -> Informed:
        made = factory(task, agent)
        controller = made.controller if isinstance(made, Informed) else made
        return Informed(controller, make_tier(tier, task, agent, senses, **options))

    return make
