"""Recordings of a real server's runs: reading them, putting their states into a world, comparing a world with them.

A recording is a file of JSON lines: a header, then cases (a set-up and its steps) or rows of numbers. States name players ``l1`` to
``r11`` and give the server's global coordinates, angles in degrees, velocities after decay.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import FormatError
from ..gamelog.streams import open_log, read_lines
from ..parameters import ServerParameters
from ..pitch import GOAL_POST_RADIUS, HALF_LENGTH
from ..player_types import PlayerParameters, PlayerType
from ..simulator import Simulator
from ..state import BALL, PLAYERS, PlayerBit, PlayMode
from .report import Result

D2R, R2D = math.pi / 180.0, 180.0 / math.pi
MODES = {mode.name: mode for mode in PlayMode}
KEYS = tuple(f"l{unum}" for unum in range(1, 12)) + tuple(f"r{unum}" for unum in range(1, 12))
"""Names of the players in recordings; the position is the row of the player."""
ROW = {key: row for row, key in enumerate(KEYS)}
CARDS = {"none": 0, "yellow": 1, "red": 2}
_PLAYER = ("type", "x", "y", "vx", "vy", "body", "neck", "stamina", "effort", "recovery", "capacity")


MOST_RECORDED = 1 << 24
"""Bytes of a recording, decompressed; it is kept in memory."""


@dataclass(slots=True)
class Recording:
    """One file: its header, and the rest of its lines on demand."""

    path: Path
    header: dict[str, Any]
    records: list[dict[str, Any]] = field(default_factory=list)

    @property
    def scenario(self) -> str:
        """What kind of run it is."""
        return str(self.header.get("scenario", "scenario"))

    @property
    def parameters(self) -> ServerParameters:
        """The server's parameters."""
        return ServerParameters.from_mapping(self.header["server_param"])

    def simulator(self, seed: int = 0) -> Simulator:
        """A simulator with the recording's parameters, types, players and goalies, standing before kick-off."""
        header = self.header
        types = [PlayerType.from_mapping(header["player_type"][str(number)]) for number in range(len(header["player_type"]))]
        sizes = [max((int(key[1:]) for key in header["client_versions"] if key[0] == side), default=0) for side in "lr"]
        goalies = [next((int(key[1:]) for key in header["goalies"] if key[0] == side), 0) for side in "lr"]
        simulator = Simulator(
            1,
            self.parameters,
            PlayerParameters.from_mapping(header["player_param"]),
            types,
            seed,
            left=sizes[0],
            right=sizes[1],
            goalies=(goalies[0], goalies[1]),
        )
        world = simulator.world[0]
        for key, version in header["client_versions"].items():
            world["protocol"][ROW[key]] = version
            world["synchronous"][ROW[key]] = version >= 18
        for row, key in enumerate(KEYS):
            if key not in header["client_versions"]:
                world["enabled"][row] = 0
        return simulator


def read_recording(path: str | os.PathLike[str]) -> Recording:
    """Read a recording.

    Raises
    ------
    FormatError
        When the file is not JSON lines that begin with a header; the message has the file and the line.
    """
    path = Path(path)
    lines = _lines(path)
    number, header = next(lines, (1, None))
    if not isinstance(header, dict) or header.get("rec") != "header":
        raise FormatError(f"{path}, line {number}: a recording begins with an object whose rec is 'header'")
    for name in ("server_param", "player_param", "player_type", "client_versions", "goalies"):
        if name not in header:
            raise FormatError(f"{path}, line {number}: the header has no {name!r}")
    recording = Recording(path, header)
    for number, record in lines:
        if not isinstance(record, dict) or "rec" not in record:
            raise FormatError(f"{path}, line {number}: an object with 'rec' was expected")
        recording.records.append(record)
    return recording


