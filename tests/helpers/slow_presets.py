"""The feature vectors of the presets as plain formulas over angles, the oracle of the kernels in `cprm_gym.envs.kernels`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cprm_gym.envs.observations import BodyFeature
from cprm_gym.envs.pitch import Pitch, wrapped
from cprm_gym.simulator.pitch import HALF_LENGTH, HALF_WIDTH, PENALTY_X, PENALTY_Y, PITCH_WIDTH
from cprm_gym.simulator.player_types import T_KICKABLE_SQUARED, T_PLAYER_SPEED_MAX
from cprm_gym.simulator.state import CommandKind, Count

RECENT = 30


class Scale:
    """What the vectors are measured against: lengths of the pitch and the parameters of server and players.

    Attributes
    ----------
    diagonal : float
        Longest distance in half a pitch, m: proximity is 1 at 0 m and -1 there and beyond.
    post : float
        |y| of the inner edges of the goal posts, m.
    marks : (11, 2) float array
        Landmarks of HFO: goal centre, goal posts, penalty box centre and corners, centre of the field, corners of the half.
    """

    def __init__(self, pitch: Pitch) -> None:
        p = pitch.parameters
        self.diagonal = math.hypot(HALF_LENGTH, PITCH_WIDTH)
        self.post = p.goal_width / 2
        self.ball_speed, self.stamina = p.ball_speed_max, p.stamina_max
        self.marks = np.array(
            [
                (HALF_LENGTH, 0.0), (HALF_LENGTH, -self.post), (HALF_LENGTH, self.post), (PENALTY_X, 0.0), (PENALTY_X, -PENALTY_Y),
                (PENALTY_X, PENALTY_Y), (0.0, 0.0), (0.0, -HALF_WIDTH), (HALF_LENGTH, -HALF_WIDTH), (HALF_LENGTH, HALF_WIDTH),
                (0.0, HALF_WIDTH),
            ]
        )  # fmt: skip

    def near(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Proximity of what lies (x, y) away."""
        return np.asarray(1.0 - 2.0 * np.minimum(np.hypot(x, y), self.diagonal) / self.diagonal)

    @staticmethod
    def of_types(pitch: Pitch, column: int, players: np.ndarray) -> np.ndarray:
        """A column of the player types, for the players at rows ``players``, (W, ...)."""
        return np.asarray(pitch.packed["types"][pitch.sim.world["type"][:, players], column])

    def kickable(self, pitch: Pitch, m: np.ndarray) -> np.ndarray:
        """(W, A) bool: the player remembers the ball within his reach."""
        squared = self.of_types(pitch, T_KICKABLE_SQUARED, pitch.players - 1)
        return np.asarray((m["ball_age"] <= 2) & ((m["ball_x"] - m["x"]) ** 2 + (m["ball_y"] - m["y"]) ** 2 <= squared))


class SlowPreset:
    """Computes the vectors of a `SoccerCore` whose worlds all play on; called once before the first step and after every step."""

    def __init__(self, pitch: Any) -> None:
        self.name, self.scale = pitch.preset.name, Scale(pitch)
        self.mates, self.opponents = pitch.preset.mates, pitch.preset.opponents
        self.kicks = np.zeros((pitch.worlds, len(pitch.players)), np.int64)

    def __call__(self, pitch: Any) -> np.ndarray:
        """(W, A, entries) float32."""
        kicks = pitch.sim.world["counts"][:, pitch.players - 1, Count.KICK].astype(np.int64)
        tried = pitch.sim.commands["kind"][:, pitch.players - 1] == CommandKind.KICK
        self.possible = np.where(tried & (kicks == self.kicks) & (pitch.cycle[:, None] > 0), -1.0, 1.0)
        self.kicks = kicks
        parts = _VECTORS[self.name](pitch, pitch.remembered()[:, pitch.players - 1], self)
        vector = np.stack(np.broadcast_arrays(*parts), axis=-1)
        return np.clip(np.nan_to_num(vector), -1.0, 1.0).astype(np.float32)


def _turned(angle: np.ndarray) -> list[np.ndarray]:
    return [np.sin(angle), np.cos(angle)]


