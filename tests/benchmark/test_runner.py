"""The benchmark: plans, equal numbers for equal seeds, errors, interruptions, reports."""

import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from cprm_gym.benchmark import plan as plans
from cprm_gym.benchmark import runner
from cprm_gym.benchmark.journal import Journal
from cprm_gym.benchmark.plan import Block, Plan
from cprm_gym.benchmark.report import figure_of, plot, summarise
from cprm_gym.benchmark.runner import play_block, run, workers_for
from cprm_gym.cli import app
from cprm_gym.envs.controller import no_action
from cprm_gym.envs.others import registry
from cprm_gym.errors import ControllerError, CprmError, ParameterError, UnknownName
from cprm_gym.workers import deaf_to_interrupts

CONTROLLERS = ("cprm", "fsm", "random")


def without_times(text):
    data = json.loads(text)
    del data["timing"]
    return json.dumps(data)


def test_the_three_controllers_are_registered():
    assert set(CONTROLLERS) <= set(registry.controller_entries())


def test_equal_seeds_give_equal_reports_whatever_the_blocks_order():
    plan = Plan(episodes=140, seed=3)
    first = list(run(plan))
    again = list(run(plan))[::-1]
    assert without_times(summarise(plan, first).to_json()) == without_times(summarise(plan, again).to_json())
    other = Plan(episodes=140, seed=4)
    assert without_times(summarise(plan, first).to_json()) != without_times(summarise(other, run(other)).to_json())


def test_workers_do_not_change_the_numbers():
    plan = Plan(controllers=("fsm", "random"), episodes=130, seed=2)
    alone, shared = summarise(plan, run(plan)), summarise(plan, run(plan, workers=2))
    assert alone.rows == shared.rows


def test_all_controllers_meet_the_same_worlds(monkeypatch):
    starts = {}
    original = runner.SoccerCore.reset

    def remember(self, seed=None, worlds=None):
        out = original(self, seed, worlds)
        starts.setdefault(current[0], []).append(self.sim.world["pos"].copy())
        return out

    monkeypatch.setattr(runner.SoccerCore, "reset", remember)
    current = [""]
    for name in CONTROLLERS:
        current[0] = name
        play_block(Block("GoToBall", name, 0, 30, 5))
    reference = starts["cprm"][-1]
    assert len(reference) == 30
    assert all(np.array_equal(starts[name][-1], reference) for name in CONTROLLERS)


def test_cprm_reaches_the_ball_and_random_does_not():
    plan = Plan(episodes=250, seed=1)
    rows = {row.controller: row for row in summarise(plan, run(plan)).rows}
    assert rows["cprm"].success_rate >= 0.95
    assert rows["random"].success_rate < 0.05
    assert rows["fsm"].success_rate > 0.5
    assert rows["cprm"].wilson_low <= rows["cprm"].success_rate <= rows["cprm"].wilson_high


class Broken:
    def reset(self, observation, seed, worlds=None):
        self.cycles = 0

    def act(self, observation):
        self.cycles += 1
        if self.cycles > 5:
            raise ZeroDivisionError("the controller's own fault")
        return runner_action(observation)


def runner_action(observation):
    from cprm_gym.envs.controller import no_action

    return no_action(len(observation["level"]))


def with_controller(monkeypatch, name, factory):
    entries = registry.controller_entries
    loader = registry.load_controller
    known = {**entries(), name: None}
    monkeypatch.setattr(plans, "controller_entries", lambda: known)
    monkeypatch.setattr(runner, "load_controller", lambda n: factory if n == name else loader(n))


def test_a_controller_that_raises_is_reported_and_the_others_finish(monkeypatch):
    with_controller(monkeypatch, "broken", lambda task, agent: Broken())
    plan = Plan(controllers=("broken", "random"), episodes=20)
    report = summarise(plan, run(plan))
    broken, fine = report.rows
    assert "ZeroDivisionError: the controller's own fault" in broken.error
    assert "in act" in broken.error
    assert broken.episodes == 0
    assert (fine.error, fine.episodes) == (None, 20)
    assert not report.complete
    assert "error: ZeroDivisionError" in report.to_markdown()


class Ends:
    """A controller that ends the program, or its generator, in its first decision."""

    def __init__(self, error):
        self.error = error

    def reset(self, observation, seed, worlds=None):
        pass

    def act(self, observation):
        raise self.error


