"""The attacker's numbers: what is nobody's parameter, tuned for a tier of knowledge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..skills.constants import Constants, between


@dataclass(frozen=True, kw_only=True)
class AttackerConstants(Constants):
    """Of the attacker; the defaults were set by hand."""

    whose: ClassVar[str] = "attacker"

    run: float = between(0.92, 0.7, 1.0)
    """Share of the top speed that he and his team-mate make on the way to the ball."""
    start: float = between(0.6, 0.0, 3.0)
    """Cycles that he loses by getting up speed."""
    mate_start: float = between(2.5, 0.0, 6.0)
    """Cycles after which a team-mate runs for a pass."""
    rival_run: float = between(0.92, 0.5, 1.0)
    """Share of the top speed that opponents make."""
    rival_start: float = between(1.0, 0.0, 4.0)
    """Cycles that an opponent loses by turning and getting up speed."""
    rival_turn: float = between(1.2, 0.0, 2.0)
    """Cycles that he loses more when he must turn by a right angle."""
    carried: float = between(0.6, 0.0, 1.5)
    """Cycles for which his motion carries him on whatever he wants."""
    rival_reach: float = between(1.0, 0.3, 2.0)
    """Metres within which an opponent has the ball."""
    keeper_reach: float = between(1.3, 0.3, 2.5)
    """The same of the keeper."""
    wander: float = between(0.2, 0.0, 1.0)
    """Metres that an opponent may have gone for each cycle since he was seen."""
    hold: float = between(2.5, 0.0, 6.0)
    """Cycles that he or his team-mate needs to play on a ball that he has met; whole ones count."""
    safe: float = between(1.0, -1.0, 3.0)
    """Metres of room below which a push or pass is in danger."""
    enough: float = between(4.0, 1.0, 10.0)
    """Metres of room beyond which more is worth nothing."""
    progress: float = between(6.0, 0.5, 12.0)
    """What a metre towards the goal in each cycle is worth, in metres of room."""
    soft: float = between(0.3, 0.0, 2.0)
    """What a pass loses for each m / cycle with which it arrives."""
    bias: float = between(0.5, -3.0, 4.0)
    """What a pass must be worth more than a push, when enough have been made."""
    first: float = between(0.5, -2.0, 4.0)
    """Room that a pass must have while passes are still to be made."""
    spread: float = between(0.08, 0.0, 0.2)
    """Metres by which a shot may go astray on each metre of its way."""
    corner: float = between(2.0, 0.0, 5.0)
    """Metres of room that each metre costs by which it may go past the post."""
    still: float = between(0.5, 0.0, 2.0)
    """What a push is worth less that leaves the ball where it is."""
    closer: float = between(0.02, 0.0, 0.4)
    """Metres of room that a metre of the way to the goal costs."""
    shot_room: float = between(-1.0, -5.0, 3.0)
    """Room, less both, that a shot must have."""
    pressed: float = between(3.0, -10.0, 3.0)
    """The same where every push is in danger, if that is less."""
    shot_far: float = between(30.0, 10.0, 32.0)
    """Metres from the goal from which he shoots."""
    shot_near: float = between(8.0, 2.0, 16.0)
    """Metres from the goal within which he shoots in any case."""
    ahead: float = between(2.0, -8.0, 12.0)
    """Metres ahead of the ball that a place to wait for a pass is looked for."""
    apart: float = between(13.0, 6.0, 22.0)
    """Metres beside it."""
    lazy: float = between(0.02, 0.0, 0.1)
    """Metres of room that a metre of the way to another place to wait costs."""
    yielding: float = between(1.0, 0.0, 6.0)
    """Cycles by which the team-mate must be nearer to the ball to leave it to him."""
    tolerance: float = between(0.1, 0.0, 1.0)
    """Metres that somebody may seem to be off the ball who has it."""
    stale: float = between(6.0, 2.0, 30.0)
    """Cycles without a sight of somebody after which he is looked at."""
    trust: float = between(3.0, 1.0, 15.0)
    """Cycles without a sight of the ball for which one in reach is taken to be there."""
    focus: float = between(15.0, 0.0, 60.0)
    """Metres from the ball within which he looks at it with the narrow cone, which sees every cycle."""


@dataclass(frozen=True, kw_only=True)
class HalfFieldConstants(AttackerConstants):
    """Of the attacker before the goal, where who waits for a safe shot loses the ball; the defaults were set by hand."""

    whose: ClassVar[str] = "attacker_half_field"

    rival_turn: float = between(0.7, 0.0, 2.0)
    """Cycles that an opponent loses more when he must turn by a right angle."""
    safe: float = between(0.6, -1.0, 3.0)
    """Metres of room below which a push or pass is in danger."""
    progress: float = between(4.0, 0.5, 12.0)
    """What a metre towards the goal in each cycle is worth, in metres of room."""
    closer: float = between(0.1, 0.0, 0.4)
    """Metres of room that a metre of the way to the goal costs."""
    shot_far: float = between(22.0, 10.0, 32.0)
    """Metres from the goal from which he shoots."""
    hold: float = between(0.5, 0.0, 6.0)
    """Cycles that he or his team-mate needs to play on a ball that he has met; whole ones count."""
    shot_room: float = between(-4.0, -8.0, 3.0)
    """Room, less both, that a shot must have."""


@dataclass(frozen=True, kw_only=True)
class PairConstants(AttackerConstants):
    """Of one of two who pass the ball through a defence without a keeper; the defaults were set by hand."""

    whose: ClassVar[str] = "attacker_pair"

    pressed: float = between(-7.0, -10.0, 3.0)
    """Room, less both, that a shot must have where every push is in danger."""
