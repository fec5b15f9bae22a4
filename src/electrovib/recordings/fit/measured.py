"""What was measured, as a fit takes it: recordings, their noise, and the drive, load and motion that they prescribe."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError, gathered, nearest, refuse
from electrovib.core.signals import SIGNALS
from electrovib.core.units import format_quantity
from electrovib.recordings.fit.rounding import resolution_of
from electrovib.recordings.interval import rough_noise
from electrovib.recordings.recording import CalibrationError

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario

PRESCRIBING: Final = {
    "drive_voltage": "drive",
    "drive_current": "drive",
    "normal_force": "load",
    "sliding_speed": "motion",
}
"""Signals of a recording that drive the model in the place of a part of the scenario."""
PRESCRIBED: Final = frozenset({"time", "frequency", "layer", *PRESCRIBING})
"""Signals that a scenario is given and does not predict."""
PROPORTIONAL: Final = frozenset({"impedance"})
"""Signals whose noise is proportional to their modulus unless stated otherwise."""
AXES: Final = ("time", "frequency")


@dataclass(frozen=True, kw_only=True)
class MeasuredTrace:
    """One recording of an experiment, with what a fit has to know beside its numbers.

    - `trace`: signals over ``time`` or over ``frequency``.
    - `changes`: settings under which it was recorded and in which it differs from the scenario, by dotted
      path.
    - `noise`: standard deviation of a signal in its unit, of each part where it is complex, or over its
      modulus where it is among `proportional`; what is absent is estimated from the scatter of the residuals.
    - `proportional`: signals whose noise is proportional to their modulus, as an impedance analyser's is.
    - `offsets`: signals whose zero is unknown; a constant is fitted to each.
    - `session`: day, finger or mounting to which the recording belongs; parameters may vary between sessions.
    - `calibration`: systematic errors, by default those of an import with a calibration, see
      `CalibrationError.attributes`.
    """

    trace: xarray.Dataset
    name: str = "recording"
    changes: Mapping[str, Any] = field(default_factory=dict)
    noise: Mapping[str, float] = field(default_factory=dict)
    proportional: Collection[str] = PROPORTIONAL
    offsets: Collection[str] = ()
    session: str = ""
    calibration: Mapping[str, CalibrationError] = field(default_factory=dict)

    def calibration_of(self, signal: str) -> CalibrationError | None:
        """Return the systematic error of a signal; None where it is not stated."""
        if signal in self.calibration:
            return self.calibration[signal]
        return CalibrationError.from_attributes(self.trace[signal].attrs)


@dataclass(frozen=True, kw_only=True)
class Observed:
    """One signal of one recording.

    - `x`: times or frequencies, increasing [s or Hz]; `y`: real or complex, in the signal's unit.
    - `noise`: standard deviation over `scale`; None where it is not stated. `noise_alone` is that stated,
      without the rounding that `noise` includes where the resolution is larger.
    - `scale`: what the noise is proportional to: 1 in the signal's unit, or the modulus of the data.
    - `offset`: whether its zero is unknown.
    - `resolution`: step to which a real signal was rounded; 0 where none is found in its values.
    - `calibration`: stated errors of gain and zero, which are no misfit; None without them and of complex signals.
    """

    signal: str
    axis: str
    x: Real
    y: NDArray[Any]
    noise: float | None
    scale: Real
    offset: bool
    resolution: float = 0.0
    noise_alone: float | None = None
    calibration: CalibrationError | None = None

    @property
    def relative(self) -> bool:
        """Whether the noise is proportional to the data."""
        return bool((self.scale != 1).any())

    @property
    def parts(self) -> int:
        """Real numbers for each sample: 2 of a complex signal."""
        return 2 if np.iscomplexobj(self.y) else 1

    @property
    def size(self) -> int:
        """Number of real numbers."""
        return self.x.size * self.parts


def observed(measured: MeasuredTrace, signals: Sequence[str] | None = None) -> tuple[Observed, ...]:
    """Collect the signals of a recording that a scenario predicts; samples that are no number are omitted."""
    trace = measured.trace
    offered = {
        str(name): str(variable.dims[0])
        for name, variable in trace.data_vars.items()
        if name in SIGNALS and name not in PRESCRIBED and len(variable.dims) == 1 and variable.dims[0] in AXES
    }
    wanted = list(offered) if signals is None else [name for name in signals if name in offered]
    problems = [
        f"{measured.name}: {what} = '{name}': the recording has no such signal.{nearest(name, offered)}"
        for what, names in (("noise", measured.noise), ("offsets", measured.offsets))
        for name in names
        if name not in offered
    ]
    problems += [
        f"{measured.name}: signals = '{name}': the scenario prescribes it, and a fit compares what a scenario predicts; omit it"
        for name in signals or ()
        if name in PRESCRIBED and name in trace.data_vars
    ]
    if not wanted and not problems and offered:
        problems += [
            f"{measured.name}: quantity = '{name}': the recording has no such signal.{nearest(name, offered)}"
            for name in signals or ()
        ]
    if not wanted and not problems:
        problems.append(
            f"{measured.name}: holds no signal to fit; it has {', '.join(map(str, trace.data_vars)) or 'no variables'}, and a"
            " fit takes signals of the nomenclature over time or frequency, such as electrostatic_force or impedance"
        )
    refuse(problems)
    return tuple(_observed(measured, name, offered[name]) for name in wanted)


def _observed(measured: MeasuredTrace, name: str, axis: str) -> Observed:
    x = np.asarray(measured.trace[axis].values, dtype=float)
    y = np.asarray(measured.trace[name].values)
    good = np.isfinite(y) & np.isfinite(x)
    noise = measured.noise.get(name)
    if noise is not None and not (np.isfinite(noise) and noise > 0):
        raise InputError(f"{measured.name}: noise.{name} = {noise}: expected a standard deviation above 0")
    if not good.any() or (np.diff(x[good]) <= 0).any():
        raise InputError(f"{measured.name}: {axis} of '{name}': expected increasing numbers")
    if name == "capacitance" and np.mean(y[good].real) < 0 and name not in measured.offsets:
        raise InputError(
            f"{measured.name}: 'capacitance' is {format_quantity(float(np.mean(y[good])), 'F', digits=3)} in the mean, and none"
            " is below 0: check the sign and the column; if too much stray capacitance was subtracted, let its zero be fitted:"
            " offsets = ['capacitance'], at the command line --zero capacitance"
        )
    scale = np.abs(y[good]) if name in measured.proportional else np.ones(good.sum())
    if (scale == 0).any():
        raise InputError(
            f"{measured.name}: '{name}' is 0 somewhere, where a noise proportional to it would be 0 too"
        )
    is_plain = not np.iscomplexobj(y) and name not in measured.proportional
    resolution = resolution_of(y[good]) if is_plain else 0.0
    return Observed(
        signal=name,
        axis=axis,
        x=x[good],
        y=y[good],
        noise=math.hypot(noise, resolution / math.sqrt(12)) if noise and resolution > noise else noise,
        scale=scale,
        offset=name in measured.offsets,
        resolution=resolution,
        noise_alone=noise,
        calibration=None if np.iscomplexobj(y) else measured.calibration_of(name),
    )


_SHARE: Final = {"drive": 0.005, "load": 0.02, "motion": 0.02}
"""Deviation over the largest value, beyond noise, up to which a recording has the course that the scenario declares."""
_FINE: Final = 1e-3
"""Deviation over the largest value, beyond noise, up to which a straight piece stands for recorded samples."""
_DEVIATIONS: Final = 3.0
_CORNERS: Final = (200, 2000)  # of a recorded load or motion, at most; beside a capacitance


def as_recorded(
    scenario: Scenario, measured: Sequence[MeasuredTrace], free: Sequence[str], keep: Collection[str] = ()
) -> tuple[list[MeasuredTrace], list[str]]:
    """Let the drive, load and motion of each recording drive the model of it, except those parts that are in `keep`.

    A recording that is, within its noise and 0.5 % of its largest value (2 % of a load or speed), the course
    of the scenario times a constant scales the scenario's formula by that constant. Every other one replaces
    it, linear between its samples. What differs from the scenario stands in the changes of each recording,
    and in a sentence with both numbers. A recording that contradicts a setting stated for it, or prescribes a
    part with a free parameter, is refused.
    """
    if unknown := [part for part in keep if part not in PRESCRIBING.values()]:
        raise InputError(f"keep = {unknown[0]}: expected drive, load or motion")
    found, said = [], []
    problems: list[str] = []
    for each in measured:
        changes: dict[str, Any] = {}
        own = scenario.replace(each.changes) if each.changes else scenario
        for signal, part in PRESCRIBING.items():
            if part in keep or signal not in each.trace or each.trace[signal].dims != ("time",):
                continue
            with gathered(problems):
                taken, words = _of_signal(own, each, signal)
                _refuse_contradiction(each, part, free, taken, words)
                changes |= taken
                said += [f"{each.name}: {words}"] if taken else []
        found.append(dataclasses.replace(each, changes=dict(each.changes) | changes) if changes else each)
    refuse(problems)
    return found, said


def _refuse_contradiction(
    measured: MeasuredTrace, part: str, free: Sequence[str], taken: dict[str, Any], words: str
) -> None:
    instead = f"take the scenario's with keep = ['{part}'], at the command line --keep {part}"
    if words and (own := [path for path in free if path.split(".")[0] == part]):
        raise InputError(
            f"{measured.name}: {own[0]} is free, but {words}: omit it from the free parameters, or {instead}"
        )
    if taken and (stated := [path for path in measured.changes if path.split(".")[0] == part]):
        raise InputError(
            f"{measured.name}: {stated[0]} = {measured.changes[stated[0]]} was stated, but {words}: omit it, or {instead}"
        )


def _of_signal(scenario: Scenario, measured: MeasuredTrace, signal: str) -> tuple[dict[str, Any], str]:
    """Return the changes by which a signal of a recording drives the scenario, none where they agree, and what to say."""
    part, unit = PRESCRIBING[signal], SIGNALS[signal].unit
    time, values = (np.asarray(measured.trace[name].values, dtype=float) for name in ("time", signal))
    good = np.isfinite(time) & np.isfinite(values) & (time >= 0)
    time, values = time[good], values[good]
    if time.size < 2:
        return {}, ""
    if part == "drive" and (scenario.drive.quantity == "current") != (signal == "drive_current"):
        raise InputError(
            f"{measured.name}: {signal} is recorded, but the scenario prescribes a {scenario.drive.quantity}: declare a drive of"
            " the same kind, or take the scenario's with keep = ['drive'], at the command line --keep drive"
        )
    declared = _declared(scenario, part, time)
    each = part == "load" and "capacitance" in measured.trace  # which follows the load of each sample at once
    spread = 0.0 if each else rough_noise(values)
    largest = float(np.max(np.abs(values)))
    limit = math.hypot(_DEVIATIONS * spread, _SHARE[part] * largest)
    course = f"the {part} has up to {format_quantity(largest, unit, digits=4)} in the recording, and"
    unknown = part == "motion" and scenario.motion.speed is None
    theirs = "none" if unknown else format_quantity(float(np.max(np.abs(declared))), unit, digits=4)
    words = f"{course} {theirs} in the scenario"
    factor, error = _factor(declared, values, spread)
    if math.isfinite(factor) and _off(declared * factor, values) <= limit:
        if abs(factor - 1) <= max(_DEVIATIONS * error, _SHARE[part] if part != "drive" else 1e-3):
            return {}, words
        if scaled := _scaled(scenario, part, unit, factor, time):
            return scaled, words
    if part == "drive":
        return _sampled(scenario, measured, time, values), words
    fine = 0.0 if each and time.size <= max(_CORNERS) else _DEVIATIONS * spread + _FINE * largest
    return _profile(measured, part, time, values, fine), words


def _declared(scenario: Scenario, part: str, time: Real) -> Real:
    """Return what the scenario prescribes at some times, in the unit of the signal."""
    if part == "drive":
        return scenario.drive.voltage(time)
    return scenario.load.forces(time) if part == "load" else scenario.motion.speeds(time)


def _neighbours(declared: Real) -> tuple[Real, Real]:
    """Return the lowest and highest value within one sample, between which an edge that is not sampled may lie."""
    wide = np.pad(declared, 1, mode="edge")
    three = np.stack([wide[:-2], wide[1:-1], wide[2:]])
    return np.min(three, axis=0), np.max(three, axis=0)


def _factor(declared: Real, values: Real, noise: float) -> tuple[float, float]:
    """Return the factor between both courses away from edges, and its standard deviation; NaN where there is none."""
    low, high = _neighbours(declared)
    even = high - low <= 0.01 * np.max(np.abs(declared))
    even = even if np.count_nonzero(even & (declared != 0)) >= 3 else np.ones(even.shape, bool)
    power = float(declared[even] @ declared[even])
    if not power:
        return math.nan, math.nan
    return float(declared[even] @ values[even]) / power, noise / math.sqrt(power)


def _off(declared: Real, values: Real) -> float:
    """Return the root mean square distance of a recording from a course, whose edges may be off by one sample."""
    low, high = _neighbours(declared)
    if np.mean(high - low) > 0.2 * np.max(np.abs(declared)):  # no sample is away from an edge
        low = high = declared
    return float(np.sqrt(np.mean((values - np.clip(values, low, high)) ** 2)))


def _scaled(scenario: Scenario, part: str, unit: str, factor: float, time: Real) -> dict[str, Any]:
    """Return the changes that scale a part of the scenario; none where they do not."""
    units = {unit, "V"} if part == "drive" else {unit}
    changes = {
        path: float(value) * factor
        for path, value, quantity in scenario.parameters()
        if path.split(".")[0] == part and quantity.unit in units and value is not None
    }
    try:
        found = _declared(scenario.replace(changes), part, time)
    except ElectrovibError:
        return {}
    wanted = factor * _declared(scenario, part, time)
    return changes if np.max(np.abs(found - wanted)) <= 1e-9 * np.max(np.abs(wanted)) else {}


def _sampled(scenario: Scenario, measured: MeasuredTrace, time: Real, values: Real) -> dict[str, Any]:
    """Return a drive through the recorded samples, from time 0 on."""
    if scenario.drive.quantity == "current":
        raise InputError(
            f"{measured.name}: its drive_current has another course than the scenario, and a recorded current is no drive:"
            " declare its course, or take the scenario's with keep = ['drive'], at the command line --keep drive"
        )
    if time[0] > 0:
        time, values = np.append(0.0, time), np.append(values[0], values)
    return {"drive": {"model": "Sampled", "time_samples": time.tolist(), "voltage_samples": values.tolist()}}


def _profile(measured: MeasuredTrace, part: str, time: Real, values: Real, limit: float) -> dict[str, Any]:
    """Return the load or speed as straight pieces between some of the recorded samples."""
    from scipy.interpolate import make_lsq_spline

    path = {"load": "load.normal_force", "motion": "motion.speed"}[part]
    if values.min() < -limit and values.max() > limit:
        raise InputError(
            f"{measured.name}: the {part} has both signs, which a scenario has not: crop the recording, or take the scenario's"
            f" with keep = ['{part}'], at the command line --keep {part}"
        )
    values = np.maximum(values if abs(values.max()) >= abs(values.min()) else -values, 0.0)
    corners = _corners(time, values, limit)
    while corners.size > _CORNERS["capacitance" in measured.trace]:
        limit *= 1.5
        corners = _corners(time, values, limit)
    ends = time[corners]
    smooth = make_lsq_spline(time, values, np.concatenate([ends[:1], ends, ends[-1:]]), k=1)
    levels = np.maximum(smooth(ends), 0.0)
    full = float(levels.max())
    shares = levels / (full or 1.0)
    points = [
        {"time": end, "share": share} for end, share in zip(ends.tolist(), shares.tolist(), strict=True)
    ]
    return {path: full, f"{part}.time_profile": {"model": "Corners", "points": points}}


def _corners(time: Real, values: Real, limit: float) -> np.ndarray:
    """Return the samples between which straight lines miss no other one by more than a limit (Ramer and Douglas-Peucker)."""
    kept, open_ones = {0, time.size - 1}, [(0, time.size - 1)]
    while open_ones:
        first, last = open_ones.pop()
        inside = slice(first + 1, last)
        if last - first < 2:
            continue
        straight = np.interp(time[inside], time[[first, last]], values[[first, last]])
        off = np.abs(values[inside] - straight)
        worst = int(np.argmax(off))
        if off[worst] > limit:
            at = first + 1 + worst
            kept.add(at)
            open_ones += [(first, at), (at, last)]
    return np.array(sorted(kept))
