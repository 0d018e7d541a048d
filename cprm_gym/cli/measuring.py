"""``cprm-gym benchmark``."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import CprmError, unknown_name
from .saying import (
    LATENCY,
    T_B,
    WORKERS,
    complain,
    complaints,
    console,
    duration,
    go_on,
    new_folder,
    progress,
    said,
    split_names,
    wrote,
)  # fmt: skip

if TYPE_CHECKING:
    from ..benchmark.journal import Planned
    from ..benchmark.plan import BlockResult, Plan


def benchmark(
    tasks: Annotated[str | None, typer.Option(help="Tasks, separated by commas.", show_default="GoToBall")] = None,
    controllers: Annotated[str | None, typer.Option(help="Controllers, separated by commas.", show_default="cprm,fsm,random")] = None,
    episodes: Annotated[int | None, typer.Option(help="Episodes per task and controller.", show_default="500")] = None,
    seed: Annotated[
        int | None, typer.Option(help="Decides every random number; all controllers meet the same worlds.", show_default="0")
    ] = None,
    workers: Annotated[int | None, typer.Option(help=WORKERS, show_default="as many as pay")] = None,
    ray: Annotated[str | None, typer.Option(help="Play on a Ray cluster at this address instead (local: one started here).")] = None,
    timeout: Annotated[
        float | None, typer.Option(help="Seconds that one decision of a controller may take; more is its error.", show_default="60")
    ] = None,
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
    played = {"tasks": tasks, "controllers": controllers, "backend": backend, "senses": senses, "tiers": tiers, "t-b": t_b,
              "latency": latency}  # fmt: skip
    if suite == "chapter5":
        _refuse(played | {"ray": ray}, "does not go with --suite chapter5; --only chooses experiments")
        _chapter5(quick, tuple(only or ()), episodes, seed, output, resume, workers, 60.0 if timeout is None else timeout)
        return
    _refuse({"only": only or None}, "goes with --suite chapter5")
    if suite is not None or quick or senses is not None or tiers is not None:
        _refuse({"backend": backend}, "does not go with --suite, which plays in process")
        _refuse({key: played[key] for key in ("controllers", "t-b", "latency")}, "does not go with --suite, where each task has its player")
        _refuse({"timeout": timeout}, "does not go with --suite, whose players are ours; it goes with --suite chapter5")
        chosen = {"tasks": tasks, "senses": senses, "tiers": tiers}
        named: dict[str, Any] = {name: split_names(text) for name, text in chosen.items() if text is not None}
        _suite(suite, quick, named | _given({"episodes": episodes, "seed": seed}), output, resume, workers, ray)
        return
    given: dict[str, Any] = {"tasks": tasks and split_names(tasks), "controllers": controllers and split_names(controllers)}
    given |= {"episodes": episodes, "seed": seed, "backend": backend}
    _controllers(_given(given), {"t_b": t_b, "latency": latency}, workers, ray, 60.0 if timeout is None else timeout, output, resume)


def _given(options: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}


def _refuse(options: dict[str, Any], why: str) -> None:
    """Refuse the first of these options that is given.

    Raises
    ------
    CprmError
        Naming it, and why it cannot be there.
    """
    for name in _given(options):
        raise CprmError(f"--{name} {why}")


def _controllers(
    given: dict[str, Any], timing: dict[str, int | None], workers: int | None, ray: str | None, timeout: float, output: Path,
    resume: Path | None,
) -> None:  # fmt: skip
    """Play tasks and controllers that are named, or their defaults."""
    from ..benchmark.plan import Plan
    from ..benchmark.report import summarise
    from ..benchmark.runner import again_with
    from ..client.remote import check_trainer
    from ..envs.others.registry import with_options
    from ..workers import check_workers

    if _given(timing):
        given["controllers"] = with_options(given.get("controllers", Plan.controllers), **timing)
    check_workers(workers)
    if "backend" in given:
        _refuse({"ray": ray}, "does not go with --backend, a server that plays one episode at a time")
        workers = 1 if workers is None else workers
        if workers != 1:
            raise CprmError(f"--workers {workers}: a server plays one episode at a time; leave it out with --backend")
    if not timeout > 0:
        raise CprmError(f"--timeout {timeout:g}: a number of seconds above 0 is needed")
    plan, folder = _resumed(resume, given) if resume is not None else (Plan(**given), None)
    if plan.backend:
        check_trainer(plan.backend)
    if folder is None:
        folder = new_folder(output)
        plan.write(folder)
    results, interrupted = _played(plan, folder, workers=workers, timeout=timeout, ray=ray)
    report = summarise(plan, results)
    written = report.write(folder)
    console.print(report.to_table())
    for message in report.errors:
        complain(message)
    wrote(written)
    if not any(p.suffix == ".png" for p in written):
        console.print("no plot: matplotlib is not installed (pip install 'cprm-gym\\[render]')")
    if interrupted:
        go_on(f"cprm-gym benchmark --resume {shlex.quote(str(folder))}{again_with(workers, ray)}")
    if report.errors:
        raise typer.Exit(1)


def _played(plan: Planned, folder: Path, **how: Any) -> tuple[list[BlockResult], bool]:
    """What a run has by its end, shown on the way, and whether it was interrupted; options as for `runner.run`."""
    from ..benchmark.runner import run

    results: list[BlockResult] = []
    with progress() as bar:
        line = bar.add_task("starting", total=len(plan.blocks()))
        try:
            for result in run(plan, journal=folder / "episodes.jsonl", told=said, **how):
                results.append(result)
                bar.update(line, advance=1, description=f"{result.block.task} {result.block.controller}")
        except KeyboardInterrupt:
            return results, True
    return results, False


def _chapter5(
    quick: bool, only: tuple[str, ...], episodes: int | None, seed: int | None, output: Path, resume: Path | None, workers: int | None,
    timeout: float,
) -> None:  # fmt: skip
    """Run the suite ``chapter5``."""
    from rich.table import Table

    from ..benchmark.chapter5.claims import CLAIMS
    from ..benchmark.chapter5.command import Asked, benchmark

    asked = Asked(quick, only, episodes, seed)
    ended = benchmark(asked, resume, lambda: new_folder(output), workers, timeout, complaints, duration)
    table = Table("claim", "verdict", "figure", box=None, padding=(0, 1))
    for key, (verdict, figure) in ended.report.verdicts().items():
        table.add_row(CLAIMS[key].says, verdict, figure)
    console.print(table)
    for who, error in ended.report.errors:
        complain(f"{who}: {error}")
    wrote(ended.written)
    if ended.interrupted:
        go_on(ended.again)
    if ended.report.errors:
        raise typer.Exit(1)


def _suite(
    suite: str | None, quick: bool, given: dict[str, Any], output: Path, resume: Path | None, workers: int | None, ray: str | None
) -> None:
    """Run the suite ``knowledge`` or ``demonstrations``."""
    from dataclasses import replace

    from rich.table import Table

    from ..benchmark import demonstrations, knowledge
    from ..benchmark.demonstrations import report as demonstrated
    from ..benchmark.runner import again_with
    from ..workers import check_workers

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
    check_workers(workers)
    if resume is not None:
        if quick or given:
            raise CprmError("--resume takes up a run as it was planned: leave --quick and what is to be played out")
        plan, folder = planned.read(resume), resume
    else:
        plan = replace(planned.quick() if quick else planned(), **given)
        folder = new_folder(output)
        plan.write(folder)
        episodes = sum(block.count for block in plan.blocks())
        complaints.print(f"{episodes:,} episodes, about {duration(plan.seconds)} of CPU time", highlight=False)
    results, interrupted = _played(plan, folder, workers=workers, play=play, ray=ray)
    report = summarise(plan, results)
    table = Table(*head, box=None, padding=(0, 1))
    for row in report.rows:
        table.add_row(*row.cells())
    console.print(table)
    wrote(report.write(folder))
    if interrupted:
        go_on(f"cprm-gym benchmark --suite {suite} --resume {shlex.quote(str(folder))}{again_with(workers, ray)}")


def _resumed(folder: Path, given: dict[str, Any]) -> tuple[Plan, Path]:
    """The plan of an interrupted run, with which every given option has to agree."""
    from ..benchmark.plan import Plan

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
