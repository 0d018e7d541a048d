"""Configurations: those of the project are whole, and mistakes are named with what is allowed."""

import pytest

from cprm_gym.envs.tasks import TASKS
from cprm_gym.errors import CprmError, FormatError, ParameterError, UnknownName
from cprm_gym.learning.configuration import ALGORITHMS, FOLDER, from_table, read_configuration, read_toml
from cprm_gym.learning.training import Plan


def test_the_projects_files_are_read_whole_and_name_tasks_and_algorithms():
    files = sorted(FOLDER.glob("*.toml"))
    assert len(files) > 2
    for file in files:
        family = [task for task in TASKS if task.startswith(file.stem)]
        assert file.stem == "default" or family
        for algorithm in read_toml(file):
            task = "GoToBall" if file.stem == "default" else family[0]
            assert read_configuration(task, algorithm, file).algorithm == algorithm
    for algorithm in ALGORITHMS:
        for task in TASKS:
            assert read_configuration(task, algorithm).steps > 0


def test_a_file_counts_for_all_tasks_that_begin_so_unless_one_has_its_own():
    kept = {task: read_configuration(task, "maskable_ppo") for task in ("HFO1v0", "HFO1v1", "HFO4v5", "GoToBall")}
    own, family = (read_toml(FOLDER / f"{name}.toml")["maskable_ppo"]["steps"] for name in ("HFO1v0", "HFO"))
    assert own != family
    assert [kept[task].steps for task in ("HFO1v0", "HFO1v1", "HFO4v5")] == [own, family, family]
    assert kept["GoToBall"].steps == read_toml(FOLDER / "default.toml")["maskable_ppo"]["steps"]


@pytest.mark.parametrize(
    ("table", "text"),
    [
        ({"step": 3}, r"unknown key 'step'. Did you mean 'steps'\? Allowed: steps, worlds"),
        ({"steps": 0}, "steps: 0 given; a whole number of at least 1 is needed"),
        ({"worlds": 2.5}, r"worlds: 2\.5 given; a whole number"),
        ({"face": "window"}, "face: 'window' given; allowed are batch, gymnasium"),
        ({"layers": [64, 0]}, "layers: .* a list of whole numbers from 1 to 4096"),
        ({"learner": {"gamma": 2}}, "learner: gamma: 2 given; allowed are numbers from 0 to 1"),
        ({"learner": {"n_steps": 2.5}}, r"learner: n_steps: 2\.5 given; allowed are whole numbers from 2"),
        ({"learner": {"tau": 0.1}}, "learner: PPO takes no 'tau'"),
        ({"learner": {"gama": 0.1}}, r"learner: PPO takes no 'gama'. Did you mean 'gamma'\?"),
        ({"environment": {"action_mode": "box"}}, "environment: 'action_mode' is decided by the algorithm"),
        ({"environment": {"nearer": 1}}, "environment: task 'GoToBall' has no option 'nearer'"),
        ({"environment": {"reward": "speed"}}, "environment: unknown reward term 'speed'"),
        ({"curriculum": [{"steps": 5}]}, "curriculum 1: .* a table of steps and environment is needed"),
        ({"steps": 10, "curriculum": [{"steps": 10, "environment": {}}]}, "its stages take all 10 steps"),
        ("all", "'all' given; a table is needed"),
    ],
)
def test_a_mistake_is_named_with_what_is_allowed(table, text):
    with pytest.raises(ParameterError, match=text) as raised:
        from_table("GoToBall", "ppo", table, "mine.toml [ppo]")
    assert str(raised.value).startswith("mine.toml [ppo]: ")


def test_files_are_checked_when_they_are_read(tmp_path):
    file = tmp_path / "mine.toml"
    for text, error, told in (
        ("[ppo\n", FormatError, "no TOML"),
        ("[ppoo]\n", ParameterError, r"unknown table 'ppoo'. Did you mean 'ppo'\?"),
        ("[sac]\n", ParameterError, r"no table \[ppo\]; it has sac"),
    ):
        file.write_text(text)
        with pytest.raises(error, match=told):
            read_configuration("GoToBall", "ppo", file)
    with pytest.raises(FormatError, match="cannot be read"):
        read_configuration("GoToBall", "ppo", tmp_path / "absent.toml")
    with pytest.raises(UnknownName, match="unknown task 'GoToBal'"):
        read_configuration("GoToBal", "ppo")
    with pytest.raises(UnknownName, match="unknown algorithm 'ppoo'"):
        read_configuration("GoToBall", "ppoo")


def test_a_plan_is_read_as_it_was_written_and_refused_when_damaged(tmp_path):
    plan = Plan.of("maskable_ppo", "HFO1v0", seeds=2, first=3, steps=1000)
    assert plan.command == "cprm-gym train maskable_ppo --task HFO1v0 --seeds 2 --seed 3 --steps 1000"
    plan.write(tmp_path)
    assert Plan.read(tmp_path) == plan
    (tmp_path / "plan.json").write_text('{"configuration": {"task": "HFO1v0", "algorithm": "ppo", "steps": -1}, "seeds": 1}')
    with pytest.raises(CprmError, match="steps: -1 given"):
        Plan.read(tmp_path)
    with pytest.raises(ParameterError, match="seeds: 0 given"):
        Plan.of("ppo", "GoToBall", seeds=0)
