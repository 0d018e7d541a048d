"""``cprm-gym studio``."""

from __future__ import annotations

import secrets
from pathlib import Path
from typing import Annotated

import typer

from ..errors import CprmError


def studio(
    file: Annotated[str | None, typer.Argument(help="A net, model or CPRM to open: a file, or package.module:NAME.")] = None,
    demo: Annotated[str | None, typer.Option(help="A demonstration to watch: striker, goalie, passers, eleven.")] = None,
    log: Annotated[Path | None, typer.Option(help="A game log (.rcg) or a benchmark's folder of results to look into.")] = None,
    seed: Annotated[int, typer.Option(help="Which world.")] = 0,
    host: Annotated[str, typer.Option(help="Address to listen at; another than this computer's own lets others in.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port; 0 takes a free one.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page.")] = True,
) -> None:
    """Watch an agent think, stop it and ask why, edit its net and model: a local page in the browser."""
    import webbrowser

    from .server import listen, make_app, serve_app
    from .sockets import Pages
    from .studio import Studio

    if sum(given is not None for given in (file, demo, log)) > 1:
        raise CprmError("FILE, --demo and --log: one of them says what is opened")
    pages, token = Pages(), secrets.token_urlsafe(18)
    made = Studio(pages.publish, file=file, demo=demo, log=log, seed=seed)
    with listen(host, port) as listening:
        bound = listening.getsockname()[1]
        names = dict.fromkeys((host, *(("127.0.0.1", "localhost") if host in ("127.0.0.1", "localhost", "0.0.0.0") else ())))
        hosts = tuple(f"[{name}]:{bound}" if ":" in name else f"{name}:{bound}" for name in names)
        app = make_app(made.calls, pages, token, hosts)
        address = f"http://{hosts[0] if host != '0.0.0.0' else hosts[1]}/?token={token}"

        def started() -> None:
            typer.echo(f"the studio is at {address}\nCtrl-C ends it")
            if browser:
                webbrowser.open(address)

        try:
            serve_app(app, listening, started)
        except KeyboardInterrupt:
            typer.echo("ended")
        finally:
            made.close()
