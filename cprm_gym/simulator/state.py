"""The state of the soccer world as one structured array: one record per world.

`WORLD` is the whole state of one world; ``numpy.zeros(W, WORLD)`` is ``W`` worlds. A record is what kernels take, so entering
compiled code costs one array, a snapshot is one copy and "equal" means equal bytes. Objects are numbered 0 = ball,
1..11 = left players, 12..22 = right players (`BALL`, `player_index`); arrays over players only are 0..21.

Units: metres, cycles (100 ms), radians. The frame is the server's: x to the right, y downwards, angles from +x towards +y
(specification/simulator.md 0.1). Side is +1 for left, -1 for right, 0 for neutral.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum, IntFlag
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..errors import ParameterError

Seed: TypeAlias = "int | np.random.SeedSequence | Sequence[int | np.random.SeedSequence]"
Worlds: TypeAlias = "int | Sequence[int] | slice | npt.NDArray[Any] | None"
"""Which worlds: an index, indices, a slice, a mask, or all of them (None)."""

PLAYERS = 22
OBJECTS = 23
BALL = 0
LEFT, NEUTRAL, RIGHT = 1, 0, -1
ANNOUNCEMENTS = 32
"""Announcements kept of one step; 22 automatic player types and a mode are the most that happens at once."""
SAY_QUEUE = 44
"""Say messages kept per world and cycle: two of every player. More are dropped (the server has no such limit)."""
SAY_SIZE = 32
"""Bytes kept of one say message; ``say_msg_size`` (10 by default) limits what is accepted."""


class PlayMode(IntEnum):
    """Play modes with the server's ids (specification/simulator.md 0.4); ``PlayMode(i).name`` is the announced string for ids above 0."""

    null = 0
    before_kick_off = 1
    time_over = 2
    play_on = 3
    kick_off_l = 4
    kick_off_r = 5
    kick_in_l = 6
    kick_in_r = 7
    free_kick_l = 8
    free_kick_r = 9
    corner_kick_l = 10
    corner_kick_r = 11
    goal_kick_l = 12
    goal_kick_r = 13
    goal_l = 14
    goal_r = 15
    drop_ball = 16
    offside_l = 17
    offside_r = 18
    penalty_kick_l = 19
    penalty_kick_r = 20
    first_half_over = 21
    pause = 22
    human_judge = 23
    foul_charge_l = 24
    foul_charge_r = 25
    foul_push_l = 26
    foul_push_r = 27
    foul_multiple_attack_l = 28
    foul_multiple_attack_r = 29
    foul_ballout_l = 30
    foul_ballout_r = 31
    back_pass_l = 32
    back_pass_r = 33
    free_kick_fault_l = 34
    free_kick_fault_r = 35
    catch_fault_l = 36
    catch_fault_r = 37
    indirect_free_kick_l = 38
    indirect_free_kick_r = 39
    penalty_setup_l = 40
    penalty_setup_r = 41
    penalty_ready_l = 42
    penalty_ready_r = 43
    penalty_taken_l = 44
    penalty_taken_r = 45
    penalty_miss_l = 46
    penalty_miss_r = 47
    penalty_score_l = 48
    penalty_score_r = 49
    illegal_defense_l = 50
    illegal_defense_r = 51


class PlayerBit(IntFlag):
    """Player state bits of monitor and log (specification/simulator.md 0.5)."""

    STAND = 0x000001
    KICK = 0x000002
    KICK_FAULT = 0x000004
    GOALIE = 0x000008
    CATCH = 0x000010
    CATCH_FAULT = 0x000020
    BALL_TO_PLAYER = 0x000040
    PLAYER_TO_BALL = 0x000080
    DISCARD = 0x000100
    LOST = 0x000200
    BALL_COLLIDE = 0x000400
    PLAYER_COLLIDE = 0x000800
    TACKLE = 0x001000
    TACKLE_FAULT = 0x002000
    BACK_PASS = 0x004000
    FREE_KICK_FAULT = 0x008000
    POST_COLLIDE = 0x010000
    FOUL_CHARGED = 0x020000
    YELLOW_CARD = 0x040000
    RED_CARD = 0x080000
    ILLEGAL_DEFENSE = 0x100000


