"""The trainer's and coaches' powers (specification/simulator.md 4.9, 4.10) and the referee's words."""

from __future__ import annotations

import math

import numpy as np
import pytest
from referee_scenes import Scene, player

from cprm_gym.errors import CommandError, ParameterError, UnknownName
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import Announcement, PlayMode
from cprm_gym.simulator.trainer import announcement_text


def test_announcements_are_the_server_s_words():
    cases = {
        "kick_off_l": (Announcement.MODE, PlayMode.kick_off_l),
        "goal_r_3": (Announcement.GOAL, -1, 3),
        "half_time": (Announcement.HALF_TIME,),
        "time_extended": (Announcement.TIME_EXTENDED,),
        "time_up": (Announcement.TIME_UP,),
        "time_up_without_a_team": (Announcement.TIME_UP_WITHOUT_A_TEAM,),
        "goalie_catch_ball_l": (Announcement.GOALIE_CATCH_BALL, 1),
        "yellow_card_l_5": (Announcement.YELLOW_CARD, 1, 5),
        "red_card_r_11": (Announcement.RED_CARD, -1, 11),
        "penalty_onfield_r": (Announcement.PENALTY_ONFIELD, -1),
        "penalty_foul_l": (Announcement.PENALTY_FOUL, 1),
        "penalty_winner_r": (Announcement.PENALTY_WINNER, -1),
        "penalty_draw": (Announcement.PENALTY_DRAW,),
        "training Keepaway 1": (Announcement.TRAINING_KEEPAWAY, 1),
        "(change_player_type l 2 7)": (Announcement.CHANGE_PLAYER_TYPE, 1, 2, 7),
        "(change_player_type r 3 goalie)": (Announcement.PROMOTE_GOALIE, -1, 3),
    }
    assert {announcement_text(*(int(n) for n in row)) for row in cases.values()} == set(cases)
    assert {int(row[0]) for row in cases.values()} == {int(kind) for kind in Announcement if kind}


def test_unknown_announcement_is_refused():
    with pytest.raises(UnknownName, match="unknown announcement '99'"):
        announcement_text(99)


# --- trainer


def test_ball_is_placed_in_chosen_worlds_only_and_taken_from_the_goalie():
    sim = Simulator(3)
    sim.world["ball_catcher"] = 1
    sim.trainer.place_ball([1.0, 2.0], 5.0, vx=0.5, worlds=[0, 2])
    assert sim.world["pos"][:, 0].tolist() == [[1.0, 5.0], [0.0, 0.0], [2.0, 5.0]]
    assert sim.world["vel"][:, 0].tolist() == [[0.5, 0.0], [0.0, 0.0], [0.5, 0.0]]
    assert sim.world["ball_catcher"].tolist() == [0, 1, 0]


def test_worlds_can_be_a_mask():
    sim = Simulator(3)
    sim.trainer.change_mode("play_on", worlds=np.array([True, False, True]))
    assert [PlayMode(mode).name for mode in sim.world["mode"]] == ["play_on", "before_kick_off", "play_on"]


def test_player_keeps_what_is_not_given():
    scene = Scene()
    scene.sim.trainer.place_player(2, 5.0, 5.0, 1.0, (0.3, 0.1))
    scene.sim.trainer.place_player(2, 6.0, 5.0)
    row = scene.world
    assert row["pos"][2].tolist() == [6.0, 5.0]
    assert row["vel"][2].tolist() == [0.3, 0.1]
    assert row["body"][1] == row["body_staged"][1] == 1.0


def test_placed_player_pushes_away_who_is_in_his_place():
    scene = Scene().put("l2", 5.0, 5.0).put("r2", 5.2, 5.0)
    assert math.dist(scene.place_of("l2"), scene.place_of("r2")) >= 0.6


def test_an_angle_beyond_a_half_turn_is_refused():
    assert Scene().put("l2", 5.0, 5.0, body=math.pi).world["body"][1] == math.pi
    with pytest.raises(CommandError, match=r"`body` takes radians from -pi to pi, got 10.0"):
        Scene().put("l2", 5.0, 5.0, body=10.0)


def test_recover_rests_everybody():
    sim = Simulator(2)
    for name in ("stamina", "effort", "recovery", "capacity"):
        sim.world[name] = 0.5
    sim.trainer.recover(worlds=1)
    assert (sim.world["stamina"][1] == 8000.0).all()
    assert (sim.world["capacity"][1] == 130600.0).all()
    assert (sim.world["stamina"][0] == 0.5).all()


def test_trainer_substitutes_without_limits():
    scene = Scene()
    for number in (2, 3, 4):
        scene.sim.trainer.change_player_type(number, 7)
    assert scene.world["type"][1:4].tolist() == [7, 7, 7]


def test_substitution_wipes_cards_and_rests_the_player_where_he_is():
    scene = Scene().put("l2", 5.0, 5.0)
    scene.world["card_count"][1], scene.world["stamina"][1] = 1, 100.0
    scene.sim.trainer.change_player_type(2, 3)
    assert scene.world["card_count"][1] == 0
    assert scene.world["stamina"][1] == 8000.0
    assert scene.world["effort"][1] == scene.sim.types[3].effort_max
    assert scene.place_of("l2") == (5.0, 5.0)


