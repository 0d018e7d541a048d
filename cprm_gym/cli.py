"""The ``cprm-gym`` command."""

from __future__ import annotations

import datetime
import shlex
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from typer.core import TyperGroup

from . import __version__
from .errors import CprmError, unknown_name
from .files import check_place
from .joining.command import join
from .learning.command import train
from .server.command import serve
from .studio.command import studio
from .viewing.command import convert, stats, watch

if TYPE_CHECKING:
    from .architecture.analysis.budget import Budget
    from .architecture.petri import PetriNet
    from .benchmark.plan import Plan

T_B = "Of the controller cprm: cycles from one inference of its model to the next."
LATENCY = "Of the controller cprm: cycles until an inference's result comes."

console = Console()
complaints = Console(stderr=True)
_WORKERS = "Processes, each of which takes 2.5 s of CPU time to start."


@contextmanager
def said_plainly() -> Iterator[None]:
    """Turns an error of ours, or of a file, into one line on the error stream and exit status 2."""
    try:
        yield
    except BrokenPipeError:  # who reads the output has seen enough
        raise
    except OSError as error:
        what = f"{error.filename}: {error.strerror}" if error.filename and error.strerror else str(error)
        _complain(what)
        raise typer.Exit(2) from None
    except CprmError as error:
        _complain(str(error))
        raise typer.Exit(2) from None


def _said(message: str) -> None:
    complaints.print(message, highlight=False, soft_wrap=True)


def _complain(message: str) -> None:
    complaints.print(f"[red]error:[/red] {escape(message)}", highlight=False, soft_wrap=True)


class PlainGroup(TyperGroup):
    """Commands whose mistakes are said plainly, also those that importing what a command needs brings up."""

    def invoke(self, ctx: Any) -> Any:
        with said_plainly():
            return super().invoke(ctx)


app = typer.Typer(
    cls=PlainGroup,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Structured, concurrent, real-time action: 2D soccer environments, Petri nets that act, models that infer.",
)


def _version(wanted: bool) -> None:
    if wanted:
        console.print(f"cprm_gym {__version__}")
        raise typer.Exit


app.command()(serve)
app.command()(join)
app.command()(watch)
app.command()(convert)
app.command()(stats)
app.command()(studio)
app.command()(train)


@app.callback()
def main(
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")] = False,
) -> None:
    """Options of every command."""


@app.command("compile")
def compile_kernels(
    parts: Annotated[list[str] | None, typer.Argument(help="drills, matches, server, views or all.", show_default="all")] = None,
    jobs: Annotated[int, typer.Option(help="Processes at a time.")] = 2,
) -> None:
    """Compile kernels ahead, into ~/.cache/cprm_gym or the folder that CPRM_GYM_CACHE names: for images, clusters, read-only places."""
    from .compile_ahead import compile_ahead

    with said_plainly():
        root = compile_ahead(parts or ["all"], jobs, lambda line: console.print(line, highlight=False))
    files = [file for file in (root / "kernels").rglob("*.nb?") if file.suffix == ".nbc"]
    size = sum(file.stat().st_size for file in files) / 1e6
    console.print(f"{len(files)} kernels, {size:.0f} MB in {root / 'kernels'}", highlight=False, soft_wrap=True)


