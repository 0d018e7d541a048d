"""Every recorded run of the real server comes out the same."""

from pathlib import Path

import pytest
from paths import SHARED

from cprm_gym.simulator.conformance import replay_scenario

DATA = Path(__file__).parent / "data"
RECORDED = SHARED / "conformance"
HERE = sorted(DATA.rglob("*.jsonl.gz"))
MORE = sorted(path for path in RECORDED.rglob("*.jsonl.gz") if not (DATA / path.relative_to(RECORDED)).exists())

# Objects in a cycle whose outcome hangs on a draw that nobody recorded: two at exactly one place are separated at a random angle (a ball
# placed on the tackler after a foul, players moved onto each other), or players are put at random into their own half or round a region of
# keepaway.
LEFT_TO_CHANCE = {
    "collide_ball": 4,
    "collide_players": 5,
    "golden_2": 3,
    "keepaway_0": 40,
    "keepaway_turnover": 10,
    "move_bko_noref": 6,
    "move_bko_ref": 8,
    "penalty_0": 3,
    "penalty_b1": 3,
    "rules": 16,
}


def name_of(path: Path) -> str:
    return path.name.removesuffix(".jsonl.gz")


def check(path: Path) -> None:
    result = replay_scenario(path)
    assert result.ok, result.text()
    assert result.cycles > 0
    assert result.compared + len(result.checks) > 0
    if "noise" not in name_of(path):  # with noise, objects near goal posts are left out
        assert result.chance == LEFT_TO_CHANCE.get(name_of(path), 0), result.text()


@pytest.mark.parametrize("path", HERE, ids=name_of)
def test_recording_comes_out_as_recorded(path):
    check(path)


@pytest.mark.skipif(not RECORDED.exists(), reason="data of ../shared absent")
@pytest.mark.parametrize("path", MORE, ids=name_of)
def test_further_recording_comes_out_as_recorded(path):
    check(path)


def test_noise_free_physics_has_no_error_at_all():
    """Positions, velocities and energy are the server's to the last bit; angles lose one in the conversion to degrees."""
    for name in ("ball_roll", "kick", "dash_default", "collide_post", "hetero"):
        errors = replay_scenario(DATA / f"{name}.jsonl.gz").errors
        assert {errors[quantity] for quantity in ("x", "y", "vx", "vy", "stamina", "effort", "recovery", "capacity")} == {0.0}
        assert errors["body"] <= 1e-12
