"""One self-contained page of HTML."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

from ..claims import CLAIMS, tally
from ..pieces import HOLDS, IN_PART, UNDECIDED, UNKNOWN, Dots, Table, Told, sentence
from . import svg
from .again import Again
from .guide import Advice
from .who import MARKS, READING, WHO

STYLE = """
:root { color-scheme: light dark; --text: #1b1b1b; --back: #fff; --quiet: #444; --line: #999; --thin: #eee; --link: #0b5a8a;
  --good: #00694c; --part: #8a6100; --bad: #a33a00; --none: #666; --error: #a30000; --drawn: none; }
@media (prefers-color-scheme: dark) { :root { --text: #e4e4e4; --back: #161616; --quiet: #b4b4b4; --line: #777; --thin: #333;
  --link: #7cc0ee; --good: #4fc59f; --part: #dcb04a; --bad: #f0935a; --none: #a0a0a0; --error: #ff8080;
  --drawn: invert(1) hue-rotate(180deg); } }
body { font: 15px/1.5 system-ui, sans-serif; color: var(--text); background: var(--back);
  max-width: 1240px; margin: 0 auto; padding: 20px; }
h1 { font-size: 26px; margin: 0 0 4px; }
h2 { font-size: 20px; margin: 32px 0 2px; border-top: 2px solid var(--thin); padding-top: 12px; }
h3 { font-size: 15px; margin: 18px 0 4px; } p { max-width: 90ch; margin: 6px 0; } .question { color: var(--quiet); font-style: italic; }
table { border-collapse: collapse; font-size: 13px; margin: 8px 0; } a { color: var(--link); }
th, td { text-align: left; padding: 3px 10px 3px 0; vertical-align: top; }
th { border-bottom: 1px solid var(--line); } td { border-bottom: 1px solid var(--thin); font-variant-numeric: tabular-nums; }
.guide td:first-child, .claims td:first-child { font-weight: 600; width: 26%; }
.who td:first-child { font-weight: 600; filter: var(--drawn); }
.guide td:nth-child(2) { width: 26%; color: var(--link); font-weight: 600; } .guide, .claims { width: 100%; }
.claims td:nth-child(2) { width: 9%; }
.panels { display: flex; flex-wrap: wrap; gap: 14px 24px; margin: 10px 0; } svg { font: 12px system-ui, sans-serif; overflow: visible; }
.panels svg { filter: var(--drawn); }
svg .title { font-weight: 600; font-size: 13px; } svg .tick { fill: #555; font-size: 11px; } svg .grid { stroke: #e4e4e4; }
svg .name { font-size: 12px; } svg .value { font-size: 11px; fill: #333; }
.verdict { font-weight: 700; white-space: nowrap; } .holds { color: var(--good); } .part { color: var(--part); }
.fails { color: var(--bad); } .unknown { color: var(--none); }
details { margin: 8px 0; } summary { cursor: pointer; color: var(--link); } .wide { overflow-x: auto; }
nav a { margin-right: 14px; } code { font-size: 13px; }
.small { font-size: 13px; color: var(--quiet); } .error { color: var(--error); }
"""
SHOWN = 9
"""Panels of an experiment that are not folded up."""
KINDS = {HOLDS: "holds", IN_PART: "part", UNDECIDED: "unknown", UNKNOWN: "unknown"}


def page(told: Sequence[Told], advice: Sequence[Advice], about: dict[str, Any], again: Again | None = None) -> str:
    """The page.

    Parameters
    ----------
    told : sequence of Told
    advice : sequence of (str, str, str)
        When, what to take, why.
    about : dict
        ``command``, ``seed``, ``episodes``, ``complete``, ``machine``, ``errors``, ``seconds``.
    again : Again, optional
        What another seed says.
    """
    links = "".join(f'<a href="#{t.name}">{k}. {escape(t.title)}</a>' for k, t in enumerate(told, 1))
    parts = [
        "<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content='width=device-width'>"
        f"<title>Chapter 5, measured</title><style>{STYLE}</style><h1>Chapter 5, measured</h1>",
        "<p>Which way of writing an agent is good for what? The same soccer tasks, played by agents of different structure.</p>",
        f"<p class=small>{escape(about['episodes'])} Seed {about['seed']}.</p>",
    ]
    if not about["complete"]:
        parts.append("<p class=error>Interrupted, or somebody failed: not everything that was planned was played.</p>")
    for who, error in about["errors"]:
        parts.append(f"<p class=error>{escape(who)}: {escape(error)}</p>")
    if advice:
        rows = "".join(f"<tr><td>{escape(when)}<td>{escape(what)}<td>{escape(why)}" for when, what, why in advice)
        parts.append(f"<h2>Which to take when</h2><table class=guide><tr><th>when<th>take<th>why{rows}</table>")
    played = {cell.split(":")[0] for one in told for table in one.tables for row in (table.head, *table.rows) for cell in row[:2]}
    played |= {name for one in told for table in one.tables for name in table.head}
    who = "".join(f'<tr><td style="color:{svg.colour(name)}">{name}<td>{escape(text)}' for name, text in WHO.items() if name in played)
    if who:
        parts.append(f"<h2>Who they are</h2><table class=who>{who}</table>")
    parts += [f"<h2>Every task</h2><p class=small>{escape(MARKS)}</p>{_brief(one)}" for one in told[:1] if one.name == "table"]
    parts.append(_claims(told, again))
    if again is not None:
        parts.append(_again(again))
    parts.append(f"<h2>The experiments</h2><nav class=small>{links}</nav><p class=small>{escape(READING)}</p>")
    for number, one in enumerate(told, 1):
        parts.append(_experiment(number, one))
    made = ", ".join(f"{escape(k)} {escape(v)}" for k, v in about["machine"].items())
    parts.append(f"<h2>How this was made</h2><p class=small><code>{escape(about['command'])}</code></p><p class=small>{made}. "
                 f"{about['seconds']:.0f} s of playing, all processes together. report.json beside this page has every "
                 f"number, marl_eval.json the same in the form that marl-eval reads.</p></html>")  # fmt: skip
    return "\n".join(parts) + "\n"


def _brief(one: Told) -> str:
    """The tables of an experiment that are to be read first."""
    return "".join(f"<h3>{escape(t.title)}</h3><div class=wide>{_table(t)}</div>" for t in one.tables if t.brief and t.rows)


def _claims(told: Sequence[Told], again: Again | None) -> str:
    said = {f.claim: f for one in told for f in one.findings}
    rows, verdicts = [], {}
    for key, claim in CLAIMS.items():
        finding = said.get(key)
        verdict, figure = (UNKNOWN, "") if finding is None else (finding.verdict, finding.figure)
        kind = KINDS.get(verdict, "fails")
        verdicts[key] = verdict
        where = f"§{claim.section}" if claim.section != "-" else ""
        hangs = f" <b>With seed {again.seed}: {escape(again.verdicts[key])}.</b>" if again and key in again.hangs else ""
        rows.append(f'<tr><td>{escape(claim.says)} <span class=small>{where}</span><td class="verdict {kind}">{escape(verdict)}'
                    f'<td>{escape(figure)}{hangs} <a class=small href="#{claim.experiment}">more</a>')  # fmt: skip
    head = f"<h2>What the dissertation says, and what was found</h2><p class=small>{tally(verdicts)}</p>"
    return f"{head}<table class=claims><tr><th>claim<th>verdict<th>figure{''.join(rows)}</table>"


def _again(again: Again) -> str:
    parts = [f"<h2>Another seed</h2><p>{escape(again.said)} {escape(again.episodes)}</p>"]
    items = [f"{CLAIMS[key].says} {again.verdicts[key]}: {figure}" for key, figure in again.figures.items()]
    items += [f"each another way: {text}" for text in again.against]
    items += [f"{who} alone: {text}" for text, who in again.once]
    if items:
        parts.append(
            f"<details><summary>What hangs on the seed</summary><ul class=small>{''.join(f'<li>{escape(i)}' for i in items)}</ul></details>"
        )
    return "".join(parts)


def _experiment(number: int, one: Told) -> str:
    parts = [f'<h2 id="{one.name}">{number}. {escape(one.title)}</h2><p class=question>{escape(one.question)}</p>']
    parts += [f"<p>{escape(' '.join(text for text in (f.figure, f.more) if text))}</p>" for f in one.findings]
    if one.name != "table":  # whose short table stands at the head of the page
        parts.append(_brief(one))
    drawn = [svg.dots(p) if isinstance(p, Dots) else svg.curves(p) for p in one.panels]
    if drawn:
        parts.append(f"<div class=panels>{''.join(drawn[:SHOWN])}</div>")
    if len(drawn) > SHOWN:
        more = "".join(drawn[SHOWN:])
        parts.append(f"<details><summary>{len(drawn) - SHOWN} more pictures</summary><div class=panels>{more}</div></details>")
    if one.comparisons:
        items = "".join(f"<li>{escape(sentence(c))}" for c in one.better)
        count = f"{len(one.better)} of {len(one.comparisons)} comparisons are decided"
        parts.append(
            f"<details><summary>{count}</summary><ul class=small>{items}</ul></details>" if items else f"<p class=small>{count}.</p>"
        )
    for table in one.tables:
        if table.rows and not table.brief:
            parts.append(f"<details><summary>{escape(table.title)}</summary><div class=wide>{_table(table)}</div></details>")
    parts += [f"<p class=small>{escape(note)}</p>" for note in one.notes]
    return "\n".join(parts)


def _table(table: Table) -> str:
    head = "".join(f"<th>{escape(cell)}" for cell in table.head)
    rows = "".join("<tr>" + "".join(f"<td>{_marked(cell)}" for cell in row) for row in table.rows)
    return f"<table><tr>{head}{rows}</table>"


def _marked(cell: str) -> str:
    """What is decidedly better or worse in its colour."""
    for mark, kind in (("▲", "holds"), ("▼", "fails")):
        if cell.endswith(mark):
            return f'<span class="{kind}">{escape(cell)}</span>'
    return escape(cell)
