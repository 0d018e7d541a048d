"""The report on a behaviour: Markdown, HTML, JSON, plots."""

from __future__ import annotations

import html
import json
from pathlib import Path
from typing import Any

from rich.table import Table

from .films import net_film, pitch_film
from .findings import BehaviourReport

COLUMNS = ("outcome", "exact", "bounded", "every row", "unknown state", "sampled", "simulator")


def rows(report: BehaviourReport) -> list[tuple[str, ...]]:
    """One row for each outcome, in the order of `COLUMNS`."""
    data = report.to_json()["outcomes"]
    found = []
    for outcome, row in data.items():
        cells = [outcome]
        cells.append(f"{row['exact']['value']:.4f} +- {row['exact']['error']:.0e}" if "exact" in row else "")
        cells += [_interval(row.get(key)) for key in ("bounded", "every_row", "unknown_state", "sampled")]
        cells.append(f"{_interval(row['simulator']['interval'])} ({row['simulator']['count']})" if "simulator" in row else "")
        found.append(tuple(cells))
    return found


def _interval(pair: Any) -> str:
    return "" if pair is None else f"[{pair[0]:.4f}, {pair[1]:.4f}]"


def to_table(report: BehaviourReport) -> Table:
    """For a terminal."""
    table = Table(title=f"{report.name} in the simulator, {report.episodes} episodes", title_justify="left")
    for column in COLUMNS:
        table.add_column(column)
    for row in rows(report):
        table.add_row(*row)
    return table


def sentences(report: BehaviourReport) -> list[str]:
    """What stands below the table."""
    data = report.to_json()
    said = []
    if data["states"]:
        said.append(f"Net and world have {data['states']:,} states.")
    if data["expected_cycles"] is not None:
        said.append(f"Expected cycles {data['expected_cycles']:.2f}" + (
            f"; in the simulator {data['simulator_cycles']:.2f} of the runs that ended." if data["simulator_cycles"] else "."))  # fmt: skip
    if report.difference():
        said.append(report.difference()[0].upper() + report.difference()[1:] + ".")
    if report.require is not None:
        word = {True: "holds", False: "is broken", None: "is undecided"}[report.verdict]
        played = f"In the simulator this {word}." if report.simulator else "Episodes of the simulator decide that; they were not played."
        said.append(f"Required: {report.done} with at least {report.require:g}. {played}")
    if any("every_row" in row for row in data["outcomes"].values()):
        said.append(
            "'unseen' is what was never seen to follow; a run that comes there may end in anything, so that it belongs to the most that "
            "every other outcome can be."
        )
    for key, whose in (("properties", "sampled"), ("simulator_properties", "simulator's")):
        for name, p in data[key].items():
            least = "" if p["least_robustness"] is None else f", robustness at least {p['least_robustness']:.4g}"
            said.append(f"Property {name}: {_interval(p['interval'])} of the {whose} runs{least}.")
    for method, found in report.said.items():
        said.append(f"{method}{'' if found.applies else ' does not apply'}: {found.says}.")
    said += [f"Condition {j}." for j in report.judged]
    if report.failing:
        said.append("Failing: " + "; ".join(report.failing) + ".")
    return said + [f"Note: {note}." for note in report.notes]


