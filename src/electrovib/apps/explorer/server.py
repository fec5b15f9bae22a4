"""The server of the page: what it takes, how many pages are open, how it starts and ends."""

from __future__ import annotations

import errno
import gc
import logging
import signal
import socket
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from contextlib import ExitStack, contextmanager
from types import FrameType
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import parse_qs

from electrovib.apps.explorer.access import LOOPBACK, TOKEN, AccessControl, is_loopback, new_token, refuse
from electrovib.apps.explorer.limits import LARGEST_MESSAGE, LARGEST_REQUEST, MOST_CONNECTIONS, MOST_PAGES
from electrovib.apps.explorer.runner import SERVER_ENDS
from electrovib.core.errors import InputError
from electrovib.scenario import DEFAULT, Scenario, Source, read_scenario

if TYPE_CHECKING:
    from electrovib.apps.explorer.access import App, Receive, Scope, Send

HISTORY: Final = 20
"""Messages that are kept for a browser whose connection is interrupted; each can hold the plots of the page."""
EVERYWHERE: Final = ("0.0.0.0", "::")  # noqa: S104 - compared with
"""Addresses of a server on all interfaces."""
UNCONNECTED: Final = 15.0
"""Seconds for which a page is kept that no browser is connected with, as long as the server is not full: a busy machine or
network may interrupt for some."""
YOURS: Final = "yours"
"""Name of a scenario that is no paper's."""


def explore(
    scenario: Source = DEFAULT,
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    port: int | None = None,
    host: str = "127.0.0.1",
    browser: bool = True,
    say: Callable[[str], None] = print,
) -> None:
    """Open a page in the browser in which the parameters of a scenario are changed and their effect is seen.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        What the page shows first, as for `electrovib.load`.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario.
    port : int, optional
        Port of the page; by default the first that is free from 8080 on.
    host : str
        Address at which the page is served. Any other than 127.0.0.1 or localhost can be reached from other machines: the
        page then needs a token, which is part of the address that is printed.
    browser : bool
        Whether a browser is opened.
    say : callable
        Called with the address of the page.

    Raises
    ------
    InputError
        For a scenario that is not valid, a port that is in use, or a page whose packages are not installed.

    Notes
    -----
    The function returns when the page is ended, by Ctrl-C. No request reads or writes a file of this machine, and what a
    visitor can ask for is limited (`electrovib.apps.explorer.limits`).
    """
    try:
        from nicegui import app, ui
    except ImportError:
        raise InputError("the page needs the extra 'explore': pip install 'electrovib[explore]'") from None
    from electrovib.apps.explorer.page import build

    host = host.strip().removeprefix("[").removesuffix("]")
    own, first = _first(scenario, set)
    chosen, sockets = listening(host, port)
    token = "" if is_loopback(host) else new_token()
    path = f"/?{TOKEN}={token}" if token else "/"
    address = f"http://{_names(host)[0]}:{chosen}{path}"
    with served_on(sockets), _orderly_end():
        _guard(app, host, chosen, token)
        _import_all()
        SERVER_ENDS.clear()
        build(own, first)
        app.on_startup(lambda: say(f"The page is at {address} ; Ctrl-C ends it."))
        ui.run(
            host=host,
            port=chosen,
            title="electrovib explorer",
            reload=False,
            language="en-US",
            show=path if browser else False,
            show_welcome_message=False,
            message_history_length=HISTORY,
            reconnect_timeout=UNCONNECTED,
            dark=None,
            favicon="〰",
            proxy_headers=False,
            ws_max_size=LARGEST_MESSAGE,
            ws_per_message_deflate=False,  # takes longer than to draw the plots, and saves nothing on this machine
        )


