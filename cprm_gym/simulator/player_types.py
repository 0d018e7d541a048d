"""Heterogeneous players: the ``player::`` parameters, the types, and how the server draws them.

The generator is the server's: a Mersenne Twister of its own, seeded once by ``random_seed``, gives the deltas of each type
(specification/parameters.md 5.1); with the same seed the same types come out, digit for digit.
"""

from __future__ import annotations

import dataclasses
import math
from enum import IntEnum
from typing import TYPE_CHECKING

import numpy as np

from ..errors import ParameterError
from .parameter_fields import ParameterSet, flag, integer, items_of, parameter_set, real
from .pitch import PITCH_LENGTH, PITCH_WIDTH

if TYPE_CHECKING:
    from .parameters import ServerParameters

MAX_TYPES = 18
"""Types the packed parameters have room for."""
MAX_TRIALS = 1000
_EPS = 1e-10
_FAR = math.sqrt(PITCH_LENGTH**2 + PITCH_WIDTH**2)


@parameter_set("player parameter")
@dataclasses.dataclass(frozen=True, kw_only=True)
class PlayerParameters(ParameterSet):
    """The ``player::`` parameters: how many types there are and how they are drawn."""

    player_types: int = integer(18, "", "number of types incl. default type 0", low=1, high=MAX_TYPES)
    subs_max: int = integer(3, "", "substitutions allowed to an online coach after the first kick-off", low=0)
    pt_max: int = integer(1, "", "max players of one type (also max uses of one type)", low=0)
    allow_mult_default_type: bool = flag(False, "type 0 exempt from pt_max", since=12)
    random_seed: int = integer(-1, "", "seed of the type generator (Mersenne-Twister 19937, own stream)", since=8)
    player_speed_max_delta_min: float = real(0.0, "", "delta of player_speed_max; lower limit")
    player_speed_max_delta_max: float = real(0.0, "", "delta of player_speed_max; upper limit")
    stamina_inc_max_delta_factor: float = real(0.0, "", "coupling speed_max to stamina_inc_max; overwritten by the new dash rate's")
    player_decay_delta_min: float = real(-0.1, "", "delta of decay; lower limit")
    player_decay_delta_max: float = real(0.1, "", "delta of decay; upper limit")
    inertia_moment_delta_factor: float = real(25.0, "", "coupling decay to inertia")
    dash_power_rate_delta_min: float = real(0.0, "", "delta of the (old) dash rate, now only of player_size; lower limit")
    dash_power_rate_delta_max: float = real(0.0, "", "delta of the (old) dash rate, now only of player_size; upper limit")
    player_size_delta_factor: float = real(-100.0, "", "coupling dash rate to size")
    kickable_margin_delta_min: float = real(-0.1, "", "delta of margin; lower limit")
    kickable_margin_delta_max: float = real(0.1, "", "delta of margin; upper limit")
    kick_rand_delta_factor: float = real(1.0, "", "coupling margin to kick_rand")
    extra_stamina_delta_min: float = real(0.0, "", "delta of extra stamina; lower limit")
    extra_stamina_delta_max: float = real(50.0, "", "delta of extra stamina; upper limit")
    effort_max_delta_factor: float = real(-0.004, "", "coupling extra stamina to effort_max")
    effort_min_delta_factor: float = real(-0.004, "", "coupling extra stamina to effort_min")
    new_dash_power_rate_delta_min: float = real(-0.0012, "", "delta of dash rate; lower limit", since=8)
    new_dash_power_rate_delta_max: float = real(0.0008, "", "delta of dash rate; upper limit", since=8)
    new_stamina_inc_max_delta_factor: float = real(-6000.0, "", "coupling dash rate to stamina_inc_max", since=8)
    kick_power_rate_delta_min: float = real(0.0, "", "delta of kick power rate; lower limit", since=14)
    kick_power_rate_delta_max: float = real(0.0, "", "delta of kick power rate; upper limit", since=14)
    foul_detect_probability_delta_factor: float = real(0.0, "", "coupling kick power rate to foul detection", since=14)
    catchable_area_l_stretch_min: float = real(1.0, "", "range of the stretch; lower limit", since=14)
    catchable_area_l_stretch_max: float = real(1.3, "", "range of the stretch; upper limit", since=14)

    @classmethod
    def from_text(cls, message: str) -> PlayerParameters:
        """Read the server's ``(player_param (name value)...)``; what it does not tell has the default.

        Raises
        ------
        ParameterError
            When the message is malformed, a name unknown or a value not allowed.
        """
        return cls(**cls._values(items_of(message, "player_param")))

    def to_text(self, version: int | None = None) -> str:
        """The server's message, names in alphabetical order; `version` as in `ServerParameters.to_text`."""
        return self._message("player_param ", version, alphabetical=True)


