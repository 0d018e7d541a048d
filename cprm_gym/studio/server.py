"""The web server of the studio: the page's files, and one websocket for all else.

It answers only who knows the token that stands in the address, and a websocket only if the page that opens it came from this server
(`Origin`), so that no other page that is open in the browser can speak to it; a request whose `Host` is another name is refused, too.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import json
import socket
from collections import deque
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from ..errors import CprmError
from .calls import Calls

STATIC = Path(__file__).parent / "static"
"""The page's files."""
LARGEST = 16 << 20
"""Bytes of the largest message that is taken."""
BACKLOG = 3
"""Events of a kind marked as passing that may wait for a slow page; older ones are left out."""
POLICY = "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; connect-src 'self'; frame-ancestors 'none'"
"""What the page may load: what comes from here."""
TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml", ".png": "image/png",
         ".txt": "text/plain", ".json": "application/json", ".woff2": "font/woff2"}  # fmt: skip
"""Ending -> type, said here because a computer's own list may say otherwise."""


class Page:
    """One page that is connected: what is to be sent to it waits here."""

    def __init__(self) -> None:
        self._waiting: deque[tuple[str | None, str]] = deque()
        self._some = asyncio.Event()

    def send(self, text: str, passing: str | None = None) -> None:
        """Send a text; of those that are `passing`, by its name, only the last few are kept where the page is slow."""
        if passing is not None and sum(name == passing for name, _ in self._waiting) >= BACKLOG:
            oldest = next(entry for entry in self._waiting if entry[0] == passing)
            self._waiting.remove(oldest)
        self._waiting.append((passing, text))
        self._some.set()

    async def next(self) -> str:
        """What is sent next."""
        while not self._waiting:
            self._some.clear()
            await self._some.wait()
        return self._waiting.popleft()[1]


class Pages:
    """All pages that are connected; events may be published from any thread."""

    def __init__(self) -> None:
        self._loop: asyncio.AbstractEventLoop | None = None
        self._pages: set[Page] = set()

    def __len__(self) -> int:
        return len(self._pages)

    def join(self, page: Page) -> None:
        """One more, in the event loop's thread."""
        self._loop = asyncio.get_running_loop()
        self._pages.add(page)

    def leave(self, page: Page) -> None:
        """One less."""
        self._pages.discard(page)

    def publish(self, event: str, content: dict[str, Any], passing: bool = False) -> None:
        """Tell every page of an event.

        Parameters
        ----------
        event : str
        content : dict
            What JSON can say.
        passing : bool
            Whether a newer one makes it worthless, as a picture of a cycle.
        """
        if self._loop is None or not self._pages:
            return
        text = to_text({"event": event, **content})
        with contextlib.suppress(RuntimeError):  # the server is closing
            self._loop.call_soon_threadsafe(self._send, text, event if passing else None)

    def _send(self, text: str, passing: str | None) -> None:
        for page in self._pages:
            page.send(text, passing)


def to_text(message: Any) -> str:
    """JSON, compact; a number that JSON does not have is a mistake of ours."""
    return json.dumps(message, separators=(",", ":"), allow_nan=False, ensure_ascii=False)


def from_text(text: str) -> Any:
    """What a message says.

    Raises
    ------
    ValueError
        When it is not JSON, or holds halves of characters, which could neither be sent to other pages nor be written to a file.
    RecursionError
        When it is nested too deeply.
    """
    message = json.loads(text)
    if "\\ud" in text.lower():  # an escape that may be half a character
        json.dumps(message, ensure_ascii=False).encode()
    return message


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
    rooms: dict[str, asyncio.Lock] = {}

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

    async def answer(page: Page, text: str) -> None:
        number = None
        try:
            message = from_text(text)
            name, given = message["call"], message.get("with", {})
            if isinstance(message["id"], (int, str)):
                number = message["id"]
            if number is None or not isinstance(name, str) or not isinstance(given, dict):
                raise TypeError
        except (ValueError, TypeError, KeyError, RecursionError):
            page.send(to_text({"re": number, "error": "a message is {id, call, with}", "kind": "FormatError"}))
            return
        try:
            async with rooms.setdefault(name.partition(".")[0], asyncio.Lock()):
                reply = to_text({"re": number, "result": await asyncio.to_thread(calls.answer, name, given)})
        except CprmError as error:
            reply = to_text({"re": number, "error": str(error), "kind": type(error).__name__})
        except OSError as error:
            reply = to_text({"re": number, "error": f"{error.filename}: {error.strerror}", "kind": "OSError"})
        except Exception as error:  # told to the page, which goes on; the trace is for whoever started the server
            reply = to_text({"re": number, "error": f"{type(error).__name__}: {error}", "kind": "Exception"})
            asyncio.get_running_loop().call_exception_handler({"message": f"call {name}", "exception": error})
        page.send(reply)

    async def connect(ws: Any) -> None:
        origin = ws.headers.get("origin", "")
        if not allowed(ws) or origin not in [f"http://{host}" for host in hosts]:
            await ws.close(4403)
            return
        await ws.accept()
        page, tasks = Page(), set()
        pages.join(page)

        async def send() -> None:
            while True:
                await ws.send_text(await page.next())

        sending = asyncio.create_task(send())
        try:
            while True:
                message = await ws.receive()
                if message["type"] != "websocket.receive":
                    break
                task = asyncio.create_task(answer(page, message.get("text") or ""))
                tasks.add(task)
                task.add_done_callback(tasks.discard)
        finally:
            pages.leave(page)
            sending.cancel()
            with contextlib.suppress(asyncio.CancelledError, Exception):  # a page that went away while it was written to
                await sending

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
