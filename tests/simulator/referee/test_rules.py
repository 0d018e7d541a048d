"""Every module of the referee can be switched off alone (`Rules`)."""

from __future__ import annotations

import math

import pytest
from referee_scenes import Scene, player

from cprm_gym.simulator.parameters import Rules


def half_time(rules: Rules) -> bool:
    scene = Scene(rules=rules, half_time=1).step(10)
    return "half_time" in scene.said


def stuck_ball(rules: Rules) -> bool:
    return "drop_ball" in Scene(rules=rules).step(101).said


def offside(rules: Rules) -> bool:
    scene = Scene(rules=rules).put("l2", 5.0, 0.0, body=0.0).put_ball(5.6, 0.0).put("l3", 30.0, 5.0).put("r1", 50.0, 0.0)
    for unum in (2, 3, 4):
        scene.put(f"r{unum}", 10.0, 20.0 + unum)
    scene.kick("l2", 50.0).step().put_ball(30.5, 5.0).kick("l3")
    return scene.mode == "offside_l"


def set_play(rules: Rules) -> bool:
    return Scene(rules=rules, mode="free_kick_l").put("l2", -0.6, 25.0, body=0.0).kick("l2").mode == "play_on"


def out(rules: Rules) -> bool:
    scene = Scene(rules=rules).put_ball(0.0, 34.0, 0.0, 1.0)
    scene.world["touch_player"] = player("l2")
    return scene.step().mode == "kick_in_r"


def caught_ball(rules: Rules) -> bool:
    return Scene(rules=rules).put("l1", -45.0, 0.0, body=0.0).put_ball(-44.1, 0.0).catch("l1").mode == "free_kick_l"


def foul(rules: Rules) -> bool:
    scene = Scene(rules=rules).put("l2", 0.0, 0.0, body=0.0).put("r2", 0.9, 0.0, body=0.0).put_ball(1.6, 0.0)
    scene.world["forced_tackle"][1] = scene.world["forced_foul"][1] = 1
    return scene.dash("r2", 1.0).tackle("l2").mode == "foul_charge_l"


def illegal_defense(rules: Rules) -> bool:
    scene = Scene(rules=rules, illegal_defense_number=1).put("l2", -48.0, 3.0)
    scene.put("r2", -30.0, 0.0, body=0.0).put_ball(-29.4, 0.0).kick("r2", 1.0).step(21)
    return "illegal_defense_l" in scene.said


def keepaway(rules: Rules) -> bool:
    scene = Scene(3, 2, goalies=(0, 0), rules=rules, keepaway=True, half_time=-1).put_ball(9.9, 0.0, 1.0).step()
    return "training Keepaway 1" in scene.said


def shoot_out(rules: Rules) -> bool:
    scene = Scene(rules=rules, half_time=1, nr_extra_halfs=0)
    scene.world["time"], scene.world["half_count"] = 19, 1
    return scene.step().mode.startswith("penalty_setup")


SCENES = {
    Rules.TIME: half_time,
    Rules.BALL_STUCK: stuck_ball,
    Rules.OFFSIDE: offside,
    Rules.FREE_KICK: set_play,
    Rules.TOUCH: out,
    Rules.CATCH: caught_ball,
    Rules.FOUL: foul,
    Rules.ILLEGAL_DEFENSE: illegal_defense,
    Rules.KEEPAWAY: keepaway,
    Rules.PENALTY: shoot_out,
}


def test_every_module_has_a_scene():
    assert set(SCENES) == {rule for rule in Rules if rule.value.bit_count() == 1}


@pytest.mark.parametrize("rule", list(SCENES), ids=lambda rule: rule.name)
def test_a_module_acts_alone_and_not_when_it_is_switched_off(rule):
    scene = SCENES[rule]
    assert scene(Rules.ALL)
    assert scene(rule)
    assert not scene(Rules.ALL & ~rule)


def test_referee_without_rules_says_nothing():
    scene = Scene(rules=Rules.NONE, half_time=1).put("l2", 52.0, 33.0, body=math.pi / 4).put_ball(52.3, 33.3).kick("l2", 100.0)
    assert not scene.step(30).said