@parameter_set("field of a player type")
@dataclasses.dataclass(frozen=True, kw_only=True)
class PlayerType(ParameterSet):
    """One heterogeneous type; the defaults are type 0 of a default server."""

    player_speed_max: float = real(1.05, "m/cycle", "speed cap", above=0)
    stamina_inc_max: float = real(45.0, "stamina/cycle", "stamina regained per cycle at recovery 1", low=0)
    player_decay: float = real(0.4, "", "velocity multiplier per cycle", low=0, below=1)
    inertia_moment: float = real(5.0, "", "turn damping", low=0)
    dash_power_rate: float = real(0.006, "", "power to acceleration", low=0)
    player_size: float = real(0.3, "m", "body radius", above=0)
    kickable_margin: float = real(0.7, "m", "width of the kickable ring", above=0)
    kick_rand: float = real(0.1, "", "kick noise", low=0)
    extra_stamina: float = real(50.0, "stamina", "reserve usable below zero", low=0)
    effort_max: float = real(1.0, "", "ceiling of effort", low=0)
    effort_min: float = real(0.6, "", "floor of effort", low=0)
    kick_power_rate: float = real(0.027, "", "kick power to acceleration", since=14)
    foul_detect_probability: float = real(0.5, "prob", "that the referee sees an intentional foul", since=14)
    catchable_area_l_stretch: float = real(1.0, "", "stretch of the catch rectangle", low=0, since=14)
    unum_far_length: float = real(20.0, "m", "numbers are always seen up to here", low=0, since=18)
    unum_too_far_length: float = real(40.0, "m", "numbers are never seen beyond", low=0, since=18)
    team_far_length: float = real(_FAR, "m", "teams are always seen up to here", low=0, since=18)
    team_too_far_length: float = real(_FAR, "m", "teams are never seen beyond", low=0, since=18)
    player_max_observation_length: float = real(_FAR, "m", "players are not seen beyond", low=0, since=18)
    ball_vel_far_length: float = real(20.0, "m", "the ball's changes are always seen up to here", low=0, since=18)
    ball_vel_too_far_length: float = real(40.0, "m", "the ball's changes are never seen beyond", low=0, since=18)
    ball_max_observation_length: float = real(_FAR, "m", "the ball is not seen beyond", low=0, since=18)
    flag_chg_far_length: float = real(20.0, "m", "landmarks' changes are always seen up to here", low=0, since=18)
    flag_chg_too_far_length: float = real(40.0, "m", "landmarks' changes are never seen beyond", low=0, since=18)
    flag_max_observation_length: float = real(_FAR, "m", "landmarks are not seen beyond", low=0, since=18)
    dist_noise_rate: float = real(0.0125, "", "Gaussian model: sigma per metre, movables", low=0, since=19)
    focus_dist_noise_rate: float = real(0.0125, "", "sigma per metre from the focus point, movables", low=0, since=19)
    land_dist_noise_rate: float = real(0.00125, "", "sigma per metre, landmarks", low=0, since=19)
    land_focus_dist_noise_rate: float = real(0.00125, "", "sigma per metre from the focus point, landmarks", low=0, since=19)

    @classmethod
    def default(cls, parameters: ServerParameters) -> PlayerType:
        """Type 0 of a server with these parameters."""
        shared = {f.name for f in dataclasses.fields(cls)} & set(parameters.names())
        values = {name: getattr(parameters, name) for name in shared}
        return cls(**values, effort_max=parameters.effort_init)

    @classmethod
    def from_text(cls, message: str) -> tuple[int, PlayerType]:
        """Read ``(player_type (id N)(name value)...)``: the id and the type; what is not told has the default.

        Raises
        ------
        ParameterError
            When the message is malformed, a name unknown or a value not allowed.
        """
        items = list(items_of(message, "player_type"))
        if not items or items[0][0] != "id" or not items[0][1].isdecimal():
            raise ParameterError(f"a player_type message starts with (id N), got {message[:60]!r}")
        return int(items[0][1]), cls(**cls._values(iter(items[1:])))

    def to_text(self, id: int, version: int | None = None, digits: int = 6) -> str:
        """The server's message for type number `id`, fields in the server's order.

        Parameters
        ----------
        id : int
            Number of the type.
        version : int, optional
            As in `ServerParameters.to_text`.
        digits : int
            Significant digits; 6 as the server's, 17 for exact recordings.
        """
        return self._message(f"player_type (id {id})", version, alphabetical=False, digits=digits)

    def row(self, parameters: ServerParameters) -> list[float]:
        """The type as a row of the packed parameters, columns `TypeColumn`."""
        values = [getattr(self, f.name) for f in dataclasses.fields(self)]
        area = self.player_size + parameters.ball_size + self.kickable_margin
        return [*values, area * area]

    @property
    def kickable_area(self) -> float:
        """Distance (m) between the centres of player and ball up to which the default ball can be kicked."""
        return self.player_size + self.kickable_margin + 0.085

    def real_speed_max(self, max_power: float = 100.0) -> float:
        """Speed (m/cycle) that dashing with `max_power` approaches at full effort."""
        return max_power * self.dash_power_rate * self.effort_max / (1.0 - self.player_decay)


