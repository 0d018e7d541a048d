"""``cprm-gym conformance``, ``demo`` and ``play``."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from ..errors import CprmError
from ..files import check_place
from .saying import LATENCY, T_B, complaints, console, split_names, wrote


def conformance(
    paths: Annotated[list[Path], typer.Argument(help="Recordings (.jsonl.gz), matches (.rcg.gz with its .rcl.gz), or folders of them.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of text.")] = False,
) -> None:
    """Replay recordings of a real server and compare; exit status 1 when anything differs."""
    from ..simulator.conformance import run as replay

    with complaints.status("replaying ...") as status:
        report = replay(paths, lambda result, done, total: status.update(f"{done} of {total} files replayed"))
    typer.echo(report.to_json() if as_json else report.text())
    if not report.ok:
        raise typer.Exit(1)


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

    from ..agents.demos import Recorder, Scene, panel, play
    from ..envs.rendering import text_picture

    def shown(scene: Scene) -> Group:
        panels = [Panel(Text("\n".join(panel(player)[1:])), title=panel(player)[0], width=46) for player in scene.players]
        width = max(40, min(106, console.width - 2))
        return Group(Text(text_picture(scene.world, width, width // 3)), Columns(panels), Text(f"cycle {scene.cycle}  {scene.status}"))

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
        wrote([record])
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

    from ..envs.others.registry import load_controller, with_options
    from ..envs.play import Film
    from ..envs.play import play as episode
    from ..envs.rendering import Viewer, text_picture
    from ..envs.tasks import Soccer, Status, make_task

    made = make_task(task)
    names = with_options([] if controller is None else [controller], t_b=t_b, latency=latency)
    factory = load_controller(names[0]) if names else None
    sides = None if others is None else split_names(others)
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
        wrote([record])
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
