"""The page of results is what its file says, and the file is whole."""

import importlib.util
import re
import sys
from dataclasses import replace

import pytest
from paths import ROOT

from cprm_gym.benchmark.chapter5 import Chapter5Plan, play_cell
from cprm_gym.benchmark.chapter5.about import revision
from cprm_gym.benchmark.chapter5.cells import QUICK, Cell
from cprm_gym.benchmark.chapter5.claims import CLAIMS
from cprm_gym.benchmark.chapter5.experiments import EXPERIMENTS
from cprm_gym.benchmark.chapter5.films import FILMS, UNFILMED, films_of
from cprm_gym.benchmark.chapter5.report.beside import beside
from cprm_gym.benchmark.chapter5.report.merged import merged
from cprm_gym.benchmark.journal import Journal
from cprm_gym.benchmark.plan import Block
from cprm_gym.benchmark.runner import run
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


def test_no_figure_of_a_run_stands_in_what_is_written_by_hand(page):
    """So that new results need no hand: what is not made from the file holds no number but those of sections, headings and commands."""
    text = page.BLOCK.sub("", page.PAGE.read_text(encoding="utf-8"))
    text = re.sub(r"`[^`]*`|\]\([^)]*\)|§[\d.]+|[Cc]hapter 5|^### \d\. ", "", text, flags=re.MULTILINE)
    assert re.findall(r"\d+", text) == []


def test_every_claim_has_a_film_or_says_why_it_has_none(page, data):
    for key in CLAIMS:
        assert bool(films_of(key)) != (key in UNFILMED), key
        assert (key in UNFILMED) == (f"{CLAIMS[key].says} No film: " in page.films(data, "")), key
    assert all(pair.task and set(pair.claims) <= set(CLAIMS) for pair in FILMS.values())


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
                if " goals (" in row[rates[0]]:
                    assert row[rates[0]].startswith(f"{cell['reward']:+.2f} goals (")
                    checked += 1
                    continue
                low, high = wilson_interval(cell["successes"], cell["n"])
                assert row[rates[0]] == f"{100 * (cell['successes'] / cell['n']):.1f} ({100 * low:.1f} - {100 * high:.1f})"
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
    assert page.HTML.stat().st_size < 1_000_000
    assert sum(path.stat().st_size for path in page.IMAGES.glob("chapter5_*")) < 1_500_000


def test_all_episodes_of_the_file_are_kept_and_say_what_it_says(page, data):
    """The packed journals hold what each cell tells: episodes, successes, cycles."""
    runs = sorted(page.RUNS.glob("[0-9]*"))
    if not runs:
        pytest.skip("the runs of this file are from before runs were kept")
    assert len(runs) == len(data["runs"])
    counts: dict[tuple[int, str, str], list[int]] = {}
    for number, folder in enumerate(runs):
        for result in Journal(folder / "episodes.jsonl").read().values():
            one = counts.setdefault((number, result.block.task, result.block.controller), [0, 0, 0])
            for k, more in enumerate((len(result.success), sum(result.success), sum(result.cycles))):
                one[k] += more
    for cell in data["cells"]:
        n, successes, cycles = counts[cell["run"], cell["task"], f"{cell['condition']}/{cell['player']}"]
        assert (n, successes) == (cell["n"], cell["successes"])
        assert cycles / n == pytest.approx(cell["cycles"])
    assert sum(path.stat().st_size for path in page.RUNS.rglob("*")) < 2_000_000


def test_runs_that_do_not_go_together_are_refused(page, tmp_path, monkeypatch):
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


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """The hike, with few episodes and with more, and of another seed."""
    root = tmp_path_factory.mktemp("runs")
    for name, count, seed in (("few", 2, 0), ("more", 4, 0), ("as_many", 4, 0), ("another", 4, 1)):
        plan = Chapter5Plan(("memory",), seed=seed)
        plan = replace(plan, size=replace(plan.size, table=count))
        (root / name).mkdir()
        plan.write(root / name)
        (root / name / "command.txt").write_text(f"cprm-gym benchmark --seed {seed}\n")
        list(run(plan, journal=root / name / "episodes.jsonl", play=play_cell))
    return root


def test_of_two_runs_the_cell_with_more_episodes_is_told_and_of_equal_ones_the_last(runs):
    cell = Cell("Hike", "default", "fsm")
    for order, which in ((["few", "more"], 1), (["more", "few"], 0), (["more", "as_many"], 1), (["as_many", "more", "few"], 1)):
        report = merged([runs / name for name in order])
        assert report.results.played(cell.task, cell.condition, cell.player).n == 4
        assert report.complete
        assert report.origin[cell] == which
        assert len(report.runs) == len(order)
        assert next(c for c in report.to_data()["cells"] if c["player"] == "fsm")["run"] == which
    assert report.command == "cprm-gym benchmark --seed 0"
    assert report.runs[0].version.startswith(revision().split(",")[0])


