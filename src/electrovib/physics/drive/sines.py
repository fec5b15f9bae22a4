"""Drives made of sines: sine, burst, amplitude modulation, chirp."""

from __future__ import annotations

import functools
import math
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from electrovib.core.arrays import Real
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.drive.base import common_period
from electrovib.physics.drive.levels import IN_PLACE_OF_SWING, Swing
from electrovib.physics.drive.parts import Chirped, Tones

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.physics.drive.parts import Part

_FREQUENCY = Quantity("Hz", 1e-3, 1e8, "frequency of the sine")
_DEPTH = Quantity("1", 0, 1, "modulation depth m")


@functools.lru_cache(maxsize=1024)
def _tone(amplitude: float, frequency: float, phase: float) -> tuple[Tones, ...]:
    """Return one tone that is always on, from amplitude [V], frequency [Hz] and phase [rad]."""
    found = np.array([frequency]), np.array([amplitude * np.exp(1j * (phase - math.pi / 2))])
    for array in found:
        array.flags.writeable = False
    return (Tones(*found),)


class Oscillation(Swing, family=True):
    """A voltage or current of one frequency about an offset."""

    frequency: Annotated[Number, _FREQUENCY]
    phase: Annotated[Number, Quantity("rad", -10, 10, "0 for a sine, pi/2 for a cosine")] = 0.0

    def parts(self) -> tuple[Part, ...]:
        """Return one tone and the offset."""
        return self._with_offset(_tone(self.amplitude, self.frequency, self.phase))

    def corners(self, end: float) -> tuple[Real, Real]:  # noqa: ARG002 of every drive
        """Return no corners: a sine is always on and smooth."""
        return np.zeros(0), np.zeros(0)

    def extremes(self, start: float = 0.0, end: float | None = None) -> tuple[float, float]:
        """Return the lowest and highest voltage [V]; over a period or more they are low and high."""
        if end is None or end - start >= self.period:
            return self.low, self.high
        return super().extremes(start, end)

    @property
    def period(self) -> float:
        """Reciprocal of the frequency [s]."""
        return 1 / self.frequency


class Sine(Oscillation):
    """A sine of one frequency about an offset."""

    equation: ClassVar[Mapping[str, str]] = {"voltage": "offset + amplitude*sin(2*pi*frequency*time + phase)"}
    example: ClassVar[Mapping[str, Any]] = {"amplitude": 100, "frequency": 125}


class Burst(Swing):
    """A whole number of cycles of a sine, which begins and ends at the offset."""

    equation: ClassVar[Mapping[str, str]] = {
        "end": "delay + cycles/frequency",
        "voltage": (
            "offset + amplitude*sin(2*pi*frequency*(time - delay)) if delay <= time < end else offset"
        ),
    }
    example: ClassVar[Mapping[str, Any]] = {"amplitude": 100, "frequency": 250, "cycles": 10}

    frequency: Annotated[Number, _FREQUENCY]
    cycles: Annotated[int, Field(description="whole number of cycles, 1 to 1e9")]
    delay: Annotated[Number, Quantity("s", 0, 1e3, "time before the burst")] = 0.0

    @model_validator(mode="after")
    def _has_cycles(self) -> Self:
        if not 1 <= self.cycles <= 10**9:
            raise ValueError("cycles must be a whole number from 1 to 1e9")
        return self

    def parts(self) -> tuple[Part, ...]:
        """Return one tone that is switched at its zero crossings, and the offset."""
        turn = np.exp(-2j * np.pi * self.frequency * self.delay)
        stop = self.delay + self.cycles / self.frequency
        tone = np.array([-1j * self.amplitude * turn])
        return self._with_offset((Tones(np.array([self.frequency]), tone, self.delay, stop),))

    @property
    def duration(self) -> float:
        """Delay and twice the length of the burst [s]."""
        return self.delay + 2 * self.cycles / self.frequency


class ModulatedCarrier(Swing, family=True):
    """A carrier with a sinusoidal modulation of its envelope, about an offset."""

    example: ClassVar[Mapping[str, Any]] = {
        "amplitude": 100,
        "carrier": 3000,
        "modulation": 100,
        "depth": 0.8,
    }

    derived: ClassVar[Mapping[str, Quantity]] = {
        "high": Quantity("V", -1e5, 1e5, "highest voltage of the envelope", IN_PLACE_OF_SWING),
        "low": Quantity("V", -1e5, 1e5, "lowest voltage of the envelope", IN_PLACE_OF_SWING),
    }

    amplitude: Annotated[Number, Quantity("V", 0, 1e5, "carrier amplitude without modulation")]
    carrier: Annotated[Number, Quantity("Hz", 1e-3, 1e8, "frequency of the carrier")]
    modulation: Annotated[Number, Quantity("Hz", 1e-3, 1e8, "frequency of the modulation")]
    depth: Annotated[Number, _DEPTH]

    @classmethod
    def _crest_of(cls, content: Mapping[str, Any]) -> float:
        """Return the largest departure from the offset over the amplitude [1], 1 where the depth is not valid."""
        try:
            return cls._envelope_crest(_DEPTH.read(content.get("depth")))
        except PydanticCustomError:
            return 1.0  # validation says what is wrong with the depth

    @staticmethod
    @abstractmethod
    def _envelope_crest(depth: float) -> float:
        """Return the highest value of the envelope over the amplitude [1], for a modulation depth [1]."""

    @property
    def duration(self) -> float:
        """Three periods of the modulation [s]."""
        return 3 / self.modulation


