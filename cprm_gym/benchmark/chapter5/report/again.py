"""What another seed says: which verdicts and which decided comparisons are the same."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Again:
    """What a second seed says.

    Attributes
    ----------
    seed : int
    episodes : str
        How much was played of it.
    verdicts : mapping of str to str
        Claim -> the verdict of the second seed, of the claims that both measured.
    hangs : tuple of str
        Claims whose verdict is another one.
    figures : mapping of str to str
        Of those, the figure of the second seed.
    compared : int
        Comparisons that both made.
    both : int
        Of these, decided by both the same way.
    neither : int
        Decided by neither.
    once : tuple of (str, str)
        Decided by one seed alone, in a sentence, and by which.
    against : tuple of str
        Decided by each another way, as the first seed says.
    """

    seed: int
    episodes: str
    verdicts: Mapping[str, str]
    hangs: tuple[str, ...]
    figures: Mapping[str, str]
    compared: int
    both: int
    neither: int
    once: tuple[tuple[str, str], ...]
    against: tuple[str, ...]

    @property
    def said(self) -> str:
        """In three sentences."""
        same = len(self.verdicts) - len(self.hangs)
        text = f"Seed {self.seed} gives the same verdict on {same} of the {len(self.verdicts)} claims that both seeds measured. "
        text += f"Of {self.compared} comparisons both decide {self.both} the same way and leave {self.neither} open; "
        text += f"{len(self.once)} are decided by one seed alone, {len(self.against)} by each another way. "
        return text + "Where a seed has fewer episodes it decides less."
