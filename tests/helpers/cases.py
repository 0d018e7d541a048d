"""The recorded reference cases as ground slices (axes in the files are child first, ours are child last)."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from paths import ROOT, SHARED

from cprm_gym.architecture.prm.grounding.grounding import GroundCPD, GroundSlice, GroundVariable

HANDED = SHARED / "cases" / "prm"
RECORDED = ROOT / "tests" / "architecture" / "prm" / "data"


def path_of(name: str) -> Path | None:
    """The file of a case: our own recordings beside the tests, else ``../shared``; None when absent."""
    for folder in (RECORDED, HANDED):
        for path in sorted(folder.glob(f"{name}*.json")):
            return path
    return None


def load(name: str) -> dict[str, Any]:
    """The parsed case, or a skip when its data is absent."""
    path = path_of(name)
    if path is None:
        pytest.skip(f"case {name} is not in ../shared")
    return dict(json.loads(path.read_text()))


def names(kind: str) -> list[str]:
    """Identifiers of all cases of a kind that are present."""
    paths = {p.stem: p for folder in (HANDED, RECORDED) for p in sorted(folder.glob("*.json"))}
    return [stem for stem, path in sorted(paths.items()) if json.loads(path.read_text())["kind"] == kind]


def variables_of(case: dict[str, Any]) -> dict[str, GroundVariable]:
    """Ground variables; a dotted name is an object and an attribute."""
    out = {}
    for name, spec in case["variables"].items():
        owner, _, attribute = name.rpartition(".")
        states = tuple(spec["states"] or (str(i) for i in range(spec["card"])))
        out[name] = GroundVariable(name, states, object_name=owner, attribute=attribute or name)
    return out


def cpd_of(spec: dict[str, Any], variables: dict[str, GroundVariable]) -> GroundCPD:
    """One CPD, with its axes brought to parents as declared, child last."""
    parents = tuple((p, 0) if isinstance(p, str) else (p[0], int(p[1])) for p in spec["parents"])
    shape = [variables[spec["child"]].card] + [variables[p].card for p, _ in parents]
    table = np.ascontiguousarray(np.moveaxis(np.array(spec["table"], dtype=float).reshape(shape), 0, -1))
    table.flags.writeable = False
    return GroundCPD(spec["child"], parents, table, key=(table.shape, table.tobytes()))


def slice_of(cpds: list[dict[str, Any]], variables: dict[str, GroundVariable]) -> GroundSlice:
    """A slice that holds the variables which have a CPD in the list."""
    ground = tuple(cpd_of(c, variables) for c in cpds)
    return GroundSlice({c.child: variables[c.child] for c in ground}, ground)


def static_slice(case: dict[str, Any]) -> GroundSlice:
    """The net of a case of kind "static"."""
    return slice_of(case["cpds"], variables_of(case))


def filter_slices(case: dict[str, Any]) -> dict[str, GroundSlice]:
    """The slice of each named CPD set of a case of kind "filter"; ``case["schedule"]`` orders them."""
    variables = variables_of(case)
    return {name: slice_of(cpds, variables) for name, cpds in case["cpd_sets"].items()}


def steps(case: dict[str, Any]) -> Iterator[tuple[dict[str, Any], GroundSlice]]:
    """Pairs (recorded step, slice) of a case of kind "filter"."""
    slices = filter_slices(case)
    for step, name in zip(case["steps"], case["schedule"]):
        yield step, slices[name]
