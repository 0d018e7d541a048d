"""A controller whose structure chooses, and whose skills act: the part that all hand-written baselines share."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from cprm_gym.agents.body import Body
from cprm_gym.agents.play import BODY_COMMANDS
from cprm_gym.envs.actions import NECK_SCALE, scaled
from cprm_gym.envs.controller import Action, Observation, no_action
from cprm_gym.errors import ControllerError

from .scene import BODY, NECK, Scene
from .skill import Mask


class Structure(Protocol):
    """Who decides which skill runs when; remembers what it has to, for each world."""

    def begin(self, worlds: int, seed: int) -> None:
        """Episodes of so many worlds."""

    def restart(self, worlds: Mask) -> None:
        """In some worlds an episode begins."""

    def decide(self, scene: Scene) -> None:
        """Let skills run (`Scene.run`) and send orders (`Scene.order`), one for body and one for neck in each world."""


class Player:
    """Plays with a structure, one memory for each world.

    Parameters
    ----------
    scene : Scene
    structure : Structure
    body : Body
    written : str
        Name of the module in which the structure stands.
    """

    needs = ("memory",)

    def __init__(self, scene: Scene, structure: Structure, body: Body, written: str = "") -> None:
        self.scene, self.structure, self.body, self.written = scene, structure, body, written

    def reset(self, observation: Observation, seed: int, worlds: np.ndarray | None = None) -> None:
        """Begin episodes."""
        count = len(observation["level"])
        if worlds is None or self.scene.worlds != count:
            self.scene.begin(count)
            self.structure.begin(count, seed)
            self._turned = np.zeros(count)
        else:
            chosen = np.asarray(worlds, bool)
            self.scene.restart(chosen)
            self.structure.restart(chosen)
            self._turned[chosen] = 0.0
        if self.scene.memory is not None:
            self.scene.memory.reset(count, None if worlds is None else np.asarray(worlds, bool))
        if self.scene.believer is not None:
            self.scene.believer.reset(count, None if worlds is None else np.asarray(worlds, bool))

    def act(self, observation: Observation) -> Action:
        """One cycle of every world."""
        if not self.scene.worlds:
            raise ControllerError("act before reset: the controller does not know how many worlds there are")
        percepts = self.scene.percepts(observation)
        if self.scene.believer is not None:
            percepts["body.turned_deg"] = self._turned
            along = np.cos(np.radians(percepts["body.speed_direction_deg"]))
            percepts["body.advanced"] = percepts["body.speed"] * along / self.body.kind.player_decay
            percepts.update(self.scene.believer.believe(percepts, observation))
        self.scene.see(percepts)
        self.structure.decide(self.scene)
        self.scene.sheet.derive_all()  # what the eyes have counted in this cycle decides where they look in it
        return self._action(percepts["body.speed"], percepts["body.neck_deg"])

    def _action(self, speed: np.ndarray, neck: np.ndarray) -> Action:
        scene, count = self.scene, self.scene.worlds
        action = no_action(count)
        turned = np.zeros(count)
        for number in np.unique(scene.chosen[:, BODY]):
            if number < 0:
                continue
            rows = scene.chosen[:, BODY] == number
            command, params = scene.commands[number]
            kind, names = BODY_COMMANDS[command]
            given = [params.get(name, 0.0) for name in names]
            values = [scene.sheet[v][rows] if isinstance(v, str) else np.full(int(rows.sum()), v) for v in given]
            action["type"][rows] = kind
            action["params"][rows] = scaled(action["type"][rows], *values)
            if command == "turn":
                turned[rows] = values[0] / (1.0 + self.body.kind.inertia_moment * speed[rows])
        self._turned = turned
        for number in np.unique(scene.chosen[:, NECK]):
            if number < 0:
                continue
            rows = scene.chosen[:, NECK] == number
            command, params = scene.commands[number]
            (value,) = (scene.sheet[v][rows] if isinstance(v, str) else np.full(int(rows.sum()), v) for v in params.values())
            if command == "look":  # the face shall point there, also when the body turns in the same cycle
                wanted = (value - turned[rows] + 180.0) % 360.0 - 180.0
                value = np.clip(wanted, self.body.server.minneckang, self.body.server.maxneckang) - neck[rows]
            action["turn_neck"][rows, 0] = np.clip(value / NECK_SCALE, -1.0, 1.0)
        if scene.view:
            action["view"] = np.rint(scene.sheet[scene.view]).astype(np.int64)
        return action