def test_a_second_seed_beside_the_first_says_what_hangs_on_it(runs, page, tmp_path, monkeypatch):
    one, other = merged([runs / "more"]), merged([runs / "another"])
    same = beside(one, other)
    assert (same.hangs, same.once, same.against) == ((), (), ())
    assert set(same.verdicts) == {"regions contained", "intention", "internal"}
    assert same.compared == len(one.told[0].comparisons) == same.both + same.neither
    # another verdict, a comparison decided by one seed alone, and one decided by each another way
    (told,) = other.told
    findings = tuple(replace(f, verdict="does not hold") if f.claim == "intention" else f for f in told.findings)
    first = replace(one.told[0], comparisons=tuple(replace(c, better=("cprm", "cprm", "")[min(k, 2)])
                                                   for k, c in enumerate(one.told[0].comparisons)))  # fmt: skip
    second = replace(told, findings=findings, comparisons=tuple(replace(c, better=("", c.second, "cprm")[min(k, 2)])
                                                                for k, c in enumerate(told.comparisons)))  # fmt: skip
    found = beside(replace(one, told=(first,)), replace(other, told=(second,)))
    assert found.hangs == ("intention",)
    assert found.verdicts["intention"] == "does not hold"
    assert [who for _, who in found.once] == ["seed 0"] + ["seed 1"] * (len(told.comparisons) - 2)
    assert len(found.against) == 1
    assert "same verdict on 2 of the 3 claims" in found.said
    text = replace(one, again=found).to_html()
    assert text.count("With seed 1: does not hold") == 1
    assert "does not hold" in replace(one, again=found).to_markdown()
    assert "**With seed 1: does not hold.**" in page.claims(page.data_of(replace(one, again=found)), "")
    for name in ("RESULTS", "HTML", "PAGE"):
        copied = tmp_path / name
        copied.write_text(page.PAGE.read_text(encoding="utf-8"), encoding="utf-8")
        monkeypatch.setattr(page, name, copied)
    monkeypatch.setattr(page, "draw", lambda report: None)
    monkeypatch.setattr(page.write, "__defaults__", (page.RESULTS,))
    monkeypatch.setattr(page.read, "__defaults__", (page.RESULTS,))
    monkeypatch.setattr(page, "RUNS", tmp_path / "runs")
    page.main([str(runs / "more"), "--again", str(runs / "another")])
    kept = [tmp_path / "runs" / "0", tmp_path / "runs" / "again" / "0"]
    assert [Journal(folder / "episodes.jsonl").read() for folder in kept] == [
        Journal(runs / name / "episodes.jsonl").read() for name in ("more", "another")
    ]
    page.keep([kept[0], runs / "more"], tmp_path / "runs")
    assert sorted(path.name for path in (tmp_path / "runs").glob("[0-9]*")) == ["0", "1"]
    page.keep([runs / "more"], tmp_path / "runs")
    assert sorted(path.name for path in (tmp_path / "runs").glob("[0-9]*")) == ["0"]
    assert "Seed 1 gives the same verdict on 3 of the 3 claims" in page.PAGE.read_text(encoding="utf-8")
    assert "Another seed" in page.HTML.read_text(encoding="utf-8")


def test_seeds_that_cannot_be_set_beside_each_other_are_refused(runs, page):
    with pytest.raises(CprmError, match="both runs are of seed 0"):
        beside(merged([runs / "more"]), merged([runs / "few"]))
    quick = replace(merged([runs / "another"]), plan=Chapter5Plan(("memory",), QUICK, seed=1))
    with pytest.raises(CprmError, match="quick run and a full one"):
        beside(merged([runs / "more"]), quick)
    for given in (["--again"], ["--again", "a"], ["a", "--again"], ["a", "--again", "b", "--again", "c"]):
        with pytest.raises(SystemExit, match="--again stands once"):
            page.main(given)


@pytest.fixture(scope="module")
def films():
    spec = importlib.util.spec_from_file_location("films_of_results", ROOT / "docs" / "chapter5_films.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_the_films_of_the_page_are_those_that_the_script_makes_and_small(page, films):
    made = {file for name, pair in films.FILMS.items() for file in pair.files(name)}
    assert {path.name for path in page.IMAGES.glob("chapter5_*.mp4")} == made
    assert all((page.IMAGES / name).stat().st_size < 300_000 for name in made)


def test_a_film_is_of_the_first_world_in_which_the_one_succeeds_and_the_other_does_not(films, tmp_path, monkeypatch):
    pair = replace(films.FILMS["late"], condition="default", one=("one", "fsm", "saved"), other=("other", "scripted", "goal"))
    monkeypatch.setitem(films.FILMS, "late", pair)
    world = films.world_of(pair)
    results = [
        play_cell(Block(pair.task, f"{pair.condition}/{player}", 0, world + 1, films.SEED)).success for player in ("fsm", "scripted")
    ]
    assert [one and not other for one, other in zip(*results)] == [False] * world + [True]
    assert films.film(tmp_path / "one.gif", pair.task, pair.condition, "fsm", world)
    assert not films.film(tmp_path / "other.gif", pair.task, pair.condition, "scripted", world)
    assert all(path.stat().st_size > 1000 for path in tmp_path.iterdir())
    with pytest.raises(SystemExit, match="in none of 60 worlds fsm succeeds and fsm does not"):
        films.world_of(replace(pair, other=("other", "fsm", "")))
    with pytest.raises(SystemExit, match="unknown film 'lat'"):
        films.main(["lat"])
