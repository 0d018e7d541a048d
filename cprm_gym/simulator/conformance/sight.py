"""Recordings of what draws decide in seeing: what is lost with distance, Gaussian distances, directions of arms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from ..landmarks import LANDMARK_NAMES, LANDMARK_POSITIONS
from ..player_types import TypeColumn
from ..senses import BallLevel, PlayerFlag, PlayerLevel, see, see_landmarks
from ..simulator import Simulator
from ..state import BALL, ViewWidth
from .recording import ROW, Recording, load_extras, load_objects
from .report import Result
from .statistics import batch, same_counts, same_distribution

_OBSERVER = (-52.0, 0.0)
_FORMS = {"full_6": PlayerLevel.NUMBER, "nounum_2": PlayerLevel.TEAM, "noteam_2": PlayerLevel.UNKNOWN}


def _looker(recording: Recording, worlds: int) -> Simulator:
    """Worlds in which player l1 looks along the pitch with a narrow view, and r1 stands somewhere."""
    simulator = batch(recording, worlds, (0, 11))
    world = simulator.world
    world["pos"][:, 1] = _OBSERVER
    world["view_width"], world["view_quality"], world["saw"] = ViewWidth.NARROW, 1, 1
    return simulator


def levels(recording: Recording, result: Result) -> None:
    """How often number, team and changes are told, by distance."""
    players, balls, flags = [], [], []
    for record in recording.records:
        count = int(record["n"]) if record["rec"] == "player" else int(record["vel"]) + int(record["novel"])
        simulator = _looker(recording, count)
        world = simulator.world
        result.cycles += count
        if record["rec"] == "player":
            world["pos"][:, 12] = _OBSERVER[0] + record.get("d_true", record["d"]), 0.0
            seen = see(world, simulator.packed).players_level[:, 0].max(axis=1)
            own = [int((seen == level).sum()) for level in _FORMS.values()]
            players.append(([int(record["forms"].get(name, 0)) for name in _FORMS], own))
            _same_support(result, f"player at {record['d']} m", players[-1])
        elif record["rec"] == "ball":
            world["pos"][:, BALL] = _OBSERVER[0] + record["d"], 0.0
            told = see(world, simulator.packed).ball_level[:, 0]
            balls.append(_moving(record, told))
            _same_support(result, f"ball at {record['d']} m", balls[-1])
        else:
            names = [name[2:] if name.startswith("f ") else name for name in (text.strip("()") for text in LANDMARK_NAMES)]
            told = see_landmarks(world, simulator.packed).level[:, 0, names.index(record["name"])]
            flags.append(_moving(record, told))
            _same_support(result, f"flag {record['name']}", flags[-1])
    same_counts(result, "forms of players", players)
    same_counts(result, "changes of the ball", balls)
    same_counts(result, "changes of landmarks", flags)


def _moving(record: dict[str, Any], told: npt.NDArray[Any]) -> tuple[list[int], list[int]]:
    """Recorded and own counts of "with changes" and "without"."""
    own = [int((told == BallLevel.MOVING).sum()), int((told == BallLevel.SEEN).sum())]
    return [int(record["vel"]), int(record["novel"])], own


def _same_support(result: Result, name: str, pair: tuple[list[int], list[int]]) -> None:
    """What always happens in one of the two must happen in the other: all looks seen, and nothing that has probability 0 or 1 differs."""
    result.equal("levels", 0, name, "looks", sum(pair[0]), sum(pair[1]))


def arms(recording: Recording, result: Result) -> None:
    """Directions in which a pointing arm is seen."""
    for record in recording.records:
        rows = [row for row in record["rows"] if row[1] is not None]
        for distance, direction in sorted({(row[0], row[1]) for row in rows}):
            told = np.array([row[2] for row in rows if row[:2] == [distance, direction]])
            simulator = _looker(recording, len(told))
            world = simulator.world
            world["pos"][:, 1], world["pos"][:, 12] = (0.0, 0.0), (distance, 0.0)
            angle = math.radians(direction)
            world["arm_target"][:, 11] = distance + 30.0 * math.cos(angle), 30.0 * math.sin(angle)
            world["arm_timer"][:, 11] = 0
            seen = see(world, simulator.packed)
            pointing = (seen.players_flags[:, 0] & PlayerFlag.POINTING) != 0
            own = np.degrees(seen.players[:, 0][pointing][:, 6])
            result.cycles += len(told)
            same_distribution(result, f"arm seen from {distance:g} m", _wrapped(told - direction), _wrapped(own - direction))


def _wrapped(degrees: npt.NDArray[Any]) -> npt.NDArray[Any]:
    # whole degrees; rounded so that equal angles of both sides are ties
    return np.round((degrees + 180.0) % 360.0 - 180.0, 6)


def gaussian(recording: Recording, result: Result) -> None:
    """Distances of the Gaussian model, as multiples of their standard deviation."""
    scenes = [record for record in recording.records if record["rec"] == "raw"]
    copies = 350
    own: dict[str, list[npt.NDArray[Any]]] = {"players": [], "ball": [], "landmarks": []}
    kind = recording.simulator().packed["types"][0, 0]
    for scene in scenes:
        simulator = batch(recording, copies)
        world = simulator.world
        for k in range(copies):
            load_objects(world[k], scene["state"])
            load_extras(world[k], scene["state"], simulator.parameters.point_to_duration)
        world["gaussian"], world["saw"] = 1, 1
        world["view_width"] = ViewWidth.WIDE
        seen, pitch = see(world, simulator.packed), see_landmarks(world, simulator.packed)
        for key in scene["msgs"]:
            _collect(own, world, seen, pitch, ROW[key], kind)
    told: dict[str, list[float]] = {"players": [], "ball": [], "landmarks": []}
    for record in recording.records:
        if record["rec"] == "rows":
            for what, distance, focus, seen_distance, *_ in record["rows"]:
                name = {"p": "players", "b": "ball", "f": "landmarks"}[what]
                if name != "players" or distance < _NUMBERED:
                    told[name].append((seen_distance - distance) / _sigma(kind, name, distance, focus))
            result.cycles += len(record["rows"])
    for name, values in told.items():
        mine = np.concatenate(own[name]) if own[name] else np.zeros(0)
        if values and len(mine):
            same_distribution(result, f"Gaussian distance of {name}", np.array(values), mine)


_NUMBERED = 15.0
"""Players nearer than this are certainly seen with their number, so that it is known who they are."""


def _sigma(kind: Any, name: str, distance: Any, focus: Any) -> Any:
    land = name == "landmarks"
    own = kind[TypeColumn.LAND_DIST_NOISE_RATE if land else TypeColumn.DIST_NOISE_RATE]
    of_focus = kind[TypeColumn.LAND_FOCUS_DIST_NOISE_RATE if land else TypeColumn.FOCUS_DIST_NOISE_RATE]
    return distance * own + focus * of_focus


def _collect(own: dict[str, list[Any]], world: Any, seen: Any, pitch: Any, row: int, kind: Any) -> None:
    """Deviations of everything that observer `row` sees and that can be told apart, in standard deviations."""
    place = world["pos"][0, row + 1]
    direction = world["body"][0, row] + world["neck"][0, row] + world["focus_direction"][0, row]
    reach = world["focus_distance"][0, row]
    focus = place + reach * np.array([math.cos(direction), math.sin(direction)])

    def add(name: str, target: Any, distances: Any) -> None:
        if len(distances):
            distance, of_focus = math.hypot(*(target - place)), math.hypot(*(target - focus))
            own[name].append((distances - distance) / _sigma(kind, name, distance, of_focus))

    for other in range(22):
        target = world["pos"][0, other + 1]
        named = seen.players_level[:, row, other] == PlayerLevel.NUMBER
        if other != row and named.all() and math.hypot(*(target - place)) < _NUMBERED:
            add("players", target, seen.players[:, row, other, 0])
    ball = seen.ball_level[:, row] >= BallLevel.SEEN
    add("ball", world["pos"][0, BALL], seen.ball[ball, row, 0])
    for number, target in enumerate(LANDMARK_POSITIONS):
        clear = pitch.level[:, row, number] >= BallLevel.SEEN
        if clear.all():
            add("landmarks", np.asarray(target), pitch.landmarks[:, row, number, 0])
