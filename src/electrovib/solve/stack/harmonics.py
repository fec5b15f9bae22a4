"""Harmonics of a periodic drive."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.drive.parts import Part, Tones
from electrovib.physics.drive.pieces import Linear

if TYPE_CHECKING:
    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.drive.base import Drive


def spectrum(drive: Drive, *, harmonics: int) -> tuple[Real, Complex]:
    """Return frequencies [Hz] and complex peak amplitudes [V] whose real parts sum to a periodic drive."""
    found: dict[float, complex] = {}
    for part in drive.parts():
        for frequency, amplitude in zip(*_part_spectrum(part, harmonics), strict=True):
            found[frequency] = found.get(frequency, 0.0) + amplitude
    frequencies = np.array(sorted(found))
    return frequencies, np.array([found[frequency] for frequency in frequencies])


def count_harmonics(drive: Drive) -> int | None:
    """Return the number of frequencies in a drive, with a constant; None where it is infinite, as for edges."""
    parts = drive.parts()
    if drive.period is None or not all(_is_tones(part) for part in parts):
        return None
    frequencies, amplitudes = spectrum(drive, harmonics=1)
    return int(np.count_nonzero(amplitudes[np.argsort(frequencies)]))


def _is_tones(part: Part) -> bool:
    return isinstance(part, Tones) or (isinstance(part, Linear) and part.is_step)


def _part_spectrum(part: Part, harmonics: int) -> tuple[Real, Complex]:
    if isinstance(part, Tones):
        return part.frequencies, part.amplitudes
    if isinstance(part, Linear) and part.is_step:
        return np.zeros(1), part.after.astype(complex)
    if isinstance(part, Linear) and part.period is not None:
        return _straight_spectrum(part, part.period, harmonics)
    raise InputError("drive: a part of it does not repeat, so it has no harmonics")


def _straight_spectrum(part: Linear, period: float, harmonics: int) -> tuple[Real, Complex]:
    """Return the Fourier series of straight pieces: 1/(j w) for each discontinuity, 1/(j w)^2 for each change of slope."""
    first, last = part.after[:-1], part.before[1:]
    steps = np.diff(part.times)
    slopes = (last - first) / steps
    mean = float(np.sum((first + last) / 2 * steps)) / period
    jumps = first - np.roll(last, 1)
    bends = slopes - np.roll(slopes, 1)
    angular = 2 * np.pi * np.arange(1, harmonics + 1) / period
    turns = np.exp(-1j * angular[:, None] * part.times[:-1])
    series = 2 / period * (turns @ jumps / (1j * angular) + turns @ bends / (1j * angular) ** 2)
    return np.append(0.0, angular / (2 * np.pi)), np.append(mean + 0j, series)
