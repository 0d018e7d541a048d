"""GoToBall: starts, ends, batches, vector environments and errors."""

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from cprm_gym.envs import soccer_v2
from cprm_gym.envs.actions import scaled
from cprm_gym.envs.core import SoccerCore, select_agents
from cprm_gym.envs.observations import MAX_AGE, BodyFeature
from cprm_gym.envs.single import SoccerEnv
from cprm_gym.envs.tasks import GoToBall, Status, make_task
from cprm_gym.envs.vector import SoccerVectorEnv
from cprm_gym.errors import CommandError, CprmError, ParameterError, UnknownName


def hybrid(core, kind, *params):
    shape = (core.worlds, len(core.agents))
    return {"type": np.full(shape, kind), "params": np.broadcast_to(scaled(int(kind), *params), (*shape, 4))}


def test_the_ball_starts_five_to_forty_metres_away_in_every_direction():
    core = SoccerCore(GoToBall(), worlds=2000, seed=1)
    core.reset(1)
    w = core.sim.world
    offset = w["pos"][:, 0] - w["pos"][:, 1]
    distance = np.hypot(*offset.T)
    assert distance.min() >= 5.0 - 1e-9
    assert distance.max() <= 40.0 + 1e-9
    assert np.abs(w["pos"][:, :2, 0]).max() <= 51.5
    assert np.abs(w["pos"][:, :2, 1]).max() <= 33.0
    relative = np.arctan2(offset[:, 1], offset[:, 0]) - w["body"][:, 0]
    counts, _ = np.histogram((relative + np.pi) % (2 * np.pi), bins=8, range=(0, 2 * np.pi))
    assert counts.min() > 0.6 * 2000 / 8
    moving = np.hypot(*w["vel"][:, 0].T)
    assert 0.35 < np.mean(moving > 0) < 0.6
    rest = w["pos"][:, 0] + w["vel"][:, 0] / (1 - 0.94)
    assert (np.abs(rest) <= [51.5 + 1e-9, 33.0 + 1e-9]).all()


def test_world_k_of_a_batch_equals_the_same_world_alone():
    batch = SoccerCore(GoToBall(), worlds=256, seed=11)
    batch.reset(11)
    chosen = (0, 1, 100, 255)
    alone = {k: SoccerCore(GoToBall(), worlds=1, seed=11, first_world=k) for k in chosen}
    for core in alone.values():
        core.reset(11)
    draws = np.random.default_rng(0)
    for _ in range(60):
        kind, power, direction = draws.integers(0, 4), draws.uniform(0, 100), draws.uniform(-180, 180)
        batch.step(hybrid(batch, kind, power, direction))
        for k, core in alone.items():
            core.step(hybrid(core, kind, power, direction))
            assert core.sim.world[0].tobytes() == batch.sim.world[k].tobytes()
            for name, values in core.observation.items():
                assert values[0].tobytes() == batch.observation[name][k].tobytes()


def test_threads_do_not_change_anything():
    cores = [SoccerCore(GoToBall(), worlds=64, seed=2, threads=t) for t in (1, 3)]
    for core in cores:
        core.reset(2)
        for _ in range(20):
            core.step(hybrid(core, 1, 80.0, 5.0))
    assert cores[0].sim.world.tobytes() == cores[1].sim.world.tobytes()


def test_reaching_the_ball_ends_the_episode_with_success():
    core = SoccerCore(GoToBall(), worlds=1, seed=0)
    core.reset(0)
    w = core.sim.world
    w["pos"][0, 1], w["vel"][0, 0] = w["pos"][0, 0] - [2.0, 0.0], 0.0
    w["body"][0, 0] = w["body_staged"][0, 0] = 0.0
    for _ in range(10):
        step = core.step(hybrid(core, 1, 100.0, 0.0))
        if step.terminated[0]:
            break
    assert step.success[0]
    assert step.reward[0, 0] == 1.0
    assert step.status[0] == Status.SUCCESS


def test_time_runs_out():
    env = gymnasium.make("cprm/GoToBall-v2", action_mode="hybrid", max_cycles=7, reward="sparse")
    env.reset(seed=0)
    action = {"type": 0, "params": np.zeros(4, np.float32), "turn_neck": np.zeros(1, np.float32), "view": 0}
    for i in range(7):
        _, reward, terminated, truncated, info = env.step(action)
        assert (reward, terminated, truncated) == (0.0, False, i == 6)
    assert info["status"] == Status.OUT_OF_TIME


