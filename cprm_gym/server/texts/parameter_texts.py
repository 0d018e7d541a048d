"""The parameters as every client is told them when it connects (specification/protocol.md 1.1, 5.1)."""

from __future__ import annotations

from ...simulator.gamelog.binary_writer import period
from ...simulator.parameters import ServerParameters
from ...simulator.player_types import PlayerParameters, PlayerType

_SERVER_7 = """
goal_width inertia_moment player_size player_decay player_rand player_weight player_speed_max player_accel_max stamina_max stamina_inc_max
recover_init recover_dec_thr recover_min recover_dec effort_init effort_dec_thr effort_min effort_dec effort_inc_thr effort_inc kick_rand
team_actuator_noise prand_factor_l prand_factor_r kick_rand_factor_l kick_rand_factor_r ball_size ball_decay ball_rand ball_weight
ball_speed_max ball_accel_max dash_power_rate kick_power_rate kickable_margin control_radius control_radius_width maxpower minpower
maxmoment minmoment maxneckmoment minneckmoment maxneckang minneckang visible_angle visible_distance wind_dir wind_force wind_ang
wind_rand kickable_area catchable_area_l catchable_area_w catch_probability goalie_max_moves ckick_margin offside_active_area_size
wind_none wind_random say_coach_cnt_max say_coach_msg_size clang_win_size clang_define_win clang_meta_win clang_advice_win clang_info_win
clang_mess_delay clang_mess_per_cycle half_cycles simulator_step send_step recv_step sense_body_step lcm_step say_msg_size hear_max
hear_inc hear_decay catch_ban_cycle slow_down_factor use_offside forbid_kick_off_offside offside_kick_margin audio_cut_dist quantize_step
quantize_step_l -1 -1 -1 -1 -1 -1 -1 coach coach_w_referee old_coach_hear send_vi_step start_goal_l start_goal_r fullstate_l fullstate_r
drop_ball_time
"""
_PLAYER_7 = """
player_types subs_max pt_max player_speed_max_delta_min player_speed_max_delta_max stamina_inc_max_delta_factor player_decay_delta_min
player_decay_delta_max inertia_moment_delta_factor dash_power_rate_delta_min dash_power_rate_delta_max player_size_delta_factor
kickable_margin_delta_min kickable_margin_delta_max kick_rand_delta_factor extra_stamina_delta_min extra_stamina_delta_max
effort_max_delta_factor effort_min_delta_factor
"""
_TYPE_7 = """
player_speed_max stamina_inc_max player_decay inertia_moment dash_power_rate player_size kickable_margin kick_rand extra_stamina
effort_max effort_min
"""


def parameter_texts(server: ServerParameters, player: PlayerParameters, types: tuple[PlayerType, ...], version: int) -> tuple[str, ...]:
    """server_param, player_param and one player_type message per type, as a client of `version` reads them.

    Parameters
    ----------
    server, player : parameters
    types : tuple of PlayerType
    version : int
        Of the client's protocol; below 7 there are no such messages, 7 has values without names.
    """
    if version < 7:
        return ()
    if version > 7:
        return server.to_text(version), player.to_text(version), *(kind.to_text(number, version) for number, kind in enumerate(types))
    derived = {
        "control_radius_width": server.control_radius - server.player_size,
        "kickable_area": server.kickable_margin + server.ball_size + server.player_size,
        "half_cycles": server.half_cycles,
        "lcm_step": period(server),
    }
    return (
        _values("server_param", _SERVER_7, server, derived),
        _values("player_param", _PLAYER_7, player, {}),
        *(_values(f"player_type {number}", _TYPE_7, kind, {}) for number, kind in enumerate(types)),
    )


def _values(head: str, names: str, source: object, derived: dict[str, float]) -> str:
    words = [name if name == "-1" else f"{float(derived[name] if name in derived else getattr(source, name)):g}" for name in names.split()]
    return f"({head} {' '.join(words)})"
