"""Finite state machines: a state for each activity, rules that lead from one to the next."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from cprm_gym.errors import ModelError, did_you_mean

from .scene import Scene
from .skill import NOTHING, Mask

MOVES = 12
"""Changes of the state that one cycle may see."""


@dataclass(frozen=True)
class Move:
    """A rule: where `when` holds, in a state that has lasted for `after` cycles (in a row, if it asks for a condition), to state `to`."""

    to: str
    when: str = ""
    after: int = 0


@dataclass(frozen=True)
class State:
    """An activity.

    Parameters
    ----------
    skill : str
        What runs in it; empty for none.
    order : str
        What is sent in it once in a cycle, if no skill runs.
    moves : tuple of Move
        Tried in this order before the skill works.
    on : mapping of str to str
        Outcome of the skill -> the next state.
    raises : tuple of str
        Flags that are 1 in it.
    """

    skill: str = ""
    order: str = ""
    moves: tuple[Move, ...] = ()
    on: Mapping[str, str] = field(default_factory=dict)
    raises: tuple[str, ...] = ()


class Machine:
    """A machine that runs in all worlds, each in its own state.

    Parameters
    ----------
    scene : Scene
    states : mapping of str to State
        The first is where it begins.
    eyes : str
        Order or skill of the neck, which a machine does beside whatever state it is in.

    Raises
    ------
    ModelError
        For a state, a skill or an outcome that there is not.
    """

    def __init__(self, scene: Scene, states: Mapping[str, State], eyes: str = "") -> None:
        self.states, self.eyes = dict(states), eyes
        self._names = list(states)
        for name, state in states.items():
            outcomes = scene.skills[state.skill].outcomes if state.skill else ()
            for what, given, known in (
                *(("state", move.to, self._names) for move in state.moves), *(("state", to, self._names) for to in state.on.values()),
                *(("outcome", outcome, outcomes) for outcome in state.on),
            ):  # fmt: skip
                if given not in known:
                    raise ModelError(f"state {name!r}: there is no {what} {given!r}.{did_you_mean(given, known)}")
            missing = set(outcomes) - set(state.on) - {"aborted"}
            if missing:
                raise ModelError(f"state {name!r}: nothing follows on {', '.join(sorted(missing))} of {state.skill!r}")
        self._moves = [[(self._names.index(move.to), move.when, move.after) for move in state.moves] for state in states.values()]

    def begin(self, worlds: int, seed: int) -> None:
        """All worlds in the first state."""
        self.at = np.zeros(worlds, np.int64)
        self.fresh = np.ones(worlds, np.bool_)
        self._opened = np.zeros(worlds, np.bool_)
        widest = max((len(moves) for moves in self._moves), default=0)
        self._clocks = np.full((worlds, widest), NOTHING, np.int64)

    def restart(self, worlds: Mask) -> None:
        """Some worlds in the first state."""
        self.at[worlds], self.fresh[worlds], self._opened[worlds], self._clocks[worlds] = 0, True, False, NOTHING

    def decide(self, scene: Scene) -> None:
        """One cycle."""
        self._tick(scene)
        acted = np.zeros(scene.worlds, np.bool_)
        for _ in range(MOVES):
            if acted.all():
                break
            for number, name in enumerate(self._names):
                self._live(scene, number, self.states[name], acted)
        self._look(scene)

    def _look(self, scene: Scene) -> None:
        if not self.eyes:
            return
        if self.eyes in scene.skills:
            scene.run(self.eyes, ~self._opened, fresh=True)
            scene.run(self.eyes, self._opened, fresh=False)
            self._opened[:] = True
        else:
            scene.order(self.eyes, np.ones(scene.worlds, np.bool_))

    def _live(self, scene: Scene, number: int, state: State, acted: Mask) -> None:
        """What those in one state do: leave it, or act in it."""
        here = (self.at == number) & ~acted
        if not here.any():
            return
        for k, (to, condition, after) in enumerate(self._moves[number]):
            leaves = here & scene.holds(condition) if condition else here.copy()
            if after:
                leaves &= self._clocks[:, k] >= after
            self._enter(scene, number, to, leaves)
            here &= ~leaves
        if not state.skill:
            if state.order:
                scene.order(state.order, here)
            acted |= here
            self.fresh[here] = False
            return
        ended = np.full(scene.worlds, NOTHING, np.int64)
        for fresh in (True, False):
            worlds = here & (self.fresh == fresh)
            if worlds.any():
                ended = np.where(worlds, scene.run(state.skill, worlds, fresh), ended)
        self.fresh[here] = False
        acted |= here & (ended < 0)
        for k, outcome in enumerate(scene.skills[state.skill].outcomes):
            if outcome in state.on:
                self._enter(scene, number, self._names.index(state.on[outcome]), here & (ended == k))

    def _enter(self, scene: Scene, source: int, to: int, worlds: Mask) -> None:
        if not worlds.any():
            return
        for name in self.states[self._names[source]].raises:
            scene.flag(name, worlds, 0.0)
        for name in self.states[self._names[to]].raises:
            scene.flag(name, worlds, 1.0)
        self.at[worlds], self.fresh[worlds], self._clocks[worlds] = to, True, NOTHING
        for k, (_, condition, after) in enumerate(self._moves[to]):
            if after:
                self._clocks[worlds, k] = np.where(scene.holds(condition), 0, NOTHING)[worlds] if condition else 0

    def _tick(self, scene: Scene) -> None:
        """The clocks of the moves that ask for time: cycles for which they could have been made."""
        for number, moves in enumerate(self._moves):
            here = self.at == number
            for k, (_, condition, after) in enumerate(moves):
                if after:
                    held = here & scene.holds(condition) if condition else here
                    self._clocks[here, k] = np.where(held, self._clocks[:, k] + 1, NOTHING)[here]
