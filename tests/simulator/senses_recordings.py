"""Recordings of the real server for the tests of the senses: where they are, and a simulator put into a recorded state."""

from __future__ import annotations

import functools
import gzip
import json
import math
from pathlib import Path

import numpy as np
import pytest

from cprm_gym.simulator.parameters import ServerParameters
from cprm_gym.simulator.player_types import PlayerParameters, PlayerType
from cprm_gym.simulator.simulator import Simulator
from cprm_gym.simulator.state import PlayerBit, PlayMode

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = [ROOT / "tests/conformance/data", ROOT.parent / "shared/conformance"]
D2R = math.pi / 180.0
KEYS = {f"{side}{n}": n + (0 if side == "l" else 11) for side in "lr" for n in range(1, 12)}


def recording(name: str) -> list[dict]:
    """All records of a recording; the test is skipped when it is neither in the repository nor beside it."""
    for folder in FOLDERS:
        path = folder / f"{name}.jsonl.gz"
        if path.exists():
            return _read(path)
    pytest.skip(f"no recording {name}")


@functools.cache
def _read(path: Path) -> list[dict]:
    with gzip.open(path, "rt") as lines:
        return [json.loads(line) for line in lines]


def _message(name: str, values: dict) -> str:
    """Recorded parameters as the server's message."""
    items = "".join(f'({key} "{value}")' if isinstance(value, str) else f"({key} {value!r})" for key, value in values.items())
    return f"({name} {items})"


def simulator(header: dict, **changes) -> Simulator:
    """A simulator with the parameters, types and players of a recording."""
    sim = Simulator(
        1, ServerParameters.from_text(_message("server_param", header["server_param"])),
        PlayerParameters.from_text(_message("player_param", header["player_param"])),
        [PlayerType.from_text(_message("player_type", kind))[1] for kind in header["player_type"].values()], **changes,
    )
    sim.team_names = ("L", "R")
    w = sim.world
    w["enabled"], w["mode"], w["kick_cycles"] = 0, PlayMode.play_on, -1
    w["goalie"] = 0
    for key, version in header["client_versions"].items():
        i = KEYS[key] - 1
        w["enabled"][0, i], w["protocol"][0, i], w["synchronous"][0, i] = 1, version, version >= 18
    for key in header.get("goalies", []):
        w["goalie"][0, KEYS[key] - 1] = 1
    return sim


def load(sim: Simulator, state: dict, time: int | None = None) -> None:
    """Put the world into a recorded state; what a state does not hold is left as it is."""
    w = sim.world[0]
    w["time"] = state.get("t", time)
    w["pos"][0], w["vel"][0] = state["ball"][:2], state["ball"][2:]
    extra = state.get("ex", {})
    if "pm" in state:
        w["mode"] = PlayMode[state["pm"]] if state["pm"] in PlayMode.__members__ else PlayMode.free_kick_l
    for key, row in state["pl"].items():
        i = KEYS[key] - 1
        w["type"][i] = row[0]
        w["pos"][i + 1], w["vel"][i + 1] = row[1:3], row[3:5]
        w["body"][i] = w["body_staged"][i] = row[5] * D2R
        w["neck"][i] = w["neck_staged"][i] = row[6] * D2R
        w["stamina"][i], w["effort"][i], w["recovery"][i], w["capacity"][i] = row[7:11]
        more = extra.get(key, {})
        w["arm_timer"][i] = 20
        if "arm" in more:
            distance, angle = more["arm"]
            angle += w["body"][i] + w["neck"][i]
            w["arm_timer"][i] = 1
            w["arm_target"][i] = w["pos"][i + 1] + distance * np.array([math.cos(angle), math.sin(angle)])
        point = more.get("fp", (0.0, 0.0))
        w["focus_distance"][i], w["focus_direction"][i] = point[0], point[1] * D2R
        marks = more.get("st", "")
        w["tackle_cycles"][i] = max(int(w["tackle_cycles"][i]), 1) if "t" in marks else 0
        w["kick_cycles"][i] = 0 if "k" in marks else -1
        cards = (PlayerBit.YELLOW_CARD if "y" in marks else 0) | (PlayerBit.RED_CARD if "r" in marks else 0)
        w["bits"][i] = PlayerBit.STAND | cards
