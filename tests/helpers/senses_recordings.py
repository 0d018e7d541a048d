"""Recordings of the real server for the tests of the senses: where they are, and a simulator that stands in a recorded state."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest
from paths import ROOT

from cprm_gym.simulator.conformance.recording import ROW, Recording, load_extras, load_objects, read_recording
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import PlayMode

FOLDERS = [ROOT / "tests/conformance/data", ROOT.parent / "shared/conformance", ROOT.parent / "shared/conformance/random"]
WIDTHS = {"narrow": 1, "normal": 2, "wide": 3}


def recording(name: str) -> Recording:
    """A recording; the test is skipped when it is neither in the repository nor beside it."""
    for folder in FOLDERS:
        path = folder / f"{name}.jsonl.gz"
        if path.exists():
            return _read(path)
    pytest.skip(f"no recording {name}")


@functools.cache
def _read(path: Path) -> Recording:
    return read_recording(path)


def simulator(recorded: Recording) -> Simulator:
    """A simulator with the recording's parameters, types and players, in play."""
    sim = recorded.simulator()
    sim.team_names = ("L", "R")
    sim.world["mode"], sim.world["kick_cycles"] = PlayMode.play_on, -1
    return sim


def load(sim: Simulator, state: dict, time: int) -> None:
    """Put what players can see of a recorded state into the world."""
    w = sim.world[0]
    w["time"] = time
    w["arm_timer"] = [1 if "arm" in state.get("ex", {}).get(key, {}) else 20 for key in ROW]
    load_objects(w, state)
    load_extras(w, state, 20)
    for key, row in ROW.items():
        marks = state.get("ex", {}).get(key, {}).get("st", "")
        w["tackle_cycles"][row] = "t" in marks
        w["kick_cycles"][row] = 0 if "k" in marks else -1


def cases(recorded: Recording) -> list[dict]:
    """The cases of a recording."""
    return [record for record in recorded.records if record["rec"] == "case"]


def see_messages(step: dict):
    """(player's key, time told, message) of the see messages recorded in a step."""
    for key, texts in (step.get("msgs") or {}).items():
        for text in texts:
            if text.startswith("(see "):
                yield key, int(text[5:].split(" ")[0].rstrip(")")), text


def random_worlds(count: int, seed: int = 0, spread: float = 1.0) -> Simulator:
    """A simulator of `count` worlds with everybody anywhere on the pitch, everybody's eyes open."""
    sim = Simulator(count, seed=seed)
    rng = np.random.default_rng(seed)
    w = sim.world
    w["mode"], w["kick_cycles"], w["saw"] = PlayMode.play_on, -1, 1
    w["pos"] = rng.uniform(-1, 1, (count, 23, 2)) * (50 * spread, 32 * spread)
    w["vel"] = rng.normal(0, 0.3, (count, 23, 2))
    w["body"], w["neck"] = rng.uniform(-np.pi, np.pi, (count, 22)), rng.uniform(-np.pi / 2, np.pi / 2, (count, 22))
    w["view_width"] = rng.integers(1, 4, (count, 22))
    return sim
