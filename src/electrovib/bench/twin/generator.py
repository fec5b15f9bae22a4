"""The simulated generator and what stands behind it: amplifier, plate, finger, sensors; and the commands it understands."""

from __future__ import annotations

import functools
import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.bench.drivers.hp_33120a import HIGH_IMPEDANCE
from electrovib.bench.settings import ForceInput
from electrovib.exports.waveform_formats import HP_FEWEST_POINTS, HP_LARGEST_CODE, HP_MOST_POINTS
from electrovib.scenario import Scenario
from electrovib.scenario.grids import AtRest
from electrovib.solve.simulate import simulate

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from electrovib.bench.link import BenchClock
    from electrovib.bench.settings import BenchSettings

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


_LARGEST: Final = 10.0
"""Largest voltage of the open output, of either sign [V]."""
_SHAPES: Final = ("SIN", "SQU", "TRI", "RAMP", "NOIS", "DC", "USER")


@dataclass(frozen=True, kw_only=True)
class _OutputState:
    """State of the output; voltages are those of the open output."""

    since: float = -np.inf
    shape: str = "SIN"
    frequency: float = 1e3
    amplitude: float = 0.2
    offset: float = 0.0
    codes: tuple[int, ...] = ()
    is_burst: bool = False
    cycles: int = 1
    source: str = "IMM"
    started: float | None = None

    def voltage(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        if self.shape == "DC":
            return np.full(times.shape, self.offset)
        origin, turns = self.since if np.isfinite(self.since) else 0.0, None
        if self.is_burst and self.source == "BUS":
            origin, turns = (np.inf if self.started is None else self.started), self.cycles
        phase = np.zeros(times.shape)  # at rest: the first point
        after = times >= origin
        phase[after] = (times[after] - origin) * self.frequency
        if turns is not None:
            phase[phase >= turns] = 0.0
        return self.offset + self.amplitude / 2 * self._cycle(phase % 1.0)

    def _cycle(self, phase: NDArray[np.float64]) -> NDArray[np.float64]:
        if self.shape == "USER" and self.codes:
            points = np.asarray(self.codes, dtype=float) / HP_LARGEST_CODE
            return np.asarray(points[np.minimum((phase * len(points)).astype(int), len(points) - 1)])
        return np.asarray(np.sin(2 * np.pi * phase))  # other periodic shapes are equally unwanted here


_ONLY: Final = {
    "FUNCtion:USER": ("VOLATILE", "VOLATILE"),
    "VOLTage:UNIT": ("VPP", "VPP"),
    "BM:PHASe": ("0", "+0.00000E+00"),
    "BM:SOURce": ("INT", "INT"),
}
"""Settings of which this instrument takes one value alone, and how it states it."""


def _load_of(text: str) -> float:
    return 50.0 if text == "50" else HIGH_IMPEDANCE


class TwinGenerator(TwinInstrument):
    """Simulated HP 33120A."""

    def __init__(self, clock: BenchClock, identity: str = "HEWLETT-PACKARD,33120A,0,8.0-5.0-1.0") -> None:
        super().__init__(identity)
        self._clock = clock
        self._history: list[_OutputState] = [_OutputState()]
        self._memory: tuple[int, ...] = ()
        self.on_trigger: list[Callable[[float], None]] = []
        self.hold("OUTPut:LOAD", 50.0, _load_of, "{:+.5E}".format)
        self.hold("OUTPut:SYNC", False, is_on)
        self.hold("FORMat:BORDer", "NORM", lambda text: text.upper()[:4])
        for header, (accepted, stated) in _ONLY.items():
            self.hold(header, stated, functools.partial(self._only, accepted, stated))
        self._commands |= {
            "*RST": lambda _: self._reset(),
            "*CLS": lambda _: self.errors.clear(),
            "*TRG": lambda _: self._trigger(),
            "APPLy:DC": self._apply_dc,
            "FUNCtion:SHAPe": self._set_shape,
            "FREQuency": lambda text: self._change(frequency=float(text)),
            "VOLTage": lambda text: self._change(amplitude=float(text.split()[0]) * self._doubling),
            "VOLTage:OFFSet": lambda text: self._change(offset=float(text) * self._doubling),
            "BM:STATe": self._set_burst,
            "BM:NCYCles": lambda text: self._change(cycles=int(float(text))),
            "TRIGger:SOURce": lambda text: self._change(source=text.upper()[:3]),
        }
        self._queries |= {
            "SYSTem:ERRor": self.next_error,
            "FUNCtion:SHAPe": lambda _: self.output.shape,
            "FREQuency": lambda _: f"{self.output.frequency:+.9E}",
            "VOLTage": lambda _: f"{self.output.amplitude / self._doubling:+.6E}",
            "VOLTage:OFFSet": lambda _: f"{self.output.offset / self._doubling:+.6E}",
            "BM:STATe": lambda _: str(int(self.output.is_burst)),
            "BM:NCYCles": lambda _: f"{self.output.cycles:+.5E}",
            "TRIGger:SOURce": lambda _: self.output.source,
            "DATA:ATTRibute:POINts": lambda _: f"+{len(self._memory)}",
        }

    @property
    def output(self) -> _OutputState:
        """State of the output now."""
        return self._history[-1]

    @property
    def _doubling(self) -> float:
        """Voltage of the open output over that which is set and shown."""
        return 2.0 if self.values["OUTPut:LOAD"] == 50.0 else 1.0

    def voltage(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the voltage of the open output [V] at times up to now [s]."""
        starts = np.array([each.since for each in self._history])
        which = np.searchsorted(starts, times, side="right") - 1
        found = np.zeros(times.shape)
        for index in np.unique(which):
            chosen = which == index
            found[chosen] = self._history[index].voltage(times[chosen])
        return found

    def _change(self, **changes: object) -> None:
        changed = replace(self.output, **changes, since=self._clock.now())  # type: ignore[arg-type]
        if abs(changed.offset) + changed.amplitude / 2 * (changed.shape != "DC") > _LARGEST * (1 + 1e-6):
            self.errors.append(OUT_OF_RANGE)
            return
        self._history.append(changed)

    def _reset(self) -> None:
        self.values["OUTPut:LOAD"] = 50.0
        self._history.append(_OutputState(since=self._clock.now()))

    def _trigger(self) -> None:
        if not (self.output.is_burst and self.output.source == "BUS"):
            self.errors.append(TRIGGER_IGNORED)
            return
        now = self._clock.now()
        self._change(started=now)
        if self.values["OUTPut:SYNC"]:
            for listener in self.on_trigger:
                listener(now)

    def _apply_dc(self, text: str) -> None:
        offset = float(text.rsplit(",", maxsplit=1)[-1]) * self._doubling
        self._change(shape="DC", offset=offset, is_burst=False, started=None)

    def _set_shape(self, text: str) -> None:
        shape = next((each for each in _SHAPES if text.upper().startswith(each)), "")
        if not shape:
            self.errors.append(OUT_OF_RANGE)
            return
        self._change(shape=shape, codes=self._memory if shape == "USER" else ())

    def _set_burst(self, text: str) -> None:
        wanted = is_on(text)
        if wanted and self.output.shape == "DC":
            self.errors.append(SETTINGS_CONFLICT)
            return
        self._change(is_burst=wanted, started=None)

    def _only(self, accepted: str, stated: str, text: str) -> str:
        if text.upper() != accepted:
            self.errors.append(OUT_OF_RANGE)
        return stated

    def take_block(self, command: str, block: bytes) -> None:
        """Take the points of ``DATA:DAC VOLATILE,``."""
        if command.upper().replace(" ", "") != "DATA:DACVOLATILE,":
            super().take_block(command, block)
            return
        digits = int(block[1:2])
        length, data = int(block[2 : 2 + digits]), block[2 + digits :]
        codes = np.frombuffer(data, ">i2" if self.values["FORMat:BORDer"] == "NORM" else "<i2")
        fits = len(data) == length and HP_FEWEST_POINTS <= codes.size <= HP_MOST_POINTS
        if not fits or np.abs(codes).max() > HP_LARGEST_CODE:
            self.errors.append(OUT_OF_RANGE)
            return
        self._memory = tuple(codes.tolist())
        if self.output.shape == "USER":
            self._change(codes=self._memory)


_NOISE: Final = 0.3
"""Standard deviation of the noise of the voltage and current monitors, in parts of a thousandth of the limit."""


class TwinPlant:
    """Amplifier with a switch, plate, finger and sensors of a simulated bench.

    Gains, ratios and calibrations of the bench file are taken as exact; the voltage of the plate replaces the
    drive of `finger`.
    """

    def __init__(
        self, settings: BenchSettings, finger: Scenario, generator: TwinGenerator, *, seed: int
    ) -> None:
        self._settings, self._finger, self._generator = settings, finger, generator
        self._random = np.random.default_rng(seed)
        self._switched: list[tuple[float, bool]] = [(-np.inf, False)]

    def switch(self, time: float, *, on: bool) -> None:
        """Switch the high voltage on or off at a time [s]."""
        self._switched.append((time, on))

    @property
    def is_on(self) -> bool:
        """Whether the high voltage is on."""
        return self._switched[-1][1]

    def plate_voltage(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the voltage of the plate [V] at times up to now [s]."""
        starts = np.array([start for start, _ in self._switched])
        states = np.array([on for _, on in self._switched])
        on = states[np.searchsorted(starts, times, side="right") - 1]
        return np.where(on, self._settings.amplifier.gain * self._generator.voltage(times), 0.0)

    def input_voltage(self, channel: int, times: NDArray[np.float64], trigger: float) -> NDArray[np.float64]:
        """Return the voltage [V] at an input of the oscilloscope, with noise; without a channel noise alone."""
        found = {each.input: (name, each) for name, each in self._settings.channels().items()}
        if channel not in found:
            return np.zeros(times.shape)
        name, role = found[channel]
        voltage = self.plate_voltage(times)
        if isinstance(role, ForceInput):
            force = _response(self._finger, _key(times - trigger, 14), _key(voltage, 9))[name]
            noisy = force + role.noise * self._random.standard_normal(times.size)
            return noisy / role.sensitivity + role.zero
        if name == "voltage":
            largest = self._settings.limits.voltage or 0.0
            noise = 1e-3 * _NOISE * largest * self._random.standard_normal(times.size)
            return (voltage + noise) / self._settings.oscilloscope.voltage.ratio
        current = _response(self._finger, _key(times - trigger, 14), _key(voltage, 9))["current"]
        noise = (
            1e-3 * _NOISE * (self._settings.limits.current or 0.0) * self._random.standard_normal(times.size)
        )
        monitor = self._settings.oscilloscope.current
        assert monitor is not None
        return (current + noise) * monitor.resistance


def _key(values: NDArray[np.float64], digits: int) -> bytes:
    """Return values without their rounding errors, so that equal bursts share a response."""
    return np.round(values, digits).tobytes()


@functools.lru_cache(maxsize=16)
def _response(finger: Scenario, times: bytes, voltages: bytes) -> dict[str, NDArray[np.float64]]:
    """Return the forces [N] and the current [A] of a finger under a voltage of the plate, from rest."""
    time, voltage = np.frombuffer(times), np.frombuffer(voltages)
    since = time - time[0]
    own = finger.circuit.amplifier
    drive = {
        "model": "Sampled",
        "time_samples": since.tolist(),
        "voltage_samples": (voltage / (1.0 if own is None else own.gain)).tolist(),
    }
    time_grid = {"initial_state": {"model": AtRest.__name__}, "duration": float(since[-1])}
    trace = simulate(finger.replace({"drive": drive, "time": time_grid}), time=since)
    found = {}
    for name, signal in (("lateral", "lateral_force"), ("normal", "normal_force")):
        measured = f"{signal}_measured"
        found[name] = np.asarray(trace[measured if measured in trace else signal].values)
    found["current"] = np.asarray(
        trace["amplifier_current" if "amplifier_current" in trace else "current"].values
    )
    return found
