"""Keys pressed while a match is watched in a terminal."""

from __future__ import annotations

import contextlib
import select
import sys
from typing import Any


class Keys:
    """Reads single keys while its block lasts; none where there is no terminal."""

    def __init__(self) -> None:
        self._before: Any = None

    def __enter__(self) -> Keys:
        with contextlib.suppress(Exception):
            import termios
            import tty

            self._before = termios.tcgetattr(sys.stdin)
            tty.setcbreak(sys.stdin.fileno())
        return self

    def __exit__(self, *_: object) -> None:
        if self._before is not None:
            import termios

            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, self._before)

    def pressed(self, seconds: float) -> str:
        """The key pressed within so many seconds, or nothing."""
        if self._before is None:
            import time

            time.sleep(seconds)
            return ""
        if select.select([sys.stdin], [], [], seconds)[0]:
            return sys.stdin.read(1)
        return ""


class Pace:
    """How fast a match is shown: space pauses, ``+`` and ``-`` change the speed, ``q`` ends.

    Parameters
    ----------
    speed : float
        Times the speed of the game, 10 cycles a second.
    """

    SLOWEST, FASTEST = 1 / 16, 64.0

    def __init__(self, speed: float = 1.0) -> None:
        self.speed, self.paused, self.ended = speed, False, False

    def press(self, key: str) -> None:
        """Act on a key."""
        if key == " ":
            self.paused = not self.paused
        elif key == "q":
            self.ended = True
        elif key in ("+", "-"):
            self.speed = min(max(self.speed * (2.0 if key == "+" else 0.5), self.SLOWEST), self.FASTEST)

    @property
    def seconds(self) -> float:
        """Between two cycles."""
        return 0.1 / self.speed
