"""The text of commands: the server's grammar."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cprm_gym.errors import CommandError
from cprm_gym.simulator.protocol.commands import (
    PlayerCommand,
    command_record,
    command_text,
    format_command,
    nothing,
    parse_commands,
    parse_trainer,
    side_of_team,
)
from cprm_gym.simulator.state import LEFT, RIGHT, CommandKind

NAN = math.nan


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("(dash 100)", [("dash", (100.0, 0.0))]),
        ("(dash 100 -30.5)(turn_neck +10)", [("dash", (100.0, -30.5)), ("turn_neck", (10.0,))]),
        ("( dash\t.5 )\n(turn 1e2)", [("dash", (0.5, 0.0)), ("turn", (100.0,))]),
        ("(dash (right 1 2) (l 3 4))", [("dash_legs", (3.0, 4.0, 1.0, 2.0))]),
        ("(tackle 30)(tackle -30 on)(tackle 0 false)", [("tackle", (30.0, False)), ("tackle", (-30.0, True)), ("tackle", (0.0, False))]),
        ("(change_view wide)(change_view narrow low)", [("change_view", (3, 0)), ("change_view", (1, 2))]),
        ('(say "a b")(say hi)(dash 100)', [("say", ("a b",)), ("say", ("hi)(dash 100",))]),
        ("(pointto 3 -4)(pointto off)", [("pointto", (3.0, -4.0)), ("pointto_off", ())]),
        (
            "(attentionto our 3)(attentionto left 4)(attentionto off)",
            [("attentionto", ("our", 3)), ("attentionto", ("l", 4)), ("attentionto_off", ())],
        ),
        ('(attentionto "kick" 3)(attentionto My_Team-2 11)', [("attentionto", ('="kick"', 3)), ("attentionto", ("=My_Team-2", 11))]),
        (
            "(ear (off opp))(ear (on our partial))(ear (on c))",
            [("ear", (False, "opp", None)), ("ear", (True, "our", "partial")), ("ear", (True, None, "complete"))],
        ),
        ("(clang (ver 7 8))(compression 9)", [("clang", (7, 8)), ("compression", (9,))]),
        (
            "(synch_see)(gaussian_see)(sense_body)(score)(done)(bye)",
            [(name, ()) for name in ("synch_see", "gaussian_see", "sense_body", "score", "done", "bye")],
        ),
        ("(turn 4294967297)", [("turn", (1.0,))]),
        ("", []),
    ],
)
def test_datagrams_are_read_in_order(text, expected):
    parsed = parse_commands(text)
    assert parsed.error is None
    assert [tuple(command) for command in parsed.commands] == expected


def test_a_leg_has_been_moved_when_its_list_ends():
    for text in ("(dash (l 50 0)(l 50 0))", "(dash (l 50 0) (r 20))", "(dash (l 50 0) 3)"):
        parsed = parse_commands(text)
        assert parsed.error is not None
        assert [command.args[:2] for command in parsed.commands] == [(50.0, 0.0)]


def test_one_leg_alone_leaves_the_other_undefined():
    (command,) = parse_commands("(dash (r 50 90))").commands
    assert math.isnan(command.args[0])
    assert command.args[2:] == (50.0, 90.0)


@pytest.mark.parametrize(
    ("text", "before"),
    [
        ("(dash 100)(turn 5.)", 1),
        ("(dash (l 100))", 0),
        ("(move (1 2))", 0),
        ("(catch)", 0),
        ("(pointto on 3 4)", 0),
        ("(dash100)", 0),
        ("(DASH 100)", 0),
        ("(turn nan)", 0),
        ("(turn inf)", 0),
        ("(turn 1,2)", 0),
        ('(say "")', 0),
        ("(say )", 0),
        ("(turn 30", 0),
        ("turn 30", 0),
        ("(kick 100)", 0),
        ("(kick 1 2 3)", 0),
        ("(attentionto kick 3)", 0),
        ("(attentionto our 3.5)", 0),
        ("(change_view normal medium)", 0),
        ("(dash (l 1 2) (l 3 4))", 1),
        ("(ear off)", 0),
        ("(fly)", 0),
        ("(turn 1)(turn 2))", 2),
        ("(turn 1)(change_focus 1)(turn 2)", 1),
        ("()", 0),
        ("(done done)", 0),
        ("(attentionto 3 4.5.6)", 0),
    ],
)
def test_commands_before_a_mistake_count_and_the_rest_is_dropped(text, before):
    parsed = parse_commands(text)
    assert parsed.error is not None
    assert 0 <= parsed.error <= len(text)
    assert len(parsed.commands) == before


numbers = st.floats(-1e6, 1e6, allow_nan=False)
commands = st.one_of(
    st.builds(lambda p, d: PlayerCommand("dash", (p, d)), numbers, numbers),
    st.builds(lambda *a: PlayerCommand("dash_legs", a), numbers, numbers, numbers, numbers),
    st.builds(lambda m: PlayerCommand("turn", (m,)), numbers),
    st.builds(lambda m: PlayerCommand("turn_neck", (m,)), numbers),
    st.builds(lambda p, d: PlayerCommand("kick", (p, d)), numbers, numbers),
    st.builds(lambda a, f: PlayerCommand("tackle", (a, f)), numbers, st.booleans()),
    st.builds(lambda d: PlayerCommand("catch", (d,)), numbers),
    st.builds(lambda x, y: PlayerCommand("move", (x, y)), numbers, numbers),
    st.builds(lambda w, q: PlayerCommand("change_view", (w, q)), st.integers(1, 3), st.integers(0, 2)),
    st.builds(lambda d, a: PlayerCommand("change_focus", (d, a)), numbers, numbers),
    st.builds(lambda d, a: PlayerCommand("pointto", (d, a)), numbers, numbers),
    st.sampled_from([PlayerCommand("pointto_off"), PlayerCommand("attentionto_off")]),
    st.builds(lambda t, u: PlayerCommand("attentionto", (t, u)), st.sampled_from(["our", "opp"]), st.integers(1, 11)),
    st.builds(lambda t: PlayerCommand("say", (t,)), st.text("abcXYZ019 ().+-*/?<>_", min_size=1, max_size=10)),
)


@given(st.lists(commands, max_size=4))
def test_what_is_written_reads_back(given_commands):
    text = "".join(format_command(command) for command in given_commands)
    parsed = parse_commands(text)
    assert parsed.error is None
    assert list(parsed.commands) == given_commands


@given(commands)
def test_a_record_tells_the_command_it_was_made_of(command):
    record = command_record(command)
    assert record is not None
    assert parse_commands(command_text(record[0])).commands == (command,)


@given(st.text('()dashturnkicksay 0123456789.-+"\\\n\0é', max_size=40))
def test_no_text_breaks_the_parser(text):
    parsed = parse_commands(text)
    for command in parsed.commands:
        format_command(command)


def test_teams_are_resolved_for_the_listener():
    names = ("Left", "opp")
    assert side_of_team("our", RIGHT, names) == RIGHT
    assert side_of_team("l", RIGHT, names) == LEFT
    assert side_of_team("opp", RIGHT, names) == LEFT
    assert side_of_team("=opp", RIGHT, names) == RIGHT
    assert side_of_team("=Nobody", LEFT, names) is None
    (command,) = parse_commands("(attentionto Left 7)").commands
    record = command_record(command, RIGHT, names)
    assert record is not None
    assert (record["attention_side"][0], record["attention_unum"][0]) == (2, 7)
    assert command_record(PlayerCommand("attentionto", ("=Nobody", 3)), LEFT, names) is None


def test_commands_without_effect_on_the_record_have_none():
    for text in ("(done)", "(ear (off))", "(long_kick 1 2)", "(attentionto our 12)"):
        (command,) = parse_commands(text).commands
        assert command_record(command) is None
    assert command_text(nothing()[0]) == ""
    assert nothing()["kind"][0] == CommandKind.NONE


def test_what_cannot_be_said_is_refused():
    with pytest.raises(CommandError, match="finite"):
        format_command(PlayerCommand("turn", (NAN,)))
    with pytest.raises(CommandError, match="say takes letters"):
        format_command(PlayerCommand("say", ('"quoted"',)))
    with pytest.raises(CommandError, match="unknown command 'fly'"):
        format_command(PlayerCommand("fly"))
    with pytest.raises(CommandError, match="at least one leg"):
        format_command(PlayerCommand("dash_legs", (NAN,) * 4))


def test_numbers_that_cannot_be_said_are_left_out_of_the_text():
    record = nothing()
    record["kind"], record["a"], record["b"] = CommandKind.DASH, math.inf, 0.0
    record["turn_neck"] = 30.0
    assert command_text(record[0]) == "(turn_neck 30)"
    record["kind"], record["a"] = CommandKind.TURN, NAN
    assert command_text(record[0]) == "(turn_neck 30)"


def test_trainer_commands_are_lists():
    assert parse_trainer("(start)") == ("start", ())
    assert parse_trainer("(move (ball) 1. -2.5 0 3 4)") == ("move", (("ball",), 1.0, -2.5, 0.0, 3.0, 4.0))
    assert parse_trainer('(move (player "R" 3) 0 0) trailing') == ("move", (("player", "R", 3.0), 0.0, 0.0))
    assert parse_trainer("(say (a) b)") == ("say", ("(a) b",))
    assert parse_trainer("(say --3. 3..)")[0] == "say"
    assert parse_trainer("(x --3. 3.. +4.)") == ("x", ("--3.", "3..", 4.0))
    for text in ("", "start", "(start", "()"):
        with pytest.raises(CommandError, match="one list in parentheses"):
            parse_trainer(text)
