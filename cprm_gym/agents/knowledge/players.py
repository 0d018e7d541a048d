"""Who plays a task on any tier of knowledge, with which numbers: the one place where a task's player is registered.

The suite ``knowledge`` and the tuning read `PLAYERS`; a new entry is measured and can be tuned at once::

    "MyTask": Player(make_my_player, MyConstants)

where ``make_my_player(task, agent, constants)`` returns a controller that reads the parts `PARTS` of an observation, and ``MyConstants``
is a `Constants`, or is left out where there is nothing to tune. Its studies are the files ``cprm_gym/agents/studies/{whose}/{tier}.jsonl``,
and those in folders beside them for other senses (`studies`).

`DEFENDERS` are those of the other side, `TEAMS` whole teams: they can be tuned likewise, and are measured by pages of their own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ...envs.controller import Controller, ControllerFactory
from ...envs.players.senses import Senses
from ...envs.tasks import Task
from ...errors import unknown_name
from .. import striker
from ..attacker import agent as attacker
from ..attacker import half_field
from ..attacker.constants import AttackerConstants, HalfFieldConstants, PairConstants
from ..body import Body
from ..finder.agent import make_controller as finder
from ..goalie import ReckoningGoalie
from ..keeper import agent as keeper
from ..keeper.constants import KeeperConstants
from ..match import agent as match
from ..match import half_field as defence
from ..match.constants import MatchConstants
from ..skills.constants import (
    AttackedConstants,
    AttackedHoldingConstants,
    Constants,
    FinderConstants,
    GoalieConstants,
    HoldingConstants,
    last_mean,
)
from ..taker.agent import make_controller as taker
from ..taker.constants import TakerConstants
from .registry import OPTIONS, ORACLES, TIERS, informed
from .studies import Study, best_study, studies
from .tiers import Informed

RIVAL = "memory"
"""The tier that the others are compared with, and whose numbers a tier without a study plays with."""
LIKE = {"belief": "tracker", "foresight": "state"}
"""A tier without a study in these senses, or without any -> the one whose numbers it plays with, where that has one there: both are
filters that know the noise, or oracles."""
ANYWHERE = tuple(tier for tier in TIERS if tier != "bins")
"""Tiers that know every task; the bins are those of the goalie's model."""


@dataclass(frozen=True)
class Player:
    """Who plays a task.

    Parameters
    ----------
    make : callable
        (task, agent, constants) -> controller.
    constants : type of Constants, optional
        What his numbers are; without them he is the same on every tier.
    tiers : tuple of str
        Those that he can be put on.
    study : str
        Folder of the studies, if they are not those of the behaviour but of it in this task.
    seconds : float
        CPU time of 1000 episodes on `RIVAL`, about, from which a suite tells its own beforehand.
    options : mapping of str to object
        Fields of the task that differ where he is tuned and measured: how strong the others are.
    holding : type of Constants, optional
        What they are on a tier that tells of his hands (`registry.OPTIONS`), by whose distribution of the ball he then catches.
    seeds : int
        Over how many seeds a suite spreads his episodes: more than 1 where a seed draws what all its worlds share.
    """

    make: Callable[[Task, str, Any], Controller]
    constants: type[Constants] | None = None
    tiers: tuple[str, ...] = ANYWHERE
    study: str = ""
    seconds: float = 20.0
    options: Mapping[str, Any] = field(default_factory=dict)
    seeds: int = 1
    holding: type[Constants] | None = None

    def kind(self, tier: str) -> type[Constants] | None:
        """What his numbers on a tier are."""
        return self.constants if self.holding is None or OPTIONS.get(tier) != "hands" else self.holding

    def study_for(self, tier: str, senses: Senses | None = None) -> Study | None:
        """The study whose numbers he plays with on a tier, in senses (`studies.best_study`); None if there is none."""
        if self.constants is None:
            return None
        folder, senses = self.study or self.constants.whose, senses or Senses()
        there = {study.tier for study in studies(folder)}
        alike = there if tier in ORACLES else {study.tier for study in studies(folder) if study.senses == senses}
        if tier in LIKE and tier not in alike and (LIKE[tier] in alike or tier not in there):
            tier = LIKE[tier]
        return best_study(folder, tier, senses, RIVAL, tier in ORACLES)

    def origin(self, tier: str, senses: Senses | None = None) -> str:
        """Where his numbers on a tier come from: ``study TIER``, ``study TIER, other senses``, ``by hand``, ``none`` where he has none."""
        if self.constants is None:
            return "none"
        study = self.study_for(tier, senses)
        if study is None:
            return "by hand"
        elsewhere = study.senses != (senses or Senses()) and tier not in ORACLES
        return f"study {study.tier}{', other senses' if elsewhere else ''}"

    def numbers(self, tier: str, senses: Senses | None = None) -> Constants | None:
        """His numbers on a tier, in senses: of the study for it, else those set by hand."""
        kind, study = self.kind(tier), self.study_for(tier, senses)
        if kind is None:
            return None
        return kind() if study is None else kind.of(last_mean(study.path))

    def on(self, tier: str, senses: Senses | None = None, constants: Constants | None = None) -> Callable[[Task, str], Informed]:
        """A factory of controllers on a tier.

        Parameters
        ----------
        tier : str
        senses : Senses, optional
            What a tracker may know of the noise, and for which his numbers are looked up.
        constants : Constants, optional
            Other numbers than those of `numbers`.

        Raises
        ------
        UnknownName
            For a tier that he cannot be put on.
        """
        if tier not in self.tiers:
            raise unknown_name("tier", tier, self.tiers)
        numbers = self.numbers(tier, senses) if constants is None else constants
        make: ControllerFactory = lambda task, agent: self.make(task, agent, numbers)  # noqa: E731
        return informed(make, tier, senses)


