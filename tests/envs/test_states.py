"""Saved states, start states, seeds and what a reset refuses."""

import io

import gymnasium
import numpy as np
import pytest

from cprm_gym import make_task
from cprm_gym.envs import soccer_v2
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.rewards import HausknechtStone
from cprm_gym.envs.single import SoccerEnv
from cprm_gym.envs.tasks.slow_approach import SlowApproachVectorEnv
from cprm_gym.envs.vector import SoccerVectorEnv
from cprm_gym.errors import ParameterError, UnknownName

FORMS = [
    {"task": "HFO2v2", "action_mode": "macro", "reward": "to_ball", "include": ("memory", "hear", "landmarks")},
    {"task": "HFO2v1", "observation": "hfo_low", "reward": HausknechtStone()},
    {"task": "Soccer5v5", "others": "strong", "observation": "full"},
    {"task": "Keepaway3v2", "action_mode": "macro", "observation": "keepaway", "include": "action_mask", "takes": 900, "size": 60.0},
]


def digest(result):
    """Everything in a result of a step, as bytes."""
    if isinstance(result, dict):
        return {k: digest(v) for k, v in result.items()}
    if isinstance(result, tuple):
        return tuple(digest(v) for v in result)
    return result.tobytes() if isinstance(result, np.ndarray) else result


def played(env, actions):
    return [digest(env.step(a)) for a in actions]


@pytest.mark.parametrize("options", FORMS, ids=lambda o: o["task"])
def test_a_running_episode_goes_on_from_a_saved_state_bit_for_bit(options):
    env = SoccerEnv(**options)
    env.reset(seed=3)
    env.action_space.seed(0)
    actions = [env.action_space.sample() for _ in range(40)]
    played(env, actions[:15])
    state = env.save_state()
    first = played(env, actions[15:])
    env.load_state(state)
    assert played(env, actions[15:]) == first
    # another environment, through a file, as the start of an episode
    file = io.BytesIO()
    np.savez(file, **state)
    file.seek(0)
    with np.load(file, allow_pickle=False) as kept:
        again = dict(kept)
    other = SoccerEnv(**options)
    other.reset(seed=9, options={"state": again})
    other.load_state(again)
    assert played(other, actions[15:]) == first


def test_one_state_starts_many_worlds_whose_luck_differs_with_a_seed():
    options = {"task": "HFO1v1", "action_mode": "macro"}
    env = SoccerEnv(**options)
    env.reset(seed=3)
    for _ in range(10):
        env.step(2)
    envs = SoccerVectorEnv(4, **options)
    state = env.save_state()
    seen, _ = envs.reset(options={"state": state})
    assert (seen["body"] == env.core.observation["body"][0]).all()
    for _ in range(10):
        envs.step(np.full(4, 2))
    same = envs.core.sim.world["pos"].copy()
    assert (same == same[0]).all()
    envs.reset(seed=7, options={"state": state})
    for _ in range(10):
        envs.step(np.full(4, 2))
    assert not np.array_equal(envs.core.sim.world["pos"][0], envs.core.sim.world["pos"][1])


def test_the_parallel_face_saves_and_loads_too():
    env = soccer_v2.parallel_env(task="HFO2v1", action_mode="macro")
    env.reset(seed=1)
    act = dict.fromkeys(env.possible_agents, 2)
    state = env.save_state()
    first = [digest(env.step(act)) for _ in range(8)]
    env.load_state(state)
    assert env.agents == env.possible_agents
    assert [digest(env.step(act)) for _ in range(8)] == first


def test_states_of_other_environments_are_refused():
    small, large = SoccerEnv("HFO1v0"), SoccerEnv("HFO1v0", action_mode="macro")
    small.reset(seed=1)
    large.reset(seed=1)
    with pytest.raises(ParameterError, match="expected what save_state gives of an environment with the same options"):
        large.load_state(small.save_state())
    with pytest.raises(ParameterError, match="expected what save_state gives"):
        small.load_state({})
    many = SoccerVectorEnv(3, "HFO1v0")
    many.reset(seed=1)
    with pytest.raises(ParameterError, match="the state of other options or another number of worlds"):
        SoccerVectorEnv(2, "HFO1v0").load_state(many.save_state())


def test_the_limit_of_an_episode_belongs_to_its_state():
    short, long = SoccerEnv("HFO1v0", max_cycles=20), SoccerEnv("HFO1v0", max_cycles=40)
    short.reset(seed=1)
    long.reset(seed=1)
    with pytest.raises(ParameterError, match="of an environment with max_cycles=20, here 40"):
        long.load_state(short.save_state())
    long.core.max_cycles = 20
    long.load_state(short.save_state())
    assert long.core.branch().max_cycles == 20