@app.command()
def benchmark(
    tasks: Annotated[str | None, typer.Option(help="Tasks, separated by commas.", show_default="GoToBall")] = None,
    controllers: Annotated[str | None, typer.Option(help="Controllers, separated by commas.", show_default="cprm,fsm,random")] = None,
    episodes: Annotated[int | None, typer.Option(help="Episodes per task and controller.", show_default="500")] = None,
    seed: Annotated[
        int | None, typer.Option(help="Decides every random number; all controllers meet the same worlds.", show_default="0")
    ] = None,
    workers: Annotated[int | None, typer.Option(help=_WORKERS, show_default="as many as pay")] = None,
    ray: Annotated[str | None, typer.Option(help="Play on a Ray cluster at this address instead (local: one started here).")] = None,
    timeout: Annotated[float, typer.Option(help="Seconds that one decision of a controller may take; more is its error.")] = 60.0,
    output: Annotated[Path, typer.Option(help="Folder of results; a folder of today's date is made in it.")] = Path("results"),
    resume: Annotated[Path | None, typer.Option(help="Take up the interrupted run in this folder, as it was planned.")] = None,
    suite: Annotated[
        str | None,
        typer.Option(
            help="A suite instead of tasks and controllers: chapter5 (nine experiments, one page), knowledge (task x senses x tier), "
            "or demonstrations (--tasks A,E)."
        ),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="The suite's short form.")] = False,
    only: Annotated[list[str] | None, typer.Option(help="Of the suite chapter5: an experiment; several times for more.")] = None,
    backend: Annotated[str | None, typer.Option(help="Play on a server, udp://host:port, instead of in process.")] = None,
    senses: Annotated[str | None, typer.Option(help="Of the suite: senses, separated by commas.", show_default="all")] = None,
    tiers: Annotated[str | None, typer.Option(help="Of the suite: tiers of knowledge, separated by commas.", show_default="all")] = None,
    t_b: Annotated[int | None, typer.Option(help=T_B, show_default="the model's slice")] = None,
    latency: Annotated[int | None, typer.Option(help=LATENCY, show_default="0")] = None,
) -> None:
    """Measure controllers on tasks: success, cycles, speed; a table, report.json, report.md and a plot."""
    if suite == "chapter5":
        with said_plainly():
            others: dict[str, Any] = {"tasks": tasks, "controllers": controllers, "backend": backend, "senses": senses, "tiers": tiers}
            others["ray"] = ray
            others |= {"t-b": t_b, "latency": latency}
            for name, value in others.items():
                if value is not None:
                    raise CprmError(f"--{name} does not go with --suite chapter5; --only chooses experiments")
            _chapter5(quick, tuple(only or ()), episodes, seed, output, resume, workers, timeout)
        return
    if only:
        with said_plainly():
            raise CprmError("--only goes with --suite chapter5")
    if suite is not None or quick or senses is not None or tiers is not None:
        with said_plainly():
            if backend is not None or ray is not None:
                raise CprmError(f"--{'backend' if ray is None else 'ray'} does not go with --suite, which plays in process")
            if controllers is not None or t_b is not None or latency is not None:
                raise CprmError("--controllers, --t-b and --latency do not go with --suite, where each task has its player")
            chosen = {"tasks": tasks, "senses": senses, "tiers": tiers}
            named: dict[str, Any] = {name: _names(text) for name, text in chosen.items() if text is not None}
            numbers = {name: value for name, value in (("episodes", episodes), ("seed", seed)) if value is not None}
            _suite(suite, quick, named | numbers, output, resume)
        return
    from .benchmark.plan import BlockResult, Plan
    from .benchmark.report import summarise
    from .benchmark.runner import again_with, run
    from .client.remote import check_trainer
    from .envs.others.registry import with_options
    from .workers import check_workers

    with said_plainly():
        given: dict[str, Any] = {"episodes": episodes, "seed": seed, "backend": backend}
        who = controllers and _names(controllers)
        if t_b is not None or latency is not None:
            who = with_options(who or Plan.controllers, t_b=t_b, latency=latency)
        given |= {"tasks": tasks and _names(tasks), "controllers": who}
        given = {name: value for name, value in given.items() if value is not None}
        check_workers(workers)
        if ray is not None and backend is not None:
            raise CprmError("--ray does not go with --backend, a server that plays one episode at a time")
        if backend is not None:
            workers = 1 if workers is None else workers
        if backend is not None and workers != 1:
            raise CprmError(f"--workers {workers}: a server plays one episode at a time; leave it out with --backend")
        if not timeout > 0:
            raise CprmError(f"--timeout {timeout:g}: a number of seconds above 0 is needed")
        plan, folder = _resumed(resume, given) if resume is not None else (Plan(**given), None)
        if plan.backend:
            check_trainer(plan.backend)
        if folder is None:
            folder = _new_folder(output)
            plan.write(folder)
        results: list[BlockResult] = []
        bar = Progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
                       console=complaints, transient=True, disable=not complaints.is_terminal)  # fmt: skip
        interrupted = False
        with bar:
            line = bar.add_task("starting", total=len(plan.blocks()))
            try:
                for result in run(plan, workers=workers, journal=folder / "episodes.jsonl", timeout=timeout, told=_said, ray=ray):
                    results.append(result)
                    bar.update(line, advance=1, description=f"{result.block.task} {result.block.controller}")
            except KeyboardInterrupt:
                interrupted = True
        report = summarise(plan, results)
        written = report.write(folder)
    console.print(report.to_table())
    for message in report.errors:
        _complain(message)
    for path in written:
        console.print(f"wrote {path}", highlight=False, soft_wrap=True)
    if not any(p.suffix == ".png" for p in written):
        console.print("no plot: matplotlib is not installed (pip install 'cprm-gym\\[render]')")
    if interrupted:
        go_on = f"cprm-gym benchmark --resume {shlex.quote(str(folder))}{again_with(workers, ray)}"
        complaints.print(f"interrupted; go on with: {escape(go_on)}", highlight=False, soft_wrap=True)
        raise typer.Exit(130)
    if report.errors:
        raise typer.Exit(1)


