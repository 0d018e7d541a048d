"""``cprm-gym train``."""

from __future__ import annotations

import datetime
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from ..errors import CprmError
from ..workers import check_workers
from .configuration import ALGORITHMS

if TYPE_CHECKING:
    from .report import Report
    from .training import Plan

console = Console()
complaints = Console(stderr=True)


def train(
    algorithm: Annotated[str | None, typer.Argument(help=f"Of {', '.join(ALGORITHMS)}.")] = None,
    task: Annotated[str | None, typer.Option(help="What is learned.", show_default="GoToBall")] = None,
    seeds: Annotated[int | None, typer.Option(help="How many.", show_default="5")] = None,
    seed: Annotated[int | None, typer.Option(help="The first of them.", show_default="0")] = None,
    config: Annotated[Path | None, typer.Option(help="TOML file with a table of the algorithm.", show_default="the project's")] = None,
    steps: Annotated[int | None, typer.Option(help="Agent-steps of each seed.", show_default="the configuration's")] = None,
    output: Annotated[Path, typer.Option(help="Folder in which one for this training is made.")] = Path("trained"),
    resume: Annotated[Path | None, typer.Option(help="Go on in this folder, as it was planned.")] = None,
    workers: Annotated[int, typer.Option(help="Processes, each of which trains a seed; 1 trains one after the other.")] = 1,
    ray: Annotated[str | None, typer.Option(help="Train on a Ray cluster at this address instead (local: one started here).")] = None,
    export: Annotated[Path | None, typer.Option(help="Write the best policy of a finished training there, without an ending.")] = None,
    convert: Annotated[Path | None, typer.Option(help="A model saved by stable-baselines3 (.zip), to --export, with --like.")] = None,
    like: Annotated[Path | None, typer.Option(help="Of --convert: a policy with the same inputs and actions.")] = None,
) -> None:
    """Learn a policy: seeds, curves with intervals, TensorBoard, checkpoints; Ctrl-C loses nothing."""
    if convert is not None:
        _convert(convert, like, export, algorithm)
        return
    if like is not None:
        raise CprmError("--like goes with --convert")
    check_workers(workers)
    folder, plan = _planned(algorithm, task, seeds, seed, config, steps, output, resume)
    from .report import Report
    from .training import train as run

    complaints.print(f"{folder}: {plan.configuration.algorithm} on {plan.configuration.task}, {plan.seeds} seeds of "
                     f"{plan.configuration.steps:,} agent-steps; curves: tensorboard --logdir {folder / 'tensorboard'}",
                     highlight=False, soft_wrap=True)  # fmt: skip
    bar = Progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(),
                   console=complaints, transient=True, disable=not complaints.is_terminal)  # fmt: skip
    interrupted, metric = False, "seconds" if plan.configuration.metric == "duration" else "success"
    with bar:
        line = bar.add_task("starting", total=plan.seeds * plan.configuration.steps)

        together, ended = workers > 1 or ray is not None, 0

        def tell(at: int, done: int, worth: float | None) -> None:
            nonlocal ended
            before = (ended if together else at - plan.first) * plan.configuration.steps
            ended += together
            told = "" if worth is None else f", {metric} {worth:.2f}"
            bar.update(line, completed=before + min(done, plan.configuration.steps), description=f"seed {at}{told}")

        try:
            run(plan, folder, tell, workers, ray)
        except KeyboardInterrupt:
            interrupted = True
    report = Report.of(folder)
    written = report.write(folder)
    if report.ends:
        table = Table(*report.head, box=None, padding=(0, 1))
        for row in report.rows():
            table.add_row(*row)
        console.print(table)
    for path in written:
        console.print(f"wrote {path}", highlight=False, soft_wrap=True)
    if interrupted:
        how = f" --ray {shlex.quote(ray)}" if ray is not None else f" --workers {workers}" * (workers > 1)
        again = f"cprm-gym train --resume {shlex.quote(str(folder))}{how}"
        complaints.print(f"interrupted; go on with: {escape(again)}", highlight=False, soft_wrap=True)
        raise typer.Exit(130)
    if export is not None:
        _export(report, folder, export)


def _planned(
    algorithm: str | None, task: str | None, seeds: int | None, seed: int | None, config: Path | None, steps: int | None, output: Path,
    resume: Path | None,
) -> tuple[Path, Plan]:  # fmt: skip
    """The folder and the plan."""
    from .training import Plan, check_installed

    if resume is not None:
        given = {"ALGORITHM": algorithm, "--task": task, "--seeds": seeds, "--seed": seed, "--config": config, "--steps": steps}
        for name, value in given.items():
            if value is not None:
                raise CprmError(f"{name} does not go with --resume, which goes on as it was planned")
        if not resume.is_dir():
            raise CprmError(f"--resume {resume}: there is no such folder")
        return resume, Plan.read(resume)
    if algorithm is None:
        raise CprmError(f"an algorithm is needed: {', '.join(ALGORITHMS)}")
    plan = Plan.of(algorithm, task or "GoToBall", config, 5 if seeds is None else seeds, seed or 0, steps)
    check_installed()
    today, number = datetime.date.today().isoformat(), 1
    while True:
        folder = output / f"{plan.configuration.task}-{algorithm}-{today}{'' if number == 1 else f'-{number}'}"
        try:
            folder.mkdir(parents=True)
            break
        except FileExistsError:
            number += 1
        except OSError as error:
            raise CprmError(f"--output {output}: a folder cannot be made there: {error.strerror}") from None
    plan.write(folder)
    return folder, plan


def _export(report: Report, folder: Path, export: Path) -> None:
    """Write the policy of the best seed."""
    from .policy import load_policy, save_policy

    best = report.best()
    if best is None:
        raise CprmError(f"{folder}: no seed is done; there is nothing to export")
    if not export.parent.is_dir():
        raise CprmError(f"--export {export}: there is no folder {export.parent}")
    for path in save_policy(load_policy(folder / f"seed_{best}" / "best"), export):
        console.print(f"wrote {path}", highlight=False, soft_wrap=True)


def _convert(model: Path, like: Path | None, export: Path | None, algorithm: str | None) -> None:
    """A policy from a model of stable-baselines3."""
    from .export import convert

    if algorithm is not None:
        raise CprmError("an algorithm does not go with --convert, which takes it from --like")
    if like is None or export is None:
        raise CprmError("--convert needs --like, a policy with the same inputs and actions, and --export, where the new one goes")
    if not model.is_file():
        raise CprmError(f"--convert {model}: there is no such file")
    complaints.print(
        f"[yellow]warning:[/yellow] {escape(str(model))} holds pickled objects, which would be executed if they were loaded. Only its "
        "weights are read, in a process of its own; still, convert nothing from people whom you do not trust.",
        highlight=False, soft_wrap=True,
    )  # fmt: skip
    for path in convert(model, like, export):
        console.print(f"wrote {path}", highlight=False, soft_wrap=True)
