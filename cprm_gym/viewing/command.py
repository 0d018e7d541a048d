"""``cprm-gym watch``, ``convert`` and ``stats``."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import CprmError

if TYPE_CHECKING:
    from ..simulator.gamelog.frames import Frame, GameLogHeader

SERVER = "udp://"


def place_of(text: str) -> tuple[str, int]:
    """Host and port of ``udp://host:port``; the port is 6000 if it is not given."""
    host, _, port = (
        text.removeprefix(SERVER).rpartition(":") if ":" in text.removeprefix(SERVER) else (text.removeprefix(SERVER), "", "6000")
    )
    if not host or not port.isascii() or not port.isdecimal() or not 1 <= int(port) <= 65535:
        raise CprmError(f"{text!r}: a server is named as {SERVER}host:port")
    return host, int(port)


def watch(
    source: Annotated[str, typer.Argument(help="A game log (.rcg, any version), or udp://host:port of a server.")] = "udp://127.0.0.1:6000",
    window: Annotated[bool, typer.Option("--window", help="Show it in a window instead of the terminal.")] = False,
    record: Annotated[Path | None, typer.Option(help="Write the stream of a server to a game log.")] = None,
    speed: Annotated[float, typer.Option(help="Times the speed of the game; a live match has its own.")] = 1.0,
    every: Annotated[int, typer.Option(help="Without a terminal: cycles between two pictures.")] = 100,
) -> None:
    """Watch a match, live or from a log: space pauses, + and - change the speed, q ends."""
    from ..client.monitor import MonitorConnection
    from ..simulator.gamelog.reader import GameLogReader
    from ..simulator.gamelog.writer import GameLogWriter

    if not speed > 0 or every < 1:
        raise CprmError(f"--speed {speed:g} and --every {every}: both must be positive")
    live = source.startswith(SERVER)
    with ExitStack() as stack:
        header: GameLogHeader
        if live:
            monitor = stack.enter_context(MonitorConnection(*place_of(source)))
            header, frames = monitor.header, monitor.frames()
        else:
            reader = GameLogReader(source)
            header, frames = reader.header, iter(reader)
        if record is not None:
            settings = header.parameters(), header.player_parameters(), header.types()
            writer = stack.enter_context(GameLogWriter(record, *settings, teams=("", "")))
            frames = recorded(frames, writer)
        seen = itertools.count()
        numbered = (frame for frame, _ in zip(frames, seen))
        try:
            show(numbered, header, window, 0.0 if live else speed, every)
        except KeyboardInterrupt:
            typer.echo("interrupted")
    typer.echo(f"{next(seen)} frames" + (f", wrote {record}" if record is not None else ""))


def recorded(frames: Iterator[Frame], writer: Any) -> Iterator[Frame]:
    """Frames, each written to a log as a server would: nothing of the waits before a kick-off, and the end once."""
    from ..simulator.state import PlayMode

    over = False
    for frame in frames:
        writer.teams = frame.left.name, frame.right.name
        if frame.mode != PlayMode.before_kick_off and not over:
            writer.write(frame)
        over = frame.mode == PlayMode.time_over
        yield frame


def show(frames: Iterator[Frame], header: GameLogHeader, window: bool, speed: float, every: int) -> None:
    """Show frames until they end or the watcher has seen enough. A live match (speed 0) sets its own pace."""
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    from ..envs.rendering import Viewer, text_picture
    from .keys import Keys, Pace
    from .pictures import world_of

    console, pace = Console(), Pace(speed or 1.0)
    viewer = Viewer("human", fps=1000, goal_width=header.parameters().goal_width) if window else None
    with Keys() as keys, ExitStack() as stack:
        live = stack.enter_context(Live(console=console, auto_refresh=False)) if console.is_terminal and viewer is None else None
        for count, frame in enumerate(frames):
            names = f"{frame.left.name or 'null'} - {frame.right.name or 'null'}"
            if viewer is not None:
                viewer.draw(world_of(frame)[0])
            elif live is not None:
                live.update(
                    Text(f"{names}  x{pace.speed:g}\n{text_picture(world_of(frame)[0], min(106, console.width - 2))}"), refresh=True
                )
            elif count % every == 0:
                typer.echo(f"{names}\n{text_picture(world_of(frame)[0])}")
            if live is not None or viewer is not None:
                pace.press(keys.pressed(pace.seconds if speed else 0.0))
                while pace.paused and not pace.ended:
                    pace.press(keys.pressed(0.1))
            if pace.ended:
                break
    if viewer is not None:
        viewer.close()


def convert(
    source: Annotated[Path, typer.Argument(help="A game log of any version.")],
    target: Annotated[Path, typer.Argument(help="Where to write it; .gz compresses.")],
    version: Annotated[str | None, typer.Option(help="1 to 6, json or record.", show_default="6; json and record by the name")] = None,
) -> None:
    """Convert a game log between all versions, JSON and records, which hold all. What a version does not hold is lost."""
    from ..files import check_place
    from ..simulator.gamelog.convert import convert as convert_log

    check_place(target, "target")
    if source.exists() and target.exists() and source.samefile(target):
        raise CprmError(f"{target}: that is the source itself")
    typer.echo(f"wrote {target}, {convert_log(source, target, version)} frames")


def stats(
    log: Annotated[Path, typer.Argument(help="A game log of any version.")],
    heat: Annotated[Path | None, typer.Option(help="Draw a heat map of the match into this picture (.png, .svg, .pdf).")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of tables.")] = False,
) -> None:
    """What happened in a match, per half: possession, passes, shots, ways, offsides, stamina, heat map."""
    import json

    from rich.console import Console
    from rich.table import Table

    from ..simulator.gamelog.statistics import match_statistics
    from .pictures import save_heat_map

    found = match_statistics(log)
    names = found.teams[0] or "null", found.teams[1] or "null"
    if as_json:
        parts = {part.name: {what: [left, right] for what, left, right in part.rows()} for part in found.parts}
        typer.echo(json.dumps({"teams": names, "parts": parts}, indent=1))
    else:
        console = Console()
        for part in found.parts:
            table = Table(f"{part.name}, {part.cycles} frames", *names, box=None, padding=(0, 2))
            for row in part.rows():
                table.add_row(*row)
            console.print(table)
    if heat is not None:
        save_heat_map(found.whole, found.teams, heat)
        typer.echo(f"wrote {heat}", err=as_json)
