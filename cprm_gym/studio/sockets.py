"""The websockets of the studio: what pages are sent and told, and how their calls are answered."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections import deque
from typing import Any

from ..errors import CprmError
from .calls import Calls

BACKLOG = 3
"""Events of a kind marked as passing that may wait for a slow page; older ones are left out."""


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


class Answers:
    """Answers the calls of pages: those of one room one after the other, those of several rooms side by side.

    Parameters
    ----------
    calls : Calls
    """

    def __init__(self, calls: Calls) -> None:
        self.calls = calls
        self._rooms: dict[str, asyncio.Lock] = {}

    async def answer(self, page: Page, text: str) -> None:
        """Answer a message; what it does wrong is told to the page."""
        number, name, given = read_message(text)
        if name is None:
            page.send(to_text({"re": number, "error": "a message is {id, call, with}", "kind": "FormatError"}))
            return
        try:
            async with self._rooms.setdefault(name.partition(".")[0], asyncio.Lock()):
                reply = to_text({"re": number, "result": await asyncio.to_thread(self.calls.answer, name, given)})
        except CprmError as error:
            reply = to_text({"re": number, "error": str(error), "kind": type(error).__name__})
        except OSError as error:
            reply = to_text({"re": number, "error": f"{error.filename}: {error.strerror}", "kind": "OSError"})
        except Exception as error:  # told to the page, which goes on; the trace is for whoever started the server
            reply = to_text({"re": number, "error": f"{type(error).__name__}: {error}", "kind": "Exception"})
            asyncio.get_running_loop().call_exception_handler({"message": f"call {name}", "exception": error})
        page.send(reply)


def read_message(text: str) -> tuple[int | str | None, str | None, dict[str, Any]]:
    """The number, the call and the arguments of a message; no call where it is no message."""
    number = None
    try:
        message = from_text(text)
        name, given = message["call"], message.get("with", {})
        if isinstance(message["id"], (int, str)):
            number = message["id"]
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return number, None, {}
    known = number is not None and isinstance(name, str) and isinstance(given, dict)
    return number, name if known else None, given if known else {}


async def attend(ws: Any, pages: Pages, answers: Answers) -> None:
    """Answer and tell one page, as long as it is there.

    Parameters
    ----------
    ws : starlette.websockets.WebSocket
        That was accepted.
    pages : Pages
    answers : Answers
    """
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
            task = asyncio.create_task(answers.answer(page, message.get("text") or ""))
            tasks.add(task)
            task.add_done_callback(tasks.discard)
    finally:
        pages.leave(page)
        sending.cancel()
        with contextlib.suppress(asyncio.CancelledError, Exception):  # a page that went away while it was written to
            await sending
