"""The guide tells the truth."""

from __future__ import annotations

import doctest

from paths import ROOT

GUIDE = ROOT / "docs" / "models.md"


def test_every_example_of_the_guide_gives_what_it_says():
    result = doctest.testfile(str(GUIDE), module_relative=False)
    assert result.attempted > 40
    assert result.failed == 0