@app.command()
def ladder(
    family: Annotated[str | None, typer.Option(help="soccer, half_field, goalie or keepaway.", show_default="soccer")] = None,
    games: Annotated[int | None, typer.Option(help="Games of each pair on each side.", show_default="50")] = None,
    seed: Annotated[
        int | None, typer.Option(help="Decides every random number; all pairs meet in the same worlds.", show_default="0")
    ] = None,
    more: Annotated[list[str] | None, typer.Option("--player", help="A further player: a controller; several times for more.")] = None,
    rivals: Annotated[list[str] | None, typer.Option("--rival", help="A further player of the other side; several times for more.")] = None,
    training: Annotated[bool, typer.Option("--training", help="Leave out the opponents that are held out for testing.")] = False,
    workers: Annotated[int | None, typer.Option(help=_WORKERS, show_default="as many as pay")] = None,
    ray: Annotated[str | None, typer.Option(help="Play on a Ray cluster at this address instead (local: one started here).")] = None,
    output: Annotated[Path, typer.Option(help="Folder of results; a folder of today's date is made in it.")] = Path("results"),
    resume: Annotated[Path | None, typer.Option(help="Take up the interrupted round robin in this folder, as it was planned.")] = None,
) -> None:
    """Rate graded opponents in a round robin: Elo with 95 % intervals; a table, ladder.json and ladder.md."""
    from rich.table import Table

    from .benchmark.ladder.command import play_ladder

    given: dict[str, Any] = {"family": family, "games": games, "seed": seed}
    given |= {"more": tuple(more or ()) or None, "rivals": tuple(rivals or ()) or None, "held_out": False if training else None}
    with complaints.status("starting ...") as status:
        played = play_ladder(
            {name: value for name, value in given.items() if value is not None}, resume, lambda: _new_folder(output), workers,
            lambda done, total, who: status.update(f"{done} of {total} blocks: {escape(who)}"), _said, ray,
        )  # fmt: skip
    table = Table(box=None, padding=(0, 1))
    for head in ("side", "player", "Elo", "95 %", "score", "games", ""):
        table.add_column(head, no_wrap=True)
    for s in played.table:
        interval, held_out = f"{s.low:.0f} to {s.high:.0f}", "held out" if s.held_out else ""
        table.add_row(s.side, escape(s.player), f"{s.elo:.0f}", interval, f"{100 * s.score:.1f} %", str(s.games), held_out)
    console.print(table, width=max(100, console.width), soft_wrap=True)
    console.print(f"wrote {played.folder / 'ladder.md'}", highlight=False, soft_wrap=True)
    if played.again:
        complaints.print(f"interrupted; go on with: {escape(played.again)}", highlight=False, soft_wrap=True)
        raise typer.Exit(130)


def _chapter5(
    quick: bool, only: tuple[str, ...], episodes: int | None, seed: int | None, output: Path, resume: Path | None, workers: int | None,
    timeout: float,
) -> None:  # fmt: skip
    """Run the suite ``chapter5``."""
    from rich.table import Table

    from .benchmark.chapter5.claims import CLAIMS
    from .benchmark.chapter5.command import Asked, benchmark

    asked = Asked(quick, only, episodes, seed)
    ended = benchmark(asked, resume, lambda: _new_folder(output), workers, timeout, complaints, _duration)
    table = Table("claim", "verdict", "figure", box=None, padding=(0, 1))
    for key, (verdict, figure) in ended.report.verdicts().items():
        table.add_row(CLAIMS[key].says, verdict, figure)
    console.print(table)
    for who, error in ended.report.errors:
        _complain(f"{who}: {error}")
    for path in ended.written:
        console.print(f"wrote {path}", highlight=False, soft_wrap=True)
    if ended.interrupted:
        complaints.print(f"interrupted; go on with: {escape(ended.again)}", highlight=False, soft_wrap=True)
        raise typer.Exit(130)
    if ended.report.errors:
        raise typer.Exit(1)


