"""What an analysis may take: memory, markings, time; one clock for all that it does."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from pathlib import Path


def available_memory() -> int:
    """Bytes that this process may still use: what the system says is free, or what its container leaves; 4 GiB if neither says."""
    found = []
    try:
        for line in Path("/proc/meminfo").read_text().splitlines():
            if line.startswith("MemAvailable:"):
                found.append(int(line.split()[1]) * 1024)
    except (OSError, ValueError):
        pass
    try:
        limit = Path("/sys/fs/cgroup/memory.max").read_text().strip()
        used = int(Path("/sys/fs/cgroup/memory.current").read_text())
        if limit != "max":
            found.append(max(int(limit) - used, 0))
    except (OSError, ValueError):
        pass
    return min(found, default=4 * 1024**3)


class Clock:
    """When an analysis must end, and whether somebody interrupted it.

    Parameters
    ----------
    seconds : float
        From now.
    whole : Clock, optional
        The clock of which this is a part.
    """

    def __init__(self, seconds: float, whole: Clock | None = None) -> None:
        self.granted = seconds
        self.ends = time.monotonic() + seconds
        self.whole = whole
        self._interrupted = False

    def interrupt(self) -> None:
        """Remember that the user does not want to wait any longer; the whole hears of it too."""
        self._interrupted = True
        if self.whole is not None:
            self.whole.interrupt()

    @property
    def interrupted(self) -> bool:
        """Whether the user interrupted this or the whole."""
        return self._interrupted or (self.whole is not None and self.whole.interrupted)

    @property
    def left(self) -> float:
        """Seconds that are left."""
        return max(0.0, self.ends - time.monotonic())

    @property
    def reason(self) -> str:
        """Why to stop: ``"interrupted"``, ``"seconds"``, or nothing."""
        return "interrupted" if self.interrupted else "seconds" if time.monotonic() > self.ends else ""

    def spent(self) -> bool:
        """Whether to stop."""
        return bool(self.reason)


@dataclass(frozen=True)
class Budget:
    """Limits of an analysis: of all of it, where several things are found.

    Attributes
    ----------
    memory : int
        Bytes for markings, table and predecessors; by default half of what is available.
    states : int
        Markings; 2**31 at most.
    seconds : float
        Wall time.
    clock : Clock or None
        That is running already; by default one starts with the first use.
    """

    memory: int = field(default_factory=lambda: available_memory() // 2)
    states: int = 2**31 - 2
    seconds: float = float("inf")
    clock: Clock | None = None

    def start(self) -> tuple[Budget, Clock]:
        """This budget with its clock running, and the clock."""
        clock = self.clock or Clock(self.seconds)
        return (self if self.clock is clock else replace(self, clock=clock)), clock

    def part(self, share: float) -> Budget:
        """A share of the time that is left."""
        _, clock = self.start()
        return replace(self, clock=Clock(clock.left * share, clock))
