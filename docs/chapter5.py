"""The results of the suite ``chapter5`` as a page: what is made of ``docs/results/chapter5.json`` in ``docs/results.md``.

``python docs/chapter5.py`` writes the made parts of the page anew. ``python docs/chapter5.py RUN ... [--again RUN ...]`` first puts the
runs of these folders together (of each cell the one with the most episodes, of equal ones that of the run given last), beside them those of
another seed, and writes the file, the pictures and ``docs/results/chapter5.html`` anew. All episodes of these runs are kept, packed, in
``docs/results/runs`` and ``docs/results/runs/again``, whose folders can be given as runs later, beside others.
"""

from __future__ import annotations

import itertools
import json
import re
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from cprm_gym.benchmark.chapter5.claims import CLAIMS, tally
from cprm_gym.benchmark.chapter5.films import FILMS, UNFILMED, films_of
from cprm_gym.benchmark.chapter5.pieces import Curves, Dots, listed
from cprm_gym.benchmark.chapter5.players import NET
from cprm_gym.benchmark.chapter5.report import svg
from cprm_gym.benchmark.chapter5.report.beside import beside
from cprm_gym.benchmark.chapter5.report.merged import merged
from cprm_gym.benchmark.chapter5.report.who import READING, WHO
from cprm_gym.benchmark.chapter5.report.whole import Chapter5Report
from cprm_gym.benchmark.journal import PACKED, Journal
from cprm_gym.errors import CprmError

DOCS = Path(__file__).parent
RESULTS, PAGE, IMAGES = DOCS / "results" / "chapter5.json", DOCS / "results.md", DOCS / "images"
HTML, RUNS = DOCS / "results" / "chapter5.html", DOCS / "results" / "runs"
KINDS = "whole|claims|guide|who|brief|again|played|found|picture|notes|rows|decided|reading|films|made"
BLOCK = re.compile(rf"(<!-- ({KINDS})(?:: (\w+))? -->\n)(?:(?!<!-- ).)*(<!-- end -->)", re.DOTALL)
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
AGAIN = "--again"


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


def whole(data: dict[str, Any], _: str) -> str:
    """How much was played, and whether that is all of it."""
    counts, size = [cell["n"] for cell in data["cells"]], data["plan"]["size"]
    text = f"{sum(counts):,} episodes in {len(counts)} cells (task, condition, controller)."
    if data["complete"]:
        return text
    text = f"**Not the whole suite, so far:** {text} They have {min(counts):,} to {max(counts):,} episodes each, where the whole suite has "
    text += f"{size['table']:,} in the table and {size['curve']:,} in curves; what was not played is named below. "
    return text + "Few episodes decide little."


def claims(data: dict[str, Any], _: str) -> str:
    """Each claim, verdict and figure."""
    again: dict[str, Any] | None = data.get("again")
    rows = []
    for key, entry in data["claims"].items():
        hangs = again is not None and key in again["hangs"]
        said = f" **With seed {again['seed']}: {again['verdicts'][key]}.**" if hangs else ""
        section = f" (§{entry['section']})" if entry["section"] != "-" else ""
        seen = ", ".join(_linked(name) for name in films_of(key)) or "-"
        figure = (entry["figure"] or "-") + said
        rows.append([entry["claim"] + section, f"**{entry['verdict']}**", figure, f"`{entry['experiment']}`", seen])
    verdicts = {key: entry["verdict"] for key, entry in data["claims"].items()}
    return f"{tally(verdicts)}\n\n" + table(["claim", "verdict", "figure", "`--only`", "films"], rows)


def _linked(name: str) -> str:
    pair = FILMS[name]
    links = [f"[{who}](images/{file})" for (who, *_), file in zip((pair.one, pair.other), pair.files(name))]
    return " ".join(dict.fromkeys(links))


def films(data: dict[str, Any], _: str) -> str:
    """What is to be seen in each film, and which claims have none."""
    rows = [
        [pair.shows, f"`{pair.task}`" + ("" if pair.condition == "default" else f", {pair.condition}"),
         *(f"[`{player}`: {how}](images/{file})" for (_, player, how), file in zip((pair.one, pair.other), pair.files(name)))]
        for name, pair in FILMS.items()
    ]  # fmt: skip
    without = "\n".join(f"* {CLAIMS[key].says} No film: {why}." for key, why in UNFILMED.items())
    return table(["what to see", "task", "the one", "the other"], rows) + "\n\n" + without


def guide(data: dict[str, Any], _: str) -> str:
    """When to take what, and why."""
    return table(["when", "take", "why"], [[when, f"**{what}**", why] for when, what, why in data["guide"]])


def who(data: dict[str, Any], _: str) -> str:
    """Who plays, and what it is."""
    return table(["name", "what it is"], [[f"`{name}`", text] for name, text in WHO.items()])


def brief(data: dict[str, Any], name: str) -> str:
    """The tables of an experiment that are to be read first."""
    return "\n\n".join(table(t["head"], t["rows"]) for t in _tables(data, name) if t.get("brief"))


