"""The notebooks run from top to bottom, and are kept without outputs."""

import json

import matplotlib.pyplot
import pytest
from paths import ROOT

NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))


def cells(path):
    return [cell for cell in json.loads(path.read_text("utf-8"))["cells"] if cell["cell_type"] == "code"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_from_top_to_bottom(path, capsys):
    told = {}
    try:
        for cell in cells(path):
            exec(compile("".join(cell["source"]), f"{path.name}, {cell['id']}", "exec"), told)
    finally:
        matplotlib.pyplot.close("all")
    assert told["ended"] > 64
    assert "of them with a goal" in capsys.readouterr().out
    assert told["picture"].ndim == 3
    assert set(told["observations"]) == {f"left_{k}" for k in range(1, 6)}


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_without_outputs(path):
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in cells(path))


def test_there_is_one():
    assert NOTEBOOKS
