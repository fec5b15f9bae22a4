"""Heights of a rough surface, periodic on a grid: random with a declared self-affine spectrum, or measured."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from electrovib.core.arrays import Complex, Indices, Numbers, Real
from electrovib.core.errors import InputError
from electrovib.core.files import UNREAD, FileColumn
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity, column_unit, is_unit_of
from electrovib.core.samples import Samples

FINEST: Final = 2048
"""Most points along a side."""
POINTS_PER_WAVE: Final = 8
"""Least points of the shortest wave: the grid of every second point still resolves it."""


class Topography(Model, family=True):
    """Heights of a rough surface over one period [m], towards the other face, and what is known of their waves."""

    if TYPE_CHECKING:  # a parameter or a property of every member

        @property
        def rms(self) -> float:
            """Root mean square height [m]."""

        @property
        def shortest(self) -> float:
            """Shortest wavelength [m]."""

    @property
    @abstractmethod
    def periods(self) -> tuple[float, float]:
        """Lengths [m] along both axes after which the heights repeat."""

    @abstractmethod
    def shape(self, points: int | None = None) -> tuple[int, int]:
        """Return the points along both axes of a grid of one period.

        Parameters
        ----------
        points : int, optional
            Points along a side, where the surface does not have its own; as few as suffice if absent.

        Returns
        -------
        shape : tuple of 2 int
            Points along both axes.

        Raises
        ------
        InputError
            If so many points cannot be had.
        """

    @abstractmethod
    def heights(self, shape: tuple[int, int], periods: tuple[float, float], *, seed: int) -> Real:
        """Return heights with mean 0 on a grid.

        Parameters
        ----------
        shape : tuple of 2 int
            Points along both axes.
        periods : tuple of 2 float
            Lengths of the grid [m], after which the heights repeat.
        seed : int
            Of what is random, 0 or above.

        Returns
        -------
        heights : ndarray, of the shape
            Heights [m].

        Raises
        ------
        InputError
            If the grid does not hold the waves of the surface.
        """

    @abstractmethod
    def without_shortest_octave(self) -> Topography:
        """Return the same surface without waves shorter than twice the shortest."""

    @abstractmethod
    def rms_slope(self, periods: tuple[float, float]) -> float:
        """Return the root mean square of the gradient [1] on a grid of lengths [m]."""


class SelfAffine(Topography):
    """Isotropic roughness whose power per wave vector is constant up to a wave number and falls with q^(-2 - 2 H) above it.

    Notes
    -----
    Phases are random and amplitudes are not: every draw has the rms height, and many waves make Gaussian heights.

    Examples
    --------
    >>> rough = ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=1.25e-4)
    >>> f"{rough.heights((32, 32), (1e-3, 1e-3), seed=1).std():.3g}"
    '2e-06'
    """

    example: ClassVar[Mapping[str, Any]] = {
        "rms": 2e-6,
        "hurst": 0.8,
        "longest": 1e-3,
        "roll_off": 2.5e-4,
        "shortest": 1.25e-4,
    }

    rms: Annotated[Number, Quantity("m", 1e-15, 1, "root mean square height")]
    hurst: Annotated[Number, Quantity("1", 0, 1, "exponent H")]
    longest: Annotated[Number, Quantity("m", 1e-12, 1e3, "longest wavelength")]
    roll_off: Annotated[Number, Quantity("m", 1e-12, 1e3, "wavelength below which the power falls")]
    shortest: Annotated[Number, Quantity("m", 1e-12, 1e3, "shortest wavelength")]

    @model_validator(mode="after")
    def _wavelengths_fall(self) -> Self:
        if not self.shortest <= self.roll_off <= self.longest:
            raise ValueError(
                f"longest = {self.longest}, roll_off = {self.roll_off}, shortest = {self.shortest}: wavelengths fall in this"
                " order, for instance 1e-3, 2.5e-4 and 1e-5 m"
            )
        return self

    def heights(self, shape: tuple[int, int], periods: tuple[float, float], *, seed: int) -> Real:
        """Return heights with mean 0 on a grid of at least two points for the shortest wave and one more [m].

        A finer grid shows the same surface of a seed, and a smaller `shortest` adds waves to those of a larger one.
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
        """Return the number that `points` returns, for both axes."""
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
        rms = math.sqrt(2 * float(np.sum(kept**2)))
        return self.replace({"shortest": shortest, "roll_off": max(self.roll_off, shortest), "rms": rms})

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


