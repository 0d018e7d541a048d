"""Observation presets: numbers to learn from, the whole percept, the truth, or the feature vectors of the literature.

``normalised``, the default, is `cprm_gym.envs.vectors.normalised`. ``raw`` and ``memory`` are the Dict of `cprm_gym.envs.observations`;
``full`` is the same Dict without noise and without limits of sight;
``hfo_low``, ``hfo_high`` and ``keepaway`` are vectors computed from the player's own memory of what he perceived (`players.memory`) by
kernels of those names, all entries in [-1, 1]. What is unknown is 0 there, where HFO writes -2; a flag says so wherever HFO has one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from gymnasium import spaces

from ..errors import UnknownName, unknown_name
from ..simulator.pitch import HALF_LENGTH, HALF_WIDTH, PENALTY_X, PENALTY_Y, PITCH_WIDTH
from ..simulator.state import PLAYERS
from .kernels import observations as kernels
from .kernels.hfo_high import hfo_high
from .kernels.hfo_low import hfo_low
from .kernels.keepaway import keepaway
from .observations import BodyFeature, with_mask
from .pitch import Pitch
from .vectors.normalised import Normalised

PRESETS = ("normalised", "raw", "memory", "full", "hfo_low", "hfo_high", "keepaway")
"""Names of the presets."""
VECTORS = ("hfo_low", "hfo_high", "keepaway")
"""Those that are one vector."""
REMEMBERED = ("normalised", *VECTORS)
"""Those that are made from the players' memories."""
TEAM = PLAYERS // 2