class AmplitudeModulation(ModulatedCarrier):
    """A carrier with the envelope 1 + m cos: the force has components at the modulation frequency and its double."""

    equation: ClassVar[Mapping[str, str]] = {
        "envelope": "1 + depth*cos(2*pi*modulation*time)",
        "voltage": "offset + amplitude*envelope*cos(2*pi*carrier*time)",
    }

    @staticmethod
    def _envelope_crest(depth: float) -> float:
        """Return 1 + m [1]."""
        return 1 + depth

    def parts(self) -> tuple[Part, ...]:
        """Return the carrier, its two sidebands and the offset."""
        frequencies = self.carrier + self.modulation * np.array([0.0, -1.0, 1.0])
        weights = np.array([1, self.depth / 2, self.depth / 2])
        return self._with_offset((_cosines(frequencies, self.amplitude * weights),))

    @property
    def period(self) -> float | None:
        """Common period of carrier and modulation [s]; None without one."""
        return common_period([1 / self.modulation, 1 / self.carrier])


class SquareRootModulation(ModulatedCarrier):
    """A carrier with the envelope sqrt(1 + m cos), whose square is a pure tone at the modulation frequency.

    Notes
    -----
    The Fourier series of the root is truncated below 1e-15 of its mean. At full depth, where the root has a kink, its
    smooth branch sqrt(2) cos(theta/2) is used instead; the square is the same.
    """

    equation: ClassVar[Mapping[str, str]] = {
        "envelope": (
            "sqrt(1 + depth*cos(2*pi*modulation*time)) if depth < 1 else sqrt(2)*cos(pi*modulation*time)"
        ),
        "voltage": "offset + amplitude*envelope*cos(2*pi*carrier*time)",
    }

    @staticmethod
    def _envelope_crest(depth: float) -> float:
        """Return the square root of 1 + m [1]."""
        return math.sqrt(1 + depth)

    def parts(self) -> tuple[Part, ...]:
        """Return the carrier, its sidebands and the offset."""
        if self.depth == 1:
            frequencies = self.carrier + self.modulation * np.array([-0.5, 0.5])
            return self._with_offset(
                (_cosines(frequencies, self.amplitude * np.array([1, 1]) / math.sqrt(2)),)
            )
        series = _root_series(self.depth)
        orders = np.arange(len(series))
        frequencies = np.concatenate(
            [self.carrier + self.modulation * orders, self.carrier - self.modulation * orders]
        )
        weights = np.concatenate([series, series]) / 2
        return self._with_offset((_cosines(frequencies, self.amplitude * weights),))

    @property
    def period(self) -> float | None:
        """Common period of carrier and modulation [s]; None without one."""
        modulation = self.modulation / 2 if self.depth == 1 else self.modulation
        return common_period([1 / modulation, 1 / self.carrier])


def _root_series(depth: float) -> Real:
    """Return the cosine coefficients of sqrt(1 + m cos), whose ratio tends to (1 - sqrt(1 - m^2))/m."""
    if depth == 0:
        return np.array([1.0])
    ratio = depth / (1 + math.sqrt(1 - depth**2))
    count = min(1 << 16, max(8, math.ceil(-36 / math.log(ratio)) + 1))
    size = 1 << math.ceil(math.log2(4 * count))
    angle = 2 * np.pi * np.arange(size) / size
    series = np.fft.rfft(np.sqrt(1 + depth * np.cos(angle))).real / size
    series[1:] *= 2
    kept = np.abs(series[:count]) > 1e-16
    return np.asarray(series[:count][: int(np.max(np.nonzero(kept))) + 1])


def _cosines(frequencies: Real, amplitudes: Real) -> Tones:
    """Return cosines; a sideband below 0 Hz is folded to a positive frequency, because cos(-x) = cos(x)."""
    return Tones(np.abs(frequencies), np.asarray(amplitudes, complex))


class Chirp(Swing):
    """A sine about an offset whose frequency changes linearly from one value to another."""

    equation: ClassVar[Mapping[str, str]] = {
        "turns": "first*time + (last - first)*time**2/(2*length)",
        "voltage": "offset + amplitude*sin(2*pi*turns) if time < length else offset",
    }
    example: ClassVar[Mapping[str, Any]] = {"amplitude": 100, "first": 10, "last": 1000, "length": 0.2}

    first: Annotated[Number, Quantity("Hz", 0, 1e8, "frequency at the beginning")]
    last: Annotated[Number, Quantity("Hz", 1e-3, 1e8, "frequency at the end")]
    length: Annotated[Number, Quantity("s", 1e-6, 1e4, "duration of the chirp")]

    def parts(self) -> tuple[Part, ...]:
        """Return the sine and the offset."""
        return self._with_offset((Chirped.between(self.amplitude, self.first, self.last, self.length),))

    @property
    def duration(self) -> float:
        """Duration of the chirp [s]."""
        return self.length
