"""Spectrum of the force on the skin, of a period or of a window: the input of perception."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.simulate import simulate

if TYPE_CHECKING:
    import xarray

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario

FEWEST: Final = 1 << 13
"""First number of samples of a period or window: 250 Hz is harmonic 17 of 15 Hz, so aliasing is small."""
MOST: Final = 1 << 19
COARSEST: Final = 2.0**-13
"""First step where a period or window is long [s]: the spectrum reaches 4 kHz."""
SIGNALS: Final = ("skin_displacement", "lateral_force", "electrostatic_force")
"""Signals of a measured Trace; the first that it has is used."""


@dataclass(frozen=True, kw_only=True)
class Lines:
    """Line spectrum of a signal, a force [N] or a displacement [m], with amplitudes from zero to peak.

    `swing` is half of the peak-to-peak value, the value just before the span included; `how` is the span in
    words.
    """

    frequency: Real
    amplitude: Real
    swing: float
    span: float
    samples: int
    signal: str
    how: str


def lines(values: Real, *, span: float, before: float, signal: str, how: str) -> Lines:
    """Compute the spectrum of a record at evenly spaced times.

    The lines are at the whole multiples of 1/span up to half the sampling rate. `span` is n times the step
    [s]; `before` is the value just before the record, for one whole period the last value. The transform of
    the increments is divided by that of a unit step. For a whole period this is the Fourier series. For a
    record that does not end where it began it adds no step at the end; a step at the beginning is included.
    """
    count = len(values)
    orders = np.arange(1, count // 2 + 1)
    changes = np.fft.rfft(np.diff(values, prepend=before))[1 : len(orders) + 1]
    change = 2 * np.abs(np.sin(np.pi * orders / count))
    amplitude = 2 * np.abs(changes) / change / count
    swing = float(max(np.max(values), before) - min(np.min(values), before)) / 2
    return Lines(
        frequency=orders / span,
        amplitude=amplitude,
        swing=swing,
        span=span,
        samples=count,
        signal=signal,
        how=how,
    )


def force_lines(scenario: Scenario, *, window: float, samples: int) -> tuple[Lines, ...]:
    """Compute the spectrum of the friction force of a scenario, with a step of at most 0.12 ms.

    A periodic drive has one, of a period of the steady state, whatever the initial state of the scenario; any
    other drive one for each window, from rest, overlapping by half.
    """
    period = scenario.drive.period
    if period is None:
        return _from_rest(scenario, window, samples)
    count = _enough(samples, period)
    settled = scenario.replace({"time.initial_state": {"model": "PeriodicState"}})
    times = _middles(count, period / count)
    try:
        force = simulate(settled, time=times).lateral_force.values
    except InputError as error:
        if not any(problem.path == "time.initial_state" for problem in error.problems):
            raise
        return _late(scenario, window, samples)
    if np.any(np.isnan(force)):
        return _late(scenario, window, samples)
    how = f"one period of {period:.4g} s in the steady state"
    return (lines(force, span=period, before=float(force[-1]), signal="lateral_force", how=how),)


def _middles(count: int, step: float) -> Real:
    """Return the middles of even steps [s], so that a discontinuity at the end of a step falls between two samples."""
    return np.asarray(step * (np.arange(count) + 0.5), dtype=float)


def _lateral(scenario: Scenario, times: Real) -> Real:
    force: Real = simulate(scenario, time=times).lateral_force.values
    if np.all(np.isnan(force)):
        raise InputError(
            "motion.speed: the finger rests, where its friction is not determined, so there is nothing to feel; set a speed"
            " above 0, omit it for a finger that slides, or add [finger], whose spring determines the friction at rest"
        )
    return force


def _enough(samples: int, span: float, *, begin: int | None = None) -> int:
    """Double the number of samples until the step is short enough."""
    count = begin or samples
    while span / count > COARSEST * FEWEST / samples and count < MOST:
        count *= 2
    return count


def _from_rest(scenario: Scenario, window: float, samples: int) -> tuple[Lines, ...]:
    start = scenario.replace({"time.initial_state": {"model": "AtRest"}})
    count = _enough(samples, window)
    step = window / count
    halves = max(2, int(np.ceil(2 * scenario.drive.duration / window - 1e-9)))
    force = _lateral(start, _middles(halves * count // 2, step))
    quiet = start.replace({"drive": {"model": "Step", "level": 0.0}})
    before = float(simulate(quiet, time=_middles(2, step)).lateral_force.values[0])
    return _windows(force, count, step, before=before, signal="lateral_force", what="from rest")


def _windows(
    values: Real, count: int, step: float, *, before: float | None, signal: str, what: str
) -> tuple[Lines, ...]:
    """Compute the spectra of windows that overlap by half; the value before the first may be known."""
    found = []
    for first in range(0, max(len(values) - count, 0) + 1, count // 2):
        part = values[first : first + count]
        previous = float(values[first - 1]) if first else float(values[0]) if before is None else before
        if np.any(np.isnan(part)):
            continue  # the finger rests, or the friction still depends on that
        previous = float(part[0]) if math.isnan(previous) else previous
        span = len(part) * step
        how = f"{what}, window of {span:.4g} s from {first * step:.4g} s on"
        found.append(lines(part, span=span, before=previous, signal=signal, how=how))
    if not found:
        raise InputError(
            f"motion.time_profile: in every window of the {signal.replace('_', ' ')} the finger rests at times, where friction"
            " is not determined; set a shorter perception.window or a time profile that slides for longer, or add [finger]"
        )
    return tuple(found)


def _late(scenario: Scenario, window: float, samples: int) -> tuple[Lines, ...]:
    """Compute the spectrum of the periods after a window of as many, where no steady state is known beforehand."""
    period = scenario.drive.period
    assert period is not None
    repeats = max(1, int(window / period * (1 + 1e-12)))
    span = repeats * period
    count = _enough(
        samples, span, begin=samples // 8
    )  # time stepping is slow, and convergence of the level is checked afterwards
    start = scenario.replace({"time.initial_state": {"model": "AtRest"}})
    force = _lateral(start, _middles(2 * count, span / count))
    if np.any(np.isnan(force[count - 1 :])):
        raise InputError(
            "motion.time_profile: the finger rests while its friction would be felt, and that friction is not determined; set"
            " a time profile that slides for longer, or add [finger], whose spring determines the friction at rest"
        )
    how = (
        f"{repeats} period(s) of {period:.4g} s from rest, after as many omitted ones; not known to be steady"
    )
    return (lines(force[count:], span=span, before=float(force[count - 1]), signal="lateral_force", how=how),)


def measured_lines(trace: xarray.Dataset, *, window: float) -> tuple[Lines, ...]:
    """Compute the spectrum of each window of a measured Trace; the windows overlap by half."""
    name = next((name for name in SIGNALS if name in trace), None)
    if name is None:
        raise InputError(f"this Trace has no signal to feel: it needs one of {', '.join(SIGNALS)}")
    if trace[name].dims != ("time",):
        raise InputError(
            f"{name} has the dimensions {', '.join(map(str, trace[name].dims))}: choose one member, for instance"
            " trace.isel(...), so that only time is left"
        )
    time, values = trace.time.values, trace[name].values
    if len(time) < 16 or not np.all(np.isfinite(values)) or not np.all(np.diff(time) > 0):
        raise InputError(f"{name}: needs at least 16 finite values at increasing times")
    step = float(time[-1] - time[0]) / (len(time) - 1)
    even = time[0] + step * np.arange(len(time))
    uneven = float(np.max(np.abs(time - even))) > 1e-3 * step
    if uneven:
        step = float(np.min(np.diff(time)))
        even = np.arange(time[0], time[-1], step)
        values = np.interp(even, time, values)
    count = min(len(values), max(16, round(window / step)))
    what = f"measured {name}" + (", interpolated linearly to even times" if uneven else "")
    return _windows(np.asarray(values, dtype=float), count, step, before=None, signal=name, what=what)