@pytest.mark.parametrize("error", [SystemExit(0), GeneratorExit()])
def test_a_controller_that_ends_the_program_is_an_error_and_the_others_finish(monkeypatch, error):
    with_controller(monkeypatch, "ends", lambda task, agent: Ends(error))
    plan = Plan(controllers=("ends", "random"), episodes=5)
    ended, fine = summarise(plan, run(plan)).rows
    assert type(error).__name__ in ended.error
    assert (fine.error, fine.episodes) == (None, 5)


def test_the_command_exits_with_1_when_a_controller_exits_with_0(tmp_path, monkeypatch):
    with_controller(monkeypatch, "ends", lambda task, agent: Ends(SystemExit(0)))
    result = invoke("--controllers", "ends", "--episodes", 5, "--output", tmp_path)
    assert result.exit_code == 1
    assert "SystemExit: 0" in result.output


class Sleeps(Ends):
    """A controller that thinks for a minute in its tenth decision."""

    def __init__(self):
        self.decisions = 0

    def reset(self, observation, seed, worlds=None):
        self.decisions = 0

    def act(self, observation):
        self.decisions += 1
        if self.decisions == 10:
            time.sleep(60)
        return no_action(len(observation["level"]))


def test_a_controller_that_sleeps_is_ended_by_the_time_out(monkeypatch):
    with_controller(monkeypatch, "sleeps", lambda task, agent: Sleeps())
    begin = time.monotonic()
    result = play_block(Block("GoToBall", "sleeps", 0, 2, 0), timeout=0.5)
    assert "ControllerError: a decision took longer than 0.5 s (--timeout)" in result.error
    assert time.monotonic() - begin < 30


def test_elsewhere_than_in_the_main_thread_the_excess_is_found_afterwards():
    limit = []

    def work():
        try:
            with runner.Limit(0.01):
                time.sleep(0.05)
        except ControllerError as error:
            limit.append(str(error))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert limit == ["a decision took longer than 0.01 s (--timeout)"]


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are listed in /proc")
def test_workers_end_when_their_parent_is_killed(tmp_path):
    command = [sys.executable, "-m", "cprm_gym.cli", "benchmark", "--controllers", "fsm,random", "--episodes", "100000",
               "--workers", "2", "--output", str(tmp_path)]  # fmt: skip
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    while not list(tmp_path.glob("*/plan.json")):
        time.sleep(0.1)
    time.sleep(3.0)  # the workers have been started
    before = living(process.pid)
    process.kill()
    process.wait()
    for _ in range(100):
        if not (left := living(process.pid)):
            break
        time.sleep(0.2)
    assert len(before) >= 2
    assert left == []


