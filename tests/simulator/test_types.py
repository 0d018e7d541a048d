"""Heterogeneous types: the server's own, digit for digit, from its seed."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import pytest
from paths import ROOT, SHARED

from cprm_gym.errors import ParameterError
from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.player_types import MAX_TYPES, PlayerParameters, PlayerType, TypeColumn, generate_types

RECORDINGS = ("hetero", "random/monkey_physics_0", "random/monkey_physics_1", "random/monkey_noise_0", "random/monkey_rules_1")


def recorded(name: str) -> Path:
    """Where a recording of a real server lies: beside the tests, or in ../shared."""
    for folder in (ROOT / "tests" / "conformance" / "data", SHARED / "conformance"):
        for path in (folder / f"{name}.jsonl.gz", folder / f"{Path(name).name}.jsonl.gz"):
            if path.exists():
                return path
    pytest.skip("data of ../shared absent")


@pytest.mark.parametrize("name", RECORDINGS)
def test_the_servers_types_come_from_its_seed_digit_for_digit(name):
    with gzip.open(recorded(name), "rt") as stream:
        header = json.loads(stream.readline())
    parameters = ServerParameters.from_mapping(header["server_param"])
    drawing = PlayerParameters.from_mapping(header["player_param"])
    told = [PlayerType.from_mapping(values) for values in header["player_type"].values()]
    assert generate_types(parameters, drawing) == tuple(told)


@pytest.mark.parametrize("seed", range(20))
def test_drawn_types_keep_the_default_ranges_and_couplings(seed):
    types = generate_types(ServerParameters(), PlayerParameters(), seed)
    assert len(types) == MAX_TYPES
    assert types[0] == PlayerType.default(ServerParameters()) == PlayerType()
    for kind in types[1:]:
        assert 0.3 <= kind.player_decay <= 0.5
        assert kind.inertia_moment == pytest.approx(5 + 25 * (kind.player_decay - 0.4))
        assert kind.stamina_inc_max == pytest.approx(45 - 6000 * (kind.dash_power_rate - 0.006))
        assert kind.kick_rand == pytest.approx(kind.kickable_margin - 0.6)
        assert kind.effort_max == pytest.approx(1 - 0.004 * (kind.extra_stamina - 50))
        assert kind.effort_min == pytest.approx(kind.effort_max - 0.4)
        assert 1.0 <= kind.catchable_area_l_stretch <= 1.3
        assert 0.75 <= kind.real_speed_max() <= 1.05
        assert kind.player_speed_max == 1.05
        assert kind.player_size == 0.3


def test_a_seed_in_the_parameters_is_used_when_none_is_given():
    assert generate_types(ServerParameters(), PlayerParameters(random_seed=5)) == generate_types(ServerParameters(), PlayerParameters(), 5)


def test_types_without_a_seed_are_refused():
    with pytest.raises(ParameterError, match="need a seed >= 0"):
        generate_types(ServerParameters(), PlayerParameters())


def test_impossible_deltas_give_copies_of_the_default_type():
    impossible = PlayerParameters(player_decay_delta_min=-0.39, player_decay_delta_max=-0.38, player_types=2)
    assert generate_types(ServerParameters(), impossible, 1) == (PlayerType(), PlayerType())


def test_old_deltas_change_size_and_speed():
    drawing = PlayerParameters(
        dash_power_rate_delta_min=-0.0005, dash_power_rate_delta_max=0.0005, player_speed_max_delta_max=0.2, player_types=6
    )
    types = generate_types(ServerParameters(), drawing, 3)
    assert len({kind.player_size for kind in types[1:]}) == 5
    assert all(0.25 <= kind.player_size <= 0.35 for kind in types)
    assert all(1.05 <= kind.player_speed_max <= 1.25 for kind in types)


def test_columns_of_packed_types_are_the_fields_in_order():
    assert [column.name.lower() for column in TypeColumn][:-1] == list(PlayerType.names())
