"""Disturbances: what each does, once an episode, at times that depend on seed and world alone."""

from dataclasses import replace

import gymnasium
import numpy as np
import pytest

from cprm_gym.envs import soccer_v2
from cprm_gym.envs.core import SoccerCore
from cprm_gym.envs.observations import BodyFeature
from cprm_gym.envs.tasks import make_task
from cprm_gym.errors import ParameterError
from cprm_gym.wrappers.disturbances import (
    DISTURBANCES,
    BallDisplaced,
    BallStopped,
    BlindSpell,
    Disturbed,
    Disturber,
    NoiseBurst,
    ParallelDisturbed,
    PlayerDisplaced,
    Push,
)


def idle(core):
    shape = (core.worlds, len(core.agents))
    return {"type": np.zeros(shape, int), "params": np.zeros((*shape, 4))}


def disturbed(disturbance, worlds=5, cycles=30, first_world=0, seed=0, start=None):
    """Idle players; (core, disturber, positions (T, W, 3, 2) before each step and after the last, fresh (T, W))."""
    core = SoccerCore(make_task("PassAndAdvance"), worlds, seed=1, first_world=first_world)
    disturber = Disturber(core, disturbance, seed)
    core.reset(1)
    if start:
        start(core)
    places, fresh = [core.sim.world["pos"][:, :3].copy()], []
    for _ in range(cycles):
        disturber()
        core.step(idle(core))
        places.append(core.sim.world["pos"][:, :3].copy())
        fresh.append(core.observation["body"][:, 0, BodyFeature.FRESH].copy())
    return core, disturber, np.array(places), np.array(fresh)


def test_the_ball_is_displaced_once_by_the_distance_asked_for():
    _, disturber, places, _ = disturbed(BallDisplaced(first=5, last=15, near=3.0, far=4.0))
    jumps = np.linalg.norm(np.diff(places[:, :, 0], axis=0), axis=-1)
    assert ((jumps > 1e-9).sum(axis=0) == 1).all()
    assert ((jumps.max(axis=0) >= 3.0) & (jumps.max(axis=0) <= 4.0)).all()
    assert (jumps.argmax(axis=0) == disturber.struck).all()
    assert ((disturber.struck >= 5) & (disturber.struck <= 15)).all()


def test_one_player_is_displaced_and_the_ball_is_not():
    _, _, places, _ = disturbed(PlayerDisplaced(first=5, last=5), worlds=20)
    moved = np.linalg.norm(places[6] - places[5], axis=-1) > 1.0
    assert (moved[:, 1:].sum(axis=1) == 1).all()
    assert not moved[:, 0].any()
    assert moved[:, 1].any()
    assert moved[:, 2].any()


def test_in_a_blind_spell_nobody_sees_and_afterwards_everybody_does():
    _, _, _, fresh = disturbed(BlindSpell(first=10, last=10, cycles=12), worlds=3)
    assert not fresh[10:21].any()
    assert fresh[:10].any(axis=0).all()
    assert fresh[22:].any(axis=0).all()


def test_pushes_move_ball_and_players_while_they_last():
    _, _, places, _ = disturbed(Push(first=4, last=4, cycles=6, ball=0.5, player=0.2))
    steps = np.linalg.norm(np.diff(places, axis=0), axis=-1)
    assert (steps[:4] < 1e-9).all()
    assert (steps[4:10].max(axis=0) > 0.01).all()
    assert steps[-1, :, 1:].max() < 1e-3
    assert len(np.unique(np.round(steps[4:10, :, 0], 9))) > 25, "irregular"


def watched(disturbance, cycles=24, worlds=6, first_world=0, seed=0, episodes=1):
    """Idle players with memories; the observations (copies) of each cycle of the last episode, begun anew in all worlds."""
    core = SoccerCore(make_task("PassAndAdvance"), worlds, seed=1, first_world=first_world, include=("memory",))
    disturber = Disturber(core, disturbance, seed) if disturbance else None
    for episode in range(episodes):
        core.reset(1)
        if disturber and episode:
            disturber.reset()
        seen = []
        for _ in range(cycles):
            if disturber:
                disturber()
            core.step(idle(core))
            seen.append({key: value.copy() for key, value in core.observation.items()})
    return {key: np.stack([s[key] for s in seen]) for key in seen[0]}


BURST = NoiseBurst(first=6, last=6, cycles=8, distance=0.2, direction=10.0)


def test_a_noise_burst_blurs_what_is_seen_while_it_lasts_and_leaves_levels_and_the_world_alone():
    clear, blurred = watched(None), watched(BURST)
    seen = (clear["level"][..., 0] > 0) & (clear["body"][..., BodyFeature.FRESH] > 0)
    during = np.zeros(len(seen), bool)
    during[6:14] = True
    for key in ("level", "body", "age"):
        assert (clear[key] == blurred[key]).all(), key
    for column in (0, 1):
        off = np.abs(clear["ball"][..., column] - blurred["ball"][..., column])
        assert (off[during][seen[during]] > 1e-6).all()
        assert (off[~during] == 0.0).all()
    told = clear["level"][..., 0] == 3
    assert (clear["ball"][..., 2:][told & during[:, None, None]] != blurred["ball"][..., 2:][told & during[:, None, None]]).all()
    assert (blurred["ball"][clear["level"][..., 0] == 0] == 0.0).all()
    mate = clear["level"][:, :, 1, 1] > 0
    assert mate[during].any()
    assert ((clear["players"][:, :, 1, 0, 0] != blurred["players"][:, :, 1, 0, 0]) == (mate & during[:, None])).all()