def living(session):
    """Processes of a session that are not zombies."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, _, owner = path.read_text().rpartition(")")[2].split()[:4]
        except OSError:
            continue
        if int(owner) == session and state != "Z":
            found.append(int(path.parent.name))
    return found


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (lambda n: 3, "act returned int, expected a dict of arrays"),
        (lambda n: {"type": np.zeros(n)}, "act returned no 'params'"),
        (lambda n: {"type": np.zeros(n), "params": np.zeros((n, 2)), "turn_neck": np.zeros((n, 1)), "view": np.zeros(n)},
         r"'params' has shape \(1, 2\), expected \(1, 4\)"),
    ],
)  # fmt: skip
def test_a_controller_that_breaks_the_interface_is_told_how(monkeypatch, answer, message):
    class Wrong:
        def reset(self, observation, seed, worlds=None):
            pass

        def act(self, observation):
            return answer(len(observation["level"]))

    with_controller(monkeypatch, "wrong", lambda task, agent: Wrong())
    result = play_block(Block("GoToBall", "wrong", 0, 1, 0))
    assert re.search("ControllerError.*" + message, result.error)


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"tasks": ("GoToBal",)}, UnknownName, r"unknown task 'GoToBal'. Did you mean 'GoToBall'\? Known: .*GoToBall, "),
        ({"controllers": ("cprm", "fms")}, UnknownName, r"unknown controller 'fms'. Did you mean 'fsm'\? Known: .*cprm, .*fsm"),
        ({"controllers": ()}, ParameterError, "controllers: none given"),
        ({"controllers": ("fsm", "fsm")}, ParameterError, "'fsm' is named twice"),
        ({"episodes": -5}, ParameterError, "episodes: -5 given, a whole number of at least 1 is needed"),
        ({"episodes": 2.5}, ParameterError, "episodes: 2.5 given"),
        ({"seed": -1}, ParameterError, "seed: -1 given"),
    ],
)
def test_a_plan_that_makes_no_sense_is_refused(changes, error, message):
    with pytest.raises(error, match=message):
        Plan(**changes)


def test_workers_are_taken_where_their_start_is_a_small_part_of_the_work():
    processors = workers_for(1e6, 10**6)
    assert processors >= 1
    assert [workers_for(seconds, blocks) for seconds, blocks in ((0.2, 10), (19.0, 1), (100.0, 1), (1e-6, 10**4))] == [1, 1, 1, 1]
    assert workers_for(10.0, 2) == min(processors, 2)


def test_without_a_number_short_work_is_played_by_one_worker_which_is_said_and_the_numbers_are_the_same():
    plan, said = Plan(episodes=2 * plans.BLOCK + 1, controllers=("random",)), []
    alone, chosen = summarise(plan, run(plan)), summarise(plan, run(plan, workers=None, told=said.append))
    assert chosen.rows == alone.rows
    assert len(said) == 1
    assert said[0].startswith("1 worker: 2 blocks of about ")


def test_fewer_workers_than_one_are_refused():
    with pytest.raises(ParameterError, match="workers: 0 given"):
        list(run(Plan(), workers=0))


def test_the_cprm_controller_lists_the_tasks_that_it_plays():
    from cprm_gym.envs.tasks import make_task

    with pytest.raises(UnknownName, match="'Soccer'"):
        registry.load_controller("fsm")(make_task("Soccer"), "left_1")
    with pytest.raises(UnknownName, match=r"Known: .*GoToBall"):
        registry.load_controller("cprm")(make_task("SlowApproach"), "left_1")


def test_an_entry_that_cannot_be_loaded_says_why(monkeypatch):
    from importlib.metadata import EntryPoint

    entry = EntryPoint("gone", "no_such_module:thing", registry.GROUP)
    monkeypatch.setattr(registry, "controller_entries", lambda: {"gone": entry})
    with pytest.raises(ControllerError, match="'gone': no_such_module:thing cannot be loaded: ModuleNotFoundError"):
        registry.load_controller("gone")


# ---------------------------------------------------------------------- journal and interruption


def test_an_interrupted_run_is_taken_up_where_it_was(tmp_path):
    plan = Plan(controllers=("random",), episodes=300, seed=8)
    journal = tmp_path / "episodes.jsonl"
    part = run(plan, journal=journal)
    next(part)
    part.close()
    assert len(Journal(journal).read()) == 1
    with journal.open("a") as file:
        file.write('{"block": {"task": "GoToB')  # cut short while it was written
    played = []
    results = list(run(plan, journal=journal, on_result=lambda r, done, total: played.append((done, total))))
    assert played == [(1, 3), (2, 3), (3, 3)]
    assert summarise(plan, results).rows == summarise(plan, run(plan)).rows
    assert len(Journal(journal).read()) == 3


WHOLE = {
    "block": {"task": "GoToBall", "controller": "random", "first": 0, "count": 3, "seed": 0},
    "success": [True, False, True], "cycles": [5, 7, 3], "reward": [1.0, -0.5, 0], "error": None,
    "wall_seconds": 0.1, "controller_seconds": 0.05, "decisions": 30, "played": 30,
}  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"success": [True, True]}, "success has 2 entries, expected a list of 3"),
        ({"success": [1, 1, 1]}, "success holds 1"),
        ({"success": True}, "success has True, expected a list of 3"),
        ({"cycles": [5, 7, 0]}, "cycles holds 0"),
        ({"cycles": [5, 7, 2.5]}, "cycles holds 2.5"),
        ({"reward": [1.0, "a", 0.0]}, "reward holds 'a'"),
        ({"reward": [1.0, float("nan"), 0.0]}, "NaN is no number of a result"),
        ({"reward": [1.0, float("inf"), 0.0]}, "Infinity is no number of a result"),
        ({"wall_seconds": -1}, "wall_seconds is -1, expected a number of at least 0"),
        ({"decisions": None}, "decisions is None, expected a number"),
        ({"error": "SystemExit: 0"}, "the block ended in an error"),
        ({"block": {**WHOLE["block"], "count": 125}}, r"count=125.* is not part of the plan|success has 3 entries, expected a list of 125"),
        ({"block": {**WHOLE["block"], "seed": 1}}, r"seed=1\) is not part of the plan"),
        ({"block": {**WHOLE["block"], "count": True}}, "count is True, expected int"),
        ({"block": [1]}, "the block is list, expected an object"),
        ({"goals": 3}, "the result has unknown goals"),
    ],
)
def test_a_journal_that_says_what_no_block_gives_is_refused_with_its_line(tmp_path, changes, message):
    journal = tmp_path / "episodes.jsonl"
    journal.write_text(json.dumps(WHOLE | changes) + "\n")
    with pytest.raises(CprmError, match=rf"episodes.jsonl, line 1: not a result of a block: .*({message})"):
        Journal(journal, Plan(controllers=("random",), episodes=3)).read()


@pytest.mark.parametrize("text", ["nonsense", "[" * 100_000, "{}", "3", '{"block": {}}', json.dumps(WHOLE) + "\n" + json.dumps(WHOLE)])
def test_a_damaged_journal_is_refused_with_its_line(tmp_path, text):
    journal = tmp_path / "episodes.jsonl"
    journal.write_text(text + "\n\n")
    with pytest.raises(CprmError, match=r"episodes.jsonl, line \d: not a result"):
        Journal(journal).read()


def test_a_whole_journal_is_read(tmp_path):
    (tmp_path / "episodes.jsonl").write_text(json.dumps(WHOLE) + "\n")
    (found,) = Journal(tmp_path / "episodes.jsonl", Plan(controllers=("random",), episodes=3)).read().values()
    assert json.loads(found.to_json()) == WHOLE


def test_a_folder_belongs_to_one_process_at_a_time(tmp_path):
    plan = Plan(controllers=("random",), episodes=200)
    course = run(plan, journal=tmp_path / "episodes.jsonl")
    next(course)
    code = f"""
