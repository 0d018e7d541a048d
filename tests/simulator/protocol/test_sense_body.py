"""Sense_body and fullstate: text of a real server, arrays, roundings."""

import math

import numpy as np
import pytest
from senses_recordings import ROW, cases, load, recording, simulator

from cprm_gym.errors import ParameterError
from cprm_gym.simulator.conformance.recording import load_hidden
from cprm_gym.simulator.protocol.messages import fullstate_text, global_text, score_text, sense_body_text
from cprm_gym.simulator.senses import BodyColumn, new_body, sense_body
from cprm_gym.simulator.simulator import Simulator, no_commands
from cprm_gym.simulator.state import CommandKind, PlayerBit, PlayMode

LETTERS = {"b": 1, "p": 2, "g": 4}
CARDS = {"none": 0, "yellow": PlayerBit.YELLOW_CARD, "red": PlayerBit.RED_CARD}


def in_play(**changes):
    sim = Simulator(1, **changes)
    sim.world["mode"] = PlayMode.play_on
    return sim


@pytest.mark.parametrize("seed", [0, 1])
def test_recorded_sense_body_texts_come_out_equal(seed):
    """Of six players among random commands; what is hidden comes from the recording, all numbers and roundings from the state."""
    recorded = recording(f"monkey_sight_{seed}")
    sim = simulator(recorded)
    w, fields = sim.world[0], recorded.header["hid_fields"]
    compared = 0
    for step in cases(recorded)[0]["steps"]:
        load(sim, step["state"], step["state"]["t"])
        for key, values in step["hid"].items():
            row, told = ROW[key], dict(zip(fields, values))
            load_hidden(w, row, fields, values, 20)
            if told["arm_expires"] == 0:
                w["arm_timer"][row] = 20
            if told["arm_movable"]:
                w["arm_timer"][row] = 5 - told["arm_movable"]
            w["collided"][row] = sum(LETTERS[letter] for letter in told["collision"]) << 4
            w["bits"][row] = CARDS[told["card"]]
        for key, texts in step.get("msgs", {}).items():
            for text in texts:
                if text.startswith("(sense_body "):
                    assert sense_body_text(sim, 0, ROW[key] + 1) == text, step["i"]
                    compared += 1
    assert compared == 900


def test_protocol_18_adds_the_focus_and_each_version_what_it_brought():
    sim = in_play()
    sim.advance()
    w = sim.world[0]
    w["neck"][1], w["vel"][2], w["card_count"][1], w["attention"][1] = 0.5, (0.3, 0.4), 0, 15
    w["body"][1] = 0.0
    w["collided"][1], w["tackle_cycles"][1], w["bits"][1] = 5 << 4, 7, PlayerBit.YELLOW_CARD
    w["focus_distance"][1], w["focus_direction"][1] = 12.5, math.pi / 6
    texts = {version: sense_body_text(sim, 0, 2, version) for version in (4, 5, 6, 7, 8, 12, 13, 14, 18, 19)}
    assert texts[4] == "(sense_body 1 (view_mode high normal) (stamina 8000 1) (speed 0.5) (kick 0) (dash 0) (turn 0) (say 0))"
    assert texts[5] == texts[4].replace("(speed 0.5)", "(speed 0.5) (head_angle 28)").replace("(say 0)", "(say 0) (turn_neck 0)")
    assert texts[6] == texts[5].replace("(speed 0.5)", "(speed 0.5 24)")
    assert texts[7] == texts[6][:-1] + " (catch 0) (move 0) (change_view 0))"
    assert texts[8] == texts[7][:-1] + (
        " (arm (movable 0) (expires 0) (target 0 0) (count 0)) (focus (target r 4) (count 0)) (tackle (expires 7) (count 0)))"
    )
    assert texts[12] == texts[8][:-1] + " (collision (ball) (post)))"
    assert texts[13] == texts[12].replace("(stamina 8000 1)", "(stamina 8000 1 130600)")
    assert texts[14] == texts[13][:-1] + " (foul (charged 0) (card yellow)))"
    assert texts[18] == texts[14].replace("(change_view 0)", "(change_view 0) (change_focus 0)")[:-1] + " (focus_point 12.5 30))"
    assert texts[19] == texts[18]


def test_head_angle_is_truncated():
    """Test vector 24 of specification/simulator.md 9: neck 30 degrees is reported as 29."""
    sim = in_play()
    commands = no_commands(1, 22)
    commands["turn_neck"][0, 0] = 30.0
    sim.step(commands)
    assert sim.world["neck"][0, 0] == 30.0 * (math.pi / 180.0)
    assert "(head_angle 29)" in sense_body_text(sim, 0, 1)
    assert sense_body(sim.world, sim.packed)[0, 0, BodyColumn.HEAD_ANGLE] == pytest.approx(math.radians(29))


def test_direction_of_no_speed_is_minus_the_face():
    sim = in_play()
    sim.world["body"][0, 2], sim.world["neck"][0, 2] = math.radians(100.2), math.radians(20)
    assert "(speed 0 -120)" in sense_body_text(sim, 0, 3)


