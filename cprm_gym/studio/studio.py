"""What one start of the studio holds: what was named on the command line, and the rooms whose functions a page calls."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..agents.demos import DEMOS, OPTIONS
from ..architecture.cprm import CPRM
from ..architecture.petri import PetriNet
from ..envs.core import select_agents
from ..envs.others.registry import controller_entries
from ..errors import unknown_name
from .calls import Calls
from .editing.desk import Desk
from .editing.models import Models
from .editing.token_game import Games
from .playing.results import Results
from .playing.room import RunRoom
from .running.recording import Recording
from .running.setup import WITH_MODEL, Setup
from .watching.comparison import Comparison
from .watching.curves import Curves
from .watching.debugger import Debugger
from .watching.readings import Readings
from .watching.session import Session
from .watching.typing import Typing

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
        self.title = f"demo {demo}" if demo else file or (log.name if log is not None else "studio")
        self.calls = Calls()
        results = Results(log) if log is not None and log.is_dir() else None
        setup = None if demo is None else Setup(DEMOS[demo], seed=seed, options=OPTIONS.get(demo, {}))
        self.session = Session(publish, setup)
        if log is not None and results is None:
            self.session.look_at(Recording(log))
        self.calls.add("studio", {"about": self.about})
        self.calls.add("watch", self.session.calls())
        self.debugger = Debugger(self.session, breakpoint_file(file))
        self.calls.add("watch", self.debugger.calls())
        self.calls.add("watch", Comparison(self.session).calls())
        self.calls.add("watch", Curves(self.session).calls())
        self.calls.add("watch", Typing(self.session).calls())
        self.playing = RunRoom(self.session, self.edited_nets, lambda: self.desk.models(), results, state_folder() / "run.json")
        self.calls.add("run", self.playing.calls())
        self.desk = Desk(publish, Path.cwd())
        self.calls.add("edit", self.desk.calls())
        self.calls.add("watch", Readings(self.session, self.desk.files).calls())
        self.calls.add("model", Models(self.desk).calls())
        self.calls.add("game", Games(lambda id, definition: self.desk.document(id).definition(definition)).calls())
        if file is not None:
            self.desk.open_named(file)
        if setup is not None:
            self.desk.begin_with(lambda: self._agents(setup))

    def about(self) -> dict[str, Any]:
        """What was opened."""
        watched = self.session.setup is not None or self.session.recording is not None
        view = "nets" if self.file else "watch" if watched else "run"
        return {"title": self.title, "view": view, "controllers": [WITH_MODEL, *controller_entries()]}

    def _agents(self, setup: Setup) -> None:
        """Open the CPRM of the first player that has one, to be changed."""
        task = setup.made()
        for agent in select_agents(task.controlled, task.left, task.right):
            cprm = getattr(setup.player(task, agent), "cprm", None)
            if isinstance(cprm, CPRM):
                self.desk.add(cprm.name, cprm, f"new:{cprm.name}")
                return

    def edited_nets(self) -> dict[str, PetriNet]:
        """The nets that are open in the editor, by their names."""
        return self.desk.nets()

    def close(self) -> None:
        """End what runs."""
        self.playing.close()
        self.session.close()
        self.desk.close()


def breakpoint_file(file: str | None) -> Path:
    """Where breakpoints are kept: beside the file that was opened; of nets that ship, in the folder of the user's state."""
    if file is not None and Path(file).is_file():
        path = Path(file)
        return path.with_name(f"{path.stem}.breakpoints.json")
    return state_folder() / "breakpoints.json"


def state_folder() -> Path:
    """Where what belongs to nobody's file is kept from one start to the next."""
    state = os.environ.get("XDG_STATE_HOME") or str(Path.home() / ".local" / "state")
    return Path(state) / "cprm_gym"
