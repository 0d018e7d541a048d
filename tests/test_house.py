"""The house stays in order: small folders and classes, no circle of imports, files where they are guessed, one version."""

import ast
import re
from pathlib import Path

import pytest
from paths import ROOT

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    tomllib = None

PACKAGES = ("cprm_gym", "baselines/cprm_baselines")
MANY = {"cprm_gym/agents/skills", "cprm_gym/envs/tasks"}
"""Folders with one file for each thing of a kind."""


def modules():
    return [path for package in PACKAGES for path in (ROOT / package).rglob("*.py")]


def test_folders_have_at_most_16_files():
    folders = {}
    for path in modules():
        folders.setdefault(path.parent.relative_to(ROOT).as_posix(), []).append(path.name)
    assert len(folders) > 20
    assert {folder: len(files) for folder, files in folders.items() if len(files) > 16 and folder not in MANY} == {}


def reasons(source):
    """(class, lines, docstring) of every class of more than 400 lines in a text."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ClassDef) and node.end_lineno - node.lineno + 1 > 400:
            yield node.name, node.end_lineno - node.lineno + 1, ast.get_docstring(node) or ""


def test_a_class_of_more_than_400_lines_says_why():
    long = {
        f"{path.name}: {name}": lines
        for path in modules()
        for name, lines, doc in reasons(path.read_text("utf-8"))
        if "One class because" not in doc
    }
    assert long == {}


def test_a_long_class_without_a_reason_is_found():
    body = "\n".join(f"    a{i} = {i}" for i in range(400))
    assert [found[:2] for found in reasons(f"class Long:\n{body}\n")] == [("Long", 401)]


@pytest.mark.skipif(tomllib is None, reason="tomllib came with Python 3.11")
def test_no_circle_is_excused():
    """Import-linter looks into every package for circles; it runs with the style checks."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]
    (circles,) = [contract for contract in contracts if contract["type"] == "acyclic_siblings"]
    assert circles["ancestors"] == ["cprm_gym", "cprm_baselines"]
    assert circles.keys() == {"name", "type", "ancestors"}


GUESSES = {
    "inhibitor arcs": ("cprm_gym/architecture/petri/net/transitions.py", "inhibitors"),
    "the offside rule": ("cprm_gym/simulator/kernels/referee/offside.py", "def offside_line"),
    "the view `quantile`": ("cprm_gym/architecture/prm/inference/views.py", "quantile"),
    "the anytime engine": ("cprm_gym/architecture/prm/inference/engines/anytime.py", "class Anytime"),
    "the pass skill": ("cprm_gym/agents/skills/pass_ball.py", "PASS_BALL"),
    "the PNML writer": ("cprm_gym/architecture/petri/files/pnml_writer.py", "def write_pnml"),
    "the possession relation": ("cprm_gym/agents/models.py", '"possessesOpponent"'),
    "the Wilson interval": ("cprm_gym/benchmark/statistics.py", "def wilson_interval"),
}


@pytest.mark.parametrize("thing", GUESSES)
def test_a_reader_of_the_tree_finds_it(thing):
    file, words = GUESSES[thing]
    assert words in (ROOT / file).read_text(encoding="utf-8")


def test_the_version_is_the_same_everywhere():
    import cprm_gym

    found = [
        re.search(pattern, (ROOT / file).read_text(encoding="utf-8"), re.MULTILINE)[1]
        for file, pattern in (("pyproject.toml", r'^version = "(.+)"'), ("CITATION.cff", r"^version: (.+)$"))
    ]
    assert found == [cprm_gym.__version__] * 2


def test_the_tree_in_the_readme_is_the_one_that_is_there():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    (tree,) = re.findall(r"## Where things are\n\n```\n(.*?)```", text, re.DOTALL)
    folders = [line.split()[0] for line in tree.splitlines()]
    assert len(folders) >= 7
    assert [folder for folder in folders if not (ROOT / folder).is_dir()] == []


def test_files_that_pages_name_exist():
    """Paths in backticks, from the root of the repository."""
    pages = [
        *ROOT.glob("*.md"),
        *(page for page in (ROOT / "docs").rglob("*.md") if not {"generated", "_build", "specification"} & set(page.parts)),
    ]
    named = {
        name
        for page in pages
        if page.name != "CHANGELOG.md"
        for name in re.findall(r"`([\w./]+/[\w.]+\.(?:py|sh|md|toml))`", page.read_text("utf-8"))
    }
    assert len(named) > 10
    assert (
        sorted(name for name in named if not any((Path(ROOT) / base / name).exists() for base in ("", "cprm_gym/envs", "cprm_gym"))) == []
    )
