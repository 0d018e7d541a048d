"""Jobs that other processes find: they count, die, or raise."""

import os
from pathlib import Path

from cprm_gym.errors import ModelError


def square(k):
    return k * k


def dies_once(k, folder):
    """The process of job 2 ends at once, the first time."""
    mark = Path(folder) / "died"
    if k == 2 and not mark.exists():
        mark.touch()
        os._exit(1)
    return k * k


def dies(k):
    os._exit(1)


def raises(k):
    raise ModelError(f"job {k} is none")
