"""Where and with what a run was made."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version

PACKAGES = ("numpy", "numba", "scipy", "gymnasium", "pettingzoo", "py_trees")


def machine() -> dict[str, str]:
    """Versions, processor and system."""
    found = {"cprm_gym": _version("cprm-gym"), "python": platform.python_version()}
    found |= {name: _version(name) for name in PACKAGES}
    return {**found, "system": f"{platform.system()} {platform.machine()}", "processor": _processor(), "cores": str(os.cpu_count() or 0)}


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8", errors="replace") as file:
            for line in file:
                if line.startswith("model name"):
                    return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or "unknown"
