"""The web server of the studio: the page's files, and one websocket for all else.

It answers only who knows the token that stands in the address, and a websocket only if the page that opens it came from this server
(`Origin`), so that no other page that is open in the browser can speak to it; a request whose `Host` is another name is refused, too.
"""

from __future__ import annotations

import hmac
import socket
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from ..errors import CprmError
from .calls import Calls
from .sockets import Answers, Pages, attend

STATIC = Path(__file__).parent / "static"
"""The page's files."""
LARGEST = 16 << 20
"""Bytes of the largest message that is taken."""
POLICY = "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; connect-src 'self'; frame-ancestors 'none'"
"""What the page may load: what comes from here."""
TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml", ".png": "image/png",
         ".txt": "text/plain", ".json": "application/json", ".woff2": "font/woff2"}  # fmt: skip
"""Ending -> type, said here because a computer's own list may say otherwise."""


def found(path: str) -> Path | None:
    """A file of the page, or None when there is none of that name."""
    try:
        file = (STATIC / path).resolve()
        known = STATIC.resolve() in file.parents and file.suffix in TYPES and file.is_file()
    except (OSError, ValueError):  # too long for a name, or no name at all
        return None
    return file if known else None


def make_app(calls: Calls, pages: Pages, token: str, hosts: tuple[str, ...]) -> Any:
    """The ASGI application.

    Parameters
    ----------
    calls : Calls
    pages : Pages
    token : str
    hosts : tuple of str
        ``127.0.0.1:8123``: names under which the server is reached; a websocket's origin is one of them.

    Raises
    ------
    CprmError
        When starlette is not installed.
    """
    try:
        applications, routing, responses = (import_module(f"starlette.{part}") for part in ("applications", "routing", "responses"))
    except ImportError:
        raise CprmError("the studio needs a web server: pip install 'cprm-gym[studio]'") from None
    answers = Answers(calls)

    def allowed(connection: Any) -> bool:
        given = connection.query_params.get("token", "")
        return connection.headers.get("host", "") in hosts and hmac.compare_digest(given.encode(), token.encode())

    async def page(request: Any) -> Any:
        headers = {"Content-Security-Policy": POLICY, "Cache-Control": "no-store", "Referrer-Policy": "no-referrer"}
        name = "index.html" if allowed(request) else "refused.html"
        return responses.HTMLResponse((STATIC / name).read_text("utf-8"), 200 if name == "index.html" else 403, headers)

    async def static(request: Any) -> Any:
        file = found(request.path_params["path"]) if request.headers.get("host", "") in hosts else None
        if file is None:
            return responses.PlainTextResponse("there is no such file", 404)
        return responses.Response(file.read_bytes(), media_type=TYPES[file.suffix], headers={"Cache-Control": "no-cache"})

    async def connect(ws: Any) -> None:
        origin = ws.headers.get("origin", "")
        if not allowed(ws) or origin not in [f"http://{host}" for host in hosts]:
            await ws.close(4403)
            return
        await ws.accept()
        await attend(ws, pages, answers)

    return applications.Starlette(
        routes=[
            routing.Route("/", page),
            routing.Route("/static/{path:path}", static),
            routing.WebSocketRoute("/ws", connect),
        ]
    )


def listen(host: str, port: int) -> socket.socket:
    """A socket that listens.

    Raises
    ------
    CprmError
        When there cannot be one.
    """
    listening = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_STREAM)
    try:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((host, port))
    except (OSError, OverflowError) as error:
        listening.close()
        raise CprmError(f"--host {host} --port {port}: cannot listen there: {error}") from None
    return listening


def serve_app(app: Any, listening: socket.socket, started: Callable[[], object] = lambda: None) -> None:
    """Serve until interrupted.

    Parameters
    ----------
    app : ASGI application
    listening : socket
    started : callable
        Called as soon as it answers.
    """
    uvicorn = import_module("uvicorn")
    config = uvicorn.Config(app, log_level="warning", ws="websockets-sansio", ws_max_size=LARGEST, lifespan="off",
                            timeout_graceful_shutdown=1)  # fmt: skip

    class Server(uvicorn.Server):  # type: ignore[misc, name-defined]
        async def startup(self, sockets: Any = None) -> None:
            await super().startup(sockets)
            started()

    Server(config).run([listening])
