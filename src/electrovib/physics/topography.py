"""Heights of a rough surface, periodic on a grid: random with a declared self-affine spectrum, or measured."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.arrays import Complex, Indices, Numbers, Real
from electrovib.core.errors import InputError
from electrovib.core.units import read_numbers

FINEST: Final = 2048
"""Most points along a side."""
POINTS_PER_WAVE: Final = 8
"""Least points of the shortest wave: the grid of every second point still resolves it."""


@dataclass(frozen=True, kw_only=True)
class SelfAffine:
    """Isotropic roughness whose power per wave vector is constant up to a wave number and falls with q^(-2 - 2 H) above it.

    Parameters
    ----------
    rms : float
        Root mean square height [m], above 0, which every draw has.
    hurst : float
        Exponent H, from 0 to 1.
    longest, roll_off, shortest : float
        Wavelengths [m], in this order: the longest one, that from which on the power falls, and the shortest one.

    Raises
    ------
    InputError
        If a number is outside its range, or the wavelengths are in another order.

    Notes
    -----
    Phases are random and amplitudes are not; many waves make Gaussian heights.

    Examples
    --------
    >>> rough = ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=1.25e-4)
    >>> f"{rough.heights((32, 32), (1e-3, 1e-3), seed=1).std():.3g}"
    '2e-06'
    """

    rms: float
    hurst: float
    longest: float
    roll_off: float
    shortest: float

    def __post_init__(self) -> None:
        """Refuse what is no spectrum."""
        read_numbers(self, rms="m", hurst="1", longest="m", roll_off="m", shortest="m")
        if not 1e-15 <= self.rms <= 1:
            raise InputError(f"rms = {self.rms}: an rms height is from 1e-15 to 1 m, for instance 5e-6 m")
        if not 0 <= self.hurst <= 1:
            raise InputError(f"hurst = {self.hurst}: a Hurst exponent is from 0 to 1, for instance 0.8")
        if not 0 < self.shortest <= self.roll_off <= self.longest < math.inf:
            raise InputError(
                f"longest = {self.longest}, roll_off = {self.roll_off}, shortest = {self.shortest}: wavelengths fall in this"
                " order, for instance 1e-3, 2.5e-4 and 1e-5 m"
            )

    def heights(self, shape: tuple[int, int], periods: tuple[float, float], *, seed: int) -> Real:
        """Return heights with mean 0 on a grid.

        Parameters
        ----------
        shape : tuple of 2 int
            Points along both axes, at least two for the shortest wave and one more.
        periods : tuple of 2 float
            Lengths of the grid [m], after which the heights repeat.
        seed : int
            Of the phases. A finer grid shows the same surface, and a smaller `shortest` adds waves to those of a larger one.

        Returns
        -------
        heights : ndarray, of the shape
            Heights [m].

        Raises
        ------
        InputError
            If the grid is too coarse for the shortest wave, or no wave fits into the periods.
        """
        if seed < 0:
            raise InputError(f"seed = {seed}: a whole number from 0 is expected")
        waves = self._waves(periods)
        needed = tuple(2 * int(np.abs(order).max()) + 1 for order in (waves.rows, waves.columns))
        if any(length < least for length, least in zip(shape, needed, strict=True)):
            raise InputError(
                f"shape = {shape}: at least {needed} points are needed for a shortest wavelength of {self.shortest} m"
            )
        phases = _phases(waves, seed)
        spectrum = np.zeros((shape[0], shape[1] // 2 + 1), dtype=complex)
        spectrum[waves.rows, waves.columns] = waves.amplitudes * np.exp(1j * phases)
        alone = (waves.columns == 0) & (waves.rows > 0)  # the other half of these waves is in the grid too
        spectrum[-waves.rows[alone], 0] = spectrum[waves.rows[alone], 0].conj()
        heights: Real = np.fft.irfft2(spectrum, s=shape, norm="forward")
        return heights

    @property
    def periods(self) -> tuple[float, float]:
        """Lengths of a grid of one period of the longest wave [m]."""
        return self.longest, self.longest

    def shape(self, points: int | None = None) -> tuple[int, int]:
        """Return the points along both axes of that grid.

        Parameters
        ----------
        points : int, optional
            As for `points`.

        Returns
        -------
        shape : tuple of 2 int
            The number that `points` returns, for each.
        """
        count = self.points(points)
        return count, count

    def points(self, points: int | None = None) -> int:
        """Return the points along a side of a grid of one period of the longest wave.

        Parameters
        ----------
        points : int, optional
            An even number of at least 8 for each shortest wave, and at most 2048; by default the least power of 2.

        Returns
        -------
        points : int
            Points along a side.

        Raises
        ------
        InputError
            If there are too few or too many, or the number is odd.
        """
        least = POINTS_PER_WAVE * self.longest / self.shortest
        if least > FINEST * (1 + 1e-9):
            raise InputError(
                f"roughness.shortest = {self.shortest}: it needs {least:.4g} points along a side, and at most {FINEST} are"
                f" computed; give a shortest wavelength from {POINTS_PER_WAVE * self.longest / FINEST:g} m"
            )
        count = 1 << int(np.ceil(np.log2(max(least, 32)) - 1e-9)) if points is None else points
        if count > FINEST or count < least * (1 - 1e-9) or count % 2:
            raise InputError(
                f"points = {count}: an even number from {POINTS_PER_WAVE} for each shortest wave, here {least:.0f}, to {FINEST}"
                " is expected; a larger shortest wavelength of the roughness needs fewer"
            )
        return count

    def without_shortest_octave(self) -> SelfAffine:
        """Return the same roughness without waves shorter than twice the shortest.

        Returns
        -------
        SelfAffine
            With a smaller rms height.

        Raises
        ------
        InputError
            If no waves are left.
        """
        shortest = 2 * self.shortest
        if shortest > self.longest * (1 + 1e-12):
            raise InputError(
                f"longest = {self.longest}, shortest = {self.shortest}: without the shortest octave no waves are left; give a"
                " shortest wavelength of at most half the longest"
            )
        waves = self._waves((self.longest, self.longest))
        kept = waves.amplitudes[waves.numbers <= 2 * math.pi / shortest * (1 + 1e-12)]
        return replace(
            self,
            shortest=shortest,
            roll_off=max(self.roll_off, shortest),
            rms=math.sqrt(2 * float(np.sum(kept**2))),
        )

    def rms_slope(self, periods: tuple[float, float]) -> float:
        """Return the root mean square of the gradient, by Parseval's theorem.

        Parameters
        ----------
        periods : tuple of 2 float
            Lengths of the grid [m].

        Returns
        -------
        slope : float
            That of every draw [1].
        """
        waves = self._waves(periods)
        return math.sqrt(2 * float(np.sum((waves.numbers * waves.amplitudes) ** 2)))

    def _waves(self, periods: tuple[float, float]) -> _Waves:
        """Return the waves with a wavelength in the range, one of each pair q, -q."""
        if max(periods) > FINEST * self.shortest:
            raise InputError(
                f"shortest = {self.shortest}: {max(periods) / self.shortest:.4g} waves stand in {max(periods)} m, and at most"
                f" {FINEST} are computed; give a larger shortest wavelength"
            )
        most = [int(period / self.shortest * (1 + 1e-12)) for period in periods]
        rows, columns = np.meshgrid(np.arange(-most[0], most[0] + 1), np.arange(most[1] + 1), indexing="ij")
        numbers = 2 * math.pi * np.hypot(rows / periods[0], columns / periods[1])
        low, corner, high = (2 * math.pi / length for length in (self.longest, self.roll_off, self.shortest))
        slack = 1 + 1e-12
        kept = (numbers >= low / slack) & (numbers <= high * slack) & ((columns > 0) | (rows > 0))
        if not kept.any():
            raise InputError(
                f"longest = {self.longest}, shortest = {self.shortest}: no wave of this range fits into periods of {periods} m"
            )
        amplitudes = np.maximum(numbers[kept] / corner, 1.0) ** (-1 - self.hurst)
        amplitudes *= self.rms / math.sqrt(2 * float(np.sum(amplitudes**2)))
        return _Waves(rows[kept], columns[kept], numbers[kept], amplitudes)


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredHeights:
    """Heights of a measured surface on an even grid, mirrored at its edges so that they repeat without steps.

    Parameters
    ----------
    values : array_like, shape (rows, columns)
        Heights [m], towards the other face, 4 to 1024 along both axes and none missing. Their tilt is subtracted, and the last
        row or column of an odd number is omitted.
    spacing : float
        Distance of neighbouring points along both axes [m], above 0.

    Raises
    ------
    InputError
        If a height is missing, the map is too small or too large, or the spacing is outside its range.

    Notes
    -----
    The grid has twice the points of the map along both axes. What is longer than twice the map was not measured, and what the
    instrument adds counts as roughness: its noise makes spots that are too small. Two rough faces have the sum of their
    heights. The library SurfaceTopography reads the files of many instruments: its
    ``read_topography("finger.x3p").interpolate_undefined_data().to_unit("m")`` has ``heights()`` and ``pixel_size``.

    Examples
    --------
    >>> rough = ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=1.25e-4)
    >>> found = ev.MeasuredHeights(values=rough.heights((32, 32), (1e-3, 1e-3), seed=1), spacing="31.25 um")
    >>> found.shape(), f"{found.rms_slope(found.periods):.2f}"
    ((64, 64), '0.07')
    """

    values: ArrayLike
    spacing: float

    def __post_init__(self) -> None:
        """Refuse what is no map, and subtract its tilt."""
        read_numbers(self, spacing="m")
        values = np.asarray(self.values, dtype=float)
        if not (values.ndim == 2 and min(values.shape) >= 4 and max(values.shape) <= FINEST // 2):
            raise InputError(
                f"values of shape {values.shape}: two axes with 4 to {FINEST // 2} points are expected; give a part of a larger"
                " map, or every second point"
            )
        if missing := int(np.sum(~np.isfinite(values))):
            raise InputError(
                f"values: {missing} of {values.size} heights are missing; fill them in from their neighbours"
            )
        if not 1e-12 <= self.spacing <= 1:
            raise InputError(f"spacing = {self.spacing}: from 1e-12 to 1 m is expected, for instance 1e-6 m")
        values = values[: values.shape[0] // 2 * 2, : values.shape[1] // 2 * 2]
        linear = np.column_stack([np.ones(values.size), *(each.ravel() for each in np.indices(values.shape))])
        fitted, *_ = np.linalg.lstsq(linear, values.ravel())
        object.__setattr__(self, "values", values - (linear @ fitted).reshape(values.shape))

    @property
    def rms(self) -> float:
        """Root mean square height [m]."""
        return float(np.asarray(self.values).std())

    @property
    def shortest(self) -> float:
        """Shortest wavelength that the points hold [m]."""
        return 2 * self.spacing

    @property
    def periods(self) -> tuple[float, float]:
        """Lengths of the mirrored map [m]."""
        rows, columns = self.shape()
        return rows * self.spacing, columns * self.spacing

    def shape(self, points: int | None = None) -> tuple[int, int]:
        """Return the points along both axes of the mirrored map.

        Parameters
        ----------
        points : None
            A measured surface has its own.

        Returns
        -------
        shape : tuple of 2 int
            Twice the points of the map.

        Raises
        ------
        InputError
            If a number of points is asked for.
        """
        if points is not None:
            raise InputError(f"points = {points}: a measured surface has its own points; omit them")
        rows, columns = np.shape(self.values)
        return 2 * rows, 2 * columns

    def heights(self, shape: tuple[int, int], periods: tuple[float, float], *, seed: int) -> Real:
        """Return the heights of the map and its mirror images.

        Parameters
        ----------
        shape, periods
            Those of this surface.
        seed : int
            Without effect.

        Returns
        -------
        heights : ndarray, of the shape
            Heights [m].
        """
        del shape, periods, seed
        rows, columns = np.shape(self.values)
        return np.pad(np.asarray(self.values), ((0, rows), (0, columns)), mode="symmetric")

    def without_shortest_octave(self) -> MeasuredHeights:
        """Return the same surface without waves shorter than twice the shortest."""
        spectrum, wavenumber = self._spectrum()
        spectrum[wavenumber > math.pi / self.shortest * (1 + 1e-12)] = 0.0
        rows, columns = np.shape(self.values)
        values = np.fft.irfft2(spectrum, s=self.shape(), norm="forward")[:rows, :columns]
        return replace(self, values=values)

    def rms_slope(self, periods: tuple[float, float]) -> float:
        """Return the root mean square of the gradient, by Parseval's theorem [1]."""
        del periods
        spectrum, wavenumber = self._spectrum()
        power = np.abs(wavenumber * spectrum) ** 2
        # the spectrum has both halves of the first column alone; in the last one mirror images cancel
        return math.sqrt(float(2 * np.sum(power) - np.sum(power[:, 0])))

    def _spectrum(self) -> tuple[Complex, Real]:
        """Return the waves of the mirrored map, and their wave numbers [1/m]."""
        shape = self.shape()
        waves = [
            2 * math.pi * each(count, self.spacing)
            for each, count in zip((np.fft.fftfreq, np.fft.rfftfreq), shape, strict=True)
        ]
        heights = self.heights(shape, self.periods, seed=0)
        return np.fft.rfft2(heights, norm="forward"), np.hypot(waves[0][:, None], waves[1][None, :])


class _Waves(NamedTuple):
    """Periods in the cell along both axes, wave numbers [1/m], and half the amplitude [m] of each wave."""

    rows: Indices
    columns: Indices
    numbers: Real
    amplitudes: Real


def _phases(waves: _Waves, seed: int) -> Numbers:
    """Return a phase for each wave, the same however many shorter ones there are."""
    shell = np.maximum(np.abs(waves.rows), waves.columns)
    reach = int(shell.max())
    drawn = np.random.default_rng(seed).uniform(0.0, 2 * math.pi, (reach + 1) * (2 * reach + 1))
    # of the shells below there are n (2 n - 1); within one, first the column of the shell's number, then its rows on both sides
    beside = waves.columns == shell
    place = np.where(beside, waves.rows + shell, 2 * shell + 1 + 2 * waves.columns + (waves.rows > 0))
    return np.asarray(drawn[shell * (2 * shell - 1) + place])
