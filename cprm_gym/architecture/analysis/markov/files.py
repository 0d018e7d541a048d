"""Chains in files: our JSON, with large matrices beside it as .npz; and what Storm and PRISM read."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from ....errors import FormatError
from ....files import read_bounded
from .chain import MarkovChain, start_at

MAX_BYTES = 512 * 2**20
"""Of a JSON file that is read."""


def chain_from_json(data: Mapping[str, Any], folder: Path | None = None) -> MarkovChain:
    """The chain that plain values describe.

    Parameters
    ----------
    data : mapping
        ``n``, ``init`` (a state, or state -> probability), ``classes`` (outcome -> states), and ``rows`` (lists of
        ``[target, probability]``, a probability as a number or a fraction, ``"1/3"``) or ``npz``, a file with arrays ``indptr``,
        ``indices``, ``data``; ``names`` may name the states.
    folder : Path, optional
        Where the file that ``npz`` names lies.

    Raises
    ------
    FormatError
        When something is missing or not understood; the message says what.
    ModelError
        When it is no chain.
    """
    if not isinstance(data, Mapping):
        raise FormatError(f"chain: an object is needed, got {type(data).__name__}")
    missing = [key for key in ("n", "init", "classes") if key not in data]
    if missing or ("rows" not in data) == ("npz" not in data):
        raise FormatError(f"chain: needs n, init, classes and either rows or npz; missing: {', '.join(missing) or 'rows or npz'}")
    n = data["n"]
    if isinstance(n, bool) or not isinstance(n, int) or n < 1:
        raise FormatError(f"chain: n is a number of states from 1, got {n!r}")
    try:
        outcomes = {str(name): np.asarray(list(states), np.int64) for name, states in data["classes"].items()}
        given = data["init"]
        initial = start_at(n, {int(k): _number(v) for k, v in given.items()} if isinstance(given, Mapping) else int(given))
        if "rows" in data:
            rows = data["rows"]
            if len(rows) != n:
                raise FormatError(f"chain: {len(rows)} rows for {n} states")
            lengths = [len(row) for row in rows]
            targets = np.array([int(j) for row in rows for j, _ in row], np.int64)
            chances = np.array([_number(p) for row in rows for _, p in row], np.float64)
            offsets = np.cumsum([0, *lengths])
        else:
            offsets, targets, chances = _arrays(data["npz"], folder)
    except (TypeError, ValueError, AttributeError, ArithmeticError) as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(f"chain: not understood: {error}") from None
    if len(offsets) != n + 1 or (targets.size and not (targets.min() >= 0 and targets.max() < n)):
        raise FormatError(f"chain: rows or targets that are no states from 0 to {n - 1}")
    return MarkovChain(offsets, targets.astype(np.int32), chances, outcomes, initial, tuple(map(str, data.get("names", ()))))


def load_chain(path: str | os.PathLike[str]) -> MarkovChain:
    """The chain in a JSON file (`chain_from_json`).

    Raises
    ------
    FormatError
        When it cannot be read; the message names the file.
    """
    file = Path(path)
    try:
        data = json.loads(read_bounded(file, MAX_BYTES))
    except (ValueError, RecursionError) as error:
        raise FormatError(f"{file}: {error}") from None
    try:
        return chain_from_json(data, file.parent)
    except FormatError as error:
        raise FormatError(f"{file}: {error}") from None


def chain_to_json(chain: MarkovChain) -> dict[str, Any]:
    """As plain values that `chain_from_json` reads back to an equal chain."""
    at = np.flatnonzero(chain.initial)
    start: Any = int(at[0]) if len(at) == 1 and chain.initial[at[0]] == 1.0 else {str(i): float(chain.initial[i]) for i in at}
    rows = [
        [[j, p] for j, p in zip(chain.targets[a:b].tolist(), chain.chances[a:b].tolist())]
        for a, b in zip(chain.offsets[:-1].tolist(), chain.offsets[1:].tolist())
    ]
    out: dict[str, Any] = {"n": chain.n, "init": start, "classes": {k: v.tolist() for k, v in chain.outcomes.items()}, "rows": rows}
    return {**out, "names": [chain.name(i) for i in range(chain.n)]} if callable(chain.names) or len(chain.names) else out


def save_chain(chain: MarkovChain, path: str | os.PathLike[str]) -> None:
    """Write a chain as JSON."""
    Path(path).write_text(json.dumps(chain_to_json(chain)), encoding="utf-8")


def chain_to_drn(chain: MarkovChain) -> str:
    """As text in Storm's explicit format (DRN); outcomes are labels, states that are ended in lead to themselves.

    References
    ----------
    https://www.stormchecker.org/documentation/background/languages.html
    """
    start = np.flatnonzero(chain.initial)
    extra = len(start) > 1  # one state more that draws the start
    label = _labels(chain)
    n = chain.n + extra
    lines = ["@type: DTMC", "@parameters", "", "@reward_models", "cycles", "@nr_states", str(n), "@nr_choices", str(n), "@model"]
    absorbing = chain.absorbing
    for i in range(chain.n):
        labels = (" init" if not extra and i == start[0] else "") + (f" {label[i]}" if i in label else "")
        lines += [f"state {i} [{0 if absorbing[i] else 1}]{labels}", "\taction 0 [0]"]
        row = {i: 1.0} if absorbing[i] else chain.row(i)
        lines += [f"\t\t{j} : {p!r}" for j, p in sorted(row.items()) if p > 0]
    if extra:
        lines += [f"state {chain.n} [0] init", "\taction 0 [0]", *(f"\t\t{i} : {float(chain.initial[i])!r}" for i in start)]
    return "\n".join(lines) + "\n"


def chain_to_prism(chain: MarkovChain) -> str:
    """As text in the language of PRISM: one variable ``s``, a label for each outcome, a reward ``cycles``."""
    start = np.flatnonzero(chain.initial)
    extra = len(start) > 1
    first = chain.n if extra else int(start[0])
    lines = ["dtmc", "", "module chain", f"  s : [0..{chain.n - 1 + extra}] init {first};"]
    absorbing = chain.absorbing
    for i in range(chain.n):
        row = {i: 1.0} if absorbing[i] else chain.row(i)
        lines.append(f"  [] s={i} -> {_updates(row)};")
    if extra:
        lines.append(f"  [] s={chain.n} -> {_updates({int(i): float(chain.initial[i]) for i in start})};")
    lines += ["endmodule", ""]
    moving = " & ".join(f"s!={i}" for i in np.flatnonzero(absorbing)) or "true"
    if extra:
        moving += f" & s!={chain.n}"
    for name, states in chain.outcomes.items():
        lines.append(f'label "{_word(name)}" = {" | ".join(f"s={i}" for i in states) or "false"};')
    lines += ["", 'rewards "cycles"', f"  {moving} : 1;", "endrewards"]
    return "\n".join(lines) + "\n"


def _updates(row: Mapping[int, float]) -> str:
    return " + ".join(f"{p!r} : (s'={j})" for j, p in sorted(row.items()) if p > 0)


def _word(name: str) -> str:
    return re.sub(r"\W", "_", name)


def _labels(chain: MarkovChain) -> dict[int, str]:
    return {int(i): _word(name) for name, states in chain.outcomes.items() for i in states}


def _number(text: Any) -> float:
    """A probability as a number or a fraction."""
    return float(Fraction(text)) if isinstance(text, str) else float(text)


def _arrays(name: Any, folder: Path | None) -> tuple[Any, Any, Any]:
    """Compressed rows from a .npz beside the file."""
    if not isinstance(name, str) or Path(name).name != name or not name.endswith(".npz") or folder is None:
        raise FormatError(f"chain: npz names a file in the same folder, got {name!r}")
    try:
        with np.load(folder / name, allow_pickle=False) as file:
            return file["indptr"].astype(np.int64), file["indices"].astype(np.int64), file["data"].astype(np.float64)
    except (OSError, KeyError, ValueError) as error:
        raise FormatError(f"chain: {name}: {error}") from None
