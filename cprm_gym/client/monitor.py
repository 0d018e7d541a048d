"""A monitor: the frames of a match that a server plays, as those of a game log."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator

from ..errors import CprmError, FormatError
from ..simulator.gamelog.frames import Frame, GameLogHeader, Message, Team
from ..simulator.gamelog.text import parameter_pairs, parse_show
from ..simulator.state import PlayMode
from .connection import Connection

_STATE = re.compile(r"\(show (\d{1,9}) \(pm (\d{1,3})\) \(tm ([^()]*)\) ")
_MESSAGE = re.compile(r'\(msg (\d{1,9}) (\d{1,3}) "(.*)"\)', re.DOTALL)


def read_frame(text: str) -> Frame:
    """The frame of a ``(show ...)`` message of the monitor protocols 3 to 5.

    Raises
    ------
    FormatError
        When it is none.
    """
    found = _STATE.match(text)
    try:
        if found is None:
            raise ValueError("it does not begin with time, play mode and teams")
        frame = parse_show(f"(show {found[1]} {text[found.end() :]}")
        frame.mode = PlayMode(int(found[2]))
        left, right, *scores = found[3].split()
        numbers = [int(score) for score in scores]
        if len(numbers) not in (2, 6):
            raise ValueError(f"{len(numbers)} scores instead of 2 or 6")
        rest = numbers[2:] or [0, 0, 0, 0]
        frame.left = Team("" if left == "null" else left, numbers[0], rest[0], rest[1])
        frame.right = Team("" if right == "null" else right, numbers[1], rest[2], rest[3])
    except (ValueError, IndexError, KeyError, OverflowError) as error:
        raise FormatError(f"a frame of a monitor cannot be read ({error}): {text[:60]!r}") from None
    return frame


class MonitorConnection:
    """A monitor of protocol 5.

    Parameters
    ----------
    host : str
    port : int
    patience : float
        Seconds for which the first datagram is waited for, and after which silence ends the stream.

    Raises
    ------
    CprmError
        When the server does not answer, or refuses.

    Attributes
    ----------
    header : GameLogHeader
        Parameters and types, as a game log has them.
    """

    def __init__(self, host: str, port: int, patience: float = 10.0) -> None:
        self.header = GameLogHeader(6)
        self._connection = Connection(host, port)
        self._patience = patience
        self._waiting: list[str] = []
        try:
            first = self._connection.ask("(dispinit version 5)", lambda text: text.startswith("(server_param"), patience, self._sort)
            self._sort(first)
            end = time.monotonic() + 2.0
            while time.monotonic() < end and not self._waiting:
                for text in self._connection.receive():
                    self._sort(text)
                time.sleep(0.002)
        except BaseException:
            self._connection.close()
            raise

    def _sort(self, text: str) -> None:
        """A datagram of the beginning: parameters, or the first frame."""
        if not self._take_in(text):
            self._waiting.append(text)

    def _take_in(self, text: str) -> bool:
        """Parameters become the header."""
        kind = text[1 : text.find(" ")]
        if kind not in ("server_param", "player_param", "player_type"):
            return False
        try:
            self.header.add(kind, parameter_pairs(text[len(kind) + 1 :]))
        except ValueError as error:
            raise FormatError(f"the server's {kind} cannot be read: {error}") from None
        return True

    def frames(self) -> Iterator[Frame]:
        """Frames as they come, each with the messages since the one before, until the server falls silent."""
        messages: list[Message] = []
        stoppage, last = 0, -1
        while time.monotonic() - self._connection.heard < self._patience:
            texts, self._waiting = [*self._waiting, *self._connection.receive()], []
            if not texts:
                time.sleep(0.01)
            for text in texts:
                told = _MESSAGE.fullmatch(text)
                if told is not None:
                    messages = [*messages[-99:], Message(int(told[1]), int(told[2]), told[3])]
                elif text.startswith("(show "):
                    frame = read_frame(text)
                    stoppage = stoppage + 1 if frame.time == last else 0
                    last = frame.time
                    frame.stoppage, frame.messages, messages = stoppage, tuple(messages), []
                    yield frame
                elif text.startswith("(error "):
                    raise CprmError(f"the server answers the monitor: {text[7:-1]}")

    def close(self) -> None:
        """Say goodbye."""
        self._connection.send("(dispbye)")
        self._connection.close()

    def __enter__(self) -> MonitorConnection:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
