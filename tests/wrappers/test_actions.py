"""Wrappers of actions and episodes: DiscreteActions, MacroSteps, SingleAgent, EpisodeStatistics, GameLog."""

import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from cprm_gym.envs import soccer_v2
from cprm_gym.envs.single import SoccerEnv
from cprm_gym.errors import CommandError, CprmError, ParameterError, UnknownName
from cprm_gym.simulator.gamelog.reader import GameLogReader
from cprm_gym.simulator.state import CommandKind
from cprm_gym.wrappers import DiscreteActions, EpisodeStatistics, GameLog, MacroSteps, ParallelGameLog, SingleAgent

# the checker remarks that what it checks is wrapped, which is the point
pytestmark = pytest.mark.filterwarnings("ignore:.*is different from the unwrapped version:UserWarning")


def test_discrete_actions_are_the_listed_commands():
    env = DiscreteActions(SoccerEnv(action_mode="hybrid"))
    check_env(env, skip_render_check=True)
    env.reset(seed=0)
    for number, (name, a, b) in enumerate(env.choices):
        env.reset(seed=0)
        env.step(number)
        command = env.unwrapped.core.sim.commands[0, 0]
        assert command["kind"] == CommandKind[name.upper()]
        assert command["a"] == pytest.approx(a, abs=1e-4)
        assert command["b"] == pytest.approx(b, abs=1e-4)
    with pytest.raises(CommandError, match="allowed are 0 to 25"):
        env.step(26)
    with pytest.raises(ParameterError, match="action_mode='hybrid'"):
        DiscreteActions(SoccerEnv(action_mode="box"))
    with pytest.raises(UnknownName, match="unknown command 'dive'"):
        DiscreteActions(SoccerEnv(action_mode="hybrid"), [("dive", 0, 0)])
    with pytest.raises(ParameterError, match="allowed are up to"):
        DiscreteActions(SoccerEnv(action_mode="hybrid"), [("dash", 300, 0)])
    with pytest.raises(ParameterError, match="a command and two numbers are needed"):
        DiscreteActions(SoccerEnv(action_mode="hybrid"), [("dash", 100)])
    with pytest.raises(ParameterError, match="choices is empty"):
        DiscreteActions(SoccerEnv(action_mode="hybrid"), [])
    for wrong in ("dash", None, 1.5, [1, 2]):
        with pytest.raises(CommandError, match="given; allowed are 0 to 25"):
            env.step(wrong)


def test_a_macro_lasts_until_the_ball_is_reached_and_says_how_long():
    env = MacroSteps(SoccerEnv(action_mode="macro", near=5.0, far=6.0, rolling=0.0, reward={"to_ball": 1.0}), longest=60)
    names = env.names
    observation, info = env.reset(seed=3)
    assert info["macro_steps"] == 0
    cycles, total, over = 0, 0.0, False
    while not over:
        mask = env.action_masks()
        macro = names.index("intercept" if mask[names.index("intercept")] else "reorient")
        observation, reward, terminated, truncated, info = env.step(macro)
        cycles += info["macro_steps"]
        total += reward
        assert reward == pytest.approx(sum(v for k, v in info.items() if k.startswith("reward_")))
        over = terminated or truncated
        if names[macro] == "intercept" and not over:
            assert info["macro_steps"] == 60 or not info["action_mask"][macro]
    assert info["is_success"]
    assert info["cycle"] == cycles
    assert observation["ball"].shape == (6,)


def test_one_cycle_macros_and_discounting():
    env = MacroSteps(SoccerEnv(action_mode="macro", reward=lambda core, outcome: np.ones((1, 1))), longest=4, gamma=0.5)
    env.reset(seed=0)
    _, reward, _, _, info = env.step(env.names.index("noop"))
    assert (reward, info["macro_steps"]) == (1.0, 1)
    _, reward, _, _, info = env.step(env.names.index("reorient"))
    assert (reward, info["macro_steps"]) == (1.875, 4)
    with pytest.raises(ParameterError, match="action_mode='macro'"):
        MacroSteps(SoccerEnv())
    with pytest.raises(ParameterError, match="longest is 0"):
        MacroSteps(SoccerEnv(action_mode="macro"), longest=0)
    check_env(MacroSteps(SoccerEnv(action_mode="macro")), skip_render_check=True)


def test_one_agent_of_a_parallel_environment_is_a_gymnasium_environment():
    def make():
        return soccer_v2.parallel_env(left=2, right=1, max_cycles=15, action_mode="discrete")

    check_env(SingleAgent(make(), "left_2"), skip_render_check=True)
    still = np.array([0, 0, 0, 0])
    seen = []

    def watch(observation):
        seen.append(observation)
        return still

    env = SingleAgent(make(), "left_1", {"left_2": watch, "right_1": watch})
    env.reset(seed=1)
    steps = 0
    over = False
    while not over:
        _, reward, terminated, truncated, _ = env.step(still)
        assert isinstance(reward, float)
        steps += 1
        over = terminated or truncated
    assert steps == 15
    assert len(seen) == 30
    with pytest.raises(CprmError, match="step before reset"):
        env.step(still)
    with pytest.raises(UnknownName, match=r"agent 'left_9' is not in this environment"):
        SingleAgent(make(), "left_9")


def test_episode_statistics_add_up():
    env = EpisodeStatistics(SoccerEnv(max_episode_steps=20, reward="to_ball"))
    env.action_space.seed(0)
    for seed in range(3):
        env.reset(seed=seed)
        total, over = 0.0, False
        while not over:
            _, reward, terminated, truncated, info = env.step(env.action_space.sample())
            total += reward
            over = terminated or truncated
        episode = info["episode"]
        assert episode["r"] == pytest.approx(total)
        assert sum(v for k, v in episode.items() if k.startswith("reward_")) == pytest.approx(total)
        assert episode["l"] == episode["cycles"] == info["cycle"]
    summary = env.summary()
    assert summary["episodes"] == 3
    assert sum(summary["status"].values()) == 3


def test_every_episode_becomes_a_game_log(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(ParameterError, match=r"GameLog: folder .*file' cannot be made: File exists"):
        GameLog(SoccerEnv(), tmp_path / "file")
    (tmp_path / "file").unlink()
    env = GameLog(SoccerEnv(max_episode_steps=12, debug_info=True), tmp_path, every=2)
    truths = []
    for seed in range(3):
        truth = [env.reset(seed=seed)[1]["truth"]]
        over = False
        while not over:
            _, _, terminated, truncated, info = env.step([1, 4, 11, 0])
            truth.append(info["truth"])
            over = terminated or truncated
        truths.append(truth)
    env.close()
    assert [p.name for p in env.paths] == ["episode-0000.rcg", "episode-0002.rcg"]
    for path, truth in zip(env.paths, truths[::2]):
        frames = list(GameLogReader(path))
        assert len(frames) == len(truth)
        for frame, positions in zip(frames, truth):
            assert frame.ball[:2] == pytest.approx(positions[0], abs=1e-3)
            assert frame.players["pos"][0] == pytest.approx(positions[1], abs=1e-3)


def test_parallel_environments_write_game_logs_too(tmp_path):
    match = soccer_v2.parallel_env(left=2, right=2, max_cycles=30, action_mode="discrete")
    env = ParallelGameLog(match, tmp_path, name="match", packed=True)
    env.reset(seed=1)
    while env.agents:
        env.step({a: [0, 0, 0, 0] for a in env.agents})
    env.close()
    assert [p.name for p in env.paths] == ["match-0000.rcg.gz"]
    assert len(list(GameLogReader(env.paths[0]))) > 20
