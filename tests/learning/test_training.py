"""Trainings: every algorithm learns a little and leaves a policy equal to PyTorch's; what is interrupted goes on; the end is measured."""

import itertools
import json

import numpy as np
import pytest

pytest.importorskip("sb3_contrib")
pytest.importorskip("safetensors")

import torch
from typer.testing import CliRunner

from cprm_gym.cli import app
from cprm_gym.errors import FormatError
from cprm_gym.learning import training
from cprm_gym.learning.configuration import from_table
from cprm_gym.learning.export import arrays_of
from cprm_gym.learning.measuring import interquartile_mean, measure, measure_random
from cprm_gym.learning.policy import SHIPPED, load_policy, shipped
from cprm_gym.learning.report import Report
from cprm_gym.learning.training import Plan, make_learner, policy_of, read_curve, train
from cprm_gym.learning.worlds import columns_of, make_worlds
from cprm_gym.wrappers.sb3 import SoccerVecEnv

SMALL = {"worlds": 2, "episodes": 4, "evaluations": 2, "steps": 128}
PPO = {"n_steps": 32, "batch_size": 32, "n_epochs": 1}
EASY = {"max_cycles": 20, "near": 4.0, "far": 6.0, "rolling": 0.0}


def small(algorithm, task="GoToBall", **more):
    learner = {"learning_starts": 20, "batch_size": 16, "buffer_size": 1000} if algorithm == "sac" else PPO
    table = {**SMALL, "learner": learner, "layers": [16], "environment": EASY if task == "GoToBall" else {"max_cycles": 30}, **more}
    return from_table(task, algorithm, table, "test")


CASES = [
    ("ppo", "GoToBall", {}),
    ("ppo", "GoToBall", {"face": "gymnasium"}),
    ("recurrent_ppo", "GoToBall", {}),
    ("sac", "GoToBall", {}),
    ("maskable_ppo", "HFO1v0", {}),
    ("belief_ppo", "GoToBall", {}),
    ("shared_ppo", "PassAndAdvance", {}),
    ("options", "HFO1v0", {"steps": 16, "learner": {**PPO, "n_steps": 4, "batch_size": 4}, "longest": 3}),
]


@pytest.mark.parametrize(("algorithm", "task", "more"), CASES, ids=[f"{a}-{m.get('face', 'batch')}" for a, _, m in CASES])
def test_every_algorithm_trains_and_its_policy_in_numpy_equals_pytorch(tmp_path, algorithm, task, more):
    plan = Plan(small(algorithm, task, **more), seeds=1, command="cprm-gym train")
    plan.write(tmp_path)
    train(plan, tmp_path)
    report = Report.of(tmp_path)
    assert report.complete
    policy = load_policy(tmp_path / "seed_0" / "best")
    assert policy.description.success["drawn"][1] == 4
    env = make_worlds(plan.configuration, 2, 0)
    model = make_learner(plan.configuration, env, 5)
    mine = policy_of(model, plan, 5, [])
    assert mine.description.columns == policy.description.columns == columns_of(env)
    space = env.observation_space
    rng = np.random.default_rng(0)
    x = rng.uniform(-1, 1, (7, len(mine.description.columns))).astype(np.float32)
    t = torch.as_tensor(x)
    with torch.no_grad():
        if algorithm == "sac":
            mean, log_std, _ = model.actor.get_action_dist_params(t)
            ours = mine.network.gaussian(x)
            assert ours[0] == pytest.approx(mean.numpy(), abs=1e-5)
            assert ours[1] == pytest.approx(log_std.exp().numpy(), abs=1e-5)
            return
        if algorithm == "recurrent_ppo":
            state, theirs = None, tuple(torch.zeros(1, 7, model.policy.lstm_actor.hidden_size) for _ in range(2))
            for step in range(3):
                x_now = np.roll(x, step, axis=0)
                distribution, theirs = model.policy.get_distribution(torch.as_tensor(x_now), theirs, torch.zeros(7))
                ours, state = mine.network(x_now, state)
                wanted = torch.cat([part.logits for part in distribution.distribution], dim=1).numpy()
                at = np.cumsum([0, *mine.description.choices])
                for a, b in itertools.pairwise(at):
                    shifted = ours[:, a:b] - np.log(np.exp(ours[:, a:b]).sum(axis=1, keepdims=True))
                    assert shifted == pytest.approx(wanted[:, a:b], abs=1e-5)
            return
        if more.get("face") == "gymnasium":
            at, given = 0, {}
            for part, box in space.spaces.items():
                size = int(np.prod(box.shape))
                given[part] = t[:, at : at + size].reshape(7, *box.shape)
                at += size
            t = given
        features = model.policy.extract_features(t)
        if isinstance(features, tuple):
            features = features[0]
        wanted = model.policy.action_net(model.policy.mlp_extractor.forward_actor(features)).numpy()
    assert mine.network(x)[0] == pytest.approx(wanted, abs=1e-5)


