"""The agents' senses: as the server makes them, or worse in stated ways.

`Senses` is an option of every environment; the default changes nothing. What it says holds for the controlled agents alone: scripted
players see as the server lets them. All luck comes from the world's own stream of sensors, so world k is the same alone and in any batch.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import ParameterError, unknown_name
from ...simulator.player_types import T_DIST_NOISE_RATE, T_FOCUS_DIST_NOISE_RATE
from ...simulator.senses import See
from ...simulator.simulator import Simulator
from ...simulator.state import ViewWidth
from ..kernels import senses as kernels
from .stated import stated

NOISE = (0.15, math.radians(8.0), 0.3, math.radians(6.0))
"""Standard deviations for ``noise=1``: of the logarithm of a distance, of a direction (rad), of a distance change (m / cycle) and of a
direction change (rad / cycle)."""
VIEWS = {"narrow": ViewWidth.NARROW, "normal": ViewWidth.NORMAL, "wide": ViewWidth.WIDE}
LATEST = 50
"""Most cycles by which news may be late."""


@dataclass(frozen=True, kw_only=True)
class Senses:
    """What the controlled agents perceive, and when.

    Attributes
    ----------
    view : str
        Width of the view cone with which an episode begins: ``narrow`` (60 degrees, a look in every cycle), ``normal`` (120 degrees, every
        second) or ``wide`` (180 degrees, every third); an agent can change it as ever.
    asynchronous : bool
        The eye has a clock of its own, as real clients of the server have by default: a look each 75, 150 or 300 ms, which may show the
        world before the step.
    lost : float
        Probability with which a see message is lost, 0 to 1; the first one of an episode is not.
    noise : float
        Normal errors of what is seen of ball and players, in multiples of `NOISE`.
    quantise : float
        Factor, at least 1, by which distances and directions are coarser than the server's (0.1 in the logarithm, 1 degree).
    gaussian : float
        Distances are told with a normal error instead of in steps: the server's ``dist_noise_rate`` and ``focus_dist_noise_rate`` (0.0125
        there); 0 not.
    late_ball, late_others, late : int
        Cycles by which news of the ball, of the other players, and of everything come late: all that is told of them, also in the part
        ``memory``, is what would have been told then, and its age says so. An episode begins with the first look.
    motion : bool
        Whether changes of distance and direction are told.
    numbers : bool
        Whether uniform numbers are told.

    Raises
    ------
    ParameterError
        For a value that is out of its range.
    """

    view: str = "normal"
    asynchronous: bool = False
    lost: float = 0.0
    noise: float = 0.0
    quantise: float = 1.0
    gaussian: float = 0.0
    late_ball: int = 0
    late_others: int = 0
    late: int = 0
    motion: bool = True
    numbers: bool = True

    def __post_init__(self) -> None:
        if self.view not in VIEWS:
            raise unknown_name("view", str(self.view), VIEWS)
        for name, low, high in (("lost", 0.0, 1.0), ("noise", 0.0, 100.0), ("quantise", 1.0, 100.0), ("gaussian", 0.0, 10.0)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, float, np.number)) or not low <= value <= high:
                raise ParameterError(f"senses: {name}: {value!r} given; allowed are numbers from {low:g} to {high:g}")
        for name in ("late_ball", "late_others", "late"):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not 0 <= value <= LATEST:
                raise ParameterError(f"senses: {name}: {value!r} given; allowed are whole numbers from 0 to {LATEST}")
        for name in ("asynchronous", "motion", "numbers"):
            value = getattr(self, name)
            if not isinstance(value, (bool, np.bool_)):
                raise ParameterError(f"senses: {name}: {value!r} given; allowed are True and False")

    @classmethod
    def of(cls, given: Senses | Mapping[str, Any]) -> Senses:
        """Senses, or those that a mapping of their fields means.

        Raises
        ------
        ParameterError
            For what is neither, or a field that there is not.
        """
        return stated(cls, given, "senses")

    @property
    def delays(self) -> tuple[int, int, int]:
        """Cycles by which news of the ball, of the others and of everything else come late."""
        return max(self.late, self.late_ball), max(self.late, self.late_others), self.late

    @property
    def sizes(self) -> np.ndarray:
        """(4,) standard deviations of the errors, as `NOISE`."""
        return self.noise * np.array(NOISE)


class SensesChange:
    """Carries `Senses` out in the worlds of a simulator.

    Parameters
    ----------
    senses : Senses
    simulator : Simulator
    players : (A,) int array
        Object numbers of the agents.

    Attributes
    ----------
    rereads : bool
        What is seen is made worse, by `reread`.
    """

    def __init__(self, senses: Senses, simulator: Simulator, players: np.ndarray) -> None:
        self.senses, self.simulator = senses, simulator
        self._rows = np.asarray(players, np.int64) - 1
        step = simulator.parameters.quantize_step if senses.quantise > 1.0 else 0.0
        coarse = math.radians(senses.quantise) if senses.quantise > 1.0 else 0.0
        self._steps = np.array([senses.quantise * step, coarse])
        self.rereads = senses.lost > 0 or senses.noise > 0 or senses.quantise > 1.0 or not (senses.motion and senses.numbers)
        self._begins = senses.view != "normal" or senses.asynchronous or senses.gaussian > 0
        if senses.gaussian > 0:
            types = simulator.packed[0]["types"]
            types[:, T_DIST_NOISE_RATE] = types[:, T_FOCUS_DIST_NOISE_RATE] = senses.gaussian

    def begin(self, worlds: np.ndarray) -> None:
        """The eyes of the agents in worlds (n,) whose episodes begin."""
        if not self._begins:
            return
        world, cells = self.simulator.world, np.ix_(worlds, self._rows)
        if self.senses.view != "normal":
            world["view_width"][cells] = VIEWS[self.senses.view]
        if self.senses.asynchronous:
            world["synchronous"][cells] = 0
        if self.senses.gaussian > 0:
            world["gaussian"][cells] = 1

    def reread(self, see: See, worlds: np.ndarray, cycles: np.ndarray) -> None:
        """Make what the agents see in `worlds`, (n,), worse, in place; `cycles` (W,) of their episodes."""
        s = self.senses
        kernels.degrade(
            self.simulator.world, worlds, self._rows, cycles, float(s.lost), s.sizes, self._steps, bool(s.motion), bool(s.numbers), *see
        )


class LateNews:
    """Observations that are told some cycles after they were made.

    Parameters
    ----------
    senses : Senses
    told : dict of (W, A, ...) arrays
        The observations that the agents get; written by `tell`.

    Attributes
    ----------
    now : dict of (W, A, ...) arrays
        The observations that they would get at once.
    """

    def __init__(self, senses: Senses, told: dict[str, np.ndarray]) -> None:
        self.told = told
        self.now = {key: value.copy() for key, value in told.items()}
        ball, others, everything = senses.delays
        # (part of the observation, its columns, how late it is, whether it is an age)
        self._parts: list[tuple[str, Any, int, bool]] = []
        for key in told:
            if key in ("level", "age", "memory", "memory_age"):
                is_age = key.endswith("age")
                self._parts += [(key, slice(0, 1), ball, is_age), (key, slice(1, None), others, is_age)]
            elif key not in ("task", "action_mask"):
                late = {"ball": ball, "players": others}.get(key, everything)
                self._parts.append((key, slice(None), late, False))
            else:
                self._parts.append((key, slice(None), 0, False))
        worlds = len(told["level"])
        self._kept = [np.zeros((worlds, late + 1, *told[key][:, :, columns].shape[1:]), told[key].dtype)
                      for key, columns, late, _ in self._parts]  # fmt: skip
        self._cycles = np.zeros(worlds, np.int64)

    def state(self) -> dict[str, np.ndarray]:
        """Arrays that decide what will be told, worlds first."""
        arrays = {f"late/{k}": kept for k, kept in enumerate(self._kept)}
        return {**arrays, "late/cycles": self._cycles, **{f"late/now/{key}": value for key, value in self.now.items()}}

    def tell(self, begun: np.ndarray | None, oldest: float) -> None:
        """The observations of a cycle.

        Parameters
        ----------
        begun : (n,) int array, optional
            Worlds whose episodes begin, and nothing else has happened; otherwise every world has gone on by a cycle.
        oldest : float
            Largest age that is told.
        """
        if begun is None:
            self._cycles += 1
        else:
            self._cycles[begun] = 0
        for (key, columns, late, is_age), kept in zip(self._parts, self._kept):
            now, told = self.now[key][:, :, columns], self.told[key][:, :, columns]
            if begun is not None:
                kept[begun] = now[begun, None]
                told[begun] = now[begun]
                continue
            kept[:, 1:] = kept[:, :-1].copy()
            kept[:, 0] = now
            told[...] = kept[:, late]
            if is_age and late:
                since = np.minimum(self._cycles, late)[:, None, None]
                told[...] = np.minimum(told + since, oldest)
