"""Who may talk to the page: checks of every HTTP request and every websocket."""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any, Final
from urllib.parse import parse_qsl, quote, urlencode, urlsplit

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

LOOPBACK: Final = ("127.0.0.1", "localhost", "[::1]")
"""Names of this machine as a browser writes them."""
TOKEN: Final = "token"  # noqa: S105 - the name of the parameter
COOKIE: Final = "electrovib-explorer"
HEADERS: Final = (
    (b"referrer-policy", b"no-referrer"),
    (b"x-frame-options", b"DENY"),
    (b"x-content-type-options", b"nosniff"),
    (b"content-security-policy", b"frame-ancestors 'none'; form-action 'self'; base-uri 'self'"),
)
"""Added to every response."""
_POLICY_VIOLATION: Final = 1008
"""Code with which a websocket is closed."""


def is_loopback(host: str) -> bool:
    """Return whether an address can be reached from this machine alone."""
    return host in ("127.0.0.1", "localhost", "::1", "[::1]")


def new_token() -> str:
    """Return a random token of 256 bits, in letters that an address may hold."""
    return secrets.token_urlsafe(32)


class AccessControl:
    """Checks in front of an application: of the host, of the origin and, where one is set, of the token.

    Parameters
    ----------
    app : callable
        ASGI application.
    hosts : iterable of str
        Names under which the page may be addressed, without a port: ``127.0.0.1``, ``localhost``.
    port : int
        Port of the page.
    token : str
        Secret that every request needs; empty where the page can be reached from this machine alone.

    Notes
    -----
    A page of another site in the same browser can send requests to this one, and can open a websocket, without reading the
    answer of the first. The browser states where they come from in ``Origin``, and by which name this server was addressed in
    ``Host`` (which a hostile name server can point here). Both are compared with the names of this page in every scope. A
    websocket without ``Origin`` is refused, because every browser sends one.

    A token is accepted from the address once; it is then kept in a cookie that scripts cannot read, and removed from the
    address, so that it is neither shown nor copied with a link.
    """

    def __init__(self, app: App, *, hosts: Iterable[str], port: int, token: str = "") -> None:
        self._app = app
        self._hosts = frozenset(f"{host}:{port}" for host in hosts) | (
            frozenset(hosts) if port == 80 else frozenset()
        )
        self._token = token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or hand it to the application."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(scope)
        if refusal:
            await _refuse(scope, receive, send, refusal)
        elif scope["type"] == "websocket":
            await self._app(scope, receive, send)
        elif self._token and (rest := self._without_token(scope)) is not None:
            await _redirect(send, rest, self._token)
        else:
            await self._app(scope, receive, _with_headers(send))

    def _refusal(self, scope: Scope) -> str:
        """Return why a request is refused, as a sentence; empty if it is not."""
        hosts, origins = _values(scope, b"host"), _values(scope, b"origin")
        if len(hosts) != 1 or hosts[0].lower() not in self._hosts:
            known = ", ".join(sorted(self._hosts))
            return f"This page is not served under this name. It is served under {known}."
        if len(origins) > 1 or (scope["type"] == "websocket" and not origins):
            return "A connection has to state the one page from which it comes (header Origin)."
        if origins and not self._is_own(origins[0], hosts[0]):
            return "A page of another site may not talk to this one."
        if self._token and not self._has_token(scope):
            return "This page needs its token. Open the address that 'electrovib explore' printed, with '?token=...'."
        return ""

    def _is_own(self, origin: str, host: str) -> bool:
        parts = urlsplit(origin)
        return parts.scheme in ("http", "https") and parts.netloc.lower() == host.lower()

    def _has_token(self, scope: Scope) -> bool:
        given = [value for name, value in _query(scope) if name == TOKEN] if scope["type"] == "http" else []
        given += _cookies(scope)
        return any(hmac.compare_digest(each.encode(), self._token.encode()) for each in given)

    def _without_token(self, scope: Scope) -> str | None:
        """Return the address without its token; None if it has none."""
        items = _query(scope)
        rest = [(name, value) for name, value in items if name != TOKEN]
        if len(rest) == len(items):
            return None
        path = quote("/" + str(scope["path"]).lstrip("/"))  # '//name' would be the address of another server
        return path + (f"?{urlencode(rest)}" if rest else "")


def _values(scope: Scope, name: bytes) -> list[str]:
    return [value.decode("latin-1") for key, value in scope["headers"] if key.lower() == name]


def _query(scope: Scope) -> list[tuple[str, str]]:
    text = scope.get("query_string", b"").decode("latin-1")
    try:
        return parse_qsl(text, keep_blank_values=True, max_num_fields=1000)
    except ValueError:
        return []


def _cookies(scope: Scope) -> list[str]:
    found = []
    for text in _values(scope, b"cookie"):
        try:
            cookie = SimpleCookie(text)
        except CookieError:
            continue
        if COOKIE in cookie:
            found.append(cookie[COOKIE].value)
    return found


def _with_headers(send: Send) -> Send:
    async def extended(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            own = {name for name, _ in HEADERS}
            kept = [(name, value) for name, value in message.get("headers", []) if name.lower() not in own]
            message = {**message, "headers": [*kept, *HEADERS]}
        await send(message)

    return extended


async def _refuse(scope: Scope, receive: Receive, send: Send, sentence: str) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": _POLICY_VIOLATION, "reason": sentence[:100]})
        return
    content = (b"content-type", b"text/plain; charset=utf-8")
    await send({"type": "http.response.start", "status": 403, "headers": [content, *HEADERS]})
    await send({"type": "http.response.body", "body": sentence.encode() + b"\n"})


async def _redirect(send: Send, address: str, token: str) -> None:
    cookie = f"{COOKIE}={token}; Path=/; HttpOnly; SameSite=Strict"
    headers = [(b"location", address.encode("latin-1")), (b"set-cookie", cookie.encode("latin-1"))]
    await send({"type": "http.response.start", "status": 303, "headers": [*headers, *HEADERS]})
    await send({"type": "http.response.body", "body": b""})
