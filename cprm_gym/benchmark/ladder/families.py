"""Who is on each ladder, and in which game they meet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ...envs.core import SoccerCore
from ...envs.tasks import Status, Task, make_task
from ...errors import unknown_name


def eased(share: int, strength: str = "strong") -> str:
    """A scripted player who acts in `share` of 100 cycles."""
    return f"eased:share={share}" if strength == "strong" else f"eased:strength={strength}:share={share}"


@dataclass(frozen=True)
class Family:
    """Tasks whose opponents are graded on one ladder.

    Attributes
    ----------
    name : str
    tasks : tuple of str
        For whose learners the ladder is.
    game : str
        Task in which the ratings are played.
    left, right : tuple of str
        Who is on the ladder of the left and the right side: names for the option ``others``.
    held_out : tuple of str
        Opponents of the side that learners meet, on the ladder for testing alone: to be left out of training.
    side : str
        The side of the opponents that learners meet, ``left`` or ``right``; both where the sides are alike (``either``).
    options : mapping
        Fields of the game that differ.
    """

    name: str
    tasks: tuple[str, ...]
    game: str
    left: tuple[str, ...]
    right: tuple[str, ...]
    held_out: tuple[str, ...]
    side: str = "right"
    options: Mapping[str, int] = field(default_factory=dict)

    @property
    def alike(self) -> bool:
        """Whether both sides have the same players and the same aim."""
        return self.side == "either"

    def task(self) -> Task:
        """The game."""
        return make_task(self.game, **self.options)

    def score(self, core: SoccerCore, status: np.ndarray) -> np.ndarray:
        """(W,) what the left side has of games that ended with `status`: 1 won, 0 lost, 0.5 drawn."""
        if self.alike:
            goals = core.sim.world["score"]
            return 0.5 + 0.5 * np.sign(goals[:, 0] - goals[:, 1])
        won = {"half_field": status == Status.GOAL, "goalie": status != Status.GOAL, "keepaway": status == Status.OUT_OF_TIME}[self.name]
        return won.astype(np.float64)


TEAMS = ("hold", "random", "knock", "weak", eased(20), eased(50), "medium", "mixing", "strong")
"""Whole sides, and attackers."""
DEFENDERS = ("hold", "random", "knock", eased(10), eased(20), eased(50), "weak", "medium", "strong")
"""Those who mix do so with the ball alone: as defenders they are the strong team."""
UNSEEN = (eased(35), eased(70), eased(60, "medium"))
"""Graded opponents that stay out of training."""

FAMILIES: dict[str, Family] = {
    family.name: family
    for family in (
        Family("soccer", ("Soccer", "Soccer5v5", "Soccer11v11"), "Soccer5v5", TEAMS, TEAMS, UNSEEN, "either", {"max_cycles": 1500}),
        Family(
            "half_field",
            ("HFO1v1", "HFO2v1", "HFO2v2", "HFO3v2", "HFO3v3", "HFO4v5", "FrontGoalBlockedShot", "FrontGoalSupportOption",
             "FrontGoalPassingLane", "FrontGoalCompactDefense", "KickOffShot2v2", "PassAndAdvance2v1", "PassAndAdvance2v2",
             "PassAndAdvance2v3"),
            "HFO2v2", ("weak", eased(50), "medium", "strong"), DEFENDERS, UNSEEN,
        ),
        Family("goalie", ("Goalie", "Goalie2v1", "Goalie3v2"), "Goalie2v1", ("hold", eased(25), eased(50), "strong"), TEAMS, UNSEEN),
        Family(
            "keepaway", ("Keepaway3v2", "Keepaway4v3", "Keepaway5v4"), "Keepaway3v2", ("keep_random", "keep_hold", "keep_hand"),
            ("hold", "random", "knock", eased(10), eased(20), eased(50), "weak", "medium", "take"), UNSEEN, "right", {"max_cycles": 100},
        ),
    )
}  # fmt: skip
"""By name. Keepers have won after 10 seconds."""


def family(name: str) -> Family:
    """The family of that name.

    Raises
    ------
    UnknownName
        Listing those there are.
    """
    if name not in FAMILIES:
        raise unknown_name("family of tasks", name, FAMILIES)
    return FAMILIES[name]
