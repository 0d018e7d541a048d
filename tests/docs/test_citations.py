"""Comments, docstrings and pages cite the specification by page and section; what they cite exists.

A citation is ``specification/simulator.md 6.1.4``, with further sections after commas, "and", "to" or a dash.
"""

import re

import pytest
from paths import ROOT

PAGES = ROOT / "docs" / "specification"
SECTION = r"\d+(?:\.\d+)*"
CITATION = re.compile(rf"\b(?P<page>\w+)\.md (?P<sections>{SECTION}(?:(?:, | and | to |-){SECTION})*)")
OLD_PAGE = re.compile(r"\b[A-Z][A-Z_]{3,}\.md\b")
ALLOWED_CAPITALS = {"README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "LICENSE.md"}


def sections(page):
    """The numbered headings of a page of the specification."""
    return set(re.findall(rf"^#+ ({SECTION})\.?\s", page.read_text(encoding="utf-8"), re.MULTILINE))


def mistakes(text):
    """What a text cites that is not there."""
    known = {page.stem: sections(page) for page in PAGES.glob("*.md")}
    found = [f"page {name}" for name in OLD_PAGE.findall(text) if name not in ALLOWED_CAPITALS]
    for match in CITATION.finditer(text):
        page = match["page"]
        if page not in known:
            found.append(f"page {page}.md")
            continue
        found += [f"{page}.md {section}" for section in re.findall(SECTION, match["sections"]) if section not in known[page]]
    return found


def texts():
    for folder in ("cprm_gym", "baselines", "tests", "docs", "examples", "scripts"):
        for kind in ("*.py", "*.md", "*.sh"):
            yield from (path for path in (ROOT / folder).rglob(kind) if "_build" not in path.parts)
    yield from ROOT.glob("*.md")


def cited(path):
    return CITATION.findall(path.read_text(encoding="utf-8"))


def test_every_cited_page_and_section_exists():
    wrong = {
        str(path.relative_to(ROOT)): found
        for path in texts()
        if path.name != "test_citations.py" and (found := mistakes(path.read_text("utf-8")))
    }
    assert wrong == {}


def test_the_code_cites_its_specification():
    assert sum(len(cited(path)) for path in (ROOT / "cprm_gym").rglob("*.py")) >= 70


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("as in specification/simulator.md 6.1.4", []),
        ("(specification/simulator.md 2.2 to 2.4, 7.3, 7.15)", []),
        ("specification/simulator.md 6.1.44", ["simulator.md 6.1.44"]),
        ("specification/simulator.md 3.1, 3.2 and 3.99", ["simulator.md 3.99"]),
        ("specification/simulator.md 99-100", ["simulator.md 99", "simulator.md 100"]),
        ("specification/weather.md 1", ["page weather.md"]),
        ("SIMULATOR.md 6.1", ["page SIMULATOR.md", "page SIMULATOR.md"]),
        ("see HOUSE.md", ["page HOUSE.md"]),
    ],
)
def test_a_wrong_citation_is_caught(text, expected):
    assert mistakes(text) == expected
