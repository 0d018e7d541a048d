"""The striker: it scores, in the order of the sequence, and goes back to the ball when it has lost it."""

import numpy as np
import pytest

from cprm_gym.agents.registry import AGENTS
from cprm_gym.agents.striker import STRIKER, STRIKER_NET, make_controller
from cprm_gym.architecture.analysis.report import analyze
from cprm_gym.architecture.petri import Executor
from cprm_gym.benchmark.plan import Block
from cprm_gym.benchmark.runner import play_block
from cprm_gym.benchmark.statistics import wilson_interval
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import make_task


def episodes(worlds, seed=0, trace=False, first=0):
    """Plays every world to its end; (core, agent, final status of each)."""
    task = make_task("KickOffShot")
    core = SoccerCore(task, worlds, seed=seed, first_world=first, include=("memory",))
    agent = make_controller(task, "left_1")
    agent.options["trace"] = trace
    observation = {k: v[:, 0] for k, v in core.reset(seed).items()}
    agent.reset(observation, seed)
    status = np.zeros(worlds, int)
    while (status == 0).any():
        step = core.step({k: np.asarray(v)[:, None] for k, v in agent.act(observation).items()})
        over = (step.terminated | step.truncated) & (status == 0)
        status[over] = step.status[over]
    return core, agent, status


def test_it_scores_in_nearly_every_episode():
    _, _, status = episodes(125, seed=3)
    assert wilson_interval(int((status == 1).sum()), 125).low > 0.93


@pytest.mark.slow
def test_it_scores_in_at_least_95_percent_of_a_thousand():
    _, _, status = episodes(1000, seed=11)
    assert wilson_interval(int((status == 1).sum()), 1000).low >= 0.95


def test_it_needs_no_model():
    assert STRIKER.model is None
    assert not Executor(STRIKER_NET).belief_names


def test_the_sequence_is_setup_pass_run_receive_dribble_shoot():
    _, agent, status = episodes(1, seed=1, trace=True)
    assert status[0] == 1
    fired = [f.transition for f in agent.controller.executor.trace.firings(0)]
    steps = ["set_up", "kick_off", "run_forward", "drive", "aim", "finish"]
    assert [fired.index(step) for step in steps] == sorted(fired.index(step) for step in steps)


@pytest.mark.parametrize("seed", [1, 3, 5])
def test_a_ball_that_is_taken_away_is_fetched_again(seed):
    task = make_task("KickOffShot")
    core = SoccerCore(task, 1, seed=seed, include=("memory",))
    agent = make_controller(task, "left_1")
    agent.options["trace"] = True
    observation = {k: v[:, 0] for k, v in core.reset(seed).items()}
    agent.reset(observation, seed)
    moved, status = False, 0
    while status == 0:
        action = agent.act(observation)
        if agent.controller.executor.read("dribble.ongoing")[0] and not moved:
            core.place_ball(*(core.sim.world["pos"][0, 1] + [-9.0, -12.0]))
            moved = True
        step = core.step({k: np.asarray(v)[:, None] for k, v in action.items()})
        status = int(step.status[0])
    fired = [f.transition for f in agent.controller.executor.trace.firings(0)]
    assert moved
    assert {"no_ball", "found", "fetch"} <= set(fired)
    assert status == 1


def test_its_net_is_bounded_and_never_stops():
    report = analyze(STRIKER_NET)
    assert report.untimed.bounded.holds
    assert report.timed.never_stops.holds


def test_it_plays_alike_alone_and_in_a_batch():
    task = make_task("KickOffShot")
    cores = [SoccerCore(task, 6, seed=5, include=("memory",)), SoccerCore(task, 1, seed=5, first_world=4, include=("memory",))]
    agents = [make_controller(task, "left_1") for _ in cores]
    observations = [{k: v[:, 0] for k, v in core.reset(5).items()} for core in cores]
    for agent, observation in zip(agents, observations):
        agent.reset(observation, 0)
    for _ in range(60):
        actions = [agent.act(observation) for agent, observation in zip(agents, observations)]
        for key in actions[0]:
            assert (actions[0][key][4] == actions[1][key][0]).all()
        for core, action in zip(cores, actions):
            core.step({k: np.asarray(v)[:, None] for k, v in action.items()})


def test_the_benchmark_plays_it_under_the_name_of_its_task():
    assert AGENTS["KickOffShot"] == "striker"
    result = play_block(Block("KickOffShot", "cprm", 0, 8, 0))
    assert result.error is None
    assert sum(result.success) >= 7
