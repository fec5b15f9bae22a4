"""Gain of the force at a carrier, samples of a drive with the force that they cause, and envelopes that make it a target."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError, refuse
from electrovib.core.model import read_model
from electrovib.core.samples import Samples
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.current import CurrentAmplifier
from electrovib.physics.drive.sampled import Sampled
from electrovib.scenario import Scenario, TimeGrid
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.expanded import FORCE, Expanded
from electrovib.solve.stack.expand import behind_amplifier, phasors
from electrovib.studies.design.drive.target import Target
from electrovib.studies.design.limits import Bounds, refuse_exceeded, worst_of

_PROBES: Final = (1.0, 100.0)
"""Amplitudes of the drive at which the mean force is compared with the square of the amplitude [V or A]."""
_SAME: Final = 1e-9
"""Relative difference that counts as rounding [1]."""


@dataclass(frozen=True, kw_only=True)
class CarrierGain:
    """Force, currents and plate voltage of one sine in its steady state, per unit of the peak of the drive, over frequency.

    - `force`: time mean over the squared peak [N/V^2; N/A^2 for a current drive], >= 0.
    - `peaks`: peak of a quantity by the name of its limit; the voltage is that of the plate [1], for a current drive that across
      the stack [V/A], the current that of the amplifier into plate, declared stray capacitance and finger [A/V; 1].
    """

    frequency: Real
    force: Real
    peaks: Mapping[str, Real]

    def largest_amplitude(self, bounds: Bounds) -> Real:
        """Return the largest peak of the drive within the limits of `peaks`; infinite without one."""
        found = np.full(len(self.frequency), np.inf)
        for name, peak in self.peaks.items():
            if (limit := bounds.value(name)) is not None:
                with np.errstate(divide="ignore"):
                    found = np.minimum(found, limit / peak)
        return found


def carrier_gain(scenario: Scenario, frequency: ArrayLike) -> CarrierGain:
    """Return force, currents and plate voltage of one sine per unit of its amplitude, at each frequency.

    The mean force is F = g a^2 for the drive a sin(2 pi f t), without initial charges and without the limits
    of an amplifier; a force of another form is refused.
    """
    axis = np.atleast_1d(np.asarray(frequency, dtype=float))
    if axis.ndim != 1 or not np.all(np.isfinite(axis) & (axis > 0)):
        raise InputError("must be frequencies above 0 Hz", path="carrier")
    refuse_nonlinear(scenario)
    section = behind_amplifier(scenario, phasors(scenario, axis))
    first, later = (mean_force(scenario, section, amplitude=probe) / probe**2 for probe in _PROBES)
    if np.any(np.abs(later - first) > _SAME * np.abs(first)):
        contact, law = type(scenario.contact).__name__, type(scenario.force).__name__
        raise InputError(
            f"the force of {law} on {contact} is not proportional to the square of the drive"
            f" ({_PROBES[0]:g} and {_PROBES[1]:g} compared), so it has no gain; use contact.model = 'FixedArea' and a law of"
            " second degree"
        )
    amplifier, area = scenario.circuit.amplifier, scenario.contact_area
    body = np.abs(section.current_density * area)
    if scenario.drive.quantity == "current":
        peaks = {"voltage": np.abs(section.voltage), "current": body, "body_current": body}
        return CarrierGain(frequency=axis, force=first, peaks=peaks)
    output = np.ones(len(axis), complex)
    current = section.current_density * area
    if amplifier is not None:
        pole = 1.0 if amplifier.bandwidth is None else 1 + 1j * axis / amplifier.bandwidth
        output = output * (amplifier.gain / pole)
        current = current + 2j * math.pi * axis * amplifier.stray_capacitance * output
    slew = 2 * math.pi * axis * abs(scenario.circuit.supply.gain)
    peaks = {"voltage": np.abs(output), "current": np.abs(current), "body_current": body, "slew_rate": slew}
    return CarrierGain(frequency=axis, force=first, peaks=peaks)


def refuse_nonlinear(scenario: Scenario) -> None:
    """Refuse a scenario whose stack does not respond linearly to the drive."""
    leaky = [name for name, layer in scenario.stack.layers.items() if layer.leak is not None]
    problems = []
    if leaky:
        problems.append(
            f"stack.{leaky[0]}.leak: the conduction is not ohmic, so the force is not proportional to the square of the"
            " voltage; declare a conductivity in place of the leak"
        )
    if scenario.contact.closing is not None:
        problems.append(
            "contact: the gap follows load and attraction, so the force is not proportional to the square of the voltage;"
            " declare a fixed gap, for instance with contact.model = 'FixedArea'"
        )
    if scenario.motion.moved_gap is not None:
        problems.append(
            "motion.distance: the gap changes with time, so the gain of the force does too; omit motion.distance"
        )
    if scenario.motion.renews_film:
        problems.append(
            "motion: the sliding film leaves the contact with its charge, which the gain at one frequency does not contain;"
            " omit the renewal of the film"
        )
    refuse(problems)


SENSE: Final = 1e3
"""Command voltage over current of a designed current drive [ohm]."""
_SIMPSON: Final = np.array([1.0, 4.0, 1.0]) / 6


class Played:
    """A scenario under a drive of straight lines between evenly spaced samples, `rate` per second, from rest."""

    def __init__(self, scenario: Scenario, rate: float) -> None:
        self.base = scenario
        self.rate = rate
        self._last: Expanded | None = None

    def times(self, count: int) -> Real:
        """Return the times of a number of samples [s]."""
        return np.asarray(np.arange(count) / self.rate)

    def scenario(self, values: Real) -> Scenario:
        """Return the scenario with samples [V, or A of a current drive] as its drive."""
        return self.base.model_copy(update={"drive": self._drive(values), "time": TimeGrid()})

    def _drive(self, values: Real) -> Drive:
        current = self.base.drive.quantity == "current"
        volts = values * SENSE if current else values
        table = {"time_samples": Samples(self.times(len(values))), "voltage_samples": Samples(volts)}
        drive = read_model(Sampled, table)
        if not current:
            return drive
        return read_model(CurrentAmplifier, {"command": drive, "sense_resistance": SENSE})

    def expanded(self, values: Real) -> Expanded:
        """Return the scenario under these samples [V or A], prepared for evaluation at any times."""
        self._last = Expanded(self.scenario(values), before=self._last, mechanics=False)
        return self._last

    def halves(self, count: int) -> Real:
        """Return the times of a number of samples and the middles between them [s]."""
        return np.asarray(np.arange(2 * count - 1) / (2 * self.rate))

    def force(self, values: Real) -> Real:
        """Return the predicted force (2 n - 1,) at the n samples and in the middles between them."""
        record = self.expanded(values).at(self.halves(len(values)), wanted=FORCE)
        return np.asarray(record.solution.attraction)

    def means(self, force: Real, first: int, count: int, width: int) -> Real:
        """Return the mean of a result of `force` over successive groups of intervals, by Simpson's rule."""
        inside = force[2 * first : 2 * (first + count * width) + 1]
        intervals = _SIMPSON[0] * inside[:-2:2] + _SIMPSON[1] * inside[1:-1:2] + _SIMPSON[2] * inside[2::2]
        return np.asarray(np.mean(intervals.reshape(count, width), axis=1))


