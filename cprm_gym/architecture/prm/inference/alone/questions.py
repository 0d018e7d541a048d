"""Numbers of the posterior of one agent that are asked in every slice, read together."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...grounding.slices import GroundVariable
from ...model.domains import Domain
from ...model.moments import is_angle, mean, points
from ..compiled.alone.program import Program
from ..compiled.steps import SliceStep
from ..views import View

Asked = tuple[NDArray[np.int64], Callable[[NDArray[np.float64]], NDArray[np.float64]]]
"""Which questions, and what reads the answers from all marginals of a step."""


class Question(NamedTuple):
    """A view of an attribute of an object, or of the object that the agent means."""

    view: View
    class_name: str
    number: int
    """Number of the object in its class; of what is meant the place where that stands."""
    meant: bool
    attribute: str
    default: float
    """The answer where nobody is meant."""


def find(
    questions: Sequence[Question],
    held: Sequence[int],
    members: Mapping[str, Sequence[str]],
    place_of: Mapping[str, NDArray[np.integer[Any]]],
    variables: Mapping[str, GroundVariable],
    step: SliceStep,
    program: Program,
) -> list[Asked] | None:
    """Where the answers stand, those about variables of one domain side by side; None where one is no hidden variable of the step.

    Parameters
    ----------
    questions : sequence of Question
    held : sequence of int
        Numbers of the objects that the agent means, -1 for nobody.
    members : mapping of str to sequence of str
        The objects of each class.
    place_of : mapping of str to (1, n) int array
        Of classes whose objects the agent numbers for itself, the place of each object.
    variables : mapping of str to GroundVariable
    step : SliceStep
    program : Program
    """
    alike: dict[tuple[View, Domain], tuple[list[int], list[range]]] = {}
    nobody: dict[int, float] = {}
    for k, q in enumerate(questions):
        index = held[q.number] if q.meant else q.number
        if index < 0:
            nobody[k] = q.default
            continue
        places = place_of.get(q.class_name)
        name = f"{members[q.class_name][index if places is None else int(places[0, index])]}.{q.attribute}"
        if name not in step.where:
            return None
        rows, entries = alike.setdefault((q.view, variables[name].domain), ([], []))
        rows.append(k)
        entries.append(program.entries(step.where[name]))
    found: list[Asked] = [(np.array(rows), _reader(view, domain, np.array(entries))) for (view, domain), (rows, entries) in alike.items()]
    if nobody:
        values = np.array(list(nobody.values()))
        found.append((np.array(list(nobody)), lambda _: values))
    return found


def _reader(view: View, domain: Domain, entries: NDArray[np.int64]) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """What reads a view of several marginals that stand at `entries`, (n, K)."""
    if view.kind == "expectation" and not is_angle(domain):
        values = points(domain)
        return lambda flat: mean(flat[entries], values)
    return lambda flat: view(flat[entries], domain)
