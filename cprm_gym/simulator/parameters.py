"""All parameters of the server and the masks of the referee's modules.

Names and defaults are those of server 19; ``describe`` tells the unit, meaning and range of each.
"""

from __future__ import annotations

import dataclasses
from enum import IntFlag

from .parameter_fields import ParameterSet, flag, integer, items_of, parameter_set, real, text


class Rules(IntFlag):
    """The referee's modules; a task switches on what it needs (specification/simulator.md 7). ``NONE`` is the server's ``coach`` mode."""

    NONE = 0
    TIME = 1
    BALL_STUCK = 2
    OFFSIDE = 4
    FREE_KICK = 8
    TOUCH = 16
    CATCH = 32
    FOUL = 64
    ILLEGAL_DEFENSE = 128
    KEEPAWAY = 256
    PENALTY = 512
    ALL = 1023


@parameter_set("server parameter")
@dataclasses.dataclass(frozen=True, kw_only=True)
class ServerParameters(ParameterSet):
    """The ``server::`` parameters."""

    # --- ball
    ball_size: float = real(0.085, "m", "ball radius", above=0)
    ball_decay: float = real(0.94, "", "velocity multiplier per cycle", low=0, high=1)
    ball_rand: float = real(0.05, "", "motion-noise factor (specification/simulator.md 3.2)", low=0)
    ball_weight: float = real(0.2, "kg", "only enters the wind formula", above=0)
    ball_speed_max: float = real(3.0, "m/cycle", "speed cap applied after adding the acceleration", above=0)
    ball_accel_max: float = real(2.7, "m/cycle^2", "cap on the summed acceleration of one cycle", above=0)

    # --- default player (type 0) body, motion
    player_size: float = real(0.3, "m", "body radius", above=0)
    player_decay: float = real(0.4, "", "velocity multiplier per cycle", low=0, below=1)
    player_rand: float = real(0.1, "", "motion noise and turn noise and bipedal-rotation noise factor", low=0)
    player_weight: float = real(60.0, "kg", "only enters the wind formula", above=0)
    player_speed_max: float = real(1.05, "m/cycle", "speed cap (per type; all types keep this value with default deltas)", above=0)
    player_accel_max: float = real(1.0, "m/cycle^2", "cap on summed acceleration; not heterogeneous", low=0)
    player_speed_max_min: float = real(0.75, "m/cycle", "lower acceptance bound for a generated type's attainable speed", low=0, since=12)
    inertia_moment: float = real(5.0, "", "turn damping", low=0)
    dash_power_rate: float = real(0.006, "", "power to acceleration", low=0)
    min_dash_power: float = real(0.0, "power", "lower clamp of dash power; -100 before server 17", since=13)
    max_dash_power: float = real(100.0, "power", "upper clamp of dash power", above=0, since=13)
    min_dash_angle: float = real(-180.0, "deg", "lower clamp of dash direction", low=-360, high=0, since=13)
    max_dash_angle: float = real(180.0, "deg", "upper clamp of dash direction", low=0, high=360, since=13)
    dash_angle_step: float = real(
        1.0, "deg", "dash direction is rounded (half-even) to a multiple; <1e-10 = continuous", low=0, high=360, since=13
    )
    side_dash_rate: float = real(0.4, "", "efficiency of dashes at ±90°", low=0, since=13)
    back_dash_rate: float = real(0.7, "", "efficiency of dashes at 180°; 0.6 before server 17", low=0, since=13)
    slowness_on_top_for_left_team: float = real(
        1.0, "", "left team's handicap at y<0: dash acceleration divided by it, caps multiplied by it", above=0, since=8
    )
    slowness_on_top_for_right_team: float = real(1.0, "", "the same for the right team", above=0, since=8)

    # --- stamina
    stamina_max: float = real(8000.0, "stamina", "initial and maximal stamina", above=0)
    stamina_inc_max: float = real(45.0, "stamina/cycle", "recovery per cycle at recovery=1", low=0)
    stamina_capacity: float = real(130600.0, "stamina", "total recoverable amount; negative = unlimited", since=13)
    extra_stamina: float = real(50.0, "stamina", "reserve usable by a dash below zero", low=0, since=12)
    recover_init: float = real(1.0, "", "nominal initial recovery (reset actually writes 1.0)", low=0, since=9)
    recover_dec_thr: float = real(0.3, "times stamina_max", "recovery decreases at or below this level", low=0)
    recover_dec: float = real(0.002, "1/cycle", "decrement of recovery", low=0)
    recover_min: float = real(0.5, "", "floor of recovery", low=0)
    effort_init: float = real(1.0, "", "initial effort and base of effort_max", low=0)
    effort_dec_thr: float = real(0.3, "times stamina_max", "effort decreases at or below", low=0)
    effort_dec: float = real(0.005, "1/cycle", "decrement of effort", low=0)
    effort_min: float = real(0.6, "", "base of the floor", low=0)
    effort_inc_thr: float = real(0.6, "times stamina_max", "effort increases at or above", low=0)
    effort_inc: float = real(0.01, "1/cycle", "increment of effort", low=0)

    # --- kick, tackle, foul, catch
    kick_power_rate: float = real(0.027, "", "kick power to acceleration", low=0)
    kick_rand: float = real(0.1, "", "kick noise base", low=0)
    kickable_margin: float = real(0.7, "m", "kickable ring width", above=0)
    control_radius: float = real(2.0, "m", "unused by the simulation", low=0)
    minpower: float = real(-100.0, "power", "kick power lower clamp (negative kicks allowed)")
    maxpower: float = real(100.0, "power", "kick power upper clamp", above=0)
    minmoment: float = real(-180.0, "deg", "lower clamp of turn moment, kick dir, tackle angle", low=-360, high=0)
    maxmoment: float = real(180.0, "deg", "upper clamp of turn moment, kick direction, tackle angle", low=0, high=360)
    minneckmoment: float = real(-180.0, "deg", "turn_neck moment clamp", low=-360, high=0)
    maxneckmoment: float = real(180.0, "deg", "turn_neck moment clamp", low=0, high=360)
    minneckang: float = real(-90.0, "deg", "neck angle clamp", low=-360, high=0)
    maxneckang: float = real(90.0, "deg", "neck angle clamp", low=0, high=360)
    tackle_dist: float = real(2.0, "m", "tackle reach when ball is in front (x>0)", low=0, since=8)
    tackle_back_dist: float = real(0.0, "m", "tackle reach when ball is not in front (0 = impossible)", since=8)
    tackle_width: float = real(1.25, "m", "lateral tackle reach", above=0, since=8)
    tackle_exponent: float = real(6.0, "", "failure exponent", above=0, since=8)
    foul_exponent: float = real(10.0, "", "failure exponent for an effective intentional foul", above=0, since=14)
    tackle_cycles: int = integer(10, "cycles", "freeze after any tackle", low=0, since=8)
    foul_cycles: int = integer(5, "cycles", "freeze of the victim of a successful intentional foul", low=0, since=14)
    tackle_power_rate: float = real(0.027, "", "tackle power to acceleration", low=0, since=8)
    max_tackle_power: float = real(100.0, "power", "power for a 0° tackle", low=0, since=12)
    max_back_tackle_power: float = real(0.0, "power", "power for a 180° tackle", since=12)
    tackle_rand_factor: float = real(2.0, "", "tackle noise = kick_rand times this", low=0, since=14)
    foul_detect_probability: float = real(0.5, "prob", "default type's detection probability", low=0, high=1, since=14)
    red_card_probability: float = real(
        0.0, "prob", "probability that a detected foul draws a card (specification/simulator.md 7.10)", low=0, high=1, since=15
    )
    catchable_area_l: float = real(1.2, "m", "catch rectangle length", above=0)
    catchable_area_w: float = real(1.0, "m", "catch rectangle width", above=0)
    catch_probability: float = real(1.0, "prob", "success probability in the reliable part", low=0, high=1)
    catch_ban_cycle: int = integer(5, "cycles", "ban after a catch attempt", low=0)
    min_catch_angle: float = real(-90.0, "deg", "clamp of catch direction", low=-360, high=0, since=17)
    max_catch_angle: float = real(90.0, "deg", "clamp of catch direction", low=0, high=360, since=17)
    goalie_max_moves: int = integer(2, "count", "moves allowed after a catch; <0 unlimited")

    # --- actuator handicap per team
    team_actuator_noise: bool = flag(False, "enable the four factors below")
    prand_factor_l: float = real(1.0, "", "times player_rand, left team", low=0)
    prand_factor_r: float = real(1.0, "", "times player_rand, right team", low=0)
    kick_rand_factor_l: float = real(1.0, "", "times kick_rand, left", low=0)
    kick_rand_factor_r: float = real(1.0, "", "times kick_rand, right", low=0)

    # --- wind
    wind_none: bool = flag(False, "force no wind")
    wind_random: bool = flag(False, "draw the wind at start")
    wind_force: float = real(0.0, "", "length of wind vector")
    wind_dir: float = real(0.0, "deg", "direction of wind vector")
    wind_rand: float = real(0.0, "", "per-axis uniform perturbation; wind has no effect unless > 0", low=0)
    wind_ang: float = real(0.0, "", "unused")

    # --- vision
    visible_angle: float = real(90.0, "deg", "basic (async normal) view cone", low=0, high=360)
    visible_distance: float = real(3.0, "m", "feel radius outside the cone", low=0)
    quantize_step: float = real(0.1, "ln m", "log-distance quantum, movable objects", low=0)
    quantize_step_l: float = real(0.01, "ln m", "log-distance quantum, landmarks and lines", low=0)
    dist_noise_rate: float = real(0.0125, "", "gaussian model: sigma per metre of distance, movables", low=0, since=19)
    focus_dist_noise_rate: float = real(0.0125, "", "sigma per metre of distance from focus point, movables", low=0, since=19)
    land_dist_noise_rate: float = real(0.00125, "", "the same for landmarks", low=0, since=19)
    land_focus_dist_noise_rate: float = real(0.00125, "", "the same for landmarks", low=0, since=19)

    # --- audio, pointing, coach talk
    audio_cut_dist: float = real(50.0, "m", "hearing range", low=0)
    hear_max: int = integer(1, "", "hear capacity cap (per speaking team)", low=0)
    hear_inc: int = integer(1, "1/cycle", "capacity refill", low=0)
    hear_decay: int = integer(1, "", "capacity cost of one full message", low=0)
    say_msg_size: int = integer(10, "chars", "longer player messages are dropped", low=0)
    point_to_ban: int = integer(5, "cycles", "minimum time between arm commands", low=0, since=8)
    point_to_duration: int = integer(20, "cycles", "arm stays up", low=0, since=8)
    say_coach_cnt_max: int = integer(128, "count", "freeform messages per normal game length", low=0)
    say_coach_msg_size: int = integer(128, "chars", "freeform length limit", low=0)
    freeform_wait_period: int = integer(600, "cycles", "freeform window period in play_on", low=0, since=8)
    freeform_send_period: int = integer(20, "cycles", "window length", low=0, since=8)
    clang_win_size: int = integer(300, "cycles", "length of the CLang quota window", low=0)
    clang_define_win: int = integer(1, "count", "CLang messages of this kind per window", low=0)
    clang_meta_win: int = integer(1, "count", "CLang messages of this kind per window", low=0)
    clang_advice_win: int = integer(1, "count", "CLang messages of this kind per window", low=0)
    clang_info_win: int = integer(1, "count", "CLang messages of this kind per window", low=0)
    clang_del_win: int = integer(1, "count", "CLang messages of this kind per window", low=0, since=8)
    clang_rule_win: int = integer(1, "count", "CLang messages of this kind per window", low=0, since=8)
    clang_mess_delay: int = integer(50, "cycles", "delay in play_on", low=0)
    clang_mess_per_cycle: int = integer(
        1, "count", "0 disables delivery, any positive value delivers all due messages (source quirk)", low=0
    )
    coach_msg_file: str = text("", "text pushed to online coaches v11+ as (include …); not in server_param of players", since=0)

    # --- time, halves, start-up
    half_time: int = integer(300, "s", "length of a half, 3000 cycles; negative = endless")
    extra_half_time: int = integer(100, "s", "length of a half of extra time, 1000 cycles", since=13)
    nr_normal_halfs: int = integer(2, "count", "halves of normal time; negative counts as 0", since=9)
    nr_extra_halfs: int = integer(2, "count", "halves of extra time; negative counts as 0", since=9)
    golden_goal: bool = flag(False, "end extra time at first goal", since=14)
    drop_ball_time: int = integer(100, "cycles", "time-out of set plays and of a stuck ball")
    ball_stuck_area: float = real(3.0, "m", "stuck radius; ≤0 disables", since=11)
    start_goal_l: int = integer(0, "goals", "initial score of the left team")
    start_goal_r: int = integer(0, "goals", "initial score of the right team")
    auto_mode: bool = flag(False, "automatic kick-off / exit", since=9)
    kick_off_wait: int = integer(100, "cycles", "auto: wait once 22 players are connected or time>0", low=0, since=9)
    connect_wait: int = integer(300, "cycles", "auto: max wait for connections", low=0, since=9)
    game_over_wait: int = integer(100, "cycles", "auto: wait before exit", low=0, since=9)
    team_l_start: str = text("", "shell command, launched by the server; ignored here", since=9)
    team_r_start: str = text("", "the same for the right team; ignored here", since=9)
    fixed_teamname_l: str = text("", "name shown to the opponents instead of the real left name", since=16)
    fixed_teamname_r: str = text("", "the same for the right", since=16)

    # --- referee
    use_offside: bool = flag(True, "the offside rule")
    offside_active_area_size: float = real(2.5, "m", "radius for failed kick/tackle near ball offside", low=0)
    offside_kick_margin: float = real(9.15, "m", "shift applied when pushing offside team back")
    forbid_kick_off_offside: bool = flag(True, "players forced into own half before/at kick-off")
    ckick_margin: float = real(1.0, "m", "corner spot inset", low=0)
    goal_width: float = real(14.02, "m", "width of the goal mouth between the posts' inner edges", above=0)
    free_kick_faults: bool = flag(True, "double-touch rule", since=8)
    back_passes: bool = flag(True, "back-pass rule", since=8)
    proper_goal_kicks: bool = flag(False, "goal kick must leave the area untouched", since=8)
    stopped_ball_vel: float = real(0.01, "m/cycle", "used only with proper_goal_kicks", low=0, since=8)
    max_goal_kicks: int = integer(3, "count", "used only with proper_goal_kicks", since=8)
    illegal_defense_number: int = integer(0, "players", "players inside the zone that make an illegal defence; 0 = rule off", since=16)
    illegal_defense_duration: int = integer(20, "cycles", "how long they must be inside", low=0, since=16)
    illegal_defense_dist_x: float = real(16.5, "m", "zone depth", low=0, since=16)
    illegal_defense_width: float = real(40.32, "m", "zone width", low=0, since=16)

    # --- penalty shoot-out
    penalty_shoot_outs: bool = flag(True, "decide a level match by penalties", since=9)
    pen_before_setup_wait: int = integer(10, "cycles", "length of miss/score modes", low=0, since=9)
    pen_setup_wait: int = integer(70, "cycles", "setup timer", low=0, since=9)
    pen_ready_wait: int = integer(10, "cycles", "ready timer", low=0, since=9)
    pen_taken_wait: int = integer(150, "cycles", "taken timer", low=0, since=9)
    pen_nr_kicks: int = integer(5, "count", "regular kicks per team", low=0, since=9)
    pen_max_extra_kicks: int = integer(5, "count", "sudden-death kicks per team", low=0, since=9)
    pen_dist_x: float = real(42.5, "m", "ball distance from goal line", since=9)
    pen_random_winner: bool = flag(False, "coin toss on draw", since=9)
    pen_max_goalie_dist_x: float = real(14.0, "m", "goalie must stay within before the kick", low=0, since=9)
    pen_allow_mult_kicks: bool = flag(True, "taker may dribble", since=9)
    pen_coach_moves_players: bool = flag(True, "server repositions offenders", since=9)

    # --- ports, timing (ms)
    port: int = integer(6000, "udp", "players and monitors", low=1, high=65535, since=8)
    coach_port: int = integer(6001, "udp", "trainer", low=1, high=65535, since=8)
    olcoach_port: int = integer(6002, "udp", "online coaches", low=1, high=65535, since=8)
    simulator_step: int = integer(100, "ms", "cycle length", above=0)
    sense_body_step: int = integer(100, "ms", "period of sense_body", above=0)
    send_step: int = integer(150, "ms", "async see base period (sub-tick = 1/4)", above=0)
    send_vi_step: int = integer(100, "ms", "coach see_global period", above=0)
    recv_step: int = integer(10, "ms", "command polling period", above=0)
    synch_mode: bool = flag(False, "think/done lock-step", since=8)
    synch_offset: int = integer(60, "ms", "think offset inside the cycle", low=0, since=8)
    synch_micro_sleep: int = integer(1, "µs", "poll sleep while waiting for done", low=0, since=8)
    synch_see_offset: int = integer(0, "ms", "offset of synchronous see after the step", low=0, since=12)
    slow_down_factor: int = integer(1, "", "stretches all step times", above=0)

    # --- modes, trainer
    coach: bool = flag(False, "trainer allowed, referee disabled")
    coach_w_referee: bool = flag(False, "trainer allowed, referee kept")
    old_coach_hear: bool = flag(False, "unused")
    fullstate_l: bool = flag(False, "send fullstate to left players (see is not suppressed)")
    fullstate_r: bool = flag(False, "send fullstate to right players")
    verbose: bool = flag(False, "print more", since=8)
    max_monitors: int = integer(-1, "count", "<=0 unlimited; not in server_param of players", since=0)
    keepaway: bool = flag(False, "keepaway training", since=9)
    keepaway_length: float = real(20.0, "m", "length of the keepaway region", low=0, since=9)
    keepaway_width: float = real(20.0, "m", "width of the keepaway region", low=0, since=9)
    keepaway_start: int = integer(-1, "s", "auto start; -1 off", since=9)

    # --- logging
    landmark_file: str = text("~/.rcssserver-landmark.xml", "XML landmark override", since=8)
    send_comms: bool = flag(False, "relay referee/player/coach audio to monitors", since=8)
    text_logging: bool = flag(True, "write the command log (.rcl)", since=8)
    game_logging: bool = flag(True, "write the game log (.rcg)", since=8)
    game_log_version: int = integer(6, "", "1..6 or -1 (JSON)", low=-1, high=6, since=8)
    text_log_dir: str = text("./", "directory of the command log", since=8)
    game_log_dir: str = text("./", "directory of the game log", since=8)
    text_log_fixed_name: str = text("rcssserver", "name of the command log when fixed", since=8)
    game_log_fixed_name: str = text("rcssserver", "name of the game log when fixed", since=8)
    text_log_fixed: bool = flag(False, "use the fixed name", since=8)
    game_log_fixed: bool = flag(False, "use the fixed name", since=8)
    text_log_dated: bool = flag(True, "put the date into the name", since=8)
    game_log_dated: bool = flag(True, "put the date into the name", since=8)
    log_date_format: str = text("%Y%m%d%H%M%S-", "format of that date", since=8)
    log_times: bool = flag(False, "log the real time of every cycle", since=8)
    record_messages: bool = flag(False, "put messages into the game log", since=8)
    text_log_compression: int = integer(0, "0-9", "gzip level", low=0, high=9, since=8)
    game_log_compression: int = integer(0, "0-9", "gzip level", low=0, high=9, since=8)
    profile: bool = flag(False, "log the time spent in parts of the server", since=8)
    keepaway_logging: bool = flag(True, "write the keepaway log", since=9)
    keepaway_log_dir: str = text("./", "directory of the keepaway log", since=9)
    keepaway_log_fixed_name: str = text("rcssserver", "name of the keepaway log when fixed", since=9)
    keepaway_log_fixed: bool = flag(False, "use the fixed name", since=9)
    keepaway_log_dated: bool = flag(True, "put the date into the name", since=9)

    @classmethod
    def from_text(cls, message: str) -> ServerParameters:
        """Read the server's ``(server_param (name value)...)``; what it does not tell has the default.

        Raises
        ------
        ParameterError
            When the message is malformed, a name unknown or a value not allowed.
        """
        return cls(**cls._values(items_of(message, "server_param")))

    def to_text(self, version: int | None = None) -> str:
        """The server's message, names in alphabetical order, reals with 6 digits.

        Parameters
        ----------
        version : int, optional
            Protocol version (8 or more) of the client it is meant for; all parameters, as in logs, when not given.
        """
        return self._message("server_param ", version, alphabetical=True)

    @property
    def half_cycles(self) -> int:
        """Cycles of one normal half; not positive means endless."""
        return self._cycles(self.half_time)

    @property
    def extra_half_cycles(self) -> int:
        """Cycles of one half of extra time."""
        return self._cycles(self.extra_half_time)

    def _cycles(self, seconds: int) -> int:
        return int(seconds * 1000.0 / self.simulator_step + 0.5)

    def without_noise(self) -> ServerParameters:
        """The same parameters with ``ball_rand``, ``player_rand``, ``kick_rand`` and ``wind_rand`` zero.

        The deltas of heterogeneous types still make their ``kick_rand`` differ from zero.
        """
        return dataclasses.replace(self, ball_rand=0.0, player_rand=0.0, kick_rand=0.0, wind_rand=0.0)