class CommandKind(IntEnum):
    """Body command of one player in one cycle; arguments in `COMMAND` fields ``a, b, c, d``."""

    NONE = 0
    DASH = 1
    """``a`` power, ``b`` direction in degrees; both legs."""
    TURN = 2
    """``a`` moment in degrees."""
    KICK = 3
    """``a`` power, ``b`` direction in degrees."""
    TACKLE = 4
    """``a`` direction in degrees, ``b`` nonzero for an intentional foul."""
    CATCH = 5
    """``a`` direction in degrees."""
    MOVE = 6
    """``a`` x, ``b`` y, in the team's own frame."""
    DASH_LEGS = 7
    """``a, b`` power and direction of the left leg, ``c, d`` of the right leg; a leg whose power is NaN is not dashed."""


class ViewWidth(IntEnum):
    """View width of `COMMAND` and `WORLD`; ``KEEP`` only in commands."""

    KEEP = 0
    NARROW = 1
    NORMAL = 2
    WIDE = 3


class Count(IntEnum):
    """Columns of ``WORLD["counts"]``: executed commands as `sense_body` reports them."""

    KICK = 0
    DASH = 1
    TURN = 2
    CATCH = 3
    MOVE = 4
    TURN_NECK = 5
    CHANGE_VIEW = 6
    CHANGE_FOCUS = 7
    SAY = 8
    TACKLE = 9
    FOUL = 10
    ARM = 11
    ATTENTION = 12


class Stream(IntEnum):
    """Random streams of one world, kept apart so that one user's draws never change another's luck."""

    PHYSICS = 0
    SENSORS = 1
    REFEREE = 2
    RESETS = 3


class Announcement(IntEnum):
    """What the referee says; arguments in the columns ``a, b, c`` of ``WORLD["announcement"]`` after the kind.

    ``trainer.announcement_text`` gives the server's string. Sides are +1 and -1.
    """

    NONE = 0
    MODE = 1
    """``a`` the `PlayMode`; the string is its name."""
    GOAL = 2
    """``a`` side, ``b`` its new score: ``goal_l_1``."""
    HALF_TIME = 3
    TIME_EXTENDED = 4
    TIME_UP = 5
    TIME_UP_WITHOUT_A_TEAM = 6
    GOALIE_CATCH_BALL = 7
    """``a`` side."""
    YELLOW_CARD = 8
    """``a`` side, ``b`` uniform number."""
    RED_CARD = 9
    PENALTY_ONFIELD = 10
    """``a`` side of the goal the shoot-out is played on."""
    PENALTY_FOUL = 11
    PENALTY_WINNER = 12
    PENALTY_DRAW = 13
    TRAINING_KEEPAWAY = 14
    CHANGE_PLAYER_TYPE = 15
    """``a`` side, ``b`` uniform number, ``c`` the new type; not a referee string but a broadcast of its own."""
    PROMOTE_GOALIE = 16
    """``a`` side, ``b`` uniform number of the new goalie; a broadcast of its own."""


COMMAND = np.dtype(
    [
        ("a", "f8"),
        ("b", "f8"),
        ("c", "f8"),
        ("d", "f8"),
        ("turn_neck", "f8"),  # moment in degrees; NaN = none
        ("focus", "f8", (2,)),  # change_focus: distance and direction moments (m, degrees); NaN = none
        ("point", "f8", (2,)),  # pointto: distance, direction (m, degrees); NaN = none; (inf, inf) = pointto off
        ("kind", "i1"),  # CommandKind
        ("view_width", "i1"),  # ViewWidth, KEEP = no change_view
        ("view_quality", "i1"),  # 0 one-argument change_view, 1 high, 2 low
        ("attention_side", "i1"),  # 0 none, 1 our, 2 opponent, 3 attentionto off
        ("attention_unum", "i1"),  # 1..11
        ("say_length", "i1"),  # bytes of `say`; 0 = no message
        ("say", "u1", (SAY_SIZE,)),
    ],
    align=True,
)
"""What one player sends in one cycle: at most one body command (the first counts) and the free side commands."""