class Scale:
    """What the vectors are measured against: lengths of the pitch and the parameters of the server.

    Attributes
    ----------
    diagonal : float
        Longest distance in half a pitch, m: proximity is 1 at 0 m and -1 there and beyond.
    post : float
        |y| of the inner edges of the goal posts, m.
    ball_speed, stamina : float
        ``ball_speed_max`` and ``stamina_max``.
    marks : (2, 11) float array
        x and y of the landmarks of HFO: goal centre, goal posts, penalty box centre and corners, centre of the field, corners of the half.
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
        ).T.copy()  # fmt: skip


def check_preset(name: str) -> str:
    """`name`, if there is such a preset.

    Raises
    ------
    UnknownName
        Listing those that there are.
    """
    if name not in PRESETS:
        raise unknown_name("observation preset", name, PRESETS)
    return name


class Preset:
    """Turns the engine's observation arrays into what the faces hand out.

    Parameters
    ----------
    pitch : Pitch
    name : str
        One of `PRESETS`.
    flatten : bool
        Hand out one vector (the parts in the order of the space's keys), whatever the preset.

    Attributes
    ----------
    space : gymnasium.spaces.Space
        Of one agent's observation.
    names : tuple of str
        For ``normalised`` and the vectors of the literature: what each entry of the vector is.
    vector : (W, A, entries) float32 array
        The vectors of all agents, overwritten in every cycle; of no entries where the observation is the engine's own arrays.
    kicks : (W, A) int array
        Kicks with effect of each agent, until the last cycle.
    drawn : (W, A) int array
        What the entries of ``hfo_high`` about others rest on (`kernels.hfo_high.picture`).
    """

    def __init__(
        self, pitch: Pitch, name: str, flatten: bool, plain: spaces.Dict, task_features: tuple[tuple[str, float, float], ...] = ()
    ) -> None:
        self.name = name
        self.flatten = flatten
        self.names: tuple[str, ...] = ()
        self._parts = tuple(name for name in plain.spaces if name != "action_mask")
        self.scale = Scale(pitch)
        self.kicks = np.zeros((pitch.worlds, len(pitch.players)), np.int64)
        self.drawn = np.full((pitch.worlds, len(pitch.players)), -1)
        self._write: Callable[[Pitch, np.ndarray], None] | None = None
        self._normal: Normalised | None = None
        self._divided: dict[str, np.ndarray] = {}
        if name == "normalised":
            self._normal = Normalised(pitch, task_features)
            columns = self._normal.columns
            self.names = columns.names
            self.space: spaces.Space[Any] = columns.space(flatten)
            if flatten:
                self.space = with_mask(self.space, plain)  # type: ignore[arg-type]
            elif "action_mask" in plain.spaces:
                self.space = spaces.Dict({**self.space.spaces, "action_mask": plain["action_mask"]})  # type: ignore[attr-defined]
            self._write = self._normalised
        elif name in VECTORS:
            counts = {(pitch.counts[0], pitch.counts[1]) if p <= 11 else (pitch.counts[1], pitch.counts[0]) for p in pitch.players.tolist()}
            if len(counts) > 1:
                raise UnknownName(
                    f"observation preset {name!r}: its size depends on the number of players, and the controlled agents are of teams of "
                    f"different sizes ({pitch.counts[0]} and {pitch.counts[1]}); control one team, or use 'raw', 'memory' or 'full'"
                )
            self.mates, self.opponents = counts.pop() if counts else (pitch.counts[0], pitch.counts[1])
            self.names = _NAMES[name](self.mates - 1, self.opponents)
            self.space = with_mask(spaces.Box(-1.0, 1.0, (len(self.names),), np.float32), plain)
            self._write = {"hfo_low": self._hfo_low, "hfo_high": self._hfo_high, "keepaway": self._keepaway}[name]
            self._index(pitch)
        elif flatten:
            low = np.concatenate([plain[k].low.ravel() for k in self._parts])  # type: ignore[attr-defined]
            high = np.concatenate([plain[k].high.ravel() for k in self._parts])  # type: ignore[attr-defined]
            self.space = with_mask(spaces.Box(low, high, dtype=np.float32), plain)
        else:
            self.space = plain
        size = len(self.names) if self._write else len(low) if flatten else 0
        self.vector: np.ndarray = np.zeros((pitch.worlds, len(pitch.players), size), np.float32)
        if self._normal is not None and not flatten:
            self._divided = self._normal.columns.views(self.vector)

    def _index(self, pitch: Pitch) -> None:
        """Whom the entries of a vector are about, as memory indices, and room for what its kernel notes of one player."""
        own, mates, opponents = (pitch.players - 1) % 11, self.mates - 1, self.opponents
        self._mates = np.array([[k for k in range(self.mates) if k != me][:mates] for me in own], np.int64).reshape(len(own), mates)
        self._takers = 11 + np.arange(opponents)
        self._others = np.concatenate([self._mates, np.tile(self._takers, (len(own), 1))], axis=1)
        self._places, self._ways, self._sines = np.zeros((2, opponents)), np.zeros((7, PLAYERS)), np.zeros((3, PLAYERS))
        self._best, self._hiders = np.zeros((6, TEAM)), np.zeros(TEAM, np.int64)

    @property
    def plain(self) -> bool:
        """Whether the observations are the engine's own arrays."""
        return not self.flatten and self.name not in REMEMBERED

    def lasting(self, o: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The arrays that are handed out in every cycle, `o` being the engine's own; empty where it is one vector."""
        if self.plain or not self._divided:
            return o if self.plain else {}
        return {**self._divided, "action_mask": o["action_mask"]} if "action_mask" in o else self._divided

    def fill(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """Write the vectors made from memory of some worlds, (n,), whose percepts and memories have just been made."""
        if self._write is not None:
            self._write(pitch, worlds)

    def __call__(self, pitch: Pitch, worlds: np.ndarray) -> dict[str, np.ndarray] | np.ndarray:
        """The observations of all worlds and agents, those of `worlds`, (n,), being new."""
        o = pitch.observation
        if self.plain:
            return o
        if self._write is None:
            self._flatten(o, worlds)
        elif self._normal is not None and "task" in o:
            self._normal.add_task(o["task"], self.vector)
        if self._divided:
            return self.lasting(o)
        return {"observations": self.vector, "action_mask": o["action_mask"]} if "action_mask" in o else self.vector

    def _flatten(self, o: dict[str, np.ndarray], worlds: np.ndarray) -> None:
        """All parts of the observations one after the other."""
        shape, everywhere = self.vector.shape[:2], len(worlds) == len(self.vector)
        at = 0
        for part in self._parts:
            values = o[part].reshape(*shape, -1)
            into = self.vector[..., at : at + values.shape[2]]
            if everywhere:
                into[...] = values
            else:
                into[worlds] = values[worlds]
            at += values.shape[2]

    def _normalised(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """All parts of ``normalised``."""
        assert self._normal is not None
        self._normal.write(pitch, worlds, pitch.remembered(), self.vector)

    # ------------------------------------------------------------------ the vectors of the literature

    def _hfo_low(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """HFO manual, "Low Level Feature Set", from memory."""
        o, s, sim = pitch.observation, self.scale, pitch.sim
        hfo_low(
            sim.world, sim.packed, worlds, pitch.players, pitch.remembered(), sim.commands, pitch.cycle, o["body"],
            int(BodyFeature.COLLIDED_BALL), o["players"], o["level"], self._others, s.marks, s.diagonal, s.ball_speed, s.stamina,
            self._sines, self.kicks, self.vector,
        )  # fmt: skip

    def _hfo_high(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """HFO manual, "High Level Feature Set", from memory; the half field is -1 to 1 in both directions."""
        s, sim = self.scale, pitch.sim
        hfo_high(
            sim.world, sim.packed, worlds, pitch.players, pitch.remembered(), sim.commands, pitch.cycle, self._mates, self.opponents,
            s.post, s.diagonal, s.stamina, self._places, self._ways, self._best, self._hiders, self.kicks, self.drawn, self.vector,
        )  # fmt: skip

    def _keepaway(self, pitch: Pitch, worlds: np.ndarray) -> None:
        """State variables of Stone, Sutton and Kuhlmann (2005), K1 being the observer, others by distance from him.

        Distances are divided by the diagonal of the region (the pitch for other tasks), angles by pi.
        """
        scale = 2.0 * math.hypot(*pitch.region)
        keepaway(worlds, pitch.players, pitch.remembered(), self._mates, self._takers, scale, self._ways, self._best, self.vector)


def see_everything(pitch: Pitch, worlds: np.ndarray) -> None:
    """Overwrite the percepts of some worlds, (n,), in ``pitch.observation`` with the truth (HFO's ``--fullstate``)."""
    o = pitch.observation
    kernels.pack_truth(pitch.sim.world, worlds, pitch.players, o["body"], o["ball"], o["players"], o["level"], o["age"])


# ---------------------------------------------------------------------- the vectors


_SELF = ("valid", "velocity_valid", "velocity_sin", "velocity_cos", "speed", "body_sin", "body_cos", "stamina", "frozen",
         "touches_ball", "touches_player", "touches_post", "kickable")  # fmt: skip
_PLACES = ("goal", "goal_post_top", "goal_post_bottom", "box", "box_top", "box_bottom", "centre", "corner_top_left", "corner_top_right",
           "corner_bottom_right", "corner_bottom_left")  # fmt: skip
_PLAYER = ("sin", "cos", "proximity", "body_sin", "body_cos", "speed", "velocity_sin", "velocity_cos")


def hfo_low_names(mates: int, opponents: int) -> tuple[str, ...]:
    """What the 58 + 9 T + 9 O + 1 entries of ``hfo_low`` are."""
    names = list(_SELF)
    names += [f"{place}_{k}" for place in _PLACES for k in ("sin", "cos", "proximity")]
    names += ["near_left_line", "near_right_line", "near_top_line", "near_bottom_line"]
    names += ["ball_valid", "ball_sin", "ball_cos", "ball_proximity", "ball_velocity_valid", "ball_speed", "ball_velocity_sin",
              "ball_velocity_cos"]  # fmt: skip
    others = [f"mate_{k + 1}" for k in range(mates)] + [f"opponent_{k + 1}" for k in range(opponents)]
    names += [f"{other}_{k}" for other in others for k in _PLAYER]
    names += [f"{other}_unum" for other in others]
    return (*names, "last_action_possible")


def hfo_high_names(mates: int, opponents: int) -> tuple[str, ...]:
    """What the 10 + 6 T + 3 O + 2 entries of ``hfo_high`` are."""
    team = [f"mate_{k + 1}" for k in range(mates)]
    names = ["x", "y", "body", "ball_x", "ball_y", "kickable", "goal_proximity", "goal_direction", "goal_opening", "opponent_proximity"]
    names += [f"{t}_goal_opening" for t in team] + [f"{t}_opponent_proximity" for t in team] + [f"{t}_pass_opening" for t in team]
    names += [f"{t}_{k}" for t in team for k in ("x", "y", "unum")]
    names += [f"opponent_{j + 1}_{k}" for j in range(opponents) for k in ("x", "y", "unum")]
    return (*names, "last_action_possible", "stamina")


def keepaway_names(mates: int, opponents: int) -> tuple[str, ...]:
    """What the entries of ``keepaway`` are: 13 for three keepers and two takers."""
    keepers, takers = mates + 1, opponents
    names = [f"K{k + 1}_centre" for k in range(keepers)] + [f"T{k + 1}_centre" for k in range(takers)]
    names += [f"K1_K{k + 1}" for k in range(1, keepers)] + [f"K1_T{k + 1}" for k in range(takers)]
    names += [f"K{k + 1}_nearest_T" for k in range(1, keepers)] + [f"angle_K{k + 1}_K1_T" for k in range(1, keepers)]
    return tuple(names)


_NAMES = {"hfo_low": hfo_low_names, "hfo_high": hfo_high_names, "keepaway": keepaway_names}
