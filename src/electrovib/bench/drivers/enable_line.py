"""Driver of an enable line that is switched by commands declared in the bench file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from electrovib.bench.faults import BenchError

if TYPE_CHECKING:
    from electrovib.bench.link import Link
    from electrovib.bench.settings import EnableLine


class EnableDriver:
    """Enables and disables the high voltage by the commands of the bench file, and reads the state back."""

    def __init__(self, link: Link, line: EnableLine) -> None:
        self.link = link
        self._line = line

    def enable(self) -> None:
        """Enable the high voltage, and refuse a line that does not read back as enabled."""
        self._switch(self._line.on, self._line.enabled, "enabled")

    def disable(self) -> None:
        """Disable the high voltage, and refuse a line that does not read back as disabled."""
        self._switch(self._line.off, self._line.disabled, "disabled")

    def confirm(self) -> None:
        """Read the state back without a change, and refuse a line that does not read back as enabled."""
        self._expect(self._line.enabled, "enabled", "while the high voltage was on")

    def _switch(self, command: str, wanted: str, state: str) -> None:
        self.link.write(command)
        self._expect(wanted, state, f"after '{command}'")

    def _expect(self, wanted: str, state: str, when: str) -> None:
        reply = self.link.ask(self._line.state)
        if reply != wanted:
            raise BenchError(
                f"the enable line answered '{reply[:60]}' to '{self._line.state}' {when}, where '{wanted}' was expected: it is"
                f" not known to be {state}"
            )