class MeasuredHeights(Topography):
    """Heights of a measured surface on an even grid, mirrored at its edges so that they repeat without steps.

    Notes
    -----
    Heights towards the other face, 4 to 1024 along both axes and none missing: `values` of two axes, or row after row with the
    `columns` of a row, as in a file. Their tilt is subtracted, and the last row or column of an odd number is omitted.
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

    example: ClassVar[Mapping[str, Any]] = {
        "values": [1e-6, 0.0, 0.0, 0.0] * 4,
        "columns": 4,
        "spacing": 1e-5,
    }

    file: Annotated[str, Field(description="csv, npy or nc file with the heights, row after row")] = ""
    column: Annotated[str | int, Field(description="name or number of the column of heights")] = "z"
    unit: Annotated[str, column_unit("m"), Field(description="unit of the column")] = "m"
    values: Annotated[Samples, Field(description="heights [m], in place of a file")] = Samples([])
    columns: Annotated[int | None, Field(ge=4, le=FINEST // 2, description="heights in a row")] = None
    spacing: Annotated[Number, Quantity("m", 1e-12, 1, "distance of neighbouring points along both axes")]

    @classmethod
    def file_columns(cls, table: Mapping[str, Any]) -> Mapping[str, FileColumn]:
        """Return the column of heights, unless the table holds them."""
        column, unit = table.get("column", "z"), table.get("unit", "m")
        wrong = not is_unit_of("m", unit) or not isinstance(column, str | int)
        if not table.get("file") or "values" in table or wrong:
            return {}
        return {"values": FileColumn(column, unit)}

    @classmethod
    def complete(cls, content: dict[str, Any]) -> dict[str, Any]:
        """Take a map of two axes for its rows."""
        values = content.get("values")
        if isinstance(values, list | tuple | np.ndarray) and np.ndim(values) == 2:
            rows = np.asarray(values, dtype=float)
            return content | {"values": rows.ravel(), "columns": rows.shape[1]}
        return content

    @model_validator(mode="after")
    def _is_a_map(self) -> Self:
        heights = self.values.values
        if not heights.size:
            raise ValueError(f"holds no heights: {UNREAD if self.file else 'give a file, or values'}")
        if self.columns is None:
            raise ValueError(
                f"{heights.size} heights: give columns, how many are in a row, or values of two axes"
            )
        rows, left = divmod(heights.size, self.columns)
        if left or not 4 <= rows <= FINEST // 2:
            raise ValueError(
                f"{heights.size} heights in rows of {self.columns}: 4 to {FINEST // 2} whole rows are expected; give a part of a"
                " larger map, or every second point"
            )
        if missing := int(np.sum(~np.isfinite(heights))):
            raise ValueError(
                f"{missing} of {heights.size} heights are missing; fill them in from their neighbours"
            )
        return self

    def _rows(self) -> Real:
        return self.values.values.reshape(-1, self.columns or 1)

    def level(self) -> Real:
        """Return the heights without their tilt, of shape (rows, columns), both even [m]."""
        values = self._rows()
        values = values[: values.shape[0] // 2 * 2, : values.shape[1] // 2 * 2]
        linear = np.column_stack([np.ones(values.size), *(each.ravel() for each in np.indices(values.shape))])
        fitted, *_ = np.linalg.lstsq(linear, values.ravel())
        return np.asarray(values - (linear @ fitted).reshape(values.shape))

    @property
    def rms(self) -> float:
        """Root mean square height [m]."""
        return float(self.level().std())

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
        """Return twice the points of the map along both axes, which are its own."""
        if points is not None:
            raise InputError(f"points = {points}: a measured surface has its own points; omit them")
        rows, columns = self._rows().shape
        return 4 * (rows // 2), 4 * (columns // 2)

    def heights(self, shape: tuple[int, int], periods: tuple[float, float], *, seed: int) -> Real:
        """Return the heights of the map and its mirror images [m], whatever the seed."""
        del shape, periods, seed
        level = self.level()
        return np.pad(level, [(0, length) for length in level.shape], mode="symmetric")

    def without_shortest_octave(self) -> MeasuredHeights:
        """Return the same surface without waves shorter than twice the shortest."""
        spectrum, wavenumber = self._spectrum()
        spectrum[wavenumber > math.pi / self.shortest * (1 + 1e-12)] = 0.0
        rows, columns = self.shape()
        values = np.fft.irfft2(spectrum, s=(rows, columns), norm="forward")[: rows // 2, : columns // 2]
        return MeasuredHeights(values=Samples(values.ravel()), columns=values.shape[1], spacing=self.spacing)

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
