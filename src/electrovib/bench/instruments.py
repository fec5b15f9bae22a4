"""The instruments of a bench: their drivers, and how they are taken to 0 V."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from electrovib.bench.drivers import enable_of, generator_of, oscilloscope_of
from electrovib.bench.link import Link
from electrovib.core.errors import ElectrovibError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from electrovib.bench.drivers.enable_line import EnableDriver
    from electrovib.bench.drivers.hp_33120a import Hp33120a
    from electrovib.bench.drivers.tektronix_tds3014b import TektronixTds3014b
    from electrovib.bench.link import Connection
    from electrovib.bench.settings import BenchSettings

_ATTEMPTS = 2


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
        return cls(
            generator=generator_of(settings, links["generator"]),
            oscilloscope=oscilloscope_of(settings, links["oscilloscope"]),
            enable=enable_of(settings, links.get("enable line")),
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
