"""How much the bins alone spread a belief.

A filter keeps of a number only its bin, and takes it as uniform inside. At every step a little mass leaks into the next bin and
is spread over it: an object that moves a share p of a bin per step gains a variance of about ``w**2 * p * (1 - p)`` each time,
noise or not. The report compares, for every binned quantity with a motion of its own, the chain of bins with the motion it was
made from. Remedy: narrower bins where it matters, not wider than two or three steps of motion; or a coarser time step.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ....errors import ParameterError
from .cpds import CPD, Noise, Switch
from .domains import Bins, Domain
from .formulas import Formula
from .model import Model
from .moments import circular_mean, variance
from .resolved import Rule, Slot, all_rules


class Diffusion(NamedTuple):
    """One quantity under one setting of the others."""

    key: tuple[str, ...]
    """The CPD: kind, owner, attribute or change, part."""
    given: dict[str, str]
    """State of the other parents, held all the time."""
    start: str
    """Bin it starts in."""
    width: float
    """Of that bin."""
    shift: float
    """How far the mean moves in one step."""
    steps: int
    """How many were made: fewer than asked for where the motion would leave the bins."""
    mean: float
    """After all steps, of the motion itself."""
    deviation: float
    binned_mean: float
    """After all steps, of the chain of bins."""
    binned_deviation: float
    distance: float
    """Total variation between the two as beliefs over bins, 0 to 1."""

    @property
    def inflation(self) -> float:
        """How many times wider the belief is than what it stands for."""
        return self.binned_deviation / self.deviation if self.deviation > 0.0 else float("inf")


@dataclass(frozen=True)
class DiffusionReport:
    """What the bins of a model do to its motions; prints as a table, the worst first.

    Attributes
    ----------
    rows : tuple of Diffusion
    """

    rows: tuple[Diffusion, ...]

    @property
    def worst(self) -> Diffusion | None:
        """The quantity whose bins distort it most."""
        return max(self.rows, key=lambda r: r.distance, default=None)

    def __str__(self) -> str:
        if not self.rows:
            return "no binned quantity moves by a noise model"
        head = "moved and spread as the motion says -> as its bins say"
        lines = [
            head,
            f"{'quantity':<28} {'given':<26} {'shift/bin':>9} {'steps':>5} {'mean':>19} {'deviation':>17} {'times':>6} {'TV':>5}",
        ]
        for r in sorted(self.rows, key=lambda r: -r.distance):
            given = ", ".join(f"{p} {s}" for p, s in r.given.items()) or "-"
            lines.append(
                f"{'.'.join(r.key[1:3]):<28} {given[:26]:<26} {r.shift / r.width:>9.2f} {r.steps:>5}"
                f" {r.mean:>8.2f} -> {r.binned_mean:>7.2f}"
                f" {r.deviation:>7.2f} -> {r.binned_deviation:>6.2f} {r.inflation:>6.2f} {r.distance:>5.2f}"
            )
        return "\n".join(lines)


def diffusion_report(model: Model, steps: int = 20, samples: int = 10_000, seed: int = 0) -> DiffusionReport:
    """Compare the motions of a model with what its bins make of them.

    For every CPD that integrates a noise model over the quantity's own previous value, with the other parents held in their
    lowest, middle and highest state: start uniform in one bin, go `steps` steps.

    Parameters
    ----------
    model : Model
    steps : int
        At most; fewer where the motion would leave the bins.
    samples : int
        Paths of the motion itself, drawn without bins.
    seed : int

    Returns
    -------
    DiffusionReport
    """
    if steps < 1 or samples < 2:
        raise ParameterError(f"at least 1 step and 2 samples, got {steps} and {samples}")
    rng = np.random.default_rng(seed)
    rows = []
    for rule in all_rules(model.checked).values():
        if rule.key[3] != "cpd" or not isinstance(rule.domain, Bins):
            continue
        me = _own_past(rule)
        if me is not None:
            for noise, cases in _noises(rule.cpd, {}):
                rows += _compare(rule, me, noise, cases, steps, samples, rng)
    return DiffusionReport(tuple(rows))


def _own_past(rule: Rule) -> Slot | None:
    """The parent that is the quantity itself in the previous slice."""
    role, _, name = rule.key[2].rpartition(".")
    for slot in rule.parents:
        if slot.lag and slot.aggregate is None and not slot.references and slot.attribute == name and slot.role == role:
            return slot
    return None


def _noises(cpd: CPD, cases: dict[str, str]) -> Iterator[tuple[Noise, dict[str, str]]]:
    """Noise models inside a CPD, with the states under which a switch chooses them."""
    if isinstance(cpd, Noise):
        yield cpd, cases
    elif isinstance(cpd, Switch):
        for state, inner in cpd.cases:
            yield from _noises(inner, {**cases, cpd.parent: state})


def _settings(others: list[Slot], cases: dict[str, str]) -> Iterator[dict[str, int]]:
    """Lowest, middle and highest state of all other parents together; those of a switch as it says."""
    for share in (0.0, 0.5, 1.0):
        out = {}
        for slot in others:
            state = cases.get(slot.text, "*")
            last = len(slot.domain) - 1
            out[slot.text] = slot.domain.states.index(state) if state != "*" else round(share * last)
        yield out


def _value(domain: Domain, state: int) -> float:
    return float(domain.values[state]) if isinstance(domain, Bins) else float(state)


def _compare(
    rule: Rule, me: Slot, noise: Noise, cases: dict[str, str], steps: int, samples: int, rng: np.random.Generator
) -> list[Diffusion]:
    bins = rule.domain
    assert isinstance(bins, Bins)
    mean, sd = Formula(noise.mean), Formula(str(noise.sd))
    others = [s for s in rule.parents if s is not me]
    out = []
    seen: list[dict[str, int]] = []
    for setting in _settings(others, cases):
        if setting in seen:
            continue
        seen.append(setting)
        held = {s.text: _value(s.domain, setting[s.text]) for s in others}

        def at(formula: Formula, x: np.ndarray, held: dict[str, float] = held) -> np.ndarray:
            known = {n: x if n == me.text else np.full(len(x), held[n]) for n in formula.names}
            return formula(known, len(x))

        middle = np.array(bins.values)
        drift = at(mean, middle) - middle
        count = _steps_inside(bins, drift, steps)
        start = _start(bins, drift, count)
        x = bins.edges[start] + rng.uniform(size=samples) * bins.widths[start]
        for _ in range(count):
            spread = at(sd, x)
            shocks = rng.standard_normal(samples) if noise.shape == "normal" else rng.uniform(-(3**0.5), 3**0.5, samples)
            x = at(mean, x) + spread * shocks
        index = tuple(slice(None) if s is me else setting[s.text] for s in rule.parents)
        belief = np.zeros(len(bins))
        belief[start] = 1.0
        for _ in range(count):
            belief = belief @ rule.table[index]
        true_mean, true_sd, true_belief = _summary(bins, x)
        binned = circular_mean(belief, bins) if bins.circular else belief @ middle
        out.append(Diffusion(
            rule.key, {n: s.domain.states[setting[n]] for n, s in ((s.text, s) for s in others)}, bins.states[start],
            bins.widths[start], float(drift[start]), count, true_mean, true_sd, float(binned),
            float(np.sqrt(variance(belief, bins))), 0.5 * float(np.abs(belief - true_belief).sum()),
        ))  # fmt: skip
    return out


def _steps_inside(bins: Bins, drift: np.ndarray, steps: int) -> int:
    """How many steps a motion stays within the middle part of the bins."""
    speed = float(np.abs(drift).min())
    if bins.circular or speed <= 0.0:
        return steps
    return int(np.clip(0.6 * (bins.edges[-1] - bins.edges[0]) / speed, 1, steps))


def _start(bins: Bins, drift: np.ndarray, steps: int) -> int:
    """The bin from which the motion stays inside the range longest: the one nearest to having its path in the middle."""
    if bins.circular:
        return 0
    middle = np.array(bins.values)
    centre = 0.5 * (bins.edges[0] + bins.edges[-1])
    return int(np.argmin(np.abs(middle + 0.5 * steps * drift - centre)))


def _summary(bins: Bins, x: np.ndarray) -> tuple[float, float, np.ndarray]:
    """Mean and deviation of samples, the short way round for angles, and their belief over the bins."""
    edges = np.array(bins.edges)
    if bins.circular:
        turn = 2.0 * np.pi / bins.period
        mean = float(np.angle(np.exp(1j * turn * x).mean()) / turn)
        away = np.mod(x - mean + 0.5 * bins.period, bins.period) - 0.5 * bins.period
        mean = float(edges[0] + (mean - edges[0]) % bins.period)
        deviation = float(away.std())
        x = edges[0] + np.mod(x - edges[0], bins.period)
    else:
        mean, deviation = float(x.mean()), float(x.std())
    state = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, len(bins) - 1)
    return mean, deviation, np.bincount(state, minlength=len(bins)) / len(x)
