"""What is felt: spectrum of the force on the skin, and its level above thresholds, given or published."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.perception import COMPLIANCES, MOTION, RYU, decibels, felt_amplitude
from electrovib.solve.simulate import simulate

if TYPE_CHECKING:
    import xarray

    from electrovib.core.arrays import Real
    from electrovib.physics.perception import Channel, Perception
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


THRESHOLD, COMPLIANCE = "perception.threshold", "perception.compliance"
"""What a person can measure, and what is assumed otherwise."""


@dataclass(frozen=True, kw_only=True)
class Sensation:
    """Lowest and highest level above the detection threshold [dB] of the channel that is excited most.

    `left` is half the range that would remain if `THRESHOLD` or `COMPLIANCE`, where assumed, were measured
    [dB].
    """

    channel: str
    low: float
    high: float
    left: dict[str, float]


def thresholds_of(person: Perception) -> list[tuple[Channel, float, float]]:
    """Return each channel with the lowest and highest amplitude at weight 1 that is just felt [dB re 1 m].

    Published thresholds stand in for one of the person; a channel without any is absent.
    """
    if person.threshold is not None:
        level, doubt = float(decibels(person.threshold)), person.threshold_uncertainty or 0.0
        return [(channel, level - doubt, level + doubt) for channel in person.channels]
    found = []
    for channel in person.channels:
        equal = [each.amplitude * float(channel.weight(each.frequency)) for each in channel.published]
        if equal := [each for each in equal if each > 0]:
            found.append((channel, float(decibels(min(equal))), float(decibels(max(equal)))))
    return found


def skins_of(found: Lines, given: Any) -> list[Any]:
    """Return the given mechanics, or the softest and the stiffest published skin; None for a measured displacement."""
    if found.signal == "skin_displacement":
        return [None]
    return [given] if given is not None else [each.skin for each in COMPLIANCES]


def sensation_of(found: Lines, person: Perception, given: Any) -> Sensation | None:
    """Compare a spectrum with the detection threshold; None where nothing moves, or no threshold is known."""
    known = thresholds_of(person)
    skins = skins_of(found, given)
    levels = np.array([[_level(found, channel, skin) for channel, *_ in known] for skin in skins])
    if not known or not np.any(np.isfinite(levels)):
        return None
    lowest = np.array([low for _, low, _ in known])
    highest = np.array([high for *_, high in known])
    top, bottom = (np.max(levels - edge, axis=1) for edge in (lowest, highest))
    middle = levels - (lowest + highest) / 2
    left = {}
    if person.threshold is None:
        left[THRESHOLD] = float(np.ptp(np.max(middle, axis=1))) / 2
    if len(skins) > 1:
        left[COMPLIANCE] = float(np.max(top - bottom)) / 2
    strongest = known[int(np.argmax(np.mean(middle, axis=0)))][0]
    return Sensation(
        channel=type(strongest).__name__, low=float(np.min(bottom)), high=float(np.max(top)), left=left
    )


def _level(found: Lines, channel: Channel, skin: Any) -> float:
    """Return the level of a channel [dB re 1 m]."""
    moved = found.amplitude if skin is None else found.amplitude * np.abs(skin.compliance(found.frequency))
    return float(decibels(felt_amplitude(channel, found.frequency, moved)))


def just_felt(found: Lines, person: Perception, given: Any, frequency: Real) -> tuple[Real, Real]:
    """Compute the lowest and highest amplitude of a single sine that is just felt; infinite where none is."""
    known = thresholds_of(person)
    given_skins = [
        1.0 if skin is None else np.abs(skin.compliance(frequency)) for skin in skins_of(found, given)
    ]

    def amplitudes(edges: list[float]) -> Real:
        felt = [
            [
                each[0].weight(frequency) * skin / 10 ** (edge / 20)
                for each, edge in zip(known, edges, strict=True)
            ]
            for skin in given_skins
        ]
        with np.errstate(divide="ignore"):
            return np.asarray(1 / np.max(felt, axis=1))

    low = np.min(amplitudes([each[1] for each in known]), axis=0)
    high = np.max(amplitudes([each[2] for each in known]), axis=0)
    return low, high


def _assumed(found: Lines, person: Perception, given: Any) -> list[str]:
    """List the published values that stand for what was not measured, each with its source and status."""
    texts = []
    if person.threshold is None:
        texts += [
            f"assumed threshold, {type(channel).__name__}: {format_quantity(each.amplitude, 'm', digits=3)} at"
            f" {each.frequency:g} Hz, {each.conditions} ({each.status}: {each.source}; taken as zero to peak)"
            for channel in person.channels
            for each in channel.published
        ]
    if len(skins_of(found, given)) > 1:
        texts += [
            f"assumed compliance, {each.conditions} ({each.status}: {each.source})" for each in COMPLIANCES
        ]
    return texts


def stands_on(found: Lines, person: Perception, given: Any) -> tuple[str, ...]:
    """List the assumptions and sources of the levels."""
    texts = [
        f"{type(channel).__name__}: {channel.status}; {channel.reference}" for channel in person.channels
    ]
    if found.signal == "skin_displacement":
        texts.append("mechanics: the displacement of the skin was measured")
    elif given is not None:
        texts.append(f"mechanics: {type(given).__name__} with the values of the scenario or the user")
    else:
        texts.append(
            "mechanics: none given, relative levels take the displacement as proportional to the force"
        )
    texts += _assumed(found, person, given)
    if person.threshold is not None:
        texts.append(
            f"threshold: {format_quantity(person.threshold, 'm', digits=4)} with an uncertainty of"
            f" {person.threshold_uncertainty:g} dB, given by the user"
        )
    texts.append(
        f"difference threshold: {person.difference_threshold:g} dB, taken as that of the voltage amplitude, which"
        f" {RYU}, does not state"
    )
    return (*texts, MOTION)
