"""What is there to decide by and to act with in a task: the quantities and the skills of the agent that plays it, without his structure."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from cprm_gym.agents.percepts import Percepts
from cprm_gym.architecture.expressions import Expression
from cprm_gym.architecture.petri import Belief, Continuous, Input, Math, PetriNet
from cprm_gym.envs.controller import Observation
from cprm_gym.errors import ModelError

from .believer import Believer
from .sheet import Sheet
from .skill import NOTHING, Mask, Skill, State, Step

BODY, NECK = 0, 1
"""What a command moves."""
_NECK = ("look", "turn_neck")


class Remembers(Protocol):
    """What percepts remember, in all worlds."""

    def reset(self, count: int, worlds: np.ndarray | None) -> None:
        """Forget, in the worlds of a mask, or in `count` worlds."""


class Keeps(Protocol):
    """What is kept from cycle to cycle beside whoever decides, and told to him as quantities."""

    columns: tuple[str, ...]

    def begin(self, worlds: int) -> None:
        """Episodes of so many worlds."""

    def restart(self, worlds: Mask) -> None:
        """In some worlds an episode begins."""

    def update(self, scene: Scene) -> None:
        """One cycle: the quantities are there, those of the last one but for `columns`, which it writes."""


class Scene:
    """Quantities and skills of a task, for all worlds at once.

    Parameters
    ----------
    net : PetriNet
        Of the agent who plays the task: its quantities and modules are taken, its places, transitions and tokens are not.
    percepts : callable
        Observation -> named quantities.
    instead : mapping of str to str
        Place of the net -> the percept that stands for it; a belief that anything reads needs one.
    without : sequence of str
        Quantities of the net that are left out.
    quantities : mapping of str to str
        Further ones: name -> text.
    orders : mapping of str to (str, dict)
        Commands that are no skill: name -> command and its parameters, by the names of quantities or as numbers.
    believer : Believer, optional
        A model whose views are percepts too, ``belief.NAME``.
    memory : Remembers, optional
        What the percepts remember from cycle to cycle.
    view : str
        Quantity that says how wide he looks, in every cycle and whatever decides; empty where he never changes it.
    keeps : Keeps, optional
        What is kept for whoever decides.

    Attributes
    ----------
    sheet : Sheet
    skills : dict of str to Skill
    """

    def __init__(
        self,
        net: PetriNet,
        percepts: Callable[[Observation], Percepts],
        instead: Mapping[str, str] | None = None,
        without: Sequence[str] = (),
        quantities: Mapping[str, str] | None = None,
        orders: Mapping[str, tuple[str, dict[str, str | float]]] | None = None,
        believer: Believer | None = None,
        memory: Remembers | None = None,
        view: str = "",
        keeps: Keeps | None = None,
    ) -> None:
        self.memory, self.view, self.keeps = memory, view, keeps
        self.net, self.percepts, self.sheet, self.believer = net, percepts, Sheet(), believer
        names = self._take(net, instead or {}, without)
        for name in keeps.columns if keeps is not None else ():
            if name not in names:
                names[name] = self.sheet.constant(name, 0.0)
        for name, text in (quantities or {}).items():
            names[name] = name
            self.sheet.derive(name, text, names)
        self.skills = {
            name: Skill(name, module, self.sheet, {
                port: names[net.fuse[f"{name}.{port}"]] for port in module.ports.parameters if f"{name}.{port}" in net.fuse
            }) for name, module in net.modules.items()
        }  # fmt: skip
        self._names = names
        self._shown = {
            name: [(k, names[f"{name}.{r}"]) for k, r in enumerate(skill.registers) if f"{name}.{r}" in names]
            for name, skill in self.skills.items()
        }
        self.commands: list[tuple[str, dict[str, str | float]]] = []
        self._offset: dict[str, int] = {}
        for name, skill in self.skills.items():
            self._offset[name] = len(self.commands)
            self.commands += skill.commands
        for name, (command, params) in (orders or {}).items():
            self._offset[name] = len(self.commands)
            self.commands.append((command, {k: names.get(v, v) if isinstance(v, str) else v for k, v in params.items()}))
        self._moves = np.array([NECK if command in _NECK else BODY for command, _ in self.commands] or [BODY])
        self.worlds = 0

    def _take(self, net: PetriNet, instead: Mapping[str, str], without: Sequence[str]) -> dict[str, str]:
        names: dict[str, str] = {}
        maths = [p for p in net.places if isinstance(p, Math) and p.name not in instead and p.name not in without]
        beliefs = {p.name for p in net.places if isinstance(p, Belief)}
        for place in net.places:
            if place.name in instead:
                names[place.name] = self.sheet.observe(instead[place.name])
            elif isinstance(place, Input):
                names[place.name] = self.sheet.observe(place.observes)
            elif isinstance(place, Continuous):
                names[place.name] = self.sheet.constant(place.name, place.value)
        names.update((place.name, place.name) for place in maths)
        for place in maths:
            for read in Expression(place.expression).names:
                if read in beliefs or read in without:
                    raise ModelError(f"net {net.name!r}: {place.name!r} reads {read!r}, for which nothing stands")
                if read not in names:  # tokens of the net's own structure: whoever decides keeps them as flags, if he wants to
                    names[read] = self.sheet.constant(read, 0.0)
            self.sheet.derive(place.name, place.expression, names)
        return names

    # ------------------------------------------------------------------ quantities

    def quantity(self, name: str) -> NDArray[np.float64]:
        """(N,) a quantity, by the name of the net; a view."""
        return self.sheet[self._names[name]]

    def holds(self, text: str) -> Mask:
        """Where a condition over quantities, by the names of the net, holds in this cycle."""
        if text not in self._held:
            value = self.sheet.evaluate(text, self._names)
            self._held[text] = (value != 0.0) & (value == value)
        return self._held[text]

    def forget_conditions(self) -> None:
        """Ask for conditions anew in this cycle, after a constant was written to."""
        self._held.clear()

    def flag(self, name: str, worlds: Mask, value: float) -> None:
        """Write a constant of the sheet in some worlds; it is read from the next cycle on."""
        self.sheet[self._names.get(name, name)][worlds] = value

    # ------------------------------------------------------------------ cycles

    def begin(self, worlds: int) -> None:
        """Episodes of so many worlds."""
        self.worlds = worlds
        self.sheet.begin(worlds)
        self._states = {name: skill.idle(worlds) for name, skill in self.skills.items()}
        self._begun = {name: skill.begun(worlds) for name, skill in self.skills.items()}
        self.chosen = np.full((worlds, 2), NOTHING, np.int64)
        if self.keeps is not None:
            self.keeps.begin(worlds)

    def restart(self, worlds: Mask) -> None:
        """In some worlds an episode begins."""
        self.sheet.restart(worlds)
        for name in self.skills:
            self.stop(name, worlds)
        self.chosen[worlds] = NOTHING
        if self.keeps is not None:
            self.keeps.restart(worlds)

    def see(self, percepts: Percepts) -> None:
        """Begin a cycle."""
        self.sheet.fill(percepts)
        if self.keeps is not None:
            self.keeps.update(self)
            self.sheet.derive_all()
        self._steps: dict[tuple[str, bool], Step] = {}
        self._held: dict[str, Mask] = {}
        self.chosen = np.full((self.worlds, 2), NOTHING, np.int64)

    def kicked(self, *skills: str) -> Mask:
        """Where one of these skills sent a kick in the last cycle; asked before this one begins."""
        kicks = [
            self._offset[name] + k for name in skills for k, (command, _) in enumerate(self.skills[name].commands) if command == "kick"
        ]  # fmt: skip
        return np.isin(self.chosen[:, BODY], kicks)

    def step(self, name: str, fresh: bool) -> Step:
        """What a skill would do in this cycle, begun now (`fresh`) or going on."""
        key = name, fresh
        if key not in self._steps:
            self._steps[key] = self.skills[name].advance((self._begun if fresh else self._states)[name])
        return self._steps[key]

    def run(self, name: str, worlds: Mask, fresh: bool) -> NDArray[np.int64]:
        """Let a skill work in some worlds for this cycle.

        Returns
        -------
        (N,) int64 array
            How it has ended: number of the outcome; -1 while it goes on, and in the other worlds.
        """
        step = self.step(name, fresh)
        self._state(name).take(worlds, step.state)
        for register, column in self._shown[name]:
            self.sheet[column][worlds] = step.state.registers[worlds, register]
        self._send(np.where(worlds & (step.emits >= 0), step.emits + self._offset[name], NOTHING))
        return np.where(worlds, step.outcome, NOTHING)

    def _state(self, name: str) -> State:
        """The state of a skill, to be changed: what was computed from it stays computed from what it was."""
        self.step(name, False)
        return self._states[name]

    def stop(self, name: str, worlds: Mask) -> None:
        """Stop a skill in some worlds."""
        self._states[name].at[worlds] = NOTHING

    def order(self, name: str, worlds: Mask) -> None:
        """Send a command that is no skill in some worlds."""
        self._send(np.where(worlds, self._offset[name], NOTHING))

    def _send(self, command: NDArray[np.int64]) -> None:
        sent = np.flatnonzero(command >= 0)
        self.chosen[sent, self._moves[command[sent]]] = command[sent]