@pytest.mark.parametrize(
    ("x", "y", "answer"),
    [
        (0.0, 0.0, "in_field"),
        (52.585, 34.085, "in_field"),
        (52.6, 0.0, "goal_r"),
        (-55.025, 7.04, "goal_l"),
        (-55.03, 0.0, "out_of_field"),
        (53.0, 7.05, "out_of_field"),
        (0.0, 34.1, "out_of_field"),
    ],
)
def test_check_ball(x, y, answer):
    sim = Simulator(2)
    sim.trainer.place_ball(x, y, worlds=1)
    assert sim.trainer.check_ball() == ["in_field", answer]


def test_mistakes_of_the_trainer_are_named():
    sim = Simulator(2)
    with pytest.raises(CommandError, match="place_ball: `vx` takes finite numbers"):
        sim.trainer.place_ball(0.0, 0.0, vx=math.nan)
    with pytest.raises(ParameterError, match="place_ball: `x` takes a number or 2 numbers"):
        sim.trainer.place_ball([1.0, 2.0, 3.0], 0.0)
    with pytest.raises(ParameterError, match="`worlds` takes indices 0 to 1"):
        sim.trainer.place_ball(0.0, 0.0, worlds=5)
    with pytest.raises(CommandError, match="`player` takes an object number from 1 to 22, got 23"):
        sim.trainer.place_player(23, 0.0, 0.0)
    with pytest.raises(UnknownName, match="Did you mean 'play_on'"):
        sim.trainer.change_mode("playon")
    with pytest.raises(UnknownName, match="unknown play mode '99'"):
        sim.trainer.change_mode(99)
    with pytest.raises(CommandError, match="`new_type` takes a player type from 0 to 17, got 18"):
        sim.trainer.change_player_type(1, 18)
    with pytest.raises(CommandError, match="player 14 is not on the field in world 0"):
        Simulator(right=2).trainer.change_player_type(14, 1)


def test_start_is_the_kick_off_procedure():
    sim = Simulator(2)
    sim.trainer.start(worlds=0)
    assert [PlayMode(mode).name for mode in sim.world["mode"]] == ["kick_off_l", "before_kick_off"]


# --- coaches


def coached(mode: str = "before_kick_off", time: int = 0, **parameters: object) -> Simulator:
    scene = Scene(11, 11, mode=mode, **parameters)
    scene.world["time"] = time
    return scene.sim


def test_coach_may_give_a_type_once():
    sim = coached()
    assert sim.coach.change_player_type(player("l7"), 3) == ["(ok change_player_type 7 3)"]
    assert sim.coach.change_player_type(player("l8"), 3) == ["(warning max_of_that_type_on_field)"]
    assert sim.coach.change_player_type(player("r8"), 3) == ["(ok change_player_type 8 3)"]
    assert sim.world["type"][0, [6, 7, 18]].tolist() == [3, 0, 3]


def test_coach_does_not_substitute_while_the_game_is_on():
    assert coached("play_on").coach.change_player_type(2, 3) == ["(warning cannot_sub_while_playon)"]


def test_coach_does_not_substitute_in_the_shoot_out():
    sim = coached("penalty_setup_l", 8000)
    assert sim.coach.change_player_type(2, 3) == ["(warning cannot_sub_while_penalty_shootouts)"]


def test_coach_has_three_substitutions_after_the_first_kick_off():
    sim = coached("free_kick_l", 10)
    answers = [sim.coach.change_player_type(number, number + 3)[0] for number in (2, 3, 4, 5)]
    assert answers == [f"(ok change_player_type {n} {n + 3})" for n in (2, 3, 4)] + ["(warning no_subs_left)"]


def test_coach_has_no_type_twice():
    sim = coached("free_kick_l", 10)
    assert sim.coach.change_player_type(2, 5)[0].startswith("(ok")
    sim.coach.change_player_type(2, 6)
    assert sim.coach.change_player_type(3, 5) == ["(warning no_left_of_that_type)"]


def test_coach_is_told_what_does_not_exist():
    sim = coached()
    assert sim.coach.change_player_type(2, 99) == ["(error out_of_range_player_type)"]
    sim.world["enabled"][0, 1] = 0
    assert sim.coach.change_player_type(2, 4) == ["(warning no_such_player)"]


def test_default_type_counts_too_unless_it_is_exempt():
    sim = coached()
    assert sim.coach.change_player_type(2, 0) == ["(ok change_player_type 2 0)"]
    assert sim.coach.change_player_type(3, 0) == ["(warning max_of_that_type_on_field)"]
    sim.packed["allow_mult_default_type"] = 1
    assert sim.coach.change_player_type(3, 0) == ["(ok change_player_type 3 0)"]


def test_coach_promotes_a_goalie_when_the_team_has_none():
    sim = coached()
    assert sim.coach.promote_goalie(2) == ["(error goalie_already_exists)"]
    sim.world["enabled"][0, 0] = 0
    assert sim.coach.promote_goalie(2) == ["(ok change_player_type 2 goalie)"]
    assert sim.world["goalie"][0, 1]
    sim = coached("play_on")
    assert sim.coach.promote_goalie(2) == ["(warning cannot_change_goalie_while_playon)"]
    sim = coached("penalty_ready_l")
    assert sim.coach.promote_goalie(2) == ["(warning cannot_change_goalie_while_penalty_taken)"]
