"""The folder of a run: finished blocks, one a line, kept by one process at a time."""

from __future__ import annotations

import lzma
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

from filelock import FileLock, Timeout

from ..errors import CprmError
from ..files import write_atomically
from .plan import Block, BlockResult

PACKED = ".xz"
"""Behind the name of a journal that is kept compressed."""
LARGEST = 500_000_000
"""Bytes that a packed journal may take unpacked."""


class Planned(Protocol):
    """What is being played, cut into blocks."""

    def blocks(self) -> list[Block]:
        """All of them."""


class Journal:
    """``episodes.jsonl`` of a run.

    Parameters
    ----------
    path : Path
        Made with the first block.
    plan : Planned, optional
        What is being played: blocks that are not in it are refused.
    """

    def __init__(self, path: Path, plan: Planned | None = None) -> None:
        self.path = path
        self._planned = None if plan is None else set(plan.blocks())

    @contextmanager
    def held(self) -> Iterator[None]:
        """For this process alone, until it ends, however it ends.

        Raises
        ------
        CprmError
            When another process has it.
        """
        lock = FileLock(self.path.with_suffix(".lock"), timeout=0)
        try:
            lock.acquire()
        except Timeout:
            raise CprmError(f"{self.path.parent}: another process is playing the run of this folder") from None
        try:
            yield
        finally:
            lock.release()

    def append(self, result: BlockResult) -> None:
        """Note a finished block."""
        with self.path.open("a", encoding="utf-8") as file:
            file.write(result.to_json() + "\n")

    def cut_torn_line(self) -> None:
        """Remove a last line that an interruption left unfinished, so that the next one begins on its own; unpack what is packed."""
        if not self.path.exists() and self._packed.exists():
            write_atomically(self.path, self._text())
        if self.path.exists():
            content = self.path.read_bytes()
            whole = content.rfind(b"\n") + 1
            if whole < len(content):
                with self.path.open("r+b") as file:
                    file.truncate(whole)

    def pack(self, path: Path) -> None:
        """Write it to another file, compressed; a journal of that name with ``.xz`` behind it is read where it is not there itself."""
        write_atomically(path, lzma.compress(self._text().encode("utf-8"), preset=9))

    @property
    def _packed(self) -> Path:
        return self.path.with_name(self.path.name + PACKED)

    def _text(self) -> str:
        if self.path.exists() or not self._packed.exists():
            return self.path.read_text(encoding="utf-8", errors="replace") if self.path.exists() else ""
        try:
            with lzma.open(self._packed) as file:
                content = file.read(LARGEST + 1)
        except (lzma.LZMAError, EOFError) as error:
            raise CprmError(f"{self._packed}: not a packed journal: {error}") from None
        if len(content) > LARGEST:
            raise CprmError(f"{self._packed}: unpacked it is larger than {LARGEST:,} bytes, which are allowed")
        return content.decode("utf-8", errors="replace")

    def read(self) -> dict[Block, BlockResult]:
        """The finished blocks; a last line cut short by an interruption is left out.

        Raises
        ------
        CprmError
            When another line cannot be read, is not whole, is not of the plan or stands there twice; the message names file and line.
        """
        lines = self._text().split("\n")
        found: dict[Block, BlockResult] = {}
        for number, line in enumerate(lines, 1):
            if not line.strip():
                continue
            try:
                result = BlockResult.from_json(line)
                if self._planned is not None and result.block not in self._planned:
                    raise ValueError(f"{result.block} is not part of the plan")
                if result.block in found:
                    raise ValueError(f"{result.block} stands there twice")
            except ValueError as error:
                if number == len(lines):
                    break
                raise CprmError(f"{self.path}, line {number}: not a result of a block: {error}") from error
            found[result.block] = result
        return found
