"""A simulated bench put together: instruments, amplifier and finger on one clock."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Protocol

import numpy as np

from electrovib.bench.clock import SimulatedClock
from electrovib.bench.drivers.tektronix_tds3014b import DIVISIONS, LEVELS
from electrovib.bench.twin.commands import TwinInstrument
from electrovib.bench.twin.generator import TwinGenerator, TwinPlant

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.bench.clock import BenchClock
    from electrovib.bench.settings import BenchSettings, EnableLine
    from electrovib.bench.twin.commands import TwinInstrument
    from electrovib.bench.twin.generator import TwinPlant
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


_BITS: Final = 9
_COUNTS: Final = 2.0 ** (16 - _BITS)
"""Counts of the 16-bit sample in one reading of the converter."""


class Probed(Protocol):
    """What is connected to the inputs."""

    def input_voltage(self, channel: int, times: NDArray[np.float64], trigger: float) -> NDArray[np.float64]:
        """Return the voltage [V] at an input at past times [s] of a record with a trigger time [s]."""


class TwinOscilloscope(TwinInstrument):
    """Simulated TDS3014B; `probed` is what is connected to its inputs."""

    def __init__(
        self,
        clock: BenchClock,
        probed: Probed,
        identity: str = "TEKTRONIX,TDS 3014B,0,CF:91.1CT FV:v3.41",
    ) -> None:
        super().__init__(identity)
        self._clock, self._probed = clock, probed
        self._records = {"RECO": 500, "WID": 1}
        self._scale, self._position = 4e-6, 50.0
        self._channels: dict[int, dict[str, float]] = {
            channel: {"SCA": 1.0, "OFFS": 0.0, "POS": 0.0} for channel in (1, 2, 3, 4)
        }
        self._coupling = dict.fromkeys((1, 2, 3, 4), "DC")
        self._source = 1
        self._has_header = True
        self._texts = {"MOD": "SAMPLE", "STOPA": "RUNSTOP", "TRIGMOD": "AUTO", "EDGE": "CH1"}
        self._started: float | None = None
        self._trigger: float | None = None
        self._put_commands()
        self._put_queries()

    def _put_commands(self) -> None:
        self._commands |= {
            "HEADer": self._set_header,
            "VERBose": lambda _: None,
            "HORizontal:RECOrdlength": lambda text: self._records.update(RECO=int(float(text))),
            "HORizontal:MAIn:SCAle": self._set_scale,
            "HORizontal:TRIGger:POSition": self._set_position,
            "ACQuire:MODe": lambda text: self._texts.update(
                MOD={"SAM": "SAMPLE"}.get(text.upper()[:3], "OTHER")
            ),
            "ACQuire:STOPAfter": lambda text: self._texts.update(
                STOPA="SEQUENCE" if text.upper().startswith("SEQ") else "RUNSTOP"
            ),
            "ACQuire:STATE": self._start,
            "TRIGger:A:TYPe": lambda _: None,
            "TRIGger:A:MODe": lambda text: self._texts.update(
                TRIGMOD="NORMAL" if text.upper().startswith("NORM") else "AUTO"
            ),
            "TRIGger:A:EDGE:SOUrce": lambda text: self._texts.update(EDGE=text.upper()),
            "TRIGger:A:EDGE:SLOpe": lambda _: None,
            "TRIGger:A:LEVel": lambda _: None,
            "DATa:SOUrce": self._set_source,
            "DATa:ENCdg": lambda _: None,
            "DATa:WIDth": lambda text: self._records.update(WID=int(text)),
            "DATa:STARt": lambda _: None,
            "DATa:STOP": lambda _: None,
        }
        for channel in self._channels:
            for name, key in (("SCAle", "SCA"), ("OFFSet", "OFFS"), ("POSition", "POS")):
                self._commands[f"CH{channel}:{name}"] = self._setter(channel, key)
            self._commands[f"CH{channel}:COUPling"] = lambda _: None
            self._commands[f"SELect:CH{channel}"] = lambda _: None

    def _put_queries(self) -> None:
        self._queries |= {
            "HORizontal:RECOrdlength": lambda _: str(self._records["RECO"]),
            "HORizontal:MAIn:SCAle": lambda _: f"{self._scale:.4E}",
            "HORizontal:TRIGger:POSition": lambda _: f"{self._position:.4E}",
            "ACQuire:MODe": lambda _: self._texts["MOD"],
            "ACQuire:STOPAfter": lambda _: self._texts["STOPA"],
            "ACQuire:STATE": lambda _: str(int(not self._is_complete())),
            "TRIGger:A:MODe": lambda _: self._texts["TRIGMOD"],
            "TRIGger:A:EDGE:SOUrce": lambda _: self._texts["EDGE"],
            "TRIGger:STATE": lambda _: self._state(),
            "*OPC": lambda _: "1",
            "WFMPre": lambda _: self._preamble(),
            "CURVe": lambda _: self._curve(),
        }
        for channel in self._channels:
            for name, key in (("SCAle", "SCA"), ("OFFSet", "OFFS"), ("POSition", "POS")):
                self._queries[f"CH{channel}:{name}"] = self._getter(channel, key)
            self._queries[f"CH{channel}:COUPling"] = lambda _: "DC"

    def _setter(self, channel: int, key: str):  # type: ignore[no-untyped-def]  # noqa: ANN202
        return lambda text: self._channels[channel].update({key: float(text)})

    def _getter(self, channel: int, key: str):  # type: ignore[no-untyped-def]  # noqa: ANN202
        return lambda _: f"{self._channels[channel][key]:.6E}"

    def _set_header(self, text: str) -> None:
        self._has_header = text.upper() in ("ON", "1")

    def _set_scale(self, text: str) -> None:
        self._scale = float(text)

    def _set_position(self, text: str) -> None:
        self._position = float(text)

    def _set_source(self, text: str) -> None:
        self._source = int(text.upper().removeprefix("CH"))

    @property
    def _length(self) -> float:
        return DIVISIONS * self._scale

    @property
    def _before(self) -> float:
        return self._length * self._position / 100

    def _start(self, text: str) -> None:
        self._started = self._clock.now() if text.upper() in ("RUN", "ON", "1") else None
        self._trigger = None

    def synchronise(self, time: float) -> None:
        """Take an edge at the EXT input at a time [s]; it counts when the part before the trigger is filled."""
        if (
            self._started is not None
            and self._trigger is None
            and self._texts["EDGE"] == "EXT"
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

    def _preamble(self) -> str:
        chosen = self._channels[self._source]
        points = self._records["RECO"]
        values = {
            "BYT_NR": 2, "BIT_NR": 16, "ENCDG": "BIN", "BN_FMT": "RI", "BYT_OR": "MSB", "NR_PT": points,
            "WFID": f'"Ch{self._source}, DC coupling, {chosen["SCA"]:.3E} V/div, {self._scale:.3E} s/div, {points} points,'
            ' Sample mode"',
            "PT_FMT": "Y", "XINCR": f"{self._length / points:.6E}", "PT_OFF": 0, "XZERO": f"{-self._before:.6E}",
            "XUNIT": '"s"', "YMULT": f"{self._step(chosen) / _COUNTS:.9E}", "YZERO": f"{chosen['OFFS']:.9E}",
            "YOFF": "0.0E0", "YUNIT": '"V"',
        }  # fmt: skip
        if not self._has_header:
            return ";".join(str(value) for value in values.values())
        return ":WFMPRE:" + ";".join(f"{key} {value}" for key, value in values.items())

    @staticmethod
    def _step(chosen: dict[str, float]) -> float:
        return chosen["SCA"] / LEVELS

    def _curve(self) -> bytes:
        chosen, points = self._channels[self._source], self._records["RECO"]
        counts = np.zeros(points)
        if self._trigger is not None:
            trigger = self._trigger
            times = trigger - self._before + np.arange(points, dtype=np.float64) * (self._length / points)
            voltage = self._probed.input_voltage(self._source, times, trigger)
            half = 2 ** (_BITS - 1)
            readings = np.rint((voltage - chosen["OFFS"]) / self._step(chosen))
            counts = np.clip(readings, -half, half - 1) * _COUNTS
        data = counts.astype(">i2").tobytes()
        length = str(len(data))
        head = ":CURVE " if self._has_header else ""
        return f"{head}#{len(length)}{length}".encode("ascii") + data
