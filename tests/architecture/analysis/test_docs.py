"""The page on structural analysis is true."""

import doctest

from paths import ROOT


def test_the_code_of_the_page_gives_what_it_says():
    page = ROOT / "docs" / "structure.md"
    failed, tried = doctest.testfile(str(page), module_relative=False)
    assert failed == 0
    assert tried > 10