WORLD = np.dtype(
    [
        # --- clocks, mode, score
        ("time", "i4"),
        ("stoppage", "i4"),
        ("mode", "i4"),
        ("kick_off_side", "i4"),
        ("ball_catcher", "i4"),  # object number of the goalie who holds the ball, 0 = nobody
        ("last_play_on_start", "i4"),
        ("half_count", "i4"),
        ("score", "i4", (2,)),
        ("pen_score", "i4", (2,)),
        ("pen_miss", "i4", (2,)),
        ("steps", "i8"),  # steps since the world was seeded; never stops; the counter of the random streams
        ("draws", "i8"),  # extra counter for draws outside a step
        ("key", "u8", (4,)),  # one key per Stream
        ("wind", "f8", (2,)),
        ("wind_rand", "f8"),
        # --- objects 0..22
        ("pos", "f8", (OBJECTS, 2)),
        ("vel", "f8", (OBJECTS, 2)),
        ("acc", "f8", (OBJECTS, 2)),
        # --- players 0..21
        ("enabled", "u1", (PLAYERS,)),
        ("goalie", "u1", (PLAYERS,)),  # 1 from the beginning, 2 promoted by a coach: his opponents are not told
        ("type", "i1", (PLAYERS,)),
        ("substituted", "u1", (PLAYERS,)),
        ("card_count", "i1", (PLAYERS,)),
        ("body", "f8", (PLAYERS,)),
        ("body_staged", "f8", (PLAYERS,)),
        ("neck", "f8", (PLAYERS,)),
        ("neck_staged", "f8", (PLAYERS,)),
        ("stamina", "f8", (PLAYERS,)),
        ("effort", "f8", (PLAYERS,)),
        ("recovery", "f8", (PLAYERS,)),
        ("capacity", "f8", (PLAYERS,)),
        ("bits", "u4", (PLAYERS,)),  # PlayerBit
        ("bits_shown", "u4", (PLAYERS,)),  # PlayerBit as logs show them of the last step, before its transient bits are cleared
        ("counts", "i4", (PLAYERS, 13)),  # Count
        # command budget (specification/simulator.md 1.7)
        ("busy", "u1", (PLAYERS,)),
        ("leg_busy", "u1", (PLAYERS, 2)),
        ("neck_busy", "u1", (PLAYERS,)),
        ("leg_power", "f8", (PLAYERS, 2)),
        ("leg_dir", "f8", (PLAYERS, 2)),
        ("leg_dashed", "u1", (PLAYERS, 2)),
        ("kick_cycles", "i2", (PLAYERS,)),
        ("dash_cycles", "i2", (PLAYERS,)),
        ("tackle_cycles", "i2", (PLAYERS,)),
        ("foul_cycles", "i2", (PLAYERS,)),
        ("catch_ban", "i2", (PLAYERS,)),
        ("moves_since_catch", "i2", (PLAYERS,)),
        # view
        ("view_width", "i1", (PLAYERS,)),
        ("view_quality", "i1", (PLAYERS,)),  # ViewWidth; 1 high, 2 low
        ("synchronous", "u1", (PLAYERS,)),
        ("gaussian", "u1", (PLAYERS,)),
        ("see_counter", "i2", (PLAYERS,)),
        ("saw", "u1", (PLAYERS,)),  # saw: a see message is due after this step
        ("focus_distance", "f8", (PLAYERS,)),
        ("focus_direction", "f8", (PLAYERS,)),
        # arm, attention, hearing
        ("arm_target", "f8", (PLAYERS, 2)),
        ("arm_timer", "i4", (PLAYERS,)),
        ("attention", "i1", (PLAYERS,)),  # object number 1..22, 0 = none
        ("ear", "u1", (PLAYERS, 2)),  # per side (own, opponent): bit 0 complete, bit 1 partial
        ("hear_capacity", "f8", (PLAYERS, 2)),
        ("protocol", "i1", (PLAYERS,)),  # protocol version of the player's client; 0 counts as the newest. 17 and older see without focus
        # audio (specification/simulator.md 6.3): the what was said since the last step, kept until the first `say` after it (kernels)
        ("audio_count", "i4"),
        ("audio_time", "i4"),  # the clock when they were said
        ("audio_done", "u1"),
        ("audio_from", "i1", (SAY_QUEUE,)),
        ("audio_listeners", "u4", (SAY_QUEUE,)),
        ("audio_length", "i1", (SAY_QUEUE,)),
        ("audio_text", "u1", (SAY_QUEUE, SAY_SIZE)),
        ("heard_count", "i1", (PLAYERS,)),
        ("heard", "i1", (PLAYERS, SAY_QUEUE)),  # in order: queue index + 1, negative = without text
        ("heard_from", "i2", (PLAYERS, SAY_QUEUE)),  # direction in degrees, of clients before protocol 8, who hear at once
        ("collided", "u1", (PLAYERS,)),  # since the last sense_body: 1 ball, 2 player, 4 post
        # outcomes of draws to come, for replays: 0 drawn as usual, 1 yes, -1 no (kernels.random.decide)
        ("forced_tackle", "i1", (PLAYERS,)),
        ("forced_catch", "i1", (PLAYERS,)),  # success of the player's tackle, stretched catch
        ("forced_foul", "i1", (PLAYERS,)),
        ("forced_card", "i1", (PLAYERS,)),  # his foul is detected; it draws a card
        ("forced_pen_side", "i1"),
        ("forced_pen_taker", "i1"),  # 1 left, -1 right: the goal of a shoot-out and who begins it
        ("order", "u1", (PLAYERS,)),  # scratch: the order in which players' commands are executed in this step
        # scratch of one collision resolution
        ("hit", "u1", (OBJECTS,)),
        ("push", "f8", (OBJECTS, 2)),
        ("pushes", "i2", (OBJECTS,)),
        # --- bookkeeping of types per team (specification/simulator.md 2.2); index 18 = "never substituted"
        ("on_field", "i2", (2, 19)),
        ("used_types", "i2", (2, 19)),
        ("substitutions", "i2", (2,)),
        # --- referee (specification/simulator.md 7); players by object number, 0 = nobody; times -1 = never
        ("stuck_pos", "f8", (2,)),
        ("stuck_count", "i4"),
        ("offside_candidate", "u1", (PLAYERS,)),
        ("offside_pos", "f8", (PLAYERS, 2)),
        ("offside_side", "i4"),
        ("offside_accel", "f8"),
        ("offside_time", "i4"),
        ("offside_stoppage", "i4"),
        ("offside_point", "f8", (2,)),
        ("fk_taken", "u1"),
        ("fk_taker", "i4"),
        ("fk_taker_dashes", "i4"),
        ("fk_timer", "i4"),
        ("fk_goal_count", "i4"),
        ("touch_player", "i4"),
        ("touch_time", "i4"),
        ("touch_accel", "f8"),
        ("touch_indirect", "u1"),
        ("touch_kicker", "i4"),
        ("ball_prev", "f8", (2,)),
        ("goal_wait", "i4"),
        ("bp_last", "i4"),
        ("bp_before_last", "i4"),
        ("bp_time", "i4"),
        ("bp_touched", "u1", (2,)),
        ("wait", "i4", (6,)),  # the 30-step waits: offside, free kick fault, back pass, catch fault, foul, illegal defence
        ("illegal_side", "i4"),
        ("illegal_time", "i4"),
        ("illegal_count", "i4", (2,)),
        ("pen_side", "i4"),
        ("pen_taker_side", "i4"),
        ("pen_number", "i4"),
        ("pen_used", "u1", (PLAYERS,)),
        ("pen_last_taker", "i4"),
        ("pen_timer", "i4"),
        ("pen_started", "u1"),
        ("pen_finished", "u1"),
        ("pen_ball_prev", "f8", (2,)),
        ("auto_kick_off_wait", "i4"),
        ("auto_connect_wait", "i4"),
        ("keepaway_count", "i4"),
        ("keepaway_first", "i4"),  # steps the takers had the ball; the keeper of the first corner
        ("keepaway_begun", "u1"),  # the first episode has begun
        # what a referee's module decided and the referee has still to carry out: Ruling, side, place
        ("ruling", "i4"),
        ("ruling_side", "i4"),
        ("ruling_pos", "f8", (2,)),
        # --- announcements of the current step, in order: Announcement and its arguments; the time each was made
        # announced_done: the step is over, the next announcement begins a new list
        ("announced", "i4"),
        ("announced_done", "u1"),
        ("announcement", "i2", (ANNOUNCEMENTS, 4)),
        ("announced_at", "i4", (ANNOUNCEMENTS,)),
    ],
    align=True,
)
"""The whole state of one world."""


def player_index(side: int, unum: int) -> int:
    """Object number 1..22 of the player `unum` (1..11) of `side` (+1 left, -1 right).

    Raises
    ------
    ValueError
        When the side or the number is not one of those.
    """
    if side not in (LEFT, RIGHT) or not 1 <= unum <= 11:
        raise ValueError(f"no player {unum!r} of side {side!r}: sides are +1 (left) and -1 (right), numbers 1 to 11")
    return unum if side == LEFT else 11 + unum


def chosen_worlds(worlds: Worlds, count: int) -> npt.NDArray[np.int64]:
    """The numbers of the chosen ones among `count` worlds.

    Raises
    ------
    ParameterError
        When there are no such worlds.
    """
    everything = np.arange(count)
    if worlds is None:
        return everything
    try:
        picked: npt.NDArray[np.int64] = np.atleast_1d(everything[worlds])
    except (IndexError, TypeError, ValueError):
        raise ParameterError(
            f"`worlds` takes indices 0 to {count - 1}, a slice or a mask of {count} truth values, got {worlds!r}"
        ) from None
    return picked
