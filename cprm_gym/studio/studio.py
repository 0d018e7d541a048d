"""What one start of the studio holds: what was named on the command line, and the rooms whose functions a page calls."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..agents.demos import DEMOS, OPTIONS
from ..errors import unknown_name
from .calls import Calls
from .running.setup import Setup
from .watching.session import Session

Publish = Callable[..., None]


class Studio:
    """Everything behind a page.

    Parameters
    ----------
    publish : callable
        Tells all pages of an event: (name, content, passing=False).
    file, demo, log, seed
        Of the command line (`command.studio`).

    Attributes
    ----------
    calls : Calls
        What pages may call; each room adds its own.
    session : Session
        The run that is watched.

    Raises
    ------
    CprmError
        For what cannot be opened.
    """

    def __init__(
        self, publish: Publish, *, file: str | None = None, demo: str | None = None, log: Path | None = None, seed: int = 0
    ) -> None:
        if demo is not None and demo not in DEMOS:
            raise unknown_name("demonstration", demo, DEMOS)
        self.publish, self.file, self.log = publish, file, log
        self.title = f"demo {demo}" if demo else str(file or log or "studio")
        self.calls = Calls()
        setup = None if demo is None else Setup(DEMOS[demo], seed=seed, options=OPTIONS.get(demo, {}))
        self.session = Session(publish, setup)
        self.calls.add("studio", {"about": self.about})
        self.calls.add("watch", self.session.calls())

    def about(self) -> dict[str, Any]:
        """What was opened."""
        return {"title": self.title, "view": "watch" if self.session.setup else "run", "nets": [], "models": []}

    def close(self) -> None:
        """End what runs."""
        self.session.close()
