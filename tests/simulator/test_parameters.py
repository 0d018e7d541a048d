"""Parameters: complete, documented, checked, and the same text as the server's."""

from __future__ import annotations

import dataclasses
import math
import re

import numpy as np
import pytest
from paths import ROOT

from cprm_gym.errors import ParameterError
from cprm_gym.simulator.packing import PARAMETERS, pack
from cprm_gym.simulator.parameters import Rules, ServerParameters
from cprm_gym.simulator.player_types import PlayerParameters, PlayerType, TypeColumn

TABLES = ROOT / "docs" / "specification" / "parameters.md"
SETS = (ServerParameters, PlayerParameters, PlayerType)


def test_there_are_202_server_parameters_and_29_player_parameters():
    assert len(ServerParameters.names()) == 202
    assert len(PlayerParameters.names()) == 29


def test_every_default_is_that_of_the_table():
    rows = re.findall(r"^\| `(\w+)` \| (real|int|bool|string) \| (.*?) \| (?:.*?) \| (.*?) \|", TABLES.read_text(), re.M)
    section = {name: (kind, default) for name, kind, default, _ in rows if name in ServerParameters.names()}
    assert len(section) == 202
    for field in dataclasses.fields(ServerParameters):
        kind, default = section[field.name]
        expected = {"real": float, "int": int, "bool": lambda t: t == "true", "string": lambda t: t.strip('`"')}[kind](default)
        assert field.default == expected, field.name


@pytest.mark.parametrize("parameters", SETS)
def test_every_parameter_is_documented(parameters):
    for name in parameters.names():
        entry = parameters.describe(name)
        assert entry["meaning"], name
        assert entry["allowed"], name
        assert f"\n{name} : " in parameters.__doc__


def test_an_unknown_name_is_refused_with_the_nearest_known_one():
    with pytest.raises(ParameterError, match=r"unknown server parameter 'bal_decay'\. Did you mean 'ball_decay'\?"):
        ServerParameters(bal_decay=0.9)
    with pytest.raises(ParameterError, match=r"unknown player parameter 'pt_maxx'\. Did you mean 'pt_max'\?"):
        PlayerParameters(pt_maxx=1)
    with pytest.raises(ParameterError, match="Did you mean 'player_decay'"):
        dataclasses.replace(PlayerType(), player_decai=0.4)


@pytest.mark.parametrize(
    ("name", "value", "allowed"),
    [
        ("ball_decay", 1.5, "a finite number >= 0 and <= 1"),
        ("ball_decay", math.nan, "a finite number"),
        ("player_size", 0.0, "a finite number > 0"),
        ("player_decay", 1.0, "a finite number >= 0 and < 1"),
        ("kick_rand", math.inf, "a finite number"),
        ("kick_rand", "0.1", "a finite number"),
        ("kick_rand", True, "a finite number"),
        ("half_time", 300.0, "a whole number"),
        ("drop_ball_time", 2**40, "a whole number"),
        ("use_offside", 1, "True or False"),
        ("foul_detect_probability", -0.1, "a finite number >= 0 and <= 1"),
        ("team_l_start", 'a"b', "a string without"),
        ("wind_force", 10**400, "a finite number"),
    ],
)
def test_a_value_that_is_not_allowed_is_named_with_what_is(name, value, allowed):
    with pytest.raises(ParameterError, match=f"server parameter '{name}': takes {re.escape(allowed)}"):
        ServerParameters(**{name: value})


def test_all_wrong_values_are_reported_at_once():
    with pytest.raises(ParameterError, match=r"'ball_decay'.*'ball_rand'"):
        ServerParameters(ball_decay=2, ball_rand=-1)


def test_parameters_are_frozen_and_numpy_numbers_become_plain():
    parameters = ServerParameters(ball_decay=np.float32(0.5), half_time=np.int64(10))
    assert type(parameters.ball_decay) is float
    assert type(parameters.half_time) is int
    with pytest.raises(dataclasses.FrozenInstanceError):
        parameters.ball_decay = 0.9


@pytest.mark.parametrize("parameters", [ServerParameters(), ServerParameters(ball_decay=0.9, team_l_start="run it", coach=True)])
def test_server_text_is_read_back(parameters):
    message = parameters.to_text()
    names = re.findall(r"\((\w+) ", message[len("(server_param ") :])
    assert names == sorted(ServerParameters.names())
    assert ServerParameters.from_text(message) == parameters


def test_server_text_has_the_servers_number_format():
    message = ServerParameters(stamina_max=1e6, ball_decay=0.1 + 0.2, wind_dir=-0.0).to_text()
    for item in ("(stamina_max 1e+06)", "(ball_decay 0.3)", "(wind_dir -0)", "(use_offside 1)", '(team_l_start "")', "(half_time 300)"):
        assert item in message


def test_clients_are_told_what_their_protocol_knows():
    parameters = ServerParameters()
    assert "dist_noise_rate" not in parameters.to_text(18)
    assert "(dist_noise_rate 0.0125)" in parameters.to_text(19)
    assert "coach_msg_file" not in parameters.to_text(19)
    assert "coach_msg_file" in parameters.to_text()
    assert "unum_far_length" not in PlayerType().to_text(0, 17)
    assert PlayerType().to_text(0, 19).startswith("(player_type (id 0)(player_speed_max 1.05)(stamina_inc_max 45)(player_decay 0.4)")
    assert PlayerType().to_text(0, 19).endswith("(land_focus_dist_noise_rate 0.00125))")


