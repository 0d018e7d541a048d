"""Sockets and clocks around `Server`: UDP on three ports, one socket per client, and the passing of time (specification/protocol.md 1)."""

from __future__ import annotations

import contextlib
import errno
import ipaddress
import select
import socket
import time
from collections.abc import Callable
from typing import Any

from ..errors import CprmError
from ..simulator.state import PLAYERS, PlayMode
from .clients import LARGEST_DATAGRAM, Client, Port
from .core import Server
from .warming import load_kernels

PATIENCE = 1.25
"""Seconds that a window of the synchronous mode stays open."""
TURNS = 64
"""Datagrams of one client that are read before time may go on; everybody's first one is read before anybody's second."""
MOST_CLIENTS = 256
"""Sockets of clients; more are refused by not being heard."""
_BUFFER = 1 << 18
_GONE = {errno.ECONNREFUSED, errno.ENOTCONN, errno.EPIPE, errno.ENOTSOCK, errno.EBADF}


class Transport:
    """The sockets of a server. They are opened when everything is compiled, so that whoever is answered is not kept waiting afterwards.

    Parameters
    ----------
    server : Server
    host : str
        Address to listen at; loopback unless told otherwise.
    ports : (int, int, int), optional
        Of players and monitors, trainer, coaches; those of the parameters if not given. 0 lets the system choose.

    Raises
    ------
    CprmError
        When the address cannot be used or a port is taken.

    Attributes
    ----------
    ports : (int, int, int)
        Where the server listens.
    dropped : int
        Datagrams that could not be sent because a client does not read.
    """

    def __init__(self, server: Server, host: str = "127.0.0.1", ports: tuple[int, int, int] | None = None) -> None:
        self.server = server
        parameters = server.settings.server
        wanted = ports or (parameters.port, parameters.coach_port, parameters.olcoach_port)
        self._host = host
        self._family = socket.AF_INET6 if _is_six(host) else socket.AF_INET
        for number in wanted:  # a port in use is said at once
            self._open(number).close()
        load_kernels(server.stadium.sim.refereed)
        self._listening: list[socket.socket] = []
        try:
            for number in wanted:
                self._listening.append(self._open(number))
        except BaseException:
            self.close()
            raise
        self.ports: tuple[int, ...] = tuple(sock.getsockname()[1] for sock in self._listening)
        self.dropped = 0
        self._sockets: dict[Client, socket.socket] = {}
        self._by_number: dict[int, socket.socket] = {}
        self._of: dict[int, Port | Client] = {}
        self._poll = select.epoll()
        for port, sock in zip(Port, self._listening):
            self._register(sock, port)

    def _open(self, number: int) -> socket.socket:
        sock = socket.socket(self._family, socket.SOCK_DGRAM)
        try:
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
            sock.bind((self._host, number))
        except OSError as error:
            sock.close()
            where = f"port {number} of {self._host}"
            taken = number and error.errno == errno.EADDRINUSE
            hint = "; another server may be running there: choose other ports with --port (or server::port=...)" if taken else ""
            raise CprmError(f"{where} cannot be used: {error.strerror or error}{hint}") from None
        sock.setblocking(False)
        return sock

    def _register(self, sock: socket.socket, of: Port | Client) -> None:
        number = sock.fileno()
        self._by_number[number], self._of[number] = sock, of
        self._poll.register(number, select.EPOLLIN)

    def _adopt(self, client: Client) -> socket.socket | None:
        """A socket of its own for a new client, connected to where it is."""
        if len(self._sockets) >= MOST_CLIENTS:
            self.server.lose(client)
            return None
        sock = socket.socket(self._family, socket.SOCK_DGRAM)
        try:
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _BUFFER)
            sock.bind((self._host, 0))
            sock.connect(client.address)  # type: ignore[arg-type]
        except OSError:
            sock.close()
            self.server.lose(client)
            return None
        sock.setblocking(False)
        self._sockets[client] = sock
        self._register(sock, client)
        return sock

    # ------------------------------------------------------------------------------------------ moving datagrams

    def receive(self, timeout: float = 0.0) -> int:
        """Wait up to `timeout` seconds for datagrams and give all that are there to the server; how many there were."""
        count = 0
        for _ in range(TURNS):
            came = self._receive_a_turn(timeout)
            if not came:
                break
            count, timeout = count + came, 0.0
        if count:
            self.send()
        return count

    def _receive_a_turn(self, timeout: float) -> int:
        """Wait for datagrams and give one of everybody who sent some to the server; how many there were."""
        count = 0
        datagrams: list[tuple[Client, bytes]] = []
        for number, _ in self._poll.poll(timeout):
            of, sock = self._of.get(number), self._by_number.get(number)
            if sock is None or of is None:
                continue
            try:
                data, address = sock.recvfrom(LARGEST_DATAGRAM)
            except (BlockingIOError, InterruptedError):
                continue
            except OSError as error:
                if isinstance(of, Client) and error.errno in _GONE:
                    self.server.lose(of)
                continue
            count += 1
            if isinstance(of, Client):
                datagrams.append((of, data))
            else:
                self.server.receive(of, address, data)
        if datagrams:
            self.server.receive_many(datagrams)
        return count

    def send(self) -> None:
        """Send what waits in the server's outbox. Nobody is waited for: what a client's socket does not take is dropped."""
        for source, address, data in self.server.take_outbox():
            try:
                if isinstance(source, Port):
                    self._listening[source].sendto(data, address)  # type: ignore[call-overload]
                    continue
                sock = self._sockets.get(source) or (self._adopt(source) if source.connected else None)
                if sock is not None:
                    sock.send(data)
            except (BlockingIOError, InterruptedError):
                self.dropped += 1
            except OSError as error:
                if isinstance(source, Client) and error.errno in _GONE:
                    self.server.lose(source)
                else:
                    self.dropped += 1
        self._forget()

    def _forget(self) -> None:
        """Close the sockets of clients who have left."""
        gone = [client for client in self._sockets if not client.connected]
        for client in gone:
            sock = self._sockets.pop(client)
            number = sock.fileno()
            self._poll.unregister(number)
            del self._by_number[number], self._of[number]
            sock.close()

    def close(self) -> None:
        """Close every socket."""
        for sock in (*self._listening, *getattr(self, "_sockets", {}).values()):
            sock.close()
        if hasattr(self, "_poll"):
            self._poll.close()

    def __enter__(self) -> Transport:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()


