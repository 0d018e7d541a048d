"""What an agent's model was told in a run, as a log from which a model is learned."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ...errors import CprmError, FormatError
from ...files import write_atomically
from ..editing.files import Files
from ..editing.logs import log_text
from .session import Session


class Readings:
    """Writes logs of the run that is watched.

    Parameters
    ----------
    session : Session
    files : Files
        Where files may be written.
    """

    def __init__(self, session: Session, files: Files) -> None:
        self.session, self.files = session, files

    def calls(self) -> Mapping[str, Callable[..., Any]]:
        """What pages may call."""
        return {"readings": self.readings}

    def readings(self, agent: str, path: str) -> dict[str, Any]:
        """Write what an agent's model was told, in the cycles that are kept and in which he was shown in full.

        Parameters
        ----------
        agent : str
        path : str
            Of a new file, with ``.json`` at its end.

        Returns
        -------
        dict
            ``written``, the path; ``slices``, how many.

        Raises
        ------
        FormatError
            For another ending, or a file that is there.
        CprmError
            When the agent has no model, or was not shown.
        """
        target = self.files.inside(path)
        if target.suffix != ".json":
            raise FormatError(f"{path}: a log of readings is written as .json")
        if target.exists():
            raise FormatError(f"{path}: is there already; choose another name")
        with self.session.lock:
            run = self.session.there()
            found = (self.session.frames[cycle] for cycle in self.session.frames if cycle <= run.cycle)
            told = [inner for made in found if (inner := made["agents"].get(agent)) is not None and "beliefs" in inner]
        if not told:
            raise CprmError(f"{agent}: no cycle is kept in which his model was told something")
        try:
            write_atomically(target, log_text([[(inner["evidence"], inner["relations"]) for inner in told]]))
        except OSError as error:
            raise FormatError(f"{path}: cannot be written: {error.strerror or error}") from None
        return {"written": self.files.shown(target), "slices": len(told)}
