"""The benchmark: tasks x controllers on the same worlds, with statistics that can be trusted."""

from .plan import Plan
from .registry import controller_entries, load_controller
from .report import Report, summarise
from .runner import play_block, run
from .statistics import Interval, wilson_interval

__all__ = ["Interval", "Plan", "Report", "controller_entries", "load_controller", "play_block", "run", "summarise", "wilson_interval"]
