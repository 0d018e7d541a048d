"""The penalty shoot-out (specification/simulator.md 7.14)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from referee_scenes import Scene, player


def level_match(players: int = 4, **parameters: Any) -> Scene:
    """A match that is level one step before its end."""
    scene = Scene(players, players, **{"half_time": 25, "nr_extra_halfs": 0, **parameters})
    scene.world["time"], scene.world["half_count"] = 499, 1
    return scene.step()


def shooting(scene: Scene) -> str:
    return "l" if scene.world["pen_taker_side"] > 0 else "r"


def attempt(scene: Scene, scored: bool) -> None:
    """Play one kick: the taker shoots, and the ball is helped into the goal or beside it."""
    side = shooting(scene)
    assert scene.mode == f"penalty_setup_{side}"
    scene.steps_until(f"penalty_ready_{side}")
    goal = -float(scene.world["pen_side"])
    bx, by = scene.ball
    fresh = [name for name in (f"{side}{unum}" for unum in range(2, 12)) if not scene.world["pen_used"][player(name) - 1]]
    near = min(fresh, key=lambda name: math.dist(scene.place_of(name), (bx, by)))
    scene.put(near, bx - 0.6 * goal, by, body=0.0 if goal > 0 else math.pi).kick(near, 10.0)
    assert scene.mode == f"penalty_taken_{side}"
    scene.step()
    scene.put_ball(51.5 * goal, 0.0 if scored else 12.0, 2.0 * goal).step(2)
    scene.listen()
    assert scene.mode == f"penalty_{'score' if scored else 'miss'}_{side}" or scene.mode == "time_over"


def play(scene: Scene, left: str, right: str) -> str:
    """Both teams score (x) or miss (o) as told, until the shoot-out is over; the last announcement before time_over."""
    plans = {"l": list(left), "r": list(right)}
    while scene.mode != "time_over":
        if not scene.mode.startswith("penalty_setup"):
            scene.step()
            continue
        attempt(scene, plans[shooting(scene)].pop(0) == "x")
    return next(text for text in reversed(scene.said) if text.startswith(("penalty_winner", "penalty_draw")))


def test_level_match_goes_to_penalties_and_the_phases_take_the_server_s_time():
    scene = level_match()
    assert [text.rpartition("_")[0] for text in scene.said] == ["penalty_onfield", "penalty_setup"]
    first = shooting(scene)
    times = {}
    while len(times) < 5:
        times.setdefault((scene.mode, shooting(scene)), int(scene.world["time"]))
        scene.step()
    second = "r" if first == "l" else "l"
    assert times == {
        (f"penalty_setup_{first}", first): 500,
        (f"penalty_ready_{first}", first): 570,
        (f"penalty_miss_{first}", first): 581,
        (f"penalty_setup_{second}", second): 592,
        (f"penalty_ready_{second}", second): 663,
    }


def test_players_are_put_where_they_belong():
    scene = level_match()
    side = shooting(scene)
    other = "r" if side == "l" else "l"
    goal = -float(scene.world["pen_side"])
    scene.put(f"{side}4", 5.0, 5.0).put(f"{other}3", 30.0, 30.0).put(f"{other}1", 0.0, 0.0)
    scene.steps_until(f"penalty_ready_{side}")
    assert math.dist(scene.place_of(f"{side}4"), scene.ball) <= 2.0 + 1e-9
    assert math.hypot(*scene.place_of(f"{other}3")) <= 9.15 - 0.3 + 1e-9
    assert scene.place_of(f"{other}1") == (pytest.approx(40.0 * goal), 0.0)
    x, y = scene.place_of(f"{side}1")
    assert math.dist((x, abs(y)), (54.5 * goal, 25.0)) <= 2.0 + 1e-9


def test_kick_before_the_ball_is_ready_is_a_foul_of_that_side():
    scene = level_match()
    side = shooting(scene)
    other = "r" if side == "l" else "l"
    scene.put(f"{other}3", scene.ball[0] - 0.5, 0.0, body=0.0).kick(f"{other}3", 10.0).listen()
    assert scene.said[-2:] == [f"penalty_foul_{other}", f"penalty_score_{side}"]
    assert not scene.world["acc"][0].any()


@pytest.mark.parametrize(
    ("left", "right", "winner", "kicks"),
    [
        ("xxx", "ooo", "penalty_winner_l", 6),
        ("ooo", "xxx", "penalty_winner_r", 6),
        ("xxxxxx", "xxxxxo", "penalty_winner_l", 12),
        ("oooooxo", "ooooox" + "x", "penalty_winner_r", 14),
    ],
)
def test_shoot_out_ends_when_it_is_decided(left, right, winner, kicks):
    scene = level_match(11)
    assert play(scene, left, right) == winner
    assert scene.world["pen_number"] == kicks
    assert scene.world["score"].tolist() == [0, 0]
    assert scene.world["pen_score"].tolist() == [left[: kicks // 2].count("x"), right[: kicks // 2].count("x")]


def test_shoot_out_without_a_winner_is_a_draw_or_a_toss():
    scene = level_match(11, pen_nr_kicks=1, pen_max_extra_kicks=1)
    assert play(scene, "xxx", "xxx") == "penalty_draw"
    scene = level_match(11, pen_nr_kicks=1, pen_max_extra_kicks=1, pen_random_winner=True)
    assert play(scene, "xxx", "xxx") in ("penalty_winner_l", "penalty_winner_r")


def test_either_goal_and_either_team_may_come_first():
    seen = set()
    for seed in range(24):
        scene = Scene(4, 4, half_time=25, nr_extra_halfs=0, seed=seed)
        scene.world["time"], scene.world["half_count"] = 499, 1
        scene.step()
        seen.add((int(scene.world["pen_side"]), shooting(scene)))
    assert len(seen) == 4


def test_goalie_who_catches_the_shot_wins_the_attempt():
    scene = level_match()
    side = shooting(scene)
    other = "r" if side == "l" else "l"
    scene.steps_until(f"penalty_ready_{side}")
    goal = -float(scene.world["pen_side"])
    bx, by = scene.ball
    scene.put(f"{side}2", bx - 0.6 * goal, by, body=0.0 if goal > 0 else math.pi)
    scene.kick(f"{side}2", 10.0).step()
    scene.put(f"{other}1", 48.0 * goal, 0.0, body=math.pi if goal > 0 else 0.0).put_ball(47.2 * goal, 0.0, 0.1 * goal)
    scene.catch(f"{other}1").listen()
    assert scene.said[-1] == f"penalty_miss_{side}"
    assert scene.world["ball_catcher"] == 0


def test_taker_has_a_limited_time():
    scene = level_match(pen_taken_wait=20)
    side = shooting(scene)
    scene.steps_until(f"penalty_ready_{side}")
    goal = -float(scene.world["pen_side"])
    bx, by = scene.ball
    scene.put(f"{side}2", bx - 0.6 * goal, by, body=0.0 if goal > 0 else math.pi).kick(f"{side}2", 1.0)
    assert scene.mode == f"penalty_taken_{side}"
    assert scene.steps_until(f"penalty_miss_{side}") == 21


def test_dribbling_can_be_forbidden():
    scene = level_match(pen_allow_mult_kicks=False)
    side = shooting(scene)
    scene.steps_until(f"penalty_ready_{side}")
    goal = -float(scene.world["pen_side"])
    bx, by = scene.ball
    body = 0.0 if goal > 0 else math.pi
    scene.put(f"{side}2", bx - 0.6 * goal, by, body=body).kick(f"{side}2", 1.0).step(2)
    scene.kick(f"{side}2", 1.0).listen()
    assert scene.said[-2:] == [f"penalty_foul_{side}", f"penalty_miss_{side}"]


def test_players_take_turns():
    scene = level_match()
    side = shooting(scene)
    attempt(scene, True)
    used = scene.world["pen_used"]
    assert used.sum() == 1
    taker = int(used.argmax())
    attempt_by_other = scene.steps_until(f"penalty_setup_{'r' if side == 'l' else 'l'}")
    assert attempt_by_other > 0
    attempt(scene, True)
    scene.steps_until(f"penalty_setup_{side}")
    scene.put(f"{side}{taker % 11 + 1}", *scene.ball)
    scene.steps_until(f"penalty_ready_{side}")
    assert math.dist(scene.sim.world[0]["pos"][taker + 1], (0.0, 0.0)) <= 9.15
    assert player(f"{side}{taker % 11 + 1}") == taker + 1


def test_trainer_may_have_penalties_practised():
    scene = Scene(mode="penalty_ready_r").put_ball(-42.5, 0.0).put("r2", -41.9, 0.0, body=math.pi).kick("r2", 10.0)
    assert scene.mode == "penalty_taken_r"
    scene.step().put_ball(-51.5, 0.0, -2.0).step(2).listen()
    assert scene.said[-1] == "penalty_score_r"


def test_nobody_shoots_in_a_mode_that_a_trainer_has_set_until_something_happens():
    """As recorded (session s06a): both goalies go in front of the one goal, and stay when the trainer sets the other side's mode."""
    scene = Scene(mode="penalty_setup_l").put_ball(47.0, 9.16).put("l1", -49.8, -24.4).put("r1", 8.8, -33.8).step(2)
    assert scene.sim.world["pos"][0, [1, 12]].tolist() == [[-49.8, -24.4], [8.8, -33.8]]
    for mode in ("penalty_ready_l", "penalty_ready_r"):
        scene.sim.trainer.change_mode(mode)
        scene.step()
        assert scene.sim.world["pos"][0, [1, 12]] == pytest.approx(np.array([[40.0, 0.0]] * 2), abs=0.31)  # as far as they push each other
    scene.sim.trainer.change_mode("penalty_ready_l")
    scene.steps_until("penalty_miss_l")
