"""Reading messages back."""

import math

import pytest
from senses_recordings import random_worlds

from cprm_gym.errors import FormatError, UnknownName
from cprm_gym.simulator.landmarks import LANDMARK_NAMES, LANDMARK_POSITIONS, LANDMARK_PROTOCOLS, landmark_index
from cprm_gym.simulator.protocol.message_parser import SeenObject, parse_hear, parse_see, parse_sense_body
from cprm_gym.simulator.protocol.messages import see_text, sense_body_text


def test_the_forms_of_objects():
    told = parse_see(
        '(see 4 ((f c) 50.0019 0) ((G) 2.4914 180) ((b) 1.46389 27 0 -11.8) ((P) 2.97447 -90) ((p "R" 1 goalie) 1 -23 0.19 5.3 7 8 t)'
        ' ((p "R") 40.9 18 5 k) ((p) 60 3) ((p "L" 2) 3 4 0 0 5 6 7) ((f t l 10) -3) ((l r) 102.5 90))'
    )
    assert told.time == 4
    assert told.objects == (
        SeenObject("flag", "c", distance=50.0019, direction=0),
        SeenObject("goal", "", True, distance=2.4914, direction=180),
        SeenObject("ball", "", distance=1.46389, direction=27, distance_change=0.0, direction_change=-11.8),
        SeenObject("player", "", True, distance=2.97447, direction=-90),
        SeenObject("player", "", False, "R", 1, True, 1.0, -23, 0.19, 5.3, 7, 8, tackling=True),
        SeenObject("player", "", False, "R", distance=40.9, direction=18, pointing=5, kicking=True),
        SeenObject("player", "", distance=60.0, direction=3),
        SeenObject("player", "", False, "L", 2, False, 3.0, 4, 0.0, 0.0, 5, 6, 7),
        SeenObject("flag", "t l 10", direction=-3),
        SeenObject("line", "r", distance=102.5, direction=90),
    )


@pytest.mark.parametrize("protocol", [3, 4, 5, 6, 8, 13, 17, 19])
def test_texts_of_every_version_are_read_back(protocol):
    sim = random_worlds(10, seed=protocol)
    sim.world["tackle_cycles"][:, ::5], sim.world["arm_timer"][:, ::4] = 4, 1
    for world in range(10):
        text = see_text(sim, world, 5, protocol)
        objects = parse_see(text).objects
        assert len(objects) == text.count("((")
        for seen in objects:
            assert seen.distance is not None
            assert -180 <= seen.direction <= 180
            if seen.unum is not None:
                assert seen.distance_change is not None
                assert (seen.body is not None) == (protocol >= 4)
                assert (seen.head is not None) == (protocol >= 5)
        names = [seen.name for seen in objects if seen.kind == "flag" and not seen.close]
        assert {f"f {name}" for name in names} <= set(LANDMARK_NAMES)


@pytest.mark.parametrize(
    "text",
    ["", "(see)", "(see x)", "(see 3", "(see 3))", "(hear 3 self x)", "(see 3 (f c) 2 3)", "(see 3 ((q) 1 2))", "(see 3 ((b) z 2))"],
)
def test_what_is_no_see_message_is_refused(text):
    with pytest.raises(FormatError, match="see"):
        parse_see(text)


@pytest.mark.parametrize("text", ["", "(hear)", "(hear 3)", "(hear x self y)", '(hear 3 "m")', "(see 3)"])
def test_what_is_no_hear_message_is_refused(text):
    with pytest.raises(FormatError, match="hear"):
        parse_hear(text)


def test_hear_messages():
    assert parse_hear('(hear 3 116 our 1 "a b")')[1:] == ("our", 116, 1, "a b")
    assert parse_hear('(hear 9 -7 opp "x")')[1:] == ("opp", -7, None, "x")
    assert parse_hear("(hear 37 our 3)")[1:] == ("our", None, 3, None)
    assert parse_hear("(hear 37 opp)")[1:] == ("opp", None, None, None)
    assert parse_hear("(hear 2 referee goal_l_1)")[1:] == ("referee", None, None, "goal_l_1")
    assert parse_hear('(hear 3 online_coach_left (freeform "go"))').message == '(freeform "go")'
    assert parse_hear('(hear 9 -7 "x")').sender == "player"


