"""Tiers of knowledge: what a player knows of the pitch, apart from what he does with it."""

from .registry import ORACLES, TIERS, informed, make_tier
from .tiers import Informed, Tier

__all__ = ["ORACLES", "TIERS", "Informed", "Tier", "informed", "make_tier"]