def _suite(suite: str | None, quick: bool, given: dict[str, Any], output: Path, resume: Path | None) -> None:
    """Run the suite ``knowledge`` or ``demonstrations``."""
    from dataclasses import replace

    from rich.table import Table

    from .benchmark import demonstrations, knowledge
    from .benchmark.demonstrations import report as demonstrated

    if suite is None:
        raise CprmError("--quick, --senses and --tiers go with --suite")
    kinds: dict[str, Any] = {
        "knowledge": (knowledge.KnowledgePlan, knowledge.play_block, knowledge.summarise, knowledge.HEAD),
        "demonstrations": (demonstrations.DemonstrationPlan, demonstrations.play_block, demonstrations.summarise, demonstrated.HEAD),
    }
    if suite not in kinds:
        raise unknown_name("suite", suite, ["chapter5", *kinds])
    planned, play, summarise, head = kinds[suite]
    if suite == "demonstrations" and {"senses", "tiers"} & set(given):
        raise CprmError("--senses and --tiers are those of the suite knowledge; a demonstration has its own")
    if resume is not None:
        if quick or given:
            raise CprmError("--resume takes up a run as it was planned: leave --quick and what is to be played out")
        plan, folder = planned.read(resume), resume
    else:
        plan = replace(planned.quick() if quick else planned(), **given)
        folder = _new_folder(output)
        plan.write(folder)
        episodes = sum(block.count for block in plan.blocks())
        complaints.print(f"{episodes:,} episodes, about {_duration(plan.seconds)} of CPU time on one core", highlight=False)
    results, interrupted = [], False
    with complaints.status("starting ...") as status:
        try:
            for result in knowledge.run(
                plan, folder / "episodes.jsonl",
                lambda r, done, total: status.update(f"{done} of {total} blocks: {r.block.task}, {r.block.controller}"), play,
            ):  # fmt: skip
                results.append(result)
        except KeyboardInterrupt:
            interrupted = True
    report = summarise(plan, results)
    table = Table(*head, box=None, padding=(0, 1))
    for row in report.rows:
        table.add_row(*row.cells())
    console.print(table)
    for path in report.write(folder):
        console.print(f"wrote {path}", highlight=False, soft_wrap=True)
    if interrupted:
        again = f"cprm-gym benchmark --suite {suite} --resume {shlex.quote(str(folder))}"
        complaints.print(f"interrupted; go on with: {escape(again)}", highlight=False, soft_wrap=True)
        raise typer.Exit(130)


def _duration(seconds: float) -> str:
    """``50 s``, ``12 min``, ``3.5 h``."""
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