def test_what_is_not_seen_is_zero_with_level_zero_and_ages():
    core = SoccerCore(GoToBall(), worlds=200, seed=4)
    o = core.reset(4)
    assert o["body"][:, 0, BodyFeature.FRESH].all(), "the eyes are open when an episode starts"
    unseen = o["level"][:, 0, 0] == 0
    assert 0 < unseen.sum() < 200
    assert (o["ball"][unseen] == 0).all()
    assert (o["age"][unseen, 0, 0] == MAX_AGE).all()
    assert (o["age"][~unseen, 0, 0] == 0).all()
    blind = core.step(hybrid(core, 0)) and core.observation
    assert not blind["body"][:, 0, BodyFeature.FRESH].any(), "the normal view brings a look every second cycle"
    assert (blind["level"] == 0).all()
    assert (blind["age"][~unseen, 0, 0] == 1).all()
    assert (blind["age"][unseen, 0, 0] == MAX_AGE).all()


def test_a_seed_fixes_the_observations_of_the_gymnasium_environment():
    env = gymnasium.make("cprm/GoToBall-v2")
    first, second, other = env.reset(seed=3)[0], env.reset(seed=3)[0], env.reset(seed=4)[0]
    assert all((first[k] == second[k]).all() for k in first)
    assert any((first[k] != other[k]).any() for k in first)


def test_episodes_after_the_first_differ():
    env = gymnasium.make("cprm/GoToBall-v2", debug_info=True)
    truths = [env.reset(seed=1 if i == 0 else None)[1]["truth"] for i in range(3)]
    assert not np.array_equal(truths[0], truths[1])
    assert not np.array_equal(truths[1], truths[2])


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_vector_environments_reset_as_their_mode_says(mode):
    envs = gymnasium.make_vec("cprm/GoToBall-v2", num_envs=5, max_episode_steps=4, vector_kwargs={}, autoreset_mode=mode)
    assert envs.metadata["autoreset_mode"] == mode
    names = envs.core.preset.names
    observations, _ = envs.reset(seed=2)
    assert envs.observation_space.contains(observations)
    envs.action_space.seed(0)
    for _ in range(4):
        observations, _, terminated, truncated, info = envs.step(envs.action_space.sample())
    assert truncated.all()
    assert not terminated.any()
    if mode == AutoresetMode.SAME_STEP:
        assert (observations["me"][:, names.index("me_fresh")] == 1).all()
        assert info["final_obs"][0]["me"].shape == (17,)
        assert (envs.core.cycle == 0).all()
    elif mode == AutoresetMode.NEXT_STEP:
        assert (envs.core.cycle == 4).all()
        _, reward, terminated, truncated, _ = envs.step(envs.action_space.sample())
        assert not truncated.any()
        assert (reward == 0).all()
        assert (envs.core.cycle == 0).all()
    else:
        with pytest.raises(CprmError, match=r"worlds \[0, 1, 2, 3, 4\] are over"):
            envs.step(envs.action_space.sample())
        mask = np.array([True, False, True, True, True])
        envs.reset(options={"reset_mask": mask})
        with pytest.raises(CprmError, match=r"worlds \[1\] are over"):
            envs.step(envs.action_space.sample())
        envs.reset(options={"reset_mask": ~mask})
        envs.step(envs.action_space.sample())


def test_vector_and_single_environment_play_the_same_world():
    envs = SoccerVectorEnv(3, action_mode="discrete")
    single = SoccerEnv(action_mode="discrete")
    many, one = envs.reset(seed=9)[0], single.reset(seed=9)[0]
    for _ in range(25):
        assert all((many[k][0] == one[k]).all() for k in one)
        action = np.array([1, 4, 11, 0])
        many, one = envs.step(np.tile(action, (3, 1)))[0], single.step(action)[0]


def test_copy_false_returns_the_same_arrays_and_copy_true_does_not():
    shared, copied = SoccerVectorEnv(2, copy=False), SoccerVectorEnv(2)
    action = np.tile([1, 4, 11, 0], (2, 1))
    for envs, same in ((shared, True), (copied, False)):
        first = envs.reset(seed=1)[0]
        assert np.shares_memory(first["me"], envs.step(action)[0]["me"]) is same