def _lines(path: Path) -> Iterator[tuple[int, Any]]:
    size = 0
    with open_log(path) as stream:
        for number, line in enumerate(read_lines(path, stream, MOST_RECORDED), 1):
            size += len(line)
            if size > MOST_RECORDED:
                raise FormatError(f"{path}, line {number}: a recording of more than {MOST_RECORDED} bytes")
            try:
                if line.strip():
                    yield number, json.loads(line)
            except RecursionError:
                raise FormatError(f"{path}, line {number}: JSON nested too deeply") from None
            except ValueError as error:
                raise FormatError(f"{path}, line {number}: not JSON: {error}") from error


# --- states


def play_mode(name: str) -> tuple[PlayMode, int]:
    """The play mode that a state names, and the side of the goalie who holds the ball (0: nobody).

    While a goalie holds the ball the server's picture says ``goalie_catch_ball_l``; the mode is his free kick.
    """
    if name.startswith("goalie_catch_ball_"):
        side = name[-1]
        return MODES[f"free_kick_{side}"], 1 if side == "l" else -1
    return MODES[name], 0


def load_objects(world: Any, state: dict[str, Any]) -> None:
    """Put ball and players of a recorded state into `world`; those the state does not have are taken off the field."""
    if "ball" in state:
        world["pos"][BALL], world["vel"][BALL], world["acc"][BALL] = state["ball"][:2], state["ball"][2:], 0.0
    if "pl" not in state:
        return
    world["enabled"] = [key in state["pl"] for key in KEYS]
    for key, values in state["pl"].items():
        row = ROW[key]
        world["type"][row] = values[0]
        world["pos"][row + 1], world["vel"][row + 1], world["acc"][row + 1] = values[1:3], values[3:5], 0.0
        for name, degrees in (("body", values[5]), ("neck", values[6])):
            # recorded degrees lose the last bit of the server's radians; an angle that agrees is kept
            if abs(nearest_angle(degrees, float(world[name][row]) * R2D) - degrees) > 1e-11:
                world[name][row] = degrees * D2R
            world[f"{name}_staged"][row] = world[name][row]
        for name, value in zip(("stamina", "effort", "recovery", "capacity"), values[7:11]):
            if value is not None:
                world[name][row] = value


def load_extras(world: Any, state: dict[str, Any], duration: int) -> None:
    """Put focus points and arms of a recorded state into `world`: its ``ex`` has them only where they are not the default."""
    extras = state.get("ex", {})
    for key in state["pl"]:
        row, extra = ROW[key], extras.get(key, {})
        distance, direction = extra.get("fp", (0.0, 0.0))
        world["focus_distance"][row] = distance
        if abs(float(world["focus_direction"][row]) * R2D - direction) > 1e-11:
            world["focus_direction"][row] = direction * D2R
        if "arm" in extra:
            reach, angle = extra["arm"]
            angle += world["body"][row] + world["neck"][row]
            x, y = world["pos"][row + 1]
            world["arm_target"][row] = x + reach * math.cos(angle), y + reach * math.sin(angle)
        elif world["arm_timer"][row] < duration:
            world["arm_timer"][row] = duration


def load_mode(world: Any, state: dict[str, Any]) -> None:
    """Put play mode, catcher and score of a recorded state into `world`."""
    mode, side = play_mode(state["pm"])
    world["mode"] = mode
    world["score"] = state["score"]
    if not side:
        world["ball_catcher"] = 0
    elif not world["ball_catcher"]:
        rows = range(11) if side > 0 else range(11, 22)
        world["ball_catcher"] = next((row + 1 for row in rows if world["goalie"][row]), 0)


def shown_mode(world: Any) -> str:
    """The mode's name as the server's picture gives it."""
    mode = PlayMode(int(world["mode"]))
    if world["ball_catcher"] and mode in (PlayMode.free_kick_l, PlayMode.free_kick_r):
        return f"goalie_catch_ball_{'l' if mode == PlayMode.free_kick_l else 'r'}"
    return mode.name


def nearest_angle(expected: float, got: float) -> float:
    """`got` (degrees), turned by whole turns so that it is nearest to `expected`: 180 and -180 are the same."""
    while got - expected > 180.0:
        got -= 360.0
    while got - expected < -180.0:
        got += 360.0
    return got