def again(data: dict[str, Any], _: str) -> str:
    """What another seed says."""
    told = data.get("again")
    if told is None:
        return "It was not played with another seed."
    parts = [f"{told['said']} {told['episodes']}"]
    parts += [f"* {data['claims'][key]['claim']} {told['verdicts'][key]}: {figure}" for key, figure in told["figures"].items()]
    first = f"seed {data['plan']['seed']}"
    won = [text.split(":")[0] for text, who in told["once"] if who == first and text.startswith(f"cprm > {NET} in ")]
    ordinary = [text.split(" in ")[1] for text in won if "," not in text]
    if ordinary:
        parts[0] += f" At ordinary senses the belief is ahead of dead reckoning by {first} alone in {listed(ordinary)}."
    items = [f"each another way: {text}" for text in told["against"]] + [f"{who} alone: {text}" for text, who in told["once"]]
    return "\n".join(parts[:1] + [""] * bool(parts[1:]) + parts[1:]) + (
        "\n\n" + _folded("Decided by one seed alone", items) if items else ""
    )


def reading(data: dict[str, Any], _: str) -> str:
    """How what was measured is to be read."""
    return READING.replace(" > ", " &gt; ")


def made(data: dict[str, Any], _: str) -> str:
    """With what, and of which runs the cells are."""
    counts: dict[int, int] = {}
    for cell in data["cells"]:
        counts[cell.get("run", 0)] = counts.get(cell.get("run", 0), 0) + 1
    entries = [
        [str(k), f"`{run['command']}`", run["version"] or "not noted", str(counts.get(k, 0))] for k, run in enumerate(data.get("runs", []))
    ]
    machine = ", ".join(f"{key} {value}" for key, value in data["machine"].items())
    return f"Seed {data['plan']['seed']}. {machine}.\n\n" + table(["run", "command", "begun with version", "cells"], entries)


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
    findings = [f for one in data["experiments"] if one["name"] == name for f in one["findings"]]
    return "\n\n".join(f"{f['figure']} {f.get('more', '')}".strip() for f in findings) or "Not yet measured."


def picture(data: dict[str, Any], name: str) -> str:
    """The small multiples of an experiment that was measured."""
    return f"![{PICTURES[name][1]}](images/chapter5_{name}.svg)" if any(one["name"] == name for one in data["experiments"]) else ""


def notes(data: dict[str, Any], name: str) -> str:
    """What has to be known of an experiment."""
    return "\n\n".join(note for one in data["experiments"] if one["name"] == name for note in one["notes"])


def _tables(data: dict[str, Any], name: str) -> list[dict[str, Any]]:
    return [t for one in data["experiments"] if one["name"] == name for t in one["tables"] if t["rows"]]


def rows(data: dict[str, Any], name: str) -> str:
    """The other tables of an experiment, folded up."""
    kept = [t for t in _tables(data, name) if not t.get("brief")]
    return "\n\n".join(f"<details><summary>{t['title']}</summary>\n\n{table(t['head'], t['rows'])}\n\n</details>" for t in kept)


def _folded(title: str, items: list[str]) -> str:
    listed = "\n".join(f"* {item}" for item in items).replace(" > ", " &gt; ")
    return f"<details><summary>{title}</summary>\n\n{listed}\n\n</details>"


def decided(data: dict[str, Any], name: str) -> str:
    """Who is better than whom, folded up."""
    for one in data["experiments"]:
        if one["name"] == name and one["better"]:
            return _folded(f"{len(one['better'])} of {one['compared']} comparisons are decided", one["better"])
    return ""


MADE = {
    "whole": whole, "claims": claims, "guide": guide, "who": who, "brief": brief, "again": again, "played": played, "found": found,
    "picture": picture, "notes": notes, "rows": rows, "decided": decided, "reading": reading, "films": films, "made": made,
}  # fmt: skip


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


def keep(runs: list[Path], under: Path) -> None:
    """Plan, command and packed journal of each run, in folders ``0``, ``1`` ...; of those of before only given ones stay."""
    stay = {folder.resolve() for folder in runs}
    for folder in under.glob("[0-9]*"):
        if folder.resolve() not in stay:
            shutil.rmtree(folder)
    for run in runs:
        if run.resolve().parent == under.resolve():
            continue
        folder = next(under / str(k) for k in itertools.count() if not (under / str(k)).exists())
        folder.mkdir(parents=True)
        for name in ("plan.json", "command.txt"):
            if (run / name).exists():
                shutil.copyfile(run / name, folder / name)
        Journal(run / "episodes.jsonl").pack(folder / f"episodes.jsonl{PACKED}")


def main(given: list[str]) -> None:
    """Take in runs, write results, page and pictures."""
    if AGAIN in given and (given[0] == AGAIN or given[-1] == AGAIN or given.count(AGAIN) > 1):
        sys.exit(f"{AGAIN} stands once, between the runs of one seed and those of another")
    at = given.index(AGAIN) if AGAIN in given else len(given)
    runs, others = ([Path(folder) for folder in part] for part in (given[:at], given[at + 1 :]))
    if runs:
        try:
            report = merged(runs)
            if others:
                report = replace(report, again=beside(report, merged(others)))
        except (CprmError, OSError) as error:
            sys.exit(str(error))
        write(data_of(report))
        draw(report)
        HTML.write_text(report.to_html(), encoding="utf-8")
        keep(runs, RUNS)
        keep(others, RUNS / "again")
    PAGE.write_text(with_parts(PAGE.read_text(encoding="utf-8"), read()), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
