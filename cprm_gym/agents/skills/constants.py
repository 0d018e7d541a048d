"""Numbers of behaviours: thresholds that are nobody's parameters, fitted to what the player knows.

What is right depends on how well he knows things: who sees the shot late has to stand deeper. So such numbers are arguments of a net, and
are tuned for each tier of knowledge by one procedure (`cprm_gym.benchmark.tuning`), whose studies stand in ``cprm_gym/agents/studies``.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ...envs.players.stated import stated
from ...errors import ParameterError, unknown_name

if TYPE_CHECKING:
    from typing_extensions import Self

STUDIES = Path(__file__).parent.parent / "studies"
"""``{whose}/{tier}.jsonl``: the journal of a study, whose last line holds the numbers that it found."""


def between(default: float, low: float, high: float) -> Any:
    """A number and the extent in which it may be tuned."""
    return field(default=default, metadata={"extent": (low, high)})


@dataclass(frozen=True, kw_only=True)
class Constants:
    """Base of the numbers of a behaviour: fields made by `between`, whose defaults were set by hand.

    Attributes
    ----------
    whose : str
        The behaviour, and the folder of its studies.

    Raises
    ------
    ParameterError
        For a number outside its extent.
    """

    whose: ClassVar[str] = ""

    def __post_init__(self) -> None:
        for entry in fields(self):
            value, (low, high) = getattr(self, entry.name), entry.metadata["extent"]
            if isinstance(value, bool) or not isinstance(value, (int, float, np.number)) or not low <= value <= high:
                raise ParameterError(f"{self.whose}: {entry.name}: {value!r} given; allowed are numbers from {low:g} to {high:g}")

    @classmethod
    def of(cls, given: Mapping[str, Any]) -> Self:
        """Those that a mapping means; what is left out is the default.

        Raises
        ------
        ParameterError
            For a name that there is not.
        """
        return stated(cls, given, cls.whose, "constant")

    def to_dict(self) -> dict[str, float]:
        """Name -> number."""
        return asdict(self)

    @classmethod
    def extents(cls) -> dict[str, tuple[float, float]]:
        """Name -> least and largest value."""
        return {entry.name: entry.metadata["extent"] for entry in fields(cls)}

    @classmethod
    def studied(cls, study: str = "") -> tuple[str, ...]:
        """Tiers of knowledge for which there is a study, of this behaviour or in the folder `study`."""
        return tuple(sorted(path.stem for path in (STUDIES / (study or cls.whose)).glob("*.jsonl")))

    @classmethod
    def tuned(cls, tier: str, study: str = "") -> Self:
        """Those tuned for a tier of knowledge.

        Parameters
        ----------
        tier : str
        study : str
            Folder of another study than that of the behaviour.

        Raises
        ------
        UnknownName
            For a tier without a study; the message lists those with one.
        """
        known = cls.studied(study)
        if tier not in known:
            raise unknown_name(f"study of {study or cls.whose} for the tier", tier, known)
        return cls.of(last_mean(STUDIES / (study or cls.whose) / f"{tier}.jsonl"))


def last_mean(journal: Path) -> dict[str, float]:
    """The numbers that a study ends with."""
    mean: dict[str, float] = json.loads(journal.read_text(encoding="utf-8").splitlines()[-1])["mean"]
    return mean


@dataclass(frozen=True, kw_only=True)
class GoalieConstants(Constants):
    """Of the goalie."""

    whose: ClassVar[str] = "goalie"

    run: float = between(0.95, 0.6, 1.0)
    """Share of the top speed that a running player makes."""
    start: float = between(0.7, 0.0, 3.0)
    """Cycles that he loses by turning and getting up speed on the way to a free ball."""
    haste: float = between(1.0, -1.0, 3.0)
    """Cycles that he loses on the way to a shot."""
    at_feet: float = between(0.593, 0.0, 1.0)
    """Share of the kickable ring at which a player who runs to the ball has it."""
    dare: float = between(20.0, 0.0, 40.0)
    """Cycles by which an opponent may be nearer to a free ball for the goalie still to go for it."""
    deepest: float = between(0.5, 0.0, 2.0)
    """Metres in front of the goal line at which a shot is met at last."""
    wide: float = between(1.99, 0.0, 9.0)
    """Metres beside the post at which a ball that crosses the goal line still counts as a shot."""
    out_share: float = between(0.3, 0.1, 0.7)
    """Share of the ball's distance from the goal that the guarding place lies before it."""
    out_least: float = between(1.0, 0.2, 4.0)
    """Metres added to it, and the least."""
    out_most: float = between(8.0, 4.0, 14.0)
    """Metres that it lies before the goal at most."""
    side_on: float = between(80.0, 30.0, 110.0)
    """Degrees between body and ball while waiting."""
    displaced: float = between(1.0, 0.45, 3.0)
    """Metres from the guarding place at which he goes there again."""
    turned: float = between(30.0, 15.0, 70.0)
    """Degrees from side-on at which he turns again."""
    strafe: float = between(2.2, 0.5, 6.0)
    """Metres up to which he does not turn first."""
    ahead: float = between(40.0, 10.0, 90.0)
    """Degrees within which he runs on without turning."""
    worth: float = between(0.5, 0.2, 1.0)
    """Chance of a tackle that is worth the ten cycles on the ground, when the hands do not reach the ball."""
    close: float = between(0.12, 0.02, 0.6)
    """Metres from the ball's way at which he stands."""
    early: float = between(0.05, 0.0, 0.6)
    """Metres within the reach of his hands at which he catches at once."""
    deepening: float = between(0.15, -0.2, 0.6)
    """Metres by which the ball must come deeper into his hands in a cycle for him to wait for it."""

    @property
    def no_dribble(self) -> str:
        """What else makes a ball on its way a shot, in an expression; nothing here."""
        return ""

    @property
    def caution(self) -> str:
        """By what else the goalie's daring is changed, in an expression; nothing here."""
        return ""


