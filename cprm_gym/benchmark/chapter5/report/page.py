"""One self-contained page of HTML."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

from ..claims import CLAIMS
from ..pieces import HOLDS, IN_PART, UNDECIDED, UNKNOWN, Dots, Table, Told, sentence
from . import svg
from .guide import Advice

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #1b1b1b; background: #fff; max-width: 1240px; margin: 0 auto; padding: 20px; }
h1 { font-size: 26px; margin: 0 0 4px; } h2 { font-size: 20px; margin: 40px 0 2px; border-top: 2px solid #ddd; padding-top: 14px; }
h3 { font-size: 15px; margin: 18px 0 4px; } p { max-width: 90ch; margin: 6px 0; } .question { color: #444; font-style: italic; }
table { border-collapse: collapse; font-size: 13px; margin: 8px 0; }
th, td { text-align: left; padding: 3px 10px 3px 0; vertical-align: top; }
th { border-bottom: 1px solid #999; } td { border-bottom: 1px solid #eee; font-variant-numeric: tabular-nums; }
.guide td:first-child, .claims td:first-child { font-weight: 600; width: 24%; }
.guide td:nth-child(2) { width: 26%; color: #0b5a8a; font-weight: 600; }
.panels { display: flex; flex-wrap: wrap; gap: 14px 24px; margin: 10px 0; } svg { font: 12px system-ui, sans-serif; overflow: visible; }
svg .title { font-weight: 600; font-size: 13px; } svg .tick { fill: #555; font-size: 11px; } svg .grid { stroke: #e4e4e4; }
svg .name { font-size: 12px; } svg .value { font-size: 11px; fill: #333; }
.verdict { font-weight: 700; white-space: nowrap; } .holds { color: #00694c; } .part { color: #8a6100; }
.fails { color: #a33a00; } .unknown { color: #666; }
details { margin: 8px 0; } summary { cursor: pointer; color: #0b5a8a; } .wide { overflow-x: auto; }
nav a { margin-right: 14px; } code { font-size: 13px; }
.small { font-size: 13px; color: #444; } .error { color: #a30000; }
"""
KINDS = {HOLDS: "holds", IN_PART: "part", UNDECIDED: "unknown", UNKNOWN: "unknown"}


def page(told: Sequence[Told], advice: Sequence[Advice], about: dict[str, Any]) -> str:
    """The page.

    Parameters
    ----------
    told : sequence of Told
    advice : sequence of (str, str, str)
        When, what to take, why.
    about : dict
        ``command``, ``seed``, ``episodes``, ``complete``, ``machine``, ``errors``, ``seconds``.
    """
    links = "".join(f'<a href="#{t.name}">{k}. {escape(t.title)}</a>' for k, t in enumerate(told, 1))
    parts = [
        f"<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport "
        f"content='width=device-width'><title>Chapter 5, measured</title>"
        f"<style>{STYLE}</style><h1>Chapter 5, measured</h1>",
        "<p>Structures of agents in a soccer world: a Petri net with a model (<b>cprm</b>; <b>net</b> is its net alone), state machines "
        "(<b>fsm</b>), <b>subsumption</b>, behaviour trees, concurrent <b>code</b> and <b>belief_region</b>, a map "
        "from beliefs to commands. All "
        "hand-written ones share skills and formulas; all meet the same worlds. “A &gt; B” stands only where the "
        "interval of the paired difference, "
        "corrected for the number of comparisons of its experiment (Holm), excludes zero.</p>",
        f"<p class=small>{escape(about['episodes'])} Seed {about['seed']}.</p>",
    ]
    if not about["complete"]:
        parts.append("<p class=error>Interrupted, or somebody failed: not everything that was planned was played.</p>")
    for who, error in about["errors"]:
        parts.append(f"<p class=error>{escape(who)}: {escape(error)}</p>")
    if advice:
        rows = "".join(f"<tr><td>{escape(when)}<td>{escape(what)}<td>{escape(why)}" for when, what, why in advice)
        parts.append(f"<h2>Which to take when</h2><table class=guide><tr><th>when<th>take<th>why{rows}</table>")
    parts.append(_claims(told))
    parts.append(f"<nav class=small>{links}</nav>")
    for number, one in enumerate(told, 1):
        parts.append(_experiment(number, one))
    made = ", ".join(f"{escape(k)} {escape(v)}" for k, v in about["machine"].items())
    parts.append(f"<h2>How this was made</h2><p class=small><code>{escape(about['command'])}</code></p><p class=small>{made}. "
                 f"{about['seconds']:.0f} s of playing, all processes together. report.json beside this page has every "
                 f"number, marl_eval.json the same in "
                 "the form that marl-eval reads.</p></html>")  # fmt: skip
    return "\n".join(parts) + "\n"


def _claims(told: Sequence[Told]) -> str:
    said = {f.claim: f for one in told for f in one.findings}
    rows = []
    for key, claim in CLAIMS.items():
        finding = said.get(key)
        verdict, figure = (UNKNOWN, "") if finding is None else (finding.verdict, finding.figure)
        kind = KINDS.get(verdict, "fails")
        where = f"§{claim.section}" if claim.section != "-" else ""
        rows.append(f'<tr><td>{escape(claim.says)} <span class=small>{where}</span><td class="verdict {kind}">{escape(verdict)}'
                    f'<td>{escape(figure)} <a class=small href="#{claim.experiment}">more</a>')  # fmt: skip
    head = "<h2>What the dissertation says, and what was found</h2><table class=claims><tr><th>claim<th>verdict<th>figure"
    return f"{head}{''.join(rows)}</table>"


def _experiment(number: int, one: Told) -> str:
    parts = [f'<h2 id="{one.name}">{number}. {escape(one.title)}</h2><p class=question>{escape(one.question)}</p>']
    parts += [f"<p>{escape(f.figure)}</p>" for f in one.findings]
    drawn = "".join(svg.dots(p) if isinstance(p, Dots) else svg.curves(p) for p in one.panels)
    if drawn:
        parts.append(f"<div class=panels>{drawn}</div>")
    if one.comparisons:
        items = "".join(f"<li>{escape(sentence(c))}" for c in one.better)
        count = f"{len(one.better)} of {len(one.comparisons)} comparisons are decided"
        parts.append(
            f"<details><summary>{count}</summary><ul class=small>{items}</ul></details>" if items else f"<p class=small>{count}.</p>"
        )
    for table in one.tables:
        if table.rows:
            parts.append(
                f"<details{'' if drawn else ' open'}><summary>{escape(table.title)}</summary><div "
                f"class=wide>{_table(table)}</div></details>"
            )
    parts += [f"<p class=small>{escape(note)}</p>" for note in one.notes]
    return "\n".join(parts)


def _table(table: Table) -> str:
    head = "".join(f"<th>{escape(cell)}" for cell in table.head)
    rows = "".join("<tr>" + "".join(f"<td>{escape(cell)}" for cell in row) for row in table.rows)
    return f"<table><tr>{head}{rows}</table>"
