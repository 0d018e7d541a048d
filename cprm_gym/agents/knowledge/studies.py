"""The studies that there are: for which tier of knowledge, and in which senses, a player's numbers were tuned."""

from __future__ import annotations

import json
from pathlib import Path
from typing import NamedTuple

from ...envs.players.senses import Senses
from ..skills import constants


class Study(NamedTuple):
    """A journal in ``cprm_gym/agents/studies/{player}``, or in a folder of it for other senses."""

    tier: str
    senses: Senses
    """In which it was made."""
    path: Path


def studies(player: str) -> tuple[Study, ...]:
    """A player's; those in his own folder come first.

    Parameters
    ----------
    player : str
        The folder.
    """
    folder = constants.STUDIES / player
    paths = sorted(folder.glob("*.jsonl")) + sorted(folder.glob("*/*.jsonl"))
    return tuple(Study(path.stem, _senses(path), path) for path in paths)


def _senses(path: Path) -> Senses:
    with path.open(encoding="utf-8") as file:
        return Senses.of(json.loads(file.readline()).get("senses", {}))


def best_study(player: str, tier: str, senses: Senses, rival: str, blind: bool) -> Study | None:
    """The study whose numbers are played with: the tier's in these senses, the rival's in these, then the same of other senses.

    Parameters
    ----------
    player : str
        The folder.
    tier : str
    senses : Senses
    rival : str
        The tier whose numbers one without a study plays with.
    blind : bool
        Whether the senses do not matter to the tier.
    """
    found = studies(player)
    alike = [study for study in found if study.senses == senses]
    for group, name in ((alike, tier), (found if blind else (), tier), (alike, rival), (found, tier), (found, rival)):
        for study in group:
            if study.tier == name:
                return study
    return None