def _moving(vx: np.ndarray, vy: np.ndarray, angle: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """Whether something moves, and the sine and cosine of its direction relative to `angle`: zeros at rest, where there is none."""
    moves = np.hypot(vx, vy) > 0.0
    return moves, [np.where(moves, v, 0.0) for v in _turned(np.arctan2(vy, vx) - angle)]


def _mates(pitch: Pitch, mates: int) -> np.ndarray:
    """(A, mates) memory indices of each agent's team-mates, by number."""
    own = (pitch.players - 1) % 11
    return np.array([[k for k in range(mates + 1) if k != me][:mates] for me in own], np.int64).reshape(len(own), mates)


def _others(m: np.ndarray, index: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, y and whether known, each (W, A, n), of the players at memory indices (A, n)."""
    pick = np.broadcast_to(index, (*m.shape, index.shape[-1]))
    x, y, age = (np.take_along_axis(m[name], pick, axis=-1) for name in ("px", "py", "age"))
    return x, y, age <= RECENT


def _hfo_low(pitch: Pitch, m: np.ndarray, preset: SlowPreset) -> list[np.ndarray]:
    """Low-level features (HFO manual, "Low Level Feature Set"), from memory; angles relative to the body."""
    body, scale = pitch.observation["body"], preset.scale
    x, y, angle = m["x"], m["y"], m["body"]
    fastest = scale.of_types(pitch, T_PLAYER_SPEED_MAX, pitch.players - 1)
    known = np.where(m["located"] > 0, 1.0, -1.0)
    speed = np.hypot(m["vx"], m["vy"])
    moves, way = _moving(m["vx"], m["vy"], angle)
    parts = [known, np.where(moves, 1.0, -1.0), *way, 2 * speed / fastest - 1, *_turned(angle), 2 * m["stamina"] / scale.stamina - 1.0]
    parts += [np.where(m["free"] > 0, -1.0, 1.0)]
    parts += [2.0 * body[..., f] - 1.0 for f in (BodyFeature.COLLIDED_BALL, BodyFeature.COLLIDED_PLAYER, BodyFeature.COLLIDED_POST)]
    parts += [np.where(scale.kickable(pitch, m), 1.0, -1.0)]
    for px, py in scale.marks:
        parts += [*_turned(np.arctan2(py - y, px - x) - angle), scale.near(px - x, py - y)]
    lines = (x, HALF_LENGTH - x, y + HALF_WIDTH, HALF_WIDTH - y)
    parts += [1 - 2 * np.clip(v, 0.0, scale.diagonal) / scale.diagonal for v in lines]
    seen = m["ball_age"] <= RECENT
    dx, dy = m["ball_x"] - x, m["ball_y"] - y
    ball = [*_turned(np.arctan2(dy, dx) - angle), scale.near(dx, dy)]
    parts += [np.where(seen, 1.0, -1.0), *(np.where(seen, v, 0.0) for v in ball)]
    rolls, way = _moving(m["ball_vx"], m["ball_vy"], angle)
    roll = [2 * np.hypot(m["ball_vx"], m["ball_vy"]) / scale.ball_speed - 1, *way]
    parts += [np.where(seen & rolls, 1.0, -1.0), *(np.where(seen, v, 0.0) for v in roll)]
    index = np.concatenate([_mates(pitch, preset.mates - 1), np.tile(11 + np.arange(preset.opponents), (len(pitch.players), 1))], axis=1)
    ox, oy, there = _others(m, index)
    bodies = _bodies_seen(pitch, index, m)
    for k in range(index.shape[1]):
        dx, dy = ox[..., k] - x, oy[..., k] - y
        place = [*_turned(np.arctan2(dy, dx) - angle), scale.near(dx, dy)]
        parts += [np.where(there[..., k], v, 0.0) for v in place]
        parts += [v[..., k] for v in bodies]
    numbers = np.where(index < 11, index, index - 11) + 1
    parts += [np.where(there[..., k], numbers[:, k] / 11.0, 0.0) for k in range(index.shape[1])]
    parts.append(preset.possible)
    return parts


def _bodies_seen(pitch: Pitch, index: np.ndarray, m: np.ndarray) -> list[np.ndarray]:
    """Body direction (sin, cos), speed and direction of motion (sin, cos) of the players seen in this cycle; zeros for the others."""
    o = pitch.observation
    left = pitch.players <= 11
    rows = np.where(left[:, None], index, np.where(index < 11, index + 11, index - 11))
    pick = np.broadcast_to(rows, (*m.shape, index.shape[1]))
    level = np.take_along_axis(o["level"][..., 1:], pick, axis=-1)
    values = np.take_along_axis(o["players"], pick[..., None], axis=-2)
    neck = m["neck"][..., None]
    body = values[..., 4] + neck
    seen = level >= 3
    across, along = values[..., 3] * values[..., 0], values[..., 2]
    bearing = values[..., 1] + neck
    own = np.arctan2(m["vy"], m["vx"]) - m["body"]
    speed_own = np.hypot(m["vx"], m["vy"])
    fastest = Scale.of_types(pitch, T_PLAYER_SPEED_MAX, rows)
    vx = along * np.cos(bearing) - across * np.sin(bearing) + (speed_own * np.cos(own))[..., None]
    vy = along * np.sin(bearing) + across * np.cos(bearing) + (speed_own * np.sin(own))[..., None]
    parts = [np.sin(body), np.cos(body), 2 * np.hypot(vx, vy) / fastest - 1, *_moving(vx, vy, np.zeros(vx.shape))[1]]
    return [np.where(seen, v, 0.0) for v in parts]


def _hfo_high(pitch: Pitch, m: np.ndarray, preset: SlowPreset) -> list[np.ndarray]:
    """High-level features (HFO manual, "High Level Feature Set"), from memory; the half field is -1 to 1 in both directions."""
    x, y, scale = m["x"], m["y"], preset.scale
    seen = m["ball_age"] <= RECENT
    opponents = _others(m, np.tile(11 + np.arange(preset.opponents), (len(pitch.players), 1)))
    team_index = _mates(pitch, preset.mates - 1)
    tx, ty, there = _others(m, team_index)
    parts = [_along(x), _across(y), m["body"] / math.pi]
    parts += [np.where(seen, _along(m["ball_x"]), 0.0), np.where(seen, _across(m["ball_y"]), 0.0)]
    parts += [np.where(scale.kickable(pitch, m), 1.0, -1.0), scale.near(HALF_LENGTH - x, -y), np.arctan2(-y, HALF_LENGTH - x) / math.pi]
    parts += [_goal_opening(scale, x, y, *opponents), _nearest(scale, x, y, *opponents)]
    team = range(preset.mates - 1)
    parts += [np.where(there[..., k], _goal_opening(scale, tx[..., k], ty[..., k], *opponents), 0.0) for k in team]
    parts += [np.where(there[..., k], _nearest(scale, tx[..., k], ty[..., k], *opponents), 0.0) for k in team]
    parts += [np.where(there[..., k], _pass_opening(x, y, tx[..., k], ty[..., k], *opponents), 0.0) for k in team]
    for k in team:
        numbers = (team_index[:, k] + 1) / 11.0
        parts += [np.where(there[..., k], v, 0.0) for v in (_along(tx[..., k]), _across(ty[..., k]), numbers)]
    ox, oy, known = opponents
    for k in range(preset.opponents):
        parts += [np.where(known[..., k], v, 0.0) for v in (_along(ox[..., k]), _across(oy[..., k]), (k + 1) / 11.0)]
    return [*parts, preset.possible, 2 * m["stamina"] / scale.stamina - 1.0]


def _along(x: np.ndarray) -> np.ndarray:
    """x in the half field, -1 at the halfway line, 1 at the goal line."""
    return 2.0 * x / HALF_LENGTH - 1.0


def _across(y: np.ndarray) -> np.ndarray:
    return y / HALF_WIDTH


def _goal_opening(scale: Scale, x: np.ndarray, y: np.ndarray, ox: np.ndarray, oy: np.ndarray, known: np.ndarray) -> np.ndarray:
    """The widest part of the goal that no opponent covers, seen from (x, y), as share of 90 degrees mapped to [-1, 1]."""
    rays = np.linspace(-scale.post, scale.post, 29)
    directions = np.arctan2(rays - y[..., None], HALF_LENGTH - x[..., None])
    dx, dy = ox - x[..., None], oy - y[..., None]
    distance = np.hypot(dx, dy)
    nearer = known & (dx < (HALF_LENGTH - x)[..., None])
    half = np.arctan2(0.5, np.maximum(distance, 0.3))
    off = np.abs(wrapped(np.arctan2(dy, dx)[..., None] - directions[..., None, :]))
    free = ~((off < half[..., None]) & nearer[..., None]).any(axis=-2)
    width = np.abs(np.diff(directions, axis=-1))
    best, run = np.zeros_like(x), np.zeros_like(x)
    for k in range(width.shape[-1]):
        run = np.where(free[..., k] & free[..., k + 1], run + width[..., k], 0.0)
        best = np.maximum(best, run)
    return 2.0 * np.minimum(best / (math.pi / 2), 1.0) - 1.0


def _nearest(scale: Scale, x: np.ndarray, y: np.ndarray, ox: np.ndarray, oy: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Proximity of the nearest known opponent; -1 when there is none."""
    if ox.shape[-1] == 0:
        return np.full(x.shape, -1.0)
    near: np.ndarray = np.where(known, scale.near(ox - x[..., None], oy - y[..., None]), -1.0).max(axis=-1)
    return near


def _pass_opening(
    x: np.ndarray, y: np.ndarray, tx: np.ndarray, ty: np.ndarray, ox: np.ndarray, oy: np.ndarray, known: np.ndarray
) -> np.ndarray:
    """Angle between the way to a team-mate and the opponent nearest to it, as share of 180 degrees mapped to [-1, 1]."""
    if ox.shape[-1] == 0:
        return np.ones(x.shape)
    dx, dy = ox - x[..., None], oy - y[..., None]
    nearer = known & (np.hypot(dx, dy) < np.hypot(tx - x, ty - y)[..., None] + 1.0)
    off = np.abs(wrapped(np.arctan2(dy, dx) - np.arctan2(ty - y, tx - x)[..., None]))
    least: np.ndarray = np.where(nearer, off, math.pi).min(axis=-1)
    return 2.0 * least / math.pi - 1.0


def _keepaway(pitch: Pitch, m: np.ndarray, preset: SlowPreset) -> list[np.ndarray]:
    """State variables of Stone, Sutton and Kuhlmann (2005), K1 being the observer, others by distance from him.

    Distances are divided by the diagonal of the region (the pitch for other tasks), angles by pi.
    """
    scale = 2.0 * math.hypot(*pitch.region)
    x, y = m["x"][..., None], m["y"][..., None]
    kx, ky, _ = _others(m, _mates(pitch, preset.mates - 1))
    tx, ty, _ = _others(m, np.tile(11 + np.arange(preset.opponents), (len(pitch.players), 1)))

    def by_distance(ax: np.ndarray, ay: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        order = np.argsort(np.hypot(ax - x, ay - y), axis=-1, kind="stable")
        return np.take_along_axis(ax, order, -1), np.take_along_axis(ay, order, -1)

    kx, ky = by_distance(kx, ky)
    tx, ty = by_distance(tx, ty)
    between = np.hypot(kx[..., :, None] - tx[..., None, :], ky[..., :, None] - ty[..., None, :])
    bearing_k, bearing_t = np.arctan2(ky - y, kx - x), np.arctan2(ty - y, tx - x)
    angle = np.abs(wrapped(bearing_k[..., :, None] - bearing_t[..., None, :]))
    lengths = [np.hypot(x, y), np.hypot(kx, ky), np.hypot(tx, ty), np.hypot(kx - x, ky - y), np.hypot(tx - x, ty - y)]
    lengths += [between.min(axis=-1, initial=scale)]
    vector = np.concatenate([v / scale for v in lengths] + [angle.min(axis=-1, initial=math.pi) / math.pi], axis=-1)
    return [vector[..., i] for i in range(vector.shape[-1])]


_VECTORS = {"hfo_low": _hfo_low, "hfo_high": _hfo_high, "keepaway": _keepaway}