def to_markdown(report: BehaviourReport) -> str:
    """As a page."""
    lines = [f"# {report.name} in the simulator", ""]
    lines += [
        f"{report.episodes} episodes taught the world (seed {report.seed}), as many fresh ones were played; intervals hold at once with "
        f"{report.confidence:.0%}.",
        "",
    ]
    lines += ["| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS)]
    lines += ["| " + " | ".join(row) + " |" for row in rows(report)]
    lines += ["", *(f"{s}\n" for s in sentences(report))]
    if report.worst:
        told = report.witness(report.worst)
        if told:
            lines += [f"## The likeliest run to {report.worst}", "", "```text", *told, "```", ""]
    for method, found in report.said.items():
        if found.lines:
            lines += [f"## {method}", "", "```text", *found.lines, "```", ""]
    if report.causes():
        lines += [f"## What sets runs to {report.worst} apart", "", *(f"* {cause}" for cause in report.causes()), ""]
    return "\n".join(lines)


def to_html(report: BehaviourReport, plot: str = "") -> str:
    """As a page of its own; names are escaped."""
    cell = html.escape
    table = "".join("<tr>" + "".join(f"<td>{cell(c)}</td>" for c in row) + "</tr>" for row in rows(report))
    head = "".join(f"<th>{cell(c)}</th>" for c in COLUMNS)
    told = report.witness(report.worst) if report.worst else []
    run = f"<h2>The likeliest run to {cell(report.worst)}</h2><pre>{cell(chr(10).join(told))}</pre>" if told else ""
    causes = "".join(f"<li>{cell(cause)}</li>" for cause in report.causes())
    run += f"<h2>What sets runs to {cell(report.worst)} apart</h2><ul>{causes}</ul>" if causes else ""
    for method, found in report.said.items():
        if found.lines:
            run += f"<h2>{cell(method)}</h2><pre>{cell(chr(10).join(found.lines))}</pre>"
    why, shown = report.shown(), report.film()
    if why is not None and shown is not None:
        run += f"<h2>{cell(why[0])}</h2><p>{pitch_film(shown)}</p><p>{net_film(shown)}</p>"
    picture = f'<img src="{cell(plot)}" alt="outcomes over time">' if plot else ""
    said = "".join(f"<p>{cell(s)}</p>" for s in sentences(report))
    return (
        f"<!doctype html><html lang='en'><meta charset='utf-8'><title>{cell(report.name)}</title>"
        "<style>body{font-family:sans-serif;max-width:70em;margin:2em auto}td,th{border:1px solid #ccc;padding:.3em .6em;text-align:left}"
        f"table{{border-collapse:collapse}}</style><h1>{cell(report.name)} in the simulator</h1><table><tr>{head}</tr>{table}</table>"
        f"{said}{picture}{run}</html>\n"
    )


def plot(report: BehaviourReport, path: Path) -> bool:
    """Outcomes over time within their bounds, the simulator's beside them; False without matplotlib or anything to draw."""
    if report.over_time is None and report.regular is None and not report.ended.size:
        return False
    try:
        from matplotlib.figure import Figure
    except ImportError:
        return False
    figure = Figure(figsize=(7, 4))
    axes = figure.add_subplot()
    colours = {o: f"C{k}" for k, o in enumerate(report.outcomes)}
    over = report.over_time
    for outcome in over.outcomes if over is not None else ():
        assert over is not None
        curve = over.by(outcome)
        if curve[-1] > 1e-4:
            axes.plot(curve, colours.get(outcome, "grey"), label=f"{outcome} (learned cells)")
    for outcome, (low, high) in (report.regular.over_time if report.regular is not None else {}).items():
        if low[-1] > 0.0 or outcome == report.done:
            axes.fill_between(range(len(low)), low, high, color=colours[outcome], alpha=0.2, label=f"{outcome} (bounds)")
    if report.ended.size:
        ends = report.ended[report.ended >= 0]
        last = max([int(report.ended.max(initial=0)), 0 if report.over_time is None else len(report.over_time.remaining) - 1])
        shares = [float((ends <= t).sum()) / len(report.ended) for t in range(last + 1)]
        axes.plot(shares, "k:", label="ended (simulator)")
    axes.set(xlabel="cycles", ylabel="probability", ylim=(0, 1.02), title=report.name)
    axes.legend()
    figure.savefig(path, dpi=120)
    return True


def write(report: BehaviourReport, folder: Path) -> list[Path]:
    """Write report.md, report.html, report.json, the learned world and a plot into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    drawn = plot(report, folder / "outcomes.png")
    (folder / "report.md").write_text(to_markdown(report), encoding="utf-8")
    (folder / "report.html").write_text(to_html(report, "outcomes.png" if drawn else ""), encoding="utf-8")
    (folder / "report.json").write_text(json.dumps(report.to_json(), indent=1), encoding="utf-8")
    written = [folder / name for name in ("report.md", "report.html", "report.json")]
    if report.world is not None:
        report.world.save(folder / "world.json")
        written.append(folder / "world.json")
    return [*written, folder / "outcomes.png"] if drawn else written