def compare_state(
    result: Result, case: str, cycle: int, world: Any, state: dict[str, Any], tolerance: Any, skip: frozenset[int] = frozenset()
) -> bool:
    """Compare every number of a recorded state with `world`; True when all agree.

    Parameters
    ----------
    result : Result
        Gets the errors and mismatches.
    case, cycle
        Where it is.
    world : record of WORLD
    state : dict
        The recorded state.
    tolerance : callable
        Object number -> tolerance.
    skip : frozenset of int
        Object numbers that are left to chance.
    """
    before = result.failed
    result.equal(case, cycle, "game", "time", state["t"], int(world["time"]))
    result.equal(case, cycle, "game", "play mode", state["pm"], shown_mode(world))
    result.equal(case, cycle, "game", "score", list(state["score"]), [int(score) for score in world["score"]])
    if BALL not in skip:
        allowed = tolerance(BALL)
        for name, expected, got in zip(("x", "y", "vx", "vy"), state["ball"], (*world["pos"][BALL], *world["vel"][BALL])):
            result.number(case, cycle, "ball", name, expected, float(got), allowed)
    players = state["pl"]
    field_ = {key for row, key in enumerate(KEYS) if world["enabled"][row]}
    result.equal(case, cycle, "game", "players", sorted(players), sorted(field_))
    for key, values in players.items():
        row = ROW[key]
        if row + 1 not in skip:
            _compare_player(result, case, cycle, key, values, world, row, tolerance(row + 1))
            _compare_extras(result, case, cycle, key, state.get("ex", {}).get(key, {}), world, row)
    return result.failed == before


def _compare_player(result: Result, case: str, cycle: int, key: str, values: list[float], world: Any, row: int, allowed: float) -> None:
    got = (
        int(world["type"][row]),
        *world["pos"][row + 1],
        *world["vel"][row + 1],
        world["body"][row] * R2D,
        world["neck"][row] * R2D,
        world["stamina"][row],
        world["effort"][row],
        world["recovery"][row],
        world["capacity"][row],
    )
    for name, expected, value in zip(_PLAYER, values, got):
        if name == "type":
            result.equal(case, cycle, key, name, expected, value)
        elif name in ("body", "neck"):
            result.number(case, cycle, key, name, expected, nearest_angle(expected, float(value)), max(allowed, 1e-12))
        else:
            # one unit in the last of 17 digits is what the recording itself can lose
            result.number(case, cycle, key, name, expected, float(value), max(allowed, 2e-16 * abs(expected)))


def _compare_extras(result: Result, case: str, cycle: int, key: str, extra: dict[str, Any], world: Any, row: int) -> None:
    marks = extra.get("st", "")
    tackling = world["tackle_cycles"][row] > 0
    kicking = world["kick_cycles"][row] >= 0 and not tackling
    charged = world["foul_cycles"][row] > 0 and not tackling and not kicking
    card = "y" if world["card_count"][row] == 1 else ""
    got = ("t" if tackling else "k" if kicking else "f" if charged else "") + card
    result.equal(case, cycle, key, "marks", "".join(marks), got)
    distance, direction = extra.get("fp", (0.0, 0.0))
    result.number(case, cycle, key, "focus distance", distance, float(world["focus_distance"][row]), 1e-9)
    result.number(case, cycle, key, "focus direction", direction, float(world["focus_direction"][row]) * R2D, 1e-9)
    result.equal(case, cycle, key, "goalie", bool(extra.get("g")), bool(world["goalie"][row]))


def compare_arm(result: Result, case: str, cycle: int, key: str, extra: dict[str, Any], world: Any, row: int, duration: int) -> None:
    """Compare whether and where a player points, relative to his face."""
    pointing = bool(world["arm_timer"][row] < duration)
    if not result.equal(case, cycle, key, "pointing", "arm" in extra, pointing) or not pointing:
        return
    dx, dy = world["arm_target"][row] - world["pos"][row + 1]
    distance, direction = extra["arm"]
    result.number(case, cycle, key, "arm distance", distance, math.hypot(dx, dy), 1e-9)
    got = (math.atan2(dy, dx) - world["body"][row] - world["neck"][row]) * R2D
    if distance > 1e-6:
        told = direction * R2D
        result.number(case, cycle, key, "arm direction", told, nearest_angle(told, float(got)), 1e-7 / min(distance, 1.0))


