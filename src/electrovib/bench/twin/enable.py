"""Simulated instrument that holds the enable line of the amplifier."""

from __future__ import annotations

from typing import TYPE_CHECKING

from electrovib.bench.twin.commands import TwinInstrument

if TYPE_CHECKING:
    from electrovib.bench.clock import BenchClock
    from electrovib.bench.settings import EnableLine
    from electrovib.bench.twin.plant import TwinPlant


class TwinEnable(TwinInstrument):
    """Switches the high voltage of a simulated bench by the commands of its bench file."""

    def __init__(self, clock: BenchClock, plant: TwinPlant, line: EnableLine) -> None:
        super().__init__("ELECTROVIB,ENABLE,0,0")
        self._clock, self._plant, self._line = clock, plant, line

    def _take(self, command: str) -> None:
        if command == self._line.state:
            state = self._line.enabled if self._plant.is_on else self._line.disabled
            self._replies.append(state.encode("ascii"))
        elif command in (self._line.on, self._line.off):
            self._plant.switch(self._clock.now(), on=command == self._line.on)
        else:
            super()._take(command)
