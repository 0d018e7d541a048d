"""Catches, back passes and catch faults (specification/simulator.md 7.9)."""

from __future__ import annotations

import math

import pytest
from referee_scenes import Scene, player

from cprm_gym.simulator.state import CommandKind


def goalie_with_ball_coming(kicker: str | None, **parameters: object) -> Scene:
    """The left goalie at (-45, 0), the ball 0.9 m before him; `kicker` has just played it."""
    scene = Scene(**parameters).put("l1", -45.0, 0.0, body=0.0).put_ball(-40.0, 0.0)
    if kicker:
        scene.put(kicker, -39.4, 0.0, body=math.pi).kick(kicker, 10.0).step(2)
    return scene.put_ball(-44.1, 0.0)


def test_caught_ball_gives_a_free_kick_and_stays_with_the_goalie():
    scene = goalie_with_ball_coming("r2").catch("l1")
    scene.listen()
    assert scene.said[-2:] == ["goalie_catch_ball_l", "free_kick_l"]
    assert scene.world["ball_catcher"] == player("l1")
    scene.do("l1", CommandKind.TURN, 90.0).step(2)
    x, y = scene.place_of("l1")
    assert math.hypot(scene.ball[0] - x, scene.ball[1] - y) == pytest.approx(0.385)


def test_goalie_may_move_twice_with_the_ball():
    scene = goalie_with_ball_coming("r2").catch("l1").step()
    for k, x in enumerate((-48.0, -44.0, -40.0)):
        scene.do("l1", CommandKind.MOVE, x, 1.0)
        assert scene.place_of("l1")[0] == pytest.approx(x if k < 2 else -44.0)
        scene.step()


def test_goalie_who_moves_out_of_his_area_with_the_ball_commits_a_catch_fault():
    scene = goalie_with_ball_coming("r2").catch("l1").step()
    scene.do("l1", CommandKind.MOVE, -30.0, 0.0).step()
    assert scene.mode == "catch_fault_l"


@pytest.mark.parametrize(("kicker", "mode"), [("l2", "back_pass_l"), ("r2", "free_kick_l"), (None, "free_kick_l")])
def test_only_a_team_mates_pass_must_not_be_caught(kicker, mode):
    assert goalie_with_ball_coming(kicker).catch("l1").mode == mode


def test_back_pass_rule_can_be_switched_off():
    assert goalie_with_ball_coming("l2", back_passes=False).catch("l1").mode == "free_kick_l"


def test_team_mates_touch_is_no_pass():
    scene = Scene().put("l1", -45.0, 0.0, body=0.0).put("l2", -43.0, 0.0).put_ball(-43.0, 0.2).step(2)
    assert scene.put("l2", -20.0, 0.0).put_ball(-44.1, 0.0).catch("l1").mode == "free_kick_l"


def test_pass_touched_by_an_opponent_at_the_same_time_is_forgotten():
    scene = Scene().put("l1", -45.0, 0.0, body=0.0).put_ball(-40.0, 0.0)
    scene.put("l2", -39.4, 0.0, body=math.pi).put("r2", -39.8, 0.7, body=math.pi)
    scene.kick("l2", 10.0).kick("r2", 5.0).step(2)
    assert scene.put_ball(-44.1, 0.0).catch("l1").mode == "free_kick_l"


def test_goalies_own_kick_caught_again_is_a_back_pass():
    scene = Scene().put("l1", -45.0, 0.0, body=0.0).put_ball(-44.5, 0.0).kick("l1", 5.0).step(3)
    assert scene.put_ball(-44.1, 0.0).catch("l1").mode == "back_pass_l"


def test_back_pass_leads_to_an_indirect_free_kick_outside_the_goal_area():
    scene = goalie_with_ball_coming("l2")
    scene.put("l1", -50.0, 0.0).put_ball(-49.1, 0.0).catch("l1")
    assert scene.ball[0] == pytest.approx(-47.0)
    assert scene.steps_until("indirect_free_kick_r") == 31


def test_catch_outside_the_penalty_area_is_a_fault_with_a_free_kick():
    scene = Scene().put("l1", -30.0, 0.0, body=0.0).put_ball(-29.2, 0.0).catch("l1")
    assert scene.mode == "catch_fault_l"
    assert scene.steps_until("free_kick_r") == 31


def test_only_the_left_counter_starts_anew_when_the_trainer_calls_a_catch_fault():
    def steps(side):
        scene = Scene(mode=f"catch_fault_{side}")
        scene.steps_until(f"free_kick_{'r' if side == 'l' else 'l'}")
        scene.sim.trainer.change_mode(f"catch_fault_{side}")
        return scene.steps_until(f"free_kick_{'r' if side == 'l' else 'l'}")

    assert steps("l") == 31
    assert steps("r") == 1
