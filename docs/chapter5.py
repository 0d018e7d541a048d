"""The results of the suite ``chapter5`` as a page: what is made of ``docs/results/chapter5.json`` in ``docs/results.md``.

``python docs/chapter5.py`` writes the made parts of the page anew; ``python docs/chapter5.py RUN ...`` first puts the runs of these folders
together (of each cell the one with the most episodes) and writes the file and the pictures anew.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

from cprm_gym.benchmark.chapter5.pieces import Curves, Dots
from cprm_gym.benchmark.chapter5.report import svg
from cprm_gym.benchmark.chapter5.report.merged import merged
from cprm_gym.benchmark.chapter5.report.whole import Chapter5Report
from cprm_gym.errors import CprmError

DOCS = Path(__file__).parent
RESULTS, PAGE, IMAGES = DOCS / "results" / "chapter5.json", DOCS / "results.md", DOCS / "images"
BLOCK = re.compile(
    r"(<!-- (claims|guide|played|found|picture|notes|rows|decided)(?:: (\w+))? -->\n)(?:(?!<!-- ).)*(<!-- end -->)", re.DOTALL
)
PICTURES = {
    "table": (12, "Success by task and controller"),
    "senses": (8, "Success by tier of knowledge over noise, lost looks and delay"),
    "disturbances": (21, "Success under disturbances"),
    "slow": (4, "Success and cycles to the first answer over latency and period"),
    "explosion": (4, "States, rules and times over the number of concurrent skills"),
    "memory": (2, "The hike: success and decision time"),
    "transfer": (4, "Success where ball, players, starts or opponents differ"),
}
"""Experiment -> how many of its panels stand on the page, at most, and what they show."""
COMMAND = "cprm-gym benchmark --suite chapter5 --only {}"


def data_of(report: Chapter5Report) -> dict[str, Any]:
    """What is kept of a report: claims, advice, tables, decided comparisons, cells."""
    data = report.to_data()
    for one in data["experiments"]:
        one["compared"] = len(one.pop("comparisons"))
    return data


def write(data: dict[str, Any], path: Path = RESULTS) -> None:
    """One line for each cell, row of a table and entry."""
    parts = []
    for key, value in data.items():
        if key in ("cells", "experiments"):
            parts.append(f'"{key}": [\n' + ",\n".join(json.dumps(entry, ensure_ascii=False) for entry in value) + "\n]")
        else:
            parts.append(f'"{key}": {json.dumps(value, ensure_ascii=False)}')
    path.write_text("{\n" + ",\n".join(parts) + "\n}\n", encoding="utf-8")


def read(path: Path = RESULTS) -> dict[str, Any]:
    """The file."""
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return data


def table(head: list[str], rows: list[list[str]]) -> str:
    """In Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(cell.replace("|", "/").replace("<", "&lt;") for cell in row) + " |" for row in rows])


def claims(data: dict[str, Any], _: str) -> str:
    """Each claim, verdict, figure and command."""
    rows = [
        [entry["claim"] + (f" (§{entry['section']})" if entry["section"] != "-" else ""), entry["verdict"], entry["figure"] or "-",
         f"`{COMMAND.format(entry['experiment'])}`"]
        for entry in data["claims"].values()
    ]  # fmt: skip
    return table(["claim", "verdict", "figure", "command"], rows)


def guide(data: dict[str, Any], _: str) -> str:
    """When to take what, and why."""
    return table(["when", "take", "why"], data["guide"])


def played(data: dict[str, Any], _: str) -> str:
    """How many episodes each experiment has in a cell, how many comparisons it makes, and how many are decided."""
    rows = []
    for one in data["experiments"]:
        counts = sorted({int(row[t["head"].index("n")]) for t in one["tables"] if "n" in t["head"] for row in t["rows"]})
        shown = "-" if not counts else str(counts[0]) if len(counts) == 1 else f"{counts[0]} to {counts[-1]}"
        compared = [str(one["compared"]), str(len(one["better"]))] if one["compared"] else ["-", "-"]
        rows.append([one["title"], shown, *compared])
    return table(["experiment", "episodes in a cell", "comparisons", "decided"], rows)


def found(data: dict[str, Any], name: str) -> str:
    """What an experiment says of its claims."""
    return "\n\n".join(f["figure"] for one in data["experiments"] if one["name"] == name for f in one["findings"]) or "Not yet measured."


def picture(data: dict[str, Any], name: str) -> str:
    """The small multiples of an experiment that was measured."""
    return f"![{PICTURES[name][1]}](images/chapter5_{name}.svg)" if any(one["name"] == name for one in data["experiments"]) else ""


def notes(data: dict[str, Any], name: str) -> str:
    """What has to be known of an experiment."""
    return "\n\n".join(note for one in data["experiments"] if one["name"] == name for note in one["notes"])


def rows(data: dict[str, Any], name: str) -> str:
    """The tables of an experiment; of what was said of a method only whether anything was."""
    found = [t for one in data["experiments"] if one["name"] == name for t in one["tables"] if t["rows"]]
    short = [[[re.sub(r"^(yes|no): .*", r"\1", cell, flags=re.DOTALL) for cell in row] for row in t["rows"]] for t in found]
    return "\n\n".join(table(t["head"], cells) for t, cells in zip(found, short))


def decided(data: dict[str, Any], name: str) -> str:
    """Who is better than whom."""
    better = [text for one in data["experiments"] if one["name"] == name for text in one["better"]]
    return ("Decided:\n\n" + "\n".join(f"* {text}" for text in better)).replace(" > ", " &gt; ") if better else ""


MADE = {
    "claims": claims,
    "guide": guide,
    "played": played,
    "found": found,
    "picture": picture,
    "notes": notes,
    "rows": rows,
    "decided": decided,
}


def with_parts(text: str, data: dict[str, Any]) -> str:
    """The page with its made parts made anew."""
    return BLOCK.sub(lambda m: f"{m[1]}\n{MADE[m[2]](data, m[3] or '')}\n\n{m[4]}", text)


def draw(report: Chapter5Report, folder: Path = IMAGES) -> list[Path]:
    """A picture of small multiples for each of `PICTURES` that was measured."""
    made = []
    for one in report.told:
        panels: list[Curves | Dots] = list(one.panels)[: PICTURES.get(one.name, (0,))[0]]
        if panels:
            path = folder / f"chapter5_{one.name}.svg"
            path.write_text(svg.sheet(panels), encoding="utf-8")
            made.append(path)
    return made


def main(runs: list[str]) -> None:
    """Take in runs, write results, page and pictures."""
    if runs:
        try:
            report = merged([Path(run) for run in runs])
        except (CprmError, OSError) as error:
            sys.exit(str(error))
        write(data_of(report))
        draw(report)
    PAGE.write_text(with_parts(PAGE.read_text(encoding="utf-8"), read()), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