def test_the_errors_of_a_noise_burst_have_the_sizes_asked_for_and_differ_by_cycle_and_player():
    clear, blurred = watched(None, worlds=60), watched(BURST, worlds=60)
    seen = clear["level"][6:14, ..., 0] > 0
    ratio = np.log(blurred["ball"][6:14, ..., 0][seen] / clear["ball"][6:14, ..., 0][seen])
    turned = np.degrees(blurred["ball"][6:14, ..., 1][seen] - clear["ball"][6:14, ..., 1][seen])
    assert len(ratio) > 300
    assert 0.17 < ratio.std() < 0.23
    assert 8.5 < turned.std() < 11.5
    assert abs(ratio.mean()) < 0.04
    assert len(np.unique(np.round(ratio, 9))) == len(ratio)


def test_what_is_remembered_in_a_noise_burst_is_what_was_seen():
    clear, blurred = watched(None), watched(BURST)
    assert (clear["self"] == blurred["self"]).all(), "he still knows where he is himself"
    fresh = blurred["level"][6:14, ..., 0] > 0
    o = {key: value[6:14][fresh] for key, value in blurred.items()}
    angle = o["self"][:, 5] + o["ball"][:, 1]
    place = o["self"][:, :2] + o["ball"][:, :1] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert np.abs(place - o["memory"][:, 0, :2]).max() < 1e-3
    assert np.abs(clear["memory"][6:14][fresh][:, 0, :2] - o["memory"][:, 0, :2]).max() > 0.5


def test_the_blur_of_a_world_is_the_same_alone_and_in_a_batch_and_gone_in_the_next_episode():
    many, one = watched(BURST), watched(BURST, worlds=1, first_world=4)
    for key in many:
        assert (many[key][:, 4] == one[key][:, 0]).all(), key
    core = SoccerCore(make_task("PassAndAdvance"), 2, seed=1, include=("memory",))
    disturber = Disturber(core, replace(BURST, first=0, last=0), 0)
    core.reset(1)
    clear = {key: value.copy() for key, value in core.observation.items()}
    for _ in range(3):
        disturber()
        core.step(idle(core))
    core.reset(1)
    for key, value in clear.items():
        assert (core.observation[key] == value).all(), key
    again, other = watched(BURST), watched(BURST, episodes=2)
    assert (again["ball"] == many["ball"]).all()
    assert (other["ball"][6:14] != many["ball"][6:14]).any(), "another episode has other errors"


def test_a_rolling_ball_is_stopped_and_one_that_lies_is_not_struck():
    def roll(core):
        core.place_ball([0.0, 0.0], [0.0, 10.0], [1.5, 0.0], [0.0, 1.2], worlds=[0, 1])

    core, disturber, places, _ = disturbed(BallStopped(first=3, last=3), worlds=4, start=roll)
    assert disturber.struck.tolist() == [3, 3, -1, -1]
    assert (np.abs(places[5:, :2, 0] - places[4, :2, 0]) < 1e-9).all()
    assert (core.sim.world["vel"][:, 0] == 0.0).all()


@pytest.mark.parametrize("name", DISTURBANCES)
def test_a_world_is_disturbed_alike_alone_and_in_a_batch(name):
    disturbance = replace(DISTURBANCES[name], first=2, last=12)

    def roll(core):
        core.place_ball(0.0, 0.0, 1.5, 0.3)

    _, many, places, _ = disturbed(disturbance, worlds=4, start=roll, cycles=25)
    _, one, alone, _ = disturbed(disturbance, worlds=1, first_world=2, start=roll, cycles=25)
    assert many.struck[2] == one.struck[0]
    assert (places[:, 2] == alone[:, 0]).all()


def test_another_episode_is_struck_at_another_time_and_another_seed_too():
    core, disturber, _, _ = disturbed(BallDisplaced(first=0, last=10_000), worlds=8)
    first = disturber._due.copy()
    disturber.reset(np.arange(8) < 4)
    assert (disturber._due[4:] == first[4:]).all()
    assert (disturber._due[:4] != first[:4]).any()
    assert (Disturber(core, disturber.disturbance, seed=9)._due != first).any()


def test_cycles_that_make_no_sense_are_refused():
    with pytest.raises(ParameterError, match="BallDisplaced: first 9 and last 3"):
        BallDisplaced(first=9, last=3)


def test_an_environment_is_disturbed_once_in_every_episode():
    env = Disturbed(gymnasium.make("cprm/GoToBall-v2"), BallDisplaced(first=3, last=6))
    action = np.zeros(4, int)
    for _ in range(2):
        env.reset(seed=4)
        ball = [env.unwrapped.core.sim.world["pos"][0, 0].copy()]
        for _ in range(10):
            *_, info = env.step(action)
            ball.append(env.unwrapped.core.sim.world["pos"][0, 0].copy())
        moved = np.linalg.norm(np.diff(ball, axis=0), axis=1) > 1.0
        assert moved.sum() == 1
        assert moved.argmax() == info["struck"]
    with pytest.raises(ParameterError, match="need an environment of cprm_gym"):
        Disturbed(gymnasium.make("CartPole-v1"), BallDisplaced())


def test_a_parallel_environment_is_disturbed_for_everybody():
    env = ParallelDisturbed(
        soccer_v2.parallel_env(left=2, right=1, max_cycles=20, action_mode="hybrid", observation="raw"),
        BlindSpell(first=4, last=4, cycles=6),
    )
    env.reset(seed=1)
    fresh = []
    for _ in range(14):
        observations, _, _, _, infos = env.step(
            {agent: {"type": 0, "params": np.zeros(4), "turn_neck": np.zeros(1), "view": 0} for agent in env.agents}
        )
        fresh.append([observations[agent]["body"][BodyFeature.FRESH] for agent in env.agents])
    assert not np.array(fresh)[4:9].any()
    assert np.array(fresh)[:4].any(axis=0).all()
    assert {info["struck"] for info in infos.values()} == {4}
