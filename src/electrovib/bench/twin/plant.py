"""What stands between the simulated instruments: amplifier, plate, finger and sensors."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.bench.settings import ForceInput
from electrovib.scenario import Scenario
from electrovib.scenario.grids import AtRest
from electrovib.solve.simulate import simulate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from electrovib.bench.settings import BenchSettings
    from electrovib.bench.twin.generator import TwinGenerator

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
