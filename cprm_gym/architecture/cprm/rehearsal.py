"""Slices that are only imagined, so that what the first use of relations and readings has to make is there before they come."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ...errors import CprmError
from ..prm.inference.evidence import StateRows
from ..prm.inference.filter_bank import FilterBank
from ..prm.inference.links import Link

EPISODE = 20
"""Slices after which the imagined agent begins anew."""


def rehearse(
    bank: FilterBank,
    observed: Sequence[Sequence[str]],
    meant: Sequence[int],
    links: Callable[[np.ndarray], Sequence[Link]],
    slices: int,
    after: Callable[[np.ndarray], object],
) -> None:
    """Let the only agent of a bank go through imagined slices, and then begin anew.

    Whom he means changes now and then, and so does what he observes; what he reads is always the middle of each variable's states. No
    answer depends on it: it takes time now that the first slices would take else.

    Parameters
    ----------
    bank : FilterBank
        Of one agent, who has made no step.
    observed : sequence of sequences of str
        Variables that are observed together or not at all.
    meant : sequence of int
        For each object that the agent means, how many there are to choose from.
    links : callable
        Whom he means (-1: nobody) -> relations.
    slices : int
    after : callable
        Is called with whom he means after every slice.
    """
    rng = np.random.default_rng(0)
    names = tuple(dict.fromkeys(name for group in observed for name in group))
    middle = np.array([bank.variables[name].card // 2 for name in names], np.int64)[:, None]
    held, counts = np.full(len(meant), -1, np.int32), np.array(meant, np.int64)
    for k in range(slices):
        if k % EPISODE == 0:
            bank.reset()
            held[:] = -1
        turns = rng.random(len(meant)) < rng.choice([0.0, 0.4, 1.0])
        # objects of a class are alike, so a few of them will do
        held = np.where(turns, rng.integers(-1, np.minimum(counts, 3)), held).astype(np.int32)
        share = rng.choice([0.0, 0.5, 1.0])  # mostly a closed eye observes nothing, and an open one everything
        seen = {name for group in observed if rng.random() < share for name in group}
        shown = np.array([name in seen for name in names], bool)[:, None]
        try:
            bank.step(StateRows(names, np.where(shown, middle, -1), checked=True), links(held))
            after(held)
        except CprmError:  # an impossible reading, or relations that do not go together: the real agent will say so
            bank.reset()
    bank.reset()
    bank.impossible_count[:] = 0