@contextmanager
def _orderly_end() -> Iterator[None]:
    """Let SIGTERM end the process by an exit of Python, at which the folders of files that are read are removed."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def end(number: int, _: FrameType | None) -> None:
        gc.freeze()  # else Python looks through all that visitors have left, several times, before it ends
        sys.exit(128 + number)

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _guard(app: Any, host: str, port: int, token: str) -> None:
    """Put the checks in front of everything else that the framework puts in front of its pages."""
    from nicegui import Client, core

    from electrovib.apps.explorer.frames import Frames, check_events, is_kept

    def put_last(client: Client) -> None:
        if client.id in Client.instances:
            Client.instances[client.id] = Client.instances.pop(client.id)

    app.on_disconnect(put_last)
    handlers = core.sio.handlers["/"]
    check_events(handlers)
    # by requests of HTTP, sessions would be opened that no connection limits
    core.sio.eio.transports = ["websocket"]
    inner = app.build_middleware_stack
    names = LOOPBACK if is_loopback(host) else (*LOOPBACK, *_names(host))

    def stack() -> AccessControl:
        limited = RequestLimits(Frames(inner(), events=handlers), pages=Client.instances)
        return AccessControl(limited, hosts=names, port=port, token=token, any_address=host in EVERYWHERE)

    app.build_middleware_stack = stack
    logging.getLogger("nicegui").addFilter(is_kept)


def _first(scenario: Source, changes: Mapping[str, Any] | None) -> tuple[dict[str, Scenario], str]:
    """Return the scenarios that are not shipped, by name, and the name of the first one."""
    from electrovib.apps.explorer.state import presets

    if isinstance(scenario, str) and scenario in presets() and not changes:
        return {}, scenario
    return {YOURS: read_scenario(scenario, changes=changes)}, YOURS


def _import_all() -> None:
    """Import what the page computes with, before several threads do so at the same time."""
    import xarray  # noqa: F401 - imported for the threads

    import electrovib.apps.fit
    import electrovib.studies.check
    import electrovib.studies.perceive
    import electrovib.studies.population
    import electrovib.view.report  # noqa: F401 - as above


def _names(host: str) -> tuple[str, ...]:
    """Return the names under which a browser addresses this machine."""
    if host in EVERYWHERE:
        name = socket.gethostname()
        try:
            found = {str(entry[4][0]) for entry in socket.getaddrinfo(name, None, socket.AF_INET)}
        except OSError:
            found = set()
        return (name.lower(), *sorted(found))
    return (f"[{host}]" if ":" in host else host.lower(),)


FIRST_PORT: Final = 8080
"""Port that is tried first."""
TRIED_PORTS: Final = 50


def listening(host: str, port: int | None) -> tuple[int, list[socket.socket]]:
    """Take a port, without a number the first from `FIRST_PORT` on that nothing else listens on, and return its sockets.

    There is one for each address of the host; they listen from now on, so that no other program can take the
    port.
    """
    if not host:
        raise InputError(
            "host is empty: give an address, for instance 127.0.0.1, or 0.0.0.0 for all interfaces"
        )
    candidates = [port] if port is not None else range(FIRST_PORT, FIRST_PORT + TRIED_PORTS)
    for each in candidates:
        if not 1 <= each <= 65535:
            raise InputError(f"port = {each}: a port is a number from 1 to 65535")
        try:
            return each, _opened(host, each)
        except (socket.gaierror, UnicodeError):
            raise InputError(f"host = {host}: no address of this machine has this name") from None
        except PermissionError:
            raise InputError(f"port = {each}: this user may not open it; take one above 1023") from None
        except OSError as error:
            reason = error
    if port is None:
        raise InputError(
            f"no port from {FIRST_PORT} to {FIRST_PORT + TRIED_PORTS - 1} can be opened at {host}: {reason}"
        )
    in_use, reached = "another program listens there", reason.strerror or str(reason)
    why = in_use if reason.errno == errno.EADDRINUSE else reached.partition(" (")[0]
    raise InputError(
        f"port = {port}: it cannot be opened at {host} ({why}); choose another with --port, or omit --port for one that is free"
    )


def _opened(host: str, port: int) -> list[socket.socket]:
    """Return a listening socket for each address of a host; an address that this machine does not have is left out."""
    found: list[socket.socket] = []
    missing: OSError | None = None
    for family, *_, address in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM):
        try:
            found.append(socket.create_server(address, family=family))
        except OSError as error:
            if error.errno not in (errno.EADDRNOTAVAIL, errno.EAFNOSUPPORT):
                close(found)
                raise
            missing = error
    if missing is not None and not found:
        raise missing
    return found


def close(sockets: list[socket.socket]) -> None:
    """Close sockets."""
    for each in sockets:
        each.close()


@contextmanager
def served_on(sockets: list[socket.socket]) -> Iterator[None]:
    """Let the framework serve on sockets that listen already, and close them at the end.

    By itself the framework opens its port only after everything is imported, when another server may have
    taken it.
    """
    from nicegui.server import Server

    run = Server.run

    def run_on_sockets(self: Server, _: list[socket.socket] | None = None) -> None:
        run(self, sockets)

    Server.run = run_on_sockets  # type: ignore[assignment, method-assign]
    try:
        yield
    finally:
        Server.run = run  # type: ignore[method-assign]
        close(sockets)


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
        self._coming = 0

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
            await refuse(scope, receive, send, f"{MOST_CONNECTIONS} connections are open already.")
            return
        self._connections[page] += 1
        try:
            await self._app(scope, receive, send)
        finally:
            self._connections -= Counter([page])

    async def _open(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Open a page; one that is being made counts until its answer begins, when it exists."""
        if has_room(self._pages, self._coming):
            with ExitStack() as coming:
                self._coming += 1
                coming.callback(self._came)
                await self._answer(scope, receive, send, coming.close)
            return
        full = (
            f"This server has {MOST_PAGES} pages open, which is as many as it shows at once."
            " Close one and load this address again after some seconds."
        )
        await refuse(scope, receive, send, full, 503)

    def _came(self) -> None:
        self._coming -= 1

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
        self._scope, self._receive, self._send, self._begins = scope, receive, send, begins
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
            too_large = f"This request is too large; a page takes {LARGEST_REQUEST / 1e6:g} MB at most."
            await refuse(self._scope, self._receive, self._send, too_large, 413)