@dataclass(frozen=True, kw_only=True)
class HoldingConstants(GoalieConstants):
    """Of the goalie who catches by how likely it is that his hands take the ball, instead of by where it is expected."""

    whose: ClassVar[str] = "goalie_holding"

    grip: float = between(0.1, 0.02, 0.99)
    """Probability of holding the ball from which he catches."""
    patience: float = between(0.1, -0.4, 0.4)
    """By how much likelier it has to be in the next cycle for him to wait."""


@dataclass(frozen=True, kw_only=True)
class AttackedConstants(GoalieConstants):
    """Of the goalie who faces several attackers: who can shoot, and who can be passed to."""

    whose: ClassVar[str] = "goalie_attacked"

    dare: float = between(4.0, -10.0, 40.0)
    """Cycles by which an opponent may be nearer to a free ball, or to the one that he dribbles, for the goalie still to go for it."""
    carry: float = between(5.0, 0.0, 12.0)
    """Cycles within which an opponent is at the ball so that it is a dribble instead of a shot."""
    touch: float = between(1.6, 0.8, 2.4)
    """m / cycle below which the ball can be one that is dribbled."""
    feared: float = between(20.0, 8.0, 40.0)
    """Metres from the goal within which one to whom could be passed is a threat; it is full 8 m nearer."""
    wary: float = between(0.3, 0.0, 1.0)
    """Share of his daring that the full threat takes."""
    lean: float = between(0.1, 0.0, 0.6)
    """Share by which the full threat moves the guarding place towards the way from there."""
    foresees: float = between(0.0, 0.0, 5.0)
    """Cycles on for which he guards where the ball will be."""

    @property
    def no_dribble(self) -> str:
        """A ball that is carried is no shot."""
        return " and carried < 1"

    @property
    def caution(self) -> str:
        """The threat of a pass takes some of the daring."""
        return f" - {self.wary * abs(self.dare):.10g} * threat"


@dataclass(frozen=True, kw_only=True)
class AttackedHoldingConstants(AttackedConstants, HoldingConstants):
    """Of the goalie who faces several attackers and catches by how likely he is to hold the ball."""

    whose: ClassVar[str] = "goalie_attacked_holding"


FIRST = GoalieConstants()
"""The goalie's, set by hand."""


@dataclass(frozen=True, kw_only=True)
class FinderConstants(Constants):
    """Of the player who finds a ball again; the defaults were set by hand."""

    whose: ClassVar[str] = "finder"

    run: float = between(0.9, 0.6, 1.0)
    """Share of the top speed that he makes."""
    start: float = between(1.0, 0.0, 4.0)
    """Cycles that he loses by turning and getting up speed."""
    lead: float = between(1.0, 0.0, 6.0)
    """Cycles for which the ball rolls on before he looks where it is then."""
    step: float = between(50.0, 20.0, 90.0)
    """Degrees from one look to the next, to either side of where it was expected."""
    reach: float = between(100.0, 60.0, 150.0)
    """Degrees from the body beyond which it turns so that the eyes get there."""
    blind: float = between(3.0, 1.0, 15.0)
    """Cycles without a sight of the ball after which the body turns for the eyes at all."""
    trust: float = between(15.0, 1.0, 40.0)
    """Cycles without a sight of the ball for which he runs on to where it is thought to be."""
    ahead: float = between(15.0, 5.0, 45.0)
    """Degrees within which he runs without turning."""