# --- the hidden state that runs of random commands record (their README)

_HIDDEN_COUNTS = {
    "kick": 0,
    "dash": 1,
    "turn": 2,
    "catch": 3,
    "move": 4,
    "turn_neck": 5,
    "change_view": 6,
    "change_focus": 7,
    "say": 8,
    "tackle_count": 9,
    "arm_count": 11,
    "focus_count": 12,
}
_WIDTHS = ("", "narrow", "normal", "wide")
_LETTERS = (("b", 1), ("p", 2), ("g", 4))


def hidden_of(world: Any, row: int, fields: list[str], ban: int, duration: int) -> list[Any]:
    """What a player's body tells of `world`, in the order of `fields`."""
    timer = int(world["arm_timer"][row])
    attention = int(world["attention"][row])
    values: dict[str, Any] = {name: int(world["counts"][row, column]) for name, column in _HIDDEN_COUNTS.items()}
    values["view"] = _WIDTHS[int(world["view_width"][row])]
    values["arm_movable"], values["arm_expires"] = max(ban - timer, 0), max(duration - timer, 0)
    values["focus"] = KEYS[attention - 1] if attention else ""
    values["tackle_expires"], values["foul_charged"] = int(world["tackle_cycles"][row]), int(world["foul_cycles"][row])
    values["collision"] = "".join(letter for letter, bit in _LETTERS if int(world["collided"][row]) >> 4 & bit)
    values["card"] = ("none", "yellow", "red")[min(int(world["card_count"][row]), 2)]
    return [values[name] for name in fields]


def load_hidden(world: Any, row: int, fields: list[str], values: list[Any], duration: int) -> None:
    """Put what a player's body told into `world`."""
    told = dict(zip(fields, values))
    for name, column in _HIDDEN_COUNTS.items():
        if name in told:
            world["counts"][row, column] = told[name]
    world["view_width"][row] = _WIDTHS.index(told["view"])
    if told["arm_expires"] > 0:
        world["arm_timer"][row] = duration - told["arm_expires"]
    world["attention"][row] = ROW[told["focus"]] + 1 if told["focus"] else 0
    world["tackle_cycles"][row], world["foul_cycles"][row] = told["tackle_expires"], told["foul_charged"]
    world["busy"][row] = bool(told["tackle_expires"] or told["foul_charged"])
    world["card_count"][row] = CARDS[told["card"]]


def near_post(position: Any, reach: float, width: float) -> bool:
    """Whether a position is so near a goal post that an object may have touched it in this cycle."""
    x, y = abs(position[0]) - (HALF_LENGTH - GOAL_POST_RADIUS), abs(position[1]) - (width / 2 + GOAL_POST_RADIUS)
    return bool(math.hypot(x, y) < reach)


COLLISIONS = int(PlayerBit.BALL_TO_PLAYER | PlayerBit.BALL_COLLIDE | PlayerBit.PLAYER_COLLIDE | PlayerBit.POST_COLLIDE)
"""State bits of a player who collided."""
_ALWAYS = int(PlayerBit.STAND | PlayerBit.GOALIE | PlayerBit.YELLOW_CARD)


def telling_bits(bits: int) -> int:
    """A player's state bits without those that only say that he is there."""
    return bits & ~_ALWAYS


def snapshot_copy(simulator: Simulator) -> Any:
    """The world as it is now, to come back to with `put_back`."""
    return simulator.world.copy()


def put_back(simulator: Simulator, snapshot: Any) -> None:
    """Make the world what it was at `snapshot`, in the simulator's own array."""
    np.copyto(simulator.world, snapshot)


ALL_PLAYERS = range(PLAYERS)
