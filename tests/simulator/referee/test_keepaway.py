"""Keepaway (specification/simulator.md 7.13)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from referee_scenes import Scene


def keepaway(**parameters: object) -> Scene:
    scene = Scene(3, 2, goalies=(0, 0), mode="before_kick_off", keepaway=True, half_time=-1, use_offside=False, **parameters)
    scene.sim.trainer.start()
    scene.listen()
    return scene


def test_kick_off_begins_to_play_at_once():
    assert keepaway().mode == "play_on"


def test_play_begins_by_itself_after_the_time_that_is_set():
    scene = Scene(3, 2, goalies=(0, 0), mode="before_kick_off", keepaway=True, keepaway_start=2, half_time=-1)
    assert scene.steps_until("play_on") == 20


def test_ball_that_leaves_the_region_ends_the_episode():
    scene = keepaway().put_ball(9.0, 0.0, 0.5).step()
    assert "training Keepaway 1" not in scene.said
    scene.step(2)
    assert scene.said[-1] == "training Keepaway 1"
    assert scene.ball == (-6.0, -6.0)
    corners = sorted((math.copysign(10.0, x), math.copysign(10.0, y)) for x, y in (scene.place_of(f"l{unum}") for unum in (1, 2, 3)))
    assert corners == [(-10.0, -10.0), (10.0, -10.0), (10.0, 10.0)]
    for unum in (1, 2):
        x, y = scene.place_of(f"r{unum}")
        assert -10.0 <= x <= -7.0
        assert 7.0 <= y <= 10.0
    assert (scene.world["stamina"][[0, 1, 2, 11, 12]] == 8000.0).all()


@pytest.mark.parametrize("begin", ["start", "change_mode", "keepaway_start"])
def test_first_play_on_places_everybody_and_recovers_them(begin):
    parameters = {"keepaway_start": 0} if begin == "keepaway_start" else {}
    scene = Scene(3, 2, goalies=(0, 0), mode="before_kick_off", keepaway=True, half_time=-1, **parameters)
    scene.world["stamina"] = 4000.0
    if begin == "start":
        scene.sim.trainer.start()
    elif begin == "change_mode":
        scene.sim.trainer.change_mode("play_on")
    else:
        scene.step()
    assert scene.mode == "play_on"
    assert scene.ball == (-6.0, -6.0)
    assert (scene.world["stamina"][[0, 1, 2, 11, 12]] == 8000.0).all()
    assert all(abs(x) <= 10.0 and abs(y) <= 10.0 for x, y in map(scene.place_of, ("l1", "l2", "l3", "r1", "r2")))
    scene.put_ball(1.0, 1.0).sim.trainer.change_mode("drop_ball")
    scene.sim.trainer.change_mode("play_on")
    assert scene.ball == (1.0, 1.0)


def test_fifth_step_with_the_ball_is_the_takers_turnover():
    """The server asks whether they had it for four steps before it counts the present one."""
    scene = keepaway().put_ball(0.0, 0.0).put("r1", 0.5, 0.0).step(4)
    assert "training Keepaway 1" not in scene.said
    assert scene.step().said[-1] == "training Keepaway 1"


def test_keeper_alone_with_the_ball_resets_the_count():
    scene = keepaway().put_ball(0.0, 0.0).put("r1", 0.5, 0.0).step(4)
    scene.put("r1", 5.0, 5.0).put("l1", 0.5, 0.0)
    scene.world["keepaway_count"] = 3
    scene.step().put("l1", 5.0, -5.0).put("r1", 0.5, 0.0).step(4)
    assert "training Keepaway 1" not in scene.said


def test_every_keeper_begins_in_every_corner():
    firsts = set()
    for seed in range(12):
        scene = keepaway()
        scene.sim.reset(seed)
        scene.sim.trainer.change_mode("play_on")
        scene.put_ball(9.9, 0.0, 1.0).step()
        firsts.add(int(scene.world["keepaway_first"]))
    assert firsts == {0, 1, 2}
    assert np.isfinite(scene.world["pos"]).all()
