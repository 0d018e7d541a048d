"""The frames that can be looked at again: the latest as they are, older ones packed."""

from __future__ import annotations

import json
import zlib
from collections import OrderedDict
from collections.abc import Iterator, Mapping

from ..running.frames import Message

KEPT = 6000
"""Frames that can be looked at again: the cycles of a match."""
RECENT = 200
"""Of them are kept as they are."""


class Frames(Mapping[int, Message]):
    """Cycle -> frame, in the order of the cycles; beyond `KEPT` the oldest is dropped."""

    def __init__(self) -> None:
        self._recent: OrderedDict[int, Message] = OrderedDict()
        self._packed: OrderedDict[int, bytes] = OrderedDict()

    def put(self, frame: Message) -> None:
        """Keep a frame; of a cycle that is there already, in its place."""
        cycle = frame["cycle"]
        if cycle in self._packed:
            self._packed[cycle] = _pack(frame)
            return
        self._recent[cycle] = frame
        if len(self._recent) > RECENT:
            oldest, old = self._recent.popitem(last=False)
            self._packed[oldest] = _pack(old)
            if len(self._packed) > KEPT - RECENT:
                self._packed.popitem(last=False)

    def drop_after(self, cycle: int) -> None:
        """Forget later cycles."""
        for kept in (self._recent, self._packed):
            for later in [c for c in kept if c > cycle]:
                del kept[later]  # type: ignore[attr-defined]

    def clear(self) -> None:
        """Forget everything."""
        self._recent.clear()
        self._packed.clear()

    def span(self) -> list[int]:
        """The first and the last cycle; 0 and 0 when there is none."""
        kept = [*list(self._packed)[:1], *list(self._recent)[:1], *list(self._packed)[-1:], *list(self._recent)[-1:]]
        return [min(kept), max(kept)] if kept else [0, 0]

    def last(self, count: int) -> list[Message]:
        """The latest of them."""
        return [self[cycle] for cycle in list(self)[-count:]]

    def __getitem__(self, cycle: int) -> Message:
        found = self._recent.get(cycle)
        return found if found is not None else json.loads(zlib.decompress(self._packed[cycle]))

    def __contains__(self, cycle: object) -> bool:
        return cycle in self._recent or cycle in self._packed

    def __iter__(self) -> Iterator[int]:
        yield from self._packed
        yield from self._recent

    def __len__(self) -> int:
        return len(self._packed) + len(self._recent)


def _pack(frame: Message) -> bytes:
    return zlib.compress(json.dumps(frame, separators=(",", ":")).encode(), 1)
