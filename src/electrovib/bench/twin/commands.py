"""Commands of SCPI: headers in their short and long forms, and the queue of messages of a simulated instrument."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

NO_ERROR = '+0,"No error"'
UNDEFINED = '-113,"Undefined header"'
SETTINGS_CONFLICT = '-221,"Settings conflict"'
OUT_OF_RANGE = '-222,"Data out of range"'
TRIGGER_IGNORED = '-211,"Trigger ignored"'


def matches(pattern: str, header: str) -> bool:
    """Return whether each part of a header, as sent without question mark, is the short or the long form of a command.

    The pattern has the letters of the short form in capitals: ``"VOLTage:OFFSet"``.
    """
    parts, given = pattern.split(":"), header.upper().split(":")
    return len(parts) == len(given) and all(
        part in (_short(wanted), wanted.upper()) for part, wanted in zip(given, parts, strict=True)
    )


def _short(word: str) -> str:
    return "".join(sign for sign in word if not sign.islower())


def is_on(text: str) -> bool:
    """Return whether an argument switches on."""
    return text.upper() in ("ON", "1")


class TwinInstrument:
    """A simulated instrument: takes messages, and keeps its replies until they are fetched."""

    def __init__(self, identity: str) -> None:
        self.identity = identity
        self.received: list[str] = []
        """Commands in the order in which they came."""
        self.errors: list[str] = []
        self._replies: list[bytes] = []
        self.values: dict[str, Any] = {}
        """Settings that are held, by their headers."""
        self._commands: dict[str, Callable[[str], object]] = {}
        self._queries: dict[str, Callable[[str], str | bytes]] = {"*IDN": lambda _: self.identity}

    def hold(
        self, header: str, value: Any, read: Callable[[str], Any], state: Callable[[Any], str] = str
    ) -> None:
        """Hold a setting that a command sets, as it is read, and a query states."""
        self.values[header] = value
        self._commands[header] = lambda text: self.values.update({header: read(text)})
        self._queries[header] = lambda _: state(self.values[header])

    def send(self, message: bytes) -> None:
        """Take one message: commands separated by semicolons, or one command with a binary block."""
        if b"#" in message:
            head, _, block = message.partition(b"#")
            self.received.append(head.decode("ascii").strip())
            self.take_block(head.decode("ascii").strip(), b"#" + block)
            return
        for part in message.decode("ascii").split(";"):
            command = part.strip().removeprefix(":")
            if command:
                self.received.append(command)
                self._take(command)

    def receive(self) -> bytes:
        """Return the oldest reply; TimeoutError where there is none."""
        if not self._replies:
            raise TimeoutError
        return self._replies.pop(0)

    def close(self) -> None:
        """End the connection."""

    def take_block(self, command: str, block: bytes) -> None:
        """Take a command with a block; none is known unless an instrument defines one."""
        del command, block
        self.errors.append(UNDEFINED)

    def _take(self, command: str) -> None:
        header, _, argument = command.partition(" ")
        header = re.sub(r"^SOUR(CE)?:", "", header, flags=re.IGNORECASE)
        is_query = header.endswith("?")
        known: dict[str, Callable[[str], Any]] = {**(self._queries if is_query else self._commands)}
        work = next((known[each] for each in known if matches(each, header.removesuffix("?"))), None)
        if work is None:
            self.errors.append(UNDEFINED)
            return
        found = work(argument.strip())
        if is_query:
            self._replies.append(found if isinstance(found, bytes) else found.encode("ascii"))

    def next_error(self, argument: str) -> str:
        """Return and remove the oldest error."""
        del argument
        return self.errors.pop(0) if self.errors else NO_ERROR