@dataclass(frozen=True, kw_only=True)
class FoundDrive:
    """Samples of a drive and the mean forces over successive intervals.

    - `times`, `values`: evenly spaced from 0, and samples [V, or A of a current drive].
    - `edges`, `wanted`, `predicted`: ends of the intervals, and mean force of the target and of the full
      model.
    - `scale`: largest multiple of the target within the limits without a compromise; infinite without limits.
    - `limited`: samples at which a limit prevents the target; `ratios`: largest value over each limit.
    - `searches`, `agreeing`: searches for the smallest misfit, 0 where none was needed, and those within 1 %
      of it.
    """

    times: Real
    values: Real
    rate: float
    edges: Real
    wanted: Real
    predicted: Real
    carrier: float | None
    scale: float
    limited: NDArray[np.bool_]
    ratios: dict[str, float] = field(default_factory=dict)
    searches: int = 0
    agreeing: int = 0


SAMPLES: Final = 64
"""Samples in a period of the carrier; a choice."""
FEWEST: Final = 8
"""Fewest samples in a period of the carrier."""
SLOWER: Final = 10.0
"""Carrier over the highest frequency of the target, at least, where the carrier is chosen."""
LOWEST: Final = 1e3
"""Lowest carrier that is chosen [Hz]; a choice, well above the vibrations that are felt best."""
_DECADES: Final = 2
_PER_DECADE: Final = 24
_ROUNDS: Final = 30
_CONVERGED: Final = 1e-6
"""Largest change of the correction of the envelope at which the iteration ends [1]."""
_SMALL: Final = 1e-6
"""Share of the largest wanted force below which the envelope is not corrected."""
_TRIALS: Final = 8
_USED: Final = 2e-4
"""Share of a limit that a drive which is bound by it may leave unused [1]."""
MOST_SAMPLES: Final = 2_000_000