def test_an_episode_starts_where_it_is_told_to():
    env = SoccerEnv("HFO1v1", debug_info=True)
    start = {"ball": (30.0, 5.0, 0.5, 0.0), "left_1": (25.0, 4.0, 1.0), "right_1": (51.0, 0.0)}
    _, info = env.reset(seed=1, options={"start": start})
    assert info["truth"][[0, 1, 12]].tolist() == [[30.0, 5.0], [25.0, 4.0], [51.0, 0.0]]
    assert env.core.sim.world["vel"][0, 0].tolist() == [0.5, 0.0]
    assert env.core.sim.world["body"][0, 0] == 1.0
    for wrong, error, message in (
        ({"bal": (0, 0)}, UnknownName, "start: 'bal' names nobody here; allowed are ball, left_1, right_1"),
        ({"left_2": (0, 0)}, UnknownName, "start: 'left_2' names nobody here"),
        ({"ball": (0, 0, 0)}, ParameterError, "start: 'ball' takes 2 or 4 finite numbers"),
        ({"left_1": (0, np.nan)}, ParameterError, "start: 'left_1' takes 2 or 3 finite numbers"),
        (
            {"left_1": (1e9, 0)},
            ParameterError,
            r"start: 'left_1' at \(1000000000.0, 0\); \|x\| and \|y\| of a place are at most 57.5 and 39 m",
        ),
        ([0, 0], ParameterError, "start: expected a dict of places"),
    ):
        with pytest.raises(error, match=message):
            env.reset(options={"start": wrong})


@pytest.mark.parametrize("face", [SoccerEnv, lambda: SoccerVectorEnv(2), lambda: soccer_v2.parallel_env(left=1, right=1)])
def test_an_unknown_option_of_a_reset_is_refused(face):
    with pytest.raises(ParameterError, match=r"reset: unknown option 'strt'\. Did you mean 'start'\? Options: .*start, state"):
        face().reset(options={"strt": 1})


def test_a_list_of_seeds_gives_each_world_what_a_single_one_with_that_seed_is():
    envs = SoccerVectorEnv(3, "HFO1v1", debug_info=True)
    seen, info = envs.reset(seed=[11, 5, 11])
    assert (info["truth"][0] == info["truth"][2]).all()
    envs.action_space.seed(0)
    singles = [SoccerEnv("HFO1v1", debug_info=True) for _ in range(3)]
    for k, (env, seed) in enumerate(zip(singles, (11, 5, 11))):
        one, told = env.reset(seed=seed)
        assert (told["truth"] == info["truth"][k]).all()
        assert all((one[name] == seen[name][k]).all() for name in one)
    actions = [envs.action_space.sample() for _ in range(12)]
    for action in actions:
        many = envs.step(action)[4]["truth"]
        assert (many == [env.step(action[k])[4]["truth"] for k, env in enumerate(singles)]).all()


def test_a_world_without_a_seed_goes_on():
    both = [SoccerVectorEnv(2, debug_info=True) for _ in range(2)]
    for envs in both:
        envs.reset(seed=1)
    went_on = both[0].reset()[1]["truth"][1]
    mixed = both[1].reset(seed=[4, None])[1]["truth"]
    assert (mixed[1] == went_on).all()
    assert (mixed[0] == SoccerEnv(debug_info=True).reset(seed=4)[1]["truth"]).all()


def test_the_world_of_the_appendix_takes_a_list_of_seeds():
    envs = SlowApproachVectorEnv(3)
    seen = envs.reset(seed=[3, 8, 3])[0]
    assert (seen[0] == seen[2]).all()
    assert (seen[0] != seen[1]).any()
    with pytest.raises(ParameterError, match="seed: expected 3 whole numbers"):
        envs.reset(seed=[1, 2])


def test_specs_know_the_longest_episode_and_an_episode_cut_by_it_says_so():
    assert gymnasium.spec("cprm/GoToBall-v2").max_episode_steps == 200
    env = gymnasium.make("cprm/GoToBall-v2", max_cycles=300)
    assert env.spec.max_episode_steps == 200
    env.reset(seed=4, options={"start": {"ball": (40.0, 30.0), "left_1": (-40.0, -30.0)}})
    for k in range(200):
        assert env.step([0, 0, 0, 0])[3] == (k == 199)
    with pytest.warns(UserWarning, match=r"cut after 200 steps.* give gymnasium\.make also max_episode_steps=300"):
        env.reset()
    long = gymnasium.make("cprm/GoToBall-v2", max_cycles=300, max_episode_steps=300)
    long.reset(seed=4, options={"start": {"ball": (40.0, 30.0), "left_1": (-40.0, -30.0)}})
    assert [long.step([0, 0, 0, 0])[3] for _ in range(300)] == [False] * 299 + [True]


@pytest.mark.parametrize("world", [2, -1, "x", True, 0.0])
def test_a_world_that_there_is_not_is_not_saved(world):
    core = SoccerCore(make_task("GoToBall"), 2)
    core.reset(0)
    with pytest.raises(ParameterError, match="save_state: no world"):
        core.save_state(world)
    assert len(core.save_state(np.int64(1))["world"]) == 1
