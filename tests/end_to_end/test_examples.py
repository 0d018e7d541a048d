"""The examples run, and show what they say."""

import importlib.util
import subprocess
import sys

import pytest
from paths import ROOT

from cprm_gym.architecture.analysis.report import analyze
from cprm_gym.architecture.cprm import cprm_from_json, cprm_to_json


def load(name):
    spec = importlib.util.spec_from_file_location(name, ROOT / "examples" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


machine = load("two_armed_machine")


def test_belief_saves_the_machine_empty_grips():
    believing, gullible = (machine.run(c, 200, 300, seed=3) for c in (machine.BELIEVER, machine.GULLIBLE))
    assert believing[1].mean() < 0.5 * gullible[1].mean()
    assert believing[0].mean() > 0.8 * gullible[0].mean()


def test_one_press_is_never_used_by_both_arms():
    report = analyze(machine.machine_net(believing=False), minimal=True)
    assert report.timed.complete
    assert report.timed.never_stops.holds
    assert report.untimed.bounded.holds
    # the token of the press is in one place only: a minimal P-invariant of weight 1 holds both arms' pressing
    using = {"press", "left.pressing", "right.pressing"}
    (found,) = [v for v in report.p_invariants.vectors if using <= set(v.weights) and "left.begin" not in v.weights]
    assert set(found.weights.values()) == {1}
    assert found.value == 1


def test_the_machine_is_a_value_that_can_be_saved():
    assert cprm_from_json(cprm_to_json(machine.BELIEVER)) == machine.BELIEVER


def test_the_example_runs_as_a_program():
    command = [sys.executable, ROOT / "examples" / "two_armed_machine.py", "20", "50"]
    out = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "parts pressed" in out.stdout
    assert "machine without belief" in out.stdout


@pytest.mark.parametrize("arguments", [["few"], ["-5", "0"]])
def test_the_example_refuses_wrong_numbers_in_a_line(arguments):
    command = [sys.executable, ROOT / "examples" / "two_armed_machine.py", *arguments]
    out = subprocess.run(command, capture_output=True, text=True, check=False)
    assert out.returncode == 2
    assert "error: " in out.stderr
    assert "Traceback" not in out.stderr


def test_the_package_is_the_command_too():
    out = subprocess.run([sys.executable, "-m", "cprm_gym", "--version"], capture_output=True, text=True, check=True)
    assert out.stdout.startswith("cprm_gym ")