def chosen_carrier(scenario: Scenario, target: Target, bounds: Bounds) -> float:
    """Return the carrier [Hz] that allows the largest force within the limits; of equal ones the lowest."""
    lowest = max(LOWEST, SLOWER * target.highest_frequency)
    candidates = lowest * 10.0 ** (np.arange(_DECADES * _PER_DECADE + 1) / _PER_DECADE)
    gain = carrier_gain(scenario, candidates)
    peak = gain.largest_amplitude(bounds)
    peak = np.minimum(peak, bounds.largest_drive)
    force = gain.force * np.where(np.isfinite(peak), peak, 1.0) ** 2
    return float(candidates[int(np.argmax(force > 0.999 * np.max(force)))])


def design_carrier(
    scenario: Scenario,
    target: Target,
    bounds: Bounds,
    *,
    carrier: float | None,
    rate: float | None,
    corrected: bool,
) -> FoundDrive:
    """Design a carrier whose envelope makes the force averaged over each of its periods the target.

    v = a(t) sin(2 pi f t), a = c(t) sqrt(F*(t)/g(f)) within plus and minus the largest amplitude, with the gain g of the mean
    force. If `corrected`, the correction c, one value for each period with straight lines between their middles, is multiplied
    by sqrt(F*/F) until it changes by less than 1e-6. A period whose envelope is at the largest amplitude is not raised. The
    `rate` is a whole multiple of the carrier, 64 in a period if None.
    """
    used = chosen_carrier(scenario, target, bounds) if carrier is None else carrier
    per_period, periods = _grid(target, used, rate)
    gain = carrier_gain(scenario, [used])
    played = Played(scenario, used * per_period)
    times, edges = played.times(periods * per_period + 1), np.arange(periods + 1) / used
    largest = float(gain.largest_amplitude(bounds)[0])
    largest = min(largest, saturated := bounds.largest_drive)
    root = target.root(times) / math.sqrt(float(gain.force[0]))
    wave = _Wave(times, edges, per_period, root, is_current=scenario.drive.quantity == "current")
    wanted = target.means(edges)
    for _ in range(_TRIALS):
        values, means = _corrected(played, wave, wanted, largest, rounds=_ROUNDS if corrected else 1)
        ratios = bounds.overload(played.scenario(values))
        worst = worst_of(ratios)
        reached = float(np.max(np.abs(values))) * (1 + _USED)
        bound = largest <= reached
        if worst <= 1 and (worst >= 1 - _USED or not bound or largest == saturated):
            break
        largest = min(min(largest, reached) * (1 - _USED / 2) / worst, saturated)
    refuse_exceeded(ratios, "envelope")
    if math.isfinite(saturated):
        ratios["voltage"] = max(ratios["voltage"], float(np.max(np.abs(values))) / saturated)
    return FoundDrive(
        times=times,
        rate=played.rate,
        values=values,
        edges=edges,
        wanted=wanted,
        predicted=means,
        carrier=used,
        scale=(largest / peak) ** 2 if (peak := float(np.max(np.abs(root)))) > 0 else math.inf,
        limited=np.abs(wave.envelope(np.ones(periods), np.inf)) > largest * (1 + 1e-6),
        ratios=ratios,
    )


