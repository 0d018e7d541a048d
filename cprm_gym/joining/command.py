"""``cprm-gym join``."""

from __future__ import annotations

import math
import signal
from typing import Annotated, Any

import typer

from ..errors import CprmError


def join(
    team: Annotated[str, typer.Argument(help="Name of the team, at most 15 letters, digits, '_' or '-'.")],
    host: Annotated[str, typer.Option(help="Where the server is.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Of its players.")] = 6000,
    controller: Annotated[str, typer.Option(help="Who plays: a registered controller.")] = "cprm",
    task: Annotated[str, typer.Option(help="What the controller plays.")] = "Soccer11v11",
    part: Annotated[str, typer.Option(help="Side of the task that the team plays, left or right, wherever it is put.")] = "left",
    players: Annotated[int | None, typer.Option(help="How many join from here.", show_default="those of the task")] = None,
    goalie: Annotated[bool, typer.Option(help="The first of them is the goalie.")] = True,
    coach: Annotated[bool, typer.Option("--coach", help="A coach chooses heterogeneous types.")] = False,
    coach_port: Annotated[int | None, typer.Option(help="Of the server's coaches.", show_default="the players' and 2")] = None,
    seed: Annotated[int, typer.Option(help="Of the controllers.")] = 0,
    t_b: Annotated[
        int | None, typer.Option(help="Of cprm: cycles from one inference to the next.", show_default="the model's slice")
    ] = None,
    latency: Annotated[int | None, typer.Option(help="Of cprm: cycles until an inference's result comes.", show_default="0")] = None,
    wait: Annotated[float, typer.Option(help="Seconds for which the server's answer is waited for.")] = 10.0,
) -> None:
    """Join a match on a server with controllers of ours."""
    import re

    from ..envs.others.registry import load_controller, with_options
    from ..envs.tasks import make_task
    from .team import JoinedTeam

    if not re.fullmatch(r"[A-Za-z0-9_-]{1,15}", team):
        raise CprmError(f"team {team!r}: a name has 1 to 15 letters, digits, '_' or '-'")
    made = make_task(task)
    if part not in ("left", "right"):
        raise CprmError(f"--part {part!r}: allowed are left and right")
    most, keeper = (made.left, made.left_goalie) if part == "left" else (made.right, made.right_goalie)
    if not most:
        raise CprmError(f"--part {part}: the task {task} has nobody on that side")
    count = most if players is None else players
    if not 1 <= count <= most:
        raise CprmError(f"--players {count}: allowed are 1 to {most}, the players of {task}")
    if not 0 < wait < math.inf:
        raise CprmError(f"--wait {wait:g}: seconds above 0 are needed")
    (controller,) = with_options([controller], t_b=t_b, latency=latency)
    going = True

    def end(*_: Any) -> None:
        nonlocal going
        going = False

    joined = JoinedTeam(
        host, port, team, made, load_controller(controller), players=count, goalie=goalie and keeper > 0, part=part,
        coach=coach, coach_port=port + 2 if coach_port is None else coach_port, seed=seed, patience=wait,
    )  # fmt: skip
    typer.echo(f"{team}: {', '.join(player.agent for player in joined.players)} play as {controller} at {host}:{port}")
    before = {word: signal.signal(word, end) for word in (signal.SIGINT, signal.SIGTERM)}
    try:
        joined.play(lambda: going)
    finally:
        joined.leave()
        for word, handler in before.items():
            signal.signal(word, handler)
    typer.echo(joined.summary())
