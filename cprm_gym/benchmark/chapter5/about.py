"""Where and with what a run was made."""

from __future__ import annotations

import os
import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = ("numpy", "numba", "scipy", "gymnasium", "pettingzoo", "py_trees")


def machine() -> dict[str, str]:
    """Versions, processor and system."""
    found = {"cprm_gym": _version("cprm-gym"), "python": platform.python_version()}
    found |= {name: _version(name) for name in PACKAGES}
    return {**found, "system": f"{platform.system()} {platform.machine()}", "processor": _processor(), "cores": str(os.cpu_count() or 0)}


def revision() -> str:
    """Version of the project and, where it lies in a checkout, its commit: ``0.1.0, 4e3d139``; with a plus where files are changed."""
    found, root = _version("cprm-gym"), Path(__file__).parents[3]
    if not (root / ".git").exists():
        return found
    command = ("git", "-C", str(root), "describe", "--always", "--dirty=+", "--exclude=*")
    try:
        said = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return found
    return f"{found}, {said}"


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
