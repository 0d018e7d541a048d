"""The suite ``chapter5``: what the dissertation argues of its rivals (§5.3), measured in nine experiments.

``cells`` say who plays what and how; ``players`` and ``conditions`` give the names their meaning; ``playing`` plays a cell, or finds a fact
out once (``facts``); ``experiments`` ask for cells and tell what they say; ``report`` writes it down.
"""

from __future__ import annotations

from .plan import Chapter5Plan
from .playing import play_cell
from .report.whole import Chapter5Report, summarise

__all__ = ["Chapter5Plan", "Chapter5Report", "play_cell", "summarise"]
