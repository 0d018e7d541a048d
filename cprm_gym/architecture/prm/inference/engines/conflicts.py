"""Readings of probability zero: which of them contradict the belief, and what to do about it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from cprm_gym.errors import ImpossibleEvidence

from ..compiled.slice_info import SliceInfo
from ..evidence import UNOBSERVED, Readings, one_hot


def impossible_evidence(names: Sequence[str], info: SliceInfo, readings: Readings, agents: np.ndarray, step: int) -> ImpossibleEvidence:
    """The error that names the conflicting readings of the first agent concerned."""
    agent = int(agents[0])
    shown = []
    for name in names:
        if name in readings.numbers:
            low, high = (float(ends[agent]) for ends in readings.numbers[name])
            shown.append(f"{name} = {low:g}" if low == high else f"{name} from {low:g} to {high:g}")
            continue
        value = readings.hard[info.row[name], agent]
        shown.append(f"{name} = {info.variables[name].states[value]}" if value >= 0 else f"the likelihood of {name}")
    who = f" (agent {agent}{f' and {len(agents) - 1} more' if len(agents) > 1 else ''})" if readings.hard.shape[1] > 1 else ""
    return ImpossibleEvidence(
        f"step {step}: the belief excludes {' together with '.join(shown) or 'what was read'}{who}; it is left as it was",
        step=step,
        conflict=tuple(names),
        agents=tuple(int(a) for a in agents),
    )


def softened(info: SliceInfo, readings: Readings, conflicts: Mapping[int, Sequence[str]], eps: float | None) -> Readings:
    """Readings with the conflicting ones of each agent taken out, or taken as true with probability ``1 - eps``.

    Parameters
    ----------
    info : SliceInfo
    readings : Readings
    conflicts : dict of agent to names
    eps : float or None
        None takes the readings out.
    """
    hard = readings.hard.copy()
    soft = {name: np.array(likelihood) for name, likelihood in readings.soft.items()}
    numbers = dict(readings.numbers)
    for agent, names in conflicts.items():
        for name in names:
            row = info.row[name]
            card = int(info.cards[row])
            if name in numbers:  # of a real number that is excluded nothing is left to be soft about
                numbers[name] = numbers[name].without(np.array([agent]))
                hard[row, agent] = UNOBSERVED
                continue
            if eps is None:
                if name in soft:
                    soft[name][agent] = 1.0
            elif hard[row, agent] >= 0:
                likelihood = soft.setdefault(name, one_hot(hard[row], card))
                likelihood[agent] = eps / card
                likelihood[agent, hard[row, agent]] += 1.0 - eps
            else:
                soft[name][agent] = (1.0 - eps) * soft[name][agent] + eps * max(soft[name][agent].max(), 1e-300)
            hard[row, agent] = UNOBSERVED
    return Readings(hard, soft, numbers)