@pytest.mark.parametrize("name", shipped())
def test_the_networks_that_are_shipped_equal_those_of_pytorch(name):
    policy = load_policy(SHIPPED / name)
    layers = []
    for part in (*(f"layer_{k}" for k in range(len(policy.arrays) // 2 - 1)), "head"):
        weight, bias = (torch.as_tensor(policy.arrays[f"{part}.{kind}"]) for kind in ("weight", "bias"))
        layer = torch.nn.Linear(*reversed(weight.shape))
        layer.load_state_dict({"weight": weight, "bias": bias})
        layers += [layer, {"tanh": torch.nn.Tanh, "relu": torch.nn.ReLU}[policy.description.activation]()]
    x = np.random.default_rng(0).uniform(-1, 1, (50, len(policy.description.columns))).astype(np.float32)
    with torch.no_grad():
        wanted = torch.nn.Sequential(*layers[:-1])(torch.as_tensor(x)).numpy()
    assert policy.network(x)[0] == pytest.approx(wanted, abs=1e-5)


def test_likeliest_actions_are_those_of_the_learner():
    configuration = small("maskable_ppo", "HFO1v0")
    env = make_worlds(configuration, 6, 1)
    model = make_learner(configuration, env, 2)
    policy = policy_of(model, Plan(configuration), 2, [])
    observation = env.reset()
    for _ in range(10):
        masks = env.action_masks()
        theirs, _ = model.predict(observation, action_masks=masks, deterministic=True)
        ours, _ = policy.act(observation, masks)
        assert (ours == theirs).all()
        observation, *_ = env.step(ours)


@pytest.mark.parametrize("algorithm", ["ppo", "sac"])
def test_an_interrupted_training_goes_on_where_it_was(tmp_path, algorithm, monkeypatch):
    plan = Plan(small(algorithm), seeds=1)
    plan.write(tmp_path)
    keep, calls = training._Run.keep, []

    def interrupted(self, model):
        keep(self, model)
        calls.append(model.num_timesteps)
        if len(calls) == 1:
            kept.append({name: values.copy() for name, values in arrays_of(model.policy.state_dict()).items()})
            raise KeyboardInterrupt

    kept = []
    monkeypatch.setattr(training._Run, "keep", interrupted)
    with pytest.raises(KeyboardInterrupt):
        train(plan, tmp_path)
    monkeypatch.undo()
    own = tmp_path / "seed_0"
    steps = json.loads((own / "learner.json").read_text())["steps"]
    assert 0 < steps < 128
    assert len(read_curve(own)) == 1
    env = make_worlds(plan.configuration, 2, 0)
    model = make_learner(plan.configuration, env, 9)
    run = training._Run(plan, 0, own, None)
    run.take_up(model)
    assert model.num_timesteps == steps
    assert all((kept[-1][name] == values).all() for name, values in arrays_of(model.policy.state_dict()).items())
    if algorithm == "ppo":
        moments = model.policy.optimizer.state_dict()["state"]
        assert len(moments) > 4
        assert all(float(moment["exp_avg_sq"].sum()) > 0 for key, moment in moments.items() if key in (0, 1))
    else:
        assert model.replay_buffer.pos * 2 == steps
    train(plan, tmp_path)
    assert Report.of(tmp_path).complete
    assert read_curve(own)[-1].steps >= 128


def contents(folder):
    """Curve and weights of every seed."""
    found = {}
    for own in sorted(folder.glob("seed_*")):
        found[own.name, "curve"] = [(p.steps, p.drawn, p.likeliest) for p in read_curve(own)]
        found[own.name, "weights"] = {name: values.tobytes() for name, values in load_policy(own / "best").arrays.items()}
    return found


def test_seeds_trained_by_two_processes_learn_the_same(tmp_path):
    plan, told = Plan(small("ppo"), seeds=2), []
    for name, workers in (("one", 1), ("two", 2)):
        (tmp_path / name).mkdir()
        plan.write(tmp_path / name)
        train(plan, tmp_path / name, lambda *news: told.append(news), workers)
    assert contents(tmp_path / "one") == contents(tmp_path / "two") != {}
    assert {(seed, steps, None) for seed, steps, worth in told[-2:]} == {(0, 128, None), (1, 128, None)}
    assert Report.of(tmp_path / "two").complete


def test_seeds_trained_by_a_ray_cluster_learn_the_same(tmp_path):
    pytest.importorskip("ray")
    plan = Plan(small("ppo"), seeds=2)
    for name, address in (("here", None), ("there", "local")):
        (tmp_path / name).mkdir()
        plan.write(tmp_path / name)
        train(plan, tmp_path / name, ray=address)
    assert contents(tmp_path / "here") == contents(tmp_path / "there") != {}


def test_time_outs_are_bootstrapped_and_ends_are_not():
    env = SoccerVecEnv("GoToBall", worlds=3, flatten=True, max_cycles=4, near=30.0, far=31.0)
    env.reset()
    for _ in range(4):
        _, _, dones, infos = env.step(np.zeros((3, 4), int))
    assert dones.all()
    assert all(info["TimeLimit.truncated"] and len(info["terminal_observation"]) == 30 for info in infos)
    model = make_learner(small("ppo", learner={"n_steps": 4, "batch_size": 4, "n_epochs": 1, "gamma": 0.5}), env, 0)
    seen = []
    model.policy.predict_values = lambda observation: seen.append(observation) or torch.full((len(observation), 1), 8.0)
    model.learn(12)
    assert model.rollout_buffer.rewards[3] == pytest.approx(4.0, abs=0.1), "gamma times the value of where time ran out"
    assert model.rollout_buffer.rewards[:3] == pytest.approx(0.0, abs=0.1)


def test_measurements_are_the_same_every_time_and_do_not_depend_on_who_else_is_measured():
    configuration = small("ppo")
    env = make_worlds(configuration, 2, 0)
    policy = policy_of(make_learner(configuration, env, 0), Plan(configuration), 0, [])
    many, few = measure(policy, configuration, True, 5, 12), measure(policy, configuration, True, 5, 5)
    assert (many.cycles[:5] == few.cycles).all()
    assert many.reward[:5] == pytest.approx(few.reward)


@pytest.mark.parametrize(
    ("algorithm", "task"), [("ppo", "GoToBall"), ("sac", "GoToBall"), ("maskable_ppo", "HFO1v0"), ("options", "HFO1v0")]
)
def test_the_floor_is_random_play_of_what_can_be_chosen(algorithm, task):
    configuration = small(algorithm, task)
    found = measure_random(configuration, 3, 5)
    assert found.cycles.min() > 0
    assert found.cycles.max() <= configuration.environment["max_cycles"]
    again = measure_random(configuration, 3, 5)
    assert (again.cycles == found.cycles).all()
    assert (again.reward == found.reward).all()


def test_what_lasts_is_measured_in_seconds(tmp_path):
    plan = Plan(small("maskable_ppo", "Keepaway3v2"), seeds=1)
    plan.write(tmp_path)
    train(plan, tmp_path)
    report = Report.of(tmp_path)
    assert report.metric == "seconds"
    cycles = report.ends[0]["drawn"]["cycles"]
    assert min(cycles) > 0
    assert report.rate(0, "drawn") == pytest.approx(np.mean(cycles) / 10)
    assert 0 < report.curves[0][-1].drawn <= 3.0
    assert report.rows()[-1][0] == "random"
    text = report.to_markdown()
    assert "seconds, drawn" in text
    assert "success" not in text
    assert ": seconds, " in report.to_svg()
    assert report.to_marl_eval()["cprm_gym"]["Keepaway3v2"]["maskable_ppo"]["seed_0"]["absolute_metrics"]["seconds"] == [
        c / 10 for c in cycles
    ]
    (tmp_path / "random.json").write_text('{"success": []}')
    with pytest.raises(FormatError, match=r"random\.json: no result of a training"):
        Report.of(tmp_path)


def test_the_interquartile_mean_leaves_out_the_outer_quarters():
    found = interquartile_mean([0.0, 0.8, 0.9, 1.0, 1.0, 1.0, 1.0, 1.0])
    assert found.centre == pytest.approx(np.mean([0.9, 1.0, 1.0, 1.0]))
    assert found.low <= found.centre <= found.high
    assert interquartile_mean([0.5]) == (0.5, 0.5, 0.5)


def test_the_command_trains_tells_exports_and_refuses(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(
        "[ppo]\nsteps = 64\nworlds = 2\nepisodes = 4\nevaluations = 1\nlayers = [8]\n[ppo.environment]\nmax_cycles = 10\n"
        "[ppo.learner]\nn_steps = 16\nbatch_size = 16\nn_epochs = 1\n[[ppo.curriculum]]\nsteps = 32\nenvironment = { far = 6.0 }\n"
    )
    run = CliRunner().invoke
    words = ["train", "ppo", "--seeds", "2", "--config", str(file), "--output", str(tmp_path), "--export", str(tmp_path / "best")]
    done = run(app, words)
    assert done.exit_code == 0, done.output
    (folder,) = tmp_path.glob("GoToBall-ppo-*")
    assert "2 seeds, interquartile mean" in (folder / "report.md").read_text()
    told = json.loads((folder / "marl_eval.json").read_text())["cprm_gym"]["GoToBall"]["ppo"]
    assert set(told) == {"seed_0", "seed_1"}
    assert len(told["seed_0"]["absolute_metrics"]["success"]) == 4
    assert (folder / "curve.svg").read_text().startswith("<svg")
    policy = load_policy(tmp_path / "best")
    assert policy.description.command == f"cprm-gym train ppo --task GoToBall --seeds 2 --config {file}"
    assert run(app, ["train", "--resume", str(folder)]).exit_code == 0
    for words, text in (
        ([], "an algorithm is needed"),
        (["ppoo"], "unknown algorithm 'ppoo'"),
        (["ppo", "--resume", str(folder)], "ALGORITHM does not go with --resume"),
        (["--resume", str(tmp_path / "absent")], "there is no such folder"),
        (["--like", "x"], "--like goes with --convert"),
        (["--convert", "x.zip"], "--convert needs --like"),
    ):
        failed = run(app, ["train", *words])
        assert failed.exit_code == 2
        assert text in failed.output.replace("\n", " ")


def test_a_model_of_stable_baselines3_is_converted_in_another_process_and_code_in_it_is_not_run(tmp_path):
    import zipfile

    configuration = small("ppo")
    env = make_worlds(configuration, 2, 0)
    plan, model = Plan(configuration), make_learner(configuration, env, 3)
    from cprm_gym.learning.policy import save_policy

    save_policy(policy_of(make_learner(configuration, env, 4), plan, 4, []), tmp_path / "like")
    model.save(tmp_path / "model.zip")
    words = ["train", "--convert", str(tmp_path / "model.zip"), "--like", str(tmp_path / "like"), "--export", str(tmp_path / "made")]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    assert "would be executed if they were loaded" in done.output.replace("\n", " ")
    made = load_policy(tmp_path / "made")
    assert all((made.arrays[name] == values).all() for name, values in arrays_of(model.policy.state_dict()).items())
    marker = tmp_path / "was_here"

    class Harmful:
        def __reduce__(self):
            return (open, (str(marker), "w"))

    torch.save({"action_net.weight": Harmful()}, tmp_path / "policy.pth")
    with zipfile.ZipFile(tmp_path / "evil.zip", "w") as archive:
        archive.write(tmp_path / "policy.pth", "policy.pth")
    failed = CliRunner().invoke(app, [*words[:2], str(tmp_path / "evil.zip"), *words[3:]])
    assert failed.exit_code == 2
    assert "cannot be converted" in failed.output.replace("\n", " ")
    assert not marker.exists()
