"""The world of Appendix A."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

from cprm_gym.envs.tasks.slow_approach import SlowApproach, SlowApproachEnv, SlowApproachVectorEnv, SlowWorlds, slow_behaviour
from cprm_gym.errors import CommandError, ParameterError, UnknownName


def arrivals(select, worlds=4000, parameters=None):
    """Steps to the ball of the behaviour "Slow" with a rule that says when to turn."""
    p = parameters or SlowApproach()
    core = SlowWorlds(p, worlds)
    core.seed(1)
    everyone = np.arange(worlds)
    core.reset(everyone)
    core.start_noise(everyone)
    steps = np.zeros(worlds, int)
    for t in range(1, p.max_cycles + 1):
        seen = core.observe()
        core.step(*slow_behaviour(seen, p, select(seen, t)))
        steps[(steps == 0) & (core.d < p.epsilon_d)] = t
        if steps.all():
            break
    return steps


def test_slow_arrives_as_fast_as_the_analysis_of_the_appendix_says():
    threshold = arrivals(lambda seen, t: np.abs(seen[:, 0]) > np.radians(20))
    assert threshold.min() > 0
    assert threshold.mean() == pytest.approx(7.55, abs=0.2)
    assert threshold.max() <= 20
    alternating = arrivals(lambda seen, t: np.full(len(seen), t % 2 == 1))
    assert alternating.min() > 0
    assert alternating.mean() == pytest.approx(11.93, abs=0.3)
    assert alternating.max() <= 29


def test_without_noise_the_update_is_the_printed_one():
    p = SlowApproach(delta_s=0.0, delta_a=0.0, delta_omega=0.0, h_theta=0.0, h_s=0.0, h_d=0.0)
    core = SlowWorlds(p, 1)
    core.seed(0)
    core.reset(np.arange(1))
    core.x[:], core.y[:], core.rho[:], core.s[:] = -5.0, 0.0, 0.3, 0.5
    assert core.theta[0] == pytest.approx(-0.3)
    core.step(np.zeros(1), np.array([-0.3]))
    assert core.s[0] == pytest.approx(0.2)
    assert (core.x[0], core.y[0]) == pytest.approx((-4.8, 0.0))
    core.step(np.array([0.4]), np.zeros(1))
    assert core.s[0] == pytest.approx(0.48)
    assert core.observe()[0] == pytest.approx([0.0, 0.48, 4.32], abs=1e-6)


def test_noise_stays_within_its_bounds():
    p = SlowApproach(delta_a=0.2)
    core = SlowWorlds(p, 2000)
    core.seed(3)
    core.reset(np.arange(2000))
    before = core.x.copy(), core.y.copy(), core.rho.copy()
    core.s[:] = 0.0
    core.step(np.full(2000, 0.5), np.zeros(2000))
    assert (np.abs(core.s - 0.5) <= 0.1 + 1e-12).all()
    assert core.s.std() > 0.02
    off = np.hypot(core.x - before[0] - core.s * np.cos(before[2]), core.y - before[1] - core.s * np.sin(before[2]))
    assert (off <= p.delta_s * core.s + 1e-12).all()
    seen = core.observe()
    assert (np.abs(seen[:, 2] / core.d - 1) <= p.h_d + 1e-6).all()
    assert (np.abs(seen[:, 0] - core.theta) <= p.h_theta + 1e-6).all()


@pytest.mark.parametrize("mode", ["hybrid", "discrete", "box"])
def test_gymnasium_accepts_it(mode):
    check_env(gymnasium.make("cprm/SlowApproach-v2", action_mode=mode).unwrapped)


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_vector_form_resets_as_its_mode_says_and_plays_the_same_worlds(mode):
    envs = gymnasium.make_vec("cprm/SlowApproach-v2", num_envs=4, action_mode="discrete", max_episode_steps=3, vector_kwargs={},
                              autoreset_mode=mode)  # fmt: skip
    single = SlowApproachEnv(action_mode="discrete", max_episode_steps=3)
    many, _ = envs.reset(seed=5)
    one, _ = single.reset(seed=5)
    assert (many[0] == one).all()
    for t in range(3):
        many, _, _, truncated, info = envs.step(np.full(4, 5))
        one = single.step(5)[0]
        assert truncated.all() == (t == 2)
        if t < 2 or mode != AutoresetMode.SAME_STEP:
            assert (many[0] == one).all()
    if mode == AutoresetMode.SAME_STEP:
        assert (info["final_obs"][0] == one).all()
        assert (envs.core.cycle == 0).all()
    elif mode == AutoresetMode.NEXT_STEP:
        _, reward, _, truncated, _ = envs.step(np.full(4, 5))
        assert not truncated.any()
        assert (reward == 0).all()
        assert (envs.core.cycle == 0).all()
    else:
        with pytest.raises(Exception, match="are over: reset them"):
            envs.step(np.full(4, 5))
        envs.reset(options={"reset_mask": np.array([True, True, True, True])})
        envs.step(np.full(4, 5))


def test_the_default_view_is_the_discrete_one_as_everywhere():
    assert SlowApproachEnv().action_space == SlowApproachEnv(action_mode="discrete").action_space
    assert SlowApproachVectorEnv(2).single_action_space == SlowApproachEnv().action_space


def test_errors_say_what_is_allowed():
    env = SlowApproachEnv(action_mode="hybrid")
    env.reset(seed=0)
    with pytest.raises(CommandError, match=r"allowed are 0 \(accelerate\) and 1 \(turn\)"):
        env.step({"type": 2, "params": [0.0]})
    with pytest.raises(CommandError, match="finite numbers from -1 to 1"):
        env.step({"type": 0, "params": [np.nan]})
    with pytest.raises(CommandError, match="action: expected Dict"):
        env.step(3)
    with pytest.raises(ParameterError, match=r"gamma is 2; allowed is 0 to 1"):
        SlowApproachEnv(gamma=2)
    with pytest.raises(ParameterError, match=r"no option 'gama'. Did you mean 'gamma'\?"):
        SlowApproachVectorEnv(2, gama=1)
    with pytest.raises(UnknownName, match="unknown action view 'macro'"):
        SlowApproachEnv(action_mode="macro")
