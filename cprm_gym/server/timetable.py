"""When a server sends what: the ticks of its clock between one step and the next (specification/simulator.md 1.2)."""

from __future__ import annotations

import math
from enum import Enum
from typing import NamedTuple

from ..simulator.parameters import ServerParameters

TICK = 10
"""Milliseconds of a tick of the server's clock; a cycle that is no multiple of it is kept exactly, with shorter ticks."""
PATTERN = (3, 3, 2)
"""Looks of who sees asynchronously, in three cycles after each other, as the simulator counts them."""
LOOKS_A_PERIOD = 4
LAST = 2
"""Number of the last of the usual looks: it comes between the commands and the next step."""


class Task(Enum):
    """What is done in a tick, in this order."""

    BODIES = "sense_body, fullstate and what is heard"
    LOOK = "see, of those who see asynchronously"
    LOOK_IN_STEP = "see, of those who see synchronously"
    PICTURES = "see_global"


class Due(NamedTuple):
    """A task and its time."""

    offset: float
    """ms after the step, in real time."""
    task: Task
    number: int
    """Of the looks since the step: 0, 1, 2 ...; the last one of the usual ones is 2, be there three or two."""


class Timetable:
    """What is due after which step, by the parameters ``simulator_step``, ``sense_body_step``, ``send_step``, ``send_vi_step`` and
    ``synch_see_offset``, all of them times ``slow_down_factor``.

    Parameters
    ----------
    parameters : ServerParameters

    Attributes
    ----------
    cycle : int
        ms from step to step, in real time.
    usual : bool
        Asynchronous looks come as the simulator itself counts them: a period of one and a half cycles.
    """

    def __init__(self, parameters: ServerParameters) -> None:
        factor = parameters.slow_down_factor
        self.cycle = parameters.simulator_step * factor
        self._tick = math.gcd(TICK, self.cycle)
        self._bodies = parameters.sense_body_step * factor
        self._pictures = parameters.send_vi_step * factor
        self._look = parameters.send_step * factor / LOOKS_A_PERIOD
        self._in_step = min(self._rounded(parameters.synch_see_offset * factor), self.cycle)
        counts = tuple(len(self._instants(self._look, n)) for n in range(len(PATTERN)))
        self.usual = 2 * parameters.send_step == 3 * parameters.simulator_step and counts == PATTERN

    def _rounded(self, moment: float) -> int:
        """The first tick that is not before a moment."""
        return math.ceil(moment / self._tick) * self._tick

    def _instants(self, period: float, step: int) -> list[int]:
        """Ticks (ms after the step) from a step to the next in which a task of that period is due; several in one tick are done once."""
        begin, end = step * self.cycle, (step + 1) * self.cycle
        first = max(math.floor((begin - self._tick) / period), 0)
        last = math.ceil(end / period)
        found = (self._rounded(k * period) for k in range(first, last + 1))
        return sorted({moment - begin for moment in found if begin <= moment < end})

    def after(self, step: int) -> list[Due]:
        """Everything from the tick of a step, the how manieth there was, to before the next one."""
        due = [Due(offset, Task.BODIES, 0) for offset in self._instants(self._bodies, step)]
        looks = self._instants(self._look, step)
        due += [Due(offset, Task.LOOK, LAST if self.usual and n == len(looks) - 1 else n) for n, offset in enumerate(looks)]
        due += [Due(offset, Task.PICTURES, 0) for offset in self._instants(self._pictures, step)]
        due.append(Due(self._in_step, Task.LOOK_IN_STEP, 0))
        order = list(Task)
        return sorted(due, key=lambda entry: (entry.offset, order.index(entry.task)))
