"""May modules that work at once disturb each other?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..logic.implication import implies
from .modules import Summary


@dataclass(frozen=True)
class Interference:
    """An answer about two modules.

    Attributes
    ----------
    first, second : str
    holds : bool or None
        Whether they may interfere; None: not decided.
    why : str
    """

    first: str
    second: str
    holds: bool | None
    why: str

    def __str__(self) -> str:
        word = {True: "interfere", False: "do not interfere", None: "may interfere"}[self.holds]
        return f"{self.first} and {self.second} {word}: {self.why}"


def reached(writes: Sequence[str], edges: Sequence[tuple[str, str]]) -> set[str]:
    """All quantities that change when these do: closed under what the world lets depend on what."""
    found, todo = set(writes), list(writes)
    while todo:
        quantity = todo.pop()
        for source, target in edges:
            if source == quantity and target not in found:
                found.add(target)
                todo.append(target)
    return found


def interferes(
    first_name: str, first: Summary, second_name: str, second: Summary, edges: Sequence[tuple[str, str]] = (),
    kinds: Mapping[str, str] | None = None, actions: Mapping[str, str] | None = None,
) -> Interference:  # fmt: skip
    """Whether one of two modules may disturb the other.

    Footprints first: what one writes, closed under the world's dependencies, must not meet what the other reads or writes. Where it does,
    and the other says what it `keeps` (an invariant on which it relies), it is enough that every action of the first preserves that
    (Owicki and Gries 1976), decided by `implies`.

    Parameters
    ----------
    first_name, second_name : str
    first, second : Summary
    edges : sequence of (str, str)
        Quantity -> quantity that depends on it, within a step or later.
    kinds : mapping, optional
        Of quantities, as for `implies`.
    actions : mapping of str to str, optional
        Module -> what its action does, a condition over quantities and their next values, ``"next_d == d - c and 0 <= c <= d"``.
    """
    both = set(first.writes) & set(second.writes)
    if both:
        return Interference(first_name, second_name, True, f"both write {', '.join(sorted(both))}")
    for (name, one), (other_name, other) in (((first_name, first), (second_name, second)), ((second_name, second), (first_name, first))):
        disturbed = reached(one.writes, edges) & set(other.reads)
        if not disturbed:
            continue
        what = f"{name} changes {', '.join(sorted(disturbed))}, which {other_name} reads"
        action = (actions or {}).get(name)
        if not (other.keeps and action):
            return Interference(first_name, second_name, True, what)
        after = _next(other.keeps, disturbed)
        verdict = implies(f"({other.keeps}) and ({action})", after, kinds)
        if verdict.holds is not True:
            return Interference(
                first_name, second_name, None if verdict.holds is None else True, f"{what}; {other.keeps} is not kept: {verdict}"
            )
    return Interference(first_name, second_name, False, "no footprint meets the other's, or what it relies on is kept")


def _next(text: str, quantities: set[str]) -> str:
    from ...expressions import Expression

    return Expression(text).rename(lambda name: f"next_{name}" if name in quantities else name).text


def groups(pairs: Sequence[tuple[str, str]]) -> list[tuple[str, ...]]:
    """Modules that are connected by pairs, each group in alphabetical order."""
    root: dict[str, str] = {}

    def find(n: str) -> str:
        root.setdefault(n, n)
        while root[n] != n:
            n = root[n]
        return n

    for a, b in pairs:
        root[find(a)] = find(b)
    found: dict[str, list[str]] = {}
    for n in list(root):
        found.setdefault(find(n), []).append(n)
    return sorted(tuple(sorted(g)) for g in found.values())
