"""A resonant sensor of declared frequency and quality factor, and the shortest time that it can show."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import parse_quantity
from electrovib.physics.relaxation import release_seen_by_sensor

INSTANT: Final = 1e-6
"""Fall time over the period of the sensor that stands for an instantaneous change; its effect is of this order."""
_TEXT: Final = re.compile(r"\s*(.+?)\s*[:,]\s*(?:Q\s*=?\s*)?([0-9.eE+-]+)\s*")


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """A force sensor with one resonance, with all that it carries.

    Parameters
    ----------
    frequency : float
        Natural frequency [Hz], above 0.
    quality : float
        Quality factor, dimensionless, above 1/2.
    frequency_error, quality_error : float
        Standard uncertainties [Hz] and dimensionless; 0 for values taken as exact.

    Raises
    ------
    InputError
        If a number is outside these limits.
    """

    frequency: float
    quality: float
    frequency_error: float = 0.0
    quality_error: float = 0.0

    def __post_init__(self) -> None:
        problems = []
        if not 0 < self.frequency < math.inf:
            problems.append(f"sensor.frequency = {self.frequency:g}: expected a positive frequency in Hz")
        if not 0.5 < self.quality < math.inf:
            problems.append(
                f"sensor.quality = {self.quality:g}: expected a quality factor above 0.5; a sensor without a resonance is"
                " not taken out"
            )
        problems += [
            f"sensor.{name} = {getattr(self, name):g}: expected a standard uncertainty of at least 0"
            for name in ("frequency_error", "quality_error")
            if not 0 <= getattr(self, name) < math.inf
        ]
        if problems:
            raise InputError(problems)

    def shortest_time(self, levels: tuple[float, float] = (0.1, 0.9)) -> float:
        """Compute the time between two levels of the reading after an instantaneous change of the force.

        Parameters
        ----------
        levels : tuple of float
            Fractions of the change, between 0 and 1, increasing.

        Returns
        -------
        time : float
            First passage through the upper level less first passage through the lower level [s].

        Notes
        -----
        The reading after a step is 1 - e^(-w t/(2 Q)) [cos(w_d t) + sin(w_d t) w/(2 Q w_d)], w_d = w sqrt(1 - 1/(4 Q^2)); it
        rises monotonically to its first maximum at pi/w_d, which lies above every level below 1.
        """
        from scipy.optimize import brentq

        first_maximum = 0.5 / (self.frequency * math.sqrt(1 - 1 / (4 * self.quality**2)))

        def progress(time: float) -> float:
            return 1.0 - float(self.release(np.array([time]), fall_time=0.0)[0])

        def passage(level: float) -> float:
            return float(
                brentq(lambda time: progress(time) - level, 0.0, first_maximum, xtol=1e-12 * first_maximum)
            )

        return passage(levels[1]) - passage(levels[0])

    def release(self, time: np.ndarray, *, fall_time: float, start: float = 0.0) -> np.ndarray:
        """Compute the reading of a force of 1 that decays exponentially from `start` on.

        Parameters
        ----------
        time : ndarray, shape (n,)
            Times [s].
        fall_time : float
            Time constant of the decay [s]; 0 for an instantaneous release.
        start : float
            Time at which the force begins to decay [s].

        Returns
        -------
        reading : ndarray, shape (n,)
            Over the constant force, dimensionless.
        """
        return release_seen_by_sensor(
            time,
            start=start,
            fall_time=max(fall_time, INSTANT / self.frequency),
            frequency=self.frequency,
            quality=self.quality,
        )


def read_sensor(text: str) -> Sensor:
    """Read a sensor written as ``FREQUENCY:QUALITY``, such as ``380 Hz:3``."""
    match = _TEXT.fullmatch(text)
    if match is None:
        raise InputError(f"sensor = {text}: expected FREQUENCY:QUALITY, such as '380 Hz:3', or 'estimate'")
    try:
        number = match[1]
        frequency = float(number) if re.fullmatch(r"[0-9.eE+-]+", number) else parse_quantity(number, "Hz")
        quality = float(match[2])
    except ValueError as error:
        raise InputError(f"sensor = {text}: {error}") from None
    return Sensor(frequency=frequency, quality=quality)