def goalie(task: Task, agent: str, constants: GoalieConstants) -> ReckoningGoalie:
    """The goalie's net without a model."""
    return ReckoningGoalie(task.right if agent.startswith("left") else task.left, Body.of(task), constants)


PLAYERS: dict[str, Player] = {
    "Goalie": Player(goalie, GoalieConstants, tuple(TIERS), seconds=2.0, holding=HoldingConstants),
    "Goalie2v1": Player(goalie, AttackedConstants, tuple(TIERS), "goalie_2v1", seconds=2.5, holding=AttackedHoldingConstants),
    "Goalie3v2": Player(goalie, AttackedConstants, tuple(TIERS), "goalie_3v2", seconds=5.0, holding=AttackedHoldingConstants),
    "LostAndFound": Player(finder, FinderConstants, seconds=1.0),
    # at a kick-off the second field player of a side becomes of the first of the types that the seed has drawn
    "KickOffShot": Player(lambda task, agent, constants: striker.make_controller(task, agent), seconds=15.0, seeds=10),
    "KickOffShot2v2": Player(
        attacker.make_controller,
        AttackerConstants,
        study="attacker_kick_off",
        seconds=15.0,
        options={"others": ("medium", "weak")},
        seeds=10,
    ),
    **{
        task: Player(half_field.make_controller, HalfFieldConstants, study=half_field.STUDY.get(task, ""), seconds=seconds)
        for task, seconds in (
            ("HFO1v0", 3.0),
            ("HFO1v1", 3.5),
            ("HFO2v1", 6.0),
            ("HFO2v2", 15.0),
            ("HFO3v2", 20.0),
            ("HFO3v3", 35.0),
            ("HFO4v5", 60.0),
            ("FrontGoalEmptyGoal", 1.0),
            ("FrontGoalBlockedShot", 2.0),
            ("FrontGoalSupportOption", 4.0),
            ("FrontGoalPassingLane", 8.0),
            ("FrontGoalCompactDefense", 12.0),
        )
    },
    **{
        task: Player(keeper.make_controller, KeeperConstants, study=keeper.STUDY.get(task, "keepers"), seconds=seconds)
        for task, seconds in (("Keepaway3v2", 35.0), ("Keepaway4v3", 40.0), ("Keepaway5v4", 50.0))
    },
    **{
        task: Player(attacker.make_controller, PairConstants, study=PairConstants.whose, seconds=seconds, options=options)
        for task, seconds, options in (
            ("PassAndAdvance2v1", 20.0, {}),
            ("PassAndAdvance2v2", 22.0, {"others": ("hold", "weak")}),
            ("PassAndAdvance2v3", 25.0, {"others": ("hold", "weak")}),
        )
    },
}
"""Task -> its player, of the left side."""
DEFENDERS: dict[str, Player] = {
    **{task: Player(taker, TakerConstants, study=TakerConstants.whose) for task in ("Keepaway3v2", "Keepaway4v3", "Keepaway5v4")},
    **{
        task: Player(defence.make_controller, MatchConstants, study=defence.STUDY, options={"others": ("strong", "strong")})
        for task in ("HFO2v2", "HFO3v2", "HFO3v3", "HFO4v5")
    },
}
"""Task -> the player of the right side, where that does something else and has numbers of its own."""
TEAMS: dict[str, Player] = {
    "Soccer5v5": Player(
        match.make_controller, MatchConstants, study=MatchConstants.whose,
        options={"controlled": "left", "others": ("strong", "strong"), "max_cycles": 600},
    ),
}  # fmt: skip
"""Match -> the team of the left side, and over how many cycles it is tuned."""


def player_of(task: str, side: str = "left") -> Player:
    """The player registered for a side of a task.

    Raises
    ------
    UnknownName
        Listing the tasks that have one.
    """
    players = DEFENDERS if side == "right" else {**PLAYERS, **TEAMS}
    if side not in ("left", "right"):
        raise unknown_name("side", str(side), ("left", "right"))
    if task not in players:
        raise unknown_name("task with a player for tiers of knowledge" if side == "left" else "task with defenders", task, players)
    return players[task]