def test_after_pointing_and_tackling_the_arm_and_the_freeze_count_down():
    """specification/simulator.md 6.2: the message after the step shows movable 4, expires 19, and expires 9 of a tackle."""
    sim = in_play()
    commands = no_commands(1, 22)
    commands["point"][0, 1] = 10.0, 20.0
    commands["kind"][0, 2], commands["a"][0, 2], commands["b"][0, 2] = CommandKind.TACKLE, 0.0, 0.0
    sim.step(commands)
    body = sense_body(sim.world, sim.packed)[0]
    assert "(arm (movable 4) (expires 19) (target 10 20) (count 1))" in sense_body_text(sim, 0, 2)
    assert body[1, BodyColumn.ARM_MOVABLE] == 4
    assert body[1, BodyColumn.ARM_EXPIRES] == 19
    assert body[1, BodyColumn.ARM_DISTANCE] == 10.0
    assert body[1, BodyColumn.ARM_DIRECTION] == pytest.approx(math.radians(20))
    assert "(tackle (expires 9) (count 1))" in sense_body_text(sim, 0, 3)
    assert body[2, BodyColumn.TACKLE_EXPIRES] == 9
    assert body[2, BodyColumn.COUNT_TACKLE] == 1
    for _ in range(19):
        sim.advance()
    assert "(arm (movable 0) (expires 0) (target 0 0) (count 1))" in sense_body_text(sim, 0, 2)


def test_collisions_are_told_once():
    sim = in_play()
    w = sim.world[0]
    w["pos"][1], w["pos"][2] = (20.0, 20.0), (20.1, 20.0)
    sim.advance()
    assert "(collision (player))" in sense_body_text(sim, 0, 1)
    assert sense_body(sim.world, sim.packed)[0, 0, BodyColumn.HIT_PLAYER] == 1
    sim.advance()
    assert "(collision none)" in sense_body_text(sim, 0, 1)


def test_array_and_text_tell_the_same():
    from cprm_gym.simulator.protocol.message_parser import parse_sense_body

    sim = in_play()
    rng = np.random.default_rng(5)
    w = sim.world
    w["vel"], w["body"], w["neck"] = rng.normal(size=(1, 23, 2)), rng.uniform(-3, 3, (1, 22)), rng.uniform(-1.5, 1.5, (1, 22))
    w["stamina"], w["counts"] = rng.uniform(0, 8000, (1, 22)), rng.integers(0, 99, (1, 22, 13))
    body = sense_body(w, sim.packed)[0]
    for row in range(22):
        told = parse_sense_body(sense_body_text(sim, 0, row + 1))
        assert told["stamina"][0] == pytest.approx(body[row, BodyColumn.STAMINA], rel=1e-5)
        assert told["speed"][0] == pytest.approx(body[row, BodyColumn.SPEED])
        assert told["speed"][1] == pytest.approx(math.degrees(body[row, BodyColumn.SPEED_DIRECTION]))
        assert told["head_angle"][0] == pytest.approx(math.degrees(body[row, BodyColumn.HEAD_ANGLE]))
        for name in ("kick", "dash", "turn", "catch", "move", "turn_neck", "change_view", "change_focus", "say"):
            assert told[name][0] == body[row, BodyColumn[f"COUNT_{name.upper()}"]]


def test_players_who_are_not_there_are_told_nothing():
    sim = in_play(left=3, right=2, goalies=(1, 1))
    body = sense_body(sim.world, sim.packed, new_body(1) + 7.0)[0]
    assert not body[3:11].any()
    assert not body[13:].any()
    assert body[:3, BodyColumn.STAMINA].all()


def test_fullstate_is_the_example_of_the_protocol():
    """specification/protocol.md 5.6: the message of player 2 after he pointed and tackled at the kick-off."""
    sim = in_play(left=2, right=0, goalies=(1, 0))
    w = sim.world[0]
    sim.types = (sim.types[0],)
    w["mode"], w["time"] = PlayMode.kick_off_l, 4
    w["pos"][0], w["vel"][0], w["pos"][1], w["pos"][2], w["body"][:2] = (0, 0), (0, 0), (-50, 0), (-2, 1), 0.0
    w["type"][1], w["effort"][1], w["tackle_cycles"][1] = 1, 0.927494, 8
    w["counts"][1, 1] = w["counts"][1, 4] = 1
    w["counts"][0, [1, 4]], w["counts"][0, 7] = 1, 1
    w["kick_cycles"] = -1
    angle = 0.349066
    w["arm_timer"][1], w["arm_target"][1] = 3, (-2 + 10 * math.cos(angle), 1 + 10 * math.sin(angle))
    assert fullstate_text(sim, 0, 1) == (
        "(fullstate 4 (pmode kick_off_l) (vmode high normal) (count 0 1 0 0 1 0 0 0 1) (arm (movable 0) (expires 0) (target 0 0) (count 0))"
        " (score 0 0) ((b) 0 0 0 0) ((p l 1 g 0) -50 0 0 0 0 0 (focus_point 0 0) (stamina 8000 1 1 130600))"
        " ((p l 2 1) -2 1 0 0 0 0 10 0.349066 (focus_point 0 0) (stamina 8000 0.927494 1 130600) t))"
    )


