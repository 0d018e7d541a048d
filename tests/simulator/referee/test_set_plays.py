"""Outs, goals, kick-offs, set plays, offside, stuck balls, illegal defence (specification/simulator.md 7.3 to 7.8, 7.11)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from referee_scenes import Scene, player

from cprm_gym.simulator.parameters import Rules
from cprm_gym.simulator.state import CommandKind

SIDES = pytest.mark.parametrize(("near", "far", "sign"), [("l", "r", 1.0), ("r", "l", -1.0)], ids=["left", "right"])


def facing(sign: float) -> float:
    return 0.0 if sign > 0 else math.pi


# --- outs


@SIDES
def test_ball_over_the_touch_line_is_a_kick_in_for_the_other_team(near, far, sign):
    scene = Scene().put(f"{near}2", 0.0, 33.0, body=math.pi / 2).put_ball(0.0, 33.7)
    scene.kick(f"{near}2", 50).step(2)
    assert scene.mode == f"kick_in_{far}"
    assert scene.ball == (pytest.approx(0.0), 34.0)
    assert not scene.world["vel"][0].any()


@SIDES
def test_ball_over_the_goal_line_touched_by_attackers_is_a_goal_kick_on_that_side(near, far, sign):
    scene = Scene().put_ball(52.0 * sign, -20.0, sign)
    scene.world["touch_player"] = player(f"{near}2")
    scene.step()
    assert scene.mode == f"goal_kick_{far}"
    assert scene.ball == (47.0 * sign, -9.16)


@SIDES
def test_ball_over_the_goal_line_touched_by_a_defender_is_a_corner(near, far, sign):
    scene = Scene().put(f"{far}2", 51.0 * sign, 20.0, body=facing(sign)).put_ball(51.7 * sign, 20.0)
    scene.kick(f"{far}2", 30).step(2)
    assert scene.mode == f"corner_kick_{near}"
    assert scene.ball == (51.5 * sign, 33.0)


def test_ball_that_nobody_touched_is_dropped_after_leaving_over_the_touch_line():
    scene = Scene().put_ball(10.0, 33.9, 0.0, 1.0).step()
    assert scene.said[-2:] == ["drop_ball", "play_on"]
    assert scene.mode == "play_on"


def test_nobody_sees_the_ball_outside_the_pitch():
    scene = Scene().put_ball(10.0, 33.9, 1.0, 2.0).step()
    assert abs(scene.ball[1]) <= 34.0


# --- goals and kick-off


@SIDES
def test_ball_through_the_goal_counts_and_the_other_team_kicks_off_after_51_steps(near, far, sign):
    scene = Scene().put_ball(51.0 * sign, 3.0, 2.5 * sign)
    time = int(scene.world["time"])
    scene.step()
    assert scene.mode == f"goal_{near}"
    assert scene.said[-1] == f"goal_{near}_1"
    assert scene.world["score"].tolist() == ([1, 0] if near == "l" else [0, 1])
    assert abs(scene.ball[0]) > 52.5
    assert not scene.world["vel"][0].any()
    assert scene.steps_until(f"kick_off_{far}") == 51
    assert scene.world["time"] == time + 2  # the clock stands after a goal
    assert scene.ball == (0.0, 0.0)


@pytest.mark.parametrize(("y", "mode"), [(6.6, "goal_l"), (7.6, "goal_kick_r")])
def test_the_crossing_point_decides_between_goal_and_goal_kick(y, mode):
    scene = Scene().put_ball(50.0, y, 2.9, 0.0)
    assert scene.step().mode == mode


def test_first_kick_off_belongs_to_the_left_team_and_rests_everybody():
    scene = Scene(mode="before_kick_off")
    scene.world["stamina"][:4] = 100.0
    scene.sim.trainer.start()
    assert scene.mode == "kick_off_l"
    assert (scene.world["stamina"][:4] == 8000.0).all()


def test_kick_off_is_not_repeated_within_a_half():
    scene = Scene(mode="before_kick_off")
    scene.sim.trainer.start()
    scene.step(5)
    scene.sim.trainer.change_mode("play_on")
    scene.sim.trainer.start()
    assert scene.mode == "play_on"


def test_kick_off_that_nobody_takes_ends_with_a_dropped_ball_at_time_100():
    scene = Scene(mode="before_kick_off")
    scene.sim.trainer.start()
    scene.listen()
    scene.step(99)
    assert scene.mode == "kick_off_l"
    assert scene.world["time"] == 99
    scene.step()
    assert scene.mode == "play_on"
    assert scene.world["time"] == 100
    assert scene.said[-2:] == ["drop_ball", "play_on"]


def test_automatic_types_leave_the_goalie_alone_and_differ_for_everybody_else():
    scene = Scene(11, 11, mode="before_kick_off")
    scene.sim.trainer.start()
    assert scene.world["type"].tolist() == list(range(11)) * 2
    scene.listen()
    assert scene.said[0] == "(change_player_type l 2 1)"


def test_teams_may_keep_the_default_type_when_it_is_exempt():
    scene = Scene(11, 11, mode="before_kick_off")
    scene.sim.packed["allow_mult_default_type"] = 1
    scene.sim.trainer.start()
    assert not scene.world["type"].any()


def test_players_in_the_other_half_are_put_back_before_kick_off():
    scene = Scene(mode="before_kick_off").put("l2", 20.0, 10.0).put("r2", -20.0, 10.0).step()
    assert scene.place_of("l2")[0] <= 0.0 <= scene.place_of("r2")[0]
    assert scene.place_of("l2") != (0.0, 10.0)  # somewhere in the own half, not at the line


def test_at_kick_off_a_player_over_the_halfway_line_is_put_on_it():
    scene = Scene(mode="before_kick_off")
    scene.sim.trainer.start()
    scene.put("l2", 3.0, 12.0).step()
    assert scene.place_of("l2") == (pytest.approx(-0.3), 12.0)


def test_opponents_leave_the_centre_circle_at_kick_off():
    scene = Scene(mode="before_kick_off")
    scene.sim.trainer.start()
    scene.put("r3", 4.0, 3.0).step()
    assert math.hypot(*scene.place_of("r3")) >= 9.45 - 1e-9


# --- set plays


def test_set_play_ends_with_the_kick_at_once():
    scene = Scene(mode="free_kick_l").put("l2", -0.5, 0.0).put_ball(0.0, 0.0).kick("l2")
    assert scene.mode == "play_on"


def test_opponents_are_kept_away_and_come_to_rest():
    scene = Scene().put("r2", 3.0, 0.0, velocity=(0.3, 0.0)).put_ball(0.0, 0.0)
    scene.sim.trainer.change_mode("free_kick_l")
    assert math.hypot(*scene.place_of("r2")) == pytest.approx(9.45, abs=2e-5)
    assert not scene.world["vel"][player("r2")].any()


def test_cleared_players_stay_inside_the_margin_near_the_touch_line():
    scene = Scene().put_ball(0.0, 34.0).put("r2", 1.0, 36.0)
    scene.sim.trainer.change_mode("kick_in_l")
    x, y = scene.place_of("r2")
    assert abs(y) <= 39.0
    assert math.hypot(x, y - 34.0) >= 9.15


def test_two_kicks_of_the_taker_are_a_fault_only_when_he_dashed_between_them():
    def second_kick(dashes):
        scene = Scene(mode="free_kick_l", player_decay=0.4).put("l2", 0.0, 0.0, body=0.0).put_ball(0.6, 0.0)
        scene.kick("l2", 1.0).step()
        if dashes:
            scene.dash("l2", 1.0)
        scene.step()
        return scene.kick("l2", 5.0).mode

    assert second_kick(dashes=False) == "play_on"
    assert second_kick(dashes=True) == "free_kick_fault_l"


def test_fault_leads_to_a_free_kick_after_30_frames():
    scene = Scene(mode="free_kick_l").put("l2", 0.0, 0.0, body=0.0).put_ball(0.6, 0.0)
    scene.kick("l2", 1.0).step()
    scene.dash("l2", 1.0).step()
    scene.kick("l2", 5.0)
    assert scene.mode == "free_kick_fault_l"
    assert scene.steps_until("free_kick_r") == 31


def test_goal_kick_lasts_until_the_ball_leaves_the_area():
    scene = Scene().put_ball(-52.0, 20.0, -1.0)
    scene.world["touch_player"] = player("r2")
    scene.step()
    assert scene.mode == "goal_kick_l"
    scene.put("l1", -47.6, 9.16, body=0.0).kick("l1", 100.0)
    assert scene.mode == "goal_kick_l"
    assert scene.steps_until("play_on", 20) > 2
    assert scene.ball[0] > -36.0


def test_opponents_leave_the_penalty_area_at_a_goal_kick():
    scene = Scene().put("r2", -40.0, 2.0).put_ball(-52.0, 20.0, -1.0)
    scene.world["touch_player"] = player("r3")
    scene.step(2)
    assert scene.mode == "goal_kick_l"
    assert scene.place_of("r2")[0] == pytest.approx(-35.7)


def test_goal_kick_played_by_an_opponent_is_repeated():
    scene = Scene().put_ball(-52.0, 20.0, -1.0)
    scene.world["touch_player"] = player("r2")
    scene.step().put("r3", -46.4, 9.16, body=math.pi)
    scene.said.clear()
    scene.kick("r3", 10.0).step()
    assert scene.said == ["goal_kick_l"]
    assert scene.ball == (-47.0, 9.16)


@pytest.mark.parametrize("mode", ["kick_in_l", "corner_kick_r", "free_kick_l", "indirect_free_kick_r"])
def test_set_play_that_nobody_takes_becomes_a_dropped_ball_after_100_steps(mode):
    scene = Scene().put_ball(20.0, 20.0)
    scene.sim.trainer.change_mode(mode)
    assert scene.steps_until("play_on") == 100


def test_nobody_scores_directly_from_an_indirect_free_kick():
    def shoot(touched):
        scene = Scene(mode="indirect_free_kick_l").put("l2", 44.4, 0.0, body=0.0).put_ball(45.0, 0.0)
        scene.kick("l2", 100.0)
        if touched:
            scene.step().put("l3", scene.ball[0] - 0.5, 0.0, body=0.0).kick("l3", 100.0)
        while scene.mode == "play_on":
            scene.step()
        return scene.mode

    assert shoot(touched=False) == "goal_kick_r"
    assert shoot(touched=True) == "goal_l"


def test_ball_that_stays_in_a_small_area_is_dropped():
    scene = Scene().put_ball(5.0, 5.0).step(101)
    scene.listen()
    assert scene.said[-2:] == ["drop_ball", "play_on"]


# --- offside


def offside_scene(sign: float = 1.0, near: str = "l", far: str = "r") -> Scene:
    scene = Scene()
    scene.put(f"{near}2", 5.0 * sign, 0.0, body=facing(sign)).put_ball(5.6 * sign, 0.0)
    return scene.put(f"{near}3", 30.0 * sign, 5.0).put(f"{far}1", 50.0 * sign, 0.0).put(f"{far}2", 20.0 * sign, -10.0)


@SIDES
def test_player_behind_the_defence_is_offside_when_he_plays_the_ball(near, far, sign):
    scene = offside_scene(sign, near, far)
    for unum in (3, 4):
        scene.put(f"{far}{unum}", 10.0 * sign, 20.0 + unum)
    scene.kick(f"{near}2", 50.0).step()
    assert scene.mode == "play_on"
    scene.put_ball(30.5 * sign, 5.0).kick(f"{near}3")
    assert scene.mode == f"offside_{near}"
    assert scene.ball == (20.0 * sign, 5.0)  # on the offside line, beside him
    assert scene.steps_until(f"free_kick_{far}") == 31


def test_player_behind_the_defence_is_not_offside_while_he_keeps_away():
    scene = offside_scene()
    scene.kick("l2", 30.0).step(20)
    assert scene.mode == "play_on"


def test_failed_kick_near_the_ball_is_offside_but_far_from_it_is_not():
    for distance, mode in ((2.0, "offside_l"), (3.0, "play_on")):
        scene = offside_scene()
        scene.put("r3", 10.0, 20.0).put("r4", 10.0, 23.0)
        scene.kick("l2", 50.0).step().put_ball(30.0, 5.0 + distance).kick("l3")
        assert scene.mode == mode


def test_there_is_no_offside_from_a_kick_in():
    scene = offside_scene()
    scene.sim.trainer.change_mode("kick_in_l")
    scene.kick("l2", 50.0).step().put_ball(30.5, 5.0).kick("l3")
    assert scene.mode == "play_on"


def test_two_kicks_in_one_cycle_cancel_offside():
    scene = offside_scene()
    scene.put("r3", 6.0, 0.8).put("r4", 10.0, 23.0)
    scene.kick("l2", 50.0).kick("r3", 5.0).step().put_ball(30.5, 5.0).kick("l3")
    assert scene.mode == "play_on"


def test_offside_can_be_switched_off():
    for change in ({"use_offside": False}, {"rules": Rules.ALL & ~Rules.OFFSIDE}):
        scene = Scene(**change)
        scene.put("l2", 5.0, 0.0, body=0.0).put_ball(5.6, 0.0).put("l3", 30.0, 5.0)
        scene.put("r1", 50.0, 0.0).put("r2", 20.0, -10.0).put("r3", 10.0, 20.0).put("r4", 10.0, 23.0)
        scene.kick("l2", 50.0).step().put_ball(30.5, 5.0).kick("l3")
        assert scene.mode == "play_on"


def test_offside_team_goes_back_behind_the_line():
    scene = offside_scene()
    scene.put("r3", 10.0, 20.0).put("r4", 10.0, 23.0).put("l4", 40.0, -20.0)
    scene.kick("l2", 50.0).step().put_ball(30.5, 5.0).kick("l3").step()
    assert scene.place_of("l4")[0] == pytest.approx(20.0 - 9.15)


# --- illegal defence, limits of the pitch, rules switched off


def test_too_many_defenders_for_too_long_are_an_illegal_defence():
    scene = Scene(4, 4, illegal_defense_number=3)
    for unum in (2, 3, 4):
        scene.put(f"l{unum}", -48.0, unum * 3.0)
    scene.put("r2", -30.0, 0.0, body=0.0).put_ball(-29.4, 0.0).kick("r2", 1.0)
    assert scene.steps_until("illegal_defense_l") == 20
    assert scene.ball == (-41.5, 0.0)
    assert scene.steps_until("free_kick_r") == 31


def test_defence_is_legal_with_the_default_parameters():
    scene = Scene(4, 4)
    for unum in (2, 3, 4):
        scene.put(f"l{unum}", -48.0, unum * 3.0)
    scene.put("r2", -30.0, 0.0, body=0.0).put_ball(-29.4, 0.0).kick("r2", 1.0).step(60)
    assert scene.mode == "play_on"


def test_nobody_leaves_the_margin_round_the_pitch():
    scene = Scene().put("l2", 60.0, 10.0).put("l3", 0.0, -50.0).step()
    assert scene.place_of("l2") == (57.5, 10.0)
    assert scene.place_of("l3") == (0.0, -39.0)


def test_without_rules_the_ball_rolls_out_and_time_never_ends():
    scene = Scene(rules=Rules.NONE, half_time=1).put_ball(52.0, 0.0, 2.0).step(30)
    assert scene.mode == "play_on"
    assert scene.ball[0] > 60.0
    assert not scene.said


def test_a_rule_alone_works_without_the_others():
    scene = Scene(rules=Rules.TOUCH).put_ball(51.5, 0.0, 2.0).step()
    assert scene.mode == "goal_l"
    scene = Scene(rules=Rules.FREE_KICK).put_ball(51.5, 0.0, 2.0).step()
    assert scene.mode == "play_on"


def test_moving_after_a_goal_is_allowed():
    scene = Scene().put_ball(51.5, 0.0, 2.0).step().do("l2", CommandKind.MOVE, -10.0, 5.0)
    assert np.allclose(scene.place_of("l2"), (-10.0, 5.0))


def test_goal_kick_that_does_not_leave_the_area_is_repeated_and_then_forfeited():
    scene = Scene(proper_goal_kicks=True).put_ball(-52.0, 20.0, -1.0)
    scene.world["touch_player"] = player("r2")
    scene.step()
    scene.said.clear()
    while scene.mode == "goal_kick_l":
        scene.put("l1", -47.6, 9.16, body=0.0).kick("l1", 5.0)
        said = len(scene.said)
        while len(scene.said) == said:
            scene.step()
            scene.put("l1", -50.0, 0.0)
    assert scene.said == ["goal_kick_l", "goal_kick_l", "free_kick_r"]


def test_a_second_kick_within_the_area_is_allowed_without_proper_goal_kicks():
    scene = Scene().put_ball(-52.0, 20.0, -1.0)
    scene.world["touch_player"] = player("r2")
    scene.step().put("l1", -47.6, 9.16, body=0.0).kick("l1", 5.0).step()
    scene.said.clear()
    scene.put("l2", scene.ball[0] - 0.6, 9.16, body=0.0).kick("l2", 100.0)
    assert scene.steps_until("play_on", 20) > 1
    assert scene.said == ["play_on"]
