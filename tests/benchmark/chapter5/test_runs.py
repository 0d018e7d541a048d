"""A run of the suite ``chapter5``: its files, its command, what interrupts it and who fails in it."""

import json
import re
import shutil
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from cprm_gym.benchmark import runner
from cprm_gym.benchmark.chapter5 import Chapter5Plan, play_cell, players, summarise
from cprm_gym.benchmark.chapter5.cells import QUICK
from cprm_gym.benchmark.chapter5.players import INTERNAL
from cprm_gym.benchmark.chapter5.report.merged import merged
from cprm_gym.benchmark.chapter5.results import Results
from cprm_gym.benchmark.journal import Journal
from cprm_gym.benchmark.plan import BlockResult
from cprm_gym.cli import app
from cprm_gym.envs.controller import no_action
from cprm_gym.errors import CprmError


@pytest.fixture(scope="module")
def hike(tmp_path_factory):
    """The smallest experiment, run by the command."""
    out = tmp_path_factory.mktemp("run")
    result = CliRunner().invoke(
        app, ["benchmark", "--suite", "chapter5", "--quick", "--only", "memory", "--episodes", "8", "--output", str(out)]
    )
    assert result.exit_code == 0, result.output
    (folder,) = out.iterdir()
    return folder, result.output


def test_a_run_writes_a_page_a_table_and_both_forms_of_json(hike):
    folder, output = hike
    data = json.loads((folder / "report.json").read_text())
    assert data["complete"]
    assert data["plan"]["size"]["table"] == 8
    assert data["claims"]["intention"]["verdict"] == "holds"
    assert data["claims"]["recovery"]["verdict"] == "not yet measured"
    assert {cell["player"] for cell in data["cells"]} >= {"cprm", "belief_region", INTERNAL}
    runs = json.loads((folder / "marl_eval.json").read_text())["cprm_gym"]["Hike"]["cprm"]["seed_0"]
    assert runs["absolute_metrics"]["success"] == [1.0] * 8
    assert "| belief_region | 8 | 0.0" in (folder / "report.md").read_text()
    assert "holds" in output


def test_a_packed_run_is_read_as_the_run_itself_and_taken_up_from(hike, tmp_path):
    folder, _ = hike
    journal = Journal(folder / "episodes.jsonl")
    journal.pack(tmp_path / "episodes.jsonl.xz")
    shutil.copyfile(folder / "plan.json", tmp_path / "plan.json")
    packed = Journal(tmp_path / "episodes.jsonl")
    assert packed.read() == journal.read() != {}
    assert merged([tmp_path]).results.cells.keys() == merged([folder]).results.cells.keys()
    (tmp_path / "episodes.jsonl.xz").write_bytes((tmp_path / "episodes.jsonl.xz").read_bytes()[:-20])
    with pytest.raises(CprmError, match="not a packed journal"):
        packed.read()
    journal.pack(tmp_path / "episodes.jsonl.xz")
    packed.cut_torn_line()
    assert (tmp_path / "episodes.jsonl").read_text() == (folder / "episodes.jsonl").read_text()


def test_of_a_run_that_is_put_together_only_what_it_played_has_to_have_the_numbers_of_then(hike, tmp_path):
    folder, _ = hike
    shutil.copytree(folder, tmp_path / "run")
    path = tmp_path / "run" / "plan.json"
    noted = json.loads(path.read_text())
    noted["constants"]["Goalie"]["run"] = 0.6
    path.write_text(json.dumps(noted))
    assert merged([tmp_path / "run"]).results.cells
    with pytest.raises(CprmError, match="others by now"):
        Chapter5Plan.read(tmp_path / "run")
    noted["constants"]["Hike"] = {"run": 0.6}
    path.write_text(json.dumps(noted))
    with pytest.raises(CprmError, match="others by now"):
        merged([tmp_path / "run"])


def test_the_page_stands_alone_and_says_how_it_was_made(hike):
    folder, _ = hike
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert not re.search(r'(src|href)\s*=\s*["\']?(?!#)\w', text)
    for drawn in re.findall(r"<svg.*?</svg>", text, re.DOTALL):
        ET.fromstring(drawn)
    for said in ("cprm-gym benchmark --suite chapter5 --quick --only memory --episodes 8", "numpy", "Seed 0", "Which to take when"):
        assert said in text


