"""Policies as files and in NumPy: equal to PyTorch, refused when damaged, controllers like any other."""

import json
import subprocess
import sys
import zipfile

import numpy as np
import pytest

pytest.importorskip("safetensors")

from cprm_gym.benchmark.episodes import play_episodes
from cprm_gym.envs.controller import check_action
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import CprmError, FormatError, ParameterError, UnknownName
from cprm_gym.learning.networks import choose
from cprm_gym.learning.player import PolicyController, columns_of, low_level, make_controller
from cprm_gym.learning.policy import SHIPPED, Description, Policy, load_policy, save_policy, shipped
from cprm_gym.learning.remembered import MacroPlayer


def described(task="GoToBall", mode="discrete", choices=(6, 5, 24, 5), names=(), **more):
    columns = columns_of(make_task(task), "left_1")
    return Description(algorithm="ppo", task=task, mode=mode, choices=choices, columns=columns, names=names, **more)


def untrained(description, seed=0, width=16, scale=0.5):
    rng = np.random.default_rng(seed)
    sizes = {"layer_0": (width, len(description.columns)), "head": (description.outputs, width)}
    arrays = {}
    for name, (rows, columns) in sizes.items():
        arrays[f"{name}.weight"] = rng.normal(0.0, scale, (rows, columns)).astype(np.float32)
        arrays[f"{name}.bias"] = rng.normal(0.0, scale, rows).astype(np.float32)
    return Policy(description, arrays)


def test_a_policy_is_read_as_it_was_written(tmp_path):
    policy = untrained(described(curve=((100, 0.5, 0.25),), success={"drawn": (9, 10)}, task_options={"far": 20.0}))
    written = save_policy(policy, tmp_path / "mine")
    assert [path.name for path in written] == ["mine.safetensors", "mine.json"]
    for path in (tmp_path / "mine", *written):
        again = load_policy(path)
        assert again.description.curve == policy.description.curve
        assert again.description.columns == policy.description.columns
        assert all((again.arrays[name] == values).all() for name, values in policy.arrays.items())


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"format": "other"}, "no description of a policy"),
        ({"version": 9}, "version 9 given; allowed is 1"),
        ({"mode": "dance"}, "mode: 'dance' given; allowed are discrete, box, macro, option"),
        ({"choices": [6, 5]}, "head: shapes"),
        ({"choices": "all"}, "choices: 'all' given; a list is needed"),
        ({"columns": ["me_x"]}, "layer_0: shapes"),
        ({"speed": 1}, "unknown key 'speed'"),
        ({"sha256": "0"}, "not the arrays that mine.json describes"),
    ],
)
def test_a_damaged_description_is_refused_with_what_is_wrong(tmp_path, change, text):
    tensors, told = save_policy(untrained(described()), tmp_path / "mine")
    told.write_text(json.dumps({**json.loads(told.read_text()), **change}))
    with pytest.raises(FormatError, match=text):
        load_policy(tensors)


def test_files_that_are_no_policies_are_refused(tmp_path):
    tensors, told = save_policy(untrained(described()), tmp_path / "mine")
    content = json.loads(told.read_text())
    tensors.write_bytes(b"\x80\x04\x95 a pickle")
    with pytest.raises(FormatError, match="another sha256"):
        load_policy(tensors)
    import hashlib

    content["sha256"] = hashlib.sha256(tensors.read_bytes()).hexdigest()
    told.write_text(json.dumps(content))
    with pytest.raises(FormatError, match="no arrays in the form safetensors"):
        load_policy(tensors)
    told.write_text("[")
    with pytest.raises(FormatError, match="no JSON"):
        load_policy(tensors)
    with pytest.raises(FormatError, match="cannot be read"):
        load_policy(tmp_path / "absent")
    with zipfile.ZipFile(tmp_path / "model.zip", "w") as archive:
        archive.writestr("data", "{}")
    with pytest.raises(CprmError, match="loading one executes code that it holds"):
        load_policy(tmp_path / "model.zip")


