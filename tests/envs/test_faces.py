"""The faces of the engine: what they hand out stays as it is, and what they refuse they name."""

import copy

import numpy as np
import pytest

from cprm_gym.envs import soccer_v2
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.single import SoccerEnv
from cprm_gym.envs.tasks import GoToBall, Status, make_task
from cprm_gym.envs.vector import SoccerVectorEnv
from cprm_gym.errors import CommandError, CprmError, ParameterError, UnknownName

DASH = {"type": 1, "params": np.array([0.5, 0, 0, 0], np.float32), "turn_neck": np.zeros(1, np.float32), "view": 0}
FORWARD = np.array([1, 4, 11, 0])


def frozen(value):
    """Everything in nested dicts, arrays as bytes."""
    if isinstance(value, dict):
        return {key: frozen(part) for key, part in value.items()}
    return value.tobytes() if isinstance(value, np.ndarray) else copy.copy(value)


# ---------------------------------------------------------------------- what is handed out


@pytest.mark.parametrize("options", [{}, {"flatten": True}, {"observation": "hfo_high"}, {"include": "memory"}], ids=str)
def test_what_a_parallel_step_returned_never_changes(options):
    env = soccer_v2.parallel_env(left=2, right=2, action_mode="macro", debug_info=True, **options)
    kept = [env.reset(seed=1)]
    before = [frozen(part) for part in kept[0]]
    for _ in range(6):
        kept.append(env.step(dict.fromkeys(env.agents, 2)))
        before += [frozen(part) for part in kept[-1]]
    env.reset(seed=2)
    assert [frozen(part) for result in kept for part in result] == before


def test_what_a_gymnasium_step_returned_never_changes():
    env = SoccerEnv(action_mode="macro", debug_info=True, include=("memory", "hear"))
    kept = [env.reset(seed=1), *(env.step(2) for _ in range(6))]
    before = [frozen(part) for result in kept for part in result]
    env.step(2)
    env.reset(seed=2)
    assert [frozen(part) for result in kept for part in result] == before


def test_agents_share_nothing_that_can_be_written_to():
    env = soccer_v2.parallel_env(left=2, right=2, action_mode="hybrid")
    env.reset(seed=1)
    observations, _, _, _, infos = env.step(dict.fromkeys(env.agents, DASH))
    others = frozen({a: (o, infos[a]) for a, o in observations.items() if a != "left_1"})
    for values in observations["left_1"].values():
        values[...] = 7.0
    infos["left_1"]["reward_goal"] = 7.0
    assert frozen({a: (o, infos[a]) for a, o in observations.items() if a != "left_1"}) == others


def test_copy_false_returns_the_same_arrays_with_the_same_numbers():
    copied, shared = (soccer_v2.parallel_env(left=2, right=2, action_mode="hybrid", copy=c) for c in (True, False))
    first, same = copied.reset(seed=1)[0], shared.reset(seed=1)[0]
    for _ in range(5):
        kept = frozen(first)
        now = copied.step(dict.fromkeys(copied.agents, DASH))[0]
        assert frozen(now) == frozen(shared.step(dict.fromkeys(shared.agents, DASH))[0]) == frozen(same)
        assert frozen(first) == kept != frozen(now)


def test_infos_have_the_same_keys_after_reset_and_step():
    env = soccer_v2.parallel_env(left=2, right=2, action_mode="macro")
    after_reset = env.reset(seed=1)[1]
    after_step = env.step(dict.fromkeys(env.agents, 0))[4]
    assert after_reset["left_2"].keys() == after_step["left_2"].keys() >= {"status", "is_success", "reward_goal", "action_mask"}
    assert after_step["left_2"]["reward_goal"] == 0.0


def test_an_episode_cut_short_by_a_wrapper_is_out_of_time():
    env = soccer_v2.parallel_env(left=2, right=2, action_mode="hybrid")
    env.reset(seed=1)
    env.max_cycles = 2
    assert env.step(dict.fromkeys(env.agents, DASH))[4]["left_1"]["status"] == Status.IN_GAME
    _, _, terminated, truncated, infos = env.step(dict.fromkeys(env.agents, DASH))
    assert (terminated["left_1"], truncated["left_1"], infos["left_1"]["status"]) == (False, True, Status.OUT_OF_TIME)
    assert env.agents == []


