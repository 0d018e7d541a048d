"""Install the package as a user would, under other Pythons and at the oldest versions that it declares, and try it there.

    python scripts/installations.py                    every Python of PYTHONS that is on the path, and the oldest versions
    python scripts/installations.py minimum 3.12       only these

Each installation has a virtual environment of its own, which is removed afterwards. `minimum` takes the oldest Python there is and turns
every ``>=`` of pyproject.toml into ``==`` (but for the extras `rl`, whose torch comes from a pinned wheel, `dev` and `docs`). Exit status 1
when one of them fails, 2 when a Python that was named is not there.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import tomllib

ROOT = Path(__file__).resolve().parents[1]
PYTHONS = ("3.10", "3.11", "3.12", "3.13")
TESTS = (
    "tests/end_to_end/test_readme.py", "tests/architecture/petri", "tests/architecture/prm/model", "tests/architecture/analysis/structure",
    "tests/envs/test_go_to_ball.py", "tests/simulator/test_motion.py", "tests/test_compilation.py",
)  # fmt: skip


def interpreter(version: str) -> str | None:
    """Path of that Python, if it is there and starts."""
    path = shutil.which(f"python{version}")
    if path is None or subprocess.run([path, "-c", ""], capture_output=True).returncode:
        return None
    return path


def minimum_versions() -> list[str]:
    """The oldest version of each dependency and of the extra `render`, as constraints."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    declared = project["dependencies"] + project["optional-dependencies"]["render"]
    return [re.sub(r">=([^,]+).*", r"==\1", requirement) for requirement in declared]


def try_installation(python: str, constraints: Path) -> bool:
    """Install with these constraints into a new environment and run the tests of `TESTS` and a benchmark there."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([python, "-m", "venv", folder], check=True)
        program = Path(folder) / ("Scripts" if sys.platform == "win32" else "bin")
        pip = [str(program / "python"), "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-c", str(constraints)]
        steps = [
            [*pip, f"{ROOT}[render]", "pytest", "hypothesis", "snakes"],
            [str(program / "python"), "-m", "pip", "check"],
            [str(program / "pytest"), "-q", *TESTS],
            [str(program / "cprm-gym"), "benchmark", "--episodes", "20", "--output", folder],
        ]
        return all(subprocess.run(step, cwd=ROOT).returncode == 0 for step in steps)


def main(wanted: list[str]) -> int:
    """Try the installations named, or all; a line for each."""
    known = ("minimum", *PYTHONS)
    if unknown := [name for name in wanted if name not in known]:
        print(f"unknown: {', '.join(unknown)}; allowed are {', '.join(known)}", file=sys.stderr)
        return 2
    found = {version: path for version in PYTHONS if (path := interpreter(version))}
    status = 0
    for name in wanted or [*found, "minimum"]:
        python = found.get(name) if name != "minimum" else next(iter(found.values()), None)
        if python is None:
            print(f"{name}: there is no such Python on the path", file=sys.stderr)
            return 2
        with tempfile.TemporaryDirectory() as folder:
            constraints = ROOT / "constraints.txt"
            if name == "minimum":
                constraints = Path(folder) / "minimum.txt"
                constraints.write_text("\n".join(minimum_versions()) + "\n", encoding="utf-8")
            ok = try_installation(python, constraints)
        print(f"installation {name}: {'passed' if ok else 'FAILED'}", flush=True)
        status |= not ok
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
