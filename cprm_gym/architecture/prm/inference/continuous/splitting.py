"""Parts of a belief that the next slice links no more: believed apart where that loses little, and what it loses at most.

Relations join what they link, and nothing parts it again by itself: a player who has had the ball would be believed together with it for
ever. Where the slice that comes links neither directly nor by what is read of both, each may go on by its marginal. The loss is the
divergence from the joint to the product, their mutual information, of which an upper bound is told: of one normal it is that number.

References
----------
Boyen and Koller 1998 (the error stays bounded); Kolchinsky and Tracey 2017 (what the choice of a component tells, at most).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...grounding.slices import PREVIOUS
from ..compiled.slice_info import SliceInfo
from ..join_tree import connected
from .belief import Group, MixtureBelief, Part

Loose = tuple[int, int, tuple[tuple[str, ...], ...]]
"""Group and part of a belief, and the sets of its variables that nothing links."""
JITTER = 1e-12
"""Share of a variance that is added to it, so that what is known for certain has one."""
LEAST = 1e-18


def loose_parts(belief: MixtureBelief, info: SliceInfo, unread: frozenset[str]) -> tuple[Loose, ...]:
    """Parts of which the slice that comes needs several sets of variables that it does not link.

    Parameters
    ----------
    belief : MixtureBelief
        Its form matters, not its numbers.
    info : SliceInfo
        Of the slice that comes.
    unread : frozenset of str
        Leaves that nobody read.
    """
    old = {name for parts in belief.form for part in parts for name in part.names}
    scopes: list[tuple[object, ...]] = []
    for cpd in info.slice.cpds:
        if cpd.child in unread:
            continue
        tokens: list[object] = [cpd.child]
        for parent, lag in cpd.parents:
            if lag != PREVIOUS and parent in info.slice.variables:
                tokens += [] if info.given[info.row[parent]] else [parent]
            elif parent in old:
                tokens.append((parent,))
        scopes.append(tuple(tokens))
    scopes += [((n,),) for n in sorted(old) if n in info.row and info.static[info.row[n]] and n not in info.slice.variables]
    where = {t[0]: k for k, some in enumerate(connected(scopes)) for i in some for t in scopes[i] if isinstance(t, tuple)}
    found: list[Loose] = []
    for g, parts in enumerate(belief.form):
        for m, part in enumerate(parts):
            sets: dict[int, list[str]] = {}
            for name in part.names:
                if name in where:
                    sets.setdefault(where[name], []).append(name)
            if len(sets) > 1:
                found.append((g, m, tuple(tuple(s) for s in sets.values())))
    return tuple(found)


def apart(belief: MixtureBelief, loose: Sequence[Loose], most: float) -> tuple[MixtureBelief, np.ndarray]:
    """The belief with loose sets in parts of their own, where that loses no agent more than `most`; and the loss, (W,) nats.

    Parameters
    ----------
    belief : MixtureBelief
    loose : sequence of Loose
        Of `loose_parts`; variables that stand in none of its sets are left out of those parts.
    most : float
        Nats for each set.
    """
    loss, chosen = np.zeros(belief.batch), {}
    for g, m, sets in loose:
        group = belief.groups[g]
        arrays, left, taken = group.rows(belief.batch, m), list(sets), []
        for some in sorted(sets, key=len):
            others = [n for s in left for n in s if s is not some]
            if not others:
                break
            lost = shared_information(group.parts[m], arrays, some, others)
            if (lost <= most).all():
                loss += lost
                taken.append(some)
                left.remove(some)
        if taken:
            chosen[g, m] = (*taken, tuple(n for s in left for n in s))
    if not chosen:
        return belief, loss
    groups: list[Group] = []
    for g, group in enumerate(belief.groups):
        alike: dict[tuple[Part, ...], list[int]] = {}
        for m, part in enumerate(group.parts):
            pattern = tuple(
                Part(
                    tuple(str(part.slots.index(n)) for n in s if n in part.slots),
                    tuple(str(part.columns.index(n)) for n in s if n in part.columns),
                )
                for s in chosen.get((g, m), (part.names,))
            )
            alike.setdefault(pattern, []).append(m)
        for pattern, members in alike.items():
            rows = (np.array(members)[:, None] * belief.batch + np.arange(belief.batch)).ravel()
            for slots, columns in pattern:
                at, to = [int(k) for k in slots], [int(k) for k in columns]
                parts = tuple(
                    Part(tuple(group.parts[m].slots[k] for k in at), tuple(group.parts[m].columns[k] for k in to)) for m in members
                )
                means, covs = group.means[rows][:, :, to], group.covs[rows][:, :, to][:, :, :, to]
                groups.append(Group(parts, group.log_weights[rows], group.states[rows][:, :, at], means, covs))
    return belief._replace(groups=tuple(groups)), loss


def shared_information(part: Part, arrays: tuple[np.ndarray, ...], some: Sequence[str], others: Sequence[str]) -> np.ndarray:
    """What two sets of variables of a part tell of each other at most, (W,) nats; of one component, what they do tell."""
    log_weights, states, means, covs = arrays
    weights = np.exp(log_weights)
    columns = [[part.columns.index(n) for n in names if n in part.columns] for names in (some, others)]
    slots = [[part.slots.index(n) for n in names if n in part.slots] for names in (some, others)]
    there = weights > 0.0
    inside = np.zeros(len(weights))
    if columns[0] and columns[1]:
        volumes = [_log_volume(covs[:, :, at][:, :, :, at], there) for at in (*columns, columns[0] + columns[1])]
        inside = (np.where(there, weights, 0.0) * 0.5 * np.maximum(volumes[0] + volumes[1] - volumes[2], 0.0)).sum(axis=1)
    if weights.shape[1] == 1:
        return inside
    between = [_told_by(weights, states[:, :, s], means[:, :, c], covs[:, :, c][:, :, :, c]) for s, c in zip(slots, columns)]
    return np.asarray(inside + np.minimum(*between))


def _firm(covs: np.ndarray, there: np.ndarray) -> np.ndarray:
    """Covariances that can be inverted; of components that are not there, any."""
    d = covs.shape[-1]
    firm = np.where(there[..., None, None], covs, np.eye(d))
    spread = np.einsum("...ii->...i", firm)
    return firm + (JITTER * spread + LEAST)[..., None] * np.eye(d)


def _log_volume(covs: np.ndarray, there: np.ndarray) -> np.ndarray:
    """Log determinants of correlations, (W, K)."""
    firm = _firm(covs, there)
    spread = np.sqrt(np.einsum("...ii->...i", firm))
    return np.asarray(np.linalg.slogdet(firm / spread[..., None] / spread[..., None, :])[1])


def _told_by(weights: np.ndarray, states: np.ndarray, means: np.ndarray, covs: np.ndarray) -> np.ndarray:
    """How much some variables tell of the component at most, (W,) nats, from the divergences between components."""
    there, d = weights > 0.0, means.shape[-1]
    away = np.where((states[:, :, None] == states[:, None]).all(axis=-1), 0.0, np.inf)
    if d:
        firm = _firm(covs, there)
        inverse, volume = np.linalg.inv(firm), np.linalg.slogdet(firm)[1]
        off = means[:, :, None] - means[:, None]
        away = away + 0.5 * np.maximum(
            np.einsum("wjab,wkba->wkj", inverse, firm) + np.einsum("wkja,wjab,wkjb->wkj", off, inverse, off)
            - d + volume[:, None] - volume[:, :, None],
            0.0,
        )  # fmt: skip
    alike = np.einsum("wj,wkj->wk", np.where(there, weights, 0.0), np.exp(-away))
    return np.asarray(-(np.where(there, weights, 0.0) * np.log(np.where(there, np.maximum(alike, 1e-300), 1.0))).sum(axis=1))
