"""The map of knowledge as a page: results of the suite ``knowledge``, and the tables and pictures that are made of them.

``python docs/map.py`` writes them anew from ``docs/results/knowledge.json`` into ``docs/knowledge.md`` and ``docs/images``;
``python docs/map.py RUN/knowledge.json ...`` takes in the rows of runs of the suite first, each in place of an older one.
"""

from __future__ import annotations

import json
import re
import sys
from dataclasses import asdict
from pathlib import Path

from cprm_gym.benchmark.knowledge import HEAD, RIVAL, Row, plot_groups

DOCS = Path(__file__).parent
RESULTS, PAGE = DOCS / "results" / "knowledge.json", DOCS / "knowledge.md"
BLOCK = re.compile(r"(<!-- (rows|senses): ([\w, ]+) -->\n)(?:(?!<!-- ).)*(<!-- end -->)", re.DOTALL)
"""A table that is made: all rows of some tasks, or one task's senses with a column for each tier."""


def read(path: Path = RESULTS) -> list[Row]:
    """The rows of a results file, of here or of a run."""
    return [Row(**row) for row in json.loads(path.read_text(encoding="utf-8"))["rows"]]


def merged(old: list[Row], new: list[Row]) -> list[Row]:
    """Old rows and new ones, which take the places of those of the same task, senses and tier."""
    rows = {(row.task, row.senses, row.tier): row for row in old}
    rows.update({(row.task, row.senses, row.tier): row for row in new})
    return list(rows.values())


def write(rows: list[Row], path: Path = RESULTS) -> None:
    """One line for each row."""
    lines = ",\n".join(json.dumps(asdict(row)) for row in rows)
    path.write_text(f'{{"suite": "knowledge", "rows": [\n{lines}\n]}}\n', encoding="utf-8")


def as_rows(rows: list[Row]) -> str:
    """The suite's own table."""
    return table(HEAD, [row.cells() for row in rows])


def as_senses(rows: list[Row]) -> str:
    """Senses in rows; the rival's rate with its Wilson interval, and of each other tier its rate and the paired difference."""
    tiers = [tier for tier in dict.fromkeys(row.tier for row in rows) if tier != RIVAL]
    lines = []
    for senses in dict.fromkeys(row.senses for row in rows):
        found = {row.tier: row for row in rows if row.senses == senses}
        cells = [senses, str(found[RIVAL].episodes), found[RIVAL].cells()[5]]
        for tier in tiers:
            cells.append(f"{100 * found[tier].rate:.1f}, {found[tier].cells()[6]}" if tier in found else "")
        lines.append(cells)
    return table(["senses", "n", f"{RIVAL} %, Wilson 95 %", *(f"{tier} %, less {RIVAL}, paired 95 %" for tier in tiers)], lines)


def table(head: tuple[str, ...] | list[str], lines: list[list[str]]) -> str:
    """In Markdown."""
    return "\n".join(["| " + " | ".join(head) + " |", "|" + "---|" * len(head), *("| " + " | ".join(line) + " |" for line in lines)])


def with_tables(text: str, rows: list[Row]) -> str:
    """The page with its tables made anew."""

    def made(match: re.Match[str]) -> str:
        tasks = match[3].split(", ")
        chosen = [row for task in tasks for row in rows if row.task == task]
        return f"{match[1]}\n{(as_rows if match[2] == 'rows' else as_senses)(chosen)}\n\n{match[4]}"

    return BLOCK.sub(made, text)


def draw(rows: list[Row], folder: Path = DOCS / "images") -> list[Path]:
    """The pictures; what they show is in the tables."""
    goalie = [row for row in rows if row.task == "Goalie"]
    stated = [row for row in rows if row.task != "Goalie"]
    made = []
    for name, chosen in (("knowledge_senses.png", goalie), ("knowledge_stated.png", stated)):
        (folder / name).write_bytes(plot_groups(chosen))
        made.append(folder / name)
    return made


def main(runs: list[str]) -> None:
    """Take in runs, write results, page and pictures."""
    rows = read() if RESULTS.exists() else []
    for run in runs:
        try:
            rows = merged(rows, read(Path(run)))
        except (OSError, ValueError, KeyError, TypeError) as error:
            sys.exit(f"{run}: not the results of a run of the suite 'knowledge': {error}")
    write(rows)
    PAGE.write_text(with_tables(PAGE.read_text(encoding="utf-8"), rows), encoding="utf-8")
    draw(rows)


if __name__ == "__main__":
    main(sys.argv[1:])
