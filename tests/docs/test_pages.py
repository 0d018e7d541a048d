"""Every block of code on every page runs and prints what stands there."""

import contextlib
import doctest
import io
import re

import pytest
from paths import ROOT

BLOCK = re.compile(r"```python\n(.*?)```(?:\n+```text\n(.*?)```)?", re.DOTALL)
ELSEWHERE = {"tutorial_kick.md": "tests/architecture/petri/test_tutorial.py"}
"""Pages whose blocks write files, with the test that runs them and looks at what they wrote."""
PAGES = sorted(
    page
    for page in (ROOT / "docs").rglob("*.md")
    if "```python" in page.read_text(encoding="utf-8") and not {"generated", "_build"} & set(page.parts)
)


@pytest.mark.parametrize("page", [page for page in PAGES if page.name not in ELSEWHERE], ids=lambda page: page.name)
def test_the_code_of_a_page_gives_what_it_says(page):
    text = page.read_text(encoding="utf-8")
    namespace = {}
    plain = [(code, printed) for code, printed in BLOCK.findall(text) if ">>> " not in code]
    for code, expected in plain:
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(code, page.name, "exec"), namespace)
        if expected:
            assert out.getvalue() == expected
    result = doctest.testfile(str(page), module_relative=False)
    assert result.failed == 0
    assert result.attempted + len(plain) > 0


def test_pages_with_code_are_found():
    assert {"models.md", "structure.md", "environments.md", "tutorial_kick.md"} <= {page.name for page in PAGES}


@pytest.mark.parametrize(("page", "test"), ELSEWHERE.items())
def test_other_pages_are_run_by_their_own_test(page, test):
    assert page in (ROOT / test).read_text(encoding="utf-8")


def test_every_page_is_on_the_site():
    """A page that no table of contents names would be found by nobody."""
    listed = set(re.findall(r"^([\w/]+)$", (ROOT / "docs" / "index.md").read_text(encoding="utf-8"), re.MULTILINE))
    pages = {page.relative_to(ROOT / "docs").with_suffix("").as_posix() for page in (ROOT / "docs").rglob("*.md")}
    assert {page for page in pages if not page.startswith(("generated/", "_build/"))} - {"index"} <= listed
