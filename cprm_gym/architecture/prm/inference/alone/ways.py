"""Where the only agent of a bank goes from slice to slice, remembered.

Whom an agent means decides how the objects are numbered, which relations hold, which slice follows and where its readings stand. All of
that follows from the slice before and the objects that are meant, so it is worked out once for each turn that an agent takes: he stands
somewhere (`Stand`), and for those whom he means there leads a `Way` on.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compiled.slice_info import SliceInfo
from ..filtering import FilterState
from ..links import Indices, Link

MOST_STANDS = 4096
"""That are remembered; then all are forgotten."""


@dataclass(eq=False)
class Stand:
    """A slice, and an order of the objects; where it leads, by `key_of` the relations that are asked for.

    Whoever asks with the same links again, one and the same object, is answered without a look at them.
    """

    ways: dict[Hashable, Way] = field(default_factory=dict)
    _last: tuple[Sequence[Link], Way] | None = None

    def way(self, links: Sequence[Link]) -> Way | None:
        """The way on; None where nobody has gone it."""
        if self._last is not None and self._last[0] is links:
            return self._last[1]
        found = self.ways.get(key_of(links))
        return None if found is None else self.leads(links, found)

    def leads(self, links: Sequence[Link], way: Way) -> Way:
        """Remember a way."""
        self.ways[key_of(links)] = way
        if isinstance(links, tuple):
            self._last = links, way
        return way


@dataclass(frozen=True, eq=False)
class Way:
    """What the next slice is.

    Attributes
    ----------
    names : dict of str to str
        New names of objects in the belief.
    situation : Situation
    info : SliceInfo
    rows : int array
        Where the readings of the slice stand among those of the bank.
    lost : int array
        Readings of the bank that the slice lacks.
    object_in, place_of : dict of str to (1, n) int array
        The order of the objects.
    """

    names: Mapping[str, str]
    situation: Any
    info: SliceInfo
    rows: NDArray[np.int64]
    lost: NDArray[np.int64]
    object_in: Mapping[str, Indices]
    place_of: Mapping[str, Indices]


def key_of(links: Sequence[Link]) -> Hashable:
    """What relations the only agent asks for, and whom he means in them."""
    return tuple(
        (link.relation, *(r if isinstance(r, str) else (r.class_name, int(r.index[0])) for r in link.roles))
        if isinstance(link, Link)
        else link
        for link in links
    )


class Ways:
    """All stands, and the one that the agent is at."""

    def __init__(self) -> None:
        self._stands: dict[Hashable, Stand] = {}
        self._state: FilterState | None = None
        self._at = Stand()
        self._after: dict[Way, Stand] = {}

    def stand(self, state: FilterState, object_in: Mapping[str, Indices]) -> Stand:
        """Where the agent stands."""
        if state is not self._state:
            self._state, self._at = state, self._find(state, object_in)
        return self._at

    def went(self, way: Way, state: FilterState, object_in: Mapping[str, Indices]) -> None:
        """The agent has gone a way."""
        known = self._after.get(way) if state.info is way.info and not state.late else None
        if known is None:
            known = self._find(state, object_in)
            if state.info is way.info and not state.late:
                self._after[way] = known
        self._state, self._at = state, known

    def _find(self, state: FilterState, object_in: Mapping[str, Indices]) -> Stand:
        if len(self._stands) > MOST_STANDS:
            self._stands.clear()
            self._after.clear()
        order = tuple((name, index.tobytes()) for name, index in object_in.items())
        key = state.info if state.step else None, state.relations if state.step else (), order, state.late
        return self._stands.setdefault(key, Stand())