from pathlib import Path
from cprm_gym.benchmark.plan import Plan
from cprm_gym.benchmark.runner import run
list(run(Plan(controllers=("random",), episodes=200), journal=Path({str(tmp_path / "episodes.jsonl")!r})))
"""
    other = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "CprmError" in other.stderr
    assert "another process is playing the run of this folder" in other.stderr
    list(course)
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


def invoke(*arguments):
    return CliRunner().invoke(app, ["benchmark", *map(str, arguments)])


def test_the_command_writes_report_table_and_plot(tmp_path):
    result = invoke("--episodes", 10, "--controllers", "fsm,random", "--output", tmp_path, "--seed", 3)
    assert result.exit_code == 0, result.output
    (folder,) = tmp_path.iterdir()
    assert sorted(p.name for p in folder.iterdir()) == [
        "episodes.jsonl",
        "episodes.lock",
        "plan.json",
        "report.json",
        "report.md",
        "report.png",
    ]
    report = json.loads((folder / "report.json").read_text())
    assert report["plan"]["episodes"] == 10
    assert [row["controller"] for row in report["rows"]] == ["fsm", "random"]
    assert (folder / "report.png").read_bytes().startswith(b"\x89PNG")
    assert "Wilson" in (folder / "report.md").read_text()
    assert "GoToBall" in result.output
    again = invoke("--episodes", 10, "--controllers", "fsm,random", "--output", tmp_path, "--seed", 3)
    assert again.exit_code == 0
    second = next(p for p in tmp_path.iterdir() if p != folder)
    assert without_times((folder / "report.json").read_text()) == without_times((second / "report.json").read_text())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--tasks", "GoToBal"], "Did you mean 'GoToBall'?"),
        (["--controllers", "nobody"], "unknown controller 'nobody'"),
        (["--episodes", "-3"], "episodes: -3 given, a whole number of at least 1 is needed"),
        (["--workers", "0"], "workers: 0 given"),
        (["--resume", "nowhere"], "--resume nowhere: there is no plan.json"),
    ],
)
def test_the_command_refuses_nonsense_in_one_line(tmp_path, arguments, message):
    result = invoke(*arguments, "--output", tmp_path)
    assert result.exit_code == 2
    assert message in " ".join(result.output.split())
    assert "Traceback" not in result.output
    assert list(tmp_path.iterdir()) == []


def test_the_command_keeps_what_it_has_when_interrupted(tmp_path, monkeypatch):
    original = runner.play_block
    calls = []

    def stop_at_the_second(block, timeout):
        calls.append(block)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return original(block, timeout)

    monkeypatch.setattr(runner, "play_block", stop_at_the_second)
    result = invoke("--episodes", 130, "--controllers", "random", "--output", tmp_path)
    assert result.exit_code == 130
    (folder,) = tmp_path.iterdir()
    report = json.loads((folder / "report.json").read_text())
    assert not report["complete"]
    assert report["rows"][0]["episodes"] == 125
    monkeypatch.setattr(runner, "play_block", original)
    assert f"go on with: cprm-gym benchmark --resume {folder}" in " ".join(result.output.split())
    other = invoke("--resume", folder, "--controllers", "fsm")
    assert other.exit_code == 2
    assert f"--controllers fsm: the run in {folder} has random" in " ".join(other.output.split())
    resumed = invoke("--resume", folder)
    assert resumed.exit_code == 0
    assert json.loads((folder / "report.json").read_text())["rows"][0]["episodes"] == 130


def test_a_run_that_was_interrupted_at_once_can_be_taken_up(tmp_path, monkeypatch):
    def stop(block, timeout):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(runner, "play_block", stop)
        assert invoke("--episodes", 5, "--controllers", "random", "--output", tmp_path).exit_code == 130
    (folder,) = tmp_path.iterdir()
    assert invoke("--resume", folder).exit_code == 0
    assert json.loads((folder / "report.json").read_text())["complete"]


@pytest.mark.parametrize("text", ["", "[]", '{"tasks": 3}', '{"goals": 3}', '{"tasks": ["GoToBal"]}'])
def test_a_damaged_plan_is_refused_by_name(tmp_path, text):
    (tmp_path / "plan.json").write_text(text)
    result = invoke("--resume", tmp_path)
    assert result.exit_code == 2
    assert "plan.json: " in result.output
    assert "Traceback" not in result.output


def test_an_interrupt_of_all_processes_is_reported_by_one(tmp_path):
    command = [sys.executable, "-m", "cprm_gym.cli", "benchmark", "--controllers", "fsm,random", "--episodes", "100000",
               "--workers", "2", "--output", str(tmp_path)]  # fmt: skip
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    while not list(tmp_path.glob("*/plan.json")):
        time.sleep(0.1)
    time.sleep(1.0)  # the workers have been started and import
    os.killpg(process.pid, signal.SIGINT)
    _, complaints = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in complaints
    assert "go on with: cprm-gym benchmark --resume" in complaints
    assert "--workers 2" in complaints


def test_an_interrupt_that_comes_while_workers_are_started_is_met_afterwards():
    started = []

    def start():
        with deaf_to_interrupts():
            signal.raise_signal(signal.SIGINT)
            started.append(True)

    with pytest.raises(KeyboardInterrupt):
        start()
    assert started


def test_a_report_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    plan = Plan(controllers=("random",), episodes=5)
    report = summarise(plan, run(plan))
    report.write(tmp_path)
    before, names = (tmp_path / "report.json").read_bytes(), set(tmp_path.iterdir())
    monkeypatch.setattr(os, "replace", lambda *a: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        report.write(tmp_path)
    assert (tmp_path / "report.json").read_bytes() == before
    assert set(tmp_path.iterdir()) == names


def test_the_plot_of_an_interrupted_run_shows_no_rate_of_what_was_not_played():
    pytest.importorskip("matplotlib")
    plan = Plan(controllers=("fsm", "random"), episodes=5)
    played = [result for result in run(plan) if result.block.controller == "random"]
    rates = figure_of(summarise(plan, played)).axes[0]
    heights = [bar.get_height() for bar in rates.patches]
    assert np.isnan(heights[0])
    assert heights[1] == 0.0


def test_without_matplotlib_there_is_no_plot_but_a_report(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    plan = Plan(controllers=("random",), episodes=5)
    report = summarise(plan, run(plan))
    assert plot(report) is None
    assert [p.name for p in report.write(tmp_path)] == ["report.json", "report.md"]


def test_keepaway_is_measured_by_its_duration():
    plan = Plan(("Keepaway3v2", "GoToBall"), ("random",), 4, 1)
    results = list(run(plan))
    keepaway, ball = summarise(plan, results).rows
    cycles = [c for r in results if r.block.task == "Keepaway3v2" for c in r.cycles]
    assert keepaway.mean_duration == pytest.approx(0.1 * sum(cycles) / len(cycles))
    assert ball.mean_duration is None
    assert f"{keepaway.mean_duration:.1f}" in summarise(plan, results).to_markdown()
