"""A simulated bench put together: instruments, amplifier and finger on one clock."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.bench.drivers.tektronix_tds3014b import DIVISIONS, LEVELS
from electrovib.bench.link import SimulatedClock
from electrovib.bench.twin.generator import TwinGenerator, TwinInstrument, TwinPlant, is_on

if TYPE_CHECKING:
    from electrovib.bench.link import BenchClock
    from electrovib.bench.settings import BenchSettings, EnableLine
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


_INPUTS: Final = (1, 2, 3, 4)
_BITS: Final = 9
_COUNTS: Final = 2.0 ** (16 - _BITS)
"""Counts of the 16-bit sample in one reading of the converter."""


def _one_of(*known: str) -> Callable[[str], str]:
    """Return what reads one of some words by its first letters; the last one for anything else."""
    return lambda text: next((each for each in known if each[:3] == text.upper()[:3]), known[-1])


_LENGTH, _SCALE, _POSITION = (
    "HORizontal:RECOrdlength",
    "HORizontal:MAIn:SCAle",
    "HORizontal:TRIGger:POSition",
)
_EDGE, _SOURCE, _HEADER = "TRIGger:A:EDGE:SOUrce", "DATa:SOUrce", "HEADer"
_SETTINGS: Final[tuple[tuple[str, Any, Callable[[str], Any], Callable[[Any], str]], ...]] = (
    (_LENGTH, 500, lambda text: int(float(text)), str),
    (_SCALE, 4e-6, float, "{:.4E}".format),
    (_POSITION, 50.0, float, "{:.4E}".format),
    ("ACQuire:MODe", "SAMPLE", _one_of("SAMPLE", "OTHER"), str),
    ("ACQuire:STOPAfter", "RUNSTOP", _one_of("SEQUENCE", "RUNSTOP"), str),
    ("TRIGger:A:MODe", "AUTO", _one_of("NORMAL", "AUTO"), str),
    (_EDGE, "CH1", str.upper, str),
    (_SOURCE, 1, lambda text: int(text.upper().removeprefix("CH")), "CH{}".format),
    (_HEADER, True, is_on, str),
    *(
        (f"CH{channel}:{name}", first, float, "{:.6E}".format)
        for channel in _INPUTS
        for name, first in (("SCAle", 1.0), ("OFFSet", 0.0), ("POSition", 0.0))
    ),
    *((f"CH{channel}:COUPling", "DC", _one_of("DC"), str) for channel in _INPUTS),
)
"""Header of each setting, its value at first, how it is read, and how it is stated."""
_WITHOUT_EFFECT: Final = (
    "VERBose", "TRIGger:A:TYPe", "TRIGger:A:EDGE:SLOpe", "TRIGger:A:LEVel", "DATa:ENCdg", "DATa:WIDth", "DATa:STARt",
    "DATa:STOP", *(f"SELect:CH{channel}" for channel in _INPUTS),
)  # fmt: skip


class TwinOscilloscope(TwinInstrument):
    """Simulated TDS3014B; `probed` is what is connected to its inputs."""

    def __init__(
        self, clock: BenchClock, probed: TwinPlant, identity: str = "TEKTRONIX,TDS 3014B,0,CF:91.1CT FV:v3.41"
    ) -> None:
        super().__init__(identity)
        self._clock, self._probed = clock, probed
        self._started: float | None = None
        self._trigger: float | None = None
        for setting in _SETTINGS:
            self.hold(*setting)
        self._commands |= {"ACQuire:STATE": self._start, **dict.fromkeys(_WITHOUT_EFFECT, bool)}
        self._queries |= {
            "ACQuire:STATE": lambda _: str(int(not self._is_complete())),
            "TRIGger:STATE": lambda _: self._state(),
            "*OPC": lambda _: "1",
            "WFMPre": lambda _: self._preamble(),
            "CURVe": lambda _: self._curve(),
        }

    @property
    def _length(self) -> float:
        return float(DIVISIONS * self.values[_SCALE])

    @property
    def _before(self) -> float:
        return float(self._length * self.values[_POSITION] / 100)

    def _start(self, text: str) -> None:
        self._started = self._clock.now() if is_on(text) or text.upper() == "RUN" else None
        self._trigger = None

    def synchronise(self, time: float) -> None:
        """Take an edge at the EXT input at a time [s]; it counts when the part before the trigger is filled."""
        if (
            self._started is not None
            and self._trigger is None
            and self.values[_EDGE] == "EXT"
            and time >= self._started + self._before
        ):
            self._trigger = time

    def _is_complete(self) -> bool:
        return self._trigger is not None and self._clock.now() >= self._trigger + self._length - self._before

    def _state(self) -> str:
        if self._started is None or self._is_complete():
            return "SAVE"
        if self._trigger is not None:
            return "TRIGGER"
        return "READY" if self._clock.now() >= self._started + self._before else "ARMED"

    def _vertical(self, name: str) -> float:
        """Return a setting of the input whose record is read."""
        return float(self.values[f"CH{self.values[_SOURCE]}:{name}"])

    @property
    def _step(self) -> float:
        return self._vertical("SCAle") / LEVELS

    def _preamble(self) -> str:
        points, scale = self.values[_LENGTH], self._vertical("SCAle")
        values = {
            "BYT_NR": 2, "BIT_NR": 16, "ENCDG": "BIN", "BN_FMT": "RI", "BYT_OR": "MSB", "NR_PT": points,
            "WFID": f'"Ch{self.values[_SOURCE]}, DC coupling, {scale:.3E} V/div, {self.values[_SCALE]:.3E} s/div,'
            f' {points} points, Sample mode"',
            "PT_FMT": "Y", "XINCR": f"{self._length / points:.6E}", "PT_OFF": 0, "XZERO": f"{-self._before:.6E}",
            "XUNIT": '"s"', "YMULT": f"{self._step / _COUNTS:.9E}", "YZERO": f"{self._vertical('OFFSet'):.9E}",
            "YOFF": "0.0E0", "YUNIT": '"V"',
        }  # fmt: skip
        if not self.values[_HEADER]:
            return ";".join(str(value) for value in values.values())
        return ":WFMPRE:" + ";".join(f"{key} {value}" for key, value in values.items())

    def _curve(self) -> bytes:
        points = self.values[_LENGTH]
        counts = np.zeros(points)
        if self._trigger is not None:
            trigger = self._trigger
            times = trigger - self._before + np.arange(points, dtype=np.float64) * (self._length / points)
            voltage = self._probed.input_voltage(self.values[_SOURCE], times, trigger)
            half = 2 ** (_BITS - 1)
            readings = np.rint((voltage - self._vertical("OFFSet")) / self._step)
            counts = np.clip(readings, -half, half - 1) * _COUNTS
        data = counts.astype(">i2").tobytes()
        length = str(len(data))
        head = ":CURVE " if self.values[_HEADER] else ""
        return f"{head}#{len(length)}{length}".encode("ascii") + data
