"""Controllers by name, and the options behind it."""

import pytest
from typer.testing import CliRunner

from cprm_gym.benchmark.plan import Plan
from cprm_gym.cli import app
from cprm_gym.envs.others.registry import load_controller, split_options, with_options
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ParameterError, UnknownName


def test_options_stand_behind_a_name():
    assert split_options("cprm:t_b=5:focus=true:engine=exact:latency=-1") == (
        "cprm",
        {"t_b": 5, "focus": True, "engine": "exact", "latency": -1},
    )
    assert split_options("fsm") == ("fsm", {})


@pytest.mark.parametrize("name", ["cprm:", "cprm:t_b", "cprm:t_b=", "cprm:=5", "cprm:t-b=5", "cprm:t_b=5:t_b=6"])
def test_what_is_no_option_is_refused(name):
    with pytest.raises(ParameterError, match="is no option"):
        split_options(name)


def test_a_controller_takes_its_options_and_no_others():
    agent = load_controller("cprm:model=bins:t_b=5:latency=2")(make_task("Goalie"), "left_1")
    assert (agent.options["t_b"], agent.options["latency"]) == (5, 2)
    with pytest.raises(ParameterError, match="'fsm' has no option 't_b'"):
        load_controller("fsm:t_b=5")
    with pytest.raises(UnknownName, match="controller"):
        load_controller("cprmm:t_b=5")
    assert Plan(controllers=("cprm:t_b=5", "fsm")).blocks()[0].controller == "cprm:t_b=5"


def test_timing_is_that_of_the_controllers_of_the_architecture():
    assert with_options(["cprm:engine=exact", "fsm"], t_b=5, latency=None) == ("cprm:engine=exact:t_b=5", "fsm")
    assert with_options(["fsm"], t_b=None) == ("fsm",)
    with pytest.raises(ParameterError, match="t_b: of the controller 'cprm'; named are fsm"):
        with_options(["fsm"], t_b=5)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (["benchmark", "--tasks", "Goalie", "--controllers", "fsm", "--t-b", "5"], "of the controller 'cprm'"),
        (["benchmark", "--suite", "knowledge", "--t-b", "5"], "--t-b does not go with --suite"),
        (["play", "--task", "Goalie", "--t-b", "5"], "of the controller 'cprm'; named are none"),
        (["play", "--task", "Goalie", "--controller", "cprm:model=bins", "--t-b", "0"], "t_b: 0 given"),
        (["play", "--task", "Goalie", "--controller", "cprm", "--t-b", "5"], "write model=bins"),
        (["demo", "goalie", "--t-b", "5"], "write model=bins"),
        (["demo", "goalie", "--model", "bin"], "Did you mean 'bins'"),
        (["demo", "striker", "--latency", "3"], "no model"),
    ],
)
def test_timing_on_the_command_line_is_refused_where_nobody_infers(line, said):
    result = CliRunner().invoke(app, line)
    assert result.exit_code == 2
    assert said in result.output


def test_timing_on_the_command_line_is_noted_in_the_plan(tmp_path):
    line = ["benchmark", "--tasks", "GoToBall", "--controllers", "cprm", "--t-b", "4", "--latency", "3", "--episodes", "4"]
    result = CliRunner().invoke(app, [*line, "--output", str(tmp_path)])
    assert result.exit_code == 0, result.output
    (folder,) = tmp_path.iterdir()
    assert Plan.read(folder).controllers == ("cprm:t_b=4:latency=3",)
