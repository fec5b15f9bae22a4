"""Messages between the program and one instrument: commands, replies, and IEEE 488.2 binary blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING, NoReturn, Protocol, TypeVar

from electrovib.bench.faults import BenchError
from electrovib.core.errors import LONGEST_QUOTED, printable, shortened

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable

T = TypeVar("T")


class Connection(Protocol):
    """A connection that carries whole messages; TimeoutError and OSError are its failures."""

    def send(self, message: bytes) -> None:
        """Send one message, without its terminator."""

    def receive(self) -> bytes:
        """Return one reply, without its terminator; TimeoutError where none comes."""

    def close(self) -> None:
        """End the connection."""


class Link:
    """The connection to one instrument, whose failures become sentences that name it by its role."""

    def __init__(self, name: str, connection: Connection) -> None:
        self.name = name
        self._connection = connection

    def write(self, command: str) -> None:
        """Send a command."""
        self._guarded(command, lambda: self._connection.send(command.encode("ascii")))

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
        digits = reply[1:2]
        if reply[:1] != b"#" or not digits.isdigit() or digits == b"0":
            self._refuse(query, f"answered '{_quoted(repr(reply[:20]))}', where a binary block was expected")
        count = int(digits)
        stated = reply[2 : 2 + count]
        if len(stated) < count or not stated.isdigit():
            self._refuse(query, "answered with a block whose length is cut off")
        data = reply[2 + count :]
        if len(data) != int(stated):
            self._refuse(
                query, f"announced a block of {int(stated)} bytes and sent {len(data)}: it is truncated"
            )
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
