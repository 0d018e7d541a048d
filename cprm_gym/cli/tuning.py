"""``cprm-gym tune``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from ..errors import CprmError, unknown_name
from ..files import check_place
from .saying import complaints, console


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
    method: Annotated[
        str | None, typer.Option(help="How it searches: cma-es (package cmaes), or cross-entropy.", show_default="cma-es")
    ] = None,
    check: Annotated[
        int | None, typer.Option(help="Then play so many other worlds with what was found and with what was set by hand, paired.")
    ] = None,
) -> None:
    """Tune the constants of a task's player for a tier of knowledge; the studies in use stand in cprm_gym/agents/studies."""
    import json

    from ..benchmark.knowledge import SENSES
    from ..benchmark.tracking import TrackingPlan
    from ..benchmark.tuning import Plan, Search, study
    from ..benchmark.tuning import check as checked

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
    for name, given in (("others", others), ("side", side if side != "left" else ""), ("check", str(check or "")), ("method", method)):
        if tracker and given:
            raise CprmError(f"--{name} {given}: the tracker's own constants are tuned for all; leave out --{name} or --tracker")
    plan: Search = (
        TrackingPlan(task, **sizes)
        if tracker
        else Plan(task, tier, senses=SENSES[senses], others=others, side=side, method=method or "cma-es", **sizes)  # type: ignore[arg-type]
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
