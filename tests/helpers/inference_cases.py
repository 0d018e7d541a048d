"""Reference cases of inference as slices: files of our own beside the tests, public nets from ``../shared`` if it is there."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from paths import ROOT, SHARED

from cprm_gym.architecture.prm.grounding.slices import GroundCPD, Grounds, GroundSlice, GroundVariable

HANDED = SHARED / "cases" / "prm"
OURS = ROOT / "tests" / "architecture" / "prm" / "data"


def find(name: str) -> Path | None:
    """Path of a case, ours first; None if it is nowhere."""
    for folder in (OURS, HANDED):
        path = folder / f"{name}.json"
        if path.exists():
            return path
    return None


def load(name: str) -> dict[str, Any]:
    """A case as a dict."""
    path = find(name)
    assert path is not None, name
    return json.loads(path.read_text())


def variable(name: str, spec: dict[str, Any]) -> GroundVariable:
    """A variable of a case."""
    states = spec["states"] or [str(i) for i in range(spec["card"])]
    return GroundVariable(name, tuple(map(str, states)))


def cpd(spec: dict[str, Any], variables: dict[str, Any]) -> GroundCPD:
    """A CPD of a case: the files have the child's axis first."""
    parents = tuple((p, 0) if isinstance(p, str) else (p[0], p[1]) for p in spec["parents"])
    shape = [variables[spec["child"]]["card"]] + [variables[p]["card"] for p, _ in parents]
    table = np.moveaxis(np.array(spec["table"]).reshape(shape), 0, -1)
    return GroundCPD(spec["child"], parents, np.ascontiguousarray(table), key=(spec["child"], parents))


def static_slice(case: dict[str, Any]) -> GroundSlice:
    """A case of kind "static" as one slice."""
    variables = {n: variable(n, v) for n, v in case["variables"].items()}
    return GroundSlice(variables, tuple(cpd(c, case["variables"]) for c in case["cpds"]))


class Schedule(Grounds):
    """The CPD sets of a case as a grounding: the active "relation" is the name of the set."""

    def __init__(self, case: dict[str, Any], given: tuple[str, ...] = ()) -> None:
        self.slices: dict[str, GroundSlice] = {}
        static: set[str] = set()
        for name, cpds in case["cpd_sets"].items():
            made = tuple(cpd(c, case["variables"]) for c in cpds if c["child"] not in given)
            names = [c["child"] for c in cpds]
            self.slices[name] = GroundSlice({n: variable(n, case["variables"][n]) for n in names}, made, given)
            static |= {p for c in made for p, lag in c.parents if lag == -1}
        self.static = tuple(sorted(static))
        self.first = case["schedule"][0]

    def ground(self, active: Any = (), first: bool = False) -> GroundSlice:
        """The slice of a CPD set."""
        return self.slices[self.first if first else active]
