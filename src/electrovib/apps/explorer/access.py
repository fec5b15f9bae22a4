"""Who may talk to the page: checks of every HTTP request and every websocket."""

from __future__ import annotations

import hmac
import ipaddress
import secrets
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from typing import Any, Final
from urllib.parse import parse_qsl, quote, urlencode

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

LOOPBACK: Final = ("127.0.0.1", "localhost", "[::1]")
"""Names of this machine as a browser writes them."""
TOKEN: Final = "token"  # noqa: S105 - the name of the parameter
COOKIE: Final = "electrovib-explorer"
"""First part of the name of the cookie; the port follows, because all ports of a host share their cookies."""
HEADERS: Final = (
    (b"referrer-policy", b"no-referrer"),
    (b"x-frame-options", b"DENY"),
    (b"x-content-type-options", b"nosniff"),
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (
        b"content-security-policy",
        # the framework writes scripts into its page and compiles its templates in the browser
        b"default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline';"
        b" img-src 'self' data: blob:; font-src 'self' data:; worker-src 'self' blob:; object-src 'none';"
        b" frame-src 'none'; frame-ancestors 'none'; form-action 'self'; base-uri 'self'",
    ),
)
"""Added to every response."""
_OF_PROXIES: Final = (b"x-forwarded-", b"forwarded", b"x-real-ip", b"x-original-", b"x-rewrite-")
"""First letters of the headers in which a proxy describes a request; this server has none that could be trusted."""
_POLICY_VIOLATION: Final = 1008
"""Code with which a websocket is closed."""


def is_loopback(host: str) -> bool:
    """Return whether an address can be reached from this machine alone."""
    return host in ("127.0.0.1", "localhost", "::1", "[::1]")


def new_token() -> str:
    """Return a random token of 256 bits, in letters that an address may hold."""
    return secrets.token_urlsafe(32)


class AccessControl:
    """Checks in front of an ASGI application: of the host, of the origin and, where one is set, of the token.

    `token` is empty where the page can be reached from this machine alone. `any_address` allows any numeric
    address too, as of a server on all interfaces, of which not every address is known: no name server can
    point a numeric address elsewhere.

    A page of another site in the same browser can send requests to this one, and can open a websocket. The
    browser states where they come from in ``Origin`` and ``Sec-Fetch-Site``, and by which name this server
    was addressed in ``Host`` (which a hostile name server can point here). All are compared with the names of
    this page in every scope. A websocket without ``Origin`` is refused, because every browser sends one.
    Another site may link to the page, but may neither embed it nor load anything from it. Headers of proxies
    are removed.

    A token is accepted from the address once; it is then kept in a cookie that scripts cannot read, and
    removed from the address, so that it is neither shown nor copied with a link.
    """

    def __init__(
        self, app: App, *, hosts: Iterable[str], port: int, token: str = "", any_address: bool = False
    ) -> None:
        self._app = app
        names = tuple(hosts)
        self._hosts = frozenset([f"{host}:{port}" for host in names] + [*(names if port == 80 else ())])
        self._port, self._token, self._any_address = port, token, any_address

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or hand it to the application."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(scope)
        if refusal:
            await refuse(scope, receive, send, refusal)
            return
        if scope["type"] == "http" and self._token and (rest := self._without_token(scope)) is not None:
            cookie = f"{COOKIE}-{self._port}={self._token}; Path=/; HttpOnly; SameSite=Strict"
            moved = [(b"location", rest.encode("latin-1")), (b"set-cookie", cookie.encode("latin-1"))]
            await _answer(send, 303, moved)
            return
        kept = [(name, value) for name, value in scope["headers"] if not name.lower().startswith(_OF_PROXIES)]
        scope = {**scope, "headers": kept}
        await self._app(scope, receive, _with_headers(send) if scope["type"] == "http" else send)

    def _refusal(self, scope: Scope) -> str:
        """Return why a request is refused, as a sentence; empty if it is not."""
        hosts, origins = _values(scope, b"host"), _values(scope, b"origin")
        if len(hosts) != 1 or not self._is_name_of_this_page(hosts[0].lower()):
            known = ", ".join(sorted(self._hosts))
            return f"This page is not served under this name. It is served under {known}."
        if len(origins) > 1 or (scope["type"] == "websocket" and not origins):
            return "A connection has to state the one page from which it comes (header Origin)."
        if origins and origins[0].lower() != f"http://{hosts[0].lower()}":
            return "A page of another site may not talk to this one."
        if _is_loaded_by_another_site(scope):
            return "A page of another site may link to this one, but may load nothing from it."
        if self._token and not self._has_token(scope):
            return "This page needs its token. Open the address that 'electrovib explore' printed, with '?token=...'."
        return ""

    def _is_name_of_this_page(self, host: str) -> bool:
        if host in self._hosts:
            return True
        name, _, port = host.rpartition(":")
        return self._any_address and port == str(self._port) and _is_numeric_address(name)

    def _has_token(self, scope: Scope) -> bool:
        given = [value for name, value in _query(scope) if name == TOKEN] if scope["type"] == "http" else []
        given += _cookies(scope, f"{COOKIE}-{self._port}")
        return any(hmac.compare_digest(each.encode(), self._token.encode()) for each in given)

    def _without_token(self, scope: Scope) -> str | None:
        """Return the address without its token; None if it has none."""
        items = _query(scope)
        rest = [(name, value) for name, value in items if name != TOKEN]
        if len(rest) == len(items):
            return None
        # '//name' would be the address of another server
        path = quote("/" + str(scope["path"]).lstrip("/\\"))
        return path + (f"?{urlencode(rest)}" if rest else "")


