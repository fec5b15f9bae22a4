"""Drivers of instruments, one file for each maker and model; a driver refuses every other model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from electrovib.bench.drivers.enable_line import EnableDriver
from electrovib.bench.drivers.hp_33120a import Hp33120a
from electrovib.bench.drivers.tektronix_tds3014b import TektronixTds3014b
from electrovib.core.errors import InputError, nearest

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.bench.link import Link
    from electrovib.bench.settings import BenchSettings

GENERATORS: Final[Mapping[str, type[Hp33120a]]] = {"hp_33120a": Hp33120a}
OSCILLOSCOPES: Final[Mapping[str, type[TektronixTds3014b]]] = {"tektronix_tds3014b": TektronixTds3014b}


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
    if problems:
        raise InputError(problems)


def generator_of(settings: BenchSettings, link: Link) -> Hp33120a:
    """Return the driver of the generator."""
    return GENERATORS[settings.generator.driver](link, also=settings.generator.accept_model)


def oscilloscope_of(settings: BenchSettings, link: Link) -> TektronixTds3014b:
    """Return the driver of the oscilloscope."""
    return OSCILLOSCOPES[settings.oscilloscope.driver](link, also=settings.oscilloscope.accept_model)


def enable_of(settings: BenchSettings, link: Link | None) -> EnableDriver | None:
    """Return the driver of the enable line; None without one."""
    line = settings.amplifier.enable
    return None if line is None or link is None else EnableDriver(link, line)
