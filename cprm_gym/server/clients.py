"""Who is connected: players, online coaches, the trainer, monitors; and what is sent to them (specification/protocol.md 1)."""

from __future__ import annotations

import zlib
from collections.abc import Hashable
from enum import IntEnum
from typing import NamedTuple

from ..simulator.state import LEFT, RIGHT


class Port(IntEnum):
    """The three well-known ports."""

    PLAYER = 0
    """Players and monitors (``port``, 6000)."""
    TRAINER = 1
    """The trainer (``coach_port``, 6001)."""
    COACH = 2
    """Online coaches (``olcoach_port``, 6002)."""


class Refused(Exception):
    """Somebody may not connect; `errors` are the server's words for why."""

    def __init__(self, *errors: str) -> None:
        super().__init__(*errors)
        self.errors = errors


LARGEST_DATAGRAM = 8192
"""Bytes of a datagram that are read."""
LARGEST_INFLATED = 65536
"""Bytes that a compressed datagram may become; more is cut."""


class Client:
    """One connected program, with a socket of its own on the server's side.

    Parameters
    ----------
    address : hashable
        Where it is; what the transport uses, ``(host, port)`` for UDP.
    version : int
        Of its protocol.

    Attributes
    ----------
    connected : bool
        False once it has left or was thrown out; nothing is sent any more.
    compression : int
        Level of zlib, below 0 for plain text.
    done : bool
        ``(done)`` was received since the last step.
    """

    strict = True
    """Whether a datagram without a final NUL is answered by a warning."""

    def __init__(self, address: Hashable, version: int) -> None:
        self.address = address
        self.version = version
        self.connected = True
        self.compression = -1
        self.done = False
        self.copies = 1
        """How often each message is sent: once more for every time that a player connected again who still was."""

    def packed(self, text: str) -> bytes:
        """`text` as the datagram that this client gets: with its NUL, compressed if it wishes."""
        data = text.encode("latin-1", "replace") + b"\0"
        return data if self.compression < 0 else deflated(data, self.compression)

    def unpacked(self, data: bytes) -> tuple[str, bool] | None:
        """Text of a datagram of this client and whether it ended with NUL; None for one that cannot be read."""
        if self.compression >= 0:
            inflated = inflate(data)
            if inflated is None:
                return None
            data = inflated
        text = data.decode("latin-1")
        return text.split("\0", 1)[0], text.endswith("\0")


def deflated(data: bytes, level: int) -> bytes:
    """`data` as a zlib stream of its own, ended by a sync flush."""
    stream = zlib.compressobj(level)
    return stream.compress(data) + stream.flush(zlib.Z_SYNC_FLUSH)


def inflate(data: bytes) -> bytes | None:
    """What a zlib stream of its own holds, at most `LARGEST_INFLATED` bytes; None when it is none."""
    try:
        return zlib.decompressobj().decompress(data, LARGEST_INFLATED)
    except zlib.error:
        return None


class Player(Client):
    """A player.

    Attributes
    ----------
    row : int
        0..10 left, 11..21 right.
    clang : (int, int) or None
        Versions of the coach's language that it understands, once declared.
    """

    def __init__(self, address: Hashable, version: int, row: int) -> None:
        super().__init__(address, version)
        self.row = row
        self.clang: tuple[int, int] | None = None
        self.pending: list[str] = []
        """Words of trainer and coach that wait for the end of the step."""
        self.kept: list[str] = []
        """Messages of what others said in steps after which nobody was told of his body."""

    @property
    def strict(self) -> bool:  # type: ignore[override]
        """Versions from 8 on are warned of a missing NUL and may not use the well-known port again."""
        return self.version >= 8

    @property
    def unum(self) -> int:
        """Uniform number."""
        return self.row % 11 + 1

    @property
    def side(self) -> int:
        """+1 left, -1 right."""
        return LEFT if self.row < 11 else RIGHT


class Official(Client):
    """What trainer and online coach have in common.

    Attributes
    ----------
    eye : bool
        Gets a picture of the whole pitch every cycle.
    """

    def __init__(self, address: Hashable, version: int) -> None:
        super().__init__(address, version)
        self.eye = False

    @property
    def strict(self) -> bool:  # type: ignore[override]
        """As for players."""
        return self.version >= 8


class Trainer(Official):
    """The trainer (offline coach).

    Attributes
    ----------
    ear : bool
        Hears referee and players.
    """

    def __init__(self, address: Hashable, version: int) -> None:
        super().__init__(address, version)
        self.ear = False


class Coach(Official):
    """An online coach.

    Attributes
    ----------
    side : int
        +1 left, -1 right.
    name : str
        His own name, which stands in the names of log files.
    """

    def __init__(self, address: Hashable, version: int, side: int, name: str) -> None:
        super().__init__(address, version)
        self.side, self.name = side, name

    @property
    def letter(self) -> str:
        """``l`` or ``r``."""
        return "l" if self.side == LEFT else "r"


class Monitor(Client):
    """A monitor; version -1 speaks JSON, 1 and 2 are binary."""

    @property
    def strict(self) -> bool:  # type: ignore[override]
        """All but version 1."""
        return self.version != 1


class Outgoing(NamedTuple):
    """A datagram that the server sends."""

    source: Client | Port
    """From the client's own socket, or from a well-known port."""
    address: Hashable
    data: bytes