def _is_numeric_address(name: str) -> bool:
    try:
        address = ipaddress.ip_address(name[1:-1] if name.startswith("[") and name.endswith("]") else name)
    except ValueError:
        return False
    return (address.version == 6) == name.startswith("[")


def _is_loaded_by_another_site(scope: Scope) -> bool:
    """Return whether the browser states that another site caused a request, other than by a link to a whole page."""
    sites = _values(scope, b"sec-fetch-site")
    if all(site in ("same-origin", "none") for site in sites):
        return False
    mode, target = _values(scope, b"sec-fetch-mode"), _values(scope, b"sec-fetch-dest")
    return scope.get("method") != "GET" or mode != ["navigate"] or target != ["document"]


def _values(scope: Scope, name: bytes) -> list[str]:
    return [value.decode("latin-1") for key, value in scope["headers"] if key.lower() == name]


def _query(scope: Scope) -> list[tuple[str, str]]:
    return parse_qsl(scope.get("query_string", b"").decode("latin-1"), keep_blank_values=True)


def _cookies(scope: Scope, name: str) -> list[str]:
    """Return the values of a cookie; those of other servers beside it may have any form."""
    pairs = (pair.partition("=") for text in _values(scope, b"cookie") for pair in text.split(";"))
    return [value.strip() for key, _, value in pairs if key.strip() == name]


def _with_headers(send: Send) -> Send:
    async def extended(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            own = {name for name, _ in HEADERS}
            kept = [(name, value) for name, value in message.get("headers", []) if name.lower() not in own]
            message = {**message, "headers": [*kept, *HEADERS]}
        await send(message)

    return extended


async def refuse(scope: Scope, receive: Receive, send: Send, sentence: str, status: int = 403) -> None:
    """Answer a request with a sentence instead of the page, or refuse a websocket."""
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": _POLICY_VIOLATION, "reason": sentence[:100]})
        return
    about = [(b"content-type", b"text/plain; charset=utf-8")]
    await _answer(send, status, about, sentence.encode() + b"\n")


async def _answer(send: Send, status: int, headers: list[tuple[bytes, bytes]], body: bytes = b"") -> None:
    found = [*headers, (b"cache-control", b"no-store"), *HEADERS]
    await send({"type": "http.response.start", "status": status, "headers": found})
    await send({"type": "http.response.body", "body": body})
