"""Messages of many players at once, as bytes: what `messages` writes one by one, to the byte, by one kernel call."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..kernels import body
from ..simulator import Simulator
from ..state import PLAYERS
from .commands import nothing
from .kernels.bodies import tell_bodies
from .kernels.intake import execute_datagrams
from .kernels.sights import new_scratch, tell_sights
from .kernels.words import coded
from .messages import NEWEST_PROTOCOL, see_text, sense_body_text

LONGEST = 1 << 13
"""Bytes of a message; the longest see has some 3,000."""


class BulkMessages:
    """Writes the messages of one world's players.

    Parameters
    ----------
    sim : Simulator
        Of one world.
    """

    def __init__(self, sim: Simulator) -> None:
        self._sim = sim
        self._out: np.ndarray = np.zeros(PLAYERS * LONGEST, np.uint8)
        self._ends: np.ndarray = np.zeros(PLAYERS, np.int64)
        self._row: np.ndarray = np.zeros(body.COLUMNS)
        self._scratch = new_scratch()
        self._named: tuple[str, str] | None = None
        self._names: np.ndarray
        self._lengths: np.ndarray

    def bodies(self, rows: Sequence[int]) -> list[bytes]:
        """sense_body messages, with their NUL, of the players `rows` (0..21)."""
        chosen = np.array(rows, np.int64)
        tell_bodies(self._sim.world, self._sim.packed, chosen, NEWEST_PROTOCOL, self._row, self._out, self._ends)
        return self._cut(rows, lambda row: sense_body_text(self._sim, 0, row + 1))

    def sights(self, rows: Sequence[int], message: int = 0) -> list[bytes]:
        """see messages, with their NUL; `message` as for `see_text`."""
        self._know_names()
        chosen = np.array(rows, np.int64)
        tell_sights(
            self._sim.world, self._sim.packed, chosen, NEWEST_PROTOCOL, message, self._names, self._lengths, self._scratch, self._out,
            self._ends,
        )  # fmt: skip
        return self._cut(rows, lambda row: see_text(self._sim, 0, row + 1, message=message))

    def _cut(self, rows: Sequence[int], slowly: object) -> list[bytes]:
        """The messages one by one; those that the kernel left are written as text."""
        at, told = 0, []
        for row, end in zip(rows, self._ends.tolist()):
            if end < 0:
                told.append(slowly(row).encode("latin-1", "replace") + b"\0")  # type: ignore[operator]
                continue
            told.append(self._out[at:end].tobytes())
            at = end
        return told

    def _know_names(self) -> None:
        """What each side calls each team."""
        sim = self._sim
        if self._named == sim.team_names:
            return
        self._named = sim.team_names
        left, right = sim.team_names
        fixed_left, fixed_right = sim.parameters.fixed_teamname_l or left, sim.parameters.fixed_teamname_r or right
        table, lengths = coded((left, fixed_right, fixed_left, right))
        self._names, self._lengths = table.reshape(2, 2, -1), lengths.reshape(2, 2)


class BulkCommands:
    """Executes datagrams of one world's players, as far as they hold plain commands.

    Parameters
    ----------
    sim : Simulator
        Of one world.
    """

    def __init__(self, sim: Simulator) -> None:
        self._sim = sim
        self._blank, self._record = nothing(), nothing()

    def execute(self, rows: Sequence[int], texts: Sequence[bytes]) -> tuple[list[int], list[bool]]:
        """Execute datagrams in order, up to the first that is not read to its end or makes the referee say something.

        Parameters
        ----------
        rows : sequence of int
            0..21, whose they are.
        texts : sequence of bytes
            Without NUL.

        Returns
        -------
        (list of int, list of bool)
            For those that were dealt with: how many bytes were read, and whether ``(done)`` was among them. What stands behind the bytes
            read has not been executed.
        """
        ends = np.cumsum([len(text) for text in texts])
        starts = np.concatenate([[0], ends[:-1]])
        reached, done = np.zeros(len(texts), np.int64), np.zeros(len(texts), np.bool_)
        count = execute_datagrams(
            self._sim.world, self._sim.packed, np.array(rows, np.int64), np.frombuffer(b"".join(texts), np.uint8), starts, ends,
            self._blank, self._record, reached, done,
        )  # fmt: skip
        return (reached - starts)[:count].tolist(), done[:count].tolist()
