"""Who may talk to the page: checks of every HTTP request and every websocket."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any, Final

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

LOOPBACK: Final = ("127.0.0.1", "localhost", "[::1]")
"""Names of this machine as a browser writes them."""
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


class AccessControl:
    """Checks in front of an ASGI application: of the host and of the origin.

    A page of another site in the same browser can send requests to this one, and can open a websocket. The
    browser states where they come from in ``Origin`` and ``Sec-Fetch-Site``, and by which name this server
    was addressed in ``Host`` (which a hostile name server can point here). All are compared with the names of
    this page in every scope. A websocket without ``Origin`` is refused, because every browser sends one.
    Another site may link to the page, but may neither embed it nor load anything from it. Headers of proxies
    are removed.
    """

    def __init__(self, app: App, *, port: int) -> None:
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
        hosts, origins = _values(scope, b"host"), _values(scope, b"origin")
        if len(hosts) != 1 or hosts[0].lower() not in self._hosts:
            known = ", ".join(sorted(self._hosts))
            return f"This page is not served under this name. It is served under {known}."
        if len(origins) > 1 or (scope["type"] == "websocket" and not origins):
            return "A connection has to state the one page from which it comes (header Origin)."
        if origins and origins[0].lower() != f"http://{hosts[0].lower()}":
            return "A page of another site may not talk to this one."
        if _is_loaded_by_another_site(scope):
            return "A page of another site may link to this one, but may load nothing from it."
        return ""


def _is_loaded_by_another_site(scope: Scope) -> bool:
    """Return whether the browser states that another site caused a request, other than by a link to a whole page."""
    sites = _values(scope, b"sec-fetch-site")
    if all(site in ("same-origin", "none") for site in sites):
        return False
    mode, target = _values(scope, b"sec-fetch-mode"), _values(scope, b"sec-fetch-dest")
    return scope.get("method") != "GET" or mode != ["navigate"] or target != ["document"]


def _values(scope: Scope, name: bytes) -> list[str]:
    return [value.decode("latin-1") for key, value in scope["headers"] if key.lower() == name]


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
    headers = [
        (b"content-type", b"text/plain; charset=utf-8"), (b"cache-control", b"no-store"), *HEADERS,
    ]  # fmt: skip
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": sentence.encode() + b"\n"})
