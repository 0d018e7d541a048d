"""``cprm-gym analyze``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from rich.markup import escape

from ..errors import CprmError, unknown_name
from ..files import check_place
from .saying import complaints, console, split_names

if TYPE_CHECKING:
    from ..architecture.analysis.budget import Budget
    from ..architecture.petri import PetriNet


def analyze(
    net: Annotated[
        str,
        typer.Argument(help="A file (PNML or JSON), the name of a net that ships, or package.module:NAME, which runs that module's code."),
    ],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")] = False,
    memory: Annotated[
        float | None, typer.Option(help="MiB that it may take before it stops with a partial answer.", show_default="4096")
    ] = None,
    seconds: Annotated[float, typer.Option(help="Seconds that all of it may take, likewise.")] = float("inf"),
    minimal: Annotated[bool, typer.Option(help="Also find the minimal invariants without negative weights.")] = False,
    rates: Annotated[
        str | None,
        typer.Option(help="Exponential rates in PNML: 'refuse', or 'plain': read without them.", show_default="refuse"),
    ] = None,
    which: Annotated[str | None, typer.Option("--net", help="Id or name of the net, for files with several.")] = None,
    reach: Annotated[str | None, typer.Option(help="Only: is this ever true of the tokens? Such as 'left >= 2 and right < 1'.")] = None,
    deadlocks: Annotated[bool, typer.Option("--deadlocks", help="Only: every marking after which nothing fires.")] = False,
    cover: Annotated[str | None, typer.Option(help="Only: can so many tokens be reached or exceeded? 'left=2,right=1'.")] = None,
    graph: Annotated[Path | None, typer.Option(help="Only: write the reachability graph to this file (.json or .dot).")] = None,
    exclusive: Annotated[
        str | None, typer.Option(help="Commands of which one goes out per cycle, separated by commas.", show_default="those of the body")
    ] = None,
    world: Annotated[
        str | None,
        typer.Option("--in", help="What the behaviour does there: in the 'simulator', or in a world.json that an earlier run learned."),
    ] = None,
    method: Annotated[
        str | None,
        typer.Option(
            help="With --in: exact, bounded, sampled, simulator, rare, modules, certificate, contract; several by commas.",
            show_default="all",
        ),
    ] = None,
    formula: Annotated[
        list[str] | None, typer.Option("--property", help="With --in: a formula that sampled runs are held against.")
    ] = None,
    episodes: Annotated[int | None, typer.Option(help="With --in: episodes to learn from, and fresh ones.", show_default="2000")] = None,
    seed: Annotated[int | None, typer.Option(help="With --in: decides every random number.", show_default="0")] = None,
    require: Annotated[float | None, typer.Option(help="With --in: what the wanted outcome's probability has to be at least.")] = None,
    output: Annotated[Path | None, typer.Option(help="With --in: folder of the report (HTML, Markdown, JSON, plot).")] = None,
) -> None:
    """What a Petri net can do: states, deadlocks, bounds, liveness, invariants, siphons, the contract of a module.

    With --in WORLD: what a behaviour does there, how likely and when; exact, bounded and sampled side by side.

    Exit status 1 when a contract is broken, a module is used wrongly, or a requirement or condition is broken, 130 when interrupted.
    """
    alone = {"--memory": memory, "--minimal": minimal or None, "--rates": rates, "--net": which, "--reach": reach,
             "--deadlocks": deadlocks or None, "--cover": cover, "--graph": graph, "--exclusive": exclusive}  # fmt: skip
    if world is not None:
        if given := [name for name, value in alone.items() if value is not None]:
            raise CprmError(f"{', '.join(given)}: of the net alone, with --in they say nothing; analyze without --in for that")
        _in_world(net, world, method, formula or [], 2000 if episodes is None else episodes, seed or 0, require, output, as_json, seconds)
        return
    memory, rates = 4096 if memory is None else memory, rates or "refuse"
    from ..agents.catalogue import shipped_net
    from ..agents.play import BODY_COMMANDS
    from ..architecture.analysis.budget import Budget
    from ..architecture.analysis.report import analyze as analyze_net

    there = {"--method": method, "--property": formula or None, "--episodes": episodes, "--seed": seed, "--require": require,
             "--output": output}  # fmt: skip
    if given := [name for name, value in there.items() if value is not None]:
        raise CprmError(f"{', '.join(given)} go with --in")
    if not (memory > 0 and seconds > 0):
        raise CprmError(f"--memory {memory:g} and --seconds {seconds:g}: both must be positive")
    if rates not in ("refuse", "plain"):
        raise CprmError(f"--rates {rates!r}: allowed are 'refuse' and 'plain'")
    if which is not None and _is_name(net):
        raise CprmError(f"--net {which!r}: {net} ships as one net; --net names one of several in a file")
    budget = Budget(memory=int(memory * 2**20), seconds=seconds)
    try:
        found = shipped_net(net) if _is_name(net) else _net_in_file(net, which, "plain" if rates == "plain" else "refuse")
        if reach is not None or deadlocks or cover is not None or graph is not None:
            _answer(found, budget, as_json, reach, deadlocks, cover, graph)
            return
        for command in split_names(exclusive or ""):
            if command not in (sent := _sent(found)):
                raise unknown_name("--exclusive, command", command, sent)
        with complaints.status("exploring ...") as status:
            report = analyze_net(
                found,
                budget=budget,
                progress=lambda states, expanded, passed: status.update(f"{states:,} states, {expanded:,} expanded, {passed:.0f} s"),
                minimal=minimal,
                exclusive=(tuple(BODY_COMMANDS) if exclusive is None else split_names(exclusive),),
            )
    except KeyboardInterrupt:
        raise typer.Exit(130) from None
    if as_json:
        typer.echo(report.text())
    else:
        console.print(report.render())
    if report.interrupted or report.broken:
        raise typer.Exit(130 if report.interrupted else 1)


def _in_world(
    name: str, world: str, method: str | None, formulas: list[str], episodes: int, seed: int, require: float | None, output: Path | None,
    as_json: bool, seconds: float,
) -> None:  # fmt: skip
    """What a behaviour does in a world: a table, and a report where it is asked for."""
    import json

    from ..architecture.analysis.budget import Budget
    from ..architecture.analysis.product.learned_world import load_world
    from ..benchmark.behaviours import report as reports
    from ..benchmark.behaviours.analysis import METHODS, analyze_behaviour

    if not seconds > 0:
        raise CprmError(f"--seconds {seconds:g}: must be positive")
    if seed < 0:
        raise CprmError(f"--seed {seed}: must not be negative")
    if output is not None:
        _check_folder(output)
    learned = None if world == "simulator" else load_world(world)
    with complaints.status("starting ...") as status:
        report = analyze_behaviour(name, methods=METHODS if method is None else split_names(method), properties=formulas, episodes=episodes,
                                   seed=seed, require=require, budget=Budget(states=200_000, seconds=seconds), learned=learned,
                                   progress=status.update)  # fmt: skip
    if as_json:
        typer.echo(json.dumps(report.to_json(), indent=1))
    else:
        console.print(reports.to_table(report))
        for sentence in reports.sentences(report):
            console.print(sentence, highlight=False, markup=False)
    for path in reports.write(report, output) if output is not None else ():
        complaints.print(f"wrote {path}", highlight=False, soft_wrap=True)
    if report.interrupted or report.broken:
        raise typer.Exit(130 if report.interrupted else 1)


def _check_folder(folder: Path) -> None:
    """Whether a report can be written there, before anything is played for it."""
    import os

    place = folder
    while not place.exists() and place.parent != place:
        place = place.parent
    if not place.is_dir():
        raise CprmError(f"--output {folder}: {place} is a file, a folder is needed")
    if not os.access(place, os.W_OK):
        raise CprmError(f"--output {folder}: nothing can be written into {place}")


def _answer(
    net: PetriNet, budget: Budget, as_json: bool, reach: str | None, deadlocks: bool, cover: str | None, graph: Path | None
) -> None:
    """Answer single questions about a net, as tables of text or as one JSON object."""
    import json

    from ..architecture.analysis import queries

    budget, _ = budget.start()
    out: dict[str, Any] = {}
    if reach is not None:
        verdict = queries.can_become(net, reach, budget=budget)
        out["reach"] = verdict.to_json()
        typer.echo(f"{reach}: {verdict}", err=as_json)
        for step in verdict.run:
            typer.echo(f"  {step}", err=as_json)
    if deadlocks:
        found = queries.deadlocks(net, budget=budget)
        out["deadlocks"] = found.to_json()
        typer.echo(f"{len(found.markings)} deadlocks" + ("" if found.complete else f", perhaps more: {found.reason}"), err=as_json)
        for marking, run in zip(found.markings, found.runs):
            where = ", ".join(f"{name} {count}" for name, count in marking.items()) or "empty"
            typer.echo(f"  {where}  after {' -> '.join(s.what for s in run) or 'nothing'}", err=as_json)
    if cover is not None:
        tree = queries.coverability(net, budget=budget)
        able = tree.covers(queries.tokens(cover))
        out["cover"] = {"holds": able, "unbounded": list(tree.unbounded_places), "complete": tree.complete}
        word = {True: "yes", False: "no", None: "unknown"}[able]
        typer.echo(f"{cover} can be covered: {word}; unbounded: {', '.join(tree.unbounded_places) or 'nothing'}", err=as_json)
    if graph is not None:
        check_place(graph, "--graph")
        out["graph"] = {"file": str(graph), "nodes": queries.save_graph(net, graph, budget=budget)}
        typer.echo(f"wrote {graph}, {out['graph']['nodes']} nodes", err=as_json)
    if as_json:
        typer.echo(json.dumps(out, indent=1))
    _, clock = budget.start()
    if clock.interrupted:
        raise typer.Exit(130)


def _net_in_file(source: str, net: str | None, rates: Literal["refuse", "plain"]) -> PetriNet:
    """The net in a file, with what was ignored in it told on the error stream."""
    import warnings

    from ..architecture.petri.files.load import load_net
    from ..errors import FormatWarning

    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", FormatWarning)
        found = load_net(source, net=net, rates=rates, imports=True)
    for warning in told:
        complaints.print(f"[yellow]note:[/yellow] {escape(str(warning.message))}", highlight=False, soft_wrap=True)
    return found


def _is_name(text: str) -> bool:
    """Whether a net is meant by its name alone: no file, no path, no module."""
    return not (Path(text).exists() or Path(text).suffix.lower() in (".pnml", ".xml", ".json") or "/" in text or ":" in text)


def _sent(net: PetriNet) -> list[str]:
    """The commands that transitions of a net and its modules send."""
    from ..architecture.petri.execution.compiled_net import compile_net

    return sorted({t.emits.name for t in compile_net(net).net.transitions if t.emits})
