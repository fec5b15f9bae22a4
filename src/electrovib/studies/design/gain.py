"""Gain of the force at a carrier: mean force over the squared amplitude of one sine, over frequency."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.electrics.attraction import mean_force
from electrovib.solve.stack.expand import behind_amplifier, phasors

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real
    from electrovib.physics.limits import Limits
    from electrovib.scenario import Scenario

_PROBES: Final = (1.0, 100.0)
"""Amplitudes of the drive at which the mean force is compared with the square of the amplitude [V or A]."""
_SAME: Final = 1e-9
"""Relative difference that counts as rounding [1]."""


@dataclass(frozen=True, kw_only=True)
class CarrierGain:
    """Force, currents and plate voltage of one sine in its steady state, per unit of the peak of the drive, over frequency.

    - `force`: time mean over the squared peak [N/V^2; N/A^2 for a current drive], >= 0.
    - `voltage`: peak voltage of the plate [1]; for a current drive that across the stack [V/A].
    - `current`, `body_current`: peak current of the amplifier into plate, declared stray capacitance and
      finger, and that through the finger [A/V; 1].
    """

    frequency: Real
    force: Real
    voltage: Real
    current: Real
    body_current: Real

    def amplitude(self, force: ArrayLike) -> Real:
        """Return the peak of the drive that causes a mean force; infinite where the gain is 0."""
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.asarray(force, dtype=float) / self.force
            return np.where(np.asarray(force) == 0, 0.0, np.sqrt(ratio))

    def largest_amplitude(self, limits: Limits, *, slew: float | None = None) -> Real:
        """Return the largest peak of the drive within limits of voltage, currents and slope; infinite without one."""
        bounds = [np.full(len(self.frequency), np.inf)]
        for limit, gain in (
            (limits.voltage, self.voltage),
            (limits.current, self.current),
            (limits.body_current, self.body_current),
        ):
            if limit is not None:
                with np.errstate(divide="ignore"):
                    bounds.append(limit / gain)
        if slew is not None:
            bounds.append(slew / (2 * math.pi * self.frequency))
        return np.asarray(np.min(bounds, axis=0))

    def largest_force(self, limits: Limits, *, slew: float | None = None) -> Real:
        """Return the largest mean force of one sine within declared limits; infinite where none is declared."""
        return np.asarray(self.force * self.largest_amplitude(limits, slew=slew) ** 2)


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
        raise _not_of_second_degree(scenario)
    amplifier, area = scenario.circuit.amplifier, scenario.contact_area
    body = np.abs(section.current_density * area)
    if scenario.drive.quantity == "current":
        return CarrierGain(
            frequency=axis, force=first, voltage=np.abs(section.voltage), current=body, body_current=body
        )
    output = np.ones(len(axis), complex)
    current = section.current_density * area
    if amplifier is not None:
        pole = 1.0 if amplifier.bandwidth is None else 1 + 1j * axis / amplifier.bandwidth
        output = output * (amplifier.gain / pole)
        current = current + 2j * math.pi * axis * amplifier.stray_capacitance * output
    return CarrierGain(
        frequency=axis,
        force=first,
        voltage=np.abs(output),
        current=np.abs(current),
        body_current=body,
    )


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
    if problems:
        raise InputError(problems)


def _not_of_second_degree(scenario: Scenario) -> InputError:
    """Return the error for a force that is not proportional to the square of the drive."""
    contact, law = type(scenario.contact).__name__, type(scenario.force).__name__
    return InputError(
        f"the force of {law} on {contact} is not proportional to the square of the drive"
        f" ({_PROBES[0]:g} and {_PROBES[1]:g} compared), so it has no gain; use contact.model = 'FixedArea' and a law of"
        " second degree"
    )