def test_arrays_that_make_no_network_are_refused():
    policy = untrained(described())
    for change, text in (
        ({"head.bias": np.zeros(3)}, r"head: shapes \(40, 16\) and \(3,\)"),
        ({"layer_0.weight": np.full((16, 30), np.nan)}, "layer_0.weight' holds what is no finite number"),
        ({"extra": np.zeros(1)}, "array 'extra' belongs to no network"),
    ):
        with pytest.raises(ParameterError, match=text):
            Policy(policy.description, {**policy.arrays, **change})
    with pytest.raises(ParameterError, match=r"array 'head\.bias' is missing"):
        Policy(policy.description, {name: values for name, values in policy.arrays.items() if name != "head.bias"})


def test_what_is_drawn_has_the_probabilities_of_the_preferences_and_never_what_is_masked():
    logits = np.log(np.tile([0.1, 0.2, 0.3, 0.4], (20_000, 1)))
    uniform = np.random.default_rng(0).random(20_000)
    share = np.bincount(choose(logits, None, uniform), minlength=4) / 20_000
    assert share == pytest.approx([0.1, 0.2, 0.3, 0.4], abs=0.015)
    mask = np.tile([True, False, True, False], (20_000, 1))
    share = np.bincount(choose(logits, mask, uniform), minlength=4) / 20_000
    assert share == pytest.approx([0.25, 0.0, 0.75, 0.0], abs=0.015)
    assert (choose(logits, mask, None) == 2).all()
    assert (choose(logits, mask, np.full(20_000, 1.0 - 1e-16)) == 2).all()


@pytest.mark.parametrize("mode", ["discrete", "box"])
def test_low_level_actions_mean_what_the_view_means(mode):
    core = SoccerCore("GoToBall", 50, action_mode=mode)
    core.reset(1)
    rng = np.random.default_rng(0)
    action = rng.integers(0, [6, 5, 24, 5], (50, 4)) if mode == "discrete" else rng.uniform(-1, 1, (50, 6))
    theirs = core.commanded(action[:, None]).copy()
    hybrid = SoccerCore("GoToBall", 50)
    hybrid.reset(1)
    ours = hybrid.commanded({key: np.asarray(values)[:, None] for key, values in low_level(mode, action).items()})
    for name in ("kind", "a", "b", "turn_neck"):
        told = ours[name][:, 0]
        wanted = theirs[name][:, 0]
        used = theirs["kind"][:, 0] > 0 if name == "a" else slice(None)
        assert np.nan_to_num(told[used]) == pytest.approx(np.nan_to_num(wanted[used]), abs=1e-4)


@pytest.mark.parametrize("task", ["HFO1v1", "Keepaway3v2", "FrontGoalPassingLane"])
def test_macros_from_observations_are_those_of_the_engine(task):
    core = SoccerCore(task, 30, action_mode="macro", include=("memory",))
    observation = core.reset(3)
    player = MacroPlayer(core.task, 1, 30)
    assert player.names == core.macros.names
    rng = np.random.default_rng(0)
    player.reset(slice(None))
    same = []
    for _ in range(40):
        mask = player.observe({name: values[:, 0] for name, values in observation.items()})
        same.append((mask == core.action_mask[:, 0]).all(axis=1))
        choice = (rng.random(core.action_mask.shape) * core.action_mask).argmax(axis=2)
        mine = player.act(choice[:, 0])
        core.step(choice)
        kinds = core.sim.commands["kind"][:, 0]
        same.append(mine["type"] == kinds)
        observation = core.observation
    assert np.mean(same) > 0.99, "single precision may decide otherwise on an edge"


@pytest.mark.parametrize("drawn", [False, True])
def test_a_policy_plays_the_benchmark_and_a_world_does_not_depend_on_the_others(drawn):
    policy = untrained(described())
    task = make_task("GoToBall")
    played = []
    for worlds in (6, 3):
        controller = PolicyController(policy, task, "left_1", drawn)
        core = SoccerCore(task, worlds, seed=5, include=controller.needs)
        observation = core.reset(5)
        seen = {key: values[:, 0] for key, values in observation.items()}
        controller.reset(seen, 7)
        for _ in range(15):
            action = check_action("policy", controller.act({key: values[:, 0] for key, values in core.observation.items()}), worlds)
            core.step({key: np.asarray(values)[:, None] for key, values in action.items()})
        played.append(core.sim.world["pos"][:3, 1].copy())
    assert (played[0] == played[1]).all()


