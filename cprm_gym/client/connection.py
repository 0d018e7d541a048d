"""A client's socket: it sends to where the last answer came from, as every client of the server does (specification/protocol.md 1)."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from typing import Any

from ..errors import CprmError
from .refusals import refusal

LARGEST_DATAGRAM = 8192
LAST_PORT = 65535
_BUFFER = 1 << 20
MOST_AT_ONCE = 256
"""Datagrams taken from the socket at once."""


class Connection:
    """A UDP socket that talks to one server.

    Parameters
    ----------
    host : str
    port : int
        The well-known port; the server answers an init from another one, to which everything later goes.

    Raises
    ------
    CprmError
        When the host is unknown or the port is none.

    Attributes
    ----------
    refused : bool
        The system said that nobody listens there.
    heard : float
        When the last datagram came (`time.monotonic`).
    """

    def __init__(self, host: str, port: int) -> None:
        if not 0 < port <= LAST_PORT:
            raise CprmError(f"server {host}:{port}: a port is 1 to {LAST_PORT}")
        try:
            family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        except (OSError, OverflowError) as error:
            raise CprmError(f"server {host}:{port}: {error}") from None
        self.place = f"{host}:{port}"
        self.known: Any = address
        self._peer: Any = address
        self.socket = socket.socket(family, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
        self.socket.setblocking(False)
        self._connected = False
        self.refused = False
        self.heard = time.monotonic()

    def fileno(self) -> int:
        """For `select`."""
        return self.socket.fileno()

    def send(self, text: str, known: bool = False) -> None:
        """Send a text with its NUL; `known`: to the well-known port. What cannot be sent is lost, as datagrams may be."""
        try:
            self.socket.sendto(text.encode("latin-1") + b"\0", self.known if known else self._peer)
        except OSError:
            self.refused = True

    def receive(self) -> list[str]:
        """Texts of the datagrams that are there; those that come from another machine than the server are dropped."""
        texts = []
        for _ in range(MOST_AT_ONCE):
            try:
                data, address = self.socket.recvfrom(LARGEST_DATAGRAM)
            except (BlockingIOError, InterruptedError):
                break
            except OSError:
                self.refused = True
                break
            if address[0] != self.known[0]:
                continue
            if address[1] != self.known[1]:
                self._peer = address
            texts.append(data.rstrip(b"\0").decode("latin-1"))
        if texts:
            self.refused, self.heard = False, time.monotonic()
        return texts

    def ask(self, text: str, wanted: Callable[[str], bool], seconds: float, tell: Callable[[str], object] = lambda text: None) -> str:
        """Send `text` to the well-known port, again every second, until an answer comes that is wanted; others are told.

        Raises
        ------
        CprmError
            When none comes, or the server refuses.
        """
        end = time.monotonic() + seconds
        again = 0.0
        while time.monotonic() < end:
            if time.monotonic() >= again:
                self.send(text, known=True)
                again = time.monotonic() + 1.0
            found = None
            for answer in self.receive():
                if found is None and wanted(answer):
                    found = answer
                elif found is None and answer.startswith("(error ") and not answer.startswith("(error only_init"):
                    raise refusal(self.place, text, answer)
                else:
                    tell(answer)
            if found is not None:
                return found
            time.sleep(0.005)
        raise CprmError(f"no answer from {self.place} within {seconds:g} s; is a server running there? `cprm-gym serve` starts one")

    def close(self) -> None:
        """Close the socket."""
        self.socket.close()
