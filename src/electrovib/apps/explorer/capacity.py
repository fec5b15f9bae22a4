"""How much the server takes: the size of a request and the number of open pages."""

from __future__ import annotations

from collections.abc import Callable, MutableMapping
from typing import Any, Final

from electrovib.apps.explorer.access import App, Receive, Scope, Send, answer
from electrovib.apps.explorer.limits import LARGEST_REQUEST, MOST_PAGES

_OF_FRAMEWORK: Final = "/_nicegui"
"""Beginning of the addresses that open no page."""


class RequestLimits:
    """Limits in front of an application: bytes of a request, and pages that are open at the same time.

    Parameters
    ----------
    app : callable
        ASGI application.
    open_pages : callable
        Returns the number of pages that are open.

    Notes
    -----
    The browser refuses a large file itself, but not every sender is a browser: the bytes are counted as they arrive, and
    those beyond the limit are not read. A connection that ends in the middle of a request is no error of the server.
    """

    def __init__(self, app: App, *, open_pages: Callable[[], int]) -> None:
        self._app, self._open_pages = app, open_pages

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Hand a request to the application, unless it is too large or one page too many."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        if not str(scope["path"]).startswith(_OF_FRAMEWORK) and self._open_pages() >= MOST_PAGES:
            await answer(
                send,
                503,
                f"This server has {MOST_PAGES} pages open, which is as many as it shows at once."
                " Close one and load this address again after some seconds.",
            )
            return
        counted = _Counted(scope, receive, send)
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
    """A request whose bytes are counted."""

    def __init__(self, scope: Scope, receive: Receive, send: Send) -> None:
        self._receive, self._send = receive, send
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
