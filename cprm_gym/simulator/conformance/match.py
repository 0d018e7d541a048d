"""Replaying a whole match from its logs: each cycle from the logged state with the logged commands (``.rcg`` and ``.rcl``).

The game log rounds (positions and velocities to 1e-4, angles to 1e-3 degrees, stamina to six digits), so a cycle is compared within what
rounding of the state before and after can do, and, if the match had noise, within the noise envelope. Where the outcome depends on
which side of a limit a rounded number lies (a ball just within reach), the cycle is tried from several states that round to the
logged one. Draws whose outcome the log tells in the players' state bits (tackles, catches, fouls) are forced. The referee is
carried along from the first kick-off; its play mode is compared and then replaced by the logged one.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...errors import CprmError, FormatError
from ..gamelog.commands import CommandLogReader, LogLine
from ..gamelog.frames import Frame
from ..gamelog.reader import GameLogReader
from ..gamelog.replay import ANGLE_UNIT, load_frame
from ..player_types import TypeColumn
from ..protocol.commands import Parsed, PlayerCommand, command_record, parse_commands, parse_trainer
from ..setup import home
from ..simulator import Simulator
from ..state import BALL, LEFT, PLAYERS, RIGHT, PlayerBit, PlayMode
from .envelope import BOUNCE, Envelope, calm, envelope, kick_noise, struck
from .recording import KEYS, put_back, snapshot_copy
from .report import Check, Mismatch, Result
from .scenario import FORCED, name_of
from .trainer import execute_trainer, is_whole

Array = npt.NDArray[Any]
INSIDE, SAME_MODE = 0.999, 0.995
TRIES = 48
"""States around the logged one that are tried before an object counts as different."""
CLEARED = 10.0
"""Radius (m) of the circle to which the referee clears players, rounded up."""
_POS, _VEL, _ANGLE = 0.5e-4, 0.5e-4, ANGLE_UNIT
_COLLIDE = int(PlayerBit.BALL_TO_PLAYER | PlayerBit.BALL_COLLIDE | PlayerBit.PLAYER_COLLIDE)
_FOULS = {PlayMode.foul_charge_l: LEFT, PlayMode.foul_charge_r: RIGHT}
Clock = tuple[int, int]
REPLAYED_VERSIONS = (5, 6, -1)
"""Versions of game logs that keep what a replay needs."""


def command_log_of(game_log: Path) -> Path | None:
    """The command log that lies beside a game log, if there is one."""
    for old, new in ((".rcg.gz", ".rcl.gz"), (".rcg", ".rcl")):
        if game_log.name.endswith(old):
            for ending in (new, ".rcl", ".rcl.gz"):
                beside = game_log.with_name(game_log.name.removesuffix(old) + ending)
                if beside.exists():
                    return beside
    return None


def replay_match(path: str | os.PathLike[str], command_log: str | os.PathLike[str] | None = None, cycles: int | None = None) -> Result:
    """Replay a match.

    Parameters
    ----------
    path : path
        The game log, text version 5 or 6 or JSON.
    command_log : path, optional
        The command log; the one beside the game log if not given.
    cycles : int, optional
        Only so many of its first cycles; all if not given.

    Raises
    ------
    FormatError
        When a file is missing or cannot be read, or the log is of a version that lacks what is needed.
    """
    path = Path(path)
    reader = GameLogReader(path)
    if reader.version not in REPLAYED_VERSIONS:
        raise FormatError(f"{path}: version {reader.version} of a game log does not keep what a replay needs; 5, 6 and JSON do")
    beside = command_log if command_log is not None else command_log_of(path)
    if beside is None:
        raise FormatError(f"{path}: a match is replayed with its command log (the same name with .rcl or .rcl.gz), which is missing")
    commands = CommandLogReader(beside)
    result = Result(str(path), "match")
    MatchReplay(reader, commands, result).run(cycles)
    return result


class MatchReplay:
    """Replays one match into a `Result`."""

    def __init__(self, reader: GameLogReader, commands: CommandLogReader, result: Result) -> None:
        self.result = result
        self.frames = iter(reader)
        first = next(self.frames, None)
        if first is None:
            raise FormatError(f"{reader.path}: no cycle in it")
        self.first = first
        header = reader.header
        goalies = [_goalie(first, rows) for rows in (slice(0, 11), slice(11, 22))]
        self.simulator = Simulator(
            1, header.parameters(), header.player_parameters(), header.types() or None, goalies=(goalies[0], goalies[1])
        )
        self.names = self.simulator.team_names = (first.left.name, first.right.name)
        self.parameters = self.simulator.parameters
        kicks = any(kind.kick_rand for kind in self.simulator.types)
        self.noisy = bool(self.parameters.ball_rand or self.parameters.player_rand or kicks)
        self.packed = self.simulator.packed
        self.calm = calm(self.packed)
        self.free = self.calm.copy()
        self.free["rules"] = 0
        self.cycles = _Cycles(commands)
        self.objects = self.inside = self.modes = self.same_modes = self.skipped = self.retried = 0
        self.rng = np.random.default_rng(6)

    @property
    def world(self) -> Any:
        """The one world, a record that can be read and written."""
        return self.simulator.world[0]

    # --- the match

    def run(self, cycles: int | None = None) -> None:
        """Every pair of consecutive frames, up to `cycles` of them."""
        self._begin(self.first)
        before, clock = self.first, (self.first.time, 0)
        for frame in itertools.islice(self.frames, cycles):
            follows = frame.time == before.time + 1 or (frame.time == before.time and frame.stoppage == before.stoppage + 1)
            lines = self.cycles.at(clock) if follows else None
            if lines is None:
                self.skipped += 1
                self._begin(frame)
            else:
                self._cycle(before, frame, lines)
            before, clock = frame, (frame.time, frame.stoppage)
        self._conclude()

    def _begin(self, frame: Frame) -> None:
        """A half begins: the cycles before it are not logged. The kick-off is given, one step passes, the frame is loaded."""
        world = self.world
        world["time"], world["stoppage"] = max(frame.time - 1, 0), 0
        load_frame(world, frame)
        if frame.mode in (PlayMode.kick_off_l, PlayMode.kick_off_r):
            self.simulator.trainer.change_mode(frame.mode)
            self.simulator.advance()
        load_frame(world, frame)
        # who lies after a tackle is taken to have tackled in the cycle before
        lies = (frame.players["state"] & int(PlayerBit.TACKLE | PlayerBit.TACKLE_FAULT)) != 0
        world["tackle_cycles"] = np.where(lies, max(self.parameters.tackle_cycles - 1, 0), 0)
        world["busy"] = lies

    def _cycle(self, before: Frame, frame: Frame, lines: list[LogLine]) -> None:
        """One cycle: run it from the logged state, compare, load the logged outcome."""
        world = self.world
        load_frame(world, before)
        start = snapshot_copy(self.simulator)
        bad = self._differences(frame, before, self._run(frame, lines, self.calm), 1.0)
        after = snapshot_copy(self.simulator)
        wrong_mode = world["mode"] != frame.mode
        self.retried += bool(bad or wrong_mode)
        for _ in range(TRIES if bad or wrong_mode else 0):
            put_back(self.simulator, start)
            blur(world, before, self.rng)
            world["key"] = self.rng.integers(0, 2**63, 4, dtype=np.uint64)
            # the outcome of a draw is as far from the logged one as two points of the noise can be from each other
            bounds = self._run(frame, lines, self.packed)
            other = self._differences(frame, before, bounds, 2.0)
            bad = {key: values for key, values in bad.items() if key in other}
            if wrong_mode and world["mode"] == frame.mode:
                wrong_mode = False
                after = snapshot_copy(self.simulator)  # the referee remembers what really happened
            if not bad and not wrong_mode:
                break
        put_back(self.simulator, after)
        world["key"] = start["key"][0]
        self._count(frame, bad, wrong_mode)
        if world["mode"] != frame.mode:
            self.simulator.trainer.change_mode(frame.mode)
        load_frame(world, frame)
        world["mode"], world["time"], world["stoppage"] = frame.mode, frame.time, frame.stoppage

    def _run(self, frame: Frame, lines: list[LogLine], packed: Array) -> Envelope:
        """Commands and step, with the parameters `packed` and the logged outcomes of draws."""
        world, simulator = self.world, self.simulator
        simulator.packed = packed
        world["announced"], world["announced_done"] = 0, 0
        self._force(frame)
        before, noise = world.copy(), 0.0
        for line in lines:
            if line.player is not None and line.player[0] in self.names:
                row = 11 * self.names.index(line.player[0]) + line.player[1] - 1
                for command in _parsed(line.command or "").commands:
                    noise += self._command(row, command)
            elif line.command is not None:
                self._coach(frame, line)
        world["bits"] &= np.uint32(~_COLLIDE & 0xFFFFFFFF)
        middle = snapshot_copy(simulator)
        if self.noisy:  # the same step without noise and referee tells where noise acts
            simulator.packed = self.free
            simulator.advance()
            bounds = envelope(self.packed[0], before, middle[0], world, noise)
            put_back(simulator, middle)
            simulator.packed = packed
        simulator.advance()
        if not self.noisy:
            bounds = envelope(self.packed[0], before, middle[0], world, noise)
        for name in FORCED:
            world[name] = 0
        return bounds

    def _coach(self, frame: Frame, line: LogLine) -> None:
        """Execute a command of the trainer, or a coach's substitution if the next frame shows that it was accepted."""
        team = (line.sender or "").removesuffix("_Coach")
        try:
            command = parse_trainer(line.command or "")
            if team == "Coach":
                execute_trainer(self.simulator, command, self.names)
                return
        except CprmError:
            return  # the server refused it too
        name, args = command
        if team not in self.names or name != "change_player_type" or len(args) != 2 or not all(map(is_whole, args)):
            return
        unum, kind = int(args[0]), int(args[1])
        player = 11 * self.names.index(team) + unum
        if 1 <= unum <= 11 and frame.players["type"][player - 1] == kind and self.world["enabled"][player - 1]:
            self.simulator.trainer.change_player_type(player, kind)

    def _leave(self, row: int) -> None:
        """A player says goodbye: he is taken off the field at once, to where everybody waited before the match."""
        world = self.world
        world["enabled"][row], world["bits"][row] = 0, world["bits"][row] & int(PlayerBit.DISCARD)
        world["pos"][row + 1], world["vel"][row + 1], world["acc"][row + 1] = home(row), 0.0, 0.0

    def _command(self, row: int, command: PlayerCommand) -> float:
        """Execute one command; returns the greatest noise of a kick."""
        if command.name == "bye":
            self._leave(row)
        record = command_record(command, LEFT if row < 11 else RIGHT, self.names)
        if record is None:
            return 0.0
        kicks = self.noisy and command.name in ("kick", "tackle")
        earlier = self.world.copy() if kicks else None
        self.simulator.command_phase(0, row + 1, record)
        return kick_noise(self.packed[0], earlier, self.world, row, command) if kicks else 0.0

    def _force(self, frame: Frame) -> None:
        """Force the draws whose outcome the next frame shows."""
        world, bits = self.world, frame.players["state"]
        tackled, failed = bits & int(PlayerBit.TACKLE), bits & int(PlayerBit.TACKLE_FAULT)
        world["forced_tackle"] = np.where((tackled != 0) & (failed == 0), 1, -1)
        world["forced_catch"] = np.where(bits & int(PlayerBit.CATCH_FAULT), -1, 1)
        begins = PlayMode(frame.mode).name.startswith("penalty_setup_") and not world["pen_started"]
        if begins:  # the ball lies before the goal that was drawn
            world["forced_pen_side"] = LEFT if frame.ball[0] < 0.0 else RIGHT
            world["forced_pen_taker"] = RIGHT if frame.mode == PlayMode.penalty_setup_l else LEFT
        side = _FOULS.get(frame.mode, 0) if frame.mode != world["mode"] else 0
        world["forced_foul"] = -1
        if side:
            world["forced_foul"][0 if side == LEFT else 11 : 11 if side == LEFT else 22] = 1

    # --- comparison

    def _differences(self, frame: Frame, before: Frame, bounds: Envelope, share: float) -> dict[str, list[tuple[str, float, float, float]]]:
        """Object -> quantities: name, logged, simulated, tolerance; only objects of which one lies outside."""
        world, rows = self.world, frame.players
        found: dict[str, list[tuple[str, float, float, float]]] = {}
        told_hit, told_ball = struck(rows["state"])
        told = np.concatenate([[told_ball], told_hit])
        pos = np.concatenate([frame.ball[None, :2], rows["pos"]])
        vel = np.concatenate([frame.ball[None, 2:], rows["vel"]])
        place_limit, speed_limit = rounding(world, bounds)
        place = np.hypot(*(pos - world["pos"]).T)
        speed = np.hypot(*(vel - world["vel"]).T)
        if self.noisy:
            place, speed, place_limit, speed_limit = around(
                self.packed[0], bounds, pos, vel, told, world, place, speed, place_limit, speed_limit, share
            )
        on = np.concatenate([[True], world["enabled"] != 0])
        for number in np.flatnonzero(on & ((place > place_limit) | (speed > speed_limit))):
            found[name_of(int(number))] = [
                ("distance of place", 0.0, float(place[number]), float(place_limit[number])),
                ("distance of velocity", 0.0, float(speed[number]), float(speed_limit[number])),
            ]
        for name, unit, factor in (("body", _ANGLE, share), ("neck", _ANGLE, 0.0)):
            error = np.abs((rows[name] - np.degrees(world[name]) + 180.0) % 360.0 - 180.0)
            limit = 2.1 * unit + factor * bounds.turn
            if name == "body":
                limit = limit + turn_rounding(self.packed[0], world, bounds)
            _note(found, world, name, rows[name], np.degrees(world[name]), error, limit)
        for name in ("stamina", "effort", "recovery", "capacity"):
            limit = 1.05 * (half_digit(rows[name]) + half_digit(before.players[name])) + 2e-6 + 1e-6 * np.abs(rows[name])
            if name in ("stamina", "capacity"):  # what one loses the other may gain, up to what is missing or left
                limit = limit + half_digit(before.players["capacity" if name == "stamina" else "stamina"])
            _note(found, world, name, rows[name], world[name], np.abs(rows[name] - world[name]), limit)
        return found

    def _count(self, frame: Frame, bad: dict[str, list[tuple[str, float, float, float]]], wrong_mode: bool) -> None:
        objects = 1 + int((self.world["enabled"] != 0).sum())
        self.result.cycles += 1
        self.result.compared += objects + 1
        self.objects += objects
        self.inside += objects - len(bad)
        self.modes += 1
        self.same_modes += not wrong_mode
        for key, values in bad.items():
            for name, told, own, limit in values:
                if abs(told - own) > limit:
                    self.result.errors[name] = max(self.result.errors.get(name, 0.0), abs(told - own))
                    self.result.mismatches.append(Mismatch("match", frame.time, key, name, told, own, limit))
        if wrong_mode:
            own_mode = PlayMode(int(self.world["mode"])).name
            self.result.mismatches.append(Mismatch("match", frame.time, "referee", "play mode", frame.mode.name, own_mode))

    def _conclude(self) -> None:
        inside = self.inside / max(self.objects, 1)
        modes = self.same_modes / max(self.modes, 1)
        what = "object-cycles inside the noise envelope" if self.noisy else "object-cycles equal within rounding"
        self.result.checks.append(Check(what, inside, INSIDE, f"{self.objects - self.inside} of {self.objects} outside"))
        self.result.checks.append(
            Check("cycles with the logged play mode", modes, SAME_MODE, f"{self.modes - self.same_modes} of {self.modes} differ")
        )
        self.result.notes.append(
            f"{self.retried} cycles differed at first and were tried from other states that round to the logged one"
            + (", with noise drawn" if self.noisy else "")
        )
        self.result.notes.append(
            f"{self.skipped} cycles not compared: the first of each half, whose state before is not logged, and any without commands"
        )


