"""CPDs learned from data, with counts tied per class: every object of a class teaches the same table.

`count` needs every variable observed; `em` (expectation-maximisation) takes expected counts of what is hidden or missing from
exact smoothing. A row that was never seen becomes uniform under `count`, and stays as it was under `em`.

References
----------
Koller and Friedman 2009, chapters 17 and 19; Dempster, Laird and Rubin 1977.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ....errors import EvidenceError, ModelError, ParameterError
from ..grounding.grounding import PREVIOUS, STATIC, Grounding, GroundSlice, Situation
from ..model.cpds import CPD, Dense
from ..model.model import Model
from ..model.resolved import all_rules
from .engines.engine import Engine
from .engines.noise_learning import refitted
from .engines.unfolding import Unfolded, fold, renamed, unfold, with_hidden
from .evidence import read_hard
from .filter import Filter, make_engine

Counts = dict[Hashable, np.ndarray]


@dataclass(frozen=True)
class Observed:
    """One slice of data.

    Attributes
    ----------
    evidence : dict of str to value
        Variable -> state, number or `Index`, for all runs or an array with one entry for each; what is left out, None or NaN is
        missing.
    relations : tuple of str
        Active tuples.
    objects : tuple of str or None
        Objects that exist; None for all.
    """

    evidence: Mapping[str, Any]
    relations: tuple[str, ...] = ()
    objects: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Episode:
    """Slices that follow each other, of `batch` runs under the same relations.

    Attributes
    ----------
    steps : tuple of Observed
        Bare dictionaries are taken as evidence without active relations.
    batch : int
        Number of runs.
    """

    steps: tuple[Observed, ...]
    batch: int = 1

    def __post_init__(self) -> None:
        made = tuple(s if isinstance(s, Observed) else Observed(s) for s in self.steps)
        if not made:
            raise EvidenceError("an episode needs at least one step")
        object.__setattr__(self, "steps", made)


class Fit(NamedTuple):
    """What learning gives."""

    model: Model
    """The model with the learned CPDs."""
    log_likelihoods: tuple[float, ...]
    """Of the data under the model before each iteration (`em`), or under the learned one (`count`)."""
    counts: Counts
    """Counts or, in the last iteration, expected counts by CPD, without the prior."""
    kept: tuple[Hashable, ...]
    """CPDs that were used but are not learned: fixed by `only`, or made of several tuples by mean or noisy-or."""


@dataclass
class _Tally:
    counts: Counts = field(default_factory=dict)

    def add(self, key: Hashable, table: np.ndarray) -> None:
        for k, t in attributed(key, table):
            self.counts[k] = self.counts[k] + t if k in self.counts else t.copy()


def count(
    world: Grounding,
    episodes: Iterable[Episode | Sequence[Any]],
    *,
    prior: float = 0.0,
    only: Iterable[tuple[str, ...]] | None = None,
) -> Fit:
    """Maximum likelihood (or, with a prior, Dirichlet posterior means) from complete data.

    Parameters
    ----------
    world : Grounding
        Real numbers of its model are learned as their bins.
    episodes : iterable of Episode
        Or of sequences of steps.
    prior : float
        Pseudo-count of every cell.
    only : iterable of tuple of str, optional
        Beginnings of the keys to learn, ``[("class", "Ball"), ("relation", "possesses", "shoot")]``; default all.

    Returns
    -------
    Fit

    Raises
    ------
    EvidenceError
        If a variable is not observed; the message names it and its step.
    ModelError
        If a real number has no bins.
    """
    _check_prior(prior)
    world = world.binned()
    tally = _Tally()
    for episode in _episodes(episodes):
        before: dict[str, np.ndarray] = {}
        static: dict[str, np.ndarray] = {}
        for t, situation in enumerate(_situations(world, episode)):
            ground = world.ground(situation, first=t == 0)
            values = _complete(world, ground, episode, t)
            static.update({name: values[name] for name in world.static if name in values})
            for cpd in ground.cpds:
                where = [before if lag == PREVIOUS else static if lag == STATIC else values for _, lag in cpd.parents]
                index = tuple(known[p] for known, (p, _) in zip(where, cpd.parents)) + (values[cpd.child],)
                table = np.zeros(cpd.table.shape)
                np.add.at(table, index, 1.0)
                tally.add(cpd.key, table)
            before = values
    learned, kept = _maximise(world.model, tally.counts, prior, only, stay=False)
    model = world.model.with_cpds(learned)
    return Fit(model, (_log_likelihood(model, tally.counts),), tally.counts, kept)


def em(
    world: Grounding,
    episodes: Iterable[Episode | Sequence[Any]],
    *,
    iterations: int = 20,
    tolerance: float = 0.0,
    prior: float = 0.0,
    only: Iterable[tuple[str, ...]] | None = None,
    engine: str | Engine = "exact",
) -> Fit:
    """Expectation-maximisation from the model's own CPDs, for data with hidden variables and missing readings.

    Parameters
    ----------
    world : Grounding
        With the engine ``"exact"`` real numbers of its model are learned as their bins.
    episodes : iterable of Episode
        Or of sequences of steps.
    iterations : int
        At most.
    tolerance : float
        Stop when the log-likelihood gains less than this.
    prior : float
        Pseudo-count of every cell (then the fixed point maximises the posterior); of a `Noise`, readings without offset and of scale 1.
    only : iterable of tuple of str, optional
        Beginnings of the keys to learn; default all.
    engine : {"exact", "mixture"} or Engine
        With ``"mixture"`` or ``"rao-blackwell"`` real numbers stay such: of each `Noise`, also in a `Switch`, an offset of the mean and a
        scale of the deviation are learned, of a `Chance` of numbers an offset and a scale of its log-odds, and tables as ever. Of a
        `Mixture` that is the whole CPD of a class's number, or the case of one state in a `Switch` that is, the weights are learned, whose
        counts have the key of the CPD with ``"parts"`` behind it (of a switch a row for each state), and of its parts what is learned of
        them alone. Other mixtures and a `Uniform` stay as they are. All of an episode is believed together, so its cost grows with the
        cube of its length: cut long ones.

    Returns
    -------
    Fit

    Raises
    ------
    ImpossibleEvidence
        If an episode has probability zero under the model.
    """
    _check_prior(prior)
    if iterations < 1:
        raise ParameterError(f"`iterations` must be at least 1, got {iterations!r}")
    wanted = _keys(only)
    data = _episodes(episodes)
    likelihoods: list[float] = []
    unfolded: tuple[Unfolded, ...] = ()
    if make_engine(engine, None, 2.0**31, {}).continuous:
        model, unfolded = unfold(world.model)
        wanted = with_hidden(wanted, unfolded)
    else:
        world = world.binned()
        model = world.model
    tally = _Tally()
    kept: tuple[Hashable, ...] = ()
    for _ in range(iterations):
        tally, total = _expect(Grounding(model, world.objects, _nested(world)), data, engine)
        likelihoods.append(total)
        learned, kept = _maximise(model, tally.counts, prior, wanted, stay=True)
        model = model.with_cpds(learned)
        if len(likelihoods) > 1 and likelihoods[-1] - likelihoods[-2] < tolerance:
            break
    if not unfolded:
        return Fit(model, tuple(likelihoods), tally.counts, kept)
    names = {key: renamed(key, unfolded) for key in (*tally.counts, *kept)}
    counts = {name: tally.counts[key] for key, name in names.items() if name is not None and key in tally.counts}
    return Fit(fold(model, unfolded), tuple(likelihoods), counts, tuple(n for key in kept if (n := names[key]) is not None))


def _expect(world: Grounding, episodes: Sequence[Episode], engine: str | Engine) -> tuple[_Tally, float]:
    """Expected counts and log-likelihood of all episodes."""
    tally, total = _Tally(), 0.0
    for episode in episodes:
        tracked = Filter(world, batch=episode.batch, engine=engine, window=len(episode.steps))
        for step, situation in zip(episode.steps, _situations(world, episode)):
            tracked.step(step.evidence, relations=situation)
        total += float(tracked.log_likelihood.sum())
        for key, table in tracked.expected_counts().items():
            tally.add(key, table)
    return tally, total


def attributed(key: Hashable, counts: np.ndarray) -> list[tuple[Hashable, np.ndarray]]:
    """Counts of a ground CPD as counts of the class-level CPDs it is made of.

    A mixture's counts go to the tuple that its selector names; a CPD of which two parents are one variable counts on the
    diagonal of its table. Means and noisy-ors keep their own key: what each tuple did in them cannot be told.
    """
    if not isinstance(key, tuple) or not key:
        return [(key, counts)]
    if isinstance(key[0], tuple) and len(key) == 2:
        inner, axes = key
        sizes = [counts.shape[a] for a in axes] + [counts.shape[-1]]
        table = np.zeros(sizes)
        for index in np.ndindex(counts.shape[:-1]):
            table[tuple(index[a] for a in axes)] = counts[index]
        return attributed(inner, table)
    if key[0] == "mixture":
        out = []
        for k, (inner, axes) in enumerate(zip(key[1], key[2])):
            part = counts[k]
            drop = tuple(a for a in range(part.ndim - 1) if a not in axes)
            table = part.sum(axis=drop)
            left = sorted(axes)
            out += attributed(inner, np.transpose(table, [*(left.index(a) for a in axes), len(left)]))
        return out
    return [(key, counts)]


def _keys(only: Iterable[tuple[str, ...]] | None) -> list[tuple[str, ...]] | None:
    """Beginnings of keys; one alone must still stand in a list."""
    if only is None:
        return None
    found = [only] if isinstance(only, str) else list(only)
    for key in found:
        if isinstance(key, str):
            raise ParameterError(f'`only` is a list of beginnings of keys, such as [("class", "Ball")], got {only!r}')
    return [tuple(key) for key in found]


def _maximise(
    model: Model, counts: Counts, prior: float, only: Iterable[tuple[str, ...]] | None, stay: bool
) -> tuple[dict[tuple[str, ...], CPD], tuple[Hashable, ...]]:
    """New tables from counts, and the keys that were left alone."""
    rules = all_rules(model.checked)
    starts = _keys(only)
    for start in starts or ():
        if not any(key[: len(start)] == start for key in rules):
            raise ModelError(f"model {model.name!r}: no CPD begins with {start!r}")
    learned: dict[tuple[str, ...], CPD] = {}
    kept = []
    for key, table in counts.items():
        rule = rules.get(key)  # type: ignore[call-overload]
        if rule is None or (starts is not None and not any(rule.key[: len(s)] == s for s in starts)):
            kept.append(key)
            continue
        if rule.density is not None:
            fitted = refitted(rule, table, prior)
            if fitted is None:
                kept.append(key)
            else:
                learned[rule.key] = fitted
            continue
        pseudo = table + prior
        total = pseudo.sum(axis=-1, keepdims=True)
        unseen = rule.table if stay else np.full(table.shape, 1.0 / table.shape[-1])
        values = np.where(total > 0.0, pseudo / np.where(total > 0.0, total, 1.0), unseen)
        learned[rule.key] = Dense(values, [*(s.domain.stamp for s in rule.parents), rule.domain.stamp])
    return learned, tuple(kept)


def _log_likelihood(model: Model, counts: Counts) -> float:
    """Of complete data, from its counts."""
    rules = all_rules(model.checked)
    total = 0.0
    for key, table in counts.items():
        rule = rules.get(key)  # type: ignore[call-overload]
        if rule is not None:
            seen = table > 0.0
            with np.errstate(divide="ignore"):
                total += float(table[seen] @ np.log(rule.table[seen]))
    return total


def _complete(world: Grounding, ground: GroundSlice, episode: Episode, t: int) -> dict[str, np.ndarray]:
    """State of every variable of a slice in every run."""
    names = tuple(ground.variables)
    row = {name: k for k, name in enumerate(names)}
    cards = np.array([v.card for v in ground.variables.values()])
    hard = read_hard(ground.variables, names, cards, row, episode.steps[t].evidence, episode.batch)
    for name, state in world.defaults(ground).items():
        hard[row[name], hard[row[name]] < 0] = state
    if (hard < 0).any():
        at, run = (int(i) for i in np.argwhere(hard < 0)[0])
        raise EvidenceError(f"step {t}, run {run}: {names[at]!r} is not observed; use `em` for data with hidden variables")
    return dict(zip(names, hard))


def _situations(world: Grounding, episode: Episode) -> list[Situation]:
    """Relations and objects of every step, with what is new in it."""
    out: list[Situation] = []
    for step in episode.steps:
        out.append(world.situation(step.relations, step.objects, out[-1] if out else None))
    return out


def _episodes(episodes: Iterable[Episode | Sequence[Any]]) -> list[Episode]:
    return [e if isinstance(e, Episode) else Episode(tuple(e)) for e in episodes]


def _nested(world: Grounding) -> dict[str, dict[str, tuple[str, ...]]]:
    out: dict[str, dict[str, tuple[str, ...]]] = {}
    for (name, slot), targets in world.references.items():
        out.setdefault(name, {})[slot] = targets
    return out


def _check_prior(prior: float) -> None:
    if not (np.isfinite(prior) and prior >= 0.0):
        raise ParameterError(f"`prior` is a pseudo-count, at least 0, got {prior!r}")
