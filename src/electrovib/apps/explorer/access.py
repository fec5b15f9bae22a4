"""Who may talk to the page, how much a request holds, and what an event of a browser may hold."""

from __future__ import annotations

import functools
import inspect
import itertools
import logging
import re
from collections.abc import Callable, Iterable, Mapping, MutableMapping
from traceback import walk_tb
from typing import TYPE_CHECKING, Any, Final

import orjson
from socketio.exceptions import SocketIOError  # type: ignore[import-untyped]
from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse

from electrovib.apps.explorer.runner import LARGEST_REQUEST, LONGEST_NAME, LOOPBACK

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

HEADERS: Final = {
    "referrer-policy": "no-referrer",
    "x-frame-options": "DENY",
    "x-content-type-options": "nosniff",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    # the framework writes scripts into its page and compiles its templates in the browser
    "content-security-policy": (
        "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline';"
        " img-src 'self' data: blob:; font-src 'self' data:; worker-src 'self' blob:; object-src 'none';"
        " frame-src 'none'; frame-ancestors 'none'; form-action 'self'; base-uri 'self'"
    ),
}
"""Added to every response."""
_OF_PROXIES: Final = (b"x-forwarded-", b"forwarded", b"x-real-ip", b"x-original-", b"x-rewrite-")
"""First letters of the headers in which a proxy describes a request; this server has none that could be trusted."""
_POLICY_VIOLATION: Final = 1008
"""Code with which a websocket is closed."""


class AccessControl:
    """Checks in front of an ASGI application: of the host and of the origin.

    A page of another site in the same browser can send requests to this one, and can open a websocket. The
    browser states where they come from in ``Origin`` and ``Sec-Fetch-Site``, and by which name this server
    was addressed in ``Host`` (which a hostile name server can point here). All are compared with the names of
    this page in every scope. A websocket without ``Origin`` is refused, because every browser sends one.
    Another site may link to the page, but may neither embed it nor load anything from it. Headers of proxies
    are removed.
    """

    def __init__(self, app: ASGIApp, *, port: int) -> None:
        self._app = app
        self._hosts = frozenset([f"{name}:{port}" for name in LOOPBACK] + [*(LOOPBACK if port == 80 else ())])

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or hand it to the application."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        if refusal := self._refusal(scope):
            await refuse(scope, receive, send, refusal)
            return
        kept = [(name, value) for name, value in scope["headers"] if not name.lower().startswith(_OF_PROXIES)]
        scope = {**scope, "headers": kept}
        await self._app(scope, receive, _with_headers(send) if scope["type"] == "http" else send)

    def _refusal(self, scope: Scope) -> str:
        """Return why a request is refused, as a sentence; empty if it is not."""
        headers = Headers(raw=_lowered(scope["headers"]))
        hosts, origins = headers.getlist("host"), headers.getlist("origin")
        if len(hosts) != 1 or hosts[0].lower() not in self._hosts:
            known = ", ".join(sorted(self._hosts))
            return f"This page is not served under this name. It is served under {known}."
        if len(origins) > 1 or (scope["type"] == "websocket" and not origins):
            return "A connection has to state the one page from which it comes (header Origin)."
        if origins and origins[0].lower() != f"http://{hosts[0].lower()}":
            return "A page of another site may not talk to this one."
        if _is_loaded_by_another_site(headers, scope):
            return "A page of another site may link to this one, but may load nothing from it."
        return ""


def _is_loaded_by_another_site(headers: Headers, scope: Scope) -> bool:
    """Return whether the browser states that another site caused a request, other than by a link to a whole page."""
    sites, mode, target = (headers.getlist(f"sec-fetch-{each}") for each in ("site", "mode", "dest"))
    if all(site in ("same-origin", "none") for site in sites):
        return False
    return scope.get("method") != "GET" or mode != ["navigate"] or target != ["document"]


def _lowered(headers: Iterable[tuple[bytes, bytes]]) -> list[tuple[bytes, bytes]]:
    """Return headers with their names in small letters; a server of websockets leaves these as they were sent."""
    return [(name.lower(), value) for name, value in headers]


