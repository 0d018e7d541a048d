"""The suite ``demonstrations``: what a model that foresees is worth, against the best fair rivals, in pairs and beside the oracle."""

from .arms import ARMS, Arm
from .plan import DEMONSTRATIONS, Demonstration, DemonstrationPlan, play_block
from .report import DemonstrationReport, summarise
from .tuning import ArmSearch

__all__ = [
    "ARMS",
    "DEMONSTRATIONS",
    "Arm",
    "ArmSearch",
    "Demonstration",
    "DemonstrationPlan",
    "DemonstrationReport",
    "play_block",
    "summarise",
]
