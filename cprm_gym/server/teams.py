"""Teams that a server starts itself: a command for each side, ended with the match."""

from __future__ import annotations

import contextlib
import os
import shlex
import signal
import subprocess
from collections.abc import Mapping

from ..errors import CprmError

_WAIT = 3.0
"""Seconds that a team has to end by itself."""


class TeamProcess:
    """A team's start command and its processes.

    Parameters
    ----------
    command : str
        Words as in a shell, without its operators; ``{host}``, ``{port}`` and ``{coach_port}`` are filled in.
    places : mapping of str to object
        What to fill in.

    Raises
    ------
    CprmError
        When the command cannot be started.
    """

    def __init__(self, command: str, places: Mapping[str, object]) -> None:
        for name, value in places.items():
            command = command.replace(f"{{{name}}}", str(value))
        self.command = command
        try:
            words = shlex.split(command)
        except ValueError as error:
            raise CprmError(f"{command!r}: not a command: {error}") from None
        if not words:
            raise CprmError("the command that starts a team is empty")
        try:
            self._process = subprocess.Popen(words, start_new_session=True, stdin=subprocess.DEVNULL)
        except OSError as error:
            raise CprmError(f"{command!r} cannot be started: {error.strerror or error}") from None

    @property
    def ended(self) -> int | None:
        """Exit status of the command, None while it runs. A start script may end while its players go on."""
        return self._process.poll()

    def stop(self) -> None:
        """End the command and everything that it started in its session."""
        for word in (signal.SIGTERM, signal.SIGKILL):
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(self._process.pid, word)
            try:
                self._process.wait(_WAIT)
            except subprocess.TimeoutExpired:
                continue
            if word == signal.SIGTERM and self._is_alone():
                return

    def _is_alone(self) -> bool:
        """Whether nothing of the session is left."""
        try:
            os.killpg(self._process.pid, 0)
        except (ProcessLookupError, PermissionError):
            return True
        return False
