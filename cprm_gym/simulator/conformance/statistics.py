"""Recordings of chance: distributions and frequencies of a real server against those of the simulator.

Every recorded row is played once more, all rows at once in as many worlds; the same statistic is formed of the recorded and of
the simulated outcome, and the two samples are compared: Kolmogorov-Smirnov for numbers, chi-square for counts. A check passes
with p >= 0.001.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats

from ...errors import FormatError
from ..kernels.motion import WIND_WEIGHT
from ..player_types import TypeColumn
from ..protocol.commands import parse_trainer
from ..simulator import Simulator
from ..state import BALL, CommandKind, PlayerBit, PlayMode
from .envelope import calm
from .recording import Recording
from .report import Check, Result

Array = npt.NDArray[Any]
LIMIT = 0.001
SEED = 20240607
_FAR = (200.0, 200.0)


def same_distribution(result: Result, name: str, recorded: Array, simulated: Array) -> None:
    """Two-sample Kolmogorov-Smirnov test."""
    outcome = stats.ks_2samp(recorded, simulated)
    detail = f"Kolmogorov-Smirnov of {len(recorded)} recorded and {len(simulated)} simulated, D = {outcome.statistic:.4f}"
    result.checks.append(Check(f"{name}: p", float(outcome.pvalue), LIMIT, detail))


def same_counts(result: Result, name: str, pairs: Sequence[tuple[Sequence[int], Sequence[int]]]) -> None:
    """Chi-square test over tables of two rows, recorded and simulated counts of the same outcomes; the statistics add up."""
    total, freedom = 0.0, 0
    for recorded, simulated in pairs:
        table = np.array([recorded, simulated], float)
        table = table[:, table.sum(axis=0) > 0]
        if table.shape[1] > 1 and (table.sum(axis=1) > 0).all():
            outcome = stats.chi2_contingency(table, correction=False)
            total, freedom = total + float(outcome.statistic), freedom + int(outcome.dof)
    chance = float(stats.chi2.sf(total, freedom)) if freedom else 1.0
    detail = f"chi-square {total:.1f} with {freedom} degrees of freedom, {len(pairs)} situations"
    result.checks.append(Check(f"{name}: p", chance, LIMIT, detail))


def same_proportions(result: Result, name: str, pairs: Sequence[tuple[Sequence[int], Sequence[int]]]) -> None:
    """Fisher's exact test of every table of two outcomes; the smallest p times their number (Bonferroni) counts."""
    chances = [float(stats.fisher_exact(np.array(pair)).pvalue) for pair in pairs]
    worst = min(1.0, min(chances, default=1.0) * max(len(chances), 1))
    result.checks.append(Check(f"{name}: p", worst, LIMIT, f"smallest of {len(chances)} exact tests, times their number"))


# --- a batch of worlds, one per row


def batch(recording: Recording, worlds: int, rows: Sequence[int] = (0,)) -> Simulator:
    """A simulator of `worlds` worlds in play_on, with the players `rows` (0..21) at rest in the centre and nobody else."""
    single = recording.simulator()
    simulator = Simulator(
        worlds,
        single.parameters,
        single.player_parameters,
        single.types,
        SEED,
        left=11,
        right=11,
        goalies=(1, 1) if recording.header["goalies"] else (0, 0),
    )
    world = simulator.world
    world["mode"], world["time"] = PlayMode.play_on, 1
    world["enabled"] = 0
    for row in rows:
        world["enabled"][:, row] = 1
    world["protocol"] = max(recording.header["client_versions"].values(), default=19)
    world["synchronous"] = 1
    world["pos"], world["vel"], world["acc"] = 0.0, 0.0, 0.0
    world["pos"][:, BALL] = _FAR
    world["body"] = world["body_staged"] = 0.0
    world["arm_timer"] = simulator.parameters.point_to_duration
    return simulator


def both_ways(simulator: Simulator) -> tuple[Array, Array]:
    """The worlds after one step of the commands in the buffer: without noise, and with it."""
    start = simulator.snapshot()
    noisy, simulator.packed = simulator.packed, calm(simulator.packed)
    simulator.step()
    quiet = simulator.snapshot()
    simulator.restore(start)
    simulator.packed = noisy
    simulator.step()
    return quiet, simulator.world


class Rows:
    """Rows of a recording by column name."""

    def __init__(self, record: dict[str, Any]) -> None:
        self.columns: list[str] = record["columns"]
        self.values = np.array(record["rows"], float)

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, name: str) -> Array:
        return self.values[:, self.columns.index(name)]

    def __contains__(self, name: str) -> bool:
        return name in self.columns

    def pair(self, x: str, y: str) -> Array:
        """Two columns, shape (n, 2)."""
        return np.stack([self[x], self[y]], axis=1)


