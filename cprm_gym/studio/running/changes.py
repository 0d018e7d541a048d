"""What is changed in a run by hand: a list of changes, so that the run can be played again with them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from typing import Any, ClassVar

import numpy as np

from ...agents.play import agent_in
from ...architecture.petri import Place, instances
from ...envs.controller import Controller
from ...envs.core import SoccerCore, player_number
from ...envs.pitch import FARTHEST
from ...errors import ParameterError, unknown_name
from ...wrappers.disturbances import NO_SIGHT
from .memory import runner_of

LONGEST = 10_000
"""Cycles for which something may be forced."""


@dataclass(frozen=True)
class Change:
    """One change, which takes effect when the commands of its cycle are carried out.

    Parameters
    ----------
    cycle : int
    kind : str
        ``ball`` and ``player`` move something, ``blind`` closes a player's eyes, ``force`` makes a percept read a number, ``lose`` keeps a
        reading from the model, ``mark`` sets a place, ``hold`` an object place, ``fail`` ends a skill with its error.
    whom : str
        The agent, or the player who is moved.
    name : str
        Of the percept, variable, place or module.
    values : tuple of float
        x, y and for the ball vx, vy, for a player his body, in metres, m / cycle and radians; the number that is read, tokens, or the
        object's number.
    cycles : int
        For how long, of ``blind``, ``force`` and ``lose``.
    """

    KINDS: ClassVar[Mapping[str, tuple[int, int]]] = {
        "ball": (2, 4), "player": (2, 3), "blind": (0, 0), "force": (1, 1), "lose": (0, 0), "mark": (1, 1), "hold": (1, 1), "fail": (0, 0),
    }  # fmt: skip
    """Kind -> the least and the most values that it takes."""
    cycle: int
    kind: str
    whom: str = ""
    name: str = ""
    values: tuple[float, ...] = ()
    cycles: int = 1

    def __post_init__(self) -> None:
        """Refuse what cannot be done."""
        if self.kind not in self.KINDS:
            raise unknown_name("change", self.kind, self.KINDS)
        least, most = self.KINDS[self.kind]
        try:
            values = tuple(float(v) for v in self.values)
        except (TypeError, ValueError):
            raise ParameterError(f"change {self.kind!r}: values are numbers, got {self.values!r}") from None
        if not least <= len(values) <= most or not np.isfinite(values).all():
            raise ParameterError(f"change {self.kind!r}: takes {least} to {most} finite numbers, got {self.values!r}")
        object.__setattr__(self, "values", values)
        if isinstance(self.cycles, bool) or not isinstance(self.cycles, int) or not 1 <= self.cycles <= LONGEST:
            raise ParameterError(f"change {self.kind!r}: lasts 1 to {LONGEST} cycles, got {self.cycles!r}")
        if self.kind in ("ball", "player") and (np.abs(values[:2]) > FARTHEST).any():
            raise ParameterError(f"change {self.kind!r}: |x| and |y| are at most {FARTHEST[0]:g} and {FARTHEST[1]:g} m, got {values[:2]}")

    def said(self) -> dict[str, Any]:
        """For a page."""
        return {**asdict(self), "values": list(self.values)}


class Hands:
    """The changes of a run, and what makes them happen.

    Parameters
    ----------
    core : SoccerCore
        Of one world.
    players : sequence of Controller
        Of its agents.

    Attributes
    ----------
    log : list of Change
        All so far, in the order of their cycles.
    """

    def __init__(self, core: SoccerCore, players: Sequence[Controller]) -> None:
        self.core, self.players = core, players
        self.log: list[Change] = []

    @property
    def cycle(self) -> int:
        """Of the episode."""
        return int(self.core.cycle[0])

    def rewind(self, cycle: int) -> None:
        """Forget what was changed from a cycle on."""
        self.log = [change for change in self.log if change.cycle < cycle]

    def take(self, change: Change) -> None:
        """Check a change against the run, and note it.

        Raises
        ------
        UnknownName, ParameterError
        NetError
            For a marking that the place cannot hold.
        """
        if change.cycle != self.cycle:
            raise ParameterError(f"a change is made in the cycle where the run stands, {self.cycle}, not {change.cycle}")
        if change.kind == "player":
            left, right = self.core.counts
            known = [*(f"left_{k + 1}" for k in range(left)), *(f"right_{k + 1}" for k in range(right))]
            if change.whom not in known:
                raise unknown_name("player", change.whom, known)
        elif change.kind != "ball":
            player = self._player(change)
            if change.kind != "blind":
                self._check(change, player)
        self.log.append(change)

    def _player(self, change: Change) -> Any:
        if change.whom not in self.core.agents:
            raise unknown_name("agent", change.whom, self.core.agents)
        return self.players[self.core.agents.index(change.whom)]

    def _check(self, change: Change, player: Any) -> None:
        runner = runner_of(player)
        if runner is None:
            raise ParameterError(f"change {change.kind!r}: {change.whom} does not play with a net of ours")
        if change.kind == "force" and change.name not in runner._percepts:
            raise unknown_name("percept", change.name, runner._percepts)
        if change.kind == "lose":
            known = [o.variable for o in runner.cprm.observations]
            if change.name not in known:
                raise unknown_name("reading", change.name, known)
        if change.kind == "hold":
            executor = runner.executor
            if change.name not in executor.object_names:
                raise unknown_name("object place", change.name, executor.object_names)
        if change.kind == "mark":
            places = [p.name for p in runner.executor.net.net.places if isinstance(p, Place)]
            if change.name not in places:
                raise unknown_name("place", change.name, places)
        if change.kind in ("mark", "hold"):  # tried, so that what cannot be held is refused now and not when it takes effect
            before = runner.executor.snapshot()
            try:
                runner.executor.write(change.name, change.values[0])
            finally:
                runner.executor.restore(before)
        if change.kind == "fail" and change.name not in (able := failing(runner.cprm.net)):
            raise unknown_name("module with an error port", change.name, able)

    # ------------------------------------------------------------------ making it happen

    def touch(self) -> None:
        """Before the step: what moves things, closes eyes, and changes nets."""
        cycle, core = self.cycle, self.core
        for change in self.log:
            if change.kind == "blind" and change.cycle <= cycle < change.cycle + change.cycles:
                last = cycle == change.cycle + change.cycles - 1
                core.sim.world["see_counter"][0, player_number(change.whom) - 1] = 0 if last else NO_SIGHT
            if change.cycle != cycle:
                continue
            if change.kind == "ball":
                core.place_ball(*change.values, worlds=0)
            elif change.kind == "player":
                core.place_player(player_number(change.whom), *change.values, worlds=0)
            elif change.kind in ("mark", "hold", "fail"):
                self._write(change)

    def _write(self, change: Change) -> None:
        runner = runner_of(self._player(change))
        assert runner is not None
        if change.kind in ("mark", "hold"):
            runner.executor.write(change.name, change.values[0])
            return
        instance = instances(runner.cprm.net)[change.name]
        for place in instance.net.places:
            if isinstance(place, Place):
                runner.executor.write(instance.places[place.name], 0.0)
        runner.executor.write(instance.places[instance.net.ports.errors[0]], 1.0)

    @contextmanager
    def over(self, i: int) -> Iterator[None]:
        """While a player decides: what he is made to read, and what his model is not told."""
        player, agent, cycle = self.players[i], self.core.agents[i], self.cycle
        mine = [c for c in self.log if c.whom == agent and c.kind in ("force", "lose") and c.cycle < cycle <= c.cycle + c.cycles]
        inner, runner = agent_in(player), runner_of(player)
        if not mine or runner is None or inner is None:
            yield
            return
        forced = {c.name: c.values[0] for c in mine if c.kind == "force"}
        percepts = inner.percepts

        def changed(observation: Any) -> Any:
            found = percepts(observation)
            found.update({name: np.full(1, value) for name, value in forced.items() if name in found})
            return found

        inner.percepts = changed
        runner.withheld = frozenset(c.name for c in mine if c.kind == "lose")
        try:
            yield
        finally:
            inner.percepts = percepts
            runner.withheld = frozenset()


def failing(net: Any) -> list[str]:
    """Modules of a net that have an error port, by path."""
    return [path for path, instance in instances(net).items() if path and instance.net.ports.errors]
