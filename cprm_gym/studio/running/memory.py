"""What a player of a run remembers, as a value that can be put back."""

from __future__ import annotations

import copy
import types
from typing import Any, NamedTuple

import numpy as np

from ...agents.play import SoccerAgent
from ...architecture.cprm import CPRMRunner
from ...architecture.petri.execution.state import Snapshot
from ...envs.controller import Controller

BANK = ("_cohorts", "_cohort_of", "_position", "object_in", "_place_of", "impossible_count", "log_likelihood", "answers", "_answered_for")
"""What of a `FilterBank` changes from cycle to cycle."""
RUNNER = ("_percepts", "_seen", "_in_force", "_cycle")
"""What of a `CPRMRunner` does, beside net and beliefs."""
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


def can_keep(player: Controller) -> bool:
    """Whether all that a player remembers is known: he plays with a CPRM, and his percepts are functions of what he observes.

    Of others, only the beginning can be had again.
    """
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


def agent_in(player: Controller) -> SoccerAgent | None:
    """Who plays with a CPRM in a player, who may be one on a tier of knowledge; None for other kinds."""
    inner = player if isinstance(player, SoccerAgent) else getattr(player, "controller", None)
    return inner if isinstance(inner, SoccerAgent) else None


def runner_of(player: Controller) -> CPRMRunner | None:
    """What runs a player's net and model; None for players of other kinds."""
    agent = agent_in(player)
    return None if agent is None else agent.controller