@dataclass(frozen=True)
class _Wave:
    """A carrier and the envelope that gives the target at the gain of the carrier [V or A].

    Times of the samples and ends of the periods [s], samples in a period, envelope, and whether it is a current.
    """

    times: Real
    edges: Real
    per_period: int
    root: Real
    is_current: bool

    def envelope(self, correction: Real, largest: float) -> Real:
        """Return the envelope with a correction for each period, within a largest amplitude [V or A]."""
        factor = np.interp(self.times, (self.edges[1:] + self.edges[:-1]) / 2, correction)
        return np.clip(self.root * factor, -largest, largest)

    def values(self, envelope: Real) -> Real:
        """Return the samples of the carrier with an envelope [V or A]; of a current the charge begins and ends at 0."""
        phase = 2 * np.pi * (np.arange(len(envelope)) % self.per_period) / self.per_period
        if not self.is_current:
            return envelope * np.sin(phase)
        rise = np.gradient(envelope) * self.per_period / (2 * np.pi)
        return envelope * np.cos(phase) + rise * np.sin(phase)


def _corrected(
    played: Played, wave: _Wave, wanted: Real, largest: float, *, rounds: int
) -> tuple[Real, Real]:
    """Return samples and predicted means, after the envelope was corrected for a number of rounds."""
    correction = np.ones(len(wanted))
    width = wave.per_period
    known = wanted > _SMALL * np.max(wanted)
    for each in range(rounds):
        envelope = wave.envelope(correction, largest)
        values = wave.values(envelope)
        means = played.means(played.force(values), 0, len(wanted), width)
        if each == rounds - 1:
            break
        held = np.abs(envelope[:-1]).reshape(-1, width).min(axis=1) >= largest * (1 - _SMALL)
        factor = np.ones(len(wanted))
        factor[known] = np.clip(np.sqrt(wanted[known] / np.maximum(means[known], 1e-30)), 0.5, 2.0)
        factor = np.where(held, np.minimum(factor, 1.0), factor)
        correction = correction * factor
        if np.max(np.abs(factor - 1)) < _CONVERGED:
            break
    return values, means


def _grid(target: Target, carrier: float, rate: float | None) -> tuple[int, int]:
    """Return the samples in a period of the carrier, and the number of periods."""
    if not (math.isfinite(carrier) and carrier > 0):
        raise InputError("must be a frequency above 0 Hz", path="carrier", value=f"{carrier:g}")
    per_period = SAMPLES if rate is None else rate / carrier
    whole = round(per_period)
    if whole < FEWEST or abs(per_period - whole) > 1e-6 * whole:
        near = max(FEWEST, whole)
        why = (
            f"has to be a whole multiple, {FEWEST} or more, of the carrier of {carrier:g} Hz: {near * carrier:g} Hz,"
            f" or take the carrier {rate / near if rate else carrier:g} Hz"
        )
        raise InputError(why, path="rate", value=f"{rate:g}" if rate else "")
    periods = max(1, math.ceil(target.duration * carrier * (1 - 1e-9)))
    if periods * whole > MOST_SAMPLES:
        why = (
            f"{periods * whole} samples for {target.duration:g} s are more than {MOST_SAMPLES}; shorten the target, lower the"
            " carrier, or set a lower rate"
        )
        raise InputError(why, path="carrier", value=f"{carrier:g}")
    return whole, periods
