"""The ``cprm-gym`` command."""

from __future__ import annotations

from typing import Annotated

import typer

from .. import __version__
from ..joining.command import join
from ..learning.command import train
from ..server.command import serve
from ..studio.command import studio
from ..viewing.command import convert, stats, watch
from .analyzing import analyze
from .compiling import compile_kernels
from .measuring import benchmark
from .rating import ladder
from .saying import PlainGroup, console
from .showing import conformance, demo, play
from .tuning import tune

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


@app.callback()
def main(
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")] = False,
) -> None:
    """Options of every command."""


for command in (serve, join, watch, convert, stats, studio, train, benchmark, ladder, tune, analyze, conformance, demo, play):
    app.command()(command)
app.command("compile")(compile_kernels)