class _Cycles:
    """The command log, cycle by cycle, asked for in the order of the game log."""

    def __init__(self, commands: CommandLogReader) -> None:
        self._cycles: Iterator[tuple[Clock, list[LogLine]]] = commands.cycles()
        self._next = next(self._cycles, None)

    def at(self, clock: Clock) -> list[LogLine] | None:
        """The lines of one clock, None when the log has none of it."""
        while self._next is not None and self._next[0] < clock:
            self._next = next(self._cycles, None)
        return self._next[1] if self._next is not None and self._next[0] == clock else None


@lru_cache(maxsize=4096)
def _parsed(text: str) -> Parsed:
    return parse_commands(text)


def _goalie(frame: Frame, rows: slice) -> int:
    goalies = frame.players["unum"][rows][(frame.players["state"][rows] & int(PlayerBit.GOALIE)) != 0]
    return int(goalies[0]) if len(goalies) else 0


def blur(world: Any, frame: Frame, rng: np.random.Generator) -> None:
    """Move everything that the log rounds to another value that rounds to the logged one."""
    world["pos"] += rng.uniform(-_POS, _POS, (23, 2))
    world["vel"] += np.where(world["vel"] != 0.0, rng.uniform(-_VEL, _VEL, (23, 2)), 0.0)
    for name in ("body", "neck"):
        world[name] += np.radians(rng.uniform(-_ANGLE, _ANGLE, PLAYERS))
        world[f"{name}_staged"] = world[name]


