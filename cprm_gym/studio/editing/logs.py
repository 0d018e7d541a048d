"""Learning a model's CPDs from a log of readings.

A log is JSON, ``{"episodes": [[{"evidence": {"ball.dist": 3.2}, "relations": ["possesses(o1,ball)"]}, ...], ...]}``, or CSV: a column
for each variable, a row for each slice, an empty row between episodes; an empty cell was not observed, a column ``relations`` holds what
is in force, parted by blanks.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...architecture.prm import Episode, Grounding, Model, Observed, count, em
from ...errors import FormatError, ParameterError, unknown_name
from ...files import parse_json, read_bounded

MAX_BYTES = 2**26
METHODS = ("count", "em")
ITERATIONS, MOST_ITERATIONS = 10, 1000
"""Of expectation-maximisation."""


def read_log(path: Path) -> list[Episode]:
    """The episodes of a log.

    Raises
    ------
    FormatError
        When the file is none; the message says where.
    """
    try:
        text = read_bounded(path, MAX_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FormatError(f"{path.name}: not text: {error}") from None
    found = _of_json(parse_json(text, path.name), path.name) if path.suffix == ".json" else _of_csv(text, path.name)
    if not found:
        raise FormatError(f"{path.name}: no episodes in it")
    return found


def _of_json(data: Any, where: str) -> list[Episode]:
    episodes = data.get("episodes") if isinstance(data, dict) else None
    if not isinstance(episodes, list) or not all(isinstance(e, list) and e for e in episodes):
        raise FormatError(f"{where}: 'episodes' is a list of lists of slices")
    made = []
    for k, episode in enumerate(episodes):
        steps = []
        for t, step in enumerate(episode):
            here = f"{where}: episode {k}, slice {t}"
            if not isinstance(step, dict) or not isinstance(step.get("evidence"), dict):
                raise FormatError(f"{here}: is an object with 'evidence'")
            relations = step.get("relations", [])
            if not isinstance(relations, list) or not all(isinstance(r, str) for r in relations):
                raise FormatError(f"{here}: 'relations' is a list of texts")
            steps.append(Observed(step["evidence"], tuple(relations)))
        made.append(Episode(tuple(steps)))
    return made


def _of_csv(text: str, where: str) -> list[Episode]:
    rows = list(csv.reader(io.StringIO(text)))
    if not rows or not any(cell.strip() for cell in rows[0]):
        raise FormatError(f"{where}: the first row names the variables")
    names = [cell.strip() for cell in rows[0]]
    episodes: list[list[Observed]] = [[]]
    for number, row in enumerate(rows[1:], 2):
        if not any(cell.strip() for cell in row):
            episodes.append([])
            continue
        if len(row) != len(names):
            raise FormatError(f"{where}: row {number} has {len(row)} cells for {len(names)} columns")
        cells = {name: cell.strip() for name, cell in zip(names, row)}
        relations = tuple(cells.pop("relations", "").split())
        episodes[-1].append(Observed({name: _value(cell) for name, cell in cells.items() if cell}, relations))
    return [Episode(tuple(steps)) for steps in episodes if steps]


def _value(cell: str) -> str | float:
    try:
        return float(cell)
    except ValueError:
        return cell


def log_text(episodes: Iterable[Sequence[tuple[Mapping[str, Any], Sequence[str]]]]) -> str:
    """A log in JSON, of slices with what was observed, None for what was not, and the relations in force."""
    said = [[{"evidence": {n: v for n, v in told.items() if v is not None}, "relations": list(relations)} for told, relations in episode]
            for episode in episodes]  # fmt: skip
    return json.dumps({"episodes": said}, separators=(",", ":"), ensure_ascii=False) + "\n"


def learn(
    grounding: Grounding, episodes: list[Episode], method: str = "em", prior: float | None = None, iterations: int = ITERATIONS
) -> tuple[Model, dict[str, Any]]:
    """The model with learned CPDs, and what to tell about it.

    Parameters
    ----------
    grounding : Grounding
    episodes : list of Episode
    method : {"count", "em"}
        Everything is observed; or something is hidden.
    prior : float, optional
        Counts added to each state of a table: by default 1 for ``count``, 0 for ``em``, which leaves rows that were not seen as they were.
    iterations : int
        Of ``em``, at most.

    Raises
    ------
    CprmError
        When the readings do not fit the model.
    """
    if method not in METHODS:
        raise unknown_name("method", method, METHODS)
    if not 1 <= iterations <= MOST_ITERATIONS:
        raise ParameterError(f"iterations: 1 to {MOST_ITERATIONS}, got {iterations}")
    if method == "count":
        fit = count(grounding, episodes, prior=1.0 if prior is None else prior)
    else:
        fit = em(grounding, episodes, prior=prior or 0.0, iterations=iterations)
    told = {
        "episodes": len(episodes),
        "slices": sum(len(e.steps) for e in episodes),
        "log_likelihoods": [float(v) for v in fit.log_likelihoods],
        "learned": sorted({".".join(key[1:3]) for key in map(_key, fit.counts) if len(key) > 2}),
    }
    return fit.model, told


def _key(key: Any) -> tuple[str, ...]:
    return tuple(map(str, key)) if isinstance(key, tuple) else (str(key),)
