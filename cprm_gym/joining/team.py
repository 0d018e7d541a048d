"""Several players of a team in one process, each with a connection, percepts and a controller of his own."""

from __future__ import annotations

import select
import time
from collections.abc import Callable

import numpy as np

from ..envs.controller import ControllerFactory
from ..envs.core import SoccerCore
from ..envs.tasks import Task
from ..simulator.state import PlayMode
from .coach import TypeCoach
from .player import JoinedPlayer

GIVE_UP = 15.0
"""Seconds of silence after which a team leaves."""


def formation(task: Task, seed: int = 0, part: str = "left") -> np.ndarray:
    """(n, 2) places, metres in the team's frame, at which the players of one side of a task start."""
    core = SoccerCore(task, 1, seed=seed)
    core.reset(seed)
    first, count, sign = (1, task.left, 1.0) if part == "left" else (12, task.right, -1.0)
    places: np.ndarray = sign * core.sim.world["pos"][0, first : first + count]
    return places


class JoinedTeam:
    """A team on a server.

    Parameters
    ----------
    host : str
    port, coach_port : int
    team : str
    task : Task
    factory : ControllerFactory
    players : int
        How many join from here; the first is the goalie if `goalie`.
    goalie : bool
    part : str
        Which side of the task the team plays, ``left`` or ``right``, whatever side the server gives it.
    coach : bool
        A coach chooses the players' types.
    seed : int
        Player k has the seed ``seed + k``.
    patience : float
        Seconds for which the server's first answer is waited for.

    Raises
    ------
    CprmError
        When the server does not answer, or refuses somebody.
    """

    def __init__(
        self,
        host: str,
        port: int,
        team: str,
        task: Task,
        factory: ControllerFactory,
        *,
        players: int = 11,
        goalie: bool = True,
        part: str = "left",
        coach: bool = False,
        coach_port: int = 6002,
        seed: int = 0,
        patience: float = 10.0,
    ) -> None:
        places = formation(task, seed, part)
        self.players: list[JoinedPlayer] = []
        self.coach: TypeCoach | None = None
        try:
            for k in range(players):
                keeper = goalie and k == 0
                player = JoinedPlayer(
                    host, port, team, task, factory, goalie=keeper, seed=seed + k, part=part, formation=places, patience=patience,
                    rehearsed=k > 0,
                )  # fmt: skip
                self.players.append(player)
                self._answer()
            if coach:
                self.coach = TypeCoach(host, coach_port, team, players, patience)
        except BaseException:
            self.leave()
            raise

    def _answer(self) -> None:
        """Let nobody wait for those who are in while others still connect."""
        for player in self.players:
            player.take()
            if player.due <= time.monotonic():
                player.act()

    def play(self, goes_on: Callable[[], bool] = lambda: True) -> None:
        """Play until the match is over or the server has been silent for long.

        Parameters
        ----------
        goes_on : callable
            Asked now and then; False ends it.
        """
        poll = select.epoll()
        try:
            owners = {player.connection.fileno(): player for player in self.players}
            for number in owners:
                poll.register(number, select.EPOLLIN)
            if self.coach is not None:
                poll.register(self.coach.connection.fileno(), select.EPOLLIN)
            while self.players and goes_on() and not self._is_over():
                wait = min([player.due for player in self.players] + [time.monotonic() + 0.2]) - time.monotonic()
                ready = poll.poll(max(0.0, wait))
                for number, _ in ready:
                    if number in owners:
                        owners[number].take()
                    elif self.coach is not None:
                        self.coach.take()
                for player in self.players:
                    if player.due <= time.monotonic():
                        player.act()
                    elif player.silent:
                        player.reconnect()
        finally:
            poll.close()

    def _is_over(self) -> bool:
        """The server has said nothing for long, or the match is over and it has fallen silent."""
        silence = time.monotonic() - max(player.connection.heard for player in self.players)
        ended = int(self.players[0].core.sim.world["mode"][0]) == PlayMode.time_over
        return silence > (1.0 if ended else GIVE_UP)

    def leave(self) -> None:
        """Everybody says goodbye."""
        for player in self.players:
            player.leave()
        if self.coach is not None:
            self.coach.leave()

    def summary(self) -> str:
        """What was decided and missed, on a line."""
        if not self.players:
            return "nobody played"
        tallies, ears = [player.tally for player in self.players], [player.ear for player in self.players]
        total = {
            "decisions": sum(tally.decisions for tally in tallies),
            "cycles missed while deciding": sum(tally.missed for tally in tallies),
            "messages lost": sum(ear.lost for ear in ears),
            "late or doubled": sum(ear.stale for ear in ears),
            "damaged": sum(ear.damaged for ear in ears),
            "reconnections": sum(tally.reconnections for tally in tallies),
        }
        longest = max(tally.longest for tally in tallies) * 1000
        return f"{len(self.players)} players: {', '.join(f'{n} {name}' for name, n in total.items())}; longest decision {longest:.0f} ms"