def half_digit(values: Array) -> Array:
    """Half a unit of the sixth significant digit of every number."""
    size = np.abs(values)
    return np.where(size > 0.0, 0.5 * 10.0 ** (np.floor(np.log10(np.maximum(size, 1e-12))) - 5.0), 0.0)


def _note(found: dict[str, Any], world: Any, name: str, told: Array, own: Array, error: Array, limit: Array) -> None:
    """Add the players whose `error` exceeds `limit` to what was found."""
    for row in np.flatnonzero((error > limit) & (world["enabled"] != 0)):
        values = (name, float(told[row]), float(own[row]), float(limit[row]))
        found.setdefault(KEYS[row], []).append(values)


def rounding(world: Any, bounds: Envelope) -> tuple[Array, Array]:
    """How far the rounding of the log can carry position and velocity of every object in one cycle, (23,) each.

    Position and velocity before (half a unit each, in two directions), the result, the angle and effort behind an acceleration; for
    the ball the place and angle from which it was kicked (specification/simulator.md 4.3).
    """
    diagonal = np.sqrt(2.0)
    acceleration = np.zeros(23)
    acceleration[1:] = np.radians(_ANGLE) + 2e-6
    kicked = bool((world["bits_shown"] & int(PlayerBit.KICK | PlayerBit.TACKLE | PlayerBit.CATCH)).any())
    acceleration[BALL] = 1.5e-3 if kicked else 0.0
    pos = 2.0 * _POS * diagonal + _VEL * diagonal + acceleration + 1e-6
    vel = (_VEL * diagonal + acceleration) * bounds.decay + _VEL * diagonal + 1e-6
    hit_players, hit_ball = struck(world["bits_shown"])
    hit = np.concatenate([[hit_ball], hit_players])
    return np.where(hit, 4.0 * pos, pos), vel


