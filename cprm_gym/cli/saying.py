"""What commands say, and how: the console, mistakes in one line, folders of results."""

from __future__ import annotations

import datetime
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from typer.core import TyperGroup

from ..errors import CprmError

T_B = "Of the controller cprm: cycles from one inference of its model to the next."
LATENCY = "Of the controller cprm: cycles until an inference's result comes."
WORKERS = "Processes, each of which takes 2.5 s of CPU time to start."

console = Console()
complaints = Console(stderr=True)


@contextmanager
def said_plainly() -> Iterator[None]:
    """Turns an error of ours, or of a file, into one line on the error stream and exit status 2."""
    try:
        yield
    except BrokenPipeError:  # who reads the output has seen enough
        raise
    except OSError as error:
        what = f"{error.filename}: {error.strerror}" if error.filename and error.strerror else str(error)
        complain(what)
        raise typer.Exit(2) from None
    except CprmError as error:
        complain(str(error))
        raise typer.Exit(2) from None


def said(message: str) -> None:
    """A line on the error stream."""
    complaints.print(message, highlight=False, soft_wrap=True)


def complain(message: str) -> None:
    """A line on the error stream about what went wrong."""
    complaints.print(f"[red]error:[/red] {escape(message)}", highlight=False, soft_wrap=True)


def wrote(paths: Iterable[Path]) -> None:
    """Say which files were written."""
    for path in paths:
        console.print(f"wrote {path}", highlight=False, soft_wrap=True)


def go_on(command: str) -> NoReturn:
    """End what was interrupted, and say how it goes on."""
    complaints.print(f"interrupted; go on with: {escape(command)}", highlight=False, soft_wrap=True)
    raise typer.Exit(130)


def progress() -> Progress:
    """A bar on the error stream, where somebody looks."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    return Progress(*columns, console=complaints, transient=True, disable=not complaints.is_terminal)


class PlainGroup(TyperGroup):
    """Commands whose mistakes are said plainly, also those that importing what a command needs brings up."""

    def invoke(self, ctx: Any) -> Any:
        with said_plainly():
            return super().invoke(ctx)


def split_names(text: str) -> tuple[str, ...]:
    """Names that commas separate."""
    return tuple(name.strip() for name in text.split(",") if name.strip())


def duration(seconds: float) -> str:
    """``50 s``, ``12 min``, ``3.5 h``."""
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


def new_folder(output: Path) -> Path:
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