class TypeColumn(IntEnum):
    """Columns of the packed types: the fields of `PlayerType`, then the squared distance up to which the ball is kickable."""

    PLAYER_SPEED_MAX = 0
    STAMINA_INC_MAX = 1
    PLAYER_DECAY = 2
    INERTIA_MOMENT = 3
    DASH_POWER_RATE = 4
    PLAYER_SIZE = 5
    KICKABLE_MARGIN = 6
    KICK_RAND = 7
    EXTRA_STAMINA = 8
    EFFORT_MAX = 9
    EFFORT_MIN = 10
    KICK_POWER_RATE = 11
    FOUL_DETECT_PROBABILITY = 12
    CATCHABLE_AREA_L_STRETCH = 13
    UNUM_FAR_LENGTH = 14
    UNUM_TOO_FAR_LENGTH = 15
    TEAM_FAR_LENGTH = 16
    TEAM_TOO_FAR_LENGTH = 17
    PLAYER_MAX_OBSERVATION_LENGTH = 18
    BALL_VEL_FAR_LENGTH = 19
    BALL_VEL_TOO_FAR_LENGTH = 20
    BALL_MAX_OBSERVATION_LENGTH = 21
    FLAG_CHG_FAR_LENGTH = 22
    FLAG_CHG_TOO_FAR_LENGTH = 23
    FLAG_MAX_OBSERVATION_LENGTH = 24
    DIST_NOISE_RATE = 25
    FOCUS_DIST_NOISE_RATE = 26
    LAND_DIST_NOISE_RATE = 27
    LAND_FOCUS_DIST_NOISE_RATE = 28
    KICKABLE_SQUARED = 29