def test_an_interrupted_run_is_taken_up_and_nothing_is_played_twice(tmp_path, monkeypatch):
    plan = Chapter5Plan(("memory",), replace(QUICK, table=4))
    played = []

    def stop_at_the_third(block, timeout):
        played.append(block)
        if len(played) == 3:
            raise KeyboardInterrupt
        return play_cell(block, timeout)

    plan.write(tmp_path)
    with pytest.raises(KeyboardInterrupt):
        list(runner.run(plan, journal=tmp_path / "episodes.jsonl", play=stop_at_the_third))
    result = CliRunner().invoke(app, ["benchmark", "--suite", "chapter5", "--resume", str(tmp_path)])
    assert result.exit_code == 0, result.output
    lines = (tmp_path / "episodes.jsonl").read_text().splitlines()
    assert len(lines) == len(plan.blocks())
    once = summarise(plan, [play_cell(block) for block in plan.blocks()])
    again = summarise(plan, [BlockResult.from_json(line) for line in lines])
    assert [c.success.tolist() for c in once.results.cells.values()] == [c.success.tolist() for c in again.results.cells.values()]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--only", "sences"], "Did you mean 'senses'?"),
        (["--tasks", "Goalie"], "--tasks does not go with --suite chapter5"),
        (["--controllers", "fsm"], "--controllers does not go with --suite chapter5"),
        (["--t-b", "3"], "--t-b does not go with --suite chapter5"),
        (["--episodes", "0"], "episodes: 0 given"),
        (["--workers", "0"], "workers: 0 given"),
        (["--timeout", "0"], "--timeout 0"),
        (["--resume", "nowhere"], "plan.json: not the plan of a run of the suite 'chapter5'"),
        (["--resume", "nowhere", "--quick"], "leave --quick and what is to be played out"),
    ],
)
def test_the_command_refuses_nonsense_in_one_line(tmp_path, arguments, message):
    result = CliRunner().invoke(app, ["benchmark", "--suite", "chapter5", *arguments, "--output", str(tmp_path)])
    assert result.exit_code == 2
    assert message in " ".join(result.output.split())
    assert "Traceback" not in result.output
    assert list(tmp_path.iterdir()) == []


def test_only_is_refused_without_the_suite(tmp_path):
    result = CliRunner().invoke(app, ["benchmark", "--only", "table", "--output", str(tmp_path)])
    assert result.exit_code == 2
    assert "--only goes with --suite chapter5" in result.output


class Bad:
    needs = ()

    def __init__(self, how):
        self.how = how

    def reset(self, observation, seed, worlds=None):
        self.worlds = len(observation["level"])

    def act(self, observation):
        return self.how(self.worlds)


def _nan(n):
    return {**no_action(n), "params": np.full((n, 4), np.nan)}


def _shape(n):
    return {**no_action(n), "params": np.zeros((n, 3))}


def _exit(n):
    raise SystemExit(0)


def _raise(n):
    raise ZeroDivisionError("by nothing")


def _slow(n):
    import time

    time.sleep(0.3)
    return no_action(n)


@pytest.mark.parametrize(
    ("how", "message"),
    [(_nan, "'params' holds what is no finite number, in world 0"), (_shape, "'params' has shape"), (_exit, "SystemExit: 0"),
     (_raise, "ZeroDivisionError: by nothing"), (_slow, "a decision took longer than 0.1 s")],
)  # fmt: skip
def test_a_controller_that_fails_is_named_and_the_rest_stands(how, message, monkeypatch):
    from cprm_gym.benchmark.chapter5 import playing

    original = players.load_controller
    monkeypatch.setattr(players, "load_controller", lambda name: (lambda task, agent: Bad(how)) if name == "scripted" else original(name))
    monkeypatch.setattr(playing, "COMPILING", 0.0 if how is _slow else 600.0)
    plan = Chapter5Plan(("table",), replace(QUICK, table=3))
    blocks = [b for b in plan.blocks() if b.task == "Hike" and b.controller.endswith(("/scripted", "/fsm", "/cprm"))]
    timeout = 0.1 if how is _slow else 60.0
    results = [play_cell(b, timeout if b.controller.endswith("scripted") else 60.0) for b in blocks]
    report = summarise(plan, results)
    ((who, error),) = report.errors
    assert who == "scripted on Hike, default"
    assert message in error
    assert not report.complete
    assert report.results.played("Hike", "default", "fsm").n == 3
    assert f"{who}: " in report.to_html()
    assert {row[1] for row in report.told[0].tables[0].rows} == {"fsm", "cprm"}


def test_nothing_played_gives_a_report_that_says_so():
    plan = Chapter5Plan.quick()
    report = summarise(plan, [])
    assert not report.complete
    assert {verdict for verdict, _ in report.verdicts().values()} == {"not yet measured"}
    assert "not everything that was planned was played" in report.to_html()
    assert report.advice == ()
    assert Results([]).cells == {}
