"""A ball and opponents at any grain, as slices made by hand: the model whose speed is promised.

Each object has hidden dist, dir, vdist, vdir (and opponents orient), a flag seen and a reading of each. Attended objects, and the
ball, have links in time. A possessed ball takes dist and dir from its possessor, vdist and vdir from where that one faces and
whether it shoots.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import norm

from cprm_gym.architecture.prm.grounding.slices import GroundCPD, Grounds, GroundSlice, GroundVariable

SIDES = 8
HIDDEN = ("dist", "dir", "vdist", "vdir")


class Active(NamedTuple):
    """Relations in force: attended opponents, and who has the ball and what the ball then remembers."""

    attended: tuple[str, ...] = ()
    possessor: str = ""
    remembers: bool = False


def bump(mean: np.ndarray | float, bins: int, deviation: float, floor: float = 1e-6) -> np.ndarray:
    """Gaussian mass in bins numbered 0, 1, ...; end bins take the tails; a little of everything mixed in."""
    edges = np.concatenate([[-np.inf], np.arange(1, bins) - 0.5, [np.inf]])
    mass = np.diff(norm.cdf((edges - np.asarray(mean)[..., None]) / deviation), axis=-1)
    return (1.0 - floor) * mass / mass.sum(axis=-1, keepdims=True) + floor / bins


class Scene(Grounds):
    """The world.

    Parameters
    ----------
    bins : int
        For each of the four hidden quantities.
    opponents : int
    coupled : bool
        Whether `seen` depends on dist as well as on dir.
    """

    def __init__(self, bins: int, opponents: int = 11, coupled: bool = False) -> None:
        n = self.bins = bins
        self.opponents = tuple(f"o{k}" for k in range(1, opponents + 1))
        self.coupled = coupled
        place = np.arange(n)
        middle = (n - 1) / 2
        speed = (place - middle) * 3.0 / n
        facing = np.arange(SIDES)
        turn = np.minimum((facing[:, None] - facing) % SIDES, (facing - facing[:, None]) % SIDES)
        rng = np.random.default_rng(0)
        inside = np.where(np.abs(place - middle) < n / 3, 0.95, 0.05)
        chance = np.outer(np.clip(1.1 - place / n, 0.0, 1.0), inside) if coupled else inside
        around = np.exp(-(turn.astype(float) ** 2))
        sharp = np.exp(-2.0 * turn.astype(float) ** 2)
        self.tables = {
            "place": np.full(n, 1.0 / n),
            "speed": bump(middle, n, n / 6),
            "move": bump(place[:, None] + speed[None, :], n, 0.7),
            "slow": bump((place - middle) * 0.9 + middle, n, 0.8),
            "seen": np.stack([1.0 - chance, chance], axis=-1),
            "reading": np.stack([np.full((n, n), 1.0 / n), bump(place, n, 0.6)], axis=1),
            "orient": np.full(SIDES, 1.0 / SIDES),
            "turn": around / around.sum(axis=1, keepdims=True),
            "facing": np.stack([np.full((SIDES, SIDES), 1.0 / SIDES), sharp / sharp.sum(axis=1, keepdims=True)], axis=1),
            "shoot": rng.dirichlet(np.ones(2), size=(n, SIDES)),
            "held dist": np.stack([bump(place, n, 0.6), bump(place - 2, n, 1.0)], axis=1),
            "held dir": np.stack([bump(place, n, 0.6), bump(place, n, 1.0)], axis=1),
            "held vdist": rng.dirichlet(np.ones(n), size=(SIDES, 2)),
            "held vdir": rng.dirichlet(np.ones(n), size=(SIDES, 2)),
            "kick vdist": rng.dirichlet(np.ones(n), size=(n, SIDES, 2)),
            "kick dist": bump(
                0.5 * (place[:, None, None, None] + speed[None, :, None, None] + place[None, None, :, None]) - np.array([0.0, 2.0]), n, 0.8
            ),
        }
        self.slices: dict[tuple[Active, bool], GroundSlice] = {}

    def cpd(self, child: str, parents: Iterable[tuple[str, int]], key: str) -> GroundCPD:
        """A CPD that every object of its kind shares."""
        return GroundCPD(child, tuple(parents), self.tables[key], key, checked=True)

    def thing(self, o: str, linked: bool, active: Active) -> list[GroundCPD]:
        """The CPDs of one object."""
        out = []
        held = o == "b" and active.possessor
        for x, v in (("dist", "vdist"), ("dir", "vdir")):
            if held and not active.remembers:
                q = active.possessor
                out.append(self.cpd(f"{o}.{x}", [(f"{q}.{x}", 0), (f"{q}.shoot", 0)], f"held {x}"))
                out.append(self.cpd(f"{o}.{v}", [(f"{q}.orient", 0), (f"{q}.shoot", 0)], f"held {v}"))
            elif held and x == "dist":
                q = active.possessor
                out.append(self.cpd("b.dist", [("b.dist", 1), ("b.vdist", 1), (f"{q}.dist", 0), (f"{q}.shoot", 0)], "kick dist"))
                out.append(self.cpd("b.vdist", [("b.vdist", 1), (f"{q}.orient", 0), (f"{q}.shoot", 0)], "kick vdist"))
            elif linked:
                out.append(self.cpd(f"{o}.{x}", [(f"{o}.{x}", 1), (f"{o}.{v}", 1)], "move"))
                out.append(self.cpd(f"{o}.{v}", [(f"{o}.{v}", 1)], "slow"))
            else:
                out += [self.cpd(f"{o}.{x}", [], "place"), self.cpd(f"{o}.{v}", [], "speed")]
        cause = [(f"{o}.dist", 0), (f"{o}.dir", 0)] if self.coupled else [(f"{o}.dir", 0)]
        out.append(self.cpd(f"{o}.seen", cause, "seen"))
        out += [self.cpd(f"{o}.obs_{x}", [(f"{o}.{x}", 0), (f"{o}.seen", 0)], "reading") for x in HIDDEN]
        if o != "b":
            out.append(self.cpd(f"{o}.orient", [(f"{o}.orient", 1)] if linked else [], "turn" if linked else "orient"))
            out.append(self.cpd(f"{o}.obs_orient", [(f"{o}.orient", 0), (f"{o}.seen", 0)], "facing"))
        return out

    def ground(self, active: Any = (), first: bool = False) -> GroundSlice:
        """The slice for some relations."""
        active = active or Active()
        key = active, first
        if key not in self.slices:
            relations = Active() if first else active
            cpds = self.thing("b", not first, relations)
            for o in self.opponents:
                cpds += self.thing(o, o in relations.attended, relations)
            if relations.possessor:
                q = relations.possessor
                cpds.append(self.cpd(f"{q}.shoot", [(f"{q}.dist", 0), (f"{q}.orient", 0)], "shoot"))
            variables = {}
            for c in cpds:
                owner, attribute = c.child.split(".")
                states = tuple(map(str, range(c.table.shape[-1])))
                variables[c.child] = GroundVariable(c.child, states, None, False, "Ball" if owner == "b" else "Opponent", owner, attribute)
            self.slices[key] = GroundSlice(variables, tuple(cpds))
        return self.slices[key]

    def readings(self, rng: np.random.Generator, width: int = 1) -> dict[str, Any]:
        """What might be seen, without a care for what is true: readings near the middle, missing where an object is not seen."""
        out: dict[str, Any] = {}
        low, high = self.bins // 2 - 1, self.bins // 2 + 2
        for o in ("b", *self.opponents):
            seen = (rng.random(width) < 0.6).astype(np.int64)
            out[f"{o}.seen"] = seen
            for x in HIDDEN:
                out[f"{o}.obs_{x}"] = np.where(seen == 1, rng.integers(low, high, width), -1)
            if o != "b":
                out[f"{o}.obs_orient"] = np.where(seen == 1, rng.integers(0, SIDES, width), -1)
        return out if width > 1 else {name: int(states[0]) for name, states in out.items()}

    def hidden(self, active: Active | None = None) -> list[str]:
        """Variables whose posteriors are wanted."""
        names = [f"{o}.{x}" for o in ("b", *self.opponents) for x in HIDDEN] + [f"{o}.orient" for o in self.opponents]
        return names + ([f"{active.possessor}.shoot"] if active and active.possessor else [])

    def all_attended(self) -> Active:
        """Every opponent attended."""
        return Active(self.opponents)
