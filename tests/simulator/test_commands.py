"""Commands: the numeric vectors recorded from server 19 (specification/simulator.md 9), validity and budget of each command."""

from __future__ import annotations

import numpy as np
import pytest
from simulator_worlds import D2R, QUIET, R2D, act, put, quiet_world, record_of, say_to

from cprm_gym.errors import CommandError
from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.player_types import PlayerType
from cprm_gym.simulator.simulator import no_commands
from cprm_gym.simulator.state import CommandKind, Count, PlayerBit, PlayMode

DASH, LEGS, TURN, KICK = CommandKind.DASH, CommandKind.DASH_LEGS, CommandKind.TURN, CommandKind.KICK
TACKLE, CATCH, MOVE, NONE = CommandKind.TACKLE, CommandKind.CATCH, CommandKind.MOVE, CommandKind.NONE
NAN = np.nan


def state(simulator, number):
    """(x, y, vx, vy) of an object of world 0."""
    return [*simulator.world["pos"][0, number], *simulator.world["vel"][0, number]]


def count(simulator, which, player=1):
    return int(simulator.world["counts"][0, player - 1, which])


# ---------------------------------------------------------------------------------------------- recorded vectors


@pytest.mark.parametrize(
    ("kind", "numbers", "expected"),
    [
        (DASH, (100,), (0.6, 0, 0.24, 0)),
        (DASH, (100, 90), (0, 0.24, 0, 0.096)),
        (DASH, (100, 135), (-0.233345, 0.233345, -0.0933381, 0.0933381)),
        (DASH, (100, 180), (-0.42, 0, -0.168, 0)),
        (DASH, (100, 44.6), (0.296985, 0.296985, 0.118794, 0.118794)),
        (LEGS, (100, 0, NAN, NAN), (0.3, 0, 0.12, 0)),
        (LEGS, (NAN, NAN, 100, 0), (0.3, 0, 0.12, 0)),
        (LEGS, (60, 0, 20, 0), (0.24, 0, 0.096, 0)),
        (LEGS, (100, 30, 100, -30), (0.415692, 0, 0.166277, 0)),
    ],
)
def test_a_dash_ends_where_the_server_recorded(kind, numbers, expected):
    simulator = quiet_world()
    act(simulator, 1, kind, *numbers)
    assert state(simulator, 1) == pytest.approx(expected, abs=1e-6)


def test_a_dash_costs_its_power_and_stamina_grows_in_the_same_step():
    simulator = quiet_world()
    act(simulator, 1, DASH, 100)
    assert simulator.world["stamina"][0, 0] == 7945.0


def test_a_dash_in_motion_is_capped_by_the_top_speed():
    simulator = quiet_world()
    put(simulator, 1, 0, 0, 0.42, 0)
    act(simulator, 1, DASH, 100)
    assert state(simulator, 1) == pytest.approx((1.02, 0, 0.408, 0))


@pytest.mark.parametrize(
    ("numbers", "degrees"), [((100, 0, NAN, NAN), 57.2958), ((NAN, NAN, 100, 0), 0), ((60, 0, 20, 0), 22.9183), ((100, 30, 100, -30), 0)]
)
def test_the_body_turns_only_when_the_left_leg_dashes(numbers, degrees):
    simulator = quiet_world()
    act(simulator, 1, LEGS, *numbers)
    assert simulator.world["body"][0, 0] * R2D == pytest.approx(degrees, abs=1e-4)


def test_an_exhausted_player_turns_left_when_he_dashes():
    simulator = quiet_world()
    simulator.world["stamina"][0, 0], simulator.world["effort"][0, 0] = 44.91, 0.995
    act(simulator, 1, DASH, 100)
    assert simulator.world["body"][0, 0] * R2D == pytest.approx(-1.413, abs=1e-3)


def test_a_turn_is_damped_by_the_present_speed():
    simulator = quiet_world()
    put(simulator, 1, 0, 0, 0.02, 0)
    act(simulator, 1, TURN, 90)
    assert simulator.world["body"][0, 0] * R2D == pytest.approx(90 / 1.1)


