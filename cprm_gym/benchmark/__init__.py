"""The benchmark: tasks x controllers on the same worlds, with statistics that can be trusted."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..lazy import lazy_face

if TYPE_CHECKING:
    from .plan import Plan as Plan
    from .report import Report as Report
    from .report import summarise as summarise
    from .runner import play_block as play_block
    from .runner import run as run
    from .statistics import Interval as Interval
    from .statistics import wilson_interval as wilson_interval
else:
    __all__, __getattr__, __dir__ = lazy_face(
        __name__,
        {
            "plan": "Plan",
            "report": "Report summarise",
            "runner": "play_block run",
            "statistics": "Interval wilson_interval",
        },
    )