def fractions(moved: Array, calm_moved: Array, radius: Array) -> tuple[Array, Array]:
    """Length of the noise as share of its bound, and its direction to that of the motion; where there is a bound."""
    noise = moved - calm_moved
    on = radius > 1e-7
    turn = np.angle(np.exp(1j * (np.arctan2(noise[:, 1], noise[:, 0]) - np.arctan2(calm_moved[:, 1], calm_moved[:, 0]))))
    return np.hypot(noise[:, 0], noise[:, 1])[on] / radius[on], turn[on]


def turned_share(after: Array, quiet: Array, before: Array, rand: float) -> Array:
    """Noise of a turn as share of its bound, -1 to 1; all angles in degrees."""
    turned = (quiet - before + 180.0) % 360.0 - 180.0
    noise = (after - quiet + 180.0) % 360.0 - 180.0
    on = np.abs(turned) > 1e-6
    share: Array = noise[on] / (turned[on] * rand)
    return share


# --- noise of players


def player_rows(recording: Recording, result: Result, record: dict[str, Any]) -> None:
    """Dashes, turns and free motion of one player."""
    rows, name = Rows(record), str(record["set"])
    simulator = batch(recording, len(rows))
    world, commands = simulator.world, simulator.commands
    world["pos"][:, 1], world["vel"][:, 1] = rows.pair("bx", "by"), rows.pair("bvx", "bvy")
    world["body"][:, 0] = world["body_staged"][:, 0] = np.radians(rows["bbody"])
    if "power" in rows:
        commands["kind"][:, 0], commands["a"][:, 0], commands["b"][:, 0] = CommandKind.DASH, rows["power"], rows["dir"]
    elif "moment" in rows:
        commands["kind"][:, 0], commands["a"][:, 0] = CommandKind.TURN, rows["moment"]
    elif "left_power" in rows:
        commands["kind"][:, 0] = CommandKind.DASH_LEGS
        for field, column in (("a", "left_power"), ("c", "right_power")):
            commands[field][:, 0] = rows[column]
        commands["b"][:, 0] = commands["d"][:, 0] = 0.0
    start = rows.pair("bx", "by")
    quiet, noisy = both_ways(simulator)
    rand = simulator.parameters.player_rand
    way = quiet["pos"][:, 1] - start
    radius = rand * np.hypot(way[:, 0], way[:, 1])
    recorded = fractions(rows.pair("ax", "ay") - start, way, radius)
    own = fractions(noisy["pos"][:, 1] - start, way, radius)
    result.cycles += len(rows)
    if len(recorded[0]):
        same_distribution(result, f"{name}, length of the noise", recorded[0], own[0])
        same_distribution(result, f"{name}, direction of the noise", recorded[1], own[1])
    before, angle = rows["bbody"], np.degrees(quiet["body"][:, 0])
    told = turned_share(rows["abody"], angle, before, rand)
    if len(told):
        same_distribution(result, f"{name}, noise of the turn", told, turned_share(np.degrees(noisy["body"][:, 0]), angle, before, rand))


# --- noise of the ball


def ball_rows(recording: Recording, result: Result, record: dict[str, Any]) -> None:
    """Free balls, kicks and tackles."""
    rows, name = Rows(record), str(record["set"])
    simulator = batch(recording, len(rows))
    world, commands = simulator.world, simulator.commands
    start = rows.pair("bx", "by") if "bx" in rows else rows.pair("x", "y")
    world["pos"][:, BALL], world["vel"][:, BALL] = start, rows.pair("bvx", "bvy")
    result.cycles += len(rows)
    if name == "free_ball":
        world["pos"][:, 1] = _FAR
        kappa = np.zeros(len(rows))
    elif name == "kick":
        world["body"][:, 0] = world["body_staged"][:, 0] = np.radians(rows["body"])
        commands["kind"][:, 0], commands["a"][:, 0], commands["b"][:, 0] = CommandKind.KICK, rows["power"], rows["dir"]
        kappa = np.full(len(rows), 2.0) * simulator.packed["types"][0, 0, TypeColumn.KICK_RAND] * np.abs(rows["power"]) / 100.0
    elif name == "tackle":
        commands["kind"][:, 0], commands["a"][:, 0], commands["b"][:, 0] = CommandKind.TACKLE, rows["angle"], 0.0
        _tackle_successes(result, simulator, rows)
        world["forced_tackle"][:, 0] = 1
        kappa = np.full(len(rows), 4.0) * simulator.packed["types"][0, 0, TypeColumn.KICK_RAND]
    else:
        raise FormatError(f"{recording.path}: unknown set of ball rows {name!r}")
    quiet, noisy = both_ways(simulator)
    way = quiet["pos"][:, BALL] - start
    radius = kappa + simulator.parameters.ball_rand * np.hypot(way[:, 0], way[:, 1])
    told_alone, own_alone, quiet_alone = np.ones(len(rows), bool), _untouched(noisy), _untouched(quiet)
    if "player_ax" in rows:
        told_alone = (rows["player_ax"] == 0.0) & (rows["player_ay"] == 0.0)
    if name == "tackle":  # the noise depends on how likely the failure was: the same rows of both
        won = rows["success_guess"] == 1.0
        told_alone, own_alone = told_alone & won, own_alone & won
    told_way = rows.pair("ax", "ay") - start
    told, own = quiet_alone & told_alone, quiet_alone & own_alone
    recorded = fractions(told_way[told], way[told], radius[told])
    simulated = fractions((noisy["pos"][:, BALL] - start)[own], way[own], radius[own])
    same_distribution(result, f"{name}, length of the noise", recorded[0], simulated[0])
    same_distribution(result, f"{name}, direction of the noise", recorded[1], simulated[1])