def _with_headers(send: Send) -> Send:
    async def extended(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(raw=_lowered(message.get("headers", [])))
            headers.update(HEADERS)
            message = {**message, "headers": headers.raw}
        await send(message)

    return extended


async def refuse(scope: Scope, receive: Receive, send: Send, sentence: str, status: int = 403) -> None:
    """Answer a request with a sentence instead of the page, or refuse a websocket."""
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": _POLICY_VIOLATION, "reason": sentence[:100]})
        return
    answer = PlainTextResponse(f"{sentence}\n", status, HEADERS | {"cache-control": "no-store"})
    await answer(scope, receive, send)


class RequestLimits:
    """Limit of the bytes of a request, in front of an ASGI application.

    The browser refuses a large file itself, but not every sender is a browser: the bytes are counted as they
    arrive, and those beyond the limit are not read. A connection that ends in the middle of a request is no
    error of the server.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Hand a request to the application, unless it is too large."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
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
        self._scope, self._receive, self._send = scope, receive, send
        self._bytes, self._has_answered, self._has_left = 0, False, False
        declared = [value for name, value in scope["headers"] if name.lower() == b"content-length"]
        self.declares_too_much = any(not each.isdigit() or int(each) > LARGEST_REQUEST for each in declared)
        self.is_too_large = False

    @property
    def has_ended(self) -> bool:
        """Whether no more of the request arrives: its sender has left, or it is too large."""
        return self._has_left or self.is_too_large

    async def receive(self) -> Message:
        """Receive the next part; a request that is too large ends as if its sender had left."""
        if self.is_too_large:
            return {"type": "http.disconnect"}
        message = await self._receive()
        self._bytes += len(message.get("body", b""))
        self.is_too_large = self._bytes > LARGEST_REQUEST
        self._has_left = self._has_left or message["type"] == "http.disconnect"
        return {"type": "http.disconnect"} if self.is_too_large else message

    async def send(self, message: Message) -> None:
        """Send a part of the answer; nothing of the application's once the request has ended early."""
        if not self.is_too_large:
            self._has_answered = True
            await self._send(message)

    async def refuse(self) -> None:
        """Answer with a sentence, unless an answer has begun."""
        if not self._has_answered:
            too_large = f"This request is too large; a page takes {LARGEST_REQUEST / 1e6:g} MB at most."
            await refuse(self._scope, self._receive, self._send, too_large, 413)


LOG: Final = logging.getLogger(__name__)
MOST_LINES: Final = 100
"""Lines in the log about messages that were refused; a sender without end would fill the disk."""
_LINES: Final = itertools.count(1)
_KNOWN: Final = re.compile(r"1|3|40(\{\})?|41|42\d{0,9}(?P<event>\[.*)", re.DOTALL)
"""Messages of the framework's client: close, pong, connect, disconnect, and an event that may ask for an answer."""
_INVALID: Final = 1007
"""Code with which a websocket is closed."""


class Frames:
    """Checks of the messages, events of given names, that reach an ASGI application over websockets."""

    def __init__(self, app: ASGIApp, *, events: Iterable[str]) -> None:
        self._app, self._events = app, frozenset(events) - {"connect", "disconnect"}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Hand a connection to the application; it ends with the first message that is not one of the page."""
        if scope["type"] != "websocket":
            await self._app(scope, receive, send)
            return

        async def checked() -> Message:
            message = await receive()
            if message["type"] == "websocket.receive" and (mistake := self._mistake(message)):
                log(mistake, message.get("bytes") if message.get("text") is None else message["text"])
                await send({"type": "websocket.close", "code": _INVALID, "reason": mistake})
                return {"type": "websocket.disconnect", "code": _INVALID}
            return message

        await self._app(scope, checked, send)

    def _mistake(self, message: Message) -> str:
        """Return what is wrong with a message; empty if nothing is."""
        text = message.get("text")
        if text is None:
            return "binary data"
        found = _KNOWN.fullmatch(text)
        if found is None:
            return "no message of the page"
        if found["event"] is None:
            return ""
        try:
            event = orjson.loads(found["event"])
        except ValueError as error:
            return f"an event that cannot be read ({error})"[:100]
        match event:
            case [str(name), dict()] if name in self._events:
                return ""
        return "no event of the page"


def check_events(handlers: MutableMapping[str, Any]) -> None:
    """Let each handler of an event refuse what it cannot read with one line in the log.

    Handlers are those of the framework, by the name of the event; mistakes of a function of the page do not
    reach them.
    """
    for name in handlers.keys() - {"disconnect"}:
        handlers[name] = _checked(name, _report if name == "log" else handlers[name])


def _checked(name: str, handler: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(handler)
    async def call(sender: str, *message: Any) -> Any:
        try:
            answer = handler(sender, *message)
            return await answer if inspect.isawaitable(answer) else answer
        except SocketIOError:  # the answer to a page that is no longer there
            raise
        except Exception as error:  # noqa: BLE001 - whatever the framework raises for it
            content = message[0]
            log(f"the event '{name}' ({type(error).__name__}: {error})", content.get("QUERY_STRING", content))
            return False

    return call


def _report(_: str, message: Mapping[str, Any]) -> None:
    """Write what a browser reports of itself into the log."""
    if message["level"] in ("warning", "error"):
        log("a report", message["message"])


def is_kept(record: logging.LogRecord) -> bool:
    """Return whether a report of the framework stays in the log: not of a value that it cannot read, which is one line.

    Nor is one kept of a browser that has not answered, which every visitor causes who leaves early.
    """
    error = record.msg
    if not isinstance(error, Exception):
        return True
    if any(frame.f_code.co_name == "_event_args_to_value" for frame, _ in walk_tb(error.__traceback__)):
        log(f"a value ({type(error).__name__}: {error})")
        return False
    return not isinstance(error, TimeoutError)


def log(what: str, content: object = "") -> None:
    """Write one line, unless there are `MOST_LINES` of them."""
    number = next(_LINES)
    if number <= MOST_LINES:
        line = f"A browser sent something that is not used ({what}): {str(content)[:LONGEST_NAME]}"
        LOG.warning("%s", line.encode("unicode_escape").decode())
    if number == MOST_LINES:
        LOG.warning("Further messages of this kind are not written.")
