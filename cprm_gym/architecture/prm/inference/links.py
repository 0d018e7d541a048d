"""Which relations hold for whom: links of many agents, as arrays.

A `Link` says for each agent whom he means in each role; agents who mean nobody in one of them have no such relation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..model.schema import canonical_tuple

Indices = NDArray[np.integer[Any]]


@dataclass(frozen=True, eq=False)
class Role:
    """Whom each agent means: ``index[k]`` numbers the objects of the class in their order; -1 is nobody."""

    class_name: str
    index: Indices


@dataclass(frozen=True, eq=False)
class Link:
    """A relation that holds for those agents who mean somebody in all of its roles; a fixed object is given by its name."""

    relation: str
    roles: tuple[str | Role, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "roles", (self.roles,) if isinstance(self.roles, str | Role) else tuple(self.roles))


class Tie(NamedTuple):
    """A link as numbers: the objects that agents mean in each role, and for which agents it holds, (W,)."""

    relation: str
    roles: tuple[Role, ...]
    held: NDArray[np.bool_]


def as_sets(codes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Each row as a set: sorted, repetitions replaced by -1."""
    codes = np.sort(codes, axis=1)
    again = codes[:, 1:] == codes[:, :-1]
    if again.any():
        codes[:, 1:][again] = -1
        codes.sort(axis=1)
    return codes


def tuples_of(kind: tuple[str, ...], numbers: Sequence[int], members: Mapping[str, Sequence[str]]) -> list[str]:
    """Relation tuples from their numbers: a relation and the classes of its roles, and the objects as digits; -1 is none."""
    relation, *classes = kind
    found = []
    for number in numbers:
        if number < 0:
            continue
        names = []
        for class_name in reversed(classes):
            number, index = divmod(number, len(members[class_name]))
            names.append(members[class_name][index])
        found.append(canonical_tuple(relation, reversed(names)))
    return found
