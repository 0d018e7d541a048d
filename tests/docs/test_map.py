"""The map of knowledge on its page is what its results say, and the results are whole."""

import importlib.util
import re
import sys
from dataclasses import replace

import pytest
from paths import ROOT

from cprm_gym.benchmark.knowledge import SENSES, STATED
from cprm_gym.benchmark.statistics import wilson_interval

TIERS = {"frozen", "memory", "tracker", "belief", "state", "foresight"}


@pytest.fixture(scope="module")
def page():
    spec = importlib.util.spec_from_file_location("map_of_knowledge", ROOT / "docs" / "map.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def rows(page):
    return page.read()


def test_the_page_has_the_tables_that_the_results_make_and_no_others(page, rows):
    text = page.PAGE.read_text(encoding="utf-8")
    assert page.with_tables(text, rows) == text
    assert len(page.BLOCK.findall(text)) == 2
    wrong = [replace(row, rate=row.rate / 2) if row.task == "LostAndFound" else row for row in rows]
    assert page.with_tables(text, wrong) != text


def test_rates_and_intervals_are_those_of_the_successes(rows):
    for row in rows:
        assert row.rate == pytest.approx(row.successes / row.episodes)
        assert (row.low, row.high) == pytest.approx(wilson_interval(row.successes, row.episodes))
        assert (row.difference is None) == (row.tier == "memory")
    memory = {(row.task, row.senses): row.rate for row in rows if row.tier == "memory"}
    for row in rows:
        if row.difference is not None:
            assert row.difference == pytest.approx(row.rate - memory[row.task, row.senses])
            assert row.difference_low < row.difference < row.difference_high


def test_every_stated_variant_was_measured_on_every_tier_and_holds(rows):
    for task, senses in STATED.items():
        found = {row.tier: row for row in rows if (row.task, row.senses) == (task, senses)}
        assert set(found) == TIERS, task
        assert found["foresight"].rate >= 0.8, task
        assert found["frozen"].rate <= 0.5, task


def test_the_goalie_was_measured_under_all_senses(rows):
    goalie = [row for row in rows if row.task == "Goalie"]
    assert {row.senses for row in goalie} == set(SENSES)
    assert {row.tier for row in goalie if row.senses == "default"} == TIERS
    for senses in SENSES:
        assert {row.tier for row in goalie if row.senses == senses} >= TIERS - {"state", "foresight"}
    assert min(row.episodes for row in goalie) >= 500


def test_runs_are_taken_in_each_row_in_place_of_an_older_one(page, rows, tmp_path):
    new = replace(rows[0], episodes=7)
    assert page.merged(rows, [new]) == [new, *rows[1:]]
    other = replace(rows[0], senses="elsewhere")
    assert page.merged(rows, [other]) == [*rows, other]
    page.write(rows, tmp_path / "x.json")
    assert page.read(tmp_path / "x.json") == rows


def test_the_pictures_on_the_page_are_there_and_can_be_made(page, rows, tmp_path):
    pytest.importorskip("matplotlib")
    shown = set(re.findall(r"\(images/(knowledge_\w+\.png)\)", page.PAGE.read_text(encoding="utf-8")))
    assert {path.name for path in page.draw(rows, tmp_path)} == shown
    assert all((ROOT / "docs" / "images" / name).stat().st_size > 10_000 for name in shown)


@pytest.mark.parametrize("content", [None, "", "[]", '{"rows": [{"task": "Goalie"}]}'])
def test_what_is_no_run_is_refused_in_one_line_and_nothing_is_written(page, content, tmp_path, monkeypatch):
    run = tmp_path / "run.json"
    if content is not None:
        run.write_text(content, encoding="utf-8")
    monkeypatch.setattr(page, "write", lambda rows: pytest.fail("written"))
    with pytest.raises(SystemExit, match=r"run\.json: not the results of a run"):
        page.main([str(run)])