def test_the_positional_texts_of_protocol_7_are_refused():
    for write in (ServerParameters().to_text, PlayerParameters().to_text, lambda version: PlayerType().to_text(1, version)):
        with pytest.raises(ParameterError, match="protocol 8 and newer"):
            write(7)


def test_player_text_is_read_back():
    parameters = PlayerParameters(player_types=7, random_seed=12)
    assert PlayerParameters.from_text(parameters.to_text()) == parameters
    kind = PlayerType(player_decay=0.45, kick_rand=0.05)
    number, back = PlayerType.from_text(kind.to_text(3))
    assert number == 3
    assert back.player_decay == kind.player_decay
    assert back.kick_rand == kind.kick_rand


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        ("(server_param (ball_decay))", "not a"),
        ("(player_param (pt_max 1))", "not a"),
        ("(server_param (ball_decay x))", "takes a finite number"),
        ("(server_param (half_time 1.5))", "takes a whole number"),
        ("(server_param (bal_decay 1))", "Did you mean 'ball_decay'"),
    ],
)
def test_a_malformed_text_is_refused(message, reason):
    with pytest.raises(ParameterError, match=reason):
        ServerParameters.from_text(message)


def test_numbers_of_json_logs_are_read():
    parameters = ServerParameters.from_mapping({"use_offside": 0, "coach": True, "half_time": 10, "ball_decay": 1, "team_l_start": '""'})
    assert not parameters.use_offside
    assert parameters.coach
    assert parameters.ball_decay == 1.0
    assert parameters.team_l_start == ""


def test_packed_parameters_hold_every_number_under_its_name():
    parameters = ServerParameters(ball_size=0.1, half_time=20, extra_half_time=7, nr_extra_halfs=-3, simulator_step=50)
    packed = pack(parameters, PlayerParameters(), [PlayerType(), PlayerType(player_decay=0.45)])
    assert packed.dtype == PARAMETERS
    for field in dataclasses.fields(ServerParameters):
        if field.metadata["kind"] != "text":
            assert packed[field.name][0] == getattr(parameters, field.name)
    assert packed["out_x"][0] == 52.6
    assert packed["half_cycles"][0] == 400
    assert packed["normal_cycles"][0] == 800
    assert packed["total_cycles"][0] == 800
    assert packed["types"][0, 1, TypeColumn.PLAYER_DECAY] == 0.45
    assert packed["types"][0, 17, TypeColumn.PLAYER_DECAY] == 0.4
    assert packed["types"][0, 0, TypeColumn.KICKABLE_SQUARED] == pytest.approx(1.1**2)


def test_team_factors_count_only_when_switched_on():
    factors = {"prand_factor_l": 2.0, "kick_rand_factor_r": 3.0}
    off = pack(ServerParameters(**factors), PlayerParameters(), [PlayerType()])
    on = pack(ServerParameters(team_actuator_noise=True, **factors), PlayerParameters(), [PlayerType()])
    assert off["player_rand_of"][0].tolist() == [0.1, 0.1]
    assert on["player_rand_of"][0].tolist() == [0.2, 0.1]
    assert on["kick_rand_factor_of"][0].tolist() == [1.0, 3.0]


def test_the_servers_coach_mode_has_no_referee():
    types = [PlayerType()]
    assert pack(ServerParameters(coach=True), PlayerParameters(), types)["rules"][0] == Rules.NONE
    assert pack(ServerParameters(coach=True, coach_w_referee=True), PlayerParameters(), types)["rules"][0] == Rules.ALL


@pytest.mark.parametrize("number", [0, 19])
def test_packing_refuses_a_number_of_types_it_has_no_room_for(number):
    with pytest.raises(ParameterError, match=f"1 to 18 player types, got {number}"):
        pack(ServerParameters(), PlayerParameters(), [PlayerType()] * number)


@pytest.mark.parametrize("log", ["v4.rcg", "v5.rcg", "v6.rcg"])
def test_the_parameters_in_a_real_log_are_read_and_written_byte_for_byte(log):
    lines = (ROOT / "tests" / "conformance" / "data" / "formats" / log).read_text("latin-1").splitlines()
    server, player = (next(line for line in lines if line.startswith(f"({head}_param ")) for head in ("server", "player"))
    types = [line for line in lines if line.startswith("(player_type ")]
    assert ServerParameters.from_text(server).to_text() == server
    assert PlayerParameters.from_text(player).to_text() == player
    assert len(types) == 18
    for number, line in enumerate(types):
        id, kind = PlayerType.from_text(line)
        assert id == number
        assert kind.to_text(id, digits=17) == line  # this server was patched to print its types exactly


@pytest.mark.parametrize("value", [10**5000, "x" * 10**6, [[1]] * 10**5], ids=["number", "text", "list"])
def test_values_of_any_size_are_refused_in_a_short_message(value):
    with pytest.raises(ParameterError) as caught:
        ServerParameters(half_time=value)
    assert len(str(caught.value)) < 200


@pytest.mark.parametrize("item", ["(goal_width 1_4)", "(goal_width \u0661\u0664)", "(half_time 3_00)"])
def test_numbers_that_only_python_knows_are_refused(item):
    with pytest.raises(ParameterError, match="got the text"):
        ServerParameters.from_text(f"(server_param {item})")