def test_a_goal_is_worth_one_to_those_who_scored():
    env = soccer_v2.parallel_env(left=2, right=1, action_mode="hybrid")
    env.reset(seed=1)
    w = env.core.sim.world[0]
    w["mode"], w["pos"][0], w["vel"][0] = 3, [52.0, 0.0], [2.5, 0.0]
    w["pos"][1:] = [0.0, 20.0]
    results = [env.step({a: {**DASH, "type": 0} for a in env.agents}) for _ in range(4)]
    assert [sum(r[1][a] for r in results) for a in env.agents] == [1.0, 1.0, -1.0]
    assert all(r[4][a]["reward_goal"] == r[1][a] for r in results for a in env.agents)


def test_a_match_is_won_by_the_side_with_more_goals():
    core = SoccerCore(make_task("Soccer", left=1, right=1), 3)
    core.reset(0)
    core.sim.world["mode"][:2] = 2
    core.sim.world["score"][:] = [[2, 1], [1, 1], [3, 0]]
    outcome = core.task.outcome(core)
    assert outcome.terminated.tolist() == [True, True, False]
    assert outcome.success.tolist() == [[True, False], [False, False], [False, False]]
    assert outcome.status.tolist() == [Status.FULL_TIME, Status.FULL_TIME, Status.IN_GAME]


def test_a_new_episode_in_one_world_does_not_disturb_the_others():
    alone, mixed = (SoccerCore(make_task("Soccer5v5"), 3, seed=1, include=("memory", "landmarks", "hear")) for _ in range(2))
    draws = np.random.default_rng(0)
    for core in (alone, mixed):
        core.reset(1)
    for cycle in range(25):
        action = {"type": draws.integers(0, 3, (3, 10)), "params": draws.uniform(-1, 1, (3, 10, 4))}
        for core in (alone, mixed):
            core.step(action)
        if cycle % 6 == 3:
            mixed.reset(worlds=[0])
        for name, values in alone.observation.items():
            assert values[1:].tobytes() == mixed.observation[name][1:].tobytes()


@pytest.mark.parametrize("mode", ["NextStep", "SameStep"])
def test_a_vector_environment_tells_of_ends_and_terms(mode):
    envs = SoccerVectorEnv(4, near=5.0, far=6.0, rolling=0.0, max_episode_steps=3, reward="to_ball", autoreset_mode=mode)
    envs.reset(seed=1)
    for _ in range(3):
        reward, _, truncated, info = envs.step(np.tile(FORWARD, (4, 1)))[1:]
        assert info["reward_to_ball"] + info["reward_reached"] == pytest.approx(reward)
        assert info["_reward_to_ball"].all()
    assert truncated.all()
    assert (info["status"] == Status.OUT_OF_TIME).all()
    if mode == "SameStep":
        assert info["final_info"]["status"].tolist() == [Status.OUT_OF_TIME] * 4
        assert info["final_info"]["_status"].all()
    else:
        reward, _, truncated, info = envs.step(np.tile(FORWARD, (4, 1)))[1:]
        for values in (reward, truncated, info["status"], info["reward_to_ball"]):
            assert not values.any()


@pytest.mark.parametrize("kept", [True, False])
def test_masks_of_a_vector_environment_are_copies_unless_asked_otherwise(kept):
    envs = SoccerVectorEnv(4, task="HFO1v0", action_mode="macro", copy=kept, max_episode_steps=5, autoreset_mode="SameStep")
    masks = [envs.reset(seed=1)[1]["action_mask"]]
    before = [mask.copy() for mask in masks]
    for _ in range(12):
        masks.append(envs.step(np.full(4, 2))[4]["action_mask"])
        before.append(masks[-1].copy())
        assert (masks[-1] == envs.core.action_mask[:, 0]).all()
    unchanged = all((mask == copied).all() for mask, copied in zip(masks, before))
    assert unchanged or not kept
    assert np.shares_memory(masks[-1], envs.core.action_mask) is not kept


# ---------------------------------------------------------------------- what is refused


