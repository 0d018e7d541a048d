"""The notebooks run from top to bottom in a process of their own, and are kept without outputs."""

import json
import subprocess
import sys

import pytest
from paths import ROOT

NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))
RUN = """
import json, sys
cells = [cell for cell in json.load(open(sys.argv[1], encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
told = {}
for cell in cells:
    exec(compile("".join(cell["source"]), cell["id"], "exec"), told)
assert told["ended"] > 64 and told["picture"].ndim == 3
assert set(told["observations"]) == {f"left_{k}" for k in range(1, 6)}
"""


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_from_top_to_bottom(path):
    run = subprocess.run([sys.executable, "-c", RUN, path], capture_output=True, text=True, timeout=600)
    assert run.returncode == 0, run.stderr
    assert "of them with a goal" in run.stdout


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_without_outputs(path):
    cells = json.loads(path.read_text("utf-8"))["cells"]
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells if cell["cell_type"] == "code")


def test_there_is_one():
    assert NOTEBOOKS