@app.command()
def tune(
    task: Annotated[str, typer.Option(help="Whose player is tuned.")] = "Goalie",
    tier: Annotated[str | None, typer.Option(help="The tier of knowledge that he is tuned for.", show_default="memory")] = None,
    tracker: Annotated[bool, typer.Option("--tracker", help="The tracker's own constants instead, by its error about the ball.")] = False,
    journal: Annotated[
        Path | None, typer.Option(help="File that holds the study, and from which it goes on.", show_default="TASK_TIER.jsonl")
    ] = None,
    senses: Annotated[
        str, typer.Option(help="Senses of the suite knowledge by which he perceives; those of --tracker are its own.")
    ] = "default",
    worlds: Annotated[int | None, typer.Option(help="Of a generation; each candidate plays all.", show_default="250, tracker 60")] = None,
    population: Annotated[int, typer.Option(help="Candidates of a generation.")] = 24,
    elite: Annotated[int, typer.Option(help="How many of them move the distribution, with --method cross-entropy.")] = 6,
    generations: Annotated[int, typer.Option(help="When it ends.")] = 8,
    seed: Annotated[int, typer.Option(help="Decides every random number.")] = 0,
    others: Annotated[
        str, typer.Option(help="Policies of the scripted players, LEFT,RIGHT.", show_default="those that he is measured against")
    ] = "",
    side: Annotated[str, typer.Option(help="Whose player: left, or right, who defends.")] = "left",
    method: Annotated[str, typer.Option(help="How it searches: cma-es (package cmaes), or cross-entropy.")] = "cma-es",
    check: Annotated[
        int | None, typer.Option(help="Then play so many other worlds with what was found and with what was set by hand, paired.")
    ] = None,
) -> None:
    """Tune the constants of a task's player for a tier of knowledge; the studies in use stand in cprm_gym/agents/studies."""
    import json

    from .benchmark.knowledge import SENSES
    from .benchmark.tracking import TrackingPlan
    from .benchmark.tuning import Plan, Search, study
    from .benchmark.tuning import check as checked

    with said_plainly():
        if tracker and tier is not None:
            raise CprmError(f"--tier {tier}: the tracker's own constants are the same for all; leave out --tier or --tracker")
        if senses not in SENSES:
            raise unknown_name("senses", senses, SENSES)
        if tracker and senses != "default":
            raise CprmError(f"--senses {senses}: the tracker's own constants are tuned for several senses; leave out --senses or --tracker")
        tier = "memory" if tier is None else tier
        if check is not None and check < 2:  # before the study, not after it
            raise CprmError(f"--check {check}: at least 2 worlds are needed")
        sizes = {"population": population, "elite": elite, "generations": generations, "seed": seed}
        sizes |= {} if worlds is None else {"worlds": worlds}
        for name, given in (("others", others), ("side", side if side != "left" else ""), ("check", str(check or ""))):
            if tracker and given:
                raise CprmError(f"--{name} {given}: the tracker's own constants are tuned for all; leave out --{name} or --tracker")
        plan: Search = (
            TrackingPlan(task, **sizes)
            if tracker
            else Plan(task, tier, senses=SENSES[senses], others=others, side=side, method=method, **sizes)  # type: ignore[arg-type]
        )
        whose = f"tracker_{task}" if tracker else "_".join((task, *([side] * (side != "left")), tier))
        place = Path(f"{whose}.jsonl") if journal is None else journal
        check_place(place, "--journal")
        found = None
        try:
            for found in study(plan, place):
                scores = f"middle {found.centre:.4f}, mean {found.rate:.4f}, best {found.best:.4f}"
                console.print(f"generation {found.number}: {scores}", highlight=False)
        except KeyboardInterrupt:
            complaints.print(f"interrupted; the same command goes on with {escape(str(place))}", highlight=False, soft_wrap=True)
            raise typer.Exit(130) from None
        if found is not None:
            typer.echo(json.dumps(found.mean, indent=1))
        if found is not None and check is not None and isinstance(plan, Plan):
            of = checked(plan, found.mean, check)
            said = f"found {of.found:.4f}, by hand {of.by_hand:.4f}: {of.difference:+.4f} ({of.low:+.4f}, {of.high:+.4f})"
            console.print(f"{check} other worlds: {said}", highlight=False)


def _resumed(folder: Path, given: dict[str, Any]) -> tuple[Plan, Path]:
    """The plan of an interrupted run, with which every given option has to agree."""
    from .benchmark.plan import Plan

    try:
        plan = Plan.read(folder)
    except CprmError as error:
        raise CprmError(f"--resume {error}") from None
    for name, value in given.items():
        planned = getattr(plan, name)
        if value != planned:
            shown, asked = (",".join(v) if isinstance(v, tuple) else v for v in (planned, value))
            raise CprmError(f"--{name} {asked}: the run in {folder} has {shown}; leave the option out, or begin anew without --resume")
    return plan, folder