def parallel(mode, action):
    env = soccer_v2.parallel_env(left=2, right=1, action_mode=mode)
    env.reset(seed=0)
    good = {"hybrid": DASH, "discrete": FORWARD, "macro": 0}[mode]
    return env.step({**dict.fromkeys(env.agents, good), "left_2": action})


@pytest.mark.parametrize(
    ("mode", "action", "message"),
    [
        ("hybrid", "dash", "left_2: hybrid action: expected a dict with the keys type, params, turn_neck, view; got .*dash"),
        ("hybrid", None, "left_2: hybrid action: expected a dict"),
        ("hybrid", {"type": 1}, "left_2: hybrid action: key 'params' is missing"),
        ("hybrid", {**DASH, "colour": 1}, "left_2: hybrid action: unknown key 'colour'; allowed are type, params"),
        ("hybrid", {**DASH, "params": np.zeros(3)}, r"left_2: action 'params': expected shape \(4,\) for every agent, got \(3,\)"),
        ("hybrid", {**DASH, "params": np.full(4, np.nan)}, "left_2: action 'params': entry .* is nan; allowed are finite numbers"),
        ("hybrid", {**DASH, "type": None}, "left_2: action 'type': expected whole numbers, got object .*None"),
        ("hybrid", {**DASH, "type": 8}, "left_2: action 'type': entry .* is 8; allowed is 0 to 7"),
        ("hybrid", {"type": 1, "params": np.zeros(4)}, "differ between the agents in their keys or shapes"),
        ("discrete", [9, 0, 0, 0], "left_2: action 'discrete command': entry .* is 9; allowed is 0 to 5"),
        ("discrete", [0, 0, 0], r"left_2: action 'discrete': expected shape \(4,\) for every agent, got \(3,\)"),
        ("discrete", DASH, "left_2: action 'discrete': expected whole numbers, got object"),
        ("discrete", None, "left_2: action 'discrete': expected whole numbers, got object .*None"),
        ("macro", 99, "left_2: action 'macro': 99 is none; allowed are 0 to 13: noop, reorient"),
        ("macro", "shoot", "left_2: action 'macro': 'shoot' is none"),
        ("macro", np.zeros(2, int), "left_2: action 'macro': array"),
    ],
)
def test_a_bad_action_is_refused_with_the_name_of_its_agent(mode, action, message):
    with pytest.raises(CommandError, match=message):
        parallel(mode, action)


def test_a_refused_action_changes_nothing():
    env, other = (soccer_v2.parallel_env(left=2, right=1, action_mode="hybrid") for _ in range(2))
    env.reset(seed=3)
    other.reset(seed=3)
    with pytest.raises(CommandError, match="right_1: action 'type'"):
        env.step({**dict.fromkeys(env.agents, DASH), "right_1": {**DASH, "type": 8}})
    assert frozen(env.step(dict.fromkeys(env.agents, DASH))[0]) == frozen(other.step(dict.fromkeys(other.agents, DASH))[0])


@pytest.mark.parametrize("actions", [None, [DASH, DASH], np.zeros(2), "dash"], ids=["None", "list", "array", "str"])
def test_actions_of_all_agents_are_a_dict(actions):
    env = soccer_v2.parallel_env(left=2, right=0, controlled="left", action_mode="hybrid")
    env.reset(seed=0)
    with pytest.raises(CommandError, match=f"actions: expected a dict with an action for every agent, got {type(actions).__name__}"):
        env.step(actions)


