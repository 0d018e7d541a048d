"""LostAndFound: the ball is seen once, leaves the view, and has to be reached before somebody who knows where it is would have it."""

import numpy as np
import pytest

from cprm_gym.agents.body import Body
from cprm_gym.agents.knowledge.oracles import idle
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.tasks import Status, make_task
from cprm_gym.envs.tasks.lost_and_found import GETTING_READY, PACE, time_needed
from cprm_gym.errors import ParameterError
from cprm_gym.simulator.state import Count


def engine(worlds=80, seed=2, first=0, **options):
    core = SoccerCore(make_task("LostAndFound", **options), worlds, seed=seed, first_world=first, include=("memory",))
    core.reset(seed)
    return core


def off_view(core):
    """(W,) degrees between the face and the way to the ball."""
    w = core.sim.world
    d = w["pos"][:, 0] - w["pos"][:, 1]
    angle = np.arctan2(d[:, 1], d[:, 0]) - w["body"][:, 0] - w["neck"][:, 0]
    return np.degrees(np.abs((angle + np.pi) % (2 * np.pi) - np.pi))


@pytest.mark.parametrize("kicked", [0.0, 1.0])
def test_the_ball_is_seen_once_and_then_leaves_the_view_of_who_stands_still(kicked):
    core = engine(kicked=kicked)
    assert (core.observation["level"][:, 0, 0] > 0).all(), "the first look shows it"
    assert (off_view(core) < 30.0).all()
    left = np.zeros(core.worlds, bool)
    for _ in range(15):
        core.step(idle(core))
        left |= off_view(core) > 30.0
    assert left.mean() > (0.95 if kicked == 0.0 else 0.5)


def test_a_rolling_ball_passes_him_as_stated_and_stays_on_the_pitch():
    core = engine(200, kicked=0.0)
    w = core.sim.world
    start, velocity = w["pos"][:, 0].copy(), w["vel"][:, 0].copy()
    speed = np.hypot(*velocity.T)
    assert speed.min() >= 1.6
    assert speed.max() <= 2.4
    d = w["pos"][:, 1] - start
    across = np.abs(d[:, 0] * velocity[:, 1] - d[:, 1] * velocity[:, 0]) / speed
    assert across.max() < 4.0
    assert across.min() > 1.0
    rest = np.abs(start + velocity / (1.0 - core.parameters.ball_decay))
    assert (rest < [52.5, 34.0]).all(axis=1).mean() > 0.99


def test_the_opponent_kicks_the_ball_away_when_it_occurs_to_him():
    core = engine(200, kicked=1.0)
    first = np.full(200, -1)
    for cycle in range(30):
        core.step(idle(core))
        first[(first < 0) & (core.sim.world["counts"][:, 11, Count.KICK] > 0)] = cycle
    assert (first >= 0).mean() > 0.98
    assert first.mean() == pytest.approx(3.0, abs=0.8), "a chance of a quarter in each cycle"
    assert len(np.unique(first)) > 6


def test_the_time_needed_is_that_of_a_run_to_a_ball_that_lies_and_of_the_meeting_with_one_that_rolls():
    core = engine(1)
    core.place_player(1, 0.0, 0.0, 0.0, (0.0, 0.0))
    core.place_ball(12.0, 0.0)
    body = Body.of(core.task)
    lies = time_needed(core, np.array([0]))[0]
    assert lies == np.ceil(GETTING_READY + (12.0 - body.reach) / (PACE * body.top_speed))
    core.place_ball(12.0, 0.0, -1.0, 0.0)
    assert time_needed(core, np.array([0]))[0] < lies
    core.place_ball(12.0, 0.0, 1.0, 0.0)
    later = time_needed(core, np.array([0]))[0]
    t = np.arange(200)
    ball = 12.0 + (1.0 - body.ball_decay**t) / body.roll - body.reach
    assert later == np.argmax(ball <= PACE * body.top_speed * np.maximum(t - GETTING_READY, 0.0))


@pytest.mark.parametrize("grace", [0.0, 7.0])
def test_who_does_nothing_has_lost_it_when_the_time_and_the_grace_are_over(grace):
    core = engine(40, kicked=0.0, grace=grace)
    core.step(idle(core))
    due = 1 + grace + time_needed(core, np.arange(40))
    ended = np.zeros(40)
    for cycle in range(2, 60):
        step = core.step(idle(core))
        fresh = step.terminated & (ended == 0)
        assert (step.status[fresh] == Status.TAKEN).all() or step.success[fresh].any()
        ended[fresh] = cycle
    taken = np.hypot(*(core.sim.world["pos"][:, 0] - core.sim.world["pos"][:, 1]).T) > 2.0
    assert taken.mean() > 0.8
    assert ended[taken] == pytest.approx(due[taken])


def test_a_ball_that_nobody_kicks_is_not_taken():
    core = engine(4, kicked=1.0, others="hold", max_cycles=30)
    for _ in range(30):
        step = core.step(idle(core))
        assert not step.terminated.any()
    assert (step.status == Status.OUT_OF_TIME).all()


def test_world_k_is_the_same_alone_and_in_a_batch():
    batch, alone = engine(5), engine(1, first=3)
    for _ in range(12):
        batch.step(idle(batch))
        alone.step(idle(alone))
    assert np.array_equal(batch.sim.world["pos"][3], alone.sim.world["pos"][0])
    assert np.array_equal(batch.memory[3], alone.memory[0])


@pytest.mark.parametrize(("given", "message"), [({"near": 12.0}, "near: 12 given; .*up to far, 8"), ({"slow": 2.5}, "slow: 2.5 given")])
def test_options_in_the_wrong_order_are_refused(given, message):
    with pytest.raises(ParameterError, match=message):
        make_task("LostAndFound", **given)