@app.command()
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
        with said_plainly():
            if given := [name for name, value in alone.items() if value is not None]:
                raise CprmError(f"{', '.join(given)}: of the net alone, with --in they say nothing; analyze without --in for that")
            _in_world(
                net, world, method, formula or [], 2000 if episodes is None else episodes, seed or 0, require, output, as_json, seconds
            )
        return
    memory, rates = 4096 if memory is None else memory, rates or "refuse"
    from .agents.catalogue import shipped_net
    from .agents.play import BODY_COMMANDS
    from .architecture.analysis.budget import Budget
    from .architecture.analysis.report import analyze as analyze_net

    with said_plainly():
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
            for command in _names(exclusive or ""):
                if command not in (sent := _sent(found)):
                    raise unknown_name("--exclusive, command", command, sent)
            with complaints.status("exploring ...") as status:
                report = analyze_net(
                    found,
                    budget=budget,
                    progress=lambda states, expanded, passed: status.update(f"{states:,} states, {expanded:,} expanded, {passed:.0f} s"),
                    minimal=minimal,
                    exclusive=(tuple(BODY_COMMANDS) if exclusive is None else _names(exclusive),),
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

    from .architecture.analysis.budget import Budget
    from .architecture.analysis.product.learned_world import load_world
    from .benchmark.behaviours import report as reports
    from .benchmark.behaviours.analysis import METHODS, analyze_behaviour

    if not seconds > 0:
        raise CprmError(f"--seconds {seconds:g}: must be positive")
    if seed < 0:
        raise CprmError(f"--seed {seed}: must not be negative")
    if output is not None:
        _check_folder(output)
    learned = None if world == "simulator" else load_world(world)
    with complaints.status("starting ...") as status:
        report = analyze_behaviour(name, methods=METHODS if method is None else _names(method), properties=formulas, episodes=episodes,
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

    from .architecture.analysis import queries

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

    from .architecture.petri.files.load import load_net
    from .errors import FormatWarning

    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", FormatWarning)
        found = load_net(source, net=net, rates=rates, imports=True)
    for warning in told:
        complaints.print(f"[yellow]note:[/yellow] {escape(str(warning.message))}", highlight=False, soft_wrap=True)
    return found


def _is_name(text: str) -> bool:
    """Whether a net is meant by its name alone: no file, no path, no module."""
    return not (Path(text).exists() or Path(text).suffix.lower() in (".pnml", ".xml", ".json") or "/" in text or ":" in text)


@app.command()
def conformance(
    paths: Annotated[list[Path], typer.Argument(help="Recordings (.jsonl.gz), matches (.rcg.gz with its .rcl.gz), or folders of them.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of text.")] = False,
) -> None:
    """Replay recordings of a real server and compare; exit status 1 when anything differs."""
    from .simulator.conformance import run as replay

    with said_plainly(), complaints.status("replaying ...") as status:
        report = replay(paths, lambda result, done, total: status.update(f"{done} of {total} files replayed"))
    typer.echo(report.to_json() if as_json else report.text())
    if not report.ok:
        raise typer.Exit(1)


@app.command()
def demo(
    name: Annotated[str, typer.Argument(help="striker, goalie, passers or eleven.")],
    record: Annotated[Path | None, typer.Option(help="Write a film (.mp4 or .gif) instead of showing it here.")] = None,
    seed: Annotated[int, typer.Option(help="Which world.")] = 0,
    every: Annotated[int, typer.Option(help="Without a terminal: cycles between two pictures.")] = 25,
    t_b: Annotated[int | None, typer.Option(help=T_B, show_default="the model's slice")] = None,
    latency: Annotated[int | None, typer.Option(help=LATENCY, show_default="0")] = None,
    model: Annotated[str, typer.Option(help="bins: with the model on bins, whose inferences can be slow.")] = "",
) -> None:
    """Show a demonstration: the field, the markings of the nets, what the players believe."""
    import time

    from rich.columns import Columns
    from rich.console import Group
    from rich.live import Live
    from rich.panel import Panel
    from rich.text import Text

    from .agents.demos import Recorder, Scene, panel, play
    from .envs.rendering import text_picture

    def shown(scene: Scene) -> Group:
        panels = [Panel(Text("\n".join(panel(player)[1:])), title=panel(player)[0], width=46) for player in scene.players]
        width = max(40, min(106, console.width - 2))
        return Group(Text(text_picture(scene.world, width, width // 3)), Columns(panels), Text(f"cycle {scene.cycle}  {scene.status}"))

    with said_plainly():
        if every < 1:
            raise CprmError(f"--every {every}: allowed is 1 and more")
        last: Scene | None = None
        timing: dict[str, Any] = {name: value for name, value in (("t_b", t_b), ("latency", latency)) if value is not None}
        timing |= {"model": model} if model else {}
        if record is not None:
            check_place(record, "--record")
            film = Recorder(record)
            try:
                with complaints.status("recording ...") as line:
                    for last in play(name, seed, **timing):
                        film.add(last)
                        line.update(f"recording, cycle {last.cycle}")
            except BaseException:
                film.discard()
                raise
            film.close()
            console.print(f"wrote {record}", highlight=False, soft_wrap=True)
        elif console.is_terminal:
            with Live(console=console, auto_refresh=False) as live:
                for last in play(name, seed, **timing):
                    live.update(shown(last), refresh=True)
                    time.sleep(0.1)
        else:
            for last in play(name, seed, **timing):
                if last.cycle % every == 0:
                    console.print(shown(last))
    if last is not None:
        console.print(f"{name}, seed {seed}: {last.status.replace('_', ' ').lower()}", highlight=False)


@app.command()
def play(
    task: Annotated[str, typer.Option(help="What is played.")] = "Soccer11v11",
    controller: Annotated[str | None, typer.Option(help="Who plays the task's agents; scripted players if not given.")] = None,
    others: Annotated[str | None, typer.Option(help="Who plays the others, a scripted policy or a controller, or left,right.")] = None,
    seed: Annotated[int, typer.Option(help="Which world.")] = 0,
    cycles: Annotated[int | None, typer.Option(help="Stop after so many cycles.")] = None,
    record: Annotated[Path | None, typer.Option(help="Write a film (.mp4, .gif) or a game log (.rcg, .rcg.gz).")] = None,
    window: Annotated[bool, typer.Option("--window", help="Show it in a window.")] = False,
    t_b: Annotated[int | None, typer.Option(help=T_B, show_default="the model's slice")] = None,
    latency: Annotated[int | None, typer.Option(help=LATENCY, show_default="0")] = None,
) -> None:
    """Play an episode of a task: in the terminal, in a window, as a film or as a game log."""
    import time

    from rich.live import Live
    from rich.text import Text

    from .envs.others.registry import load_controller, with_options
    from .envs.play import Film
    from .envs.play import play as episode
    from .envs.rendering import Viewer, text_picture
    from .envs.tasks import Soccer, Status, make_task

    with said_plainly():
        made = make_task(task)
        names = with_options([] if controller is None else [controller], t_b=t_b, latency=latency)
        factory = load_controller(names[0]) if names else None
        sides = None if others is None else _names(others)
        chosen = sides[0] if sides is not None and len(sides) == 1 else sides
        course = episode(made, factory, chosen, seed, cycles)
        core, status = next(course)

        def to_the_end(show: Callable[[], object]) -> Status:
            word = status
            for _, now in course:
                word = now
                show()
            return word

        if record is not None:
            with Film(record, core) as film, complaints.status("recording ...") as line:
                film.add()

                def shoot() -> None:
                    film.add()
                    line.update(f"recording, cycle {int(core.cycle[0])} of at most {min(made.max_cycles, cycles or made.max_cycles)}")

                status = to_the_end(shoot)
            console.print(f"wrote {record}", highlight=False, soft_wrap=True)
        elif window:
            viewer = Viewer("human", region=made.region)
            status = to_the_end(lambda: viewer.draw(core.sim.world[0], tuple(core.players.tolist())[:3]))
            viewer.close()
        elif console.is_terminal:
            with Live(console=console, auto_refresh=False) as live:

                def show() -> None:
                    live.update(Text(text_picture(core.sim.world[0], min(106, console.width - 2), region=made.region)), refresh=True)
                    time.sleep(0.1)

                status = to_the_end(show)
        else:
            status = to_the_end(lambda: None)
            typer.echo(text_picture(core.sim.world[0]))
        left, right = (int(goals) for goals in core.sim.world["score"][0])
        # drills end at the goal line, before a referee counts
        score = f", goals {left} : {right}" if isinstance(made, Soccer) or left + right else ""
        console.print(f"{made.name}, seed {seed}: {status.name}, {int(core.cycle[0])} cycles{score}", highlight=False)


def _sent(net: PetriNet) -> list[str]:
    """The commands that transitions of a net and its modules send."""
    from .architecture.petri.execution.compiled_net import compile_net

    return sorted({t.emits.name for t in compile_net(net).net.transitions if t.emits})


def _names(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())


def _new_folder(output: Path) -> Path:
    """A new folder named by today's date, with a number if there is one already."""
    today = datetime.date.today().isoformat()
    number = 1
    while True:
        folder = output / (today if number == 1 else f"{today}-{number}")
        try:
            folder.mkdir(parents=True)
            return folder
        except FileExistsError:
            number += 1
        except OSError as error:
            raise CprmError(f"--output {output}: a folder cannot be made there: {error.strerror}") from None


if __name__ == "__main__":
    app()
