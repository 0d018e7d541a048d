"""An online coach who chooses the types of his players before the kick-off."""

from __future__ import annotations

import re

from ..client.connection import Connection
from ..client.perceived import ServerTold
from ..simulator.player_types import PlayerType

_ANSWER = re.compile(r"\(init ([lr]) ok\)")
_CHANGED = re.compile(r"\(ok change_player_type (\d+) (\d+)\)")


def choose_types(types: tuple[PlayerType, ...], players: int, most: int = 1, max_power: float = 100.0) -> dict[int, int]:
    """A type for each field player, the fastest for those in front, each at most `most` times; the goalie keeps the default type.

    Parameters
    ----------
    types : tuple of PlayerType
        As the server told them; type 0 is the default type.
    players : int
        Players of the team.
    most : int
        Players who may be of one type (``pt_max``).
    max_power : float
        Power of a dash.

    Returns
    -------
    dict of int to int
        Uniform number -> type.
    """

    def top_speed(number: int) -> float:
        return min(types[number].real_speed_max(max_power), types[number].player_speed_max)

    best = sorted((number for number in range(1, len(types)) for _ in range(most)), key=lambda number: (-top_speed(number), number))
    numbers = list(range(players, 1, -1))
    return dict(zip(numbers, best))


class TypeCoach:
    """A coach on a server: when the parameters have come he exchanges the players, then only listens.

    Parameters
    ----------
    host, port
        Of the server's online coaches.
    team : str
    players : int
        Players of the team.
    patience : float
        Seconds for which an answer is waited for.

    Raises
    ------
    CprmError
        When the server does not answer, or refuses.

    Attributes
    ----------
    chosen : dict of int to int
        What the server has accepted.
    """

    def __init__(self, host: str, port: int, team: str, players: int, patience: float = 10.0) -> None:
        self.connection = Connection(host, port)
        self._told, self._asked, self._players = ServerTold(), False, players
        self.chosen: dict[int, int] = {}
        try:
            self.connection.ask(f"(init {team} (version 19))", lambda text: _ANSWER.fullmatch(text) is not None, patience, self._told.tell)
        except BaseException:
            self.connection.close()
            raise

    def take(self) -> None:
        """Take in what has come; exchange the players once everything is known."""
        for text in self.connection.receive():
            found = _CHANGED.fullmatch(text)
            if found is not None:
                self.chosen[int(found[1])] = int(found[2])
            else:
                self._told.tell(text)
        if not self._asked and self._told.server is not None and len(self._told.types) > 1:
            self._asked = True
            for unum, kind in choose_types(self._told.player_types, self._players).items():
                self.connection.send(f"(change_player_type {unum} {kind})")

    def leave(self) -> None:
        """Say goodbye and close the connection."""
        self.connection.send("(bye)")
        self.connection.close()