# ---------------------------------------------------------------------- errors say what was given and what is allowed


def test_step_before_reset_says_so():
    with pytest.raises(CprmError, match=r"step before reset: call reset\(\) first"):
        SoccerEnv().step(np.array([0, 0, 0, 0]))
    with pytest.raises(CprmError, match="step before reset"):
        SoccerVectorEnv(2).step(np.zeros((2, 4), int))
    with pytest.raises(CprmError, match="step before reset"):
        soccer_v2.parallel_env(left=1, right=1).step({})


def test_unknown_names_list_the_right_ones():
    with pytest.raises(UnknownName, match=r"unknown task 'GoToBal'. Did you mean 'GoToBall'\?"):
        make_task("GoToBal")
    with pytest.raises(UnknownName, match="unknown action view 'boxes'"):
        SoccerEnv(action_mode="boxes")
    with pytest.raises(UnknownName, match=r"'left_3' names no player here.* Allowed: all, left, right, left_1"):
        SoccerEnv(agent="left_3")
    with pytest.raises(UnknownName, match="render_mode 'video': allowed are human, rgb_array, ansi or None"):
        SoccerEnv(render_mode="video")


def test_actions_for_the_wrong_agents_are_refused_by_name():
    env = soccer_v2.parallel_env(left=2, right=0, controlled="left", action_mode="hybrid")
    env.reset(seed=0)
    good = {a: env.action_space(a).sample() for a in env.agents}
    with pytest.raises(UnknownName, match="agent 'left_9' is not controlled here; controlled are left_1, left_2"):
        env.step({**good, "left_9": good["left_1"]})
    with pytest.raises(UnknownName, match="none given for left_2"):
        env.step({"left_1": good["left_1"]})
    with pytest.raises(CommandError, match=r"'params': entry .* is nan"):
        env.step({a: {**action, "params": np.full(4, np.nan)} for a, action in good.items()})
    with pytest.raises(UnknownName, match="agent 'right_1' is not controlled here"):
        env.observation_space("right_1")


def test_agents_are_selected_by_side_or_name():
    assert select_agents("all", 2, 1) == ("left_1", "left_2", "right_1")
    assert select_agents("right", 2, 1) == ("right_1",)
    assert select_agents("right_1, left_2", 2, 1) == ("left_2", "right_1")
    assert select_agents(["left"], 2, 1) == ("left_1", "left_2")


@pytest.mark.parametrize(
    ("task", "option", "allowed"),
    [
        ("GoToBall", {"far": -1.0}, "finite numbers from 0 to 120"),
        ("GoToBall", {"far": float("nan")}, "finite numbers from 0 to 120"),
        ("GoToBall", {"far": "x"}, "finite numbers from 0 to 120"),
        ("GoToBall", {"near": float("inf")}, "finite numbers from 0 to 120"),
        ("GoToBall", {"near": 50.0}, "numbers up to far, 40"),
        ("GoToBall", {"tries": 0}, "whole numbers from 1 to 1000"),
        ("GoToBall", {"tries": 2.5}, "whole numbers from 1 to 1000"),
        ("GoToBall", {"rolling": 5}, "finite numbers from 0 to 1"),
        ("GoToBall", {"speed": 50}, "finite numbers from 0 to 3"),
        ("Goalie", {"difficulty": 1.5}, "finite numbers from 0 to 1"),
        ("Keepaway3v2", {"size": 0}, "finite numbers from 5 to 60"),
        ("HFO1v0", {"ball_y": 200}, "finite numbers from 0 to 34"),
        ("KickOffShot", {"wait": -1}, "whole numbers of at least 0"),
    ],
)
def test_numbers_that_make_no_sense_are_refused_by_name(task, option, allowed):
    ((name, value),) = option.items()
    given = f"{value:g}" if name == "near" and value == 50.0 else repr(value)
    with pytest.raises(ParameterError, match=rf"task '{task}': {name}: {given} given; allowed are {allowed}"):
        make_task(task, **option)


def test_a_side_without_players_has_nobody_to_select():
    with pytest.raises(UnknownName, match=r"agents: 'all' names no player here\. Allowed"):
        select_agents("all", 0, 0)