# the same as plain numbers, for kernels
T_PLAYER_SPEED_MAX = int(TypeColumn.PLAYER_SPEED_MAX)
T_STAMINA_INC_MAX = int(TypeColumn.STAMINA_INC_MAX)
T_PLAYER_DECAY = int(TypeColumn.PLAYER_DECAY)
T_INERTIA_MOMENT = int(TypeColumn.INERTIA_MOMENT)
T_DASH_POWER_RATE = int(TypeColumn.DASH_POWER_RATE)
T_PLAYER_SIZE = int(TypeColumn.PLAYER_SIZE)
T_KICKABLE_MARGIN = int(TypeColumn.KICKABLE_MARGIN)
T_KICK_RAND = int(TypeColumn.KICK_RAND)
T_EXTRA_STAMINA = int(TypeColumn.EXTRA_STAMINA)
T_EFFORT_MAX = int(TypeColumn.EFFORT_MAX)
T_EFFORT_MIN = int(TypeColumn.EFFORT_MIN)
T_KICK_POWER_RATE = int(TypeColumn.KICK_POWER_RATE)
T_FOUL_DETECT_PROBABILITY = int(TypeColumn.FOUL_DETECT_PROBABILITY)
T_CATCHABLE_AREA_L_STRETCH = int(TypeColumn.CATCHABLE_AREA_L_STRETCH)
T_UNUM_FAR_LENGTH = int(TypeColumn.UNUM_FAR_LENGTH)
T_UNUM_TOO_FAR_LENGTH = int(TypeColumn.UNUM_TOO_FAR_LENGTH)
T_TEAM_FAR_LENGTH = int(TypeColumn.TEAM_FAR_LENGTH)
T_TEAM_TOO_FAR_LENGTH = int(TypeColumn.TEAM_TOO_FAR_LENGTH)
T_PLAYER_MAX_OBSERVATION_LENGTH = int(TypeColumn.PLAYER_MAX_OBSERVATION_LENGTH)
T_BALL_VEL_FAR_LENGTH = int(TypeColumn.BALL_VEL_FAR_LENGTH)
T_BALL_VEL_TOO_FAR_LENGTH = int(TypeColumn.BALL_VEL_TOO_FAR_LENGTH)
T_BALL_MAX_OBSERVATION_LENGTH = int(TypeColumn.BALL_MAX_OBSERVATION_LENGTH)
T_FLAG_CHG_FAR_LENGTH = int(TypeColumn.FLAG_CHG_FAR_LENGTH)
T_FLAG_CHG_TOO_FAR_LENGTH = int(TypeColumn.FLAG_CHG_TOO_FAR_LENGTH)
T_FLAG_MAX_OBSERVATION_LENGTH = int(TypeColumn.FLAG_MAX_OBSERVATION_LENGTH)
T_DIST_NOISE_RATE = int(TypeColumn.DIST_NOISE_RATE)
T_FOCUS_DIST_NOISE_RATE = int(TypeColumn.FOCUS_DIST_NOISE_RATE)
T_LAND_DIST_NOISE_RATE = int(TypeColumn.LAND_DIST_NOISE_RATE)
T_LAND_FOCUS_DIST_NOISE_RATE = int(TypeColumn.LAND_FOCUS_DIST_NOISE_RATE)
T_KICKABLE_SQUARED = int(TypeColumn.KICKABLE_SQUARED)


class ServerGenerator:
    """Uniform reals as the server draws them for its types: MT19937 words, two per number, no number when the limits meet."""

    def __init__(self, seed: int) -> None:
        self._bits = np.random.MT19937()
        self._bits._legacy_seeding(seed % 2**32)  # type: ignore[attr-defined]

    def uniform(self, low: float, high: float) -> float:
        """U(low, high); the midpoint, without drawing, when the limits are closer than 1e-10."""
        if high < low:
            low, high = high, low
        if high - low < _EPS:
            return 0.5 * (low + high)
        first, second = (int(word) for word in self._bits.random_raw(2))
        return low + (first + second * 2.0**32) / 2.0**64 * (high - low)


