"""A run as a small file: what it was made of, what was changed by hand, and where it stood. Played again, it is the same run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ...architecture.petri import PetriNet
from ...architecture.prm import Model
from ...errors import CprmError, FormatError
from ...files import parse_json, read_bounded, write_atomically
from .changes import Change
from .run import Run
from .setup import Setup

FORMAT, VERSION, LARGEST = "cprm_gym run", 1, 1 << 20
MOST = 10_000
"""Changes, and cycles of which a run is played again."""


class KeptRun(NamedTuple):
    """What such a file says."""

    setup: Mapping[str, Any]
    changes: tuple[Change, ...]
    cycle: int

    def said(self) -> dict[str, Any]:
        """For a page."""
        return {**self.setup, "changes": len(self.changes), "cycle": self.cycle}

    def made(self, nets: Mapping[str, PetriNet], models: Mapping[str, Model]) -> Setup:
        """The setup, with the nets and models that were edited then, as they are open now.

        Raises
        ------
        CprmError
            When one of them is not open.
        """
        for kind, wanted, there in (("net", "nets", nets), ("model", "models", models)):
            if missing := [name for name in self.setup[wanted] if name not in there]:
                raise CprmError(f"the run was played with an edited {kind} that is not open: {', '.join(missing)}")
        own = {name: self.setup[name] for name in ("task", "controller", "seed", "world", "disturbance", "options")}
        chosen = {name: nets[name] for name in self.setup["nets"]}, {name: models[name] for name in self.setup["models"]}
        return Setup(**own, nets=chosen[0], models=chosen[1])


def keep_run(path: Path, run: Run) -> None:
    """Write the file; it is there whole or not at all."""
    s = run.setup
    setup = {"task": s.task, "controller": s.controller, "seed": s.seed, "world": s.world, "disturbance": s.disturbance,
             "options": dict(s.options), "nets": sorted(s.nets), "models": sorted(s.models)}  # fmt: skip
    changes = [change.said() for change in run.hands.log]
    content = {"format": FORMAT, "version": VERSION, "setup": setup, "changes": changes, "cycle": run.cycle}
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, json.dumps(content, indent=1) + "\n")


def read_run(path: Path) -> KeptRun:
    """What a file says.

    Raises
    ------
    FormatError
        When it is none, or damaged.
    """
    data = parse_json(read_bounded(path, LARGEST).decode("utf-8", "replace"), str(path))
    if not isinstance(data, dict) or data.get("format") != FORMAT or data.get("version") != VERSION:
        raise FormatError(f"{path}: no run of the studio")
    try:
        setup, changes, cycle = data["setup"], data["changes"], data["cycle"]
        if type(cycle) is not int or not 0 <= cycle <= MOST or len(changes) > MOST:
            raise FormatError(f"{path}: at most {MOST} cycles and changes")
        lists = all(isinstance(setup[name], list) and all(isinstance(n, str) for n in setup[name]) for name in ("nets", "models"))
        if not lists or not isinstance(setup["options"], dict):
            raise FormatError(f"{path}: nets and models are lists of names, options are fields of the task")
        Setup(**{name: setup[name] for name in ("task", "controller", "seed", "world", "disturbance")})
        made = tuple(Change(**{**change, "values": tuple(change["values"])}) for change in changes)
    except (TypeError, KeyError, ValueError) as error:
        raise FormatError(f"{path}: {error}") from None
    return KeptRun(setup, made, cycle)
