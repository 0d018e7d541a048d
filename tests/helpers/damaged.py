"""Damaged texts and documents, at random from a seed: what a reader of files must survive."""

from __future__ import annotations

import copy
import json
import random
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from cprm_gym.errors import CprmError

WORDS = (
    '"', "{", "}", "(", ")", "[", "]", ";", "|", ",", ":", "=", "\\", "/*", "*/", "//", "\n", "\x00", "²", "é", "null", "true", "nan", "-1",
    "9e999", "1_0", "0x1", "1e-400", "2**80", "1" * 400, "prev.", "*", "..", "is", "[" * 200, '{"a":' * 200,
)  # fmt: skip

VALUES: tuple[Any, ...] = (
    None, True, False, -1, 0, 1, 2, 10**12, 2**80, -0.0, 0.5, 1e300, -1e300, 5e-324, "", "x", "a.b", "prev.x", "*", "0", "1 / 0", "(" * 80,
    "x" * 3000, "\x00", [], {}, [[]], [1], ["a"], [0.5, 0.5], [["a", "b"]], {"is": "Uniform"}, {"is": "Labels", "names": ["a"]},
    {"is": "Noise", "mean": "x"}, {"a": {"b": []}},
)  # fmt: skip


def damaged_text(rng: random.Random, text: str) -> str:
    """A text with some pieces cut out, doubled, moved or replaced."""
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(text) + 1)
        end = min(len(text), at + rng.choice((0, 1, 3, 10, 60)))
        kind = rng.randrange(4)
        if kind == 0:
            text = text[:at] + rng.choice(WORDS) + text[end:]
        elif kind == 1:
            text = text[:at] + text[end:]
        elif kind == 2:
            text = text[:end] + text[at:end] + text[end:]
        else:
            to = rng.randrange(len(text) + 1)
            text = text[:to] + text[at:end] + text[to:]
    return text


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Every place of a JSON document."""
    yield path
    if isinstance(value, dict | list):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from places(value[key], (*path, key))


def damaged_document(rng: random.Random, document: Any) -> Any:
    """A document with some parts replaced by others of it, by odd values, left out, or under another key."""
    document = copy.deepcopy(document)
    for _ in range(rng.randint(1, 3)):
        every = [p for p in places(document) if p]
        if not every:
            return document
        *way, last = rng.choice(every)
        inner = document
        for key in way:
            inner = inner[key]
        kind = rng.randrange(5)
        if kind <= 1:
            inner[last] = copy.deepcopy(rng.choice(VALUES))
        elif kind == 2:
            part = document
            for key in rng.choice(every):
                part = part[key]
            inner[last] = copy.deepcopy(part)
        elif kind == 3:
            del inner[last]
        elif isinstance(inner, dict):
            inner[rng.choice(("x", "name", "is", "parents", "cpd", last))] = inner.pop(last)
        else:
            inner.append(copy.deepcopy(inner[last]))
    return document


def survives(read: Callable[[str], Any], texts: Sequence[str], count: int, seed: int, slowest: float = 10.0) -> tuple[int, int]:
    """Give a reader `count` damaged texts: how many it refused, and how many it took. Anything but an error of ours is a failure.

    Parameters
    ----------
    read : callable
    texts : sequence of str
        Sound ones; those that are JSON are damaged as documents half the time.
    count, seed : int
    slowest : float
        Seconds that one text may take.
    """
    rng = random.Random(seed)
    documents = [json.loads(t) if t.lstrip().startswith("{") else None for t in texts]
    refused = taken = 0
    for k in range(count):
        which = rng.randrange(len(texts))
        whole = documents[which] is not None and rng.random() < 0.5
        text = json.dumps(damaged_document(rng, documents[which])) if whole else damaged_text(rng, texts[which])
        begun = time.perf_counter()
        try:
            read(text)
            taken += 1
        except CprmError:
            refused += 1
        except Exception as error:
            raise AssertionError(f"input {k} of seed {seed}: {type(error).__name__}: {error}\n{text}") from error
        took = time.perf_counter() - begun
        assert took < slowest, f"input {k} of seed {seed} took {took:.1f} s:\n{text}"
    return refused, taken
