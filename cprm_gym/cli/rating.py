"""``cprm-gym ladder``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.markup import escape

from .saying import WORKERS, complaints, console, go_on, new_folder, said, wrote


def ladder(
    family: Annotated[str | None, typer.Option(help="soccer, half_field, goalie or keepaway.", show_default="soccer")] = None,
    games: Annotated[int | None, typer.Option(help="Games of each pair on each side.", show_default="50")] = None,
    seed: Annotated[
        int | None, typer.Option(help="Decides every random number; all pairs meet in the same worlds.", show_default="0")
    ] = None,
    more: Annotated[list[str] | None, typer.Option("--player", help="A further player: a controller; several times for more.")] = None,
    rivals: Annotated[list[str] | None, typer.Option("--rival", help="A further player of the other side; several times for more.")] = None,
    training: Annotated[bool, typer.Option("--training", help="Leave out the opponents that are held out for testing.")] = False,
    workers: Annotated[int | None, typer.Option(help=WORKERS, show_default="as many as pay")] = None,
    ray: Annotated[str | None, typer.Option(help="Play on a Ray cluster at this address instead (local: one started here).")] = None,
    output: Annotated[Path, typer.Option(help="Folder of results; a folder of today's date is made in it.")] = Path("results"),
    resume: Annotated[Path | None, typer.Option(help="Take up the interrupted round robin in this folder, as it was planned.")] = None,
) -> None:
    """Rate graded opponents in a round robin: Elo with 95 % intervals; a table, ladder.json and ladder.md."""
    from rich.table import Table

    from ..benchmark.ladder.command import play_ladder

    given: dict[str, Any] = {"family": family, "games": games, "seed": seed}
    given |= {"more": tuple(more or ()) or None, "rivals": tuple(rivals or ()) or None, "held_out": False if training else None}
    with complaints.status("starting ...") as status:
        played = play_ladder(
            {name: value for name, value in given.items() if value is not None}, resume, lambda: new_folder(output), workers,
            lambda done, total, who: status.update(f"{done} of {total} blocks: {escape(who)}"), said, ray,
        )  # fmt: skip
    table = Table(box=None, padding=(0, 1))
    for head in ("side", "player", "Elo", "95 %", "score", "games", ""):
        table.add_column(head, no_wrap=True)
    for s in played.table:
        interval, held_out = f"{s.low:.0f} to {s.high:.0f}", "held out" if s.held_out else ""
        table.add_row(s.side, escape(s.player), f"{s.elo:.0f}", interval, f"{100 * s.score:.1f} %", str(s.games), held_out)
    console.print(table, width=max(100, console.width), soft_wrap=True)
    wrote([played.folder / "ladder.md"])
    if played.again:
        go_on(played.again)