def test_fullstate_has_the_own_arm_unrounded_in_length_and_rounded_in_angle():
    """As the server printed it beside a sense_body that said 17 and 165."""
    sim = in_play(left=1, right=0, goalies=(0, 0))
    w, angle = sim.world[0], math.radians(165.6)
    w["pos"][1], w["body"][0], w["arm_timer"][0] = (1.0, 2.0), 0.0, 3
    w["arm_target"][0] = 1.0 + 16.9628 * math.cos(angle), 2.0 + 16.9628 * math.sin(angle)
    assert "(target 16.9628 166)" in fullstate_text(sim, 0, 1)
    assert "(target 17 165)" in sense_body_text(sim, 0, 1)
    w["arm_timer"][0] = 1000
    assert "(target 0 0)" in fullstate_text(sim, 0, 1, 8)


@pytest.mark.parametrize(("stamina", "told"), [(7999.9, "7999"), (0.7, "0"), (8000.0, "8000")])
def test_fullstate_before_version_8_cuts_stamina(stamina, told):
    sim = in_play(left=1, right=0, goalies=(0, 0))
    sim.world["stamina"][0, 0] = stamina
    assert fullstate_text(sim, 0, 1, 6).endswith(f" {told} 1 1))")


def test_fullstate_of_older_versions_and_of_a_goalie_with_the_ball():
    sim = in_play(left=1, right=1)
    w = sim.world[0]
    w["mode"], w["ball_catcher"], w["score"], w["kick_cycles"] = PlayMode.free_kick_r, 12, (3, 1), -1
    w["bits"][11], w["foul_cycles"][0] = PlayerBit.RED_CARD, 2
    new, old = fullstate_text(sim, 0, 12, 19), fullstate_text(sim, 0, 12, 8)
    assert "(pmode goalie_catch_ball_r)" in new
    assert "(score 1 3)" in new
    assert "((p r 1 g 0)" in new
    assert "((p r 1 g)" in old
    assert "focus_point" not in old
    assert "130600" not in old
    assert new.endswith(" r)") is False
    assert new.endswith(" r))")
    assert " f) " in new
    w["pos"][0], w["pos"][1], w["vel"][1] = (1.23456, -2.0), (0.0, 0.00049), 0.0
    w["stamina"][0], w["effort"][0], w["body"][0] = 77.7, 0.98765, 1.0
    w["enabled"][11], w["time"] = 0, 9
    assert fullstate_text(sim, 0, 12, 7) == (
        "(fullstate 9 (pmode goalie_catch_ball_r) (vmode high normal) (score 1 0) (ball 1.235 -2 0 0) (l_1 0 0 0 0 57.296 0 77 0.9876 1))"
    )
    with pytest.raises(ParameterError, match="versions 5 to 19, got 4"):
        fullstate_text(sim, 0, 12, 4)


def test_the_trainers_look_is_the_example_of_the_protocol():
    """specification/protocol.md 6; the coach's picture of the same moment marks a kick and cards too."""
    sim = in_play(left=2, right=1, goalies=(1, 0))
    w = sim.world[0]
    w["time"], w["kick_cycles"], w["body"][:], w["pos"][0], w["vel"][0] = 5, -1, 0.0, 0.0, 0.0
    w["pos"][1], w["pos"][2], w["pos"][12], w["vel"][12] = (-50, 0), (-2, 1), (10.962, 0.101363), (0.0388515, 0.00556502)
    w["tackle_cycles"][1], w["arm_timer"][1], w["arm_target"][1] = 3, 0, (-2 + math.cos(0.349066), 1 + math.sin(0.349066))
    example = (
        '(ok look 5 ((g r) 52.5 0) ((g l) -52.5 0) ((b) 0 0 0 0) ((p "Left" 1 goalie) -50 0 0 0 0 0) ((p "Left" 2) -2 1 0 0 0 0 20 t)'
        ' ((p "Right" 1) 10.962 0.101363 0.0388515 0.00556502 0 0))'
    )
    assert global_text(sim, 0, look=True) == example
    assert global_text(sim, 0) == example.replace("(ok look", "(see_global")
    w["kick_cycles"][0], w["bits"][11], w["foul_cycles"][11] = 0, PlayerBit.YELLOW_CARD, 3
    assert global_text(sim, 0, look=True) == example
    assert "0 0 0 0 0 k) " in global_text(sim, 0)
    assert global_text(sim, 0).endswith("0 0 f y))")


def test_the_score_is_told_from_the_own_side():
    sim = in_play()
    sim.world["score"], sim.world["time"] = (3, 1), 70
    assert score_text(sim, 0, 2) == "(score 70 3 1)"
    assert score_text(sim, 0, 15) == "(score 70 1 3)"
