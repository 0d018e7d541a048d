"""Subsumption: layers of augmented machines; the output of a higher one suppresses that of the lower ones, or inhibits it (Brooks 1986).

Each layer is always at work on the same senses and knows nothing of the others; what it has to remember it keeps in timed registers. Its
output goes on a wire to the legs or the neck, on which nodes decide: a suppression node lets the higher layer through and holds the lower
one off for a time, an inhibition node only holds it off.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from cprm_gym.errors import ModelError, did_you_mean

from .scene import Scene
from .skill import NOTHING, Mask


@dataclass(frozen=True)
class Layer:
    """A layer.

    Parameters
    ----------
    name : str
    when : str
        Condition in which it has something to say.
    skill, order : str
        What it says: one of both.
    stays : str
        Condition in which it goes on once it has begun; that of `when` if not given. A skill that has ended ends the layer's turn.
    sets : mapping of str to (str, int)
        Outcome of the skill -> register, and cycles for which it is then 1 in the conditions.
    holds : int
        Cycles after its last output for which the lower ones stay suppressed.
    inhibits : tuple of str
        Layers, whose output is held off while this one has something to say; it does not replace them.
    raises : tuple of str
        Flags that are 1 while it speaks.
    """

    name: str
    when: str
    skill: str = ""
    order: str = ""
    stays: str = ""
    sets: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    holds: int = 0
    inhibits: tuple[str, ...] = ()
    raises: tuple[str, ...] = ()


class Layers:
    """Layers that run in all worlds.

    Parameters
    ----------
    scene : Scene
    layers : sequence of Layer
        The lowest first.
    eyes : str
        Skill or order on the wire of the neck.

    Raises
    ------
    ModelError
        For a skill, an outcome, a register or a layer that there is not.
    """

    def __init__(self, scene: Scene, layers: Sequence[Layer], eyes: str) -> None:
        self.layers, self.eyes = tuple(layers), eyes
        names = [layer.name for layer in layers]
        self.registers = sorted({register for layer in layers for register, _ in layer.sets.values()})
        for layer in layers:
            if bool(layer.skill) + bool(layer.order) + bool(layer.inhibits) < 1:
                raise ModelError(f"layer {layer.name!r} says nothing")
            outcomes = scene.skills[layer.skill].outcomes if layer.skill else ()
            for what, given, known in (
                *(("outcome", outcome, outcomes) for outcome in layer.sets), *(("layer", other, names) for other in layer.inhibits)
            ):  # fmt: skip
                if given not in known:
                    raise ModelError(f"layer {layer.name!r}: there is no {what} {given!r}.{did_you_mean(given, known)}")
        for register in self.registers:
            if register not in scene.sheet:
                scene.sheet.constant(register, 0.0)

    def begin(self, worlds: int, seed: int) -> None:
        """Nothing is remembered."""
        self._left = np.zeros((worlds, len(self.registers)), np.int64)
        self._speaks = np.zeros((worlds, len(self.layers)), np.bool_)
        self._held = np.zeros((worlds, len(self.layers)), np.int64)
        self._opened = np.zeros(worlds, np.bool_)

    def restart(self, worlds: Mask) -> None:
        """Nothing is remembered in some worlds."""
        self._left[worlds], self._speaks[worlds], self._held[worlds], self._opened[worlds] = 0, False, 0, False

    def decide(self, scene: Scene) -> None:
        """One cycle: the wires from the highest layer down."""
        self._left = np.maximum(self._left - 1, 0)
        for k, register in enumerate(self.registers):
            scene.sheet[register][:] = self._left[:, k] > 0
        scene.sheet.derive_all()
        free = np.ones(scene.worlds, np.bool_)
        inhibited = np.zeros((scene.worlds, len(self.layers)), np.bool_)
        for k in range(len(self.layers) - 1, -1, -1):
            layer = self.layers[k]
            wants = np.where(self._speaks[:, k], scene.holds(layer.stays or layer.when), scene.holds(layer.when))
            for name in layer.inhibits:
                inhibited[wants, [other.name for other in self.layers].index(name)] = True
            if layer.skill or layer.order:
                self._speak(scene, k, wants & ~inhibited[:, k], free)
        if not self.eyes:
            return
        if self.eyes in scene.skills:
            scene.run(self.eyes, ~self._opened, fresh=True)
            scene.run(self.eyes, self._opened, fresh=False)
            self._opened[:] = True
        else:
            scene.order(self.eyes, np.ones(scene.worlds, np.bool_))

    def _speak(self, scene: Scene, k: int, wants: Mask, free: Mask) -> None:
        """The output of one layer, where no higher one has taken the wire."""
        layer = self.layers[k]
        gets = wants & free
        said = gets.copy()
        if layer.skill:
            for fresh in (True, False):
                worlds = gets & (self._speaks[:, k] != fresh)
                if worlds.any():
                    ended = scene.run(layer.skill, worlds, fresh)
                    said &= ~(worlds & (ended >= 0))
                    self._note(scene, layer, ended)
        else:
            scene.order(layer.order, gets)
        for flag in layer.raises:
            scene.flag(flag, np.ones(scene.worlds, np.bool_), 0.0)
            scene.flag(flag, said, 1.0)
        self._speaks[:, k] = said
        self._held[:, k] = np.where(said, layer.holds, np.maximum(self._held[:, k] - 1, NOTHING))
        free &= ~(said | (self._held[:, k] > 0))

    def _note(self, scene: Scene, layer: Layer, ended: np.ndarray) -> None:
        """Registers that an outcome sets; they count in this cycle already."""
        for outcome, (register, cycles) in layer.sets.items():
            where = ended == scene.skills[layer.skill].outcomes.index(outcome)
            if where.any():
                self._left[where, self.registers.index(register)] = cycles
                scene.sheet[register][where] = 1.0
                scene.sheet.derive_all()
                scene.forget_conditions()
