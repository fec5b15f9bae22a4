"""The port of the page."""

from __future__ import annotations

import errno
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Final

from electrovib.core.errors import InputError

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
    why = (
        "another program listens there"
        if reason.errno == errno.EADDRINUSE
        else reason.strerror or str(reason)
    )
    raise InputError(
        f"port = {port}: it cannot be opened at {host} ({why}); choose another with --port, or omit --port for one that is free"
    )


def _opened(host: str, port: int) -> list[socket.socket]:
    """Return a listening socket for each address of a host; an address that this machine does not have is left out."""
    found: list[socket.socket] = []
    missing: OSError | None = None
    for family, kind, protocol, _, address in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM):
        try:
            found.append(_listening_at(family, kind, protocol, address))
        except OSError as error:
            if error.errno not in (errno.EADDRNOTAVAIL, errno.EAFNOSUPPORT):
                close(found)
                raise
            missing = error
    if missing is not None and not found:
        raise missing
    return found


def _listening_at(family: int, kind: int, protocol: int, address: Any) -> socket.socket:
    found = socket.socket(family, kind, protocol)
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if family == socket.AF_INET6:
            found.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
        found.bind(address)
        found.listen()  # until one of them listens, two sockets can be bound to the same port
    except OSError:
        found.close()
        raise
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
