"""The packed form of all parameters: one record of dtype `PARAMETERS` with everything the kernels need."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError
from .parameters import Rules, ServerParameters
from .pitch import GOAL_POST_RADIUS, HALF_LENGTH, HALF_WIDTH, PITCH_MARGIN, post_centre
from .player_types import MAX_TYPES, PlayerParameters, PlayerType, TypeColumn

_PACKED = [f for cls in (ServerParameters, PlayerParameters) for f in dataclasses.fields(cls) if f.metadata["kind"] != "text"]

PARAMETERS = np.dtype(
    [(f.name, "f8" if f.metadata["kind"] == "real" else "i4") for f in _PACKED]
    + [
        ("types", "f8", (MAX_TYPES, len(TypeColumn))),  # columns: TypeColumn
        ("rules", "i8"),  # Rules
        ("goal_line", "f8"),
        ("touch_line", "f8"),  # 52.5, 34
        ("out_x", "f8"),
        ("out_y", "f8"),  # the same plus the ball's radius: beyond it the ball is out
        ("limit_x", "f8"),
        ("limit_y", "f8"),  # 57.5, 39: nobody is allowed beyond
        ("post_x", "f8"),
        ("post_y", "f8"),
        ("post_radius", "f8"),
        ("ball_top_speed", "f8"),  # ball_speed_max * ball_decay: what a kick finds at most
        ("player_rand_of", "f8", (2,)),
        ("kick_rand_factor_of", "f8", (2,)),
        ("slowness_of", "f8", (2,)),  # left, right
        ("half_cycles", "i4"),
        ("extra_half_cycles", "i4"),
        ("normal_cycles", "i4"),
        ("total_cycles", "i4"),  # N and M of specification/simulator.md 7.4
    ],
    align=True,
)
"""What the kernels read: every numeric parameter under its own name, the types, and constants derived from them."""


def _marked(kind: np.dtype[Any], mark: str) -> np.dtype[Any]:
    """`kind` with one more name for the bytes of its field ``rules``: the same memory, another type."""
    fields = {name: kind.fields[name] for name in kind.names or ()}  # type: ignore[index]
    names = [*fields, mark]
    formats = [*(field[0] for field in fields.values()), fields["rules"][0]]
    offsets = [*(field[1] for field in fields.values()), fields["rules"][1]]
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": kind.itemsize}, align=True)


NO_REFEREE = _marked(PARAMETERS, "no_referee")
"""The same record where no rule is on: kernels that get it leave the referee out (`kernels.event`)."""


def pack(
    parameters: ServerParameters,
    player_parameters: PlayerParameters,
    types: Sequence[PlayerType],
    rules: Rules = Rules.ALL,
) -> npt.NDArray[Any]:
    """One record of dtype `PARAMETERS`, in an array of shape (1,).

    Parameters
    ----------
    parameters, player_parameters
        The two sets.
    types : sequence of PlayerType
        1 to 18 types; type 0 is the default type. Missing ones are copies of type 0.
    rules : Rules
        Modules of the referee that are on; none are when ``coach`` is set without ``coach_w_referee``.

    Raises
    ------
    ParameterError
        When the number of types is not 1 to 18.
    """
    if not 1 <= len(types) <= MAX_TYPES:
        raise ParameterError(f"`types` takes 1 to {MAX_TYPES} player types, got {len(types)}")
    record = np.zeros(1, PARAMETERS)
    for source in (parameters, player_parameters):
        for field in dataclasses.fields(source):
            if field.metadata["kind"] != "text":
                record[field.name] = getattr(source, field.name)
    for row in range(MAX_TYPES):
        record["types"][0, row] = types[row if row < len(types) else 0].row(parameters)
    if parameters.coach and not parameters.coach_w_referee:
        rules = Rules.NONE
    record["rules"] = int(rules)
    record["goal_line"], record["touch_line"] = HALF_LENGTH, HALF_WIDTH
    record["out_x"], record["out_y"] = HALF_LENGTH + parameters.ball_size, HALF_WIDTH + parameters.ball_size
    record["limit_x"], record["limit_y"] = HALF_LENGTH + PITCH_MARGIN, HALF_WIDTH + PITCH_MARGIN
    record["post_x"], record["post_y"] = post_centre(parameters)
    record["post_radius"] = GOAL_POST_RADIUS
    record["ball_top_speed"] = parameters.ball_speed_max * parameters.ball_decay
    noisy = parameters.team_actuator_noise
    rand = parameters.player_rand
    record["player_rand_of"] = (rand * parameters.prand_factor_l, rand * parameters.prand_factor_r) if noisy else (rand, rand)
    record["kick_rand_factor_of"] = (parameters.kick_rand_factor_l, parameters.kick_rand_factor_r) if noisy else (1.0, 1.0)
    record["slowness_of"] = parameters.slowness_on_top_for_left_team, parameters.slowness_on_top_for_right_team
    record["half_cycles"], record["extra_half_cycles"] = parameters.half_cycles, parameters.extra_half_cycles
    normal = parameters.half_cycles * max(parameters.nr_normal_halfs, 0)
    record["normal_cycles"] = normal
    record["total_cycles"] = normal + parameters.extra_half_cycles * max(parameters.nr_extra_halfs, 0)
    return record
