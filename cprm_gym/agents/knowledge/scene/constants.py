"""Numbers of the scene's model that are neither the server's nor the senses'."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ...skills.constants import Constants, between


@dataclass(frozen=True, kw_only=True)
class PoseConstants(Constants):
    """Of the own pose."""

    whose: ClassVar[str] = "pose"

    slack: float = between(0.02, 0.001, 0.2)
    """m that a straight line may be off."""
    slanting: float = between(0.0005, 0.0, 0.01)
    """Share of the distance that it may."""
    straying: float = between(0.012, 0.001, 0.2)
    """m by which he goes elsewhere in a cycle than he feels."""
    bumped: float = between(0.3, 0.05, 1.0)
    """The same where he ran into something."""
    twisting: float = between(0.001, 0.0001, 0.1)
    """rad by which he turns otherwise than commanded, beside the server's noise."""
    surprise: float = between(7.0, 3.0, 50.0)
    """Nats for each reading below which what he believed is given up."""
    late: float = between(0.28, 0.01, 0.99)
    """Share of the looks of an asynchronous eye that show the world before the step."""
    spread: float = between(3.0, 0.5, 30.0)
    """m by which a first place is wrong."""
    turn: float = between(0.07, 0.01, 0.5)
    """rad by which a first face is wrong."""


@dataclass(frozen=True, kw_only=True)
class PlayerConstants(Constants):
    """Of mates and opponents; the defaults are the best of 120 draws around each other, by error and log density under six senses."""

    whose: ClassVar[str] = "others"

    still: float = between(0.008, 0.001, 0.2)
    """m / cycle by which the velocity of one who rests changes (standard deviation)."""
    steady: float = between(0.058, 0.001, 0.3)
    """The same of one who runs on."""
    keeps: float = between(0.982, 0.5, 1.0)
    """Share of his velocity that one who runs on keeps in a cycle."""
    sudden: float = between(0.15, 0.02, 0.6)
    """The same of one who starts, stops or turns."""
    holds: float = between(0.77, 0.0, 1.0)
    """Share of his velocity that he keeps then."""
    lasting: float = between(0.9, 0.5, 0.999)
    """Probability that a player goes on as he does."""
    jitter: float = between(0.0065, 0.001, 0.3)
    """m by which a cycle's way is another than his velocity says."""
    turning: float = between(0.3, 0.01, 2.0)
    """rad by which a body turns in a cycle."""
    placed: float = between(0.008, 0.001, 0.5)
    """m by which a reading is off, whatever its size."""
    turned: float = between(0.011, 0.01, 3.0)
    """Degrees by which a direction is off."""
    paced: float = between(0.004, 0.001, 0.2)
    """m / cycle by which a change is off."""
    seen: float = between(0.97, 0.5, 0.999)
    """Probability of seeing somebody who is in view."""
    speed: float = between(1.0, 0.05, 1.0)
    """m / cycle of one of whom nothing is known."""
    elsewhere: float = between(0.001, 1e-6, 0.2)
    """Probability that one whose number is told was not where he was believed to be."""
    fresh: float = between(0.07, 1e-6, 1.0)
    """That a nameless reading is of somebody who was not known."""
    stray: float = between(3e-05, 1e-9, 0.2)
    """That it is of nobody who can have caused it."""
    gate: float = between(40.0, 5.0, 200.0)
    """Squared distance, in deviations, beyond which nobody caused a reading."""
    soft: float = between(1.0, 0.0, 1.0)
    """1: all hypotheses count by their weight; 0: the likeliest alone."""
