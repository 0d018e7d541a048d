"""Referee, trainer and coach: the referee's words, and what the trainer and the coaches may do to a match.

The referee itself is compiled (`kernels.referee`). A `Simulator` has a `Trainer`, ``simulator.trainer``, and a `Coach`,
``simulator.coach`` (specification/simulator.md 4.9, 4.10); they act at once, between the steps.
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ..errors import CommandError, ParameterError, unknown_name
from .kernels import powers
from .pitch import GOAL_DEPTH
from .state import PLAYERS, Announcement, PlayMode, Worlds, chosen_worlds

Numbers: TypeAlias = "float | npt.ArrayLike"

_SIDES = {1: "l", -1: "r"}
_MODES = {mode.name: mode for mode in PlayMode if mode != PlayMode.null}
_PLAIN = {
    Announcement.HALF_TIME: "half_time",
    Announcement.TIME_EXTENDED: "time_extended",
    Announcement.TIME_UP: "time_up",
    Announcement.TIME_UP_WITHOUT_A_TEAM: "time_up_without_a_team",
    Announcement.PENALTY_DRAW: "penalty_draw",
}
_WITH_SIDE = {
    Announcement.GOALIE_CATCH_BALL: "goalie_catch_ball",
    Announcement.PENALTY_ONFIELD: "penalty_onfield",
    Announcement.PENALTY_FOUL: "penalty_foul",
    Announcement.PENALTY_WINNER: "penalty_winner",
}
_WITH_SIDE_AND_NUMBER = {
    Announcement.GOAL: "goal",
    Announcement.YELLOW_CARD: "yellow_card",
    Announcement.RED_CARD: "red_card",
}
_ANSWERS = {
    powers.WHILE_PLAY_ON: "(warning cannot_sub_while_playon)",
    powers.WHILE_SHOOT_OUT: "(warning cannot_sub_while_penalty_shootouts)",
    powers.NO_SUBSTITUTIONS_LEFT: "(warning no_subs_left)",
    powers.NO_SUCH_TYPE: "(error out_of_range_player_type)",
    powers.TYPE_USED_UP: "(warning no_left_of_that_type)",
    powers.NO_SUCH_PLAYER: "(warning no_such_player)",
    powers.TYPE_ON_FIELD: "(warning max_of_that_type_on_field)",
    powers.GOALIE_WHILE_PLAY_ON: "(warning cannot_change_goalie_while_playon)",
    powers.GOALIE_WHILE_PENALTY: "(warning cannot_change_goalie_while_penalty_taken)",
    powers.HAS_GOALIE: "(error goalie_already_exists)",
}


def announcement_text(kind: int, a: int = 0, b: int = 0, c: int = 0) -> str:
    """What the server says for an announcement, a row of ``WORLD["announcement"]``.

    Parameters
    ----------
    kind : int
        `Announcement`.
    a, b, c : int
        Its arguments.

    Returns
    -------
    str
        The referee's word (``kick_off_l``, ``goal_r_2``, ``yellow_card_l_5``), or the broadcast of a change of player.

    Raises
    ------
    UnknownName
        When there is no such announcement.
    """
    if kind == Announcement.MODE:
        return PlayMode(a).name
    if kind in _PLAIN:
        return _PLAIN[Announcement(kind)]
    if kind in _WITH_SIDE:
        return f"{_WITH_SIDE[Announcement(kind)]}_{_SIDES[a]}"
    if kind in _WITH_SIDE_AND_NUMBER:
        return f"{_WITH_SIDE_AND_NUMBER[Announcement(kind)]}_{_SIDES[a]}_{b}"
    if kind == Announcement.TRAINING_KEEPAWAY:
        return f"training Keepaway {a}"
    if kind == Announcement.CHANGE_PLAYER_TYPE:
        return f"(change_player_type {_SIDES[a]} {b} {c})"
    if kind == Announcement.PROMOTE_GOALIE:
        return f"(change_player_type {_SIDES[a]} {b} goalie)"
    raise unknown_name("announcement", str(kind), [str(int(known)) for known in Announcement if known])


class _Official:
    """Somebody with powers over the worlds of a simulator.

    In every method `worlds` chooses the worlds concerned: an index, indices, a slice, a mask, or all of them when it is not
    given. Numbers may be one for all chosen worlds or one for each.

    Parameters
    ----------
    world : (W,) array of WORLD
        Of the simulator; changed in place.
    packed : (1,) array of PARAMETERS
    """

    def __init__(self, world: npt.NDArray[Any], packed: npt.NDArray[Any]) -> None:
        self._world, self._packed = world, packed

    def _chosen(self, worlds: Worlds) -> npt.NDArray[np.int64]:
        return chosen_worlds(worlds, len(self._world))


class Trainer(_Official):
    """What the trainer may do: place ball and players, change the mode, rest and exchange players, kick off."""

    def place_ball(self, x: Numbers, y: Numbers, vx: Numbers = 0.0, vy: Numbers = 0.0, worlds: Worlds = None) -> None:
        """Put the ball somewhere, out of any goalie's hands.

        Parameters
        ----------
        x, y : float or (n,) array
            Place, metres.
        vx, vy : float or (n,) array
            Velocity, metres per cycle.
        worlds : int, indices, slice or mask, optional

        Raises
        ------
        CommandError
            When a number is not finite.
        ParameterError
            When there are no such worlds.
        """
        chosen = self._chosen(worlds)
        places = _columns("place_ball", chosen, x=x, y=y)
        powers.put_ball(self._world, chosen, places, _columns("place_ball", chosen, vx=vx, vy=vy))

    def place_player(
        self,
        player: int,
        x: Numbers,
        y: Numbers,
        body: Numbers | None = None,
        velocity: tuple[Numbers, Numbers] | None = None,
        worlds: Worlds = None,
    ) -> None:
        """Put a player somewhere; who is in the way is pushed aside as in any collision.

        Parameters
        ----------
        player : int
            Object number 1 to 22 (`player_index`).
        x, y : float or (n,) array
            Place, metres, in the frame of the pitch for both teams.
        body : float or (n,) array, optional
            Direction of his body, radians from -pi to pi; kept when not given.
        velocity : pair of float or (n,) array, optional
            Metres per cycle; kept when not given.
        worlds : int, indices, slice or mask, optional

        Raises
        ------
        CommandError
            When there is no such player, a number is not finite or the direction is beyond pi.
        ParameterError
            When there are no such worlds.
        """
        chosen, row = self._chosen(worlds), _player_row(player)
        places = _columns("place_player", chosen, x=x, y=y)
        bodies, velocities = np.full(len(chosen), np.nan), np.full((len(chosen), 2), np.nan)
        if body is not None:
            bodies[:] = _columns("place_player", chosen, body=body)[:, 0]
            if (np.abs(bodies) > math.pi).any():
                raise CommandError(f"place_player: `body` takes radians from -pi to pi, got {body!r:.60}")
        if velocity is not None:
            velocities[:] = _columns("place_player", chosen, vx=velocity[0], vy=velocity[1])
        powers.put_player(self._world, self._packed, chosen, row, places, bodies, velocities)

    def change_mode(self, mode: str | int, worlds: Worlds = None) -> None:
        """Set the play mode; the ball stays where it is, the referee's modules are told.

        Parameters
        ----------
        mode : str or PlayMode
            ``"play_on"``, ``"free_kick_l"``, ...
        worlds : int, indices, slice or mask, optional

        Raises
        ------
        UnknownName
            When there is no such mode.
        ParameterError
            When there are no such worlds.
        """
        powers.set_modes(self._world, self._packed, self._chosen(worlds), int(_mode(mode)))

    def recover(self, worlds: Worlds = None) -> None:
        """Give every player on the field his full stamina, effort, recovery, capacity and hearing.

        Parameters
        ----------
        worlds : int, indices, slice or mask, optional

        Raises
        ------
        ParameterError
            When there are no such worlds.
        """
        powers.recover_all(self._world, self._packed, self._chosen(worlds))

    def change_player_type(self, player: int, new_type: int, worlds: Worlds = None) -> None:
        """Substitute a player, as the trainer does, without limits: rested, without cards, at the same place.

        Parameters
        ----------
        player : int
            Object number 1 to 22.
        new_type : int
            The type he gets, 0 to ``player_types - 1``.
        worlds : int, indices, slice or mask, optional

        Raises
        ------
        CommandError
            When there is no such player on the field, or no such type.
        ParameterError
            When there are no such worlds.
        """
        chosen, row = self._chosen(worlds), _player_row(player)
        missing = chosen[self._world["enabled"][chosen, row] == 0]
        if len(missing):
            raise CommandError(f"change_player_type: player {player} is not on the field in world {missing[0]}")
        powers.change_type(self._world, self._packed, chosen, row, self._type(new_type))

    def check_ball(self, worlds: Worlds = None) -> list[str]:
        """Where the ball is: ``goal_l``, ``goal_r``, ``in_field`` or ``out_of_field`` (specification/simulator.md 7.16).

        Parameters
        ----------
        worlds : int, indices, slice or mask, optional

        Raises
        ------
        ParameterError
            When there are no such worlds.
        """
        p = self._packed[0]
        half_goal = 0.5 * (p["goal_width"] + p["post_radius"])
        answers = []
        for x, y in self._world["pos"][self._chosen(worlds), 0]:
            in_goal = p["out_x"] <= abs(x) <= p["out_x"] + GOAL_DEPTH and abs(y) <= half_goal
            if in_goal:
                answers.append("goal_l" if x < 0 else "goal_r")
            else:
                answers.append("in_field" if abs(x) <= p["out_x"] and abs(y) <= p["out_y"] else "out_of_field")
        return answers

    def start(self, worlds: Worlds = None) -> None:
        """The kick-off procedure (specification/simulator.md 7.3); nothing happens unless a half begins or time does not count.

        Parameters
        ----------
        worlds : int, indices, slice or mask, optional

        Raises
        ------
        ParameterError
            When there are no such worlds.
        """
        powers.kick_off_worlds(self._world, self._packed, self._chosen(worlds))

    def _type(self, new_type: int) -> int:
        """`new_type` if there is such a type."""
        count = int(self._packed["player_types"][0])
        if isinstance(new_type, (bool, np.bool_)) or not isinstance(new_type, (int, np.integer)) or not 0 <= new_type < count:
            raise CommandError(f"`new_type` takes a player type from 0 to {count - 1}, got {new_type!r}")
        return int(new_type)


class Coach(_Official):
    """What the coaches may do: exchange players and name a goalie, within the rules."""

    def change_player_type(self, player: int, new_type: int, worlds: Worlds = None) -> list[str]:
        """Substitute a player, as his coach does, within the limits of the rules.

        Parameters
        ----------
        player : int
            Object number 1 to 22.
        new_type : int
            The type he gets.
        worlds : int, indices, slice or mask, optional

        Returns
        -------
        list of str
            The server's answer for each chosen world, ``(ok change_player_type 7 3)`` or why it is refused.

        Raises
        ------
        CommandError
            When there is no such player, or `new_type` is not a whole number.
        ParameterError
            When there are no such worlds.
        """
        chosen, row = self._chosen(worlds), _player_row(player)
        if isinstance(new_type, (bool, np.bool_)) or not isinstance(new_type, (int, np.integer)):
            raise CommandError(f"`new_type` takes a whole number, got {new_type!r}")
        answers = np.zeros(len(chosen), np.int64)
        powers.coach_change_type(self._world, self._packed, chosen, row, int(new_type), answers)
        accepted = f"(ok change_player_type {row % 11 + 1} {int(new_type)})"
        return [_ANSWERS.get(int(answer), accepted) for answer in answers]

    def promote_goalie(self, player: int, worlds: Worlds = None) -> list[str]:
        """Make a field player the goalie, as a coach may when his team has none.

        Parameters
        ----------
        player : int
            Object number 1 to 22.
        worlds : int, indices, slice or mask, optional

        Returns
        -------
        list of str
            The server's answer for each chosen world.

        Raises
        ------
        CommandError
            When there is no such player.
        ParameterError
            When there are no such worlds.
        """
        chosen, row = self._chosen(worlds), _player_row(player)
        answers = np.zeros(len(chosen), np.int64)
        powers.coach_promote(self._world, chosen, row, answers)
        accepted = f"(ok change_player_type {row % 11 + 1} goalie)"
        return [_ANSWERS.get(int(answer), accepted) for answer in answers]


def _player_row(player: int) -> int:
    """Row 0..21 of an object number."""
    whole = isinstance(player, (int, np.integer)) and not isinstance(player, (bool, np.bool_))
    if not whole or not 1 <= player <= PLAYERS:
        raise CommandError(f"`player` takes an object number from 1 to {PLAYERS}, got {player!r}")
    return int(player) - 1


def _mode(mode: str | int) -> PlayMode:
    """The play mode of a name or number."""
    if isinstance(mode, str):
        if mode not in _MODES:
            raise unknown_name("play mode", mode, _MODES)
        return _MODES[mode]
    if isinstance(mode, (bool, np.bool_)) or mode not in list(_MODES.values()):
        raise unknown_name("play mode", str(mode), _MODES)
    return PlayMode(mode)


def _columns(method: str, chosen: npt.NDArray[np.int64], **numbers: Numbers) -> npt.NDArray[np.float64]:
    """The numbers as columns, one row per chosen world."""
    table = np.empty((len(chosen), len(numbers)))
    for column, (name, given) in enumerate(numbers.items()):
        try:
            table[:, column] = np.asarray(given, dtype=np.float64)
        except (TypeError, ValueError):
            raise ParameterError(f"{method}: `{name}` takes a number or {len(chosen)} numbers, got {given!r}") from None
        if not np.isfinite(table[:, column]).all():
            raise CommandError(f"{method}: `{name}` takes finite numbers, got {given!r}")
    return table
