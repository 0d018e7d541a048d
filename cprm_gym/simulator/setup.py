"""How a world begins: players at home, full of stamina, the clock at 0 (specification/simulator.md 0.6), and its random streams."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError
from .player_types import TypeColumn
from .state import LEFT, PLAYERS, WORLD, PlayerBit, PlayMode, Seed, Stream, ViewWidth

if TYPE_CHECKING:
    from .parameters import ServerParameters

NEVER_SUBSTITUTED = 18
_D2R = math.pi / 180.0


def initial_world(packed: npt.NDArray[Any], left: int, right: int, goalies: tuple[int, int]) -> npt.NDArray[Any]:
    """One `WORLD` record (shape ()) before kick-off, as after the connection of every player.

    Parameters
    ----------
    packed : (1,) array of PARAMETERS
        Made by `pack`.
    left, right : int
        Players per team, 0 to 11.
    goalies : pair of int
        Uniform numbers of the goalies, 0 for none.

    Raises
    ------
    ParameterError
        When there are no such numbers of players or goalies.
    """
    for name, size in (("left", left), ("right", right)):
        if isinstance(size, bool) or not isinstance(size, (int, np.integer)) or not 0 <= size <= 11:
            raise ParameterError(f"`{name}` takes a number of players from 0 to 11, got {size!r}")
    if not isinstance(goalies, (tuple, list)) or len(goalies) != 2:
        raise ParameterError(f"`goalies` takes two uniform numbers, got {goalies!r}")
    p = packed[0]
    w = np.zeros((), WORLD)
    w["mode"], w["kick_off_side"] = PlayMode.before_kick_off, LEFT
    w["score"] = p["start_goal_l"], p["start_goal_r"]
    w["auto_kick_off_wait"], w["auto_connect_wait"] = p["kick_off_wait"], p["connect_wait"]
    for name in ("offside_time", "offside_stoppage", "touch_time", "bp_time", "illegal_time", "fk_timer"):
        w[name] = -1
    for team, (size, goalie) in enumerate(zip((left, right), goalies)):
        if isinstance(goalie, bool) or not isinstance(goalie, (int, np.integer)) or not 0 <= goalie <= size:
            raise ParameterError(f"`goalies` takes uniform numbers of players on the field (0 for none), got {goalies!r}")
        w["on_field"][team, NEVER_SUBSTITUTED] = w["used_types"][team, NEVER_SUBSTITUTED] = size
        for i in range(11 * team, 11 * team + size):
            w["enabled"][i] = 1
            w["bits"][i] = PlayerBit.STAND
        if goalie:
            w["goalie"][11 * team + goalie - 1] = 1
            w["bits"][11 * team + goalie - 1] |= PlayerBit.GOALIE
    for i in range(PLAYERS):
        w["pos"][i + 1] = home(i)
    w["body"][11:] = math.pi  # committed; the staged angle is 0, so that everybody faces 0 after the first step
    w["stamina"], w["capacity"], w["recovery"] = p["stamina_max"], p["stamina_capacity"], 1.0
    w["effort"] = p["types"][0, TypeColumn.EFFORT_MAX]
    w["hear_capacity"] = p["hear_max"]
    w["ear"] = 1
    w["arm_timer"] = p["point_to_duration"]
    w["view_width"], w["view_quality"], w["synchronous"] = ViewWidth.NORMAL, 1, 1
    return w


def home(row: int) -> tuple[float, float]:
    """Where player `row` (0..21) waits beside the pitch before he is placed, and when he has left."""
    return 3.0 * (row % 11 + 1) * (-1.0 if row < 11 else 1.0), -37.0


def stream_keys(seed: Seed, chosen: npt.NDArray[np.int64], first: int = 0) -> npt.NDArray[np.uint64]:
    """Keys of the random streams, shape (len(chosen), 4).

    Parameters
    ----------
    seed : int, SeedSequence or sequence of int
        One seed, of which world ``k`` gets the child number ``first + k``, or one seed (or SeedSequence) per chosen world.
    chosen : (n,) int array
        Numbers of the worlds.
    first : int
        Number of world 0 among the children.

    Raises
    ------
    ParameterError
        When a seed is not a whole number >= 0, or their number is not that of the chosen worlds.
    """
    if isinstance(seed, np.random.SeedSequence):
        root = seed
        children = [np.random.SeedSequence(root.entropy, spawn_key=(*root.spawn_key, first + int(k))) for k in chosen]
    elif _is_seed(seed):
        children = [np.random.SeedSequence(int(seed), spawn_key=(first + int(k),)) for k in chosen]  # type: ignore[arg-type]
    else:
        try:
            seeds = list(seed)  # type: ignore[arg-type]
        except TypeError:
            seeds = []
        if len(seeds) != len(chosen) or not all(_is_seed(s) or isinstance(s, np.random.SeedSequence) for s in seeds):
            raise ParameterError(f"`seed` takes a whole number >= 0, a SeedSequence or {len(chosen)} such numbers, got {seed!r}")
        children = [s if isinstance(s, np.random.SeedSequence) else np.random.SeedSequence(int(s)) for s in seeds]
    return np.array([child.generate_state(len(Stream), np.uint64) for child in children]).reshape(len(chosen), len(Stream))


def _is_seed(seed: Any) -> bool:
    return isinstance(seed, (int, np.integer)) and not isinstance(seed, (bool, np.bool_)) and int(seed) >= 0


def draw_wind(world: npt.NDArray[Any], parameters: ServerParameters, chosen: npt.NDArray[np.int64]) -> None:
    """Set the wind of the chosen worlds (specification/simulator.md 3.2): none, given, or drawn from the worlds' stream of resets.

    Parameters
    ----------
    world : (W,) array of WORLD
        Changed in place.
    parameters : ServerParameters
        ``wind_none``, ``wind_random``, ``wind_force``, ``wind_dir``, ``wind_rand``.
    chosen : (n,) int array
        Numbers of the worlds.
    """
    if parameters.wind_none:
        return
    if not parameters.wind_random:
        angle = parameters.wind_dir * _D2R
        world["wind"][chosen] = parameters.wind_force * math.cos(angle), parameters.wind_force * math.sin(angle)
        world["wind_rand"][chosen] = parameters.wind_rand
        return
    for k in chosen:
        draws = np.random.default_rng([int(world["key"][k, Stream.RESETS]), int(world["draws"][k])])
        force, angle = draws.uniform(0.0, 100.0), draws.uniform(-math.pi, math.pi)
        world["wind"][k] = force * math.cos(angle), force * math.sin(angle)
        world["wind_rand"][k] = draws.uniform(0.0, 0.5)
