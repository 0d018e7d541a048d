"""What a replay found: numbers compared, largest errors, every mismatch, statistical tests; for reading and as JSON."""

from __future__ import annotations

import dataclasses
import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

SHOWN = 20
"""Mismatches printed per file; all of them are in the JSON, up to `KEPT`."""
KEPT = 10_000


@dataclass(frozen=True, slots=True)
class Mismatch:
    """One number or text that did not come out as recorded.

    ``expected`` is what the real server said, ``got`` what the simulator said, ``tolerance`` the difference allowed (0 for texts).
    """

    case: str
    cycle: int
    object: str
    quantity: str
    expected: Any
    got: Any
    tolerance: float = 0.0

    def __str__(self) -> str:
        place = f"{self.case}, cycle {self.cycle}, {self.object}: {self.quantity}"
        return f"{place} expected {_shown(self.expected)}, got {_shown(self.got)}"


@dataclass(frozen=True, slots=True)
class Check:
    """One statistical test or share: passed when `value` is at least `limit`."""

    name: str
    value: float
    limit: float
    detail: str = ""

    @property
    def passed(self) -> bool:
        """Whether the value reaches the limit; NaN never does."""
        return self.value >= self.limit

    def __str__(self) -> str:
        mark = "ok  " if self.passed else "FAIL"
        return f"{mark} {self.name}: {self.value:.6g} (at least {self.limit:g})" + (f"; {self.detail}" if self.detail else "")


@dataclass(slots=True)
class Result:
    """The outcome of one file.

    Attributes
    ----------
    path : str
    kind : str
        Scenario name, ``match`` or ``statistics``.
    cycles : int
        Cycles replayed and compared; those replayed freely count again.
    compared : int
        Single comparisons.
    errors : dict
        Quantity -> largest difference seen, mismatches included.
    counts : dict
        Quantity -> comparisons.
    mismatches : list of Mismatch
        The first `KEPT` of them; `failed` counts all.
    chance : int
        Objects in a cycle whose outcome depends on a draw that no record tells, and which were therefore not compared.
    checks : list of Check
    notes : list of str
        Explanations: what was left out, what differs and why.
    not_replayed : str
        Why the file could only be read; empty for those that are compared.
    """

    path: str
    kind: str
    cycles: int = 0
    compared: int = 0
    errors: dict[str, float] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    mismatches: list[Mismatch] = field(default_factory=list)
    failed: int = 0
    chance: int = 0
    checks: list[Check] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    not_replayed: str = ""

    @property
    def ok(self) -> bool:
        """No mismatch and every check passed."""
        return not self.failed and all(check.passed for check in self.checks)

    def add(self, mismatch: Mismatch) -> None:
        """Record a mismatch."""
        self.failed += 1
        if len(self.mismatches) < KEPT:
            self.mismatches.append(mismatch)

    def number(self, case: str, cycle: int, object: str, quantity: str, expected: float, got: float, tolerance: float) -> bool:
        """Compare two numbers; True when they agree."""
        error = abs(expected - got)
        self.compared += 1
        self.counts[quantity] = self.counts.get(quantity, 0) + 1
        if not error <= self.errors.get(quantity, -1.0):
            self.errors[quantity] = error
        if error <= tolerance:
            return True
        self.add(Mismatch(case, cycle, object, quantity, expected, got, tolerance))
        return False

    def equal(self, case: str, cycle: int, object: str, quantity: str, expected: Any, got: Any) -> bool:
        """Compare two values that must be the same; True when they are."""
        self.compared += 1
        self.counts[quantity] = self.counts.get(quantity, 0) + 1
        if expected == got:
            return True
        self.add(Mismatch(case, cycle, object, quantity, expected, got))
        return False

    def text(self) -> str:
        """The file's paragraph of the printed report."""
        if self.not_replayed:
            return f"---- {self.path} ({self.kind}): not replayed, {self.not_replayed}"
        lines = [f"{'ok  ' if self.ok else 'FAIL'} {self.path} ({self.kind}): {self.cycles} cycles, {self.compared} comparisons"]
        if self.chance:
            lines.append(f"     left to chance: {self.chance} objects in a cycle (a draw that the recording does not tell)")
        if self.errors:
            lines.append("     largest error: " + ", ".join(f"{name} {error:.3g}" for name, error in sorted(self.errors.items())))
        texts = {name: count for name, count in self.counts.items() if name not in self.errors}
        if texts:
            lines.append("     compared as they are: " + ", ".join(f"{name} {count}" for name, count in sorted(texts.items())))
        lines += [f"     {check}" for check in self.checks]
        lines += [f"     note: {note}" for note in self.notes]
        if self.mismatches:
            number = max(self.failed, len(self.mismatches))
            what = "mismatches" if self.failed else "differences within what the checks allow"
            lines.append(f"     {number} {what}" + (f", the first {SHOWN}:" if number > SHOWN else ":"))
            lines += [f"       {mismatch}" for mismatch in self.mismatches[:SHOWN]]
        return "\n".join(lines)


@dataclass(slots=True)
class Report:
    """The outcomes of all files of one run."""

    results: list[Result] = field(default_factory=list)

    @property
    def ok(self) -> bool:
        """Every file came out as recorded."""
        return all(result.ok for result in self.results)

    def text(self) -> str:
        """What the command prints."""
        bad = sum(not result.ok for result in self.results)
        cycles = sum(result.cycles for result in self.results)
        count = len(self.results)
        verdict = f"{bad} {'file differs' if bad == 1 else 'files differ'}" if bad else "all as recorded"
        last = f"{count} {'file' if count == 1 else 'files'}, {cycles} cycles: {verdict}"
        left = sum(bool(result.not_replayed) for result in self.results)
        if left:
            last += f"; {left} of the files could not be replayed"
        return "\n".join([result.text() for result in self.results] + [last])

    def to_json(self, indent: int | None = 2) -> str:
        """The same with every mismatch, as a JSON object; numbers that are not finite become strings."""
        content = {"ok": self.ok, "files": [_plain(result) for result in self.results]}
        return json.dumps(content, indent=indent, allow_nan=False, default=str)


def _plain(result: Result) -> dict[str, Any]:
    content = dataclasses.asdict(result)
    content["ok"] = result.ok
    for check, values in zip(result.checks, content["checks"]):
        values["passed"] = check.passed
    finite: dict[str, Any] = _finite(content)
    return finite


def _finite(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, dict):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    if isinstance(value, Path):
        return str(value)
    return value.item() if hasattr(value, "item") else value


def _shown(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.17g}"
    return repr(value)
