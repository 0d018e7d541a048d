"""What a player of a run remembers, as a value that can be put back."""

from __future__ import annotations

import copy
import types
from typing import Any, NamedTuple

import numpy as np

from ...agents.knowledge.belief import BeliefTier
from ...agents.knowledge.scene.others import PlayersFilter
from ...agents.knowledge.scene.pose import PoseFilter
from ...agents.knowledge.tiers import Frozen, Informed, Memory
from ...agents.knowledge.tracker import Tracker
from ...agents.play import SoccerAgent, agent_in
from ...architecture.cprm import CPRMRunner
from ...architecture.petri.execution.state import Snapshot
from ...architecture.prm.inference.filter import Filter
from ...envs.controller import Controller

BANK = ("_cohorts", "_cohort_of", "_position", "object_in", "_place_of", "impossible_count", "log_likelihood", "answers", "_answered_for")
"""What of a `FilterBank` changes from cycle to cycle."""
RUNNER = ("_percepts", "_seen", "_in_force", "_cycle")
"""What of a `CPRMRunner` does, beside net and beliefs."""
TIERS = (Frozen, Memory, Tracker, BeliefTier)
"""Tiers of knowledge of which all that they remember is known."""
ROOM = ("_room", "_work", "_grounding", "_engine")
"""What of a tier is only worked in, or never changes."""
FIXED = ("controller", "cprm", "body", "options", "needs", "percepts", "objects")
"""What of a `SoccerAgent` does not."""


class Remembered(NamedTuple):
    """Of one player."""

    own: dict[str, Any]
    """The agent's own attributes."""
    net: Snapshot
    runner: dict[str, Any]
    bank: dict[str, Any] | None
    separate: tuple[list[Any], list[Any]] | None
    """States and answers of beliefs kept one by one."""
    tier: dict[str, Any] | None = None
    """Of one on a tier of knowledge: what that knows, and what was sent and told last."""


def can_keep(player: Controller) -> bool:
    """Whether all that a player remembers is known: he plays with a CPRM, and his percepts are functions of what he observes.

    Of others, only the beginning can be had again.
    """
    if isinstance(player, Informed):
        return type(player.tier) in TIERS and can_keep(player.controller)
    if not isinstance(player, SoccerAgent) or player.controller is None:
        return False
    bank, separate = player.controller.bank, player.controller.separate
    engines = [] if bank is None else [bank.settings.engine]
    engines += [] if separate is None else [one.engine for one in separate.filters]
    return all(e.divisible for e in engines) and all(f is None or _plain(f, player) for f in (player.percepts, player.objects))


def _plain(function: Any, player: SoccerAgent) -> bool:
    """A function that holds nothing but values, or a method of the player, whose attributes are kept."""
    if isinstance(function, types.MethodType):
        return function.__self__ is player
    if not isinstance(function, types.FunctionType):
        return False
    cells = [cell.cell_contents for cell in function.__closure__ or ()]
    return not any(isinstance(value, (list, dict, set, np.ndarray)) or callable(getattr(value, "reset", None)) for value in cells)


def keep(player: Controller) -> Remembered:
    """All that a player remembers, for whom `can_keep` says so."""
    if isinstance(player, Informed):
        return keep(player.controller)._replace(tier=_copied({"tier": player.tier, "_sent": player._sent, "known": player.known}))
    assert isinstance(player, SoccerAgent)
    runner = player.controller
    assert runner is not None
    separate = runner.separate
    return Remembered(
        {name: copy.copy(value) for name, value in vars(player).items() if name not in FIXED},
        runner.executor.snapshot(),
        _kept(runner, RUNNER),
        None if runner.bank is None else _kept(runner.bank, BANK),
        None if separate is None else ([one.state for one in separate.filters], list(separate.answers)),
    )


def put(player: Controller, kept: Remembered) -> None:
    """The player as he was."""
    if isinstance(player, Informed):
        assert kept.tier is not None
        for name, value in kept.tier.items():
            _put_back(player, name, value)
        put(player.controller, kept)
        return
    assert isinstance(player, SoccerAgent)
    runner = player.controller
    assert runner is not None
    for name, value in kept.own.items():
        setattr(player, name, copy.copy(value))
    runner.executor.restore(kept.net)
    _put(runner, kept.runner)
    if runner.bank is not None and kept.bank is not None:
        _put(runner.bank, kept.bank)
    if runner.separate is not None and kept.separate is not None:
        for one, state in zip(runner.separate.filters, kept.separate[0]):
            one.state = state
        runner.separate.answers[:] = kept.separate[1]


def _kept(owner: Any, names: tuple[str, ...]) -> dict[str, Any]:
    return {name: copy.copy(getattr(owner, name)) for name in names}


def _put(owner: Any, kept: dict[str, Any]) -> None:
    for name, value in kept.items():
        setattr(owner, name, copy.copy(value))


def _copied(value: Any) -> Any:
    """A value that stays as it is; of objects their attributes but those that are `ROOM`."""
    if isinstance(value, np.ndarray):
        return value.copy()
    if isinstance(value, Filter):
        return value.state
    if isinstance(value, (*TIERS, PoseFilter, PlayersFilter)):
        return {name: _copied(part) for name, part in vars(value).items() if name not in ROOM}
    if isinstance(value, (list, tuple)):
        parts = [_copied(part) for part in value]
        return type(value)(*parts) if hasattr(value, "_fields") else type(value)(parts)
    if isinstance(value, dict):
        return {name: _copied(part) for name, part in value.items()}
    return value


def _put_back(owner: Any, name: str, kept: Any) -> None:
    """An attribute as `_copied` has it."""
    now = getattr(owner, name)
    if isinstance(now, Filter):
        now.state = kept
    elif isinstance(now, (*TIERS, PoseFilter, PlayersFilter)):
        for part, value in kept.items():
            _put_back(now, part, value)
    else:
        setattr(owner, name, _copied(kept))


def runner_of(player: Controller) -> CPRMRunner | None:
    """What runs a player's net and model; None for players of other kinds."""
    agent = agent_in(player)
    return None if agent is None else agent.controller