def test_the_controller_named_policy_says_what_there_is(tmp_path):
    task = make_task("GoToBall")
    save_policy(untrained(described()), tmp_path / "mine")
    assert make_controller(task, "left_1", str(tmp_path / "mine"), True).drawn
    with pytest.raises(UnknownName, match="unknown policy 'nobody'"):
        make_controller(task, "left_1", "nobody")
    with pytest.raises(UnknownName, match="none of the project's policies is for Soccer5v5"):
        make_controller(make_task("Soccer5v5"), "left_1")
    with pytest.raises(ParameterError, match="it takes in 30 of the 40 columns that left_1 observes"):
        PolicyController(untrained(described()), make_task("HFO1v1"), "left_1")
    with pytest.raises(ParameterError, match="it takes in 'opponent_1_sin', which left_1 does not observe"):
        PolicyController(untrained(described("HFO1v1")), task, "left_1")


@pytest.mark.parametrize("name", shipped())
def test_policies_that_are_shipped_are_small_whole_and_play(name):
    policy = load_policy(SHIPPED / name)
    assert (SHIPPED / f"{name}.safetensors").stat().st_size < 1_000_000
    assert policy.description.success["drawn"][1] >= 200
    assert policy.description.command.startswith("cprm-gym train ")
    task = make_task(policy.description.task)
    controller = make_controller(task, "left_1", name)
    core = SoccerCore(task, 4, controlled="left_1", seed=1, include=controller.needs)
    observation = core.reset(1)
    controller.reset({key: values[:, 0] for key, values in observation.items()}, 0)
    for _ in range(3):
        action = check_action(name, controller.act({key: values[:, 0] for key, values in core.observation.items()}), 4)
        core.step({key: np.asarray(values)[:, None] for key, values in action.items()})


@pytest.mark.parametrize("name", shipped())
def test_policies_that_are_shipped_play_better_than_random_choices(name):
    """A network of zeros, drawn from, prefers nothing: it is the floor."""
    policy = load_policy(SHIPPED / name)
    floor = Policy(policy.description, {key: np.zeros_like(values) for key, values in policy.arrays.items()})
    task = make_task(policy.description.task, **policy.description.task_options)
    reached = []
    for who, drawn in ((policy, False), (floor, True)):
        found = play_episodes(task, lambda task, agent, who=who, drawn=drawn: PolicyController(who, task, agent, drawn), 100, 40)
        reached.append(found.cycles / task.max_cycles if task.metric == "duration" else found.success)
    ours, random = (np.asarray(values, float) for values in reached)
    assert ours.mean() - random.mean() > 2 * (ours - random).std() / 10, "by more than two standard errors of 100 pairs"


def test_policies_that_are_shipped_are_read_and_choose_without_pytorch():
    code = """
import sys
sys.modules["torch"] = None
import numpy as np
from cprm_gym.learning.policy import SHIPPED, load_policy, shipped
for name in shipped():
    policy = load_policy(SHIPPED / name)
    policy.act(np.zeros((3, len(policy.description.columns)), np.float32))
    print(name)
"""
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert tuple(told.split()) == shipped()


@pytest.mark.parametrize("drawn", [False, True])
def test_a_policy_plays_beside_the_agents_and_is_saved_with_them(drawn):
    policy = untrained(described("HFO1v1", "macro", (12,), MacroPlayer(make_task("HFO1v1"), 12, 1).names))

    def opponent(task, agent):
        return PolicyController(policy, task, agent, drawn)

    core = SoccerCore("HFO1v1", 3, action_mode="discrete", controlled="left", others=("hold", opponent))
    core.reset(2)
    rng = np.random.default_rng(0)
    actions = rng.integers(0, [6, 5, 24, 5], (30, 3, 1, 4))
    for action in actions[:15]:
        core.step(action)
    state = core.save_state()
    first = [core.step(action) and core.sim.world["pos"][:, 12].copy() for action in actions[15:]]
    core.load_state(state)
    again = [core.step(action) and core.sim.world["pos"][:, 12].copy() for action in actions[15:]]
    assert all((a == b).all() for a, b in zip(first, again))
    assert np.ptp(np.array(first), axis=0).max() > 0.1, "he moves"
