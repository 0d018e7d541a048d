"""What the benchmarks of agents share."""

from __future__ import annotations

import time
from typing import Any


def timed(call: Any, total: list[float]) -> Any:
    """The call, its CPU time added to a total."""

    def run(*arguments: Any) -> Any:
        start = time.process_time()
        result = call(*arguments)
        total[0] += time.process_time() - start
        return result

    return run