def generate_types(parameters: ServerParameters, player_parameters: PlayerParameters, seed: int | None = None) -> tuple[PlayerType, ...]:
    """The ``player_types`` types of a match: the default type and types drawn by the server's formulas.

    Parameters
    ----------
    parameters, player_parameters
        The server's parameters.
    seed : int, optional
        Seed of the generator; ``random_seed`` of the player parameters when not given.

    Raises
    ------
    ParameterError
        When neither gives a seed that is not negative.
    """
    seed = player_parameters.random_seed if seed is None else seed
    if seed < 0:
        raise ParameterError(f"player types need a seed >= 0: pass `seed` or set `random_seed`, got {seed}")
    generator = ServerGenerator(seed)
    default = PlayerType.default(parameters)
    types = [default]
    for _ in range(1, player_parameters.player_types):
        for _ in range(MAX_TRIALS):
            drawn = _trial(generator, default, parameters, player_parameters)
            if drawn is not None:
                types.append(drawn)
                break
        else:
            types.append(default)
    return tuple(types)


def _trial(generator: ServerGenerator, default: PlayerType, s: ServerParameters, p: PlayerParameters) -> PlayerType | None:
    """One attempt to draw a type, None when it is refused; the draws are in the server's order."""
    delta = generator.uniform(p.player_speed_max_delta_min, p.player_speed_max_delta_max)
    speed_max = s.player_speed_max + delta
    if speed_max <= 0.0 or s.stamina_inc_max + delta * p.stamina_inc_max_delta_factor <= 0.0:
        return None
    delta = generator.uniform(p.player_decay_delta_min, p.player_decay_delta_max)
    decay, inertia = s.player_decay + delta, s.inertia_moment + delta * p.inertia_moment_delta_factor
    if decay <= 0.0 or inertia < 0.0:
        return None
    delta = generator.uniform(p.dash_power_rate_delta_min, p.dash_power_rate_delta_max)
    size = s.player_size + delta * p.player_size_delta_factor
    if s.dash_power_rate + delta <= 0.0 or size <= 0.0:
        return None
    delta = generator.uniform(p.new_dash_power_rate_delta_min, p.new_dash_power_rate_delta_max)
    dash_rate, stamina_inc = s.dash_power_rate + delta, s.stamina_inc_max + delta * p.new_stamina_inc_max_delta_factor
    if dash_rate <= 0.0 or stamina_inc <= 0.0:
        return None
    delta = generator.uniform(p.kickable_margin_delta_min, p.kickable_margin_delta_max)
    margin, kick_rand = s.kickable_margin + delta, s.kick_rand + delta * p.kick_rand_delta_factor
    if margin <= 0.0 or kick_rand < 0.0:
        return None
    delta = generator.uniform(p.extra_stamina_delta_min, p.extra_stamina_delta_max)
    extra = s.extra_stamina + delta
    effort_max, effort_min = s.effort_init + delta * p.effort_max_delta_factor, s.effort_min + delta * p.effort_min_delta_factor
    if extra < 0.0 or effort_max <= 0.0 or effort_min <= 0.0:
        return None
    delta = generator.uniform(p.kick_power_rate_delta_min, p.kick_power_rate_delta_max)
    kick_rate, detect = s.kick_power_rate + delta, s.foul_detect_probability + delta * p.foul_detect_probability_delta_factor
    stretch = generator.uniform(p.catchable_area_l_stretch_min, p.catchable_area_l_stretch_max)
    if decay >= 1.0 or not s.player_speed_max_min - _EPS < s.maxpower * dash_rate * effort_max / (1.0 - decay) < speed_max + _EPS:
        return None
    return dataclasses.replace(
        default,
        player_speed_max=speed_max,
        stamina_inc_max=stamina_inc,
        player_decay=decay,
        inertia_moment=inertia,
        dash_power_rate=dash_rate,
        player_size=size,
        kickable_margin=margin,
        kick_rand=kick_rand,
        extra_stamina=extra,
        effort_max=effort_max,
        effort_min=effort_min,
        kick_power_rate=kick_rate,
        foul_detect_probability=detect,
        catchable_area_l_stretch=stretch,
    )
