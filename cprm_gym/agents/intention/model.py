"""What the holder of the ball is about to do: a relational model whose CPDs are learned from logged play.

    possesses(o, b):  prev.o.mode --> o.mode --> b.touch          what was done to the ball tells what he has in mind
                                      o.mode, situation --> o.due  when he shoots
                                      o.mode, view --> o.line      where the shot crosses the goal line
                                      drive --> o.pace             how fast the ball then is

What he has in mind is hidden and lasts: `possesses` links it in time (dissertation §2.3.5, Fig. 2.28). The leaves of three trees of
questions are what is given of the situation, of what he sees open, and of what drives the ball.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ...architecture.prm.model.cpds import Dense
from ...architecture.prm.model.domains import Bins, Labels
from ...architecture.prm.model.model import Model
from ...architecture.prm.model.schema import Attribute, Given, PRMClass, Relation, Replace, prev
from ...errors import FormatError, unknown_name
from .situation import FEATURES, TOUCHES, VIEW
from .tree import Tree

TABLES = Path(__file__).parent / "tables"
"""Learned tables, one file for each kind of play; ``python -m cprm_gym.benchmark.demonstrations.learning`` makes them."""
MODES = ("dribble", "feint left", "feint right", "pass", "shoot", "shoot left", "shoot right")
"""What a holder has in mind; a feint, and a shot after one, with the side (y grows to the left of who faces the other goal)."""
DUE = ("1", "2", "3", "4", "5", "later")
"""Cycles until he shoots: "1" is the kick of the cycle that comes."""
LINE = Bins((-9.0, -7.0, -5.5, -4.0, -2.0, 0.0, 2.0, 4.0, 5.5, 7.0, 9.0), unit="m", clip=True)
"""y at which a shot crosses the goal line."""
PACE = Bins((1.0, 1.4, 1.6, 1.8, 2.0, 2.2, 2.4, 2.6, 2.8, 3.0), unit="m/cycle", clip=True)
"""Speed of the ball after a shot."""
POSSESSES = "possesses"
"""The relation of a holder to the ball."""
RULES = {"begin": ("o.mode", "initial"), "mode": ("o.mode", "cpd"), "touch": ("b.touch", "cpd"), "due": ("o.due", "cpd"),
         "line": ("o.line", "cpd"), "pace": ("o.pace", "cpd")}  # fmt: skip
"""Table -> target and part of the change of `POSSESSES` that has it."""


@dataclass(frozen=True, eq=False)
class Intention:
    """Trees and tables.

    Attributes
    ----------
    situations : Tree
        Sorts `situation` into leaves.
    views : Tree
        Sorts `view` into leaves.
    drives : Tree
        Sorts `view` and `situation`, side by side, into leaves.
    tables : dict of str to array
        ``begin`` (M,), ``mode`` (M, M), ``touch`` (M, T), ``due`` (M, S, D), ``line`` (M, V, L), ``pace`` (R, P).
    source : str
        How they were learned.
    """

    situations: Tree
    views: Tree
    drives: Tree
    tables: Mapping[str, np.ndarray]
    source: str = ""

    def __post_init__(self) -> None:
        m, s, v = len(MODES), self.situations.leaves, self.views.leaves
        shapes = {
            "begin": (m,), "mode": (m, m), "touch": (m, len(TOUCHES)), "due": (m, s, len(DUE)), "line": (m, v, len(LINE)),
            "pace": (self.drives.leaves, len(PACE)),
        }  # fmt: skip
        for name, shape in shapes.items():
            if name not in self.tables or np.shape(self.tables[name]) != shape:
                raise FormatError(f"intention: table {name!r} has shape {np.shape(self.tables.get(name, ()))}, needed is {shape}")

    def to_json(self) -> str:
        """As text; probabilities to four digits."""
        data = {
            "source": self.source, "features": list(FEATURES), "view": list(VIEW),
            "situations": self.situations.to_dict(), "views": self.views.to_dict(), "drives": self.drives.to_dict(),
            "tables": {name: np.round(table, 4).tolist() for name, table in self.tables.items()},
        }  # fmt: skip
        return json.dumps(data, separators=(",", ":")) + "\n"

    @classmethod
    def of(cls, text: str) -> Intention:
        """Of the text that `to_json` made; rows are made whole again.

        Raises
        ------
        FormatError
            For what is no such text, or of other features.
        """
        try:
            data: Any = json.loads(text)
            if (tuple(data["features"]), tuple(data["view"])) != (FEATURES, VIEW):
                raise FormatError(f"intention: learned from {data['features']} and {data['view']}, not from {FEATURES} and {VIEW}")
            tables = {name: np.array(table, float) for name, table in data["tables"].items()}
            tables = {name: table / table.sum(axis=-1, keepdims=True) for name, table in tables.items()}
            situations, views, drives = (Tree.of(data[name]) for name in ("situations", "views", "drives"))
            return cls(situations, views, drives, tables, str(data["source"]))
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            raise FormatError(f"intention: not learned tables: {error}") from None

    def model(self) -> Model:
        """The relational model with these tables."""
        return intention_model(self.situations.leaves, self.views.leaves, self.drives.leaves, self.tables)


def learned(play: str) -> Intention:
    """The tables learned from a kind of play.

    Parameters
    ----------
    play : str
        ``shooter``: the task Goalie; ``attackers``: attackers who mix.

    Raises
    ------
    UnknownName
        Listing those there are.
    """
    known = sorted(path.stem for path in TABLES.glob("*.json"))
    if play not in known:
        raise unknown_name("kind of play", play, known)
    return _read(TABLES / f"{play}.json")


@lru_cache(maxsize=8)
def _read(path: Path) -> Intention:
    return Intention.of(path.read_text(encoding="utf-8"))


def intention_model(situations: int, views: int, drives: int, tables: Mapping[str, np.ndarray]) -> Model:
    """Ball, opponents, and `POSSESSES` between them.

    Parameters
    ----------
    situations, views, drives : int
        Leaves of the trees.
    tables : dict of str to array
        As in `Intention`.
    """
    kinds = Labels(tuple(f"s{k}" for k in range(situations)))
    opens, forces = Labels(tuple(f"v{k}" for k in range(views))), Labels(tuple(f"r{k}" for k in range(drives)))
    modes, due, touches = Labels(MODES), Labels(DUE), Labels(TOUCHES)

    def without(states: int, usual: int) -> Dense:
        return Dense(np.where(np.arange(states) == usual, 1.0 - 0.01 * (states - 1), 0.01))

    opponent = PRMClass(
        "Opponent",
        given=(Given("situation", kinds, "s0"), Given("view", opens, "v0"), Given("drive", forces, "r0")),
        attributes=(
            Attribute("mode", modes, Dense(tables["begin"])),
            Attribute("due", due, without(len(DUE), len(DUE) - 1)),
            Attribute("line", LINE, Dense(np.full(len(LINE), 1.0 / len(LINE)))),
            Attribute("pace", PACE, Dense(np.full(len(PACE), 1.0 / len(PACE)))),
        ),
    )
    ball = PRMClass("Ball", attributes=(Attribute("touch", touches, without(len(TOUCHES), 0)),))
    possesses = Relation(
        POSSESSES,
        roles=(("o", "Opponent"), ("b", "Ball")),
        changes=(
            Replace("o.mode", (prev("o.mode"),), Dense(tables["mode"]), initial=Dense(tables["begin"])),
            Replace("b.touch", ("o.mode",), Dense(tables["touch"])),
            Replace("o.due", ("o.mode", "o.situation"), Dense(tables["due"])),
            Replace("o.line", ("o.mode", "o.view"), Dense(tables["line"])),
            Replace("o.pace", ("o.drive",), Dense(tables["pace"])),
        ),
        conflict="priority",
    )
    return Model("intention", classes=(opponent, ball), relations=(possesses,))
