"""What is felt: spectrum of the force on the skin, its level above thresholds, and threshold voltages of drives."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.perception import (
    COMPLIANCES,
    MOTION,
    RYU,
    Channel,
    Perception,
    decibels,
    felt_amplitude,
    strongest,
)

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
        force = _force(settled, times)
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


def _force(scenario: Scenario, times: Real) -> Real:
    """Return the friction force alone [N], without judging the run."""
    from electrovib.solve.expanded import Expanded

    _, values = Expanded(scenario, times).at(times, wanted={"lateral_force"}).signals["lateral_force"]
    return np.asarray(values, dtype=float)


def _lateral(scenario: Scenario, times: Real) -> Real:
    force = _force(scenario, times)
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
    before = float(_force(quiet, _middles(2, step))[0])
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


@dataclass(frozen=True)
class Stimulus:
    """A spectrum, the person who feels it, and the mechanics in between.

    `skin` is None where the displacement was measured, or counts as proportional to the force.
    """

    lines: Lines
    person: Perception
    skin: Any

    @property
    def is_displacement(self) -> bool:
        """Whether the displacement of the skin was measured."""
        return self.lines.signal == "skin_displacement"

    @property
    def moved(self) -> Real:
        """Displacement at each line [m], or the force [N] without mechanics."""
        return self.lines.amplitude * compliance(self.skin, self.lines.frequency)

    @functools.cached_property
    def level(self) -> float:
        """Level of the channel that is excited most [dB re 1 m, or 1 N]."""
        return float(decibels(strongest(self.person, self.lines.frequency, self.moved)))

    @functools.cached_property
    def reference(self) -> float:
        """Felt amplitude of a sine of equal force at the best frequency."""
        best = np.array([self.person.most_sensitive().best()])
        return strongest(self.person, best, self.lines.swing * compliance(self.skin, best))


def compliance(skin: Any, frequency: Real) -> Real:
    """Return the magnitude of the compliance of a skin [m/N]; 1 without one."""
    return np.ones(np.shape(frequency)) if skin is None else np.asarray(np.abs(skin.compliance(frequency)))


def loudest(windows: Iterable[Lines], person: Perception, skin: Any) -> Stimulus:
    """Return the window that is felt most."""
    return max((Stimulus(each, person, skin) for each in windows), key=lambda each: each.level)


def felt_level(scenario: Scenario, person: Perception) -> float:
    """Compute the amplitude of a sine at the best frequency that is felt as strongly [m, or N without mechanics]."""
    windows = force_lines(scenario, window=person.window, samples=FEWEST)
    return float(10 ** (loudest(windows, person, person.compliance or scenario.finger).level / 20))


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


def skins_of(felt: Stimulus) -> list[Any]:
    """Return the given mechanics, or the softest and the stiffest published skin; None for a measured displacement."""
    if felt.is_displacement:
        return [None]
    return [felt.skin] if felt.skin is not None else [each.skin for each in COMPLIANCES]


def sensation_of(felt: Stimulus) -> Sensation | None:
    """Compare a spectrum with the detection threshold; None where nothing moves, or no threshold is known."""
    known, skins, lines = thresholds_of(felt.person), skins_of(felt), felt.lines
    moved = [lines.amplitude * compliance(skin, lines.frequency) for skin in skins]
    levels = np.array(
        [
            [float(decibels(felt_amplitude(channel, lines.frequency, each))) for channel, *_ in known]
            for each in moved
        ]
    )
    if not known or not np.any(np.isfinite(levels)):
        return None
    lowest = np.array([low for _, low, _ in known])
    highest = np.array([high for *_, high in known])
    top, bottom = (np.max(levels - edge, axis=1) for edge in (lowest, highest))
    middle = levels - (lowest + highest) / 2
    left = {}
    if felt.person.threshold is None:
        left[THRESHOLD] = float(np.ptp(np.max(middle, axis=1))) / 2
    if len(skins) > 1:
        left[COMPLIANCE] = float(np.max(top - bottom)) / 2
    first = known[int(np.argmax(np.mean(middle, axis=0)))][0]
    return Sensation(
        channel=type(first).__name__, low=float(np.min(bottom)), high=float(np.max(top)), left=left
    )


def just_felt(felt: Stimulus, frequency: Real) -> tuple[Real, Real]:
    """Compute the lowest and highest amplitude of a single sine that is just felt; infinite where none is."""
    channels, lowest, highest = zip(*thresholds_of(felt.person), strict=True)
    weights = np.array([channel.weight(frequency) for channel in channels])
    skins = np.array([compliance(skin, frequency) for skin in skins_of(felt)])

    def amplitudes(edges: Sequence[float]) -> Real:
        alike = skins[:, None] * weights / 10 ** (np.array(edges)[:, None] / 20)
        with np.errstate(divide="ignore"):
            return np.asarray(1 / np.max(alike, axis=1))

    return np.min(amplitudes(lowest), axis=0), np.max(amplitudes(highest), axis=0)


def _assumed(felt: Stimulus) -> list[str]:
    """List the published values that stand for what was not measured, each with its source and status."""
    texts, person = [], felt.person
    if person.threshold is None:
        texts += [
            f"assumed threshold, {type(channel).__name__}: {format_quantity(each.amplitude, 'm', digits=3)} at"
            f" {each.frequency:g} Hz, {each.conditions} ({each.status}: {each.source}; taken as zero to peak)"
            for channel in person.channels
            for each in channel.published
        ]
    if len(skins_of(felt)) > 1:
        texts += [
            f"assumed compliance, {each.conditions} ({each.status}: {each.source})" for each in COMPLIANCES
        ]
    return texts


def stands_on(felt: Stimulus) -> tuple[str, ...]:
    """List the assumptions and sources of the levels."""
    person = felt.person
    texts = [
        f"{type(channel).__name__}: {channel.status}; {channel.reference}" for channel in person.channels
    ]
    if felt.is_displacement:
        texts.append("mechanics: the displacement of the skin was measured")
    elif felt.skin is not None:
        texts.append(f"mechanics: {type(felt.skin).__name__} with the values of the scenario or the user")
    else:
        texts.append(
            "mechanics: none given, relative levels take the displacement as proportional to the force"
        )
    texts += _assumed(felt)
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


Pair = Callable[[float], "tuple[Scenario, Scenario]"]


@dataclass(frozen=True)
class ThresholdCurves:
    """Threshold voltage of each drive over its fundamental frequency, relative to the lowest of all [dB].

    `voltage` is the peak at threshold [V]; it is empty where the threshold is not calibrated.
    """

    frequency: Real
    level: Mapping[str, Real]
    voltage: Mapping[str, Real]


def threshold_over_frequency(
    scenario: Scenario,
    frequencies: Sequence[float] | Real,
    drives: Mapping[str, Mapping[str, Any]],
    *,
    perception: Perception | None = None,
) -> ThresholdCurves:
    r"""Compute the threshold voltage of waveforms over their frequency, which replaces that of each table of `drives`.

    The change of the friction has to be proportional to the square of the voltage, which excludes a non-ohmic
    leak and a PowerLaw; a drive of peak V whose felt amplitude is X is then just felt at

    .. math:: V_0 = V \sqrt{X_0/X}
    """
    _proportional(scenario)
    person = perception or getattr(scenario, "perception", None) or Perception()
    places = np.asarray(frequencies, dtype=float)
    at_threshold: dict[str, Real] = {}
    for name, drive in drives.items():
        cases = [scenario.replace({"drive": {**drive, "frequency": float(place)}}) for place in places]
        felt = np.array([felt_level(case, person) for case in cases])
        peaks = np.array([case.drive.largest() for case in cases])
        at_threshold[name] = peaks / np.sqrt(np.maximum(felt, np.finfo(float).tiny))
    lowest = min(float(np.min(row)) for row in at_threshold.values())
    level = {name: 20 * np.log10(row / lowest) for name, row in at_threshold.items()}
    absolute = person.compliance or getattr(scenario, "finger", None)
    voltage: dict[str, Real] = {}
    if person.threshold is not None and absolute is not None:
        voltage = {name: row * np.sqrt(person.threshold) for name, row in at_threshold.items()}
    return ThresholdCurves(places, level, voltage)


def not_proportional(scenario: Scenario) -> list[str]:
    """Return the parts for which changes of friction are not proportional to the square of the voltage."""
    leaks = [f"stack.{name}.leak" for name, layer in scenario.stack.layers.items() if layer.leak is not None]
    friction, contact, limited = scenario.friction, scenario.contact, scenario.circuit.supply.is_limited
    bends = friction.deflects or not friction.without_memory().is_linear
    yields = contact.closing is not None or contact.grows
    return [*leaks, *["friction"] * bends, *["contact"] * yields, *["circuit.amplifier"] * limited]


def _proportional(scenario: Scenario) -> None:
    """Refuse a scenario whose changes of friction are not proportional to the square of the voltage."""
    if parts := not_proportional(scenario):
        raise InputError(
            f"{parts[0]}: with it the change of the friction is not proportional to the square of the voltage, so one run gives"
            " no threshold; perceive the scenario at several voltages instead"
        )


def threshold_ratio(first: Scenario, second: Scenario, person: Perception) -> float:
    """Compute the threshold voltage of a drive relative to that of another drive of the same peak [dB]."""
    for each in (first, second):
        _proportional(each)
    felt = [felt_level(scenario, person) for scenario in (second, first)]
    return float(10 * np.log10(felt[0] / felt[1]))


def crossover(pair: Pair, *, low: float, high: float, person: Perception) -> float:
    """Find the lowest frequency [Hz] at which two drives of the same peak voltage have the same threshold voltage.

    The search proceeds by octaves, and two crossings within one are not found. The result is 0 if the second
    drive is not felt at a lower voltage even at `low`, infinite if it is at every octave up to `high`.
    """
    from scipy.optimize import brentq

    def ratio(logarithm: float) -> float:
        return threshold_ratio(*pair(float(np.exp(logarithm))), person)

    octaves = int(np.ceil(np.log2(high / low) * (1 - 1e-12)))
    places = np.linspace(np.log(low), np.log(high), octaves + 1).tolist()
    first = next((at for at, place in enumerate(places) if ratio(place) <= 0), len(places))
    if first in {0, len(places)}:
        return 0.0 if first == 0 else math.inf
    return float(np.exp(brentq(ratio, places[first - 1], places[first], xtol=1e-3)))
