"""A simulated bench put together: instruments, amplifier and finger on one clock."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.bench.clock import SimulatedClock
from electrovib.bench.twin.enable import TwinEnable
from electrovib.bench.twin.generator import TwinGenerator
from electrovib.bench.twin.oscilloscope import TwinOscilloscope
from electrovib.bench.twin.plant import TwinPlant

if TYPE_CHECKING:
    from electrovib.bench.clock import BenchClock
    from electrovib.bench.settings import BenchSettings
    from electrovib.bench.twin.commands import TwinInstrument
    from electrovib.scenario import Scenario


class SimulatedBench:
    """Simulated instruments of a bench file, with a finger.

    The `clock` is by default simulated time, which passes only while the program waits.
    """

    def __init__(
        self, settings: BenchSettings, finger: Scenario, *, seed: int, clock: BenchClock | None = None
    ) -> None:
        self.clock: BenchClock = SimulatedClock() if clock is None else clock
        self.generator = TwinGenerator(self.clock)
        self.plant = TwinPlant(settings, finger, self.generator, seed=seed)
        self.oscilloscope = TwinOscilloscope(self.clock, self.plant)
        self.generator.on_trigger.append(self.oscilloscope.synchronise)
        line = settings.amplifier.enable
        self.enable = None if line is None else TwinEnable(self.clock, self.plant, line)

    @property
    def connections(self) -> dict[str, TwinInstrument]:
        """The instruments by role."""
        found: dict[str, TwinInstrument] = {"generator": self.generator, "oscilloscope": self.oscilloscope}
        return found if self.enable is None else {**found, "enable line": self.enable}

    def operate(self, words: str) -> bool:
        """Do what an operator is asked to do: switch the high voltage on or off."""
        self.plant.switch(self.clock.now(), on=" ON" in words)
        return True

    def plate_voltage(self) -> float:
        """Return the voltage of the plate now [V]."""
        return float(self.plant.plate_voltage(np.array([self.clock.now()]))[0])
