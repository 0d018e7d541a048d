"""``cprm-gym analyze``: exit status, questions, what a budget bounds."""

import json
import signal
import time

import pytest
from contract_modules import broken, turn_to_ball
from paths import SHARED
from structure_nets import kanban, philosophers
from typer.testing import CliRunner

from cprm_gym.architecture.analysis import report as reports
from cprm_gym.architecture.petri import save_net
from cprm_gym.cli import app

BOMB = SHARED / "cases" / "faults" / "bomb24.json"


def run(*arguments):
    return CliRunner().invoke(app, ["analyze", *map(str, arguments)])


def test_a_broken_contract_is_exit_status_1_and_a_kept_one_0(tmp_path):
    save_net(broken()["two outcomes"][0], tmp_path / "bad.json")
    save_net(turn_to_ball(), tmp_path / "good.json")
    assert run(tmp_path / "bad.json").exit_code == 1
    assert run(tmp_path / "bad.json", "--json").exit_code == 1
    assert run(tmp_path / "good.json").exit_code == 0


def test_exclusive_commands_are_those_that_the_net_sends():
    wrong = run("striker", "--exclusive", "kik")
    assert wrong.exit_code == 2
    assert "command 'kik'. Did you mean 'kick'?" in " ".join(wrong.output.split())
    assert run("go_to_ball", "--exclusive", "dash,turn").exit_code == 0


def test_an_interrupted_analysis_is_exit_status_130(monkeypatch, tmp_path):
    save_net(philosophers(2), tmp_path / "net.json")

    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(reports, "conservative", stop)
    assert run(tmp_path / "net.json").exit_code == 130


def test_ctrl_c_while_exploring_prints_what_is_known_and_is_130(tmp_path):
    save_net(kanban(9), tmp_path / "net.json")
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)  # what Ctrl-C does
    signal.setitimer(signal.ITIMER_REAL, 4.0)
    try:
        answer = run(tmp_path / "net.json")
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert answer.exit_code == 130
    assert "interrupted" in answer.output


def test_questions_are_answered_alone(tmp_path):
    save_net(philosophers(3), tmp_path / "net.json")
    answer = run(tmp_path / "net.json", "--reach", "eats0", "--deadlocks", "--cover", "eats0=1", "--graph", tmp_path / "g.json")
    assert answer.exit_code == 0
    assert "eats0: yes" in answer.output
    assert "1 deadlocks" in answer.output
    assert "can be covered: yes" in answer.output
    assert json.loads((tmp_path / "g.json").read_text())["net"] == "philosophers"
    wrong = run(tmp_path / "net.json", "--reach", "eats7")
    assert wrong.exit_code == 2


@pytest.mark.skipif(not BOMB.is_file(), reason="data of ../shared absent")
def test_a_small_file_that_means_an_enormous_net_is_refused_at_once():
    began = time.process_time()
    answer = run(BOMB, "--seconds", "1.5")
    assert answer.exit_code == 2
    assert time.process_time() - began < 5


@pytest.mark.parametrize(
    "option",
    [("--require", "0.9"), ("--property", "F at_ball"), ("--method", "exact"), ("--output", "here"), ("--episodes", "9"), ("--seed", "3")],
)
def test_what_goes_with_a_world_is_refused_without_one(option):
    found = run("go_to_ball", *option)
    assert (found.exit_code, "go with --in" in found.output) == (2, True)
