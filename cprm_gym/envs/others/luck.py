"""Luck of a controller, each world's own: what a world is given does not depend on how many others there are."""

from __future__ import annotations

import numpy as np


class WorldLuck:
    """A generator for each of N worlds.

    Parameters
    ----------
    count : int
        Numbers that are drawn for a world at once.

    Attributes
    ----------
    seeds : (N, 2) int64 array
        What each world's generator was made from.
    draws : (N,) int64 array
        How often it was drawn from. Both are live: who writes into them sets the luck back.
    """

    def __init__(self, count: int) -> None:
        self.count = count
        self.seeds, self.draws = np.zeros((0, 2), np.int64), np.zeros(0, np.int64)
        self._generators: list[np.random.Generator] = []
        self._known = np.zeros((0, 3), np.int64)

    def begin(self, seeds: np.ndarray, salt: int | np.ndarray, worlds: np.ndarray | None = None) -> None:
        """New luck.

        Parameters
        ----------
        seeds : (N,) int array
        salt : int or (N,) int array
            A second number of each seed, at least 0: so that players of one world differ.
        worlds : (N,) bool array, optional
            Which worlds; all if not given.
        """
        seeds = np.asarray(seeds, np.int64)
        if worlds is None or len(self.draws) != len(seeds):
            self.seeds, self.draws = np.zeros((len(seeds), 2), np.int64), np.zeros(len(seeds), np.int64)
            worlds = np.ones(len(seeds), bool)
        self.seeds[worlds, 0] = seeds[worlds]
        self.seeds[worlds, 1] = np.broadcast_to(salt, seeds.shape)[worlds]
        self.draws[worlds] = 0

    def draw(self) -> np.ndarray:
        """(N, count) numbers in [0, 1)."""
        now = np.column_stack([self.seeds, self.draws])
        if now.shape != self._known.shape:
            self._generators, self._known = [np.random.default_rng(0)] * len(now), np.full(now.shape, -1)
        for k in np.flatnonzero((now != self._known).any(axis=1)):
            bits = np.random.PCG64(np.random.SeedSequence(now[k, :2].tolist()))
            self._generators[k] = np.random.Generator(bits.advance(self.count * int(now[k, 2])))
        out = np.array([g.random(self.count) for g in self._generators]).reshape(len(now), self.count)
        self.draws += 1
        now[:, 2] += 1
        self._known = now
        return out

    def state(self) -> dict[str, np.ndarray]:
        """The live arrays."""
        return {"seeds": self.seeds, "draws": self.draws}
