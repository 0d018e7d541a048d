"""The code of README and docstrings runs and prints what stands there."""

import contextlib
import doctest
import importlib
import io
import pkgutil
import re
from pathlib import Path

import pytest
from paths import ROOT

import cprm_gym


def blocks(path):
    """(code, expected output or None) of every Python block of a page."""
    text = path.read_text(encoding="utf-8")
    found = re.findall(r"```python\n(.*?)```(?:\n\n```text\n(.*?)```)?", text, re.DOTALL)
    return [(code, expected or None) for code, expected in found]


def test_the_readme_does_what_it_says():
    namespace = {}
    parts = blocks(ROOT / "README.md")
    assert len(parts) >= 4
    for code, expected in parts:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, "README.md", "exec"), namespace)
        if expected is not None:
            assert printed.getvalue() == expected


def modules():
    for found in pkgutil.walk_packages(cprm_gym.__path__, "cprm_gym."):
        source = Path(importlib.util.find_spec(found.name).origin)
        text = source.read_text(encoding="utf-8")
        if ">>> " in text and "doctest: +SKIP" not in text:
            yield found.name


@pytest.mark.parametrize("name", list(modules()))
def test_docstring_examples_run(name):
    result = doctest.testmod(importlib.import_module(name))
    assert result.attempted > 0
    assert result.failed == 0


def test_the_readme_names_the_commands_that_exist():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    for script in re.findall(r"bash (scripts/\S+\.sh)", text):
        assert (ROOT / script).is_file()
    assert (ROOT / ".ci" / "run").read_text().rstrip().endswith("bash scripts/test.sh\nbash scripts/docs.sh")
