"""The instruments of a bench: their drivers, and how they are taken to 0 V."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from electrovib.bench.drivers.hp_33120a import Hp33120a
from electrovib.bench.drivers.tektronix_tds3014b import TektronixTds3014b
from electrovib.bench.link import BenchError, Link
from electrovib.core.errors import ElectrovibError, nearest, refuse

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from electrovib.bench.link import Connection
    from electrovib.bench.settings import BenchSettings, EnableLine


GENERATORS: Final[Mapping[str, type[Hp33120a]]] = {"hp_33120a": Hp33120a}
OSCILLOSCOPES: Final[Mapping[str, type[TektronixTds3014b]]] = {"tektronix_tds3014b": TektronixTds3014b}
"""Drivers by their names in a bench file."""
_ATTEMPTS = 2


def check_drivers(settings: BenchSettings) -> None:
    """Refuse names of drivers that do not exist, with the nearest name."""
    asked = (
        ("generator.driver", settings.generator.driver, GENERATORS),
        ("oscilloscope.driver", settings.oscilloscope.driver, OSCILLOSCOPES),
    )
    problems = [
        f"{path} = '{name}': there is no such driver.{nearest(name, known)}"
        for path, name, known in asked
        if name not in known
    ]
    refuse(problems)


@dataclass(frozen=True, kw_only=True)
class Instruments:
    """Drivers of the instruments of a bench; `enable` is None without an enable line of the amplifier."""

    generator: Hp33120a
    oscilloscope: TektronixTds3014b
    enable: EnableDriver | None

    @classmethod
    def of(cls, settings: BenchSettings, connections: Mapping[str, Connection]) -> Instruments:
        """Make the drivers from connections by role."""
        links = {name: Link(name, connection) for name, connection in connections.items()}
        generator, oscilloscope, line = settings.generator, settings.oscilloscope, settings.amplifier.enable
        return cls(
            generator=GENERATORS[generator.driver](links["generator"], also=generator.accept_model),
            oscilloscope=OSCILLOSCOPES[oscilloscope.driver](
                links["oscilloscope"], also=oscilloscope.accept_model
            ),
            enable=None if line is None else EnableDriver(links["enable line"], line),
        )

    def to_zero(self) -> list[str]:
        """Disable the high voltage and set the generator to 0 V, whatever fails; return what could not be confirmed."""
        failures = []
        if self.enable is not None:
            failures += _attempted(self.enable.disable, "the high voltage is not confirmed as disabled")
        failures += _attempted(self.generator.zero, "0 V at the generator is not confirmed")
        return failures

    def close(self) -> None:
        """End the connections."""
        self.generator.link.close()
        self.oscilloscope.link.close()
        if self.enable is not None:
            self.enable.link.close()


def _attempted(work: Callable[[], None], what: str) -> list[str]:
    """Try a command a few times; return what failed."""
    last: BaseException | None = None
    for _ in range(_ATTEMPTS):
        try:
            work()
        except BaseException as error:  # noqa: BLE001  # nothing may keep the next command from being sent
            last = error
        else:
            return []
    why = str(last) if isinstance(last, ElectrovibError) else f"{type(last).__name__}: {last}"
    return [f"{what}: {why}"]


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
