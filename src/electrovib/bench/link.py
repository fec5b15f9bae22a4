"""Messages between the program and one instrument, by VISA or a socket, IEEE 488.2 blocks included; and the clock of a bench."""

from __future__ import annotations

import functools
import re
import socket
import time
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any, Final, NoReturn, Protocol, TypeVar

from electrovib.core.errors import LONGEST_QUOTED, ElectrovibError, InputError, printable, shortened
from electrovib.data.readers.isf import block_at

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Mapping


class BenchClock(Protocol):
    """A clock that can be read and waited for."""

    def now(self) -> float:
        """Return the time [s] since any fixed instant."""

    def sleep(self, duration: float) -> None:
        """Wait for a duration [s]."""


class SystemClock:
    """The clock of the system."""

    def now(self) -> float:
        """Return the time [s] since any fixed instant."""
        return time.monotonic()

    def sleep(self, duration: float) -> None:
        """Wait for a duration [s]."""
        time.sleep(duration)


class SimulatedClock:
    """A clock that advances only in `sleep`."""

    def __init__(self) -> None:
        self._now = 0.0

    def now(self) -> float:
        """Return the time [s] since its beginning."""
        return self._now

    def sleep(self, duration: float) -> None:
        """Advance by a duration [s]."""
        self._now += max(duration, 0.0)


class BenchError(ElectrovibError):
    """A run on a bench that was stopped, with the instrument, the reason and the state in which the bench was left."""


class BenchStopped(BaseException):  # a signal, not a mistake: no handler of Exception may stop it
    """A signal that asks the process to end."""


T = TypeVar("T")
_NO_BLOCK: Final = {
    rb"#0": ", not one of indefinite length (#0), whose end no byte tells; set the instrument to definite length",
    rb"[^#]{1,80}#": ": it stands behind other text; switch headers off (HEADER OFF)",
}
"""Beginnings of replies that hold a block and are none, with what is done about it."""


class Connection(Protocol):
    """A connection that carries whole messages; TimeoutError and OSError are its failures."""

    def send(self, message: bytes) -> None:
        """Send one message, without its terminator."""

    def receive(self) -> bytes:
        """Return one reply, without its terminator unless it is a block; TimeoutError where none comes."""

    def close(self) -> None:
        """End the connection."""


class Link:
    """The connection to one instrument, whose failures become sentences that name it by its role."""

    def __init__(self, name: str, connection: Connection) -> None:
        self.name = name
        self._connection = connection

    def write(self, *commands: str) -> None:
        """Send commands, one after the other."""
        for command in commands:
            self._guarded(command, functools.partial(self._connection.send, command.encode("ascii")))

    def write_block(self, command: str, data: bytes) -> None:
        """Send a command that ends with a definite-length block, ``#<digits><length><data>``."""
        length = str(len(data))
        block = f"{command}#{len(length)}{length}".encode("ascii") + data
        self._guarded(command, lambda: self._connection.send(block))

    def ask(self, query: str) -> str:
        """Send a query and return its reply as text."""
        reply = self._exchange(query)
        try:
            return reply.decode("ascii").strip()
        except UnicodeDecodeError:
            self._refuse(query, "answered with bytes that are no text")

    def answers(self, queries: Iterable[str]) -> dict[str, str]:
        """Return the reply to each query."""
        return {query: self.ask(query) for query in queries}

    def identify(self, models: Collection[str], also: str, setting: str) -> str:
        """Ask for maker and model, and refuse a model that the driver was not written for.

        `models` are those of the driver, as the second field of the reply to ``*IDN?``; `also` is a further one
        that the user has named, empty for none, and `setting` the dotted path of the setting that names it. The
        whole reply is returned.
        """
        reply = self.ask("*IDN?")
        _, _, rest = reply.partition(",")
        model = rest.partition(",")[0].strip()
        known = {name.upper().replace(" ", "") for name in (*models, *([also] if also else []))}
        if model.upper().replace(" ", "") not in known:
            raise BenchError(
                f"the {self.name} states '{reply[:80]}', which is not the model of this driver ({', '.join(models)}); to use"
                f' it with this driver on your own judgement, set {setting} = "{model or reply[:20]}"'
            )
        return reply

    def ask_number(self, query: str) -> float:
        """Send a query and return its reply as a number."""
        reply = self.ask(query)
        try:
            return float(reply)
        except ValueError:
            self._refuse(query, f"answered '{_quoted(reply)}', where a number was expected")

    def ask_block(self, query: str) -> bytes:
        """Send a query and return the data of the block that answers it.

        A reply is refused that is no block, or holds fewer or more bytes than it states.
        """
        reply = self._exchange(query)
        block = block_at(reply)
        if block is None:
            why = next((hint for form, hint in _NO_BLOCK.items() if re.match(form, reply)), "")
            self._refuse(
                query, f"answered '{_quoted(repr(reply[:20]))}', where a binary block was expected{why}"
            )
        first, length = block
        data, rest = reply[first : first + length], reply[first + length :]
        if len(data) < length or rest not in (b"", b"\n", b"\r\n"):
            how = "it is truncated" if len(data) < length else "they are no single block"
            self._refuse(query, f"announced a block of {length} bytes and sent {len(data + rest)}: {how}")
        return data

    def close(self) -> None:
        """End the connection; what fails here changes nothing."""
        try:
            self._connection.close()
        except Exception:  # noqa: BLE001  # a library of a maker may raise anything
            return

    def _exchange(self, query: str) -> bytes:
        def both() -> bytes:
            self._connection.send(query.encode("ascii"))
            return self._connection.receive()

        return self._guarded(query, both)

    def _guarded(self, command: str, work: Callable[[], T]) -> T:
        try:
            return work()
        except TimeoutError:
            self._refuse(command, "gave no answer in time")
        except OSError as error:
            why = error.strerror or str(error) or type(error).__name__
            self._refuse(command, f"is no longer connected ({why})")

    def _refuse(self, command: str, why: str) -> NoReturn:
        raise BenchError(f"the {self.name} {why}, after '{_quoted(command)}'") from None


def _quoted(text: str) -> str:
    return shortened(printable(text), LONGEST_QUOTED)


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
    with ExitStack() as made:
        for role, address in resources.items():
            try:
                found[role] = _open(address)
            except (OSError, ValueError) as error:
                raise BenchError(f"the {role} at '{address}' cannot be reached: {error}") from None
            made.callback(found[role].close)
        made.pop_all()
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
        return first + digits + length + self._file.read(int(length)) + self._file.readline(_LONGEST)

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
        return reply if reply.startswith(b"#") else reply.removesuffix(b"\n").removesuffix(b"\r")

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