@pytest.mark.parametrize("face", [SoccerEnv, SoccerVectorEnv, soccer_v2.parallel_env])
@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"task": None}, UnknownName, "task: expected a name or a Task, got NoneType None"),
        ({"task": GoToBall(), "nearr": 3.0}, ParameterError, r"task 'GoToBall' has no option 'nearr'\. Did you mean 'near'\?"),
        ({"lft": 2}, ParameterError, r"has no option 'lft'\. Did you mean 'left'\?"),
        ({"left": 12}, ParameterError, "`left` takes a number of players from 0 to 11, got 12"),
        ({"task": GoToBall(max_cycles=0)}, ParameterError, "max_cycles: 0 given, a whole number of at least 1 is needed"),
        ({"task": GoToBall(max_cycles=2.5)}, ParameterError, "max_cycles: 2.5 given"),
        ({"others": "mediun"}, UnknownName, r"unknown scripted policy or controller 'mediun'. Did you mean 'medium'\?"),
        ({"others": 5}, UnknownName, "others: expected a string or a sequence of strings, got int 5"),
        ({"include": 5}, UnknownName, "include: expected a string or a sequence of strings, got int 5"),
        ({"include": "memry"}, UnknownName, r"unknown part of an observation 'memry'. Did you mean 'memory'\?"),
        ({"observation": "hfo_lo"}, UnknownName, r"unknown observation preset 'hfo_lo'. Did you mean 'hfo_low'\?"),
        ({"action_mode": "hybird"}, UnknownName, r"unknown action view 'hybird'. Did you mean 'hybrid'\?"),
        ({"render_mode": "video"}, UnknownName, "render_mode 'video'"),
    ],
)
def test_every_face_refuses_a_bad_argument(face, options, error, message):
    with pytest.raises(error, match=message):
        face(**options)


def test_who_acts_is_somebody():
    with pytest.raises(UnknownName, match="controlled: nobody chosen"):
        soccer_v2.parallel_env(controlled=[])
    with pytest.raises(UnknownName, match="agents: expected a string or a sequence of strings, got int 5"):
        soccer_v2.parallel_env(controlled=5)
    with pytest.raises(UnknownName, match=r"agent 'all': one agent is needed here, such as 'left_1'; use soccer_v2 for several"):
        SoccerEnv("Soccer", agent="all")


def test_options_change_a_task_that_is_given_as_an_object():
    assert SoccerEnv(GoToBall(), max_episode_steps=5).task.max_cycles == 5
    assert soccer_v2.parallel_env(task=GoToBall(), max_cycles=6, near=7.0).task == GoToBall(max_cycles=6, near=7.0)


@pytest.mark.parametrize("worlds", [0, 2.5, "2", None])
def test_a_vector_environment_has_at_least_one_world(worlds):
    with pytest.raises(ParameterError, match=f"num_envs: {worlds!r} given, a whole number of at least 1 is needed"):
        SoccerVectorEnv(worlds)


def test_the_reset_of_a_vector_environment_says_what_it_takes():
    envs = SoccerVectorEnv(3, reward="sparse")
    with pytest.raises(ParameterError, match=r"seed: expected a whole number of at least 0, or 3 of them, got \[1, 2\]"):
        envs.reset(seed=[1, 2])
    with pytest.raises(ParameterError, match=r"seed: entry 1 is -2; expected a whole number of at least 0, or None"):
        envs.reset(seed=[1, -2, 3])
    with pytest.raises(ParameterError, match=r"reset_mask: expected bool of shape \(3,\), got bool of shape \(2,\)"):
        envs.reset(options={"reset_mask": np.ones(2, bool)})
    with pytest.raises(CprmError, match="the first reset takes all worlds"):
        envs.reset(options={"reset_mask": np.array([True, False, False])})
    envs.reset(seed=1, options={"reset_mask": np.ones(3, bool)})
    assert (envs.step(np.tile(FORWARD, (3, 1)))[1] == 0).all()


def test_the_engine_wants_a_reset_of_all_worlds_first():
    core = SoccerCore(GoToBall(), 3)
    action = {"type": np.zeros((3, 1), int), "params": np.zeros((3, 1, 4))}
    with pytest.raises(CprmError, match=r"step before reset: call reset\(\) first"):
        core.step(action)
    with pytest.raises(CprmError, match="the first reset takes all worlds"):
        core.reset(worlds=[0, 2])
    core.reset(0)
    core.step(action)
    assert (core.reset(worlds=[])["age"] == core.observation["age"]).all()
    assert core.cycle.tolist() == [1, 1, 1]
    core.reset(worlds=[1])
    assert core.cycle.tolist() == [1, 0, 1]
    for wrong in (1, np.ones(4, bool), [0.5]):
        with pytest.raises(ParameterError, match=r"worlds: expected \(3,\) bool or a list of indices"):
            core.reset(worlds=wrong)
