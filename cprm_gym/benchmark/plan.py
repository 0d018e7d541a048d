"""What a benchmark is to measure, cut into blocks, and what a block gave."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any, TypeVar

from ..client.remote import server_place
from ..envs.others.registry import controller_entries, split_options
from ..envs.tasks import TASKS
from ..errors import CprmError, ParameterError, unknown_name
from ..files import write_atomically

Kind = TypeVar("Kind")
BLOCK = 125
"""Episodes played as one batch; a fixed number, so that results do not depend on the number of workers."""


def write_plan(plan: Any, folder: Path) -> None:
    """Note in a folder what is to be played there (``plan.json``): the fields of a dataclass."""
    write_atomically(folder / "plan.json", json.dumps(asdict(plan), indent=2) + "\n")


def read_plan(kind: type[Kind], folder: Path, of: str) -> Kind:
    """The plan that `write_plan` noted.

    Parameters
    ----------
    kind : type
        Its dataclass.
    folder : Path
    of : str
        What is planned, for messages.

    Raises
    ------
    CprmError
        When there is none, or it cannot be read.
    """
    path = folder / "plan.json"
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        return kind(**{key: tuple(value) if isinstance(value, list) else value for key, value in data.items()})
    except FileNotFoundError:
        raise CprmError(f"{folder}: there is no plan.json; the folder of an interrupted {of} is needed") from None
    except CprmError as error:
        raise CprmError(f"{path}: {error}") from None
    except (OSError, ValueError, TypeError, AttributeError, RecursionError) as error:
        raise CprmError(f"{path}: not the plan of a {of}: {error}") from None


@dataclass(frozen=True)
class Plan:
    """What is to be measured.

    Raises
    ------
    UnknownName
        For a task or controller that does not exist; the message lists those that do.
    ParameterError
        For a number that makes no sense; the message names it, what was given and what is allowed.
    """

    tasks: tuple[str, ...] = ("GoToBall",)
    controllers: tuple[str, ...] = ("cprm", "fsm", "random")
    episodes: int = 500
    seed: int = 0
    backend: str = ""
    """In process, or on the server ``udp://host:port``, one episode after the other."""

    def __post_init__(self) -> None:
        if self.backend:
            server_place(self.backend)
        for kind, names, known in (("task", self.tasks, list(TASKS)), ("controller", self.controllers, list(controller_entries()))):
            if not names:
                raise ParameterError(f"{kind}s: none given; known are {', '.join(known)}")
            for i, name in enumerate(names):
                if (split_options(name)[0] if kind == "controller" else name) not in known:
                    raise unknown_name(kind, name, known)
                if name in names[:i]:
                    raise ParameterError(f"{kind} {name!r} is named twice")
        for number, value, least in (("episodes", self.episodes, 1), ("seed", self.seed, 0)):
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise ParameterError(f"{number}: {value!r} given, a whole number of at least {least} is needed")

    def blocks(self) -> list[Block]:
        """All blocks, in the order of the report."""
        return [
            Block(task, controller, first, min(BLOCK, self.episodes - first), self.seed, self.backend)
            for task in self.tasks
            for controller in self.controllers
            for first in range(0, self.episodes, BLOCK)
        ]

    def write(self, folder: Path) -> None:
        """Note in the folder of a run what is to be played there (``plan.json``)."""
        write_plan(self, folder)

    @classmethod
    def read(cls, folder: Path) -> Plan:
        """The plan noted by `write`.

        Raises
        ------
        CprmError
            When there is none, or it cannot be read.
        """
        return read_plan(cls, folder, "run")


@dataclass(frozen=True)
class Block:
    """Episodes ``first ... first + count - 1`` of one task and controller."""

    task: str
    controller: str
    first: int
    count: int
    seed: int
    backend: str = field(default="", repr=False)


@dataclass
class BlockResult:
    """What a block gave, or the error that its controller raised."""

    block: Block
    success: list[bool] = field(default_factory=list)
    cycles: list[int] = field(default_factory=list)
    """Cycles of each episode until success, other end or time-out."""
    reward: list[float] = field(default_factory=list)
    error: str | None = None
    wall_seconds: float = 0.0
    controller_seconds: float = 0.0
    """CPU seconds inside the controller."""
    decisions: int = 0
    played: int = 0
    """Cycles of worlds simulated."""
    more: dict[str, Any] = field(default_factory=dict)
    """What else was measured, in JSON's own types."""

    def to_json(self) -> str:
        """One line of ``episodes.jsonl``."""
        data = asdict(self)
        if not self.block.backend:
            del data["block"]["backend"]
        if not self.more:
            del data["more"]
        return json.dumps(data)

    @classmethod
    def from_json(cls, line: str) -> BlockResult:
        """The result written by `to_json`.

        Raises
        ------
        ValueError
            When the line is not the whole result of a block: the message says what is wrong.
        """
        try:
            data = json.loads(line, parse_constant=_refuse)
        except RecursionError:
            raise ValueError("nested too deeply") from None
        if isinstance(data, Mapping) and "more" not in data:
            data = {**data, "more": {}}
        values = _entries(data, cls, "result")
        block = values["block"]
        if isinstance(block, Mapping) and "backend" not in block:  # of before there were backends
            block = {**block, "backend": ""}
        made = cls(**{**values, "block": Block(**_entries(block, Block, "block"))})
        made.check()
        return made

    def check(self) -> None:
        """Refuse what no block can have given, with a `ValueError` that names the entry."""
        block = self.block
        for name, kind in (("task", str), ("controller", str), ("first", int), ("count", int), ("seed", int), ("backend", str)):
            if type(getattr(block, name)) is not kind:
                raise ValueError(f"{name} is {getattr(block, name)!r}, expected {kind.__name__}")
        if self.error is not None:
            raise ValueError("the block ended in an error")
        if not isinstance(self.more, dict):
            raise ValueError(f"more is {self.more!r}, expected an object")
        for name, kinds in (("success", (bool,)), ("cycles", (int,)), ("reward", (int, float))):
            values = getattr(self, name)
            if not isinstance(values, list) or len(values) != block.count:
                size = f"{len(values)} entries" if isinstance(values, list) else f"{values!r}"
                raise ValueError(f"{name} has {size}, expected a list of {block.count}")
            for value in values:
                if type(value) not in kinds or not math.isfinite(value) or (name == "cycles" and value < 1):
                    raise ValueError(f"{name} holds {value!r}")
        for name in ("wall_seconds", "controller_seconds", "decisions", "played"):
            value = getattr(self, name)
            if type(value) not in (int, float) or not (math.isfinite(value) and value >= 0):
                raise ValueError(f"{name} is {value!r}, expected a number of at least 0")


def _refuse(constant: str) -> Any:
    raise ValueError(f"{constant} is no number of a result")


def _entries(data: Any, kind: type, what: str) -> dict[str, Any]:
    """`data`, if it has just the entries of a dataclass."""
    names = [f.name for f in fields(kind)]
    if not isinstance(data, Mapping):
        raise ValueError(f"the {what} is {type(data).__name__}, expected an object")
    if set(data) != set(names):
        wrong = sorted(set(names) - set(data)) or sorted(map(str, set(data) - set(names)))
        raise ValueError(f"the {what} {'lacks' if set(names) - set(data) else 'has unknown'} {', '.join(wrong)}")
    return dict(data)
