"""A game log as a run that can only be looked at."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...errors import CprmError, FormatError, ParameterError
from ...simulator.gamelog.frames import Frame
from ...simulator.gamelog.reader import GameLogReader
from ...simulator.pitch import HALF_LENGTH, HALF_WIDTH
from ...viewing.pictures import world_of as world_record
from .frames import Message, world_of

MOST = 20_000
"""Frames of a log that are read: more than two matches."""


class Recording:
    """A match from a log; its cycles are the frames, counted from 0.

    Parameters
    ----------
    path : Path

    Raises
    ------
    FormatError
        When it is no game log, an empty one, or longer than `MOST` frames.
    """

    agents: tuple[str, ...] = ()
    over = False

    def __init__(self, path: Path) -> None:
        self.path = path
        reader = GameLogReader(path)
        self.header = reader.header
        self._pictures: list[Frame] = []
        for frame in reader:
            self._pictures.append(frame)
            if len(self._pictures) > MOST:
                raise FormatError(f"{path}: more than the {MOST:,} frames that are read")
        if not self._pictures:
            raise FormatError(f"{path}: holds no frame")
        self.cycle = 0

    def __len__(self) -> int:
        return len(self._pictures)

    def about(self) -> dict[str, Any]:
        """What does not change from frame to frame."""
        first = self._pictures[-1]
        teams = f"{first.left.name or 'left'} - {first.right.name or 'right'}"
        return {
            **{
                "task": teams,
                "controller": "",
                "seed": 0,
                "world": 0,
                "disturbance": None,
                "changed": [],
                "agents": [],
                "counts": [11, 11],
            },
            "region": [HALF_LENGTH, HALF_WIDTH],
            "models": [],
            "max_cycles": len(self) - 1,
            "goal_width": float(self.header.parameters().goal_width),
            "keepable": False,
            "recorded": str(self.path),
        }

    def picture(self, cycle: int | None = None) -> Message:
        """The frame of a cycle; of the present one if not given."""
        at = self.cycle if cycle is None else cycle
        frame = self._pictures[at]
        world = world_of(world_record(frame)[0], (11, 11))
        world["score"] = [frame.left.score, frame.right.score]
        return {
            **{
                "cycle": at,
                "status": "RECORDED",
                "success": False,
                "trouble": "",
                "struck": -1,
                "commands": {},
                "changes": [],
                "agents": {},
            },
            "over": at == len(self) - 1,
            "world": world,
        }

    def advance(self) -> None:
        """The next frame.

        Raises
        ------
        CprmError
            At the end.
        """
        if self.cycle + 1 >= len(self):
            raise CprmError(f"{self.path}: the log ends here")
        self.cycle += 1
        self.over = self.cycle == len(self) - 1

    def go_to(self, cycle: int, told: Callable[[int], object] = lambda cycle: None) -> None:
        """Stand in another frame.

        Raises
        ------
        ParameterError
            When there is no such frame.
        """
        if isinstance(cycle, bool) or not isinstance(cycle, int) or not 0 <= cycle < len(self):
            raise ParameterError(f"cycle: 0 to {len(self) - 1}, got {cycle!r}")
        self.cycle, self.over = cycle, cycle == len(self) - 1
        told(cycle)
