"""Connections to real instruments: by VISA, or by a plain socket."""

from __future__ import annotations

import re
import socket
from typing import TYPE_CHECKING, Any, Final

from electrovib.bench.faults import BenchError
from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.bench.link import Connection

_SOCKET: Final = re.compile(r"TCPIP\d*::([^:]+)::(\d+)::SOCKET", re.IGNORECASE)
TIMEOUT: Final = 5.0
"""Time within which an instrument has to answer [s]."""
_LONGEST: Final = 1 << 20


def connect(resources: Mapping[str, str]) -> dict[str, Connection]:
    """Connect to the instruments, each by its role and address.

    If one cannot be reached, the connections made before are closed.
    """
    missing = [role for role, address in resources.items() if not address]
    if missing:
        raise InputError(
            f"{role.replace(' ', '_')}.resource: the bench file states no address of the {role}; add, for instance,"
            ' resource = "GPIB0::10::INSTR"'
            for role in missing
        )
    found: dict[str, Connection] = {}
    try:
        for role, address in resources.items():
            try:
                found[role] = _open(address)
            except (OSError, ValueError) as error:
                raise BenchError(f"the {role} at '{address}' cannot be reached: {error}") from None
    except BaseException:
        for connection in found.values():
            connection.close()
        raise
    return found


def _open(address: str) -> Connection:
    if match := _SOCKET.fullmatch(address):
        return SocketConnection(match.group(1), int(match.group(2)))
    return VisaConnection(address)


class SocketConnection:
    """A connection by TCP, with messages that end with a line feed."""

    def __init__(self, host: str, port: int) -> None:
        self._socket = socket.create_connection((host, port), timeout=TIMEOUT)
        self._file = self._socket.makefile("rb")

    def send(self, message: bytes) -> None:
        """Send one message."""
        self._socket.sendall(message + b"\n")

    def receive(self) -> bytes:
        """Return one reply: a line, or a binary block."""
        first = self._read(1)
        if first != b"#":
            line = first + self._file.readline(_LONGEST)
            if not line.endswith(b"\n"):
                raise ConnectionError("the connection was closed")
            return line.rstrip(b"\r\n")
        digits = self._read(1)
        length = self._read(int(digits)) if digits.isdigit() else b""
        if not length.isdigit() or int(length) > _LONGEST:
            return first + digits + length
        data = self._file.read(int(length) + 1)
        return (
            first + digits + length + data.removesuffix(b"\n")
            if len(data) > int(length)
            else (first + digits + length + data)
        )

    def close(self) -> None:
        """End the connection."""
        self._file.close()
        self._socket.close()

    def _read(self, count: int) -> bytes:
        found = self._file.read(count)
        if len(found) < count:
            raise ConnectionError("the connection was closed")
        return found


class VisaConnection:
    """A connection by VISA (GPIB, RS-232, LXI, USB) to a resource; needs pyvisa."""

    def __init__(self, address: str) -> None:
        try:
            import pyvisa
        except ImportError:
            raise InputError(
                f"'{address}' is reached by VISA, which needs pyvisa: pip install 'electrovib[bench]'"
            ) from None
        self._timeout = pyvisa.constants.StatusCode.error_timeout
        self._error = pyvisa.errors.VisaIOError
        self._resource: Any = pyvisa.ResourceManager().open_resource(address, timeout=int(1000 * TIMEOUT))

    def send(self, message: bytes) -> None:
        """Send one message."""
        self._guarded(lambda: self._resource.write_raw(message + b"\n"))

    def receive(self) -> bytes:
        """Return one reply."""
        reply: bytes = self._guarded(self._resource.read_raw)
        return (
            reply.removesuffix(b"\n").removesuffix(b"\r")
            if not reply.startswith(b"#")
            else reply[: _end(reply)]
        )

    def close(self) -> None:
        """End the connection."""
        self._guarded(self._resource.close)

    def _guarded(self, work: Any) -> Any:
        try:
            return work()
        except self._error as error:
            if error.error_code == self._timeout:
                raise TimeoutError from None
            raise ConnectionError(str(error)) from None


def _end(reply: bytes) -> int:
    """Return the length of a block without the terminator that follows it."""
    digits = reply[1:2]
    length = reply[2 : 2 + int(digits)] if digits.isdigit() else b""
    return 2 + len(length) + int(length) if length.isdigit() else len(reply)
