"""The texts of commands: numbers and brackets of any size."""

import sys
import time

import pytest

from cprm_gym.errors import CommandError
from cprm_gym.simulator.protocol.commands import PlayerCommand, parse_commands, parse_trainer


@pytest.mark.parametrize(("sign", "value"), [("", -1.0), ("+", -1.0), ("-", 0.0)])
def test_numbers_of_any_length_are_cut_as_the_server_cuts_them(sign, value):
    """C's atoi on 64 bits saturates; the lower 32 bits are what is left."""
    parsed = parse_commands(f"(turn {sign}{'9' * 5000})")
    assert parsed == ((PlayerCommand("turn", (value,)),), None)
    assert parse_commands(f"(turn {sign}{'0' * 5000}7)").commands[0].args == (-7.0 if sign == "-" else 7.0,)


def test_deep_brackets_of_a_trainer_are_refused_in_linear_time():
    for text in ("(" * 200_000, "(move " + "(" * 200_000 + ")" * 200_000 + ")"):
        with pytest.raises(CommandError, match="up to 8 deep"):
            parse_trainer(text)
    start = time.process_time()
    assert len(parse_trainer("(look " + "a " * 200_000 + ")").args) == 200_000
    assert time.process_time() - start < 5.0


def test_a_real_number_too_large_is_the_largest_one_for_trainers_too():
    assert parse_trainer("(move (ball) 1e999 -1e999)").args[1:] == (sys.float_info.max, -sys.float_info.max)
    assert parse_commands("(kick 1e999 0)")[0][0].args[0] == sys.float_info.max


@pytest.mark.parametrize("text", ["(dash \u0661\u0660)", "(turn \uff11)", "(move 1 2.\u0665)"])
def test_digits_are_those_of_ascii(text):
    parsed = parse_commands(text)
    assert not parsed.commands
    assert parsed.error is not None