@pytest.mark.parametrize(
    ("parse", "text"),
    [
        (parse_see, "(see 0 ((b) inf))"),
        (parse_see, "(see 0 ((b) 1e999 3))"),
        (parse_see, "(see 0 ((b) nan 3))"),
        (parse_see, "(see 0 " + "(" * 100_000 + ")" * 100_000 + ")"),
        (parse_see, "(" * 100_000),
        (parse_see, "(see " + "9" * 5000 + ")"),
        (parse_see, "(see 0 (((((b)))) 3))"),
        (parse_see, "(see 0 ((b) 1_0 3))"),
        (parse_see, "(see 0 ((b) \u0661 3))"),
        (parse_see, "(see 1_0 ((b) 10 3))"),
        (parse_see, '(see 0 ((p "a" 1_0) 3 4))'),
        (parse_hear, '(hear \u0661 self "a")'),
        (parse_sense_body, "(sense_body 0 " + "(" * 100_000 + ")" * 100_000 + ")"),
        (parse_sense_body, "(sense_body 0 (arm (())))"),
        (parse_hear, "(hear " + "9" * 5000 + ' self "a")'),
        (parse_hear, "(hear 0 " + "9" * 5000 + ' "a")'),
    ],
)
def test_hostile_messages_are_format_errors(parse, text):
    with pytest.raises(FormatError):
        parse(text)


@pytest.mark.parametrize("word", ["nan", "inf", "1e999", "1_0", "\u0661"])
def test_what_is_no_number_of_the_servers_stays_a_word(word):
    assert parse_sense_body(f"(sense_body 0 (speed {word} 1))")["speed"] == (word, 1.0)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("(hear 2 self Yab0Y)", (2, "self", None, None, "Yab0Y")),
        ("(hear 2 -28 Yab0Y)", (2, "player", -28, None, "Yab0Y")),
        ("(hear 7 15 ()", (7, "player", 15, None, "(")),
        ("(hear 0 97 (*>0?1- )", (0, "player", 97, None, "(*>0?1- ")),
        ("(hear 1 20 our 5)", (1, "player", 20, None, "our 5")),
        ("(hear 1 20 7)", (1, "player", 20, None, "7")),
    ],
)
def test_speech_before_version_7_has_no_quotes(text, told):
    assert parse_hear(text) == told


def test_sense_body_is_read_as_lists():
    sim = random_worlds(1)
    told = parse_sense_body(sense_body_text(sim, 0, 4))
    assert told["view_mode"][0] == "high"
    assert told["stamina"] == (8000.0, 1.0, 130600.0)
    assert told["focus.target"] == ("none",)
    assert told["arm.count"] == (0.0,)
    assert told["collision"] == ("none",)
    assert told["foul.card"] == ("none",)
    with pytest.raises(FormatError, match="sense_body"):
        parse_sense_body("(sense_body)")
    with pytest.raises(FormatError, match="sense_body"):
        parse_sense_body("(sense_body 3 x)")
    with pytest.raises(FormatError, match="sense_body"):
        parse_sense_body("(sense_body 3 (arm ()))")


def test_landmarks_are_those_of_the_table():
    assert len(LANDMARK_NAMES) == 55 == len(set(LANDMARK_NAMES))
    assert (LANDMARK_PROTOCOLS == 4).sum() == 36
    assert LANDMARK_POSITIONS[landmark_index("g r")].tolist() == [52.5, 0.0]
    assert LANDMARK_POSITIONS[landmark_index("f p l b")].tolist() == [-36.0, 20.16]
    mirrored = {(-x, -y) for x, y in LANDMARK_POSITIONS.tolist()}
    assert mirrored == set(map(tuple, LANDMARK_POSITIONS.tolist()))
    assert math.isclose(abs(LANDMARK_POSITIONS[landmark_index("f g l t")][1]), 7.01)
    with pytest.raises(UnknownName, match="Did you mean 'f g l t'"):
        landmark_index("f g l tt")
