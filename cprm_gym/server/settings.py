"""What a server is started with: parameters given as words or in the server's own files (specification/parameters.md)."""

from __future__ import annotations

import dataclasses
import os
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from ..errors import FormatError, ParameterError
from ..files import read_bounded
from ..simulator.parameter_fields import ParameterSet, value_of
from ..simulator.parameters import ServerParameters
from ..simulator.player_types import PlayerParameters, PlayerType, generate_types

LARGEST_FILE, LARGEST_COACH_MESSAGE = 1 << 20, 4096
_WORD = re.compile(r"\s*(?:(?P<module>[A-Za-z_]+)::)?(?P<name>[A-Za-z_]\w*)\s*=\s*(?P<value>.*?)\s*", re.DOTALL)
_MODULES = ("server", "player")
_PASSED_OVER = ("CSVSaver",)
"""Modules of the server whose parameters have no meaning here."""


@dataclasses.dataclass(frozen=True)
class Settings:
    """Parameters of a server.

    Attributes
    ----------
    server, player : parameters
    types : tuple of PlayerType
        Drawn from ``player::random_seed``, or from `seed` when that is negative.
    """

    server: ServerParameters = dataclasses.field(default_factory=ServerParameters)
    player: PlayerParameters = dataclasses.field(default_factory=PlayerParameters)
    types: tuple[PlayerType, ...] = ()
    coach_message: str = ""
    """What coaches from version 11 on are told when they connect; the content of ``coach_msg_file``."""

    def __post_init__(self) -> None:
        if not self.types:
            drawn = self.player.random_seed
            object.__setattr__(self, "types", generate_types(self.server, self.player, drawn if drawn >= 0 else 0))

    @classmethod
    def from_words(cls, words: Iterable[str] = (), files: Iterable[str | os.PathLike[str]] = (), seed: int = 0) -> Settings:
        """Settings from files, then words, later ones over earlier ones.

        Parameters
        ----------
        words : iterable of str
            ``server::half_time=10``, ``player::player_types=1``.
        files : iterable of path
            ``server.conf`` and ``player.conf``: lines ``server::name = value`` or ``name = value``, ``#`` begins a comment.
        seed : int
            For the player types, when ``player::random_seed`` does not give one.

        Raises
        ------
        ParameterError
            For a word that is none, an unknown name or a value not allowed.
        FormatError
            For a file that cannot be read; the message names the line.
        """
        values: dict[str, dict[str, Any]] = {"server": {}, "player": {}}
        for path in files:
            _read_file(Path(path), values)
        for word in words:
            _take(word, None, values)
        server, player = ServerParameters(**values["server"]), PlayerParameters(**values["player"])
        drawn = player.random_seed
        told = read_bounded(server.coach_msg_file, LARGEST_COACH_MESSAGE).decode("latin-1") if server.coach_msg_file else ""
        return cls(server, player, generate_types(server, player, drawn if drawn >= 0 else seed), told)


def _read_file(path: Path, values: dict[str, dict[str, Any]]) -> None:
    """Take over the lines of a file; its name tells the module of lines that do not say it."""
    text = read_bounded(path, LARGEST_FILE).decode("utf-8", "replace")
    module = "player" if path.name.startswith("player") else "server"
    for number, line in enumerate(text.splitlines(), 1):
        line = line.split("#", 1)[0].strip()
        if line:
            try:
                _take(line, module, values)
            except ParameterError as error:
                raise FormatError(f"{path}, line {number}: {error}") from None


def _take(word: str, module: str | None, values: dict[str, dict[str, Any]]) -> None:
    """Take over one ``module::name=value``."""
    found = _WORD.fullmatch(word)
    if found is None:
        raise ParameterError(f"a parameter is given as server::name=value or player::name=value, got {word[:80]!r}")
    module = found["module"] or module
    if module in _PASSED_OVER:
        return
    if module not in _MODULES:
        raise ParameterError(f"{word[:80]!r}: a parameter belongs to {' or '.join(f'{name}::' for name in _MODULES)}")
    kind: type[ParameterSet] = ServerParameters if module == "server" else PlayerParameters
    field = kind._field_named(found["name"])
    value = found["value"].strip("'\"")
    if field.metadata["kind"] == "flag" and value.lower() in ("yes", "no"):
        value = {"yes": "true", "no": "false"}[value.lower()]
    values[module][found["name"]] = value_of(field, value, f"{module} parameter")
