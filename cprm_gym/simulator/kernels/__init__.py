"""The compiled half of the simulator: functions over one `WORLD` record ``w`` and one `PARAMETERS` record ``p``.

Kernels compute, objects remember: a kernel changes the record in place or returns scalars. It allocates nothing, checks no
arguments and draws only from the counter-based streams of `random`. All kernels share one decorator, so that editing any of
them compiles all of them again (see `cprm_gym.compilation`).
"""

from __future__ import annotations

from pathlib import Path

from cprm_gym.compilation import kernel_group

_simulator = Path(__file__).parent.parent

kernel = kernel_group(
    Path(__file__).parent,
    *(_simulator / name for name in ("state.py", "parameters.py", "player_types.py", "landmarks.py")),
)
"""``numba.njit`` with the package's flags and a cache keyed by every file that the kernels depend on."""
