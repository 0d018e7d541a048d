"""A belief of independent parts, each a mixture: states in slots, and a normal over columns of numbers.

Like parts are kept side by side in a group, for one call of a kernel: row ``part * W + agent`` of its arrays.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from .....errors import ModelError
from ..compiled.slice_info import SliceInfo
from ..join_tree import connected
from .kernels import groups as kernels
from .normal_mixture import NormalMixture


class Part(NamedTuple):
    """What one independent part is about.

    Attributes
    ----------
    slots : tuple of str
        Variables with states.
    columns : tuple of str
        Numbers.
    """

    slots: tuple[str, ...]
    columns: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """All of them."""
        return self.slots + self.columns


class Group(NamedTuple):
    """Like parts of W agents, M of them.

    Attributes
    ----------
    parts : tuple of Part
    log_weights : (M * W, K) float array
        Minus infinity where there is no component; the others sum to one.
    states : (M * W, K, D) int array
    means : (M * W, K, N) float array
    covs : (M * W, K, N, N) float array
    """

    parts: tuple[Part, ...]
    log_weights: np.ndarray
    states: np.ndarray
    means: np.ndarray
    covs: np.ndarray

    @property
    def arrays(self) -> tuple[np.ndarray, ...]:
        """Weights, states, means, covariances."""
        return self[1:]

    def rows(self, agents: int, member: int) -> tuple[np.ndarray, ...]:
        """The arrays of one part."""
        return tuple(a[member * agents : (member + 1) * agents] for a in self.arrays)


class MixtureBelief(NamedTuple):
    """What a Gaussian engine knows; its arrays are never changed.

    Attributes
    ----------
    info : SliceInfo or None
        The last slice.
    groups : tuple of Group
    batch : int
        W, the number of agents.
    random : mapping
        State of the stream of random numbers, for engines that draw.
    """

    info: SliceInfo | None
    groups: tuple[Group, ...]
    batch: int
    random: Mapping[str, Any] = MappingProxyType({})

    @property
    def form(self) -> tuple[tuple[Part, ...], ...]:
        """Its parts by group."""
        return tuple(g.parts for g in self.groups)

    def find(self, name: str) -> tuple[int, int]:
        """Group and part of a variable; (-1, -1) where it is not kept."""
        for g, group in enumerate(self.groups):
            for m, part in enumerate(group.parts):
                if name in part.slots or name in part.columns:
                    return g, m
        return -1, -1

    def part(self, name: str) -> tuple[Part, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The part with a variable: its names, weights (W, K), states, means and covariances."""
        g, m = self.find(name)
        group = self.groups[g]
        log_weights, states, means, covs = group.rows(self.batch, m)
        return group.parts[m], np.exp(log_weights), states, means, covs

    def number(self, name: str, period: float) -> NormalMixture:
        """The posterior of a number that is kept."""
        part, weights, _, means, covs = self.part(name)
        c, there = part.columns.index(name), weights > 0.0
        return NormalMixture(weights, np.where(there, means[:, :, c], 0.0), np.where(there, covs[:, :, c, c], 0.0), period)

    def states(self, names: Sequence[str], cards: Sequence[int]) -> np.ndarray:
        """Joint probabilities of states of one part, (W, card, ...)."""
        part, weights, states, _, _ = self.part(names[0])
        index = np.zeros(weights.shape, np.int64)
        for name, card in zip(names, cards):
            index = index * card + np.where(weights > 0.0, states[:, :, part.slots.index(name)], 0)
        out = np.zeros((self.batch, int(np.prod(cards))))
        np.add.at(out, (np.arange(self.batch)[:, None], index), weights)
        return out.reshape(self.batch, *cards)

    def select(self, agents: np.ndarray) -> MixtureBelief:
        """The belief of some agents."""
        groups = []
        for g in self.groups:
            rows = (np.arange(len(g.parts))[:, None] * self.batch + agents).ravel()
            groups.append(Group(g.parts, *(a[rows] for a in g.arrays)))
        return self._replace(groups=tuple(groups), batch=len(agents))

    def renamed(self, info: SliceInfo, pairs: Mapping[str, str]) -> MixtureBelief:
        """The belief with other names; `info` is a slice with them."""
        groups = tuple(
            g._replace(parts=tuple(Part(*(tuple(pairs.get(n, n) for n in names) for names in part)) for part in g.parts))
            for g in self.groups
        )
        return self._replace(info=info, groups=groups)

    def conformed(self, parts: Sequence[Part], room: int) -> MixtureBelief:
        """The belief with each of these parts alone in a group; what was independent stands side by side in it."""
        groups = []
        for part in parts:
            sources: list[tuple[int, int]] = []
            for name in part.names:
                found = self.find(name)
                if found[0] < 0:
                    raise ModelError(f"some agents begin anew while others go on, and {name!r} is not in a first slice")
                if found not in sources:
                    sources.append(found)
            arrays, whole, _ = side_by_side([(self.groups[g].parts[m], self.groups[g].rows(self.batch, m)) for g, m in sources], room)
            slots, columns = [whole.slots.index(n) for n in part.slots], [whole.columns.index(n) for n in part.columns]
            groups.append(
                Group((part,), arrays[0], arrays[1][:, :, slots], arrays[2][:, :, columns], arrays[3][:, :, columns][..., columns])
            )
        return self._replace(groups=tuple(groups))


