"""Wrappers of observations: Flatten, FrameStack, BeliefObservation."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from cprm_gym.agents.models import BALL_MODEL, DIRECTION, DISTANCE
from cprm_gym.architecture.prm.grounding.grounding import Grounding
from cprm_gym.architecture.prm.inference.filter import Filter
from cprm_gym.envs.observations import BodyFeature, ObjectFeature
from cprm_gym.envs.single import SoccerEnv
from cprm_gym.errors import ParameterError
from cprm_gym.wrappers import BeliefObservation, Flatten, FrameStack
from cprm_gym.wrappers.belief import FilterBelief

# the checker remarks that what it checks is wrapped, which is the point
pytestmark = pytest.mark.filterwarnings("ignore:.*is different from the unwrapped version:UserWarning")


def rollout(env, cycles=12, seed=1):
    observation, _ = env.reset(seed=seed)
    env.action_space.seed(seed)
    yield observation
    for _ in range(cycles):
        observation = env.step(env.action_space.sample())[0]
        yield observation


def test_flatten_keeps_every_entry_in_the_order_of_the_parts():
    plain, flat = SoccerEnv(), Flatten(SoccerEnv())
    for a, b in zip(rollout(plain), rollout(flat)):
        for name, where in flat.slices.items():
            assert (b[where] == a[name].ravel()).all()
        assert flat.observation_space.contains(b)
    check_env(Flatten(SoccerEnv()), skip_render_check=True)


def test_flatten_scales_to_one_if_asked():
    env = Flatten(SoccerEnv(observation="memory"), normalise=True)
    for vector in rollout(env):
        assert np.abs(vector).max() <= 1.0
    with pytest.raises(ParameterError, match="flat Dict of boxes is needed"):
        Flatten(gymnasium.make("FrozenLake-v1"))


def test_frame_stack_holds_the_last_observations_oldest_first():
    plain, stacked = list(rollout(SoccerEnv())), list(rollout(FrameStack(SoccerEnv(), 3)))
    assert (stacked[0]["me"][:2] == 0).all()
    for t in range(2, len(plain)):
        for name in plain[t]:
            assert (stacked[t][name] == np.stack([plain[t - 2][name], plain[t - 1][name], plain[t][name]])).all()
    check_env(FrameStack(SoccerEnv(), 2), skip_render_check=True)
    vector = FrameStack(Flatten(SoccerEnv()), 4)
    assert vector.observation_space.contains(vector.reset(seed=0)[0])
    with pytest.raises(ParameterError, match=r"frames is 2\.5; allowed are whole numbers from 1"):
        FrameStack(SoccerEnv(), 2.5)
    with pytest.raises(ParameterError, match="frames is 0; allowed are whole numbers from 1"):
        FrameStack(SoccerEnv(), 0)


def ball_evidence(observation):
    """What an observation says about the ball, in the words of the ball model."""
    if observation["body"][BodyFeature.FRESH] == 0:
        return {}
    if observation["level"][0] == 0:
        return {"ball.seen": "no"}
    direction = np.degrees(observation["ball"][ObjectFeature.DIRECTION] + observation["body"][BodyFeature.NECK])
    return {
        "ball.seen": "yes",
        "ball.seen_dist": float(observation["ball"][ObjectFeature.DISTANCE]),
        "ball.seen_dir_deg": float((direction + 180.0) % 360.0 - 180.0),
    }


def ball_belief():
    filtered = Filter(Grounding(BALL_MODEL, {"ball": "Ball"}), on_impossible="restart")
    return FilterBelief(filtered, {"ball.dist": len(DISTANCE.edges) - 1, "ball.dir_deg": len(DIRECTION.edges) - 1}, ball_evidence)


def test_the_ball_models_posterior_becomes_part_of_the_observation():
    env = BeliefObservation(SoccerEnv(observation="raw"), ball_belief())
    assert env.observation_space["belief"].shape == (21,)
    seen = 0
    for seed in range(6):
        observation, _ = env.reset(seed=seed)
        assert env.observation_space.contains(observation)
        assert observation["belief"].sum() == pytest.approx(2.0, abs=1e-5)
        if observation["level"][0] > 0:
            seen += 1
            distance = observation["ball"][ObjectFeature.DISTANCE]
            bin_of = np.searchsorted(DISTANCE.edges, distance) - 1
            assert abs(observation["belief"][:10].argmax() - bin_of) <= 1
    assert seen > 0


def test_a_belief_must_keep_its_promise():
    class Short:
        size = 3

        def reset(self, observation):
            return np.zeros(2)

    with pytest.raises(ParameterError, match=r"gave shape \(2,\), promised \(3,\)"):
        BeliefObservation(SoccerEnv(), Short()).reset(seed=0)
    with pytest.raises(ParameterError, match="needs Dict observations"):
        BeliefObservation(SoccerEnv(flatten=True), Short())