@pytest.mark.parametrize(
    ("ball", "numbers", "expected"),
    [
        ((0.8, 0), (100, 30), (2.7917, 1.14991, 1.8722, 1.08092)),
        ((0, 0.9), (80, -45), (1.05551, -0.155508, 0.992178, -0.992178)),
        ((0.5, 0.2, -0.94, 0), (100, 0), (2.03021, 0.2, 1.4384, 0)),
        ((0.8, 0), (-50, 0), (-0.367455, 0, 0.108092, 0)),
    ],
)
def test_a_kicked_ball_ends_where_the_server_recorded(ball, numbers, expected):
    simulator = quiet_world()
    put(simulator, 0, *ball)
    act(simulator, 1, KICK, *numbers)
    assert state(simulator, 0) == pytest.approx(expected, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize(
    ("ball", "angle", "expected"), [((1, 0), 0, (3.7, 0, 2.538, 0)), ((0.9, 0.3), 45, (2.25857, 1.65857, 1.27705, 1.27705))]
)
def test_a_tackled_ball_ends_where_the_server_recorded(ball, angle, expected):
    simulator = quiet_world()
    put(simulator, 0, *ball)
    simulator.world["forced_tackle"] = 1
    act(simulator, 1, TACKLE, angle)
    assert state(simulator, 0) == pytest.approx(expected, rel=1e-5)


def test_a_ball_behind_cannot_be_tackled():
    simulator = quiet_world()
    put(simulator, 0, -0.5, 0)
    simulator.world["forced_tackle"] = 1
    act(simulator, 1, TACKLE, 0)
    assert state(simulator, 0) == [-0.5, 0, 0, 0]
    assert simulator.world["bits_shown"][0, 0] & PlayerBit.TACKLE_FAULT


def test_a_catching_goalie_goes_to_the_ball_and_turns_to_it():
    simulator = quiet_world()
    put(simulator, 1, -45, 0, body=0)
    put(simulator, 0, -44.2, 0.1)
    act(simulator, 1, CATCH, 0)
    assert simulator.world["pos"][0, 1] == pytest.approx((-44.582, 0.0522466), rel=1e-5)
    assert simulator.world["body"][0, 0] * R2D == pytest.approx(7.12502, abs=1e-5)


def test_the_neck_turns_within_its_limits_once_per_cycle():
    simulator = quiet_world()
    for moment, neck in ((60, 60), (60, 90), (-400, -90)):
        act(simulator, 1, NONE, turn_neck=moment)
        assert simulator.world["neck"][0, 0] * R2D == pytest.approx(neck)
    simulator.command_phase(0, 1, record_of(NONE, turn_neck=10))
    simulator.command_phase(0, 1, record_of(NONE, turn_neck=30))
    simulator.advance()
    assert simulator.world["neck"][0, 0] * R2D == pytest.approx(-80)
    assert count(simulator, Count.TURN_NECK) == 4


# ---------------------------------------------------------------------------------------------- closed forms


def test_dashing_approaches_the_top_speed_as_a_geometric_series():
    simulator = quiet_world()
    for n in range(1, 40):
        act(simulator, 1, DASH, 100)
        x = sum(0.6 * (1 - 0.4**k) / 0.6 for k in range(1, n + 1))
        assert simulator.world["pos"][0, 1, 0] == pytest.approx(x, rel=1e-12)


@pytest.mark.parametrize("angle", range(-180, 181, 15))
def test_a_dash_is_weaker_to_the_side_and_backwards(angle):
    simulator = quiet_world()
    act(simulator, 1, DASH, 100, angle)
    side = 0.4 + 0.6 * (1 - abs(angle) / 90) if abs(angle) <= 90 else 0.7 - 0.3 * (1 - (abs(angle) - 90) / 90)
    assert np.hypot(*simulator.world["pos"][0, 1]) == pytest.approx(0.6 * side)


@pytest.mark.parametrize(("asked", "given"), [(44.5, 44), (45.5, 46), (-44.5, -44), (0.5, 0), (300, 180), (-999, -180)])
def test_the_direction_of_a_dash_is_clipped_and_rounded_half_to_even(asked, given):
    one, other = quiet_world(), quiet_world()
    act(one, 1, DASH, 100, asked)
    act(other, 1, DASH, 100, given)
    assert one.state_hash() == other.state_hash()


def test_kick_power_falls_with_angle_and_distance():
    for degrees in range(0, 181, 20):
        for gap in (0.0, 0.3, 0.69):
            simulator = quiet_world()
            reach = 0.385 + gap
            put(simulator, 1, 0, 0, body=-degrees)
            put(simulator, 0, reach, 0)
            act(simulator, 1, KICK, 100, degrees)
            strength = 2.7 * (1 - 0.25 * degrees / 180 - 0.25 * gap / 0.7)
            assert simulator.world["vel"][0, 0, 0] / 0.94 == pytest.approx(strength)


def test_two_kicks_add_up_to_the_acceleration_cap():
    simulator = quiet_world(left=2)
    put(simulator, 1, -0.4, 0)
    put(simulator, 2, -0.4, 0.65)
    put(simulator, 0, 0, 0.3)
    for number in (1, 2):
        say_to(simulator, number, KICK, 100, 0)
    simulator.step()
    assert np.hypot(*simulator.world["vel"][0, 0]) / 0.94 == pytest.approx(2.7)


# ---------------------------------------------------------------------------------------------- validity and budget


def test_only_the_first_body_command_of_a_cycle_counts():
    simulator = quiet_world()
    for command in (record_of(TURN, 30), record_of(TURN, 50), record_of(DASH, 100), record_of(KICK, 100)):
        simulator.command_phase(0, 1, command)
    simulator.advance()
    assert simulator.world["body"][0, 0] * R2D == pytest.approx(30)
    assert [count(simulator, c) for c in (Count.TURN, Count.DASH, Count.KICK)] == [1, 0, 0]


@pytest.mark.parametrize("first", [KICK, CATCH])
def test_the_leg_form_of_dash_ignores_a_kick_and_a_catch(first):
    simulator = quiet_world()
    simulator.command_phase(0, 1, record_of(first, 10, 0))
    simulator.command_phase(0, 1, record_of(LEGS, 100, 0, 100, 0))
    simulator.advance()
    assert count(simulator, Count.DASH) == 1
    assert simulator.world["pos"][0, 1, 0] == pytest.approx(0.6)


def test_each_leg_is_used_once():
    simulator = quiet_world()
    simulator.command_phase(0, 1, record_of(LEGS, 100, 0, NAN, NAN))
    simulator.command_phase(0, 1, record_of(LEGS, 20, 0, 100, 0))
    simulator.advance()
    assert simulator.world["pos"][0, 1, 0] == pytest.approx(0.6)
    assert count(simulator, Count.DASH) == 1


def test_a_tackle_freezes_the_body_for_ten_cycles_but_not_the_legs():
    simulator = quiet_world()
    act(simulator, 1, TACKLE, 0)
    for _ in range(9):
        act(simulator, 1, TURN, 10)
        assert count(simulator, Count.TURN) == 0
        assert simulator.world["bits_shown"][0, 0] & PlayerBit.TACKLE_FAULT
    act(simulator, 1, TURN, 10)
    assert count(simulator, Count.TURN) == 1
    act(simulator, 1, TACKLE, 0)
    act(simulator, 1, LEGS, 100, 0, 100, 0)
    assert count(simulator, Count.DASH) == 1


def test_a_successful_intentional_foul_does_not_freeze_the_tackler():
    simulator = quiet_world(right=1)
    put(simulator, 12, 1.5, 0)
    put(simulator, 0, 1, 0)
    simulator.world["forced_tackle"] = 1
    act(simulator, 1, TACKLE, 0, 1)
    assert simulator.world["tackle_cycles"][0, 0] == 0
    act(simulator, 1, TURN, 10)
    assert count(simulator, Count.TURN) == 1


@pytest.mark.parametrize(
    "mode", [PlayMode.before_kick_off, PlayMode.time_over, PlayMode.offside_l, PlayMode.goal_r, PlayMode.illegal_defense_l]
)
def test_kicks_have_no_effect_in_dead_modes(mode):
    simulator = quiet_world(mode=mode)
    put(simulator, 0, 0.6, 0)
    act(simulator, 1, KICK, 100, 0)
    assert state(simulator, 0) == [0.6, 0, 0, 0]
    assert simulator.world["bits_shown"][0, 0] & PlayerBit.KICK_FAULT
    assert count(simulator, Count.KICK) == 0


@pytest.mark.parametrize(("mode", "moves"), [(PlayMode.catch_fault_r, True), (PlayMode.free_kick_fault_r, False)])
def test_tackles_have_an_effect_in_catch_fault_modes_only(mode, moves):
    simulator = quiet_world(mode=mode)
    put(simulator, 0, 1, 0)
    simulator.world["forced_tackle"] = 1
    act(simulator, 1, TACKLE, 0)
    assert (simulator.world["pos"][0, 0, 0] > 1) == moves


def test_a_kick_out_of_reach_is_a_fault_that_uses_the_body():
    simulator = quiet_world()
    put(simulator, 0, 1.2, 0)
    simulator.command_phase(0, 1, record_of(KICK, 100, 0))
    simulator.command_phase(0, 1, record_of(TURN, 10))
    simulator.advance()
    assert simulator.world["bits_shown"][0, 0] & PlayerBit.KICK_FAULT
    assert count(simulator, Count.TURN) == 0


def test_the_edge_of_the_kickable_area_is_inside():
    simulator = quiet_world()
    put(simulator, 0, 1.085, 0)
    act(simulator, 1, KICK, 100, 0)
    assert count(simulator, Count.KICK) == 1


def test_a_move_before_kick_off_is_in_the_teams_own_frame():
    simulator = quiet_world(right=1, mode=PlayMode.before_kick_off)
    say_to(simulator, 1, MOVE, -10, 5)
    say_to(simulator, 12, MOVE, -10, 5)
    simulator.step()
    assert simulator.world["pos"][0, [1, 12]].tolist() == [[-10, 5], [10, -5]]
    assert count(simulator, Count.MOVE) == 1


def test_a_move_in_play_is_ignored_and_leaves_the_body_free():
    simulator = quiet_world()
    simulator.command_phase(0, 1, record_of(MOVE, -10, 5))
    simulator.command_phase(0, 1, record_of(TURN, 10))
    simulator.advance()
    assert simulator.world["pos"][0, 1].tolist() == [0, 0]
    assert [count(simulator, c) for c in (Count.MOVE, Count.TURN)] == [0, 1]


def test_a_goalie_with_the_ball_moves_twice_and_the_ball_comes_along():
    simulator = quiet_world(mode=PlayMode.free_kick_l)
    simulator.world["ball_catcher"] = 1
    for k, x in enumerate((-40.0, -41.0, -42.0)):
        act(simulator, 1, MOVE, x, 1)
        assert simulator.world["pos"][0, 1, 0] == (x if k < 2 else -41.0)
        assert simulator.world["pos"][0, 0] == pytest.approx(simulator.world["pos"][0, 1] + (0.385, 0))
    assert count(simulator, Count.MOVE) == 3


def test_a_catch_bans_catching_for_five_cycles():
    simulator = quiet_world()
    act(simulator, 1, CATCH, 0)
    assert simulator.world["catch_ban"][0, 0] == 4
    for expected in (3, 2, 1, 0):
        act(simulator, 1, CATCH, 0)
        assert simulator.world["bits_shown"][0, 0] & PlayerBit.CATCH_FAULT
        assert simulator.world["catch_ban"][0, 0] == expected
    put(simulator, 0, 0.5, 0)
    act(simulator, 1, CATCH, 0)
    assert count(simulator, Count.CATCH) == 1


def test_a_field_player_cannot_catch():
    simulator = quiet_world(left=2)
    put(simulator, 2, 0, 0)
    put(simulator, 1, -30, 0)
    put(simulator, 0, 0.6, 0)
    act(simulator, 2, CATCH, 0)
    assert simulator.world["pos"][0, 2].tolist() == [0, 0]
    assert simulator.world["catch_ban"][0, 1] == 0


def test_a_failed_catch_in_the_stretched_area_punches_the_ball_back():
    stretched = PlayerType(catchable_area_l_stretch=1.3, kick_rand=0.0)
    for forced, caught in ((1, True), (-1, False)):
        simulator = quiet_world(player_types=[stretched])
        put(simulator, 0, 1.4, 0, -1, 0.2)
        simulator.world["forced_catch"] = forced
        act(simulator, 1, CATCH, 0)
        assert (simulator.world["pos"][0, 1, 0] > 0.5) == caught
        assert (simulator.world["vel"][0, 0, 0] > 0) != caught
        assert simulator.world["counts"][0, 0, Count.CATCH] == 1


def test_view_width_quality_and_focus():
    simulator = quiet_world()
    simulator.world["focus_direction"][0, 0] = 50 * D2R
    act(simulator, 1, NONE, view_width=1, view_quality=1)
    assert simulator.world["view_width"][0, 0] == 1
    assert simulator.world["focus_direction"][0, 0] == 50 * D2R
    act(simulator, 1, NONE, view_width=1)
    assert simulator.world["focus_direction"][0, 0] == pytest.approx(30 * D2R)
    act(simulator, 1, NONE, view_width=3, view_quality=2)
    assert simulator.world["view_width"][0, 0] == 1
    act(simulator, 1, NONE, focus=(100.0, -200.0))
    assert simulator.world["focus_distance"][0, 0] == 40
    assert simulator.world["focus_direction"][0, 0] == pytest.approx(-30 * D2R)
    assert [count(simulator, c) for c in (Count.CHANGE_VIEW, Count.CHANGE_FOCUS)] == [2, 1]


def test_an_arm_points_at_a_place_for_twenty_cycles():
    simulator = quiet_world()
    simulator.world["neck"] = simulator.world["neck_staged"] = 30 * D2R
    act(simulator, 1, NONE, point=(10.0, 60.0))
    assert simulator.world["arm_target"][0, 0] == pytest.approx((0, 10), abs=1e-12)
    assert simulator.world["arm_timer"][0, 0] == 1
    act(simulator, 1, NONE, point=(5.0, 0.0))
    act(simulator, 1, NONE, point=(np.inf, np.inf))
    assert count(simulator, Count.ARM) == 1
    for _ in range(3):
        simulator.step()
    act(simulator, 1, NONE, point=(np.inf, np.inf))
    assert simulator.world["arm_timer"][0, 0] == 21
    assert count(simulator, Count.ARM) == 2


def test_attention_goes_to_players_who_are_there():
    simulator = quiet_world(left=3, right=2)
    for side, unum, target in ((1, 3, 3), (2, 2, 13), (2, 5, 13), (1, 1, 13), (3, 0, 0)):
        act(simulator, 1, NONE, attention_side=side, attention_unum=unum)
        assert simulator.world["attention"][0, 0] == target
    assert count(simulator, Count.ATTENTION) == 3


def test_attention_may_go_to_a_player_who_was_sent_off():
    simulator = quiet_world(left=1, right=2)
    simulator.world["enabled"][0, 12] = 0
    simulator.world["bits"][0, 12] |= PlayerBit.DISCARD
    act(simulator, 1, NONE, attention_side=2, attention_unum=2)
    assert simulator.world["attention"][0, 0] == 13


@pytest.mark.parametrize("bad", [NAN, np.inf, -np.inf])
@pytest.mark.parametrize("kind", [DASH, TURN, KICK, TACKLE, CATCH, MOVE])
def test_a_number_that_is_not_finite_voids_its_command(kind, bad):
    simulator = quiet_world()
    put(simulator, 0, 0.6, 0)
    act(simulator, 1, kind, bad, 0)
    assert not simulator.world["counts"].any()
    assert state(simulator, 1) == [0, 0, 0, 0]
    assert state(simulator, 0) == [0.6, 0, 0, 0]


@pytest.mark.parametrize(("asked", "given"), [((1e300, -1e300), (100, -180)), ((-1e300, 0), (-100, 0))])
def test_huge_numbers_are_clipped(asked, given):
    one, other = quiet_world(), quiet_world()
    for simulator, numbers in ((one, asked), (other, given)):
        put(simulator, 0, 0.6, 0)
        act(simulator, 1, KICK, *numbers)
    assert one.state_hash() == other.state_hash()


def test_old_clients_tackle_with_a_power():
    simulator = quiet_world(parameters=ServerParameters(max_back_tackle_power=50.0).without_noise())
    simulator.world["protocol"], simulator.world["forced_tackle"] = 11, 1
    put(simulator, 0, 1, 0)
    act(simulator, 1, TACKLE, -10)
    assert state(simulator, 0) == pytest.approx((0.73, 0, -0.2538, 0))


# ---------------------------------------------------------------------------------------------- wrong arguments


@pytest.mark.parametrize("wrong", [None, 3, "dash", no_commands(22), no_commands(2, 22), np.zeros((1, 22))])
def test_commands_of_a_wrong_kind_are_refused(wrong):
    if wrong is None:
        wrong = [[0] * 22]
    with pytest.raises(CommandError, match=r"`commands` takes an array of dtype COMMAND and shape \(1, 22\), got"):
        quiet_world().step(wrong)


@pytest.mark.parametrize(
    ("world", "player", "named"),
    [(1, 1, "`world`"), (-1, 1, "`world`"), (0, 0, "`player`"), (0, 23, "`player`"), (0, 1.0, "`player`"), (True, 1, "`world`")],
)
def test_a_world_or_player_that_does_not_exist_is_refused(world, player, named):
    with pytest.raises(CommandError, match=named):
        quiet_world().command_phase(world, player, record_of(TURN, 1))


def test_a_command_that_is_no_record_is_refused():
    with pytest.raises(CommandError, match="`command` takes one record"):
        quiet_world().command_phase(0, 1, "(turn 3)")


def test_the_helpers_are_quiet():
    assert QUIET.ball_rand == QUIET.player_rand == QUIET.kick_rand == 0.0
