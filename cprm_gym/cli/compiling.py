"""``cprm-gym compile``."""

from __future__ import annotations

from typing import Annotated

import typer

from .saying import console


def compile_kernels(
    parts: Annotated[list[str] | None, typer.Argument(help="drills, matches, server, views or all.", show_default="all")] = None,
    jobs: Annotated[int, typer.Option(help="Processes at a time.")] = 2,
) -> None:
    """Compile kernels ahead, into ~/.cache/cprm_gym or the folder that CPRM_GYM_CACHE names: for images, clusters, read-only places."""
    from ..compile_ahead import compile_ahead

    root = compile_ahead(parts or ["all"], jobs, lambda line: console.print(line, highlight=False))
    files = [file for file in (root / "kernels").rglob("*.nb?") if file.suffix == ".nbc"]
    size = sum(file.stat().st_size for file in files) / 1e6
    console.print(f"{len(files)} kernels, {size:.0f} MB in {root / 'kernels'}", highlight=False, soft_wrap=True)
