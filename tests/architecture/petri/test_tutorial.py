"""The tutorial's blocks run, print what stands under them, and draw its pictures.

``python tests/architecture/petri/test_tutorial.py`` writes both anew.
"""

import contextlib
import io
import os
import re
import sys
import tempfile
from pathlib import Path

import pytest
from paths import ROOT

PAGE = ROOT / "docs" / "tutorial_kick.md"
BLOCK = re.compile(r"```python\n(.*?)```\n(?:```text\n(.*?)```\n)?", re.DOTALL)


def run(page: str) -> list[tuple[str, str, str]]:
    """(code, printed, expected) of every block, run in order in one namespace and the current directory."""
    namespace: dict[str, object] = {}
    found = []
    for match in BLOCK.finditer(page):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            exec(compile(match[1], f"{PAGE.name}, block {len(found) + 1}", "exec"), namespace)
        found.append((match[1], out.getvalue(), match[2] or ""))
    return found


@pytest.fixture(scope="module")
def blocks(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tutorial")
    before = Path.cwd()
    os.chdir(folder)
    try:
        return run(PAGE.read_text(encoding="utf-8")), folder
    finally:
        os.chdir(before)


def test_blocks_print_what_stands_under_them(blocks):
    for code, printed, expected in blocks[0]:
        assert printed == expected, code


def test_pictures_are_those_of_the_nets(blocks):
    drawn = sorted(path.name for path in blocks[1].glob("*.svg"))
    shown = sorted(set(re.findall(r"\]\(images/(kick_\w+\.svg)\)", PAGE.read_text(encoding="utf-8"))))
    assert drawn == shown
    for name in drawn:
        assert (PAGE.parent / "images" / name).read_text(encoding="utf-8") == (blocks[1] / name).read_text(encoding="utf-8"), name


def test_every_stage_of_the_example_is_there():
    page = PAGE.read_text(encoding="utf-8")
    assert re.findall(r"^\| \[\d\]\(.*\| ([\d., ]+) \|$", page, re.MULTILINE) == [
        "2.3", "2.4", "2.7", "2.8", "2.9", "2.10, 4.1", "2.17", "2.18", "2.23",
    ]  # fmt: skip


def write_anew() -> None:
    """Put what the blocks print under them, and the pictures beside the page."""
    page = PAGE.read_text(encoding="utf-8")
    images = PAGE.parent / "images"
    images.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        printed = iter(run(page))

        def block(match: re.Match[str]) -> str:
            code, out, _ = next(printed)
            return f"```python\n{code}```\n" + (f"```text\n{out}```\n" if out else "")

        PAGE.write_text(BLOCK.sub(block, page), encoding="utf-8")
        for picture in Path(folder).glob("*.svg"):
            (images / picture.name).write_text(picture.read_text(encoding="utf-8"), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(write_anew())
