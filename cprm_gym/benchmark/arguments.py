"""Arguments of the commands that measure."""

from __future__ import annotations

import argparse
from collections.abc import Callable


def at_least(low: int) -> Callable[[str], int]:
    """A type for `argparse`: a whole number from `low`; anything else is refused in one line."""

    def read(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = low - 1
        if value < low:
            raise argparse.ArgumentTypeError(f"{text!r} given; allowed are whole numbers of at least {low}")
        return value

    return read