def side_by_side(sources: Sequence[tuple[Part, tuple[np.ndarray, ...]]], room: int) -> tuple[tuple[np.ndarray, ...], Part, np.ndarray]:
    """Components of independent parts together, at most `room` of them, and the loss of those left out, (rows,) nats."""
    (whole, arrays), *more = sources
    loss = np.zeros(len(arrays[0]))
    for part, others in more:
        rows, count = len(arrays[0]), min(arrays[0].shape[1] * others[0].shape[1], room)
        slots, columns = arrays[1].shape[2] + others[1].shape[2], arrays[2].shape[2] + others[2].shape[2]
        made = (
            np.empty((rows, count)), np.zeros((rows, count, slots), np.int64), np.zeros((rows, count, columns)),
            np.zeros((rows, count, columns, columns)),
        )  # fmt: skip
        lost = np.empty(rows)
        kernels.product(*map(np.ascontiguousarray, arrays), *map(np.ascontiguousarray, others), *made, lost)
        arrays, loss = made, loss + lost
        whole = Part(whole.slots + part.slots, whole.columns + part.columns)
    return arrays, whole, loss


def with_agents(old: MixtureBelief, new: MixtureBelief, agents: np.ndarray, room: int) -> MixtureBelief:
    """The belief that is `new` for some agents; parts are joined where the two divide the variables differently."""
    if old.form != new.form:
        kept = {n for g in old.groups for p in g.parts for n in p.names}
        scopes = [p.names for b in (old, new) for g in b.groups for p in g.parts if set(p.names) & kept]
        slots = {n for g in old.groups for p in g.parts for n in p.slots}
        parts = []
        for indices in connected(scopes):
            names = [n for n in dict.fromkeys(n for i in indices for n in scopes[i]) if n in kept]
            parts.append(Part(tuple(n for n in names if n in slots), tuple(n for n in names if n not in slots)))
        old, new = old.conformed(parts, room), new.conformed(parts, room)
    groups = []
    for a, b in zip(old.groups, new.groups):
        count = max(a.log_weights.shape[1], b.log_weights.shape[1])
        arrays = [x.copy() for x in widened(a, count)]
        rows = (np.arange(len(a.parts))[:, None] * old.batch + agents).ravel()
        for x, y in zip(arrays, widened(b, count)):
            x[rows] = y
        groups.append(Group(a.parts, *arrays))
    return old._replace(groups=tuple(groups))


def widened(group: Group, count: int) -> tuple[np.ndarray, ...]:
    """The arrays of a group with room for this many components."""
    missing = count - group.log_weights.shape[1]
    if not missing:
        return group.arrays
    fills = (-np.inf, 0, 0.0, 0.0)
    return tuple(
        np.concatenate([a, np.full((len(a), missing, *a.shape[2:]), fill, a.dtype)], axis=1) for a, fill in zip(group.arrays, fills)
    )


def joined(beliefs: Sequence[MixtureBelief]) -> MixtureBelief:
    """The belief of the agents of several of one form."""
    groups, batch = [], sum(b.batch for b in beliefs)
    for g, first in enumerate(beliefs[0].groups):
        count = max(b.groups[g].log_weights.shape[1] for b in beliefs)
        members = len(first.parts)
        stacks = zip(*(widened(b.groups[g], count) for b in beliefs))
        arrays = []
        for stack in stacks:
            split = [a.reshape(members, b.batch, *a.shape[1:]) for a, b in zip(stack, beliefs)]
            whole = np.concatenate(split, axis=1)
            arrays.append(whole.reshape(members * batch, *whole.shape[2:]))
        groups.append(Group(first.parts, *arrays))
    return beliefs[0]._replace(groups=tuple(groups), batch=batch)
