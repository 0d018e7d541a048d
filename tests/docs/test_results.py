"""The page of results is what its file says, and the file is whole."""

import importlib.util
import re
import sys

import pytest
from paths import ROOT

from cprm_gym.benchmark.chapter5.claims import CLAIMS
from cprm_gym.benchmark.chapter5.experiments import EXPERIMENTS
from cprm_gym.benchmark.statistics import wilson_interval
from cprm_gym.errors import CprmError

VERDICTS = {"holds", "in part", "does not hold", "not decided", "not yet measured"}


@pytest.fixture(scope="module")
def page():
    spec = importlib.util.spec_from_file_location("page_of_results", ROOT / "docs" / "chapter5.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def data(page):
    return page.read()


def test_the_page_says_what_the_file_says_and_would_not_if_a_number_were_another(page, data):
    text = page.PAGE.read_text(encoding="utf-8")
    assert page.with_parts(text, data) == text
    kinds = [m[2] for m in page.BLOCK.finditer(text)]
    assert set(page.MADE) == set(kinds)
    assert {m[3] for m in page.BLOCK.finditer(text) if m[2] == "found"} == set(EXPERIMENTS)
    other = {**data, "claims": {**data["claims"], "intention": {**data["claims"]["intention"], "figure": "Nobody came home."}}}
    assert page.with_parts(text, other) != text


def test_every_claim_has_a_verdict_and_where_it_is_measured_a_figure(data):
    assert list(data["claims"]) == list(CLAIMS)
    for key, entry in data["claims"].items():
        assert entry["claim"] == CLAIMS[key].says
        assert entry["verdict"] in VERDICTS
        assert bool(re.search(r"\d", entry["figure"])) == (entry["verdict"] != "not yet measured"), key


def test_rates_of_the_tables_are_those_of_the_cells(data):
    cells = {(c["task"], c["condition"], c["player"]): c for c in data["cells"]}
    checked = 0
    for one in data["experiments"]:
        for table in one["tables"]:
            head = table["head"]
            rates = [k for k, title in enumerate(head) if title.startswith("success %")]
            if "player" not in head or "n" not in head or not rates or one["name"] not in ("table", "memory"):
                continue
            for row in table["rows"]:
                if " s (" in row[rates[0]]:  # a duration
                    continue
                cell = cells[row[head.index("task")] if "task" in head else "Hike", "default", row[head.index("player")]]
                if int(row[head.index("n")]) != cell["n"]:  # of a cell with more episodes than the others of its task
                    continue
                low, high = wilson_interval(cell["successes"], cell["n"])
                assert row[rates[0]] == f"{100 * cell['successes'] / cell['n']:.1f} ({100 * low:.1f} - {100 * high:.1f})"
                checked += 1
    assert checked >= 7


def test_the_pictures_and_films_of_the_page_are_there(page):
    named = re.findall(r"\(images/(chapter5_\w+\.\w+)\)", page.PAGE.read_text(encoding="utf-8"))
    assert len(named) > 5
    for name in named:
        assert (ROOT / "docs" / "images" / name).stat().st_size > 1000, name
    assert {path.name for path in page.IMAGES.glob("chapter5_*")} == set(named)


def test_small_files_only(page):
    assert page.RESULTS.stat().st_size < 1_000_000
    assert sum(path.stat().st_size for path in page.IMAGES.glob("chapter5_*")) < 1_500_000


def test_runs_that_do_not_go_together_are_refused(page, tmp_path, monkeypatch):
    from cprm_gym.benchmark.chapter5 import Chapter5Plan
    from cprm_gym.benchmark.chapter5.report.merged import merged

    with pytest.raises(CprmError, match="no runs given"):
        merged([])
    for name, plan in (("a", Chapter5Plan(("memory",))), ("b", Chapter5Plan(("memory",), seed=1))):
        (tmp_path / name).mkdir()
        plan.write(tmp_path / name)
    with pytest.raises(CprmError, match="different seeds"):
        merged([tmp_path / "a", tmp_path / "b"])
    monkeypatch.setattr(page, "write", lambda data: pytest.fail("written"))
    with pytest.raises(SystemExit, match=r"plan\.json: not the plan"):
        page.main([str(tmp_path)])


def test_of_two_runs_the_cell_with_more_episodes_is_told(tmp_path):
    from dataclasses import replace

    from cprm_gym.benchmark.chapter5 import Chapter5Plan, play_cell
    from cprm_gym.benchmark.chapter5.report.merged import merged
    from cprm_gym.benchmark.runner import run

    for name, count in (("few", 2), ("more", 4)):
        plan = Chapter5Plan(("memory",))
        plan = replace(plan, size=replace(plan.size, table=count))
        (tmp_path / name).mkdir()
        plan.write(tmp_path / name)
        list(run(plan, journal=tmp_path / name / "episodes.jsonl", play=play_cell))
    for order in (["few", "more"], ["more", "few"]):
        report = merged([tmp_path / name for name in order])
        assert report.results.played("Hike", "default", "fsm").n == 4
        assert report.complete
