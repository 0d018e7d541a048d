"""``cprm-gym serve``."""

from __future__ import annotations

import math
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from ..errors import CprmError
from ..files import check_place

Clock = Literal["real", "synchronous", "fast"]


def serve(
    parameters: Annotated[
        list[str] | None, typer.Argument(help="server::name=value and player::name=value, such as server::port=7000.", show_default=False)
    ] = None,
    conf: Annotated[list[Path] | None, typer.Option(help="server.conf or player.conf; may be repeated.", show_default=False)] = None,
    port: Annotated[
        int | None, typer.Option(help="Of the players; the next two are those of trainer and coaches. 0: free ones.", show_default="6000")
    ] = None,
    host: Annotated[str, typer.Option(help="Address to listen at; other machines reach 0.0.0.0.")] = "127.0.0.1",
    clock: Annotated[str, typer.Option(help="real, synchronous (as server::synch_mode), or fast: synchronous without any rest.")] = "",
    seed: Annotated[int, typer.Option(help="Decides every random number of the match.")] = 0,
    automatic: Annotated[bool, typer.Option("--automatic", help="Kick off when teams are there, end after the match.")] = False,
    left: Annotated[str | None, typer.Option(help="Command that starts the left team; {host} {port} {coach_port} are filled in.")] = None,
    right: Annotated[str | None, typer.Option(help="Command that starts the right team.")] = None,
    wait: Annotated[float | None, typer.Option(help="Seconds in which both teams must have come.", show_default="60 with --left")] = None,
    log: Annotated[Path | None, typer.Option(help="Folder for game log (.rcg) and text log (.rcl).")] = None,
    results: Annotated[Path | None, typer.Option(help="Table of results in CSV to which the match is added.")] = None,
) -> None:
    """Serve a match over UDP: players, coaches, trainer and monitors of the RoboCup 2D soccer server can join."""
    from .core import Server
    from .logs import MatchLogs, append_result, check_folder, result_line
    from .settings import Settings
    from .transport import Transport, run_in_real_time, run_synchronously

    if clock not in ("", "real", "synchronous", "fast"):
        raise CprmError(f"--clock {clock!r}: allowed are real, synchronous and fast")
    if seed < 0:
        raise CprmError(f"--seed {seed}: a whole number >= 0 is needed")
    if wait is not None and not 0 < wait < math.inf:
        raise CprmError(f"--wait {wait:g}: seconds above 0 are needed")
    if results is not None:
        check_place(results, "--results")
    if log is not None:
        check_folder(log)
    words = [*port_words(port), *(parameters or ())]
    if automatic:
        words.append("server::auto_mode=true")
    if clock:
        words.append(f"server::synch_mode={'false' if clock == 'real' else 'true'}")
    settings = Settings.from_words(words, conf or (), seed)
    server = Server(settings, seed)
    late: Any = None
    with Transport(server, host, (0, 0, 0) if port == 0 else None) as transport, interrupted(server):
        logs = MatchLogs(server, log) if log is not None else None
        guests = Guests(server, transport.ports, host, left, right, wait)
        typer.echo(
            f"listening at {host}: players and monitors {transport.ports[0]}, trainer {transport.ports[1]}, coaches {transport.ports[2]}"
        )
        try:
            if settings.server.synch_mode:
                run_synchronously(transport, clock == "fast", guests.look_after)
            else:
                late = run_in_real_time(transport, guests.look_after)
        finally:
            guests.stop()
            written = logs.close() if logs is not None else []
    for path in written:
        typer.echo(f"wrote {path}")
    if late is not None and late.late:
        typer.echo(f"{late.late} of {late.cycles} cycles began more than 10 ms late, the worst {late.worst * 1000:.0f} ms", err=True)
    typer.echo(f"{result_line(server.stadium)} ({server.over or 'a team did not come'})")
    if results is not None:
        append_result(server.stadium, results)
    if guests.missing or (settings.server.auto_mode and server.over == "the match is over"):
        guests.complain()


def port_words(port: int | None) -> list[str]:
    """Parameters for ``--port``: the port of the players, and the next two for trainer and online coaches.

    Raises
    ------
    CprmError
        When there are no such ports.
    """
    if not port:
        return []
    names = ("port", "coach_port", "olcoach_port")
    last = 65536 - len(names)
    if not 0 < port <= last:
        raise CprmError(f"--port {port}: allowed are 1 to {last}, and 0 for free ones")
    return [f"server::{name}={port + k}" for k, name in enumerate(names)]


class Guests:
    """Starts the teams of ``--left`` and ``--right`` and sees that they come.

    Attributes
    ----------
    missing : str
        What is said about a team that did not come; empty if there is none.
    """

    def __init__(self, server: Any, ports: tuple[int, ...], host: str, left: str | None, right: str | None, wait: float | None) -> None:
        self._server, self._commands = server, [left, right]
        self._places = {"host": "127.0.0.1" if host in ("0.0.0.0", "::") else host, "port": ports[0], "coach_port": ports[2]}
        self._running: list[Any] = []
        self._wait = wait if wait is not None else 60.0 if left or right else None
        self._begin = time.monotonic()
        self.missing = ""

    def look_after(self) -> bool:
        """Before every cycle: start a team whose turn it is; False when one did not come in time."""
        from .teams import TeamProcess

        teams = self._server.stadium.teams
        for side, command in enumerate(self._commands):
            if command is not None and (side == 0 or teams[0].name or (self._commands[0] is None and not self._running)):
                self._running.append(TeamProcess(command, self._places))
                self._commands[side] = None
            if command is not None:
                break
        if self._wait is None or all(team.joined for team in teams):
            return True
        if time.monotonic() - self._begin < self._wait:
            return True
        absent = next(word for word, team in zip(("left", "right"), teams) if not team.joined)
        self.missing = (
            f"no player of the {absent} team came within {self._wait:g} s; start one that plays at port {self._places['port']}, "
            f"see what --{absent} does, or allow more time with --wait"
        )
        return False

    def complain(self) -> None:
        """At the end of a match that was to have two teams.

        Raises
        ------
        CprmError
            When one of them never came.
        """
        absent = [word for word, team in zip(("left", "right"), self._server.stadium.teams) if not team.joined]
        if self.missing:
            raise CprmError(self.missing)
        if absent:
            raise CprmError(
                f"no player of the {absent[0]} team came before the match began without it; start one that plays at port "
                f"{self._places['port']}, or allow more cycles with server::connect_wait=..."
            )

    def stop(self) -> None:
        """End the teams."""
        for process in self._running:
            process.stop()


@contextmanager
def interrupted(server: Any) -> Iterator[None]:
    """While it lasts, Ctrl-C and SIGTERM end the match after the present cycle."""

    def end(*_: Any) -> None:
        server.over = "interrupted"

    before = {word: signal.signal(word, end) for word in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for word, handler in before.items():
            signal.signal(word, handler)
