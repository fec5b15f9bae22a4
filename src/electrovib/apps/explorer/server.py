"""The server of the page: what it takes, how it starts and ends."""

from __future__ import annotations

import errno
import gc
import logging
import signal
import socket
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import FrameType
from typing import Any, Final

from electrovib.apps.explorer.runner import LARGEST_MESSAGE, LOOPBACK, SERVER_ENDS
from electrovib.core.errors import InputError
from electrovib.scenario import DEFAULT, Scenario, Source, read_scenario

HISTORY: Final = 20
"""Messages that are kept for a browser whose connection is interrupted; each can hold the plots of the page."""
UNCONNECTED: Final = 15.0
"""Seconds for which a page is kept that no browser is connected with: a busy machine may interrupt for some."""
YOURS: Final = "yours"
"""Name of a scenario that is no paper's."""


def explore(
    scenario: Source = DEFAULT,
    *,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    port: int | None = None,
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
    The function returns when the page is ended, by Ctrl-C. The page is served on 127.0.0.1, which no other machine reaches; no
    request reads or writes a file of this machine, and what can be asked for is limited (`electrovib.apps.explorer.runner`).
    """
    try:
        from nicegui import app, ui
    except ImportError:
        raise InputError("the page needs the extra 'explore': pip install 'electrovib[explore]'") from None
    from electrovib.apps.explorer.page import build

    own, first = _first(scenario, set)
    chosen, listener = listening(port)
    with served_on(listener), _orderly_end():
        _guard(app, chosen)
        _import_all()
        SERVER_ENDS.clear()
        build(own, first)
        app.on_startup(lambda: say(f"The page is at http://{LOOPBACK[0]}:{chosen}/ ; Ctrl-C ends it."))
        ui.run(
            host=LOOPBACK[0],
            port=chosen,
            title="electrovib explorer",
            reload=False,
            language="en-US",
            show=browser,
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
        gc.freeze()  # else Python looks through all that pages have left, several times, before it ends
        sys.exit(128 + number)

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _guard(app: Any, port: int) -> None:
    """Put the checks in front of everything else that the framework puts in front of its pages."""
    from nicegui import core

    from electrovib.apps.explorer.access import AccessControl, Frames, RequestLimits, check_events, is_kept

    handlers = core.sio.handlers["/"]
    check_events(handlers)
    # by requests of HTTP, messages would come that nothing checks
    core.sio.eio.transports = ["websocket"]
    inner = app.build_middleware_stack
    app.build_middleware_stack = lambda: AccessControl(
        RequestLimits(Frames(inner(), events=handlers)), port=port
    )
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


FIRST_PORT: Final = 8080
"""Port that is tried first."""
TRIED_PORTS: Final = 50


def listening(port: int | None) -> tuple[int, socket.socket]:
    """Take a port, without a number the first from `FIRST_PORT` on that nothing else listens on, and return its socket.

    It listens from now on, so that no other program can take the port.
    """
    candidates = [port] if port is not None else range(FIRST_PORT, FIRST_PORT + TRIED_PORTS)
    for each in candidates:
        if not 1 <= each <= 65535:
            raise InputError(f"port = {each}: a port is a number from 1 to 65535")
        try:
            return each, socket.create_server((LOOPBACK[0], each))
        except PermissionError:
            raise InputError(f"port = {each}: this user may not open it; take one above 1023") from None
        except OSError as error:
            reason = error
    if port is None:
        last = FIRST_PORT + TRIED_PORTS - 1
        raise InputError(f"no port from {FIRST_PORT} to {last} can be opened: {reason}")
    in_use, reached = "another program listens there", reason.strerror or str(reason)
    why = in_use if reason.errno == errno.EADDRINUSE else reached.partition(" (")[0]
    raise InputError(
        f"port = {port}: it cannot be opened ({why}); choose another with --port, or omit --port for one that is free"
    )


@contextmanager
def served_on(listener: socket.socket) -> Iterator[None]:
    """Let the framework serve on a socket that listens already, and close it at the end.

    By itself the framework opens its port only after everything is imported, when another server may have
    taken it.
    """
    from nicegui.server import Server

    run = Server.run

    def run_on_socket(self: Server, _: list[socket.socket] | None = None) -> None:
        run(self, [listener])

    Server.run = run_on_socket  # type: ignore[assignment, method-assign]
    try:
        yield
    finally:
        Server.run = run  # type: ignore[method-assign]
        listener.close()
