"""Ends of halves, extra time, golden goal, automatic kick-offs (specification/simulator.md 7.3, 7.4, 7.15)."""

from __future__ import annotations

import pytest
from referee_scenes import Scene

from cprm_gym.simulator.parameters import Rules

SHORT = {"half_time": 6, "extra_half_time": 3}  # 60 and 30 cycles


def play(scene: Scene, until: int) -> Scene:
    """Let time pass in play_on, with kick-offs as soon as they are possible."""
    while scene.world["time"] < until and scene.mode != "time_over":
        if scene.mode == "before_kick_off":
            scene.sim.trainer.start()
        if scene.mode.startswith("kick_off"):
            scene.sim.trainer.change_mode("play_on")
        scene.step()
    return scene


def test_half_time_stops_the_clock_and_the_other_team_kicks_off():
    scene = play(Scene(mode="before_kick_off", **SHORT), 60)
    assert scene.said[-2:] == ["half_time", "before_kick_off"]
    scene.step(10)
    assert scene.world["time"] == 60
    assert scene.world["stoppage"] == 10
    scene.sim.trainer.start()
    assert scene.mode == "kick_off_r"


def test_half_time_interrupts_a_set_play_but_waits_for_a_stoppage():
    scene = Scene(**SHORT)
    scene.world["time"] = 59
    scene.sim.trainer.change_mode("free_kick_l")
    assert scene.step().mode == "before_kick_off"
    scene = Scene(**SHORT)
    scene.world["time"] = 59
    scene.put_ball(51.5, 0.0, 2.0).step()
    assert scene.mode == "before_kick_off"  # the time module is asked before the ball
    scene = Scene(**SHORT)
    scene.world["time"] = 60
    scene.sim.trainer.change_mode("goal_l")
    assert scene.step().mode == "goal_l"


def test_decided_match_ends_with_normal_time():
    scene = Scene(mode="before_kick_off", **SHORT)
    scene.world["score"][0] = 1
    play(scene, 500)
    assert scene.world["time"] == 120
    assert scene.said[-2:] == ["time_up", "time_over"]
    assert scene.said.count("half_time") == 1


def test_level_match_is_extended_and_then_ends_when_there_is_no_shoot_out():
    scene = play(Scene(mode="before_kick_off", penalty_shoot_outs=False, **SHORT), 500)
    assert scene.world["time"] == 180
    assert scene.said.count("time_extended") == 2
    assert scene.said[-2:] == ["time_up", "time_over"]


def test_extra_time_is_played_to_its_end_unless_the_goal_is_golden():
    for golden, end in ((False, 180), (True, 131)):
        scene = play(Scene(mode="before_kick_off", penalty_shoot_outs=False, golden_goal=golden, **SHORT), 130)
        if scene.mode == "before_kick_off":
            scene.sim.trainer.start()
        scene.sim.trainer.change_mode("play_on")
        scene.put_ball(51.5, 0.0, 2.0).step()
        assert scene.world["score"].tolist() == [1, 0]
        if not golden:
            assert scene.mode == "goal_l"
            scene.sim.trainer.change_mode("play_on")
            play(scene, 500)
        assert scene.mode == "time_over"
        assert scene.world["time"] == end


def test_extra_time_begins_with_full_capacity_and_the_stamina_that_is_left():
    scene = play(Scene(mode="before_kick_off", **SHORT), 119)
    scene.world["stamina"][:4], scene.world["capacity"][:4] = 3000.0, 500.0
    scene.step()
    assert scene.mode == "before_kick_off"
    assert scene.said[-2] == "time_extended"
    assert (scene.world["capacity"][:4] > 130000.0).all()
    assert (scene.world["stamina"][:4] < 3100.0).all()
    scene.sim.trainer.start()
    assert (scene.world["stamina"][:4] < 3100.0).all()


def test_match_without_a_team_ends_after_normal_time():
    scene = play(Scene(right=0, goalies=(1, 0), mode="before_kick_off", **SHORT), 500)
    assert scene.said[-2:] == ["time_up_without_a_team", "time_over"]


def test_endless_match_has_no_half_time():
    scene = Scene(half_time=-1)
    scene.world["time"] = 3000
    assert scene.step(3).mode == "play_on"


def test_time_rule_can_be_switched_off():
    scene = Scene(rules=Rules.ALL & ~Rules.TIME & ~Rules.PENALTY, **SHORT)
    scene.step(200)
    assert "half_time" not in scene.said
    assert scene.world["time"] == 200


def test_nothing_happens_after_time_over():
    scene = Scene(mode="time_over").put_ball(0.0, 0.0, 1.0).step(5)
    assert scene.mode == "time_over"
    assert scene.ball == (0.0, 0.0)


@pytest.mark.parametrize(("left", "right", "steps"), [(11, 11, 7), (4, 4, 20)])
def test_automatic_mode_kicks_off_when_its_wait_is_over(left, right, steps):
    scene = Scene(left, right, mode="before_kick_off", auto_mode=True, kick_off_wait=7, connect_wait=20)
    assert scene.steps_until("kick_off_l") == steps


def test_wind_turns_at_half_time():
    scene = Scene(mode="before_kick_off", **SHORT)
    scene.world["wind"] = 3.0, -2.0
    play(scene, 60)
    assert scene.world["wind"].tolist() == [-3.0, 2.0]
