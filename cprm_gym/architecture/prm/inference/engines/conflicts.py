"""Readings of probability zero: which of them contradict the belief, and what to do about it."""

from __future__ import annotations

from typing import Any

import numpy as np

from cprm_gym.errors import ImpossibleEvidence

from ..bayes_net import one_hot
from ..compiled.steps import ABSORBED, NeedsVariable, SliceInfo
from ..evidence import UNOBSERVED, Readings
from .exact import ExactEngine, Outcome


def suspects(outcome: Outcome, agent: int) -> list[str]:
    """Observed variables of the components in which an agent's readings are impossible, except what is given."""
    info = outcome.info
    names: dict[str, None] = {}
    for group, b in outcome.excluded(agent):
        for name in sorted(group.readings[b], key=lambda n: info.row[n]):
            seen = outcome.readings.hard[info.row[name], agent] >= 0 or name in outcome.readings.soft
            if seen and not info.given[info.row[name]]:
                names[name] = None
    return list(names)


def minimal_conflict(engine: ExactEngine, before: Any, info: SliceInfo, readings: Readings, names: list[str], agent: int) -> list[str]:
    """A smallest-by-inclusion subset of the readings that still has probability zero.

    Each reading is left out in turn, and stays out if the rest is still impossible.
    """
    row = np.array([agent])
    batch = readings.hard.shape[1]
    alone = before._replace(messages=tuple(np.ascontiguousarray(m[agent::batch]) for m in before.messages), hard=before.hard[:, row])
    kept = list(names)

    def impossible(left: list[str]) -> bool:
        part = readings.rows(row)
        hard = part.hard.copy()
        for name in names:
            if name not in left:
                hard[info.row[name]] = UNOBSERVED
        soft = {n: s for n, s in part.soft.items() if n in left or n not in names}
        try:
            return bool(engine.advance(alone, info, Readings(hard, soft)).impossible[0])
        except NeedsVariable:
            return False

    for name in names:
        left = [n for n in kept if n != name]
        if impossible(left):
            kept = left
    return kept


def explain(
    engine: Any, before: Any, info: SliceInfo, readings: Readings, outcome: Any, agents: np.ndarray, step: int
) -> ImpossibleEvidence:
    """The error that names a smallest conflicting set of readings of the first agent concerned."""
    agent = int(agents[0])
    if isinstance(outcome, Outcome) and not outcome.replaced and isinstance(engine, ExactEngine):
        names = minimal_conflict(engine, before, info, readings, suspects(outcome, agent), agent)
    elif hasattr(outcome, "suspects"):
        names = outcome.suspects(agent)
    else:
        names = [n for n, r in info.row.items() if readings.hard[r, agent] >= 0 and not info.given[r]]
    shown = []
    for name in names:
        value = readings.hard[info.row[name], agent]
        shown.append(f"{name} = {info.variables[name].states[value]}" if value >= 0 else f"the likelihood of {name}")
    who = f" (agent {agent}{f' and {len(agents) - 1} more' if len(agents) > 1 else ''})" if readings.hard.shape[1] > 1 else ""
    return ImpossibleEvidence(
        f"step {step}: the belief excludes {' together with '.join(shown) or 'what was read'}{who}; it is left as it was",
        step=step,
        conflict=tuple(names),
        agents=tuple(int(a) for a in agents),
    )


def soften(outcome: Outcome, info: SliceInfo, readings: Readings, agents: np.ndarray, eps: float | None, extent: str) -> Readings | None:
    """Readings with the impossible ones taken out, or taken as true with probability ``1 - eps``.

    Parameters
    ----------
    outcome : Outcome
        Of the readings.
    info : SliceInfo
    readings : Readings
    agents : int array
        Those concerned.
    eps : float or None
        None takes the readings out.
    extent : {"readings", "components", "everything"}
        Only childless readings of the components that are impossible; every observed variable of these; all that the agents
        observed. What is given stays.

    Returns
    -------
    Readings or None
        None if there is nothing left to change.
    """
    hard = readings.hard.copy()
    soft = dict(readings.soft)
    changed = False
    for agent in map(int, agents):
        for name in info.names if extent == "everything" else suspects(outcome, agent):
            row = info.row[name]
            if info.given[row] or (extent == "readings" and outcome.slice_step.status[row] != ABSORBED):
                continue
            card = int(info.cards[row])
            observed = hard[row, agent] >= 0
            if observed and eps is not None:
                likelihood = np.array(soft[name]) if name in soft else one_hot(hard[row], card)
                likelihood[agent] = eps / card
                likelihood[agent, hard[row, agent]] += 1.0 - eps
                soft[name] = likelihood
                changed = True
            elif not observed and name in soft and (soft[name][agent] <= 0.0).any():
                likelihood = np.array(soft[name])
                share = 0.0 if eps is None else 1.0 - eps
                likelihood[agent] = share * likelihood[agent] + (1.0 - share) * max(likelihood[agent].max(), 1e-300)
                soft[name] = likelihood
                changed = True
            changed |= bool(observed)
            hard[row, agent] = UNOBSERVED
    return Readings(hard, soft) if changed else None
