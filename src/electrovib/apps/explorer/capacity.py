"""How much the server takes: the size of a request and the numbers of open pages and connections."""

from __future__ import annotations

import asyncio
import time
from collections import Counter
from collections.abc import Callable, Mapping, MutableMapping
from contextlib import ExitStack
from typing import Any, Final
from urllib.parse import parse_qs

from electrovib.apps.explorer.access import App, Receive, Scope, Send, answer, refuse_connection
from electrovib.apps.explorer.limits import LARGEST_REQUEST, MOST_CONNECTIONS, MOST_PAGES

_OF_FRAMEWORK: Final = "/_nicegui"
"""Beginning of the addresses that open no page."""
FIRST_CONNECTION: Final = 5.0
"""Seconds for which a page is kept on a full server until a browser connects with it."""


def has_room(pages: Mapping[str, Any], coming: int = 0) -> bool:
    """Return whether one more page can be opened; on a full server those are closed first whose browsers have left.

    `pages` are in the order in which they were requested or, later, left by their browsers; `coming` are
    opened before this one.
    """
    latest = time.time() - FIRST_CONNECTION
    left = [
        each
        for each in pages.values()
        if not each.has_socket_connection and (each.environ is not None or each.created < latest)
    ]
    for each in left[: max(len(pages) + coming - MOST_PAGES + 1, 0)]:
        for waiting in each._delete_tasks.values():  # noqa: SLF001 - they would delete it again
            waiting.cancel()
        each.delete()
    return len(pages) + coming < MOST_PAGES


class RequestLimits:
    """Limits in front of an ASGI application: bytes of a request, and pages and connections that are open at the same time.

    The browser refuses a large file itself, but not every sender is a browser: the bytes are counted as they
    arrive, and those beyond the limit are not read. A connection that ends in the middle of a request is no
    error of the server.
    """

    def __init__(self, app: App, *, pages: Mapping[str, Any]) -> None:
        self._app, self._pages = app, pages
        self._connections: Counter[str] = Counter()
        self._turn, self._waiting = asyncio.Lock(), 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Hand a request to the application, unless it is too large, or one page or connection too many."""
        if scope["type"] == "websocket":
            await self._connect(scope, receive, send)
        elif scope["type"] != "http":
            await self._app(scope, receive, send)
        elif str(scope["path"]).startswith(_OF_FRAMEWORK):
            await self._answer(scope, receive, send)
        else:
            await self._open(scope, receive, send)

    async def _connect(self, scope: Scope, receive: Receive, send: Send) -> None:
        wanted = parse_qs(scope.get("query_string", b"").decode("latin-1")).get("client_id", [""])[0]
        page = wanted if wanted in self._pages else ""
        if self._connections[page] >= MOST_CONNECTIONS:
            await refuse_connection(receive, send, f"{MOST_CONNECTIONS} connections are open already.")
            return
        self._connections[page] += 1
        try:
            await self._app(scope, receive, send)
        finally:
            self._connections -= Counter([page])

    async def _open(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Open a page after those that were asked for before, each of which exists when its answer begins."""
        if has_room(self._pages, self._waiting):
            with ExitStack() as turn:
                self._waiting += 1
                try:
                    await self._turn.acquire()
                finally:
                    self._waiting -= 1
                turn.callback(self._turn.release)
                if has_room(self._pages):
                    await self._answer(scope, receive, send, turn.close)
                    return
        await answer(
            send,
            503,
            f"This server has {MOST_PAGES} pages open, which is as many as it shows at once."
            " Close one and load this address again after some seconds.",
        )

    async def _answer(
        self, scope: Scope, receive: Receive, send: Send, begins: Callable[[], object] = bool
    ) -> None:
        counted = _Counted(scope, receive, send, begins)
        if counted.declares_too_much:
            await counted.refuse()
            return
        try:
            await self._app(scope, counted.receive, counted.send)
        except Exception:
            if not counted.has_ended:
                raise
        if counted.is_too_large:
            await counted.refuse()


class _Counted:
    """A request whose bytes are counted; `begins` is called before each part of its answer."""

    def __init__(self, scope: Scope, receive: Receive, send: Send, begins: Callable[[], object]) -> None:
        self._receive, self._send, self._begins = receive, send, begins
        self._bytes, self._has_answered, self._has_left = 0, False, False
        declared = [value for name, value in scope["headers"] if name.lower() == b"content-length"]
        self.declares_too_much = any(not each.isdigit() or int(each) > LARGEST_REQUEST for each in declared)
        self.is_too_large = False

    @property
    def has_ended(self) -> bool:
        """Whether no more of the request arrives: its sender has left, or it is too large."""
        return self._has_left or self.is_too_large

    async def receive(self) -> MutableMapping[str, Any]:
        """Receive the next part; a request that is too large ends as if its sender had left."""
        if self.is_too_large:
            return {"type": "http.disconnect"}
        message = await self._receive()
        self._bytes += len(message.get("body", b""))
        self.is_too_large = self._bytes > LARGEST_REQUEST
        self._has_left = self._has_left or message["type"] == "http.disconnect"
        return {"type": "http.disconnect"} if self.is_too_large else message

    async def send(self, message: MutableMapping[str, Any]) -> None:
        """Send a part of the answer; nothing of the application's once the request has ended early."""
        self._begins()
        if not self.is_too_large:
            self._has_answered = True
            await self._send(message)

    async def refuse(self) -> None:
        """Answer with a sentence, unless an answer has begun."""
        if not self._has_answered:
            await answer(
                self._send,
                413,
                f"This request is too large; a page takes {LARGEST_REQUEST / 1e6:g} MB at most.",
            )
