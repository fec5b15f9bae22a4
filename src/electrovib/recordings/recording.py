"""A recording of a tribometer, calibrated, by a line through pairs of known value and reading too, and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from electrovib.core.errors import InputError, refuse
from electrovib.core.files import note_input
from electrovib.core.model import read_model
from electrovib.core.parsing import read_toml_file
from electrovib.data.registry import read_columns
from electrovib.physics.rig import EvenSamples, TimeColumn, TribometerChannels

if TYPE_CHECKING:
    import xarray
    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.sampled import StampTreatment


@dataclass(frozen=True, kw_only=True)
class SensorCalibration:
    """A straight calibration line: value = intercept + sensitivity reading, in SI.

    `covariance` is that of intercept and sensitivity, in that order; `residual` the standard deviation of the
    values about the line.
    """

    sensitivity: float
    intercept: float
    covariance: Real
    residual: float

    def value(self, reading: ArrayLike) -> Real:
        """Convert readings to values."""
        return np.asarray(self.intercept + self.sensitivity * np.asarray(reading, dtype=float))

    def standard_uncertainty(self, reading: ArrayLike) -> Real:
        """Return the standard uncertainty of values by that of the line, common to all samples: it does not average out."""
        at = np.asarray(reading, dtype=float)
        (first, both), (_, second) = self.covariance
        variance: Real = np.maximum(first + 2 * both * at + second * at**2, 0.0)
        return np.asarray(np.sqrt(variance))

    def error(self, *, zero_known: bool = False) -> CalibrationError:
        """Return the systematic error of a signal that the line has converted.

        With value v = a + b r of the reading r, deviations da and db change v by dz + g v, where g = db / b
        and dz = da - (a / b) db. `zero_known` says that a mean or trend of the signal has been subtracted,
        which removes the error of its zero.
        """
        (first, both), (_, second) = self.covariance
        ratio = self.intercept / self.sensitivity
        gain = float(np.sqrt(second)) / abs(self.sensitivity)
        if zero_known:
            return CalibrationError(gain=gain)
        zero = float(np.sqrt(max(first - 2 * ratio * both + ratio**2 * second, 0.0)))
        covariance = float((both - ratio * second) / self.sensitivity)
        largest = gain * zero  # exceeded only by rounding
        return CalibrationError(gain=gain, zero=zero, covariance=min(max(covariance, -largest), largest))


def calibrate(reading: ArrayLike, known: ArrayLike) -> SensorCalibration:
    """Fit a calibration line to readings at known values.

    Parameters
    ----------
    reading : array_like, shape (n,)
        Readings of the sensor, in the SI unit of the reading; at least three, not all equal.
    known : array_like, shape (n,)
        Known values, such as weights [N], without error.

    Returns
    -------
    SensorCalibration
        Least-squares line with its covariance, from the scatter of the values about it with n - 2 degrees of freedom.

    Raises
    ------
    InputError
        If there are fewer than three pairs, one is not finite, or all readings are equal.

    Notes
    -----
    The line is fitted to the values over the readings, which is unbiased if the scatter of the readings is small compared with
    their range.
    """
    x, y = np.asarray(reading, dtype=float), np.asarray(known, dtype=float)
    if x.ndim != 1 or x.shape != y.shape or x.size < 3 or not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise InputError(
            "calibrate: expected three or more pairs of finite numbers, a reading and a known value"
        )
    if not np.ptp(x):
        raise InputError("calibrate: all readings are equal; they have to cover the range of the sensor")
    (sensitivity, intercept), covariance = np.polyfit(x, y, 1, cov=True)
    left = y - intercept - sensitivity * x
    return SensorCalibration(
        sensitivity=float(sensitivity),
        intercept=float(intercept),
        covariance=covariance[::-1, ::-1],
        residual=float(np.sqrt(np.sum(left**2) / (x.size - 2))),
    )


_ATTRIBUTES: Final = {
    "gain": "gain_uncertainty",
    "zero": "zero_uncertainty",
    "covariance": "gain_zero_covariance",
}
"""Number of a calibration error to the attribute of the signal that holds it."""


@dataclass(frozen=True, kw_only=True)
class CalibrationError:
    """Systematic error of a measured signal: values = true values times (1 + gain error) + zero error.

    `gain` is the standard uncertainty of the gain over the gain, `zero` that of the zero in the unit of the
    signal, and `covariance` that of both, in the same unit.
    """

    gain: float = 0.0
    zero: float = 0.0
    covariance: float = 0.0

    def __post_init__(self) -> None:
        numbers = (self.gain, self.zero, self.covariance)
        if not np.isfinite(numbers).all() or self.gain < 0 or self.zero < 0:
            raise InputError(
                f"gain error {self.gain:g}, zero error {self.zero:g}: expected finite uncertainties of 0 or more"
            )
        if abs(self.covariance) > self.gain * self.zero * (1 + 1e-9):
            raise InputError(
                f"covariance of gain and zero {self.covariance:g}: expected at most the product of both uncertainties"
            )

    def attributes(self) -> dict[str, float]:
        """Return the error as attributes of the signal."""
        return {attribute: float(getattr(self, name)) for name, attribute in _ATTRIBUTES.items()}

    @classmethod
    def from_attributes(cls, attributes: Mapping[Any, Any]) -> CalibrationError | None:
        """Read the error from the attributes of a signal; None where no attribute states an error other than 0."""
        try:
            stated = {name: float(attributes.get(attribute, 0.0)) for name, attribute in _ATTRIBUTES.items()}
        except (TypeError, ValueError):
            raise InputError(f"attributes {', '.join(_ATTRIBUTES.values())}: expected numbers") from None
        return cls(**stated) if any(stated.values()) else None


if TYPE_CHECKING:
    Recorded: TypeAlias = "Recording | xarray.Dataset | str | Path"
    Channels: TypeAlias = "TribometerChannels | Mapping[str, Any] | str | Path"


_FEWEST = 100
"""Smallest number of samples of a record."""


@dataclass(frozen=True, kw_only=True)
class Recording:
    """A calibrated recording of a tribometer; the zeros of its forces are still those of the sensors.

    - `position`: position of the carriage, 0 at the first sample, continuous where the encoder wraps `wraps`
      times; None without an encoder.
    - `step`: length of one count of the encoder [m]; 0 without one.
    - `missing`: number of rows that were omitted because they held a NaN.
    - `at_rail`: for ``normal`` and ``lateral``, True where the sensor is at the end of its range.
    """

    time: Real
    normal_force: Real
    lateral_force: Real
    position: Real | None
    step: float
    channels: TribometerChannels
    source: str
    wraps: int
    missing: int
    at_rail: Mapping[str, NDArray[np.bool_]]

    @property
    def forces(self) -> Real:
        """Normal and lateral force [N], shape (2, n)."""
        return np.stack([self.normal_force, self.lateral_force])

    def ends(self, span: Span) -> tuple[float, float]:
        """Return the times of the first and the last sample of a section [s]."""
        return float(self.time[span[0]]), float(self.time[span[1] - 1])


def read_recording(path: Path, channels: TribometerChannels) -> Recording:
    """Read and calibrate a recording of a tribometer.

    Parameters
    ----------
    path : Path
        Any file from which `electrovib.data.registry.read_columns` reads columns: ``.mat``, ``.csv``, ``.npy`` ...
    channels : TribometerChannels
        Assignment of the columns, and their calibration.

    Returns
    -------
    Recording
        Calibrated recording, in SI.

    Raises
    ------
    InputError
        If the file or a column cannot be read, or if a column is no record.
    """
    return calibrated(read_columns(path, _columns(channels), missing=True), channels, source=str(path))


def _columns(channels: TribometerChannels) -> dict[str, tuple[str | int, str]]:
    """Name and unit of each column that holds a part of the record."""
    forces = (("normal", channels.normal), ("lateral", channels.lateral))
    found: dict[str, tuple[str | int, str]] = {name: (each.column, each.read_as) for name, each in forces}
    if channels.encoder is not None:
        found["encoder"] = (channels.encoder.column, "1")
    if isinstance(channels.clock, TimeColumn):
        found["time"] = (channels.clock.column, channels.clock.unit)
    return found


def calibrated(
    columns: Mapping[str, Real], channels: TribometerChannels, *, source: str = "the recording"
) -> Recording:
    """Compute forces and a position from the columns ``normal``, ``lateral``, ``encoder`` and ``time`` of a tribometer."""
    needed = _columns(channels)
    given = {name: np.asarray(columns[name], dtype=np.float64) for name in needed if name in columns}
    problems = [f"{source}: there is no column '{name}'." for name in needed if name not in given]
    problems += [fault for name, values in given.items() for fault in _faults(source, name, values)]
    if len({values.shape for values in given.values()}) > 1:
        sizes = ", ".join(f"{name} {len(values)}" for name, values in given.items())
        problems.append(f"{source}: the columns differ in length: {sizes}.")
    refuse(problems)
    whole = without_missing(given, channels.missing_rows, source)
    rows = np.flatnonzero(whole)  # an omitted row leaves a gap in time
    if isinstance(channels.clock, TimeColumn):
        rows = rows[increasing(given["time"][rows], channels.clock.stamps, source)]
        time = given["time"][rows] - given["time"][rows[0]]
    else:
        assert isinstance(channels.clock, EvenSamples)
        time = rows / channels.clock.rate
    given = {name: values[rows] for name, values in given.items()}
    encoder = channels.encoder
    return Recording(
        time=time,
        normal_force=channels.normal.force(given["normal"]),
        lateral_force=channels.lateral.force(given["lateral"]),
        position=None if encoder is None else encoder.position(given["encoder"]),
        step=0.0 if encoder is None else abs(encoder.step),
        channels=channels,
        source=source,
        wraps=0 if encoder is None else int(np.count_nonzero(np.diff(encoder.wraps(given["encoder"])))),
        missing=int(np.count_nonzero(~whole)),
        at_rail={name: at_rail(given[name]) for name in ("normal", "lateral")},
    )


def increasing(time: Real, stamps: StampTreatment, source: str) -> NDArray[np.bool_]:
    """Return which samples of a record to keep so that time stamps increase, or refuse the record; 100 have to be left."""
    try:
        kept = stamps.keep(time)
    except ValueError as error:
        fault = str(error).partition(". To drop")[0]
        raise InputError(
            f"{fault}. With stamps KeepIncreasing such samples are dropped.", path=source
        ) from None
    if np.count_nonzero(kept) < _FEWEST:
        raise InputError(
            f"only {np.count_nonzero(kept)} samples with increasing time stamps are left.", path=source
        )
    return kept


def without_missing(columns: Mapping[str, Real], allowed: int, source: str) -> NDArray[np.bool_]:
    """Find the rows of a record in which every value is a finite number; refuse if more than `allowed` are not."""
    kept = np.all([np.isfinite(values) for values in columns.values()], axis=0)
    missing = int(np.count_nonzero(~kept))
    if missing <= allowed:
        return np.asarray(kept)
    faults = []
    for name, values in columns.items():
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            faults.append(f"column '{name}', sample {bad[0]}: {values[bad[0]]} is not a finite number")
    may = f"missing_rows = {missing} omits them" if allowed == 0 else f"missing_rows = {allowed} allows fewer"
    rows = "1 row" if missing == 1 else f"{missing} rows"
    raise InputError(f"{'; '.join(faults)}. This concerns {rows} of {len(kept)}; {may}.", path=source)


def omitted_rows(missing: int) -> list[str]:
    """Write how many rows were omitted because they held a NaN."""
    if not missing:
        return []
    rows = "1 row that holds a NaN was" if missing == 1 else f"{missing} rows that hold a NaN were"
    return [f"{rows} omitted."]


def _faults(source: str, name: str, values: Real) -> list[str]:
    if values.ndim != 1 or len(values) < _FEWEST:
        return [
            f"{source}: column '{name}' has shape {values.shape}; a row of at least {_FEWEST} samples is needed."
        ]
    if name in {"normal", "lateral"} and np.all(values == values[0]):
        return [f"{source}: column '{name}' holds {values[0]:g} throughout; is it the right column?"]
    return []


_FORCES = {
    "normal": ("normal_force_measured", "normal_force"),
    "lateral": ("lateral_force_measured", "lateral_force"),
}


def recording_of(
    record: Recorded, *, channels: Channels | None = None, speed: float | str | None = None
) -> Recording:
    """Open a recording of a tribometer; the position of a Trace is the integral of its sliding speed."""
    if channels is not None:
        if not isinstance(record, (str, Path)) or speed is not None:
            why = "; a Trace is calibrated already" if speed is None else ", and states its speed too"
            raise InputError(f"channels: belongs to a file of an instrument{why}")
        note_input(Path(record))
        return read_recording(Path(record), _channels(channels))
    if isinstance(record, Recording):
        return record
    source = "the Trace"
    if isinstance(record, (str, Path)):
        from electrovib.data.traces import open_trace

        source, record = str(record), open_trace(record)
    return _of_trace(record, speed, source)


def _channels(channels: Channels) -> TribometerChannels:
    if isinstance(channels, TribometerChannels):
        return channels
    if isinstance(channels, Mapping):
        return read_model(TribometerChannels, channels)
    path = Path(channels)
    advice = "--recipe names the calibration of the columns"
    content = read_toml_file(path, kind="a file of channels", advice=advice)
    try:
        return read_model(TribometerChannels, content)
    except InputError as error:
        raise InputError(f"{path}: {problem}" for problem in error.problems) from None


def _of_trace(trace: xarray.Dataset, speed: float | str | None, source: str) -> Recording:
    names = {
        part: next((each for each in wanted if each in trace and trace[each].dims == ("time",)), "")
        for part, wanted in _FORCES.items()
    }
    if lacking := [part for part, name in names.items() if not name]:
        held = ", ".join(str(name) for name in trace.data_vars) or "none"
        raise InputError(
            f"{source}: a swipe needs a {lacking[0]} force over time; the signals are {held}. Import it with"
            f" --column {_FORCES[lacking[0]][0]}=COLUMN, or name the columns of the file of the instrument with --recipe"
        )
    moved = "sliding_speed" in trace and trace["sliding_speed"].dims == ("time",)
    if moved and speed is not None:
        raise InputError("speed: the Trace has a sliding_speed; omit one of them")
    channels = read_model(
        TribometerChannels,
        {
            **{part: {"column": name, "unit": "N"} for part, name in names.items()},
            "clock": {"model": "TimeColumn", "column": "time"},
            "speed": speed,
        },
    )
    rows = np.all([np.isfinite(trace[name].values) for name in names.values()], axis=0)
    columns: dict[str, Real] = {part: trace[name].values[rows] for part, name in names.items()}
    found = calibrated({**columns, "time": trace["time"].values[rows]}, channels, source=source)
    found = replace(found, missing=int(np.count_nonzero(~rows)))
    if not moved:
        return found
    pace = np.nan_to_num(np.asarray(trace["sliding_speed"].values[rows], dtype=float))
    steps = np.diff(found.time) * (pace[1:] + pace[:-1]) / 2
    return replace(found, position=np.append(0.0, np.cumsum(steps)))


REPEATS = 10
"""Number of equal extreme samples from which on they are no coincidence."""
_MORE = 3
"""Factor by which the extreme reading occurs more often than any other in its half of the range."""
_STEP = 1.5
"""Width, in units of the distance of two readings, within which others are counted that could flicker as they do."""
_NOISE = 0.5
"""Median difference of successive changes inside the range, in steps of the converter, below which there is no noise."""
_BETWEEN = 0.1
"""Smallest share of samples between the extremes; a square wave has fewer."""


def at_rail(reading: Real) -> NDArray[np.bool_]:
    """Find the samples at which a sensor is at the end of its range, at a reading that occurs much more often than any other.

    A converter at the end of its range repeats one number, while a force within the range comes with noise. A
    reading whose noise is less than a step of the converter is never found, nor one that is limited by an
    amplifier before the converter, because it keeps the noise of the converter. A dead band, in which a small
    force reads exactly 0, cannot be distinguished from the end of the range; it hides the zero of the sensor
    too.
    """
    found = at_extreme(reading)
    if not found.any():
        return found
    inside = (reading != reading.min()) & (reading != reading.max()) & ~found
    change = np.diff(reading)
    together = inside[2:] & inside[1:-1] & inside[:-2]
    step = float(np.min(np.abs(change[change != 0]), initial=np.inf))
    noise = np.abs(np.diff(change))[together]
    return found if len(noise) and np.median(noise) > _NOISE * step else np.zeros_like(found)


def at_extreme(reading: Real) -> NDArray[np.bool_]:
    """Find the samples at a highest or lowest reading that repeats, at a rail or because the quantity is constant.

    Two readings that are one step of the converter apart count as one, which flickers.
    """
    extremes = [reading.min(), reading.max()] if len(reading) else [np.nan]
    if all(np.isfinite(end) and 2 * np.count_nonzero(reading == end) < REPEATS for end in extremes):
        return np.zeros(len(reading), dtype=np.bool_)  # as neither end repeats often enough
    levels, counts = np.unique(reading, return_counts=True)
    found = np.zeros(len(reading), dtype=np.bool_)
    for upwards in (True, False):
        values, often = (levels, counts) if upwards else (-levels[::-1], counts[::-1])
        if (ends := _repeated_end(values, often)) > 0:
            extreme = values[ends - 1]
            found |= (reading <= extreme) if upwards else (-reading <= extreme)
    between = (reading != levels[0]) & (reading != levels[-1]) & ~found
    return found if np.mean(between) >= _BETWEEN else np.zeros_like(found)


def _repeated_end(levels: Real, counts: NDArray[np.intp]) -> int:
    """Return how many of the lowest levels, one or two that are a step apart, occur much more often than all others."""
    if levels.size < 2:
        return 0
    near = np.flatnonzero(levels <= (levels[0] + levels[-1]) / 2)
    if counts[0] >= max(REPEATS, _MORE * int(np.max(counts[near[1:]], initial=0))):
        return 1
    if levels.size < 3 or near.size < 2 or counts[0] < max(REPEATS / 2, _MORE * counts[2]):
        return 0
    ends = np.searchsorted(levels, levels[near[2:]] + _STEP * (levels[1] - levels[0]))
    below = np.append(0, np.cumsum(counts))
    others = below[ends] - below[near[2:]]
    return 2 if counts[:2].sum() >= max(REPEATS, _MORE * int(np.max(others, initial=0))) else 0


Span = tuple[int, int]
"""Index of the first sample of a section, and of the sample after its last."""


def closed(mask: NDArray[np.bool_], count: int) -> NDArray[np.bool_]:
    """Fill gaps between two true sections that are shorter than a number of samples."""
    filled = mask.copy()
    for first, last in runs(~mask):
        if first > 0 and last < len(mask) and last - first < count:
            filled[first:last] = True
    return filled


def runs(mask: NDArray[np.bool_]) -> list[Span]:
    """Return the sections in which a condition holds."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]
