"""What the three faces tell beside observation and reward: the same names, numbers and arrays of fixed shape only."""

import numpy as np
import pytest

from cprm_gym.envs import soccer_v2
from cprm_gym.envs.registration import TASK_NAMES
from cprm_gym.envs.single import SoccerEnv
from cprm_gym.envs.tasks import Status, make_task
from cprm_gym.envs.tasks.slow_approach import SlowApproachEnv, SlowApproachVectorEnv
from cprm_gym.envs.vector import SoccerVectorEnv

HFO = {"IN_GAME": 0, "GOAL": 1, "CAPTURED_BY_DEFENSE": 2, "OUT_OF_BOUNDS": 3, "OUT_OF_TIME": 4, "SERVER_DOWN": 5}


def kinds(info):
    """Type and shape of every entry."""
    assert all(isinstance(v, (bool, int, float, np.bool_, np.number, np.ndarray)) for v in info.values()), info
    return {k: (np.asarray(v).dtype.kind, np.asarray(v).dtype.itemsize, np.shape(v)) for k, v in info.items()}


def infos(face, **options):
    """Kinds of the infos after reset and after a step of a face."""
    if face is SoccerVectorEnv:
        envs = face(1, **options)
        several = envs.reset(seed=1)[1], envs.step(envs.action_space.sample())[4]
        single = [{k: v[0] for k, v in info.items() if not k.startswith("_")} for info in several]
        return [kinds(info) for info in single]
    if face is SoccerEnv:
        env = face(**options)
        return [kinds(env.reset(seed=1)[1]), kinds(env.step(env.action_space.sample())[4])]
    env = face(**options)
    after_reset = env.reset(seed=1)[1]
    after_step = env.step({a: env.action_space(a).sample() for a in env.agents})[4]
    assert len({str(kinds(i)) for i in after_reset.values()}) == 1
    return [kinds(after_reset[env.possible_agents[0]]), kinds(after_step[env.possible_agents[0]])]


@pytest.mark.parametrize("name", TASK_NAMES)
def test_every_face_tells_the_same_from_the_reset_on(name):
    options = {"task": name, "action_mode": "macro", "debug_info": True, "reward": ("possession", "ball_to_goal_progress")}
    told = [part for face in (SoccerEnv, SoccerVectorEnv, soccer_v2.parallel_env) for part in infos(face, **options)]
    assert all(part == told[0] for part in told[1:])
    terms = {f"reward_{term}" for term in (*make_task(name).terms, "possession", "ball_to_goal_progress")}
    assert set(told[0]) == {"status", "is_success", "cycle", "action_mask", "truth"} | terms


def test_the_terms_add_up_to_the_reward_in_every_face():
    envs = SoccerVectorEnv(3, "GoToBall", reward={"to_ball": 2.0})
    envs.reset(seed=1)
    _, reward, _, _, info = envs.step(np.tile([1, 4, 11, 0], (3, 1)))
    assert info["reward_reached"] + info["reward_to_ball"] == pytest.approx(reward)


def test_the_world_of_the_appendix_tells_the_same():
    env, envs = SlowApproachEnv(action_mode="discrete"), SlowApproachVectorEnv(1, action_mode="discrete")
    told = [kinds(env.reset(seed=1)[1]), kinds(env.step(3)[4])]
    told += [kinds({k: v[0] for k, v in i.items() if k[0] != "_"}) for i in (envs.reset(seed=1)[1], envs.step(np.array([3]))[4])]
    assert all(part == told[0] for part in told[1:])
    assert set(told[0]) == {"status", "is_success", "cycle", "reward_reached"}


def test_statuses_begin_with_those_of_hfo():
    assert {s.name: int(s) for s in Status if s <= 5} == HFO
    for name in TASK_NAMES:
        task = make_task(name)
        assert Status.OUT_OF_TIME in task.statuses
        assert all(isinstance(s, Status) for s in task.statuses)


def test_the_same_default_action_view_and_both_names_of_the_limit_everywhere():
    faces = (SoccerEnv, lambda **o: SoccerVectorEnv(2, **o), soccer_v2.parallel_env)
    for face in faces:
        assert face(task="HFO1v1").core.view.name == "discrete"
        for name in ("max_cycles", "max_episode_steps"):
            assert face(task="HFO1v1", **{name: 7}).core.max_cycles == 7
        assert face(task="HFO1v1", max_cycles=9, max_episode_steps=7).core.max_cycles == 9


def test_a_mask_can_stand_in_the_observation_too():
    flat = SoccerEnv("HFO1v0", action_mode="macro", observation="hfo_high", include="action_mask")
    observation, info = flat.reset(seed=1)
    assert set(observation) == set(flat.observation_space) == {"observations", "action_mask"}
    assert flat.observation_space.contains(observation)
    assert (observation["action_mask"] == info["action_mask"]).all()
    assert (flat.action_masks() == info["action_mask"]).all()
    plain = soccer_v2.parallel_env(task="HFO2v1", action_mode="macro", include=("action_mask", "memory"))
    observations, infos_ = plain.reset(seed=1)
    for agent in plain.agents:
        assert plain.observation_space(agent).contains(observations[agent])
        assert (observations[agent]["action_mask"] == infos_[agent]["action_mask"]).all()