# --- wind


def winds(recording: Recording, result: Result) -> None:
    """Steps of a moving ball and player in a wind with randomness: every push within its bounds, and distributed as the simulator's."""
    steps = [step for record in recording.records for step in record["steps"]]
    simulator = batch(recording, len(steps))
    world, p = simulator.world, simulator.packed[0]
    for row, step in enumerate(steps):
        for text in step["trainer"]:
            what, x, y, _, vx, vy = parse_trainer(text).args
            number = BALL if what == ("ball",) else 1
            world["pos"][row, number], world["vel"][row, number] = (x, y), (vx, vy)
    start = simulator.snapshot()
    simulator.step()
    result.cycles += len(steps)
    weights = {BALL: p["ball_weight"], 1: p["player_weight"]}
    for number, name in ((BALL, "ball"), (1, "l1")):
        told = np.array([(step["state"]["ball"] if number == BALL else step["state"]["pl"]["l1"][1:])[:2] for step in steps])
        speed = np.hypot(*start["vel"][:, number].T)[:, None]
        unit = speed / (weights[number] * WIND_WEIGHT)
        for axis, letter in enumerate("xy"):
            pushes = [
                ((moved - start["pos"][:, number] - start["vel"][:, number]) / unit - world["wind"])[:, axis] / p["wind_rand"]
                for moved in (told, world["pos"][:, number])
            ]
            excess = max(float(np.abs(pushes[0]).max()) - 1.0, 0.0)
            result.number(recording.scenario, 0, name, f"wind in {letter} beyond its bounds", 0.0, excess, 1e-6)
            same_distribution(result, f"wind in {letter}, {name}", *pushes)


def _untouched(world: Array) -> Array:
    """Worlds in which the ball did not run into the player."""
    return (world["bits_shown"][:, 0] & int(PlayerBit.BALL_COLLIDE)) == 0


def _tackle_successes(result: Result, simulator: Simulator, rows: Rows) -> None:
    """Frequency of success at every place of the ball."""
    start = simulator.snapshot()
    simulator.step()
    won = (simulator.world["bits_shown"][:, 0] & int(PlayerBit.TACKLE | PlayerBit.TACKLE_FAULT)) == int(PlayerBit.TACKLE)
    # a success that hardly moves the ball is not recognised as one in the recording: backward tackles have no power
    clear = np.hypot(*(simulator.world["pos"][:, BALL] - start["pos"][:, BALL] - start["vel"][:, BALL]).T) > 0.5
    simulator.restore(start)
    told = rows["success_guess"] == 1.0
    strong = np.zeros(len(rows), bool)
    places = np.round(rows.values[:, [rows.columns.index(name) for name in ("x", "y", "angle", "bvx", "bvy")]], 6)
    kinds, which = np.unique(places, axis=0, return_inverse=True)
    which = which.ravel()
    for kind in range(len(kinds)):
        strong[which == kind] = clear[(which == kind) & won].all() if ((which == kind) & won).any() else True
    spots, spot = np.unique(places[:, :2], axis=0, return_inverse=True)
    pairs = []
    for number in range(len(spots)):
        on = (spot.ravel() == number) & strong
        if on.any():
            pairs.append(((int(told[on].sum()), int((~told[on]).sum())), (int(won[on].sum()), int((~won[on]).sum()))))
    same_counts(result, "tackle, success", pairs)