def _is_six(host: str) -> bool:
    with contextlib.suppress(ValueError):
        return ipaddress.ip_address(host).version == 6
    return False


# ---------------------------------------------------------------------------------------------- clocks


def run_synchronously(transport: Transport, fast: bool = False, each: Callable[[], bool] = lambda: True) -> None:
    """Lock-step: a cycle ends when everybody is done, or after 1.25 s.

    Parameters
    ----------
    transport : Transport
    fast : bool
        As fast as possible, without the server's short rests before the kick-off, once all 22 players are there, and for monitors.
    each : callable
        Called before every cycle; False ends the match.
    """
    server, windows = transport.server, 0
    while not server.over and each():
        server.step()
        if server.over:
            transport.send()
            return
        server.look_again()
        transport.send()
        windows += 1
        waiting = server.stadium.time == 0 and server.stadium.mode == PlayMode.before_kick_off
        if waiting and not (fast and len(list(server.stadium.players())) == PLAYERS):
            time.sleep(0.05)
        elif not fast and server.stadium.monitors and windows % 32 == 0:
            time.sleep(0.02)
        server.think()
        transport.send()
        deadline = time.monotonic() + PATIENCE
        transport.receive(0.0)
        while not server.is_complete:
            left = deadline - time.monotonic()
            if left <= 0.0:
                break
            transport.receive(left)
        server.close_window(server.is_complete)
        server.look_late()
        transport.send()


def run_in_real_time(transport: Transport, each: Callable[[], bool] = lambda: True) -> Lateness:
    """A cycle every ``simulator_step`` milliseconds; late ones do not shift those after them.

    Parameters
    ----------
    transport : Transport
    each : callable
        Called before every cycle; False ends the match.

    Returns
    -------
    Lateness
        How late the cycles began.
    """
    server = transport.server
    length = server.timetable.cycle / 1000.0
    late = Lateness()
    begin = time.monotonic()
    while not server.over and each():
        for due in server.due:
            _receive_until(transport, begin + due.offset / 1000.0)
            server.send(due)
            transport.send()
        _receive_until(transport, begin + length)
        late.add(time.monotonic() - begin - length)
        server.step(look=False)
        transport.send()
        now = time.monotonic()
        begin += length * max(1, int((now - begin) / length))  # a missed cycle is not made up for
    return late


def _receive_until(transport: Transport, moment: float) -> None:
    """Receive until a moment of the monotonic clock."""
    while True:
        left = moment - time.monotonic()
        if left <= 0.0:
            transport.receive(0.0)
            return
        transport.receive(left)


class Lateness:
    """How late the cycles of a match in real time began.

    Attributes
    ----------
    cycles : int
    late : int
        Cycles that began more than 10 ms late.
    worst : float
        Seconds.
    """

    LIMIT = 0.010

    def __init__(self) -> None:
        self.cycles = self.late = 0
        self.worst = 0.0

    def add(self, seconds: float) -> None:
        """Count a cycle that began so many seconds after its time."""
        self.cycles += 1
        self.late += seconds > self.LIMIT
        self.worst = max(self.worst, seconds)