def turn_rounding(packed: Any, world: Any, bounds: Envelope) -> Array:
    """How far the rounding of the speed can carry the angle (degrees) of a player who turns, (22,)."""
    inertia = packed["types"][world["type"], TypeColumn.INERTIA_MOMENT]
    return np.where(bounds.turning > 1e-9, bounds.turning * inertia * _VEL * 1.5, 0.0)


def around(
    packed: Any,
    bounds: Envelope,
    pos: Array,
    vel: Array,
    told: Array,
    world: Any,
    place: Array,
    speed: Array,
    pos_slack: Array,
    vel_slack: Array,
    share: float,
) -> tuple[Array, Array, Array, Array]:
    """Distances of a logged state from the noise envelope's middle, and the limits: rounding, noise, and what a collision can push.

    Parameters
    ----------
    packed : record of PARAMETERS
    bounds : Envelope
        Of the step without noise and without referee.
    pos, vel : (23, 2) arrays
        As logged.
    told : (23,) bool
        Who collided, by the log.
    world : record of WORLD
        After the simulator's own step.
    place, speed : (23,) arrays
        Distances of the logged from the simulator's own state.
    pos_slack, vel_slack : (23,) arrays
        What rounding allows.
    share : float
        Radii allowed between the logged and the simulator's own state: 1 if that is without noise, 2 if both have some.
    """
    kept = np.where(told, -BOUNCE, 1.0) * bounds.decay
    free_place = np.hypot(*(pos - bounds.start - bounds.move).T)
    free_speed = np.hypot(*(vel - kept[:, None] * bounds.move).T)
    reach = np.where(told, 1.2, 0.0)
    free_inside = (free_place <= bounds.radius + pos_slack + reach) & (free_speed <= np.abs(kept) * bounds.radius + vel_slack)
    # what was put somewhere (by the referee, by its goalie, by a goal post) is judged by where the simulator put it: a ball that is
    # held goes where its catcher goes and turns; who is cleared from the ball goes to the edge of a circle round it, and the nearer
    # he stood, the more his direction is noise
    carried, catcher = bounds.radius[BALL], int(world["ball_catcher"])
    if catcher:
        arm = packed["types"][world["type"][catcher - 1], TypeColumn.PLAYER_SIZE] + packed["ball_size"]
        carried += bounds.radius[catcher] + arm * np.radians(bounds.turn[catcher - 1])
    target = bounds.start + bounds.move
    own_hit = np.concatenate([[struck(world["bits_shown"])[1]], struck(world["bits_shown"])[0]])
    own_move = np.where(own_hit, -BOUNCE, 1.0)[:, None] * bounds.decay[:, None] * bounds.move
    put = np.hypot(*(world["pos"] - target).T) > (share - 1.0) * bounds.radius + 1e-6
    put |= np.hypot(*(world["vel"] - own_move).T) > (share - 1.0) * bounds.radius * bounds.decay + 1e-6
    near = np.maximum(np.hypot(*(target - world["pos"][BALL]).T), 0.05)
    stretch = np.maximum(3.0, CLEARED / near)
    stretch[BALL] = 3.0
    own_limit = stretch * (share * (bounds.radius + carried) + pos_slack)
    free_limit, own_speed_limit = bounds.radius + pos_slack + reach, share * bounds.radius * bounds.decay + vel_slack
    use_own = put & ~free_inside
    return (
        np.where(use_own, place, free_place),
        np.where(use_own, speed, free_speed),
        np.where(use_own, own_limit, free_limit),
        np.where(use_own, own_speed_limit, np.abs(kept) * bounds.radius + vel_slack),
    )
